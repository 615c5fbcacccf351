"""The gradient descent search placed by itself, on a processor."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.relaxation.plan.parameters import RelaxParameters
from codesign.planners.relaxation.plan.planner import PLANNER
from codesign.planners.relaxation.styles.costs import SEARCH_UNITS
from codesign.planners.relaxation.styles.host import SEARCH
from codesign.planners.styles import HostTask, Step, one_step


class HostSearch(HostTask):
    """Two units for each step of the path, as in the styles of the whole planner. Assumed."""

    planner = "relaxation"
    task = SEARCH
    description = "from cell to cell, each time to the lowest neighbour"
    kernel = "relaxation_node_update"

    def outcome(self, job: Job[Problem, RelaxParameters]) -> tuple[int, tuple[NDArray[np.float64], bool]]:
        """The path from the position."""
        points, arrived = PLANNER.path_from(job.problem, job.plan, job.position)
        return SEARCH_UNITS * max(1, len(points) - 1), (points, arrived)

    def again(self, _job: Job[Problem, RelaxParameters], /) -> Generator[Step, None, None]:
        """The next cell alone, as only that cell is sent."""
        yield one_step(self.task, SEARCH_UNITS)


TASK_STYLES = (HostSearch(),)
