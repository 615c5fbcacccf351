"""Sweeps of Gauss-Seidel for a board without the package: diagonal after diagonal, with NumPy alone.

The arithmetic of ``plan.kernels.in_place_sweeps`` in another program, which Python 3.7 runs too: every diagonal is some
calls of NumPy, and the cost of ``relaxation_diagonal`` then holds them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

_GOAL = -(2.0**1000)
_STEPS = ((-1, 0), (0, 1), (1, 0), (0, -1), (-1, 1), (1, 1), (1, -1), (-1, -1))


def plan(free: Any, goal: Any, _start: Any, max_iterations: int, **_others: Any) -> int:
    """Units of the sweeps: cells times iterations. ``free``: bool, rows × columns; ``goal``: (row, column)."""
    sweeps(free, goal, max_iterations)
    return int(free.size) * max_iterations


def sweeps(free: Any, goal: Any, count: int) -> tuple[Any, Any]:
    """The potential after some sweeps, float64 with its ring, and the side of the lowest neighbour of each cell."""
    rows, columns = free.shape[0] + 2, free.shape[1] + 2
    movable, values = np.zeros((rows, columns), bool), np.zeros((rows, columns))
    movable[1:-1, 1:-1] = free
    movable[goal[0] + 1, goal[1] + 1] = False
    values[goal[0] + 1, goal[1] + 1] = _GOAL
    # Node (i, j) lies at base[i + j] + i: the nodes of a diagonal side by side.
    number = np.arange(rows + columns - 1)
    first = np.maximum(0, number - columns + 1)
    base = np.concatenate([[0], np.cumsum(np.minimum(rows - 1, number) - first + 1)[:-1]]) - first
    place = base[np.add.outer(np.arange(rows), np.arange(columns))] + np.arange(rows)[:, None]
    packed, free_to_move = np.empty(values.size), np.empty(values.size, bool)
    packed[place], free_to_move[place] = values, movable
    for _ in range(count):
        for d in range(2, rows + columns - 3):
            low, high = max(1, d - columns + 2), min(rows - 2, d - 1) + 1
            here, north, south = base[d], base[d - 1], base[d + 1]
            above, below = packed[north + low - 1 : north + high], packed[south + low : south + high + 1]
            new = 0.25 * ((above[:-1] + above[1:]) + (below[:-1] + below[1:]))
            np.copyto(packed[here + low : here + high], new, where=free_to_move[here + low : here + high])
    values = packed[place]
    sides = [values[1 + y : rows - 1 + y, 1 + x : columns - 1 + x] for y, x in _STEPS]
    return values, np.argmin(np.stack(sides), axis=0)
