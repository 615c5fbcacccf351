"""The best precision schedule of a map, exactly, and with its proof.

Under sound termination a converged stage leaves the least fixed point of its precision, from any start below it. So the
cost of a stage depends on its first and last precision alone, and the cost of a schedule is the sum over its stages.
The best of all 2^n schedules through n candidates is a shortest path over at most (n+1)(n+2)/2 stages.

A stage is simulated only where the search needs its cost (``best_schedule``). Bounds rule out most of the others.

The termination test of the paper can end a stage with wrong cells, and so can a promotion before a stage has settled.
These cells depend on the stages before, so costs do not add up, and there is no such search.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol

from codesign.ground.errors import InputError
from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan.parameters import Stop
from codesign.planners.harmonic.plan.stage_costs import SimulatedStages, iteration_cycles

if TYPE_CHECKING:
    from codesign.planners.harmonic.plan.parameters import RelaxParameters
    from codesign.planners.harmonic.plan.stage_costs import StageCost
    from codesign.planners.interface import Problem


@dataclass(frozen=True)
class Schedule:
    """The best schedule, and why no other is better.

    Attributes:
        precisions: of its stages, in order.
        cost: the sum of the costs of its stages.
        schedules: how many schedules it was chosen from.
        series: the cost of the schedule through all candidates.
        stages: how many different stages those schedules have.
        simulated: how many of these were simulated to their end.
        cut: how many were simulated until their cost so far ruled them out.
        bounded: how many were never begun: a bound on their cost, or the end of the search, ruled them out.
    """

    precisions: tuple[int, ...]
    cost: int
    schedules: int
    series: int
    stages: int
    simulated: int
    cut: int

    @property
    def bounded(self) -> int:
        """Stages that were never begun."""
        return self.stages - self.simulated - self.cut


class Stages(Protocol):
    """The stages of a map between any two precisions; 0 as the first one: from zero."""

    def least(self, begin: int, end: int) -> int:
        """A proven lower bound ≥ 0 on the cost of a stage. It may rise as stages are run."""

    def run(self, begin: int, end: int, most: int | None) -> int | None:
        """The cost of a stage; None where it is above ``most``.

        Called at most once for a stage, after some stage to ``begin`` was run to its end.
        """

    def ends(self, precision: int) -> bool:
        """True if a run would end after a stage at this precision. Called after such a stage was run to its end."""


def best_schedule(stages: Stages, candidates: Iterable[int], last: int, *, may_end: bool = True) -> Schedule:
    """The cheapest rising schedule that ends at ``last``; among equals, one with the fewest stages.

    Args:
        stages: their costs and bounds.
        candidates: the precisions that may come before ``last``; those not below it are left out.
        last: fractional bits of the last stage.
        may_end: True if a run may end at an earlier precision (``Stages.ends``). A schedule that reaches such a
            precision ends there.

    Raises:
        InputError: a precision below 1.
    """
    rungs = sorted({precision for precision in candidates if precision < last} | {last})
    if rungs[0] < 1:
        raise InputError(f"a precision of {rungs[0]} bits", "candidates", "precisions start at 1")
    return _Search(stages, rungs, may_end).best()


Price = tuple[int, int]
"""Cost, then the number of stages, which decides among equal costs."""


class _Search:
    """A shortest path by A*: the stage with the least bound on the whole schedule comes next.

    ``_incumbent``: the best schedule of stages that were run. A stage whose bound is above it is on no best schedule.
    """

    def __init__(self, stages: Stages, rungs: list[int], may_end: bool) -> None:
        self._stages, self._rungs, self._last, self._may_end = stages, rungs, rungs[-1], may_end
        self._costs: dict[tuple[int, int], int] = {}
        self._cut = 0
        self._over: dict[int, bool] = {0: False}
        self._incumbent: Price | None = None

    def best(self) -> Schedule:
        series = self._series()
        # Every schedule that goes on has a stage to the last precision. Frozen, so that the order stays consistent.
        ahead = self._ahead()
        waiting = [self._entry((0, 0), 0, end, ahead) for end in self._rungs]
        heapq.heapify(waiting)
        before: dict[int, tuple[int, Price]] = {}
        while True:
            (cost, count), pending, end, begin, so_far = heapq.heappop(waiting)
            if end in before:
                continue
            if pending:
                entry = self._entry(so_far, begin, end, ahead)
                if entry[0] > (cost, count):
                    heapq.heappush(waiting, entry)
                elif self._measured(so_far, begin, end, ahead[end]):
                    heapq.heappush(waiting, self._entry(so_far, begin, end, ahead))
                continue
            before[end] = begin, so_far
            price = so_far[0] + self._costs[begin, end], so_far[1] + 1
            if self._over[end]:
                return self._proven(before, end, price[0], series)
            for after in self._rungs:
                if after > end:
                    heapq.heappush(waiting, self._entry(price, end, after, ahead))

    def _entry(self, so_far: Price, begin: int, end: int, ahead: dict[int, int]) -> tuple[Price, bool, int, int, Price]:
        """A stage in the queue: a bound on every schedule that begins with ``so_far`` and goes on with it."""
        known = self._costs.get((begin, end))
        stage = self._stages.least(begin, end) if known is None else known
        return (so_far[0] + stage + ahead[end], so_far[1] + 1), known is None, end, begin, so_far

    def _series(self) -> int:
        """Run the schedule through all candidates: its cost, which is the first incumbent."""
        total = 0
        for begin, end in pairwise([0, *self._rungs]):
            cost = self._run(begin, end, None)
            assert cost is not None, "without a bound a stage is run to its end"
            total += cost
            if self._over[end]:
                break
        return total

    def _ahead(self) -> dict[int, int]:
        """For each precision a lower bound on what a schedule costs after it."""
        if self._may_end:
            return dict.fromkeys(self._rungs, 0)
        to_last = min((self._stages.least(begin, self._last) for begin in self._rungs[:-1]), default=0)
        return {**dict.fromkeys(self._rungs, to_last), self._last: 0}

    def _measured(self, so_far: Price, begin: int, end: int, ahead: int) -> bool:
        """True if a stage was run to its end, and not cut off."""
        assert self._incumbent is not None, "the series was run"
        most = self._incumbent[0] - so_far[0] - ahead
        if most >= self._stages.least(begin, end):
            if self._run(begin, end, most) is not None:
                return True
            self._cut += 1
        return False

    def _run(self, begin: int, end: int, most: int | None) -> int | None:
        cost = self._stages.run(begin, end, most)
        if cost is not None:
            self._costs[begin, end] = cost
            self._over[end] = end == self._last or (self._may_end and self._stages.ends(end))
            self._incumbent = self._best_run() or self._incumbent
        return cost

    def _best_run(self) -> Price | None:
        """The price of the best schedule whose stages were all run; None where there is none yet."""
        prices: dict[int, Price] = {0: (0, 0)}
        for begin, end in sorted(self._costs):
            if begin in prices and not self._over[begin]:
                cost, count = prices[begin]
                price = cost + self._costs[begin, end], count + 1
                prices[end] = min(price, prices.get(end, price))
        return min((price for end, price in prices.items() if self._over[end]), default=None)

    def _proven(self, before: dict[int, tuple[int, Price]], end: int, cost: int, series: int) -> Schedule:
        precisions: list[int] = []
        while end:
            precisions.append(end)
            end = before[end][0]
        count = len(self._rungs)
        return Schedule(
            precisions=tuple(reversed(precisions)),
            cost=cost,
            schedules=2 ** (count - 1),
            series=series,
            stages=count * (count + 1) // 2,
            simulated=len(self._costs),
            cut=self._cut,
        )


def optimise_schedule(
    problem: Problem,
    parameters: RelaxParameters,
    candidates: Iterable[int],
    memo: Memo | None = None,
    cost: StageCost | None = None,
) -> Schedule:
    """The cheapest schedule for a problem.

    It ends at the last precision of ``parameters``, or, where they stop the run at the first stage without local
    maxima, at any precision that leaves none. The search simulates every stage that it needs, bit for bit.
    The last precision of a run may depend on the schedule; the field at a precision never does.

    Args:
        problem: map and goals.
        parameters: partition, iterations, when the run stops, and the last precision; its schedule is not
            used otherwise.
        candidates: precisions that may come before the last.
        memo: keeps stages and fields for searches that share them.
        cost: the cost of a stage, for example with the cycles of switching blocks; iterations × (p + 2) by default.

    Raises:
        InputError: termination is not sound, stages are promoted early, or a precision is below 1.
    """
    refusal = parameters.no_search
    if refusal is not None:
        raise InputError(*refusal)
    stages = SimulatedStages(
        problem, parameters, Memo() if memo is None else memo, iteration_cycles if cost is None else cost
    )
    stops = parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA
    return best_schedule(stages, candidates, parameters.precisions[-1], may_end=stops)
