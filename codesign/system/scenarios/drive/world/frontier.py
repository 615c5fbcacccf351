"""Frontiers (Yamauchi 1997): known free cells that border on unknown ones; the goals of an exploration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.maps.reach import reachable
from codesign.system.scenarios.drive.world.belief import Belief

Cell = tuple[int, int]


class Frontiers:
    """The frontier cells of an exploration, and those that turned out barren.

    A frontier cell can be reached through cells known to be free, and borders (by a side) on a cell that may be free
    but is not known to be, for the middle of the robot. Without a radius: a known free cell beside an unknown one.

    A cell is barren once the robot was in it, looked, and it is a frontier cell still: its sensor cannot see what is
    behind (rays too far apart, or too short a range). It is no goal again, so that every exploration ends.
    """

    def __init__(self, belief: Belief) -> None:
        self._belief = belief
        self._barren = np.zeros(belief.cells.shape, np.bool_)

    @property
    def barren(self) -> int:
        """The number of cells that were found barren."""
        return int(self._barren.sum())

    def mask(self, robot: Cell) -> NDArray[np.bool_]:
        """Bool, rows × columns: the frontier cells that the robot can reach from its cell, barren ones left out."""
        known_free = self._belief.known_free(robot)
        open_cells = self._belief.planning_free(robot) & ~known_free
        beside = np.zeros_like(known_free)
        beside[1:] |= open_cells[:-1]
        beside[:-1] |= open_cells[1:]
        beside[:, 1:] |= open_cells[:, :-1]
        beside[:, :-1] |= open_cells[:, 1:]
        candidates = known_free & beside & ~self._barren
        return candidates & reachable(known_free, [robot]) if candidates.any() else candidates

    def goals(self, robot: Cell) -> list[Cell]:
        """The cells of ``mask``, in raster order; none: all that can be reached is known."""
        return [(int(row), int(column)) for row, column in np.argwhere(self.mask(robot))]

    def looked(self, robot: Cell) -> bool:
        """The robot looked around from its cell, and the belief was updated; whether the cell turned out barren."""
        barren = bool(self.mask(robot)[robot])
        self._barren[robot] |= barren
        return barren
