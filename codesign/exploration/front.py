"""The non-dominated set over any number of objectives, exact."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_BLOCK = 512


def non_dominated(values: ArrayLike, maximise: ArrayLike) -> NDArray[np.bool_]:
    """Which points are on the front.

    A point is on the front if no other is at least as good in every objective and better in one; points
    with equal figures stand or fall together. A point with a missing figure (NaN) cannot be compared: it is
    not on the front and dominates no other.

    Args:
        values: float64, points × objectives.
        maximise: bool, one entry an objective; False is minimise.

    Returns:
        bool, one entry a point, in the order given.

    >>> non_dominated([[1, 5], [2, 2], [3, 3], [2, 2]], [False, False]).tolist()
    [True, True, False, True]
    """
    maximise = np.asarray(maximise, dtype=bool)
    costs = np.asarray(values, dtype=np.float64).reshape(-1, len(maximise))
    # The zero added makes -0.0 and 0.0 one value, so that they are one row below as well.
    costs = np.where(maximise, -costs, costs) + 0.0
    complete = ~np.isnan(costs).any(axis=1)
    chosen = np.zeros(len(costs), dtype=bool)
    if complete.any():
        distinct, which = np.unique(costs[complete], axis=0, return_inverse=True)
        chosen[complete] = _distinct_front(distinct)[which.reshape(-1)]
    return chosen


def _distinct_front(rows: NDArray[np.float64]) -> NDArray[np.bool_]:
    # Rows rise lexicographically and are distinct: none is dominated by a later one, so the front only grows.
    keep = np.zeros(len(rows), dtype=bool)
    front = np.empty((0, rows.shape[1]))
    for begin in range(0, len(rows), _BLOCK):
        block = rows[begin : begin + _BLOCK]
        alive = np.ones(len(block), dtype=bool)
        for start in range(0, len(front), _BLOCK):
            alive &= ~_at_most(front[start : start + _BLOCK], block).any(axis=0)
        candidates = block[alive]
        among = _at_most(candidates, candidates)
        np.fill_diagonal(among, False)
        alive[alive] = ~among.any(axis=0)
        keep[begin : begin + _BLOCK] = alive
        front = np.concatenate([front, block[alive]])
    return keep


def _at_most(left: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which rows of ``left`` are at most a row of ``right`` in every objective: bool, left × right."""
    result = np.ones((len(left), len(right)), dtype=bool)
    for objective in range(left.shape[1]):
        result &= left[:, None, objective] <= right[None, :, objective]
    return result
