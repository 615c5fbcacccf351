"""Block-synchronous relaxation of a harmonic field with rising precision (Girau et al. 2008, section 4).

- **iteration** of a block: every free cell becomes floor((N + E + S + W) / 4), all at once, neighbours
  outside the block at their latest values;
- **visit**: up to I iterations of one block, ended early by one that changes no bit (which is counted);
- **sweep**: one visit of each block in raster order;
- **stage**: sweeps at one precision until converged. ``sound``: no visit of the sweep changed a bit.
  ``published``, the paper's listing: each visit of the sweep ended with an iteration that changed no bit.

Then all values are shifted left to the next precision.

**Early promotion**: a stage may be left after some sweeps, before it converged. Under ``sound`` the last field has the
same bits. Let L_p be the least fixed point at precision p. Values that begin nowhere above L_p stay nowhere above it,
and settle at it, as an iteration keeps their order and L_p stays. Shifted by d bits they are nowhere above L_p · 2^d,
and that is nowhere above L_(p+d), as 2^d · floor(s / 4) ≤ floor(2^d · s / 4). So every stage begins nowhere above its
fixed point, and the last one runs until it is there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.planners.harmonic.plan.arguments import Arguments, Stage, StageEnd, VisitBatch, check_arguments
from codesign.planners.harmonic.plan.fixed_point import Field, LowerBound

NEVER: Mapping[int, int] = MappingProxyType({})
"""No stage is left before it has settled."""


@dataclass(frozen=True, eq=False)
class VisitRecord:
    """Every visit of a run in order: int32 arrays of equal length."""

    stage: NDArray[np.int32]
    block: NDArray[np.int32]
    iterations: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class HarmonicPlan:
    """The outcome of ``relax``.

    Attributes:
        stages: the counts of each stage, in order.
        field: the field at the last precision reached.
        reachable: bool, rows × columns: free cells from which some 4-connected path leads to a goal.
        visits: iterations of each visit, or None where they were not recorded.
        from_below: the values began nowhere above the converged field, so they never rose above it.
        fault: the reason why the field is not settled; empty where it is.
    """

    stages: tuple[Stage, ...]
    field: Field
    reachable: NDArray[np.bool_]
    visits: VisitRecord | None
    from_below: bool = True
    fault: str = ""

    @cached_property
    def values(self) -> NDArray[np.object_]:
        """The exact values at the last precision reached: objects of Python int, rows × columns."""
        return self.field.to_ints()

    @property
    def precision(self) -> int:
        """The last precision reached."""
        return self.field.precision

    @property
    def local_maxima(self) -> int:
        """Local maxima left at the end."""
        return self.stages[-1].local_maxima

    @property
    def total_iterations(self) -> int:
        """Iterations of all stages."""
        return sum(stage.iterations for stage in self.stages)

    @property
    def total_cycles(self) -> int:
        """Cycles of all stages, p + 2 an iteration."""
        return sum(stage.cycles for stage in self.stages)


def work(
    free: Any,
    goals: Any,
    *,
    block: tuple[int, int],
    iterations: int,
    schedule: Any,
    termination: str = "sound",
    start: Any = None,
    stop_without_local_maxima: bool = False,
    most_sweeps: int | None = None,
    promote_after: Mapping[int, int] = NEVER,
) -> Iterator[VisitBatch | StageEnd]:
    """The visits of ``relax`` one by one, each stage closed by a StageEnd.

    Takes the arguments of ``relax`` and checks them before it returns. Memory stays bounded: a batch holds at most some
    ten thousand visits. The caller may stop at any point.
    """
    arguments = check_arguments(
        free, goals, block=block, iterations=iterations, schedule=schedule, termination=termination, start=start
    )
    return _run(arguments, stop_without_local_maxima, most_sweeps, promote_after)


def _run(
    arguments: Arguments, stop_without_local_maxima: bool, most_sweeps: int | None, promote_after: Mapping[int, int]
) -> Iterator[VisitBatch | StageEnd]:
    from codesign.planners.harmonic.plan.engine import Engine

    engine, schedule = Engine(arguments), arguments.schedule
    del arguments
    for index, precision in enumerate(schedule):
        for item in engine.run(index, precision, most_sweeps, promote_after.get(precision)):
            yield item
            if isinstance(item, StageEnd) and (item.fault or (stop_without_local_maxima and item.stage.ends_a_run)):
                return


def relax(
    free: Any,
    goals: Any,
    *,
    block: tuple[int, int],
    iterations: int,
    schedule: Any,
    termination: str = "sound",
    start: Any = None,
    stop_without_local_maxima: bool = False,
    record_visits: bool = True,
    most_sweeps: int | None = None,
    promote_after: Mapping[int, int] = NEVER,
) -> HarmonicPlan:
    """Relax a harmonic field, bit for bit as the block-synchronous circuit does.

    Args:
        free: bool, rows × columns; True is free. Outside the map all is obstacle.
        goals: (row, column) pairs on free cells.
        block: rows and columns of a block; the last block of a row or column may be partial.
        iterations: the paper's I, most iterations of a visit.
        schedule: precisions in bits, rising.
        termination: ``sound`` or ``published``.
        start: values to start from, integers at precision schedule[0] in 0..2^p, or a Field at that precision
            or a lower one (then shifted); None is zero. Goals are always 2^p and obstacles 0.
        stop_without_local_maxima: end at the first stage that leaves no local maximum, instead of running
            the whole schedule.
        record_visits: keep the iterations of every visit (4 bytes each).
        most_sweeps: end the run at a stage that has not settled after this many sweeps, or never will; ``fault`` gives
            the reason. None means without a bound.
        promote_after: by precision, the sweeps after which a stage is left though it has not settled. Such a stage
            never ends the run. The last precision of the schedule is not among them.

    Raises:
        MapError: the map or a goal is unusable. InputError: another argument is.
        RunError: from this start the values come back to where they were and never settle. Cannot happen from
            zero, nor from any start at or below the final field, nor with ``most_sweeps``.

    >>> import numpy as np
    >>> result = relax(np.ones((1, 3), bool), [(0, 0)], block=(1, 3), iterations=8, schedule=[4])
    >>> result.values.tolist()
    [[16, 4, 1]]
    >>> result.stages[0].iterations, result.stages[0].cycles
    (4, 24)
    """
    stages: list[Stage] = []
    batches: list[VisitBatch] = []
    arguments = check_arguments(
        free, goals, block=block, iterations=iterations, schedule=schedule, termination=termination, start=start
    )
    reachable = arguments.reachable
    run = _run(arguments, stop_without_local_maxima, most_sweeps, promote_after)
    # From here on only the engine holds the start: it would take as much memory again as the field.
    del arguments
    field, fault = None, ""
    for item in run:
        if isinstance(item, StageEnd):
            stages.append(item.stage)
            field, fault = item.field, item.fault
        elif record_visits:
            batches.append(item)
    assert field is not None, "a schedule has at least one stage"
    visits = _record(batches) if record_visits else None
    below = start is None or isinstance(start, LowerBound)
    return HarmonicPlan(tuple(stages), field, reachable, visits, below, fault)


def _record(batches: list[VisitBatch]) -> VisitRecord:
    return VisitRecord(
        stage=np.concatenate([np.full(len(batch.block), batch.stage_index, np.int32) for batch in batches]),
        block=np.concatenate([batch.block for batch in batches]),
        iterations=np.concatenate([batch.iterations for batch in batches]),
    )


def stage_cost(
    free: Any,
    goals: Any,
    field: Field | None,
    precision: int,
    *,
    block: tuple[int, int],
    iterations: int,
    termination: str = "sound",
) -> tuple[Stage, Field]:
    """Run exactly one stage at ``precision`` from a field at a lower one (None means from zero).

    Under sound termination the resulting field does not depend on the stages before. So stage costs add up, and the
    best schedule is a shortest path over precisions.
    """
    result = relax(
        free,
        goals,
        block=block,
        iterations=iterations,
        schedule=[precision],
        termination=termination,
        start=field,
        record_visits=False,
    )
    return result.stages[0], result.field
