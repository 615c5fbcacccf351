"""The search: every design of every board is tried, or excluded with a reason, within a budget of computing time.

A style gives its designs in families (``Architecture.families``). A family is excluded

- where its least design is short of a resource or a bound of the part: so are all others of it;
- where a bound of its cycles, over the fastest clock that it reaches by its law, and the message with the map, which
  every design gets, take longer than a plan may take.

A family may hold all designs but a few, so a board that is far too slow is done in one step. Where it is excluded at
the figures' own values alone, and all else of the board at every value, its parts are looked at.

Of what is left each design is tried, least bits first, and parts of a family have sharper bounds. A chain ends at the
first design that suffices, and at the first that takes longer than a plan may take: the designs after it take at least
as long.

First, each arrangement of each board has a few of its most promising families looked at. Then the boards that cost less
than the cheapest one that suffices are searched to the end, the cheapest first. What the budget leaves is counted. A
board is not searched to the end either where the code of a planner fails on it.
"""

from __future__ import annotations

import math
import time
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import zip_longest
from typing import Any, Literal, TypeVar, get_args

from pydantic import Field

from codesign.ground.errors import RunError
from codesign.ground.figures import Figure
from codesign.ground.kernel_cache import compiling_timed
from codesign.planners.styles import Family
from codesign.study.advice.candidates import SIMPLE, Arrangement, Board, Candidate, Circuit, arrangements_of, at_clock
from codesign.study.advice.certainty import excluded, shortfalls_of
from codesign.study.advice.needs import Needs
from codesign.study.advice.trials import Laboratory, Shortfall, Trial
from codesign.study.store import Batch, Entry, EntryState, Store
from codesign.system.bind import planner_code
from codesign.system.results.model import ResultModel

T = TypeVar("T")

BUDGET_S = 45.0
"""Seconds of computing that a search may take by default. A design that was begun is completed."""

FEW = 3
"""Families of an arrangement that are looked at on every board, whatever it costs."""

MARGIN = 1.1
"""Cycles are counted beyond those that a plan may take by this, so that a question about a slower rate finds them."""

_GROUP = 64
"""Trials that the cache is given at once."""

Progress = Callable[[int, int], None]
"""Takes how many boards are done, and of how many."""

Tried = tuple[Candidate, Trial]

State = Literal["unfit", "bound", "counted", "tried", "left"]


COUNTS: tuple[State, ...] = get_args(State)


class Settled(ResultModel):
    """A family of designs and what became of it: a line of the certificate.

    ``unfit``: its least design takes more of a resource than there is. ``bound``, ``counted``: its cycles, by a bound
    or by a computation of the visits, take longer than a plan may take. ``tried``: its designs were simulated.
    ``left``: the budget did not reach it.
    """

    state: State = Field(description="unfit, bound, counted, tried or left")
    planner: str = Field(description="name of the planner")
    style: str = Field(description="architecture style of the planning task")
    component: str = Field(description="the component that plans")
    apart: dict[str, str] = Field(description="the tasks that other components do")
    memory: str | None = Field(description="the external memory of the planning task")
    least: dict[str, Any] = Field(description="parameters of its least design")
    ranges: dict[str, tuple[int, int]] = Field(description="the designs: least and greatest value, by name")
    designs: int = Field(description="designs of it, those of its parts left out")
    resource: str = Field(default="", description="of an unfit one: what it is short of")
    demand: float | None = Field(default=None, description="of an unfit one: how much its least design takes of that")
    budget: float | None = Field(default=None, description="of an unfit one: how much there is of that")
    units: dict[str, int] = Field(
        default={},
        description="no design of it takes fewer: cycles of an FPGA under the empty name, or units by kernel",
    )
    unit_s: dict[str, float] = Field(default={}, description="the least time of each of these units, s")
    map_s: float = Field(default=0.0, description="time of the message with the map, without waits, s")
    clock_hz: float | None = Field(default=None, description="no design of it has a faster clock, Hz, by its law")
    time_s: float | None = Field(default=None, description="no design of it takes less time, messages included, s")
    least_s: float | None = Field(
        default=None, description="no design of it takes less time at any value inside the intervals, s"
    )
    sure: bool = Field(default=False, description="whether it is excluded at every value inside the intervals")

    def at(self, period_s: float) -> Settled | None:
        """The same at another period; None where it may not be excluded there, or no longer at every value."""
        if self.time_s is None or self.least_s is None:
            return self if self.state == "unfit" else None
        sure = self.least_s > period_s
        return self.model_copy(update={"sure": sure}) if self.time_s > period_s and sure >= self.sure else None


