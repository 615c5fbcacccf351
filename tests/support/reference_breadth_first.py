"""The search of Vacariu et al. (2008), Listings 1 and 2, in plain lines: the reference of the kernel."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.planners.breadth_first.plan.search import NEIGHBOURS, UNKNOWN, Cell


@dataclass(frozen=True)
class Trail:
    """The contents of the memories of the state machine after a search.

    ``pushed``: every cell that entered the queue, in order. ``popped``: the number of cells that left it, the goal
    included. ``depth``: the most cells in the queue at once. ``directions``: int8, the side of a cell on which its
    discoverer lies. ``goal``: the goal that was popped, or None.
    """

    pushed: tuple[Cell, ...]
    popped: int
    depth: int
    directions: NDArray[np.int8]
    goal: Cell | None


def trail(free: NDArray[np.bool_], start: Cell, goals: tuple[Cell, ...]) -> Trail:
    """Listing 1: pop, compare with the goal, look at the neighbours, push those not visited."""
    rows, columns = free.shape
    visited = np.zeros(free.shape, np.bool_)
    directions = np.full(free.shape, UNKNOWN, np.int8)
    queue = deque([start])
    pushed = [start]
    visited[start] = True
    popped, depth, reached = 0, 1, None
    while queue:
        row, column = queue.popleft()
        popped += 1
        if (row, column) in goals:
            reached = row, column
            break
        for side, (down, right) in enumerate(NEIGHBOURS):
            cell = row + down, column + right
            inside = 0 <= cell[0] < rows and 0 <= cell[1] < columns
            if inside and free[cell] and not visited[cell]:
                visited[cell] = True
                directions[cell] = side ^ 1
                queue.append(cell)
                pushed.append(cell)
        depth = max(depth, len(queue))
    return Trail(tuple(pushed), popped, depth, directions, reached)


def mark_path(directions: NDArray[np.int8], goal: Cell) -> list[Cell]:
    """Listing 2: from the goal back to the start along the directions, then turned round."""
    path = [goal]
    while directions[path[-1]] != UNKNOWN:
        down, right = NEIGHBOURS[directions[path[-1]]]
        path.append((path[-1][0] + down, path[-1][1] + right))
    return path[::-1]
