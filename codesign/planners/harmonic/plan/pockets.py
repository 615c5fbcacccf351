"""Pockets: free cells from which no path leads to a goal. Their values stay 0, so each is a local maximum for ever."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.maps.reach import reachable
from codesign.planners.harmonic.plan.parameters import Pockets, RelaxParameters
from codesign.planners.interface import MapWork, Problem
from codesign.planners.map_flood import CELL_KERNEL, MAP_KERNEL, WALL_KERNEL, beside_walls

FILL = "fill pockets"
"""The work of the sender, in records and terms."""


def sent_map(problem: Problem, parameters: RelaxParameters) -> NDArray[np.bool_]:
    """The free cells of the map as it is sent to the planner: bool, rows × columns.

    With ``pockets: filled`` the sender turns pockets into obstacles. No value of any other cell depends on that.
    """
    if parameters.pockets is Pockets.KEPT:
        return problem.free

    return reachable(problem.free, problem.goals)


def fill_work(problem: Problem, parameters: RelaxParameters) -> tuple[MapWork, ...]:
    """The work of the sender that fills the pockets: a flood from the goals; none where it sends the map as it is.

    The flood pops every cell with a path to a goal once. What it leaves is sent as an obstacle.
    """
    if parameters.pockets is Pockets.KEPT:
        return ()
    reached = sent_map(problem, parameters)
    walls = int((reached & beside_walls(problem.free)).sum())
    return (
        MapWork(FILL, MAP_KERNEL, problem.free.size),
        MapWork(FILL, CELL_KERNEL, int(reached.sum())),
        MapWork(FILL, WALL_KERNEL, walls),
    )
