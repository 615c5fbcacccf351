"""The non-dominated set over any number of objectives, exact."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codesign.ground.numbering import distinct

_BITS = 64
_BLOCK = 256
"""Rows that are looked at together; a multiple of ``_BITS``."""
_GROUPS = 1024
_MOST_BYTES = 2**26
_WORDS_AT_ONCE = 2**18
_EVERY = slice(None)
_PIVOTS = 64
_FEW = 4096
_WORTHWHILE = 0.05
"""Points are pruned as long as a round of pivots removes this share of those that are left."""


def non_dominated(values: ArrayLike, maximise: ArrayLike) -> NDArray[np.bool_]:
    """The points on the front.

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
    # Equal rows stand or fall together. In lexicographic order they are neighbours: ``first`` begins each run of them,
    # and the sum of ``first`` up to a row, less 1, is the number of its run.
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
        # The rows with the least sums of places dominate most; each removes what it dominates, the best first.
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


def _dominated(rows: NDArray[np.float64], left: NDArray[np.intp], pivot: NDArray[np.float64]) -> NDArray[np.bool_]:
    """The rows among those left that the pivot dominates."""
    # At least as great as the pivot in every objective, and greater in one.
    above = np.arange(len(left))
    for column, value in zip(rows.T, pivot, strict=True):
        above = above[column[left[above]] >= value]
    dominated = np.zeros(len(left), dtype=bool)
    dominated[above] = (rows[left[above]] > pivot).any(axis=1)
    return dominated