class Extent(ResultModel):
    """The designs of a board, by what became of them."""

    designs: int = Field(description="designs of the families that were met")
    unfit: int = Field(description="excluded, as the least design of their family does not fit")
    bound: int = Field(description="excluded by a lower bound of their cycles")
    counted: int = Field(description="excluded by a computation of their cycles")
    tried: int = Field(description="simulated, or after one in a chain that was")
    left: int = Field(description="not looked at, as the budget was spent, or a dearer board was not asked further")
    complete: bool = Field(description="whether none is left")


@dataclass
class Findings:
    """The findings of a search.

    ``tried``: the designs of each board by its name. ``settled``: its families. ``ended``: the boards with no family
    left. ``excluded``: the boards that no design helps, by the need, and whether that is sure. ``simulated``,
    ``kept``: the number of trials that were computed, and of those that came from the cache.
    """

    tried: dict[str, list[Tried]]
    settled: dict[str, list[Settled]]
    ended: set[str] = field(default_factory=set)
    excluded: dict[str, tuple[Shortfall, bool]] = field(default_factory=dict)
    simulated: int = 0
    kept: int = 0

    def surely(self, board: str) -> bool:
        """True if each family of a board that was excluded is so at every value inside the intervals."""
        if board in self.excluded:
            return self.excluded[board][1]
        return all(each.sure or each.state == "tried" for each in self.settled[board])

    def extent(self, board: str) -> Extent:
        """The designs of a board by what became of them."""
        counts = dict.fromkeys(COUNTS, 0)
        for each in self.settled[board]:
            counts[each.state] += each.designs
        return Extent(designs=sum(counts.values()), complete=board in self.ended, **counts)


def search(
    laboratory: Laboratory,
    boards: Sequence[Board],
    store: Store,
    *,
    budget_s: float = BUDGET_S,
    progress: Progress = lambda _done, _total: None,
) -> Findings:
    """Search the designs of all boards.

    ``budget_s``: seconds of this process that may be spent before a further design is begun. Kernels are compiled once,
    which does not count.
    """
    end = time.process_time() + budget_s
    with compiling_timed() as compiled_s:
        return _Search(laboratory, boards, store, lambda: time.process_time() - compiled_s() > end, progress).findings()


Path = tuple[int, ...]
"""The place of a family: its number among all of the style, then among the parts of that one, and so on."""


class Kept(ResultModel):
    """A family of an arrangement, for a question about another rate."""

    path: Path = Field(description="its place")
    settled: Settled = Field(description="what became of it")
    designs: tuple[dict[str, Any], ...] = Field(default=(), description="its designs that were tried, in their order")
    bound: dict[str, int] = Field(default={}, description="of a tried one: units that no design of it undercuts")
    counted: dict[str, int] = Field(default={}, description="the same, by a count")

    @property
    def tried(self) -> Family:
        """Its designs that were tried, as a family of their own: the parts of the whole stand for themselves."""
        own = self.settled
        return Family(self.designs, self.bound, own.ranges, own.designs, own.least, lambda _most: self.counted)

    @property
    def left(self) -> Settled:
        """The same as a line of an answer that does not look at it."""
        numbers = {"state", "resource", "demand", "budget", "units", "unit_s", "map_s", "clock_hz"}
        return Settled(state="left", **self.settled.model_dump(exclude={*numbers, "time_s", "least_s", "sure"}))


class Looked(ResultModel):
    """All families of an arrangement that were met, those that were left too."""

    families: tuple[Kept, ...] = Field(description="each with its place")
    nearest: dict[str, Any] | None = Field(description="the most promising design whose cycles were counted")


