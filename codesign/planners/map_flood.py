"""A flood over the free cells of a map on a processor: the loop of breadth-first search, whatever it is run for.

Its kernels are measured once, by the probes of breadth-first search.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CELL_KERNEL = "breadth_first_cell"
"""The unit of the loop: one popped cell with its four neighbours."""

MAP_KERNEL = "breadth_first_map_cell"
"""The unit of the preparation: one cell of the map, with its ring, its direction, and its copy in the plan."""

WALL_KERNEL = "breadth_first_wall_cell"
"""A popped cell beside an obstacle or the edge of the map, besides the unit of every popped cell."""


def beside_walls(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Bool, rows × columns: the cells with an obstacle or the edge of the map on one of their four sides.

    >>> int(beside_walls(np.ones((3, 3), np.bool_)).sum())
    8
    """
    padded = np.pad(free, 1)
    beside: NDArray[np.bool_] = ~(padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:])
    return beside
