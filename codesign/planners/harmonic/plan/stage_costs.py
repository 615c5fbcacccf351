"""The costs of single stages for the search of the best schedule: simulated, cut off, or bounded from below.

**Bounds.** Only what is proven rules a stage out. Let G be one sweep at precision b, and L_b its least fixed point.

- *Cost so far.* Costs are sums over visits, and none is negative. So a stage costs at least what its first visits cost.
- *Sweeps.* A visit maps values to values, and keeps their order, as floor((N + E + S + W) / 4) does. So G keeps it too.
  Let a < a' < b. Then x = L_a · 2^(b-a) ≤ y = L_a' · 2^(b-a') ≤ L_b, because 2^d · floor(s / 4) ≤ floor(2^d · s / 4)
  makes every shifted fixed point a value that only rises. So G^k(x) ≤ G^k(y) ≤ L_b for any k. Once G^k(x) = L_b, so
  is G^k(y), and a stage ends with the first sweep that begins at L_b. So a stage from a lower start takes **at least as
  many sweeps** as one from a higher start to the same precision.
- *Iterations.* With I = 1 a visit is one iteration, so the iterations are bounded likewise. With one block an iteration
  of the map keeps the order, so k, the number of iterations that change a bit, is bounded likewise. The iterations of
  the stage are k + 1, and one more where I does not divide k. That does not fall as k rises.

- *Decay.* With one block the error cannot shrink faster than its slowest decay lets it: see ``decay``.

A bound that was only observed is not among them. With several blocks and I > 1, a higher start can take more
iterations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan.arguments import check_arguments
from codesign.planners.harmonic.plan.decay import Decay
from codesign.planners.harmonic.plan.pockets import sent_map
from codesign.planners.harmonic.plan.stages import StageEnd, Visits
from codesign.planners.harmonic.plan.warm_start import FieldBounds

if TYPE_CHECKING:
    from codesign.planners.harmonic.plan import Field
    from codesign.planners.harmonic.plan.parameters import RelaxParameters
    from codesign.planners.interface import Problem

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