@dataclass(eq=False)
class _Open:
    """An arrangement with the families that are still to be looked at: of the last iterator first.

    ``record``: what became of each family that was met, by its place; ``again``: those of an earlier question that are
    to be looked at after all; ``few``: how many families are looked at whatever the board costs.
    """

    arrangement: Arrangement
    known: tuple[float, float] | None = None
    nearest: dict[str, Any] | None = None
    few: int = FEW
    record: dict[Path, Kept] = field(default_factory=dict)
    again: deque[Kept] = field(default_factory=deque)
    changed: bool = False
    counted: dict[Path, dict[str, int]] = field(default_factory=dict)
    families: list[Iterator[tuple[Path, Family]]] = field(init=False)
    paths: dict[int, Path] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.families = [self._numbered((), self.arrangement.families())]

    @staticmethod
    def _numbered(path: Path, families: Iterator[Family]) -> Iterator[tuple[Path, Family]]:
        for index, family in enumerate(families):
            yield (*path, index), family

    def resume(self, looked: Looked, period_s: float) -> Iterator[Settled]:
        """What an earlier search settled that holds at this period too. All other families are left to be looked at."""
        self.record = {each.path: each for each in looked.families}
        self.nearest, self.families = looked.nearest, []
        first = [each.settled for each in looked.families[:FEW]]
        if any(each.state != "left" for each in first):
            self.few = sum(each.state != "left" and each.at(period_s) is None for each in first)
        for each in looked.families:
            settled = each.settled.at(period_s)
            if settled is None:
                self.again.append(each)
            else:
                yield settled

    @property
    def messages(self) -> tuple[float, float]:
        """The time of the message with the map, s: its value and the least; 0 before a design was tried."""
        return self.known or (0.0, 0.0)

    def push(self, family: Family) -> None:
        """The parts of a family, if it has some, come before the families that are left."""
        if family.parts is not None:
            self.families.append(self._numbered(self.paths[id(family)], self.arrangement.parts(family)))

    def next(self, laboratory: Laboratory) -> Family | None:
        """The next family; None where none is left, or the code of the planner fails, which is noted."""
        while self.families:
            last: tuple[Path, Family | None] = (), None
            path, family = self._asked(partial(next, self.families[-1], last), laboratory, last)
            if family is not None:
                self.paths[id(family)] = path
                return family
            self.families.pop()
        while self.again:
            kept = self.again.popleft()
            made = kept.tried if kept.designs else self._made(kept.path, laboratory)
            if made is not None:
                return self._placed(kept.path, made)
        return None

    def was_tried(self, family: Family) -> bool:
        """True of a family whose designs an earlier question tried."""
        kept = self.record.get(self.paths[id(family)])
        return kept is not None and bool(kept.designs)

    def whole(self, family: Family, level: int, laboratory: Laboratory) -> Family:
        """A family with the designs after that of a level, of which an earlier question may have tried none."""
        path = self.paths[id(family)]
        made = self._made(path, laboratory) if self.was_tried(family) and level + 1 == len(family.chain) else None
        return family if made is None else self._placed(path, replace(made, parts=None, count=family.count))

    def _placed(self, path: Path, family: Family) -> Family:
        self.paths[id(family)] = path
        return family

    def _made(self, path: Path, laboratory: Laboratory) -> Family | None:
        return self._asked(lambda: self.arrangement.at(path), laboratory, None)

    def _asked(self, ask: Callable[[], T], laboratory: Laboratory, none: T) -> T:
        """The answer of a planner's code; ``none`` where it fails, which is noted."""
        try:
            with planner_code(self.arrangement.planner):
                return ask()
        except RunError as failed:
            laboratory.fail(self.arrangement.board.name, failed)
            return none

    def sharper(self, family: Family, most: int, laboratory: Laboratory) -> Mapping[str, int] | None:
        """The sharper bound of a family; None where it has none, or the code of the planner fails, which is noted."""
        sharper = family.sharper
        return None if sharper is None else self._asked(lambda: sharper(most), laboratory, None)


