"""Breadth-first search on a grid, exactly as the state machine of Vacariu et al. (2008) runs it.

A cell is marked as visited when it is pushed, so it enters the queue once; the search ends when the goal is popped,
not when it is discovered. Neighbours are looked at north, south, west, east: that order decides which of several
shortest paths is found, and how many cells are popped before the goal.
"""

from __future__ import annotations

import operator
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.maps.grid import as_free
from codesign.maps.reach import check_cells

NEIGHBOURS = ((-1, 0), (1, 0), (0, -1), (0, 1))
"""(row, column) steps in the paper's order: north, south, west, east (section 2.1)."""

NORTH, SOUTH, WEST, EAST = range(4)
UNKNOWN = -1
"""The direction of a cell without a discoverer: the start, or a cell that was not reached."""

Cell = tuple[int, int]


kernels = late("codesign.planners.breadth_first.plan.kernels")


@dataclass(frozen=True, eq=False)
class BreadthFirstPlan:
    """The outcome of a search.

    Attributes:
        start: the first cell.
        goal: the goal that was popped; None where none can be reached.
        path: int32 n × 2, (row, column) from start to goal; 0 × 2 where there is none.
        pushed: int32, row × columns + column of every cell that entered the queue, in order.
        popped_cells: the number of cells that left the queue, the goal included: the executed nodes of the paper.
        queue_depth: the most cells in the queue at once.
        directions: int8 rows × columns, the side (0..3 = north, south, west, east) of a cell on which its discoverer
            lies; -1 at the start and where the search did not reach.
        everywhere: True if it is a search from a goal until the queue was empty (``search_everywhere``). Then the
            directions lead from every cell to that goal, and ``path`` is the goal alone.
    """

    start: Cell
    goal: Cell | None
    path: NDArray[np.int32]
    pushed: NDArray[np.int32]
    popped_cells: int
    queue_depth: int
    directions: NDArray[np.int8]
    everywhere: bool = False

    @property
    def reached(self) -> bool:
        """True if a goal was popped."""
        return self.goal is not None

    @cached_property
    def order(self) -> NDArray[np.int32]:
        """Int32 popped × 2: (row, column) of the popped cells, in the order of popping."""
        cells = np.divmod(self.pushed[: self.popped_cells], np.int32(self.directions.shape[1]))
        return np.stack(cells, axis=1)

    @property
    def pushed_cells(self) -> int:
        """Cells that entered the queue."""
        return len(self.pushed)

    @property
    def path_steps(self) -> int | None:
        """Steps of the path, the fewest on the grid; None where there is no path."""
        return len(self.path) - 1 if self.reached else None

    @property
    def spreading(self) -> int:
        """Cells that entered the queue and are not on the path (section 2.2)."""
        return self.pushed_cells - len(self.path)


def search(free: NDArray[np.bool_], start: Cell, goal: Cell) -> BreadthFirstPlan:
    """Search from ``start`` until ``goal`` is popped. Linear in the cells of the map.

    Args:
        free: bool, rows × columns; outside of the map is obstacle.
        start, goal: (row, column) of free cells.

    A goal that cannot be reached is an answer, "No solution" in the paper: ``reached`` is False, the path empty.

    Raises:
        MapError: the map is unusable, or start or goal lies outside of it or on an obstacle.

    >>> free = np.array([[True, True, True], [True, False, True]])
    >>> plan = search(free, (1, 0), (1, 2))
    >>> plan.path.tolist(), plan.popped_cells, plan.spreading
    ([[1, 0], [0, 0], [0, 1], [0, 2], [1, 2]], 5, 0)
    """
    return search_nearest(free, start, [goal])


def search_everywhere(free: NDArray[np.bool_], goal: Cell) -> BreadthFirstPlan:
    """The search from ``goal`` until the queue is empty: its directions lead from every cell back to the goal.

    Raises:
        MapError: see ``search``.

    >>> free = np.array([[True, True, True], [True, False, True]])
    >>> plan = search_everywhere(free, (1, 2))
    >>> plan.directions.tolist(), plan.popped_cells
    ([[3, 3, 1], [0, -1, -1]], 5)
    """
    return _search(free, goal, ())


def search_nearest(free: NDArray[np.bool_], start: Cell, goals: Iterable[Cell]) -> BreadthFirstPlan:
    """``search`` for the first of several goals to be popped, which is one of the nearest.

    Raises:
        MapError: see ``search``; also where there is no goal.
    """
    check_cells(as_free(free, "free"), goals := tuple(goals), where="goal")
    return _search(free, start, goals)


def _search(free: NDArray[np.bool_], start: Cell, goals: tuple[Cell, ...]) -> BreadthFirstPlan:
    """The search until one of ``goals`` is popped; without goals until the queue is empty, from the goal ``start``."""
    free = as_free(free, "free")
    origin = check_cells(free, [start], name="start", where="start")[0]
    ends = np.array(goals, np.int64).reshape(-1, 2)
    rows, columns = free.shape
    stride = columns + 2
    cells = np.zeros((rows + 2, stride), np.uint8)
    cells[1:-1, 1:-1] = free
    cells[ends[:, 0] + 1, ends[:, 1] + 1] = kernels.GOAL
    first = operator.index((origin[0] + 1) * stride + origin[1] + 1)
    queue, pushed, popped, depth, directions, goal = kernels.trail(cells.ravel(), first, stride)
    goal = goal if goals else first
    path = kernels.mark_path(directions, goal, stride) if goal >= 0 else queue[:0]
    path = np.stack(np.divmod(path, np.int32(stride)), axis=1) - np.int32(1)
    return BreadthFirstPlan(
        start=(int(origin[0]), int(origin[1])),
        goal=(int(path[-1, 0]), int(path[-1, 1])) if len(path) else None,
        path=path,
        pushed=kernels.without_ring(queue[:pushed], stride),
        popped_cells=int(popped),
        queue_depth=int(depth),
        directions=directions.reshape(rows + 2, stride)[1:-1, 1:-1].copy(),
        everywhere=not goals,
    )
