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

import hashlib
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

from pydantic import Field

from codesign.ground.errors import CodesignError, RunError, SpecError
from codesign.ground.figures import FIGURES, label
from codesign.ground.memo import Memo
from codesign.ground.records import Listener
from codesign.inputs import Platform, Workload, design_point
from codesign.planners.interface import Quality
from codesign.study.advice.candidates import Board, Candidate, chains_of
from codesign.study.advice.needs import Question, workload_tree
from codesign.study.identity import code_digest, platform_digest
from codesign.study.space import canonical
from codesign.study.store import Batch, Entry, EntryState, Store
from codesign.system import catalog
from codesign.system.bind import planner_code
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Result
from codesign.system.scenarios import simulate
from codesign.system.verdicts import fit_verdict
from codesign.system.verdicts.fits import ends_text

# The trial of a design: what it comes to on its board, kept by content.

WORST_TIME = FIGURES["plan_time_worst_s"]
"""The time that a rate is held against."""

MEAN_TIME = FIGURES["plan_time_mean_s"]
"""The time that the energy of a plan belongs to."""

ENERGY = FIGURES["energy_j"]


Need = Literal["rate", "power", "price", "arrive", "fit", "refused"]

_NEED_OF: dict[str, Need] = {"quality": "arrive"}
"""The needs of reasons that are no matter of the size of the design."""


class Shortfall(ResultModel):
    """The fault that keeps a design from sufficing: ``demand`` passes ``limit``."""

    need: Need = Field(
        description="the need that excludes it: the rate, the power, the price; starts that do not arrive; a resource,"
        " a bound or a clock of the part; or a combination that is refused"
    )
    name: str = Field(description="which of that kind, or why it is refused")
    demand: float | None = Field(default=None, description="what it comes to, in unit; None: not known")
    limit: float = Field(default=0.0, description="what it may be, in unit")
    unit: str = Field(default="", description="unit of the two; empty for counts")

    @property
    def is_unknown(self) -> bool:
        """True if nobody knows what it comes to, which is no matter of a refusal."""
        return self.demand is None and self.need != "refused"

    @property
    def ratio(self) -> float:
        """The demand over the limit; infinite if there is no limit to speak of."""
        if self.demand is None:
            return math.inf
        large, small = (self.limit, self.demand) if self.need == "arrive" else (self.demand, self.limit)
        return large / small if small else math.inf


class Use(ResultModel):
    """The resource of the part that a design uses most of."""

    resource: str = Field(description="the kind, such as slices")
    demand: int = Field(description="how many it takes")
    budget: int = Field(description="how many the part has")

    @property
    def share(self) -> float:
        """The share of the budget."""
        return self.demand / self.budget if self.budget else math.inf


class Trial(ResultModel):
    """The figures of a design, whatever is asked of it. Figures that only a run gives are None if it was not run."""

    clock_hz: int | None = Field(
        default=None, description="the clock that the fabric was lowered to, as the design is too slow for its own"
    )
    time_s: float | None = Field(default=None, description="time of a plan, the worst over the starts, s")
    time_low_s: float | None = Field(
        default=None, description="the same, the least value inside the intervals of all figures, s"
    )
    time_high_s: float | None = Field(
        default=None, description="the same, the greatest value inside the intervals of all figures, s"
    )
    surely_fits: bool = Field(
        default=False, description="whether it fits, its clock too, at every value inside the intervals"
    )
    may_fit: str = Field(
        default="", description="of a design that does not fit: the limit that it keeps at some values inside intervals"
    )
    mean_time_s: float | None = Field(default=None, description="the same, mean, s")
    energy_j: float | None = Field(default=None, description="energy of a plan, J")
    energy_low_j: float | None = Field(default=None, description="the same, the least value, J")
    energy_high_j: float | None = Field(default=None, description="the same, the greatest value, J")
    starts: int = Field(default=0, description="starts tried")
    arrived: int = Field(default=0, description="starts that arrived")
    fullest: Use | None = Field(default=None, description="the resource of the part that is used most")
    shortfalls: tuple[Shortfall, ...] = Field(default=(), description="why it cannot serve")


