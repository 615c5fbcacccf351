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
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol

import numpy as np

from codesign.ground.errors import InputError
from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan.arguments import StageEnd, Visits, check_arguments
from codesign.planners.harmonic.plan.parameters import Stop
from codesign.planners.harmonic.plan.planner import sent_map
from codesign.planners.harmonic.plan.warm_start import FieldBounds

if TYPE_CHECKING:
    from codesign.planners.harmonic.plan.fixed_point import Field
    from codesign.planners.harmonic.plan.parameters import RelaxParameters
    from codesign.planners.interface import Problem


# The costs of single stages for the search of the best schedule: simulated, cut off, or bounded from below.
#
# **Bounds.** Only what is proven rules a stage out. Let G be one sweep at precision b, and L_b its least fixed point.
#
# - *Cost so far.* Costs are sums over visits, and none is negative. So a stage costs at least what its first visits do.
# - *Sweeps.* A visit maps values to values, and keeps their order, as floor((N + E + S + W) / 4) does. So G keeps it.
#   Let a < a' < b. Then x = L_a · 2^(b-a) ≤ y = L_a' · 2^(b-a') ≤ L_b, because 2^d · floor(s / 4) ≤ floor(2^d · s / 4)
#   makes every shifted fixed point a value that only rises. So G^k(x) ≤ G^k(y) ≤ L_b for any k. Once G^k(x) = L_b, so
#   is G^k(y), and a stage ends with the first sweep that begins at L_b. So a stage from a lower start takes **at least
#   as many sweeps** as one from a higher start to the same precision.
# - *Iterations.* With I = 1 a visit is one iteration, so the iterations are bounded likewise. With one block an
#   iteration of the map keeps the order, so k, the number of iterations that change a bit, is bounded likewise. The
#   iterations of the stage are k + 1, and one more where I does not divide k. That does not fall as k rises.
# - *Decay.* With one block the error cannot shrink faster than its slowest decay lets it: see ``Decay``.
#
# A bound that was only observed is not among them. With several blocks and I > 1, a higher start can take more
# iterations.

ROUNDS = 40
"""Rounds of inverse iteration."""

SCALE = 300
"""φ is taken in units of 2^-300: exact for every value above 2^-248."""

_SAFE = 1e-9
"""Relative room for the rounding of doubles, far above it."""


class Decay:
    """A lower bound on the iterations of one block, from the slowest decay of its error.

    Let e = L_b - h ≥ 0 be the error of the values h at precision b, and A the average over the four neighbours, on the
    computed cells. As h' = floor((N + E + S + W) / 4) loses at most 3/4, e' ≥ A e - 3/4. With w = A w + 1 that is
    e' + ¾w ≥ A (e + ¾w), so after k iterations e_k + ¾w ≥ A^k (e_0 + ¾w). Let φ ≥ 0 with A φ ≥ μ φ in every cell; A is
    symmetric. The values have settled once e_k = 0, so

        ¾ φ·w ≥ μ^k (φ·e_0 + ¾ φ·w),    k ≥ ln(1 + φ·e_0 / (¾ φ·w)) / ln(1/μ).

    φ comes from inverse iteration, so μ is close to the largest eigenvalue. Nothing rests on how close: μ is the least
    ratio of A φ to φ, and w is enlarged until w ≥ A w + 1 holds. φ·e_0 is exact, in integers.

    ``bounds``: of the map and its goals.
    """

    def __init__(self, bounds: FieldBounds) -> None:
        from scipy.sparse.csgraph import connected_components

        average, self._cells = bounds.average, bounds.cells
        weights = np.ones(len(self._cells))
        for _ in range(ROUNDS):
            weights = np.maximum(bounds.solve(weights), 0.0)
            weights /= weights.max()
        # Goals may part the map: the component with the best ratio is taken, and the weights elsewhere are 0.
        count, component = connected_components(average, directed=False)
        ratios = np.full(count, np.inf)
        np.minimum.at(ratios, component, np.divide(average @ weights, np.maximum(weights, 2.0**-200)))
        best = int(np.argmax(ratios))
        self._rate = float(ratios[best]) - 1e-12
        weights = np.where(component == best, weights, 0.0)
        steps = bounds.noise
        steps = steps / (steps - average @ steps).min()
        self._loss = 0.75 * float(weights @ steps) * (1 + _SAFE)
        self._weights = np.array([int(math.ldexp(weight, SCALE)) for weight in weights], object)

    def sum_of(self, field: Field) -> int:
        """φ · h of a field, in units of 2^-SCALE."""
        values = field.to_ints().ravel()[self._cells]
        return int((self._weights * values).sum())

    def least_iterations(self, error: int) -> int:
        """A lower bound on the iterations of a stage: those that change a bit, and one that sees that none does.

        ``error``: φ · e_0, by ``sum_of``.
        """
        if error <= 0 or not 0.0 < self._rate < 1.0:
            return 1
        exponent = math.log(error) - SCALE * math.log(2) - math.log(self._loss)
        # ln(1 + x) ≥ ln x; the exact form where x is small enough for doubles.
        grown = math.log1p(math.exp(exponent)) if exponent < 100 else exponent
        return math.ceil(grown / -math.log(self._rate) * (1 - _SAFE)) + 1


StageCost = Callable[[int, Visits], int]
"""The cost of a stage at a precision with these sums of visits: it never falls as a sum rises."""

