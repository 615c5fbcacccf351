"""The tracking of the wavefront planner placed by itself: on a processor, as in the paper."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.architectures.host_task import HostTask
from codesign.architectures.wavefront.steps import tracked_steps
from codesign.planners.interface import Problem
from codesign.planners.wavefront.parameters import PropagateParameters
from codesign.planners.wavefront.plan import WavefrontPlan
from codesign.planners.wavefront.planner import PLANNER
from codesign.planners.ways import cell_of


class HostTracking(HostTask):
    """A unit for each step of the way, as in style ``software``: eight neighbours are looked at. Assumed."""

    planner = "wavefront"
    task = "track"
    description = "the way by the rule of Dreyfus, eight neighbours a step"
    kernel = "wavefront_cell"

    def outcome(
        self,
        problem: Problem,
        parameters: PropagateParameters,
        plan: WavefrontPlan,
        position: tuple[float, float],
    ) -> tuple[int, tuple[NDArray[np.float64], bool]]:
        """The way from the position; a local course costs its first steps only."""
        cell = cell_of(problem, position)
        units = 1 if cell is None else tracked_steps(problem, parameters, plan, cell)
        return units, PLANNER.way(problem, plan, position)


TASK_STYLES = (HostTracking(),)