class Laboratory:
    """Tries the designs of a question. What they have in common is computed once.

    ``failures``: what went wrong in the code of planners. These designs count as refused, and are not kept.
    """

    def __init__(self, question: Question) -> None:
        self.question = question
        self.memo = Memo()
        self.failures: list[str] = []
        self._platforms: dict[str, str] = {}

    @cached_property
    def _asked(self) -> list[Any]:
        section = {key: value for key, value in self.question.section.items() if key != "map"}
        grid = self.question.grid
        return [self.question.problem.digest, grid.digest, grid.resolution, section, code_digest()]

    def key(self, candidate: Candidate) -> str:
        """The digest of all that the trial depends on: board, design, map, goals, starts, and the code."""
        board = candidate.board.platform
        if board.name not in self._platforms:
            self._platforms[board.name] = platform_digest(board)
        design = [candidate.planner.name, candidate.mapping, candidate.settings]
        identity = [*self._asked, self._platforms[board.name], *design]
        return hashlib.sha256(canonical(identity).encode()).hexdigest()

    def point(self, candidate: Candidate) -> tuple[Platform, Workload]:
        """Platform and workload of a design.

        Raises:
            SpecError: they do not belong together.
        """
        tree = workload_tree(candidate.planner.name, self.question.section, candidate.mapping)
        workload = catalog.load_workload(tree)
        if not candidate.settings:
            return candidate.board.platform, workload
        return design_point(candidate.board.platform, workload, candidate.settings)

    def result(self, candidate: Candidate, listeners: Sequence[Listener] = ()) -> Result:
        """The result of a design, simulated; ``listeners`` take the records of the run.

        Raises:
            CodesignError: the design is refused.
        """
        point = self.point(candidate)
        with planner_code(candidate.planner):
            return simulate(*point, listeners=listeners, memo=self.memo, grid=self.question.grid)

    def trial(self, candidate: Candidate) -> Trial:
        """The trial of a design. A clock that is all that it is too slow for is lowered to what it reaches."""
        try:
            result = self.result(candidate)
            if not result.feasible and all(reason.kind == "clock" for reason in result.reasons):
                slower = slowed(candidate, result)
                trial, clock = trial_of(self.result(slower)), clock_of(slower)
                assert result.clock is not None, "only a design with a clock is too slow for it"
                # No part of a time falls by more than the clock rises.
                fastest = min(result.clock.hz, result.clock.limit.interval[1])
                least = None if trial.time_low_s is None else trial.time_low_s * clock / fastest
                return trial.model_copy(update={"clock_hz": clock, "time_low_s": least})
        except SpecError as refused:
            return _refused(refused.faults[0].what)
        except RunError as failed:
            self.failures.append(f"{candidate.board.name}: {failed.what}")
            return _refused(failed.what)
        except CodesignError as refused:
            return _refused(refused.what)
        return trial_of(result)


def slowed(candidate: Candidate, result: Result) -> Candidate:
    """The design at the fastest clock that it reaches, in whole MHz where that is above 10 MHz."""
    assert result.clock is not None, "only a design with a clock is too slow for it"
    step = 1_000_000 if result.clock.limit.value >= 10_000_000 else 1_000
    return at_clock(candidate, int(result.clock.limit.value) // step * step)


def at_clock(candidate: Candidate, hz: int) -> Candidate:
    """The design at a clock of the fabric, Hz."""
    return replace(candidate, settings={f"{candidate.component}.clock": f"{hz // 1000} kHz"})


def clock_of(candidate: Candidate) -> int:
    """The clock that a design was lowered to, Hz."""
    return int(next(iter(candidate.settings.values())).split()[0]) * 1000


def trial_of(result: Result) -> Trial:
    """The trial of a result: its figures, whatever is asked of it."""
    uses = [Use(resource=use.resource, demand=use.demand, budget=use.budget) for use in result.resources]
    quality = result.quality
    starts, arrived = (quality.starts, quality.starts_arrived) if isinstance(quality, Quality) else (0, 0)
    shortfalls = [
        Shortfall(
            need=_NEED_OF.get(reason.kind, "fit"),
            name=label(reason.name),
            demand=float(reason.demand),
            limit=float(reason.limit),
            unit=reason.unit,
        )
        for reason in result.reasons
    ]
    if result.feasible and arrived < starts:
        shortfalls.append(Shortfall(need="arrive", name="starts", demand=arrived, limit=starts))
    fit, nothing = fit_verdict(result), (None, None)
    time, energy = result.interval(WORST_TIME) or nothing, result.interval(ENERGY) or nothing
    return Trial(
        time_s=result.figure(WORST_TIME),
        time_low_s=time[0],
        time_high_s=time[1],
        surely_fits=fit.fits == "yes",
        may_fit=ends_text(fit) if fit.fits == "uncertain" and not result.feasible else "",
        mean_time_s=result.figure(MEAN_TIME),
        energy_j=result.figure(ENERGY),
        energy_low_j=energy[0],
        energy_high_j=energy[1],
        starts=starts,
        arrived=arrived,
        fullest=max(uses, key=lambda use: use.share, default=None),
        shortfalls=tuple(shortfalls),
    )


def _refused(why: str) -> Trial:
    return Trial(shortfalls=(Shortfall(need="refused", name=why),))


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