class _Search:
    """See ``search``. ``over``: whether the budget is spent."""

    def __init__(
        self,
        laboratory: Laboratory,
        boards: Sequence[Board],
        store: Store,
        over: Callable[[], bool],
        progress: Progress,
    ) -> None:
        self.laboratory, self.boards, self.over, self.progress = laboratory, boards, over, progress
        self.needs = laboratory.question.needs
        self.found = Findings({board.name: [] for board in boards}, {board.name: [] for board in boards})
        self.waiting = _Waiting(store)
        self.starts = len(laboratory.question.problem.starts)
        self.is_spent = False
        self.sufficing: dict[str, float | None] = {}

    def findings(self) -> Findings:
        """Look at a few families everywhere, then search the cheaper boards to the end."""
        problem = self.laboratory.question.problem
        circuits: dict[Any, Circuit] = {}
        out = {board.name: excluded(board, self.needs) for board in self.boards}
        self.found.excluded = {name: why for name, why in out.items() if why is not None}
        opened = {
            board.name: [self._open(each) for each in arrangements_of(board, problem, self.needs, circuits)]
            for board in self.boards
        }
        # The boards take turns, so that a small budget reaches each of them; the simplest arrangement is first.
        self.progress(0, len(self.boards))
        for turns in zip_longest(*(self._few(opened[board.name]) for board in self.boards)):
            self._settle([each for each in turns if each is not None])
        boards = sorted(self.boards, key=lambda each: (each.price_usd is None, each.price_usd or 0.0))
        for done, board in enumerate(boards):
            self.progress(done, len(boards))
            for each in opened[board.name]:
                # A board is shown by what it can: by designs that its cycles left out too.
                if each.nearest is not None and not self._is_settled(board):
                    self._trial(each, each.arrangement.candidate(each.nearest), self.laboratory.farthest)
            for each in opened[board.name]:
                self._drain(each, board)
            left = [each for each in opened[board.name] if self._leave(each)]
            whole = board.name not in self.laboratory.failed | self.found.excluded.keys()
            for each in opened[board.name]:
                if each.changed and whole:
                    looked = Looked(families=tuple(each.record.values()), nearest=each.nearest)
                    self.waiting.keep_looked(self.laboratory.key_of(each.arrangement), looked)
            if board.name in self.found.excluded or not (left or board.name in self.laboratory.failed):
                self.found.ended.add(board.name)
            self._fill(board)
        self.waiting.write()
        return self.found

    def _open(self, each: Arrangement) -> _Open:
        """An arrangement to be looked at, or what an earlier question found that holds for this one as well."""
        opened = _Open(each)
        looked = self.waiting.looked(self.laboratory.key_of(each))
        if looked is not None:
            self.found.settled[each.board.name] += opened.resume(looked, self.needs.period_s)
        return opened

    def _few(self, opened: list[_Open]) -> Iterator[tuple[_Open, Family]]:
        """A few families of each arrangement of a board, software first."""
        for each in sorted(opened, key=lambda each: SIMPLE.index(each.arrangement.placement)):
            for _ in range(each.few):
                if self._suffices(each.arrangement.board):
                    return
                family = each.next(self.laboratory)
                if family is None:
                    break
                yield each, family

    def _fill(self, board: Board) -> None:
        """Try the best design of a board from all starts, until the best is one that was."""
        tried = self.found.tried[board.name]
        while tried:
            best = min(tried, key=lambda each: order(each, board, self.needs))
            candidate, trial = best
            if trial.time_s is None or trial.starts == self.starts:
                return
            tried.remove(best)
            self._tried(*self._known(candidate, self.laboratory))

    @property
    def _spent(self) -> bool:
        self.is_spent = self.is_spent or self.over()
        return self.is_spent

    def _suffices(self, board: Board) -> bool:
        return board.name in self.sufficing

    def _is_settled(self, board: Board) -> bool:
        """True if nothing more about a board can change which is the cheapest that suffices."""
        prices = [price for price in self.sufficing.values() if price is not None]
        dearer = bool(prices) and (board.price_usd is None or board.price_usd >= min(prices))
        return dearer or self._suffices(board) or board.name in self.found.excluded

    def _tried(self, candidate: Candidate, trial: Trial) -> None:
        """Keep a trial, and its board where it suffices."""
        board = candidate.board
        self.found.tried[board.name].append((candidate, trial))
        if trial.starts == self.starts and not shortfalls_of(trial, board, self.needs):
            self.sufficing[board.name] = board.price_usd

    def _drain(self, opened: _Open, board: Board) -> None:
        """Look at all families of an arrangement, until one suffices or the budget is spent."""
        while not self._spent and not self._is_settled(board):
            family = opened.next(self.laboratory)
            if family is None:
                return
            self._settle([(opened, family)])

    def _leave(self, opened: _Open) -> bool:
        """Count the families that are left; true if there are some. A board that no design helps is not asked."""
        board = opened.arrangement.board.name
        if board in self.found.excluded:
            return False
        some = bool(opened.again)
        self.found.settled[board] += (each.left for each in opened.again)
        opened.again.clear()
        while (family := opened.next(self.laboratory)) is not None:
            some = True
            self._note(opened, family, "left")
        return some

    def _note(
        self, opened: _Open, family: Family, state: State, *, tried: Iterable[Mapping[str, Any]] = (), **more: Any
    ) -> None:
        each, path = opened.arrangement, opened.paths[id(family)]
        settled = Settled(
            state=state,
            planner=each.planner.name,
            style=each.style.style,
            component=each.component,
            apart=dict(each.placed.apart),
            memory=each.placed.memory,
            least=dict(family.lowest),
            ranges=dict(family.ranges),
            designs=len(family.chain) if state == "tried" and family.parts is not None else family.count,
            **more,
        )
        # What an earlier question settled is of more use than that this one left it.
        if state != "left" or path not in opened.record:
            kept = Kept(path=path, settled=settled, designs=tuple(map(dict, tried)))
            if kept.designs:
                kept = kept.model_copy(update={"bound": dict(family.units), "counted": opened.counted.get(path, {})})
            opened.record[path] = kept
            opened.changed = True
        self.found.settled[each.board.name].append(settled)

    def _settle(self, families: Sequence[tuple[_Open, Family]]) -> None:
        """Exclude each family, or try its chain and put its parts in the place of the whole."""
        chains = []
        for opened, family in families:
            if self._spent:
                self._note(opened, family, "left")
            elif not self._excluded(opened, family):
                if family.chain:
                    chains.append((opened, family))
                else:
                    opened.push(family)
        self._try(chains)

    def _excluded(self, opened: _Open, family: Family) -> bool:
        """True if no design of a family suffices by its least demand, or by a bound of its time."""
        each, least = opened.arrangement, family.lowest
        above = each.clock_of_whole(family)
        if above is not None and self._too_slow(opened, family, above, "bound", family.units):
            return True
        held = None if family.clock_alone or opened.was_tried(family) else each.held(least)
        short = [] if held is None else [reason for reason in held.reasons if reason.kind == "resource"]
        if held is not None and short:
            worst = max(short, key=lambda reason: reason.demand / max(reason.limit, 1e-12))
            use = next(use for use in held.resources if use.resource == worst.name)
            sure = sum(item.figure.interval[0] for item in use.items) > worst.limit
            numbers: dict[str, Any] = {"demand": float(worst.demand), "budget": float(worst.limit)}
            self._note(opened, family, "unfit", sure=sure, resource=worst.name, **numbers)
            return True
        limit = each.clock_limit(least)
        if limit is None and each.placement != "host":
            return False
        if self._too_slow(opened, family, limit, "bound", family.units):
            return True
        most = 0 if limit is None else math.floor(MARGIN * self._left_s(opened) * limit.value)
        counted = opened.sharper(family, most, self.laboratory)
        if counted is None:
            return False
        opened.counted[opened.paths[id(family)]] = dict(counted)
        return self._too_slow(opened, family, limit, "counted", counted)

    def _left_s(self, opened: _Open) -> float:
        """The time that the map leaves of the one that a plan may take, s."""
        return self.needs.period_s - opened.messages[0]

    def _too_slow(
        self, opened: _Open, family: Family, limit: Figure | None, state: State, units: Mapping[str, int]
    ) -> bool:
        """True, and noted, if no design of a family takes less than these units, and they take too long.

        ``limit``: the clock that none of them exceeds by its law, Hz; None on a processor.
        """
        each, (messages, least_messages) = opened.arrangement, opened.messages
        time, least_time = each.time_of(units, limit)
        if time <= self._left_s(opened):
            return False
        least_s = least_time + least_messages
        sure = least_s > self.needs.period_s
        if not sure and not family.chain and self.found.surely(each.board.name):
            # Its parts may be out at every value, as all others of the board are so far.
            return False
        rates = {unit: each.time_of({unit: 1}, limit)[0] for unit in units}
        known = {unit: amount for unit, amount in units.items() if rates[unit]}
        clock = None if limit is None else limit.value
        numbers: dict[str, Any] = {"unit_s": rates, "map_s": messages, "time_s": time + messages, "least_s": least_s}
        # A count is given up at the limit, so of those the most promising, which comes first, is the nearest.
        if state == "counted" and family.chain and opened.nearest is None:
            opened.nearest = dict(family.chain[0])
        self._note(opened, family, state, sure=sure, units=known, clock_hz=clock, **numbers)
        return True

    def _try(self, chains: Sequence[tuple[_Open, Family]]) -> None:
        """Try chains level by level, designs of few bits first."""
        level = 0
        open_chains = list(chains)
        while open_chains:
            designs = [(*each, each[0].arrangement.candidate(each[1].chain[level])) for each in open_chains]
            designs.sort(key=lambda each: each[2].bits)
            open_chains = []
            for opened, family, candidate in designs:
                trial = self._trial(opened, candidate, self.laboratory.farthest)
                if trial is not None and not self._is_slow(trial) and self.laboratory.farthest is not self.laboratory:
                    trial = self._trial(opened, candidate, self.laboratory)
                goes_on = trial is not None and self._goes_on(trial, candidate.board)
                rest = opened.whole(family, level, self.laboratory) if goes_on else family
                if trial is None:
                    self._note(opened, family, "left")
                elif goes_on and level + 1 < len(rest.chain):
                    open_chains.append((opened, rest))
                else:
                    self._note(opened, rest, "tried", tried=rest.chain[: level + 1])
                    opened.push(rest)
            level += 1

    def _trial(self, opened: _Open, candidate: Candidate, laboratory: Laboratory) -> Trial | None:
        """The trial of a design, kept or computed; None where the budget is spent."""
        if self._spent and self.waiting.trial(laboratory.key(candidate)) is None:
            return None
        candidate, trial = self._known(candidate, laboratory)
        if trial.messages_s is not None:
            (value, least), (other, least_other) = opened.known or trial.messages_s, trial.messages_s
            opened.known = min(value, other), min(least, least_other)
        self._tried(candidate, trial)
        return trial

    def _known(self, candidate: Candidate, laboratory: Laboratory) -> Tried:
        """A design at the clock of its trial, which is kept or computed."""
        key = laboratory.key(candidate)
        trial = self.waiting.trial(key)
        if trial is not None:
            self.found.kept += 1
            return candidate if trial.clock_hz is None else at_clock(candidate, trial.clock_hz), trial
        failed = len(laboratory.failures)
        candidate, trial = laboratory.trial(candidate)
        self.found.simulated += 1
        if len(laboratory.failures) == failed:
            self.waiting.keep(key, trial)
        return candidate, trial

    def _is_slow(self, trial: Trial) -> bool:
        """True if a design cannot serve, or is too slow: from the farthest start alone is enough to know."""
        return trial.time_s is None or trial.time_s > self.needs.period_s

    def _goes_on(self, trial: Trial, board: Board) -> bool:
        """True if the next design of a chain may suffice where this does not: it is as long, and as large."""
        short = {shortfall.need for shortfall in shortfalls_of(trial, board, self.needs)}
        return bool(short) and not short & {"rate", "fit", "price"}


