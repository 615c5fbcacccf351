"""The search of Vacariu et al. (2008), Listing 1, in plain lines: what the kernel is held against."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NEIGHBOURS = ((-1, 0), (1, 0), (0, -1), (0, 1))
"""(row, column) steps in the paper's order: north, south, west, east (section 2.1)."""

NORTH, SOUTH, WEST, EAST = range(4)
UNKNOWN = -1
"""The direction of a cell that nothing discovered: not reached, or the start."""

Cell = tuple[int, int]


@dataclass(frozen=True)
class Trail:
    """What the state machine leaves in its memories.

    ``pushed``: every cell that entered the queue, in order. ``popped``: how many of them left it, the goal included.
    ``depth``: the most cells that waited in the queue at once. ``directions``: int8, on which side of a cell lies the
    one that discovered it. ``goal``: the goal that was popped, or None.
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
    popped, depth, found = 0, 1, None
    while queue:
        row, column = queue.popleft()
        popped += 1
        if (row, column) in goals:
            found = row, column
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
    return Trail(tuple(pushed), popped, depth, directions, found)


def mark_path(directions: NDArray[np.int8], goal: Cell) -> list[Cell]:
    """Listing 2: from the goal back to the start along the directions, then turned round."""
    way = [goal]
    while directions[way[-1]] != UNKNOWN:
        down, right = NEIGHBOURS[directions[way[-1]]]
        way.append((way[-1][0] + down, way[-1][1] + right))
    return way[::-1]