def _distinct_front(rows: NDArray[np.float64]) -> NDArray[np.bool_]:
    """The rows that no other dominates, among distinct rows in lexicographic order.

    Only an earlier row can dominate one, and does where it is at most as great in all objectives but the first. The
    sets of rows that are at most as great are bits, so 64 rows are compared at once.
    """
    keep = np.ones(len(rows), dtype=bool)
    if rows.shape[1] < 2 or not len(rows):
        keep[1:] = False
        return keep
    sets = [_Below.of(column, len(rows)) for column in rows.T[1:]]
    earlier = np.packbits(np.tri(_BLOCK, k=-1, dtype=bool), axis=1, bitorder="little").view(np.uint64)
    for begin in range(0, len(rows), _BLOCK):
        # may[i]: the bits of rows before row begin + i that are at most as great in all objectives, or may be: values
        # of one group are not told apart. must[i]: the bits of rows that are so for certain.
        end = min(begin + _BLOCK, len(rows))
        words = slice(0, -(-end // _BITS))
        mask = earlier[: end - begin, : words.stop - begin // _BITS]
        may = _all([each.may(each.group[begin:end], words) for each in sets])
        may[:, words.stop - mask.shape[1] :] &= mask
        open_ = np.flatnonzero(may.any(axis=1))
        if not all(each.exact for each in sets):
            must = _all([each.must(each.group[begin + open_], words) for each in sets])
            must[:, words.stop - mask.shape[1] :] &= mask[open_]
            beaten = must.any(axis=1)
            keep[begin + open_[beaten]] = False
            left = open_[~beaten]
            pairs = ((left[place], number) for place, number in _bits_of(may[left]))
            open_ = np.concatenate([np.empty(0, np.intp), *(_not_greater(rows, begin, *each) for each in pairs)])
        keep[begin + open_] = False
    return keep


def _not_greater(
    rows: NDArray[np.float64], begin: int, place: NDArray[np.intp], number: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Those of the rows at ``begin + place`` that are at least as great as the row ``number`` beside them."""
    return place[(rows[number] <= rows[begin + place]).all(axis=1)]


@dataclass(frozen=True, eq=False)
class _Below:
    """The rows that are at most as great as a value, in one objective, as bits of words of 64.

    - ``below``: the rows in the groups before each group of values. ``values``: all, rising. ``group``: of each row.
    - ``exact``: whether each group is one value; otherwise only rows of an earlier group are known to be less.
    """

    below: NDArray[np.uint64]
    values: NDArray[np.float64]
    group: NDArray[np.intp]
    exact: bool

    @classmethod
    def of(cls, column: NDArray[np.float64], count: int) -> _Below:
        """Those of a column."""
        values, rank = distinct(column)
        words = -(-count // _BITS)
        groups = max(1, min(len(values), _GROUPS, _MOST_BYTES // (8 * words)))
        group = rank * groups // len(values)
        below = np.zeros((groups + 1, words), np.uint64)
        # below[g + 1] gets the bit of each row of group g; then the union of all groups up to it.
        number = np.arange(count)
        bits = np.left_shift(np.uint64(1), (number % _BITS).astype(np.uint64))
        np.bitwise_or.at(below, (group + 1, number // _BITS), bits)
        np.bitwise_or.accumulate(below, axis=0, out=below)
        return cls(below, values, group, groups == len(values))

    def groups_of(self, column: NDArray[np.float64]) -> NDArray[np.intp]:
        """The group of the greatest value that is at most as great, for each number; -1: there is none."""
        rank = np.searchsorted(self.values, column, side="right") - 1
        return np.asarray(rank * (len(self.below) - 1) // len(self.values), np.intp)

    def may(self, group: NDArray[np.intp], words: slice = _EVERY) -> NDArray[np.uint64]:
        """All rows that are at most as great as values of these groups, and others of the same group."""
        return self.below[group + 1, words]

    def must(self, group: NDArray[np.intp], words: slice = _EVERY) -> NDArray[np.uint64]:
        """Rows that are at most as great; not all, unless ``exact``."""
        return self.below[group + 1 if self.exact else np.maximum(group, 0), words]


def _all(sets: list[NDArray[np.uint64]]) -> NDArray[np.uint64]:
    """The members of all sets; the first one is overwritten."""
    common = sets[0]
    for each in sets[1:]:
        common &= each
    return common


def _first_bit(sets: NDArray[np.uint64]) -> NDArray[np.intp]:
    """The first number in each set; of an empty one, any."""
    word = np.argmax(sets != 0, axis=1)
    bits = np.unpackbits(sets[np.arange(len(sets)), word].view(np.uint8), bitorder="little")
    return np.asarray(word * _BITS + np.argmax(bits.reshape(-1, _BITS), axis=1), np.intp)


def _bits_of(sets: NDArray[np.uint64]) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Every number in every set, as pairs of the place of the set and the number; some at a time."""
    places, words = np.nonzero(sets)
    for begin in range(0, len(places), _WORDS_AT_ONCE // _BITS):
        place, word = (each[begin : begin + _WORDS_AT_ONCE // _BITS] for each in (places, words))
        bits = np.unpackbits(sets[place, word].view(np.uint8), bitorder="little").reshape(-1, _BITS)
        pair, bit = np.nonzero(bits)
        yield place[pair], word[pair] * _BITS + bit


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
    if not len(best):
        return chosen
    # The front's good points first: they dominate most, so that few stand for many.
    order = np.argsort(_places(best), kind="stable")
    best = best[order]
    sets = [_Below.of(column, len(best)) for column in best.T]
    whole = np.flatnonzero(~np.isnan(costs).any(axis=1))
    rows_at_once = max(_BLOCK, _WORDS_AT_ONCE // sets[0].below.shape[1])
    for begin in range(0, len(whole), rows_at_once):
        some = whole[begin : begin + rows_at_once]
        groups = [each.groups_of(column) for each, column in zip(sets, costs[some].T, strict=True)]
        may = _all([each.may(group) for each, group in zip(sets, groups, strict=True)])
        must = _all([each.must(group) for each, group in zip(sets, groups, strict=True)])
        # A point of the front that is at most as great for certain dominates, unless the two are equal. Of the others
        # each pair that may be one is compared in all objectives.
        found = np.where(must.any(axis=1), _first_bit(must), -1)
        found[(best[found] == costs[some]).all(axis=1)] = -1
        open_ = np.flatnonzero((found < 0) & may.any(axis=1))
        for place, number in _bits_of(may[open_]):
            mine, its = best[number], costs[some[open_[place]]]
            better = (mine <= its).all(axis=1) & (mine < its).any(axis=1)
            found[open_[place[better]]] = number[better]
        chosen[some] = np.where(found < 0, -1, order[found])
    return chosen
