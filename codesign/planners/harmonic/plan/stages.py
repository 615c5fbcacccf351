"""The reports of a relaxation: stages and their visits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from codesign.planners.harmonic.plan.fixed_point import Field


@dataclass(frozen=True)
class Stage:
    """The counts of one stage.

    Attributes:
        precision: fractional bits p.
        sweeps, visits, iterations: their numbers, over all blocks.
        local_maxima: free cells, goals left out, with no strictly greater neighbour at the end.
        promoted: the stage was left after a number of sweeps, before it settled.
    """

    precision: int
    sweeps: int
    visits: int
    iterations: int
    local_maxima: int
    promoted: bool = False

    @property
    def ends_a_run(self) -> bool:
        """True if a run that stops without local maxima stops here: the stage settled, and left none."""
        return self.local_maxima == 0 and not self.promoted

    @property
    def cycles(self) -> int:
        """Clock cycles of the iterations alone: p + 2 each (section 5.4), for any size of the block."""
        return self.iterations * (self.precision + 2)


@dataclass(frozen=True, eq=False)
class VisitBatch:
    """Consecutive visits of one stage, in order.

    Attributes:
        stage_index: index of the stage in the schedule, from 0.
        precision: fractional bits p.
        block: int32, index of the block in raster order.
        iterations: int32, iterations of each visit, 1..I.
    """

    stage_index: int
    precision: int
    block: NDArray[np.int32]
    iterations: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Visits:
    """Visits one by one, or the sums of the visits of each block: arrays of one length.

    ``block``: int32. ``iterations``: int64. ``count``: int64, how many visits. ``early``: int64, how many of them ended
    before their last iteration.
    """

    block: NDArray[np.int32]
    iterations: NDArray[np.int64]
    count: NDArray[np.int64]
    early: NDArray[np.int64]

    @classmethod
    def none(cls, blocks: int) -> Self:
        """The sums of no visits, for ``blocks`` blocks."""
        return cls(np.arange(blocks, dtype=np.int32), *np.zeros((3, blocks), np.int64))

    def add(self, batch: VisitBatch, most_iterations: int) -> None:
        """Add the visits of a batch to these sums. ``most_iterations``: of one visit."""
        blocks = len(self.block)
        self.iterations[:] += np.bincount(batch.block, batch.iterations, blocks).astype(np.int64)
        self.count[:] += np.bincount(batch.block, minlength=blocks)
        early = batch.block[batch.iterations < most_iterations]
        self.early[:] += np.bincount(early, minlength=blocks)


@dataclass(frozen=True, eq=False)
class StageEnd:
    """The end of a stage: its index in the schedule, its counts, and its field.

    ``fault``: the reason why the stage did not settle; empty where it did.
    """

    stage_index: int
    stage: Stage
    field: Field
    fault: str = ""
