"""What a relaxation reports: stages, and the visits they are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.planners.harmonic.plan.fixed_point import Field


@dataclass(frozen=True)
class Stage:
    """What one stage took.

    Attributes:
        precision: fractional bits p.
        sweeps, visits, iterations: how many, all blocks together.
        local_maxima: reachable free cells, goals left out, with no strictly greater neighbour at the end.
    """

    precision: int
    sweeps: int
    visits: int
    iterations: int
    local_maxima: int

    @property
    def cycles(self) -> int:
        """Clock cycles of the iterations alone: p + 2 each (section 5.4), whatever the size of the block."""
        return self.iterations * (self.precision + 2)


@dataclass(frozen=True, eq=False)
class VisitBatch:
    """Consecutive visits of one stage, in the order they are made.

    Attributes:
        stage_index: which stage of the schedule, from 0.
        precision: fractional bits p.
        block: int32, which block, counted in raster order.
        iterations: int32, iterations of each visit, 1..I.
    """

    stage_index: int
    precision: int
    block: NDArray[np.int32]
    iterations: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class StageEnd:
    """The end of a stage: its index in the schedule, what it took, and the field it left.

    ``fault``: why that field is not the one that the stage was to settle at; empty where it settled.
    """

    stage_index: int
    stage: Stage
    field: Field
    fault: str = ""
