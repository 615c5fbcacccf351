"""The search compiled (imported on first use): with a plain twin in the tests.

The map is flattened with a ring of obstacles around it, so that no neighbour needs a bounds check.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

BLOCKED, FREE, GOAL, WAITING_GOAL = 0, 1, 2, 3
"""Values of a cell of the padded map. On discovery a free cell becomes BLOCKED, and a goal WAITING_GOAL."""


@njit(cache=True, nogil=True)
def trail(cells: NDArray[np.uint8], start: int, stride: int) -> Any:
    """Search from ``start`` until a goal is popped or the queue is empty.

    Args:
        cells: uint8, padded and flattened: BLOCKED, FREE or GOAL. Overwritten.
        start: its index in ``cells``. stride: length of a padded row.

    Returns:
        queue (int32 indices of every pushed cell), pushed, popped, the greatest depth of the queue, directions (int8,
        -1 where nothing discovered the cell), the index of the goal or -1.
    """
    # Listing 1 of the paper. Each cell is pushed once at most, so the queue never wraps:
    #
    #   queue   | popped ..  | waiting ..        | unused
    #           0            popped              pushed           depth: the most that waited, pushed - popped
    queue = np.empty(cells.size, np.int32)
    directions = np.full(cells.size, -1, np.int8)
    # North, south, west, east: opposite sides are pairs, so that ``side ^ 1`` is the direction back.
    offsets = (-stride, stride, -1, 1)
    # "Visited" is marked when a cell is pushed, not when it is popped: else neighbours would push it again.
    cells[start] = WAITING_GOAL if cells[start] == GOAL else BLOCKED
    queue[0] = start
    popped, pushed, depth = 0, 1, 1
    while popped < pushed:
        cell = queue[popped]
        popped += 1
        # As in the listing, the goal ends the search when it is popped, not when it is found. The cycles
        # depend on that.
        if cells[cell] == WAITING_GOAL:
            return queue, pushed, popped, depth, directions, cell
        for side in range(4):
            neighbour = cell + offsets[side]
            if cells[neighbour] == FREE or cells[neighbour] == GOAL:
                cells[neighbour] = BLOCKED if cells[neighbour] == FREE else WAITING_GOAL
                directions[neighbour] = side ^ 1
                queue[pushed] = neighbour
                pushed += 1
        depth = max(depth, pushed - popped)
    return queue, pushed, popped, depth, directions, -1


@njit(cache=True, nogil=True)
def mark_path(directions: NDArray[np.int8], goal: int, stride: int) -> Any:
    """Int32 indices of the cells from the start to ``goal``, along the directions that ``trail`` left."""
    # Listing 2: from the goal back along the directions, once to count the steps and once to fill the path from its
    # end.
    offsets = (-stride, stride, -1, 1)
    steps = 0
    cell = goal
    while directions[cell] >= 0:
        cell += offsets[directions[cell]]
        steps += 1
    path = np.empty(steps + 1, np.int32)
    cell = goal
    for index in range(steps, -1, -1):
        path[index] = cell
        if directions[cell] >= 0:
            cell += offsets[directions[cell]]
    return path


@njit(cache=True, nogil=True)
def without_ring(indices: NDArray[np.int32], stride: int) -> Any:
    """Int32: the same cells, counted in the map without its ring of obstacles."""
    cells = np.empty(indices.size, np.int32)
    for index in range(indices.size):
        row, column = divmod(indices[index], stride)
        cells[index] = (row - 1) * (stride - 2) + column - 1
    return cells


@njit(cache=True, nogil=True)
def steps(pushed: NDArray[np.int32], directions: NDArray[np.int8]) -> Any:
    """Float64, rows × columns: steps from the start to each pushed cell, infinite elsewhere.

    ``pushed``: in their order, the start first. ``directions``: int8, rows × columns, without the ring of obstacles.
    """
    rows, columns = directions.shape
    offsets, sides = (-columns, columns, -1, 1), directions.ravel()
    counts = np.full(rows * columns, np.inf)
    counts[pushed[0]] = 0.0
    # A cell is pushed after the cell that discovered it, so that one has its count already.
    for index in range(1, pushed.size):
        cell = pushed[index]
        counts[cell] = counts[cell + offsets[sides[cell]]] + 1.0
    return counts.reshape(rows, columns)
