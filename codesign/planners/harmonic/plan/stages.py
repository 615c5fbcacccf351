"""The reports of a relaxation: stages and their visits."""

from __future__ import annotations

from dataclasses import dataclass

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
    """

    precision: int
    sweeps: int
    visits: int
    iterations: int
    local_maxima: int

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
class StageEnd:
    """The end of a stage: its index in the schedule, its counts, and its field.

    ``fault``: the reason why the stage did not settle; empty where it did.
    """

    stage_index: int
    stage: Stage
    field: Field
    fault: str = ""
