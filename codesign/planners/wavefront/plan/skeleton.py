"""The skeleton of a map: the crest of the distance from obstacles, computed in 5 × 5 neighbourhoods.

The paper says of its procedure that it is purely local, involves only the 5 × 5 neighbourhood of a node, and
detects all points at the crest of p^d. It does not say how. Here a free cell is on the crest if, along one of the four
axes through it (row, column, both diagonals), it is not below its two neighbours and above the two cells behind them.
The rule holds for ridges with a top of one cell and of two cells (corridors of even width).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

AXES = ((0, 1), (1, 0), (1, 1), (1, -1))
REACH = 2


def skeleton(obstacle_potentials: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Bool H×W: the cells on the crest of ``obstacle_potentials`` (int32 H×W, 0 on obstacles).

    The border cells are repeated outside of the map: p^d has no obstacle there, and so no crest against it.

    >>> distances = np.array([[0] * 6, [2] * 6, [4] * 6, [2] * 6, [0] * 6], dtype=np.int32)
    >>> np.flatnonzero(skeleton(distances).any(axis=1))
    array([2])
    """
    rows, columns = obstacle_potentials.shape
    padded = np.pad(obstacle_potentials, REACH, mode="edge")

    def seen(row: int, column: int) -> NDArray[np.int32]:
        return padded[REACH + row : REACH + row + rows, REACH + column : REACH + column + columns]

    crest = np.zeros((rows, columns), np.bool_)
    for row, column in AXES:
        beside = np.maximum(seen(row, column), seen(-row, -column))
        behind = np.maximum(seen(2 * row, 2 * column), seen(-2 * row, -2 * column))
        crest |= (obstacle_potentials >= beside) & (obstacle_potentials > behind)
    return crest & (obstacle_potentials > 0)
