"""A floor plan of 330 × 270 cells, drawn for this purpose: the maps of Saudi and Sulaiman (2016) are not published.

Columns run along the 330, rows along the 270. Rooms lie above and below two corridors. Between the corridors lie a hall
with the goal and more rooms. The iterations of a map depend on its widest open space (a potential fixed on all walls
settles at the pace of its slowest mode, 1/height² + 1/width² of a hall). So the hall is sized to the Gauss-Seidel row
of Table I, its height by that estimate and its width by trial. No other row was used for the choice.
``workloads/maps/floor-plan.png`` is this map.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

ROWS, COLUMNS = 270, 330
WALL = 3
GOAL = (150, 60)
"""In the hall, as section V's "goal point": one goal for all starts."""

HALL_WIDTH = 200

_CORRIDORS = ((54, 72), (201, 219))
"""First and last + 1 row of the corridors along the plan."""

_DOORS = (
    ((54 - WALL, 54), (20, 60, 100, 150, 200, 250, 300)),
    ((72, 72 + WALL), (30, 130, 215, 290)),
    ((201 - WALL, 201), (60, 150, 230, 280)),
    ((219, 219 + WALL), (20, 75, 130, 190, 240, 300)),
)
"""Rows of a wall along a corridor, and the first columns of its doors."""

_DOOR = 12


def floor_plan(hall_width: int = HALL_WIDTH) -> NDArray[np.bool_]:
    """Bool 270 × 330, true where free; every free cell can be reached."""
    right = WALL + hall_width + WALL
    middle = (right + COLUMNS) // 2
    bands = (
        ((WALL, 54 - WALL), (WALL, 44, 84, 132, 180, 228, 276, COLUMNS)),
        ((72 + WALL, 201 - WALL), (WALL, right, middle, COLUMNS)),
        ((219 + WALL, ROWS - WALL), (WALL, 57, 112, 170, 222, 276, COLUMNS)),
    )
    free = np.zeros((ROWS, COLUMNS), np.bool_)
    for top, bottom in _CORRIDORS:
        free[top:bottom, WALL : COLUMNS - WALL] = True
    for (top, bottom), edges in bands:
        for left, end in pairwise(edges):
            free[top:bottom, left : end - WALL] = True
    for (top, bottom), doors in _DOORS:
        for left in doors:
            free[top:bottom, left : left + _DOOR] = True
    return free