MAX_CELLS = 1 << 16
"""Cells of the largest map with a bound by its decay: some tenths of a second."""

BUDGET = 1 << 22
"""Words times iterations between two looks at the cost so far: some hundredth of a second."""


def iteration_cycles(precision: int, visits: Visits) -> int:
    """Iterations × (p + 2) (section 5.4)."""
    return int(visits.iterations.sum()) * (precision + 2)


@dataclass(frozen=True, eq=False)
class _Whole:
    """A stage that was simulated to its end."""

    visits: Visits
    local_maxima: int


class _AboveError(Exception):
    """The cost so far is above the most that may be. ``visits``: so far."""

    def __init__(self, visits: Visits) -> None:
        super().__init__()
        self.visits = visits


def _itself(field: Field) -> Field:
    return field


class SimulatedStages:
    """The stages of a problem between any two precisions, each simulated at most once, as far as needed."""

    def __init__(self, problem: Problem, parameters: RelaxParameters, memo: Memo, cost: StageCost) -> None:
        self._goals, self._free = problem.goals, sent_map(problem, parameters)
        self._memo, self._cost = memo, cost
        rows, columns = parameters.block_shape(*problem.shape)
        self._block = min(rows, problem.rows), min(columns, problem.columns)
        self._blocks = parameters.block_count(*problem.shape)
        self._iterations = parameters.iterations
        self._map = problem.map_digest, parameters.pockets
        self._local_maxima: dict[int, int] = {}
        # By last precision, then by first: the least sweeps and iterations of the stage.
        self._sums = {0: 0}
        self._known: dict[int, dict[int, tuple[int, int]]] = {}

    @cached_property
    def _decay(self) -> Decay | None:
        """The decay of one block; None where it says nothing, or would take too long."""
        if self._blocks > 1 or self._free.size > MAX_CELLS:
            return None

        bounds = FieldBounds(self._free, self._goals)
        return Decay(bounds) if len(bounds.cells) else None

    def _least_iterations(self, begin: int, end: int) -> int:
        """By the decay of the error of the field at ``begin`` at precision ``end``."""
        if self._decay is None or begin not in self._sums or end not in self._sums:
            return 1
        return self._decay.least_iterations(self._sums[end] - (self._sums[begin] << (end - begin)))

    def least(self, begin: int, end: int) -> int:
        """See ``best_schedule.Stages``."""
        known = [bound for start, bound in self._known.get(end, {}).items() if start >= begin]
        sweeps = max((sweeps for sweeps, _ in known), default=1)
        visits = Visits.none(self._blocks)
        visits.count[:] = visits.iterations[:] = sweeps
        if self._blocks == 1:
            # With I = 1, sweeps and iterations are the same.
            iterations = max((iterations for _, iterations in known), default=1)
            iterations = max(iterations, self._least_iterations(begin, end))
            visits.iterations[:] = iterations
            visits.count[:] = max(sweeps, -(-iterations // self._iterations))
        return self._cost(end, visits)

    def run(self, begin: int, end: int, most: int | None) -> int | None:
        """See ``best_schedule.Stages``."""
        try:
            whole = self._stage(begin, end, most)
        except _AboveError as above:
            # The first block has a visit in every sweep that has begun.
            self._note(begin, end, int(above.visits.count[0]), above.visits)
            return None
        self._note(begin, end, int(whole.visits.count[0]), whole.visits)
        self._local_maxima[end] = whole.local_maxima
        if self._decay is not None and end not in self._sums:
            self._sums[end] = self._decay.sum_of(self._least_field(end))
        return self._cost(end, whole.visits)

    def ends(self, precision: int) -> bool:
        """See ``best_schedule.Stages``."""
        return self._local_maxima[precision] == 0

    def _note(self, begin: int, end: int, sweeps: int, visits: Visits) -> None:
        self._known.setdefault(end, {})[begin] = sweeps, int(visits.iterations.sum())

    def _stage(self, begin: int, end: int, most: int | None) -> _Whole:
        key = ("stage of a search", *self._map, self._block, self._iterations, begin, end)
        return self._memo.get(key, lambda: self._simulated(begin, end, most)[0])

    def _field(self, precision: int) -> Field | None:
        """The field after any stage to a precision; None if it is zero."""
        return self._least_field(precision) if precision else None

    def _least_field(self, precision: int) -> Field:
        # A stage to this precision ran before. Where the memo had no room, the field is computed again from zero.
        return self._memo.get(self._field_key(precision), lambda: self._simulated(0, precision, None)[1])

    def _field_key(self, precision: int) -> tuple[object, ...]:
        return ("least field", *self._map, precision)

    def _simulated(self, begin: int, end: int, most: int | None) -> tuple[_Whole, Field]:
        from codesign.planners.harmonic.plan.engine import Engine

        arguments = check_arguments(
            self._free,
            self._goals,
            block=self._block,
            iterations=self._iterations,
            schedule=(end,),
            termination="sound",
            start=self._field(begin),
        )
        engine, visits = Engine(arguments, budget=BUDGET), Visits.none(self._blocks)
        for item in engine.run(0, end):
            if isinstance(item, StageEnd):
                self._memo.get(self._field_key(end), partial(_itself, item.field))
                return _Whole(visits, item.stage.local_maxima), item.field
            visits.add(item, self._iterations)
            if most is not None and self._cost(end, visits) > most:
                raise _AboveError(visits)
        raise AssertionError("a stage has an end")


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