def order(tried: Tried, board: Board, needs: Needs) -> tuple[int, float, float]:
    """The best design first: it suffices and is simple; else it runs and serves, and is nearest to the needs."""
    candidate, trial = tried
    short = shortfalls_of(trial, board, needs)
    time = math.inf if trial.time_s is None else trial.time_s
    # What nobody knows is the same of every design.
    worst = max((shortfall.ratio for shortfall in short if not shortfall.is_unknown), default=0.0)
    kinds = {shortfall.need for shortfall in short}
    if not short:
        return 0, SIMPLE.index(candidate.placement), time
    stages = ("refused", "fit", "arrive")
    return 4 - next((index for index, kind in enumerate(stages) if kind in kinds), 3), worst, time


class _Waiting:
    """The cache, written in groups."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._entries: dict[str, Entry] = {}
        self._blocks: dict[str, bytes] = {}

    def looked(self, key: str) -> Looked | None:
        """What is kept of an arrangement; None where nothing is, or a cache of another version."""
        for _, block in self._store.blocks([key]):
            with suppress(ValueError, zlib.error):
                return Looked.model_validate_json(zlib.decompress(block))
        return None

    def keep_looked(self, key: str, looked: Looked) -> None:
        self._blocks[key] = zlib.compress(looked.model_dump_json(exclude_defaults=True).encode())

    def trial(self, key: str) -> Trial | None:
        entry = self._entries.get(key) or self._store.find([key]).get(key)
        return None if entry is None else Trial.model_validate_json(entry.text)

    def keep(self, key: str, trial: Trial) -> None:
        self._entries[key] = Entry(key, EntryState.DONE, trial.model_dump_json())
        if len(self._entries) >= _GROUP:
            self.write()

    def write(self) -> None:
        self._store.put(Batch(tuple(self._entries.values()), self._blocks))
        self._entries, self._blocks = {}, {}
