"""The non-dominated set over any number of objectives, exact."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_BLOCK = 512
_PIVOTS = 64
_FEW = 4096
_WORTHWHILE = 0.05
"""Points are pruned as long as a round of pivots removes this share of those that are left."""


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
    left = np.flatnonzero(~np.isnan(costs).any(axis=1))
    left = left[_pruned(costs[left])]
    rows = costs[left]
    # Equal rows stand or fall together.
    order = np.lexsort(rows.T[::-1]) if len(rows) else left
    rows = rows[order]
    first = np.ones(len(rows), dtype=bool)
    first[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    chosen = np.zeros(len(costs), dtype=bool)
    chosen[left[order]] = _distinct_front(rows[first])[np.cumsum(first) - 1]
    return chosen


def _pruned(rows: NDArray[np.float64]) -> NDArray[np.intp]:
    """The rows that are left when those that a few good ones dominate are removed: most, where there are many.

    What is good decides how many are left, not what is on the front.
    """
    left = np.arange(len(rows))
    score = _places(rows)
    while len(left) > _FEW:
        before = len(left)
        pivots = left[np.argpartition(score[left], _PIVOTS)[:_PIVOTS]]
        for pivot in pivots[np.argsort(score[pivots])]:
            left = left[~_dominated(rows, left, rows[pivot])]
        # The next round takes others.
        score[pivots] = np.iinfo(score.dtype).max
        if len(left) > (1 - _WORTHWHILE) * before:
            break
    return left


def _places(rows: NDArray[np.float64]) -> NDArray[np.int64]:
    """The sum of the places of each row among some rows, by objective: little for a good row, in whatever units."""
    some = np.sort(rows[:: max(1, len(rows) // 1000)], axis=0)
    places = np.zeros(len(rows), np.int64)
    for column, sample in zip(rows.T, some.T, strict=True):
        places += np.searchsorted(sample, column)
    return places


def _dominated(
    rows: NDArray[np.float64], left: NDArray[np.intp], pivot: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Which of the rows that are left the pivot dominates."""
    above = np.arange(len(left))
    for column, value in zip(rows.T, pivot, strict=True):
        above = above[column[left[above]] >= value]
    dominated = np.zeros(len(left), dtype=bool)
    dominated[above] = (rows[left[above]] > pivot).any(axis=1)
    return dominated


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


def dominators(values: ArrayLike, maximise: ArrayLike, front: ArrayLike) -> NDArray[np.int64]:
    """For each point the place in ``front`` of a point that dominates it; -1 where none does.

    Args:
        values: float64, points × objectives. maximise: see ``non_dominated``.
        front: float64, points × objectives, in any order.

    >>> dominators([[1, 5], [3, 3], [2, 2]], [False, False], [[1, 5], [2, 2]]).tolist()
    [-1, 1, -1]
    """
    signs = np.where(np.asarray(maximise, dtype=bool), -1.0, 1.0)
    costs, best = (np.asarray(each, np.float64).reshape(-1, len(signs)) * signs for each in (values, front))
    chosen = np.full(len(costs), -1, np.int64)
    left = np.flatnonzero(~np.isnan(costs).any(axis=1))
    # The front's good points first: they dominate most, and what is left is little.
    for place in np.argsort(_places(best), kind="stable") if len(best) else ():
        if not len(left):
            break
        dominated = _dominated(costs, left, best[place])
        chosen[left[dominated]] = place
        left = left[~dominated]
    return chosen
