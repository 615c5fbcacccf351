"""The occupancy that the robot keeps on board, what it believes of the true map, and the frontiers of what it knows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.components.sensor import RangeScan
from codesign.ground.errors import InputError
from codesign.maps.reach import reachable
from codesign.system.scenarios.drive.world.inflation import Inflation

UNKNOWN, FREE, BLOCKED = 0, 1, 2
"""The belief about a cell."""

Cell = tuple[int, int]
Cells = NDArray[np.int64]
"""int64 n × 2, (row, column)."""


@dataclass(frozen=True, eq=False)
class Update:
    """The change by a scan: cells (int64 n × 2) that are now believed blocked, and cells that are now believed free."""

    newly_blocked: Cells
    newly_free: Cells

    @property
    def changed(self) -> Cells:
        """All of them."""
        return np.concatenate((self.newly_blocked, self.newly_free))

    def __bool__(self) -> bool:
        return bool(len(self.newly_blocked) or len(self.newly_free))


class Belief:
    """Unknown, free or blocked, for each cell; a cell keeps what was last seen of it. Outside of the map is blocked.

    Two maps follow from it, both for the middle of the robot: the optimistic ``planning_free``, in which unknown cells
    count as free, and ``known_free``, the cells through which the robot may be given authority.

    Args:
        rows, columns: of the map.
        known: bool, rows × columns, true where free: a map known from the start; None: nothing is known.
        unknown: bool, rows × columns: cells that ``known`` says nothing of; None: it covers all.
        radius_cells: of the robot.

    Attributes:
        cells: int8, rows × columns, read-only: ``UNKNOWN``, ``FREE`` or ``BLOCKED``.

    Raises:
        InputError: a known map of another size.
    """

    def __init__(
        self,
        rows: int,
        columns: int,
        known: NDArray[np.bool_] | None = None,
        *,
        unknown: NDArray[np.bool_] | None = None,
        radius_cells: float = 0.0,
    ) -> None:
        shape = (rows, columns)
        for name, mask in (("known", known), ("unknown", unknown)):
            if mask is not None and mask.shape != shape:
                raise InputError(f"{name} of shape {mask.shape} for a map of {rows} × {columns} cells", name)
        self._cells = np.full(shape, UNKNOWN, np.int8)
        if known is not None:
            self._cells[:] = np.where(known, FREE, BLOCKED)
            if unknown is not None:
                self._cells[unknown] = UNKNOWN
        self.cells = self._cells.view()
        self.cells.flags.writeable = False
        self._obstacles = Inflation(self._cells == BLOCKED, radius_cells)
        self._risks = Inflation(self._cells != FREE, radius_cells)

    def update(self, scan: RangeScan) -> Update:
        """Believe what was seen; what changed by it."""
        free, blocked = scan.free, scan.blocked
        before_free = self._cells[free[:, 0], free[:, 1]]
        before_blocked = self._cells[blocked[:, 0], blocked[:, 1]]
        newly_free, newly_blocked = free[before_free != FREE], blocked[before_blocked != BLOCKED]
        self._cells[newly_free[:, 0], newly_free[:, 1]] = FREE
        self._cells[newly_blocked[:, 0], newly_blocked[:, 1]] = BLOCKED
        self._obstacles.change(newly_blocked, free[before_free == BLOCKED])
        self._risks.change(blocked[before_blocked == FREE], newly_free)
        return Update(newly_blocked, newly_free)

    def planning_free(self, robot: Cell | None = None) -> NDArray[np.bool_]:
        """Bool, rows × columns, a copy: not believed blocked for the robot's middle. ``robot``, its cell, is free."""
        return _with(~self._obstacles.blocked, robot)

    def known_free(self, robot: Cell | None = None) -> NDArray[np.bool_]:
        """Bool, rows × columns, a copy: all that the robot's body would cover, were its middle there, is known free.

        ``robot``, its cell, is free.
        """
        return _with(~self._risks.blocked, robot)

    @property
    def blocked_for_robot(self) -> NDArray[np.bool_]:
        """Bool, rows × columns, a view: cells believed blocked for the robot's middle."""
        return self._obstacles.blocked

    @property
    def known_share(self) -> float:
        """Share of the cells that are known."""
        return float(np.count_nonzero(self._cells) / self._cells.size)


def _with(free: NDArray[np.bool_], cell: Cell | None) -> NDArray[np.bool_]:
    if cell is not None:
        free[cell] = True
    return free


class Frontiers:
    """The frontier cells (Yamauchi 1997) of an exploration, its goals, and those that turned out barren.

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
