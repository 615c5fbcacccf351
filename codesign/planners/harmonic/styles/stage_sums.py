"""The stages of a relaxation without their single visits, shared between designs.

Three facts let designs on one map share what they compute:

- Stages that begin from the same field at the same precision, in the same blocks and with the same iterations, are the
  same. So schedules share the stages up to the first one in which they differ.
- A stage goes on where the stage before it ended: in the bit planes of an engine, if it still stands there. From a
  field alone they have to be made again.
- A stage with the published termination makes the first sweeps of the one with the sound termination. If no visit of
  its last sweep changed a bit, the sound stage ends there too. If all blocks are settled, the sound stage makes one
  more sweep, in which each visit is the one iteration that sees that nothing changes. Else it goes on from there.

A fourth fact spares the values: from below, a stage that settles leads to the least fixed point at its precision,
whatever its start, blocks and iterations are. So its field is read from the bit planes once for each precision.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan.arguments import check_arguments
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Termination
from codesign.planners.harmonic.plan.pockets import sent_map
from codesign.planners.harmonic.plan.stages import Stage, StageEnd, Visits
from codesign.planners.interface import Problem

if TYPE_CHECKING:
    from codesign.planners.harmonic.plan.engine import Engine

MOST_SWEEPS = 1 << 16
"""The most sweeps of a stage that starts from old values. Assumed: a watchdog of 16 bits."""


@dataclass(frozen=True, eq=False)
class StageSums:
    """A stage without its single visits: the sums of each block.

    ``quiet``: no visit of its last sweep changed a bit.
    """

    stage: Stage
    field: Field
    visits: Visits
    fault: str
    quiet: bool


@dataclass(eq=False)
class _Standing:
    """The engine that ran the last stage on a map, and where it stands: ``field``, in the blocks of ``partition``.

    ``published``: that termination was asked about on this map, so the stages of both are computed at once.
    """

    engine: Engine | None = None
    partition: tuple[Any, ...] = ()
    field: Field | None = None
    published: bool = False


@dataclass(frozen=True, eq=False)
class StageRuns:
    """The stages of one relaxation. ``below``: the values begin nowhere above the converged field."""

    problem: Problem
    parameters: RelaxParameters
    below: bool
    memo: Memo | None

    def sums(self, precision: int, start: Field | None) -> StageSums:
        """One stage from the field of an earlier one, or from the start; it is not computed again if it was before."""
        if self.memo is None:
            # Without a memo nothing would use them again, and the fields of all stages would only take memory.
            return self._run(self._engine(precision, start), precision)
        standing = self.memo.get(("harmonic standing", self.problem.map_digest), _Standing)
        if self.parameters.termination is Termination.PUBLISHED:
            standing.published = True
        return self.memo.get(
            self._key(precision, start, self.parameters.termination), lambda: self._shared(precision, start, standing)
        )

    def _partition(self) -> tuple[Any, ...]:
        height, width = self.parameters.block_shape(*self.problem.shape)
        # Blocks that hold the same cells have the same visits.
        block = min(height, self.problem.rows), min(width, self.problem.columns)
        return self.problem.map_digest, *block, self.parameters.iterations, self.parameters.pockets

    def _key(self, precision: int, start: Field | None, termination: Termination) -> tuple[Any, ...]:
        digest = None if start is None else start.digest()
        promoted = self.parameters.promote_after.get(precision)
        return "harmonic stage", *self._partition(), termination, digest, self.below, precision, promoted

    def _shared(self, precision: int, start: Field | None, standing: _Standing) -> StageSums:
        """A stage that the memo does not hold. It may put that of the other termination there."""
        promoted = self.parameters.promote_after.get(precision) is not None
        both = standing.published and self.below and not promoted
        sound = self.parameters.termination is Termination.SOUND
        partition = self._partition()
        stands = standing.engine if start is not None and standing.field is start else None
        engine = stands if stands is not None and standing.partition == partition else None
        # Not two at once: the planes of one are most of the memory of a run.
        standing.engine = None
        del stands
        if engine is None:
            engine = self._engine(precision, start)
        engine.published = both or not sound
        sums = self._run(engine, precision)
        if both:
            sums = self._both(engine, precision, start, sums)
        if not sums.fault:
            standing.engine, standing.partition, standing.field = engine, partition, sums.field
        return sums

    def _both(self, engine: Engine, precision: int, start: Field | None, published: StageSums) -> StageSums:
        """The stage of the termination that is asked about; that of the other one is put into the memo.

        ``published``: the published stage, at the end of which the engine stands.
        """
        assert self.memo is not None, "stages are shared under a memo"
        asked = self.parameters.termination
        if published.fault:
            return published if asked is Termination.PUBLISHED else self._run(self._engine(precision, start), precision)
        if published.quiet:
            sound = published
        elif engine.settled:
            sound = _with_a_quiet_sweep(published, self.parameters.iterations)
        elif asked is Termination.PUBLISHED:
            return published
        else:
            engine.published = False
            sound = _joined(published, self._run(engine, precision))
        ends = {Termination.PUBLISHED: published, Termination.SOUND: sound}
        (other,) = ends.keys() - {asked}
        self.memo.get(self._key(precision, start, other), lambda: ends[other])
        return ends[asked]

    def _engine(self, precision: int, start: Field | None) -> Engine:
        """An engine before its first stage."""
        from codesign.planners.harmonic.plan.engine import Engine

        problem, parameters = self.problem, self.parameters
        arguments = check_arguments(
            sent_map(problem, parameters),
            problem.goals,
            block=parameters.block_shape(*problem.shape),
            iterations=parameters.iterations,
            schedule=(precision,),
            termination=parameters.termination,
            start=start,
        )
        return Engine(arguments)

    def _run(self, engine: Engine, precision: int) -> StageSums:
        """One stage of an engine."""
        blocks = self.parameters.block_count(*self.problem.shape)
        visits = Visits.none(blocks)
        last: NDArray[np.int32] = np.zeros(0, np.int32)
        most = None if self.below else MOST_SWEEPS
        key = "harmonic converged", self.problem.map_digest, self.parameters.pockets, precision
        memo = self.memo if self.below else None
        converged = None if memo is None else memo.held(key)
        promoted = self.parameters.promote_after.get(precision)
        for item in engine.run(0, precision, most, promoted, converged):
            if isinstance(item, StageEnd):
                if memo is not None and converged is None and engine.settled:
                    memo.keep(key, item)
                # A visit of more than one iteration changed a bit.
                return StageSums(item.stage, item.field, visits, item.fault, bool((last == 1).all()))
            visits.add(item, self.parameters.iterations)
            last = np.concatenate([last, item.iterations])[-blocks:]
        raise AssertionError("a stage has an end")


def _with_a_quiet_sweep(sums: StageSums, most_iterations: int) -> StageSums:
    """The stage with one more sweep of visits of one iteration each."""
    blocks, visits = len(sums.visits.block), sums.visits
    longer = Visits(visits.block, visits.iterations + 1, visits.count + 1, visits.early + (most_iterations > 1))
    stage = replace(
        sums.stage,
        sweeps=sums.stage.sweeps + 1,
        visits=sums.stage.visits + blocks,
        iterations=sums.stage.iterations + blocks,
    )
    return replace(sums, stage=stage, visits=longer, quiet=True)


def _joined(first: StageSums, rest: StageSums) -> StageSums:
    """A stage in two parts as one."""
    one, two = first.visits, rest.visits
    stage = replace(
        rest.stage,
        sweeps=first.stage.sweeps + rest.stage.sweeps,
        visits=first.stage.visits + rest.stage.visits,
        iterations=first.stage.iterations + rest.stage.iterations,
    )
    visits = Visits(one.block, one.iterations + two.iterations, one.count + two.count, one.early + two.early)
    return replace(rest, stage=stage, visits=visits)
