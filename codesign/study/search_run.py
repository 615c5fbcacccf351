"""Every search by its name, and what runs them round by round: what they ask for is evaluated once, and told them."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.inputs import exploration as limits
from codesign.inputs.exploration import POPULATION, Exploration, Searching
from codesign.study.blocks import Plan
from codesign.study.bounds import Bounds
from codesign.study.budget import Budget
from codesign.study.conditions import Conditions
from codesign.study.constraints import Floats, bound_names
from codesign.study.definition import MAX_STUDY_POINTS
from codesign.study.evaluation import Done
from codesign.study.explored import Explored
from codesign.study.judged import Judged
from codesign.study.kept import Kept
from codesign.study.outcomes import Outcomes, State
from codesign.study.partition import Work, parted
from codesign.study.search import Problem, RandomSearch, Search, Searched, Trace
from codesign.study.search_bound import BoundSearch
from codesign.study.search_optuna import nsga2, tpe
from codesign.study.space import Space, points_of
from codesign.study.tally import Tally
from codesign.system.results.result import Reason, Result

SEARCHES: Mapping[str, Callable[[Problem, Searching], Search]] = {
    "nsga2": nsga2,
    "tpe": tpe,
    "random": lambda problem, searching: RandomSearch(problem, searching.seed),
    "bound": lambda problem, _searching: BoundSearch(problem),
}
"""Every search by its name (``Searching.sampler``): what makes one for a problem and options."""


def search_of(searching: Searching, problem: Problem) -> Search:
    """The search that is asked for.

    Raises:
        InputError: it needs a package that is not installed; or nothing to search.
    """
    if len(problem.decisions) < 2:
        what = "there is nothing to search: the workload has one design"
        raise InputError(what, "search", "give an axis a second value")
    return SEARCHES[searching.sampler](problem, searching)


CUT_OFF = "cut off"
"""The end of a search that was interrupted."""

_GROWN = 1.25
_COMPARABLE, _FIT, _SHARE = "comparable", "fit", "share"

Indices = NDArray[np.int64]


class Rounds(Tally):
    """The outcomes of those points that were asked for, round by round.

    ``chosen``: the designs, in the order in which they were asked for, where the space is too large to hold.
    """

    def _begun(self) -> Outcomes:
        self._held: list[tuple[Indices, Outcomes]] = []
        self._place: dict[int, tuple[int, int]] = {}
        return Outcomes.empty(0)

    def left_s(self) -> float | None:
        """Seconds to go, by the mean of the points so far; None without a number of them."""
        if not self._computed or not self.total:
            return None
        return (time.monotonic() - self._started) / self.done * max(0, self.total - self.done)

    def begin(self, points: Indices) -> None:
        """A round of points, none of which was in a round before."""
        number = len(self._held)
        self._held.append((points, Outcomes.empty(len(points))))
        self._place |= {point: (number, row) for row, point in enumerate(points.tolist())}

    def _join(self, indices: Indices, batch: Outcomes) -> None:
        places = [self._place[point] for point in indices.tolist()]
        rows = np.array([row for _, row in places], np.intp)
        numbers = np.array([number for number, _ in places])
        for number in np.unique(numbers):
            own = np.flatnonzero(numbers == number)
            self._held[number][1].join(rows[own], batch if len(own) == len(rows) else batch.chosen(own))

    def of(self, points: Sequence[int]) -> Outcomes:
        """The outcomes of points of one round or of several."""
        outcomes = Outcomes.empty(len(points))
        places = [self._place[point] for point in points]
        for number in sorted({number for number, _ in places}):
            own = [row for row, (of_round, _) in enumerate(places) if of_round == number]
            rows = np.array([places[row][1] for row in own], np.intp)
            outcomes.join(np.array(own, np.intp), self._held[number][1].chosen(rows))
        return outcomes

    def is_done(self, point: int) -> bool:
        """True if a point was computed, and did not fail."""
        number, row = self._place.get(point, (-1, -1))
        return number >= 0 and self._held[number][1].state[row] == State.DONE

    def gather(self, designs: Sequence[int], conditions: int) -> None:
        """Put the rounds together: all points of the space if a study may hold them, else the points of the designs."""
        if len(self.space) <= MAX_STUDY_POINTS:
            self.outcomes = Outcomes.empty(len(self.space))
            for points, outcomes in self._held:
                self.outcomes.join(points, outcomes)
            return
        self.chosen = tuple(designs)
        rows = {design: row for row, design in enumerate(designs)}
        self.outcomes = Outcomes.empty(len(designs) * conditions)
        for points, outcomes in self._held:
            row = [rows[point // conditions] * conditions + point % conditions for point in points.tolist()]
            self.outcomes.join(np.array(row, np.intp), outcomes)


class Feed(Iterator[Work]):
    """Works for an executor, which come in as long as it runs: behind the last one, it is asked again later."""

    def __init__(self) -> None:
        self._works: deque[Work] = deque()

    def add(self, works: Iterable[Work]) -> None:
        """More works; to be added while the executor waits for what it gave to be taken."""
        self._works.extend(works)

    def __next__(self) -> Work:
        if not self._works:
            raise StopIteration
        return self._works.popleft()


class SearchRun:
    """Searches of one space, with one store.

    Args:
        section, kept, tally: of the exploration.
        parted: points as works.
        compute: what comes of works; it is begun once, with a ``Feed``.
        noted: called with the works of all rounds, before they are computed.
        came: called with what was computed, to keep it.
        earlier: the plan of what was evaluated in this space before; see ``blocks.read_plan``.
    """

    def __init__(
        self,
        section: Exploration,
        kept: Kept,
        tally: Rounds,
        parted: Callable[[Indices], Iterable[Work]],
        compute: Callable[[Iterable[Work]], Generator[Done, None, None]],
        noted: Callable[[Sequence[Work]], None],
        came: Callable[[Done], None],
        earlier: Plan = (),
    ) -> None:
        self.world = Conditions(section.conditions, section.aggregate)
        self.conditions = len(self.world.each)
        self._section, self._kept, self._tally, self._parted = section, kept, tally, parted
        self._noted, self._came = noted, came
        self._feed = Feed()
        self._coming = compute(self._feed)
        self._works: list[Work] = []
        self._earlier = earlier
        self._traces: tuple[Trace, ...] = ()
        self._count_noted = 0
        self._verdicts: dict[int, tuple[Floats, Floats]] = {}
        self.limits = (*_bound_names(section), _SHARE, _FIT, _COMPARABLE)
        self.designs = dict.fromkeys(kept.designs_of(earlier, self.conditions))
        if self.designs:
            tally.begin(self._points(list(self.designs)))
            for done in kept.planned(earlier):
                tally.take_kept(done)

    def problem(self, decisions: Space, bounds: Bounds | None) -> Problem:
        """The problem of the search."""
        figures = self._section.objectives
        maximise = tuple(self.world.maximise(figure) for figure in figures)
        return Problem(decisions, tuple(figure.name for figure in figures), maximise, self.limits, bounds)

    @property
    def in_order(self) -> list[int]:
        """The designs in the order in which the store's plan has them."""
        plan = [*self._earlier, *(("", np.array(sorted(work.indices), np.int64)) for work in self._works)]
        return self._kept.designs_of(plan, self.conditions)

    def close(self) -> None:
        """End all work, and note what was asked for."""
        self._coming.close()
        if len(self._works) > self._count_noted:
            self._noted(self._works)

    def run(self, asked: Sequence[Searching], problem: Problem, budget: Budget | None) -> Searched:
        """Run the first search within the budget, and beside it the others with as many evaluations.

        Raises:
            InputError: a search that has no end of its own has no budget; see ``search_of``.
        """
        searches = [search_of(each, problem) for each in asked]
        unlimited = budget is None or (budget.points is None and budget.seconds is None)
        if unlimited and searches[0].endless:
            hint = "name --points or --time, or points or time in explore.search"
            raise InputError(f"search {asked[0].sampler} has no end of its own", "search", hint)
        budget = budget or Budget()
        traces = [Trace(each.sampler, each.seed, ended=CUT_OFF) for each in asked]
        self._traces = tuple(traces)
        first, *sides = zip(searches, traces, strict=True)
        self._tally.total = (budget.points or 0) * len(asked)
        while len(traces[0].designs) < len(problem.decisions):
            room = self._room(searches[0], budget)
            if not room or not self._round(*first, room, budget):
                break
            for search, trace in sides:
                while (missing := len(traces[0].designs) - len(trace.designs)) and self._round(
                    search, trace, missing, None
                ):
                    pass
        for search, trace in zip(searches, traces, strict=True):
            trace.excluded, trace.ended = tuple(search.excluded), ""
            trace.proved = search.complete or len(trace.designs) == len(problem.decisions)
        traces[0].ended = "" if traces[0].proved else budget.ended
        return self.searched

    @property
    def searched(self) -> Searched:
        """The searches so far."""
        return Searched(self._traces, self._tally.simulated, self._tally.cached)

    def _room(self, search: Search, budget: Budget) -> int:
        """The number of designs that may be asked for; 0 if the budget is used up."""
        if budget.left is None:
            return search.batch
        if budget.left < self.conditions:
            budget.spend(self.conditions)
            return 0
        return min(search.batch, budget.left // self.conditions)

    def _round(self, search: Search, trace: Trace, room: int, budget: Budget | None) -> bool:
        """Ask, evaluate and tell; whether the search goes on."""
        asked = search.ask(room)
        trace.repeated = search.repeated
        if not asked or (budget is not None and not budget.spend(len(asked) * self.conditions)):
            return False
        self.evaluate(asked)
        verdicts = [self._verdicts[design] for design in asked]
        search.tell(asked, np.array([each[0] for each in verdicts]), np.array([each[1] for each in verdicts]))
        trace.designs += asked
        return True

    def evaluate(self, designs: Sequence[int]) -> None:
        """Have designs evaluated that were not yet, and judge them."""
        unjudged = [design for design in designs if design not in self._verdicts]
        new = [design for design in unjudged if not self._is_done(design)]
        if new:
            self._compute(self._points(new), [design for design in new if design not in self.designs])
            self.designs |= dict.fromkeys(new)
        if unjudged:
            outcomes = self._tally.of(self._points(unjudged).tolist())
            rows = zip(*verdicts(outcomes, self.world, self._section, self.limits), strict=True)
            self._verdicts |= dict(zip(unjudged, rows, strict=True))

    def _is_done(self, design: int) -> bool:
        return all(self._tally.is_done(point) for point in self._points([design]).tolist())

    def _points(self, designs: Sequence[int]) -> Indices:
        return points_of(designs, self.conditions)

    def _compute(self, points: Indices, unheld: Sequence[int]) -> None:
        self._tally.begin(self._points(unheld))
        works = list(self._parted(np.sort(points)))
        self._works += works
        if len(self._works) >= _GROWN * self._count_noted:
            self._noted(self._works)
            self._count_noted = len(self._works)
        pending: list[Work] = []
        for each in self._kept.parted(works):
            if isinstance(each, Done):
                self._tally.take_kept(each)
            else:
                pending.append(each)
        left = sum(map(len, pending))
        self._tally.total = max(self._tally.total, self._tally.done + left)
        self._feed.add(pending)
        while left:
            done = next(self._coming)
            self._came(done)
            left -= len(done.work)


def enumerated(searching: Searching, explored: Explored, space: Space, budget: Budget | None) -> str:
    """The reason for which all points are computed in the place of a search; "": they are not.

    It may not take more simulations: branch and bound simulates as much as all points do, the others at most what their
    budget of points allows, or a generation where they have none.
    """
    if searching.sampler == "random" or len(space) > limits.ENUMERATED:
        return ""
    most = (budget and budget.points) or (len(space) if searching.sampler == "bound" else POPULATION)
    works = parted(explored, space, np.arange(len(space)))
    simulations = sum(1 for _ in islice(works, most + 1))
    if simulations > most:
        return ""
    return (
        f"{searching.sampler} was not run: all points of a space of at most {limits.ENUMERATED:,} are computed"
        " where they take few simulations, which is exact, and cheaper than a proof"
        f" ({len(space):,} take at most {simulations:,})"
    )


def searched_before(kept: Kept, section: Exploration, plan: Plan) -> Rounds:
    """The outcomes of what was asked for in a space that is too large to hold."""
    rounds = Rounds(kept.space, section, kept.where)
    conditions = len(Conditions(section.conditions, section.aggregate).each)
    designs = kept.designs_of(plan, conditions)
    rounds.begin(points_of(designs, conditions))
    for done in kept.planned(plan):
        rounds.take_kept(done)
    rounds.gather(designs, conditions)
    return rounds


def verdicts(
    outcomes: Outcomes, world: Conditions, section: Exploration, limits: Sequence[str]
) -> tuple[Floats, Floats]:
    """The verdicts on designs that searches are told: their objectives, and by how much they break each limit.

    Returns:
        float64, designs × objectives (NaN: not comparable), and designs × limits (NaN: the design failed).
    """
    judged = Judged(outcomes, world, section.constraints, section.objectives)
    comparable = judged.feasible & ~judged.unreached
    objectives = np.column_stack([judged.figure(figure) for figure in section.objectives])
    objectives = np.where(comparable[:, None], objectives, math.nan)
    excess = np.zeros((judged.count, len(limits)))
    bounds = _bound_names(section)
    for broken in (*judged.broken_points, *judged.broken):
        place = bounds.index(broken.name.partition(":")[0])
        amounts = broken.gap / np.where(broken.limit == 0, 1.0, np.abs(broken.limit))
        excess[broken.which, place] = np.maximum(amounts, np.finfo(np.float64).tiny)
    for broken in judged.short:
        excess[broken.which, limits.index(_SHARE)] += broken.gap
    table = np.array([*map(_amount, outcomes.reasons), 0.0])
    fit = outcomes.each(_amounts, 0.0) + table[outcomes.reason]
    out = ~judged.feasible
    excess[:, limits.index(_FIT)] = np.where(out, judged.by_design(fit).sum(axis=1), 0.0)
    silent = out & ~(excess > 0).any(axis=1)
    lacks = judged.feasible & np.isnan(objectives).any(axis=1)
    excess[silent | lacks, limits.index(_COMPARABLE)] = 1.0
    excess[judged.state != State.DONE] = math.nan
    return objectives, excess


def _bound_names(section: Exploration) -> tuple[str, ...]:
    """The names of all bounds of the constraints, as reasons have them."""
    return tuple(name for limit in section.constraints for name in bound_names(limit).values())


def _amounts(template: Result) -> float:
    return sum(map(_amount, template.reasons))


def _amount(reason: Reason) -> float:
    """By how much a reason passes its limit, relative to it; more than 0."""
    return max(reason.gap / abs(reason.limit) if reason.limit else reason.gap, 1e-9)
