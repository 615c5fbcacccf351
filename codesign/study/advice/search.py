"""The search: every chain of every board, level by level, cheap designs first, within a budget of computing time.

The functional work of a design depends on planner, parameters and map, not on the board: it is computed once
(``Memo``), and each board prices it in a few milliseconds. Three bounds keep the search short, and none changes the
answer.

- A design that does not fit is not run.
- A chain ends at the first design that serves, and at the first that takes longer than a plan may take: the designs
  after it take at least as long.
- Designs with fewer bits come first, on all boards. Where the budget is spent, what is left is reported.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from codesign.study.advice.boards import Board
from codesign.study.advice.candidates import Candidate, chains_of
from codesign.study.advice.needs import Question
from codesign.study.advice.trials import Laboratory, Trial, at_clock
from codesign.study.store import Batch, Entry, EntryState, Store

BUDGET_S = 45.0
"""Seconds of computing that a search may take by default. A design that was begun is completed."""

_GROUP = 64
"""Trials that the cache is given at once."""

Progress = Callable[[int, int], None]
"""Takes how many chains are done, and of how many."""

Tried = tuple[Candidate, Trial]


@dataclass
class Findings:
    """The findings of a search.

    ``tried``: the designs of each board by its name. ``left``: the first design of each chain that the budget did not
    reach. ``simulated``, ``kept``: the number of trials that were computed, and of those that came from the cache.
    """

    tried: dict[str, list[Tried]]
    left: list[Candidate] = field(default_factory=list)
    simulated: int = 0
    kept: int = 0


def search(
    laboratory: Laboratory,
    boards: Sequence[Board],
    store: Store,
    *,
    budget_s: float = BUDGET_S,
    progress: Progress = lambda _done, _total: None,
) -> Findings:
    """Try the designs of all boards.

    ``budget_s``: seconds of this process that may be spent before a further design is begun.
    """
    question = laboratory.question
    findings = Findings({board.name: [] for board in boards})
    numbered = [(rank, chain) for board in boards for rank, chain in enumerate(chains_of(board, question.problem))]
    # Round the boards, so that a small budget reaches each of them.
    chains = [chain for _, chain in sorted(numbered, key=lambda each: each[0])]
    waiting = _Waiting(store)
    begun, level, total = time.process_time(), 0, len(chains)
    while chains:
        chains.sort(key=lambda chain: chain[level].bits)
        further = []
        for index, chain in enumerate(chains, 1):
            candidate = chain[level]
            trial = waiting.trial(laboratory.key(candidate))
            if trial is not None:
                findings.kept += 1
            elif time.process_time() - begun > budget_s:
                findings.left.append(candidate)
                continue
            else:
                failed = len(laboratory.failures)
                trial = laboratory.trial(candidate)
                findings.simulated += 1
                if len(laboratory.failures) == failed:
                    waiting.keep(laboratory.key(candidate), trial)
            tried = candidate if trial.clock_hz is None else at_clock(candidate, trial.clock_hz)
            findings.tried[candidate.board.name].append((tried, trial))
            if level + 1 < len(chain) and _goes_on(trial, question):
                further.append(chain)
            progress(total - len(further) - len(chains) + index, total)
        chains, level = further, level + 1
    waiting.write()
    return findings


def _goes_on(trial: Trial, question: Question) -> bool:
    """True if the next design of a chain may suffice where this one does not."""
    if trial.time_s is not None and trial.time_s > question.needs.period_s:
        return False
    return bool(trial.shortfalls) and all(shortfall.need == "arrive" for shortfall in trial.shortfalls)


class _Waiting:
    """The cache, written in groups."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._entries: dict[str, Entry] = {}

    def trial(self, key: str) -> Trial | None:
        entry = self._entries.get(key) or self._store.find([key]).get(key)
        return None if entry is None else Trial.model_validate_json(entry.text)

    def keep(self, key: str, trial: Trial) -> None:
        self._entries[key] = Entry(key, EntryState.DONE, trial.model_dump_json())
        if len(self._entries) >= _GROUP:
            self.write()

    def write(self) -> None:
        self._store.put(Batch(tuple(self._entries.values())))
        self._entries = {}
