"""The searches compiled (imported on first use), and the sums of ``potential``. Tests have each in plain lines.

A cell of the flat, padded map has a state: 0 for an obstacle, else FREE, OPEN (in the heap) or CLOSED.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from codesign.planners.grid_search.plan.parameters import (
    ANY,
    CLOSED,
    DIAGONAL,
    EUCLIDEAN,
    FREE,
    NONE,
    OPEN,
    STRAIGHT,
    TIE_BITS,
    TIE_SHIFT,
)

MOST_TIE = (1 << TIE_BITS) - 1
MOST_PUSHED = 8
"""Entries that one expansion adds at most."""
ROOT_TWO = math.sqrt(2.0)

DOWN, RIGHT = (-1, 1, 0, 0, -1, -1, 1, 1), (0, 0, -1, 1, -1, 1, -1, 1)
"""Rows and columns of a step to each side, as ``parameters.STEPS``."""


@njit(cache=True, nogil=True)
def padded(free: NDArray[np.bool_]) -> Any:
    """Uint8: the map with a ring of obstacles, flat."""
    rows, columns = free.shape
    cells = np.zeros((rows + 2) * (columns + 2), np.uint8)
    for row in range(rows):
        first = (row + 1) * (columns + 2) + 1
        for column in range(columns):
            cells[first + column] = free[row, column]
    return cells


# A binary heap: two arrays, the least key first, of equal keys the least item. The entries below ``size`` are in order.


@njit(cache=True, nogil=True, inline="always")
def _rise(keys: Any, items: Any, hole: Any, key: Any, item: Any) -> None:
    """Put an entry into the hole, or above it."""
    while hole > 0:
        parent = (hole - 1) >> 1
        if keys[parent] < key or (keys[parent] == key and items[parent] <= item):
            break
        keys[hole], items[hole] = keys[parent], items[parent]
        hole = parent
    keys[hole], items[hole] = key, item


@njit(cache=True, nogil=True)
def with_room(keys: Any, items: Any, size: Any) -> Any:
    """The arrays; twice as long where they have no room for ``MOST_PUSHED`` entries after ``size`` of them."""
    if size + MOST_PUSHED <= keys.size:
        return keys, items
    longer_keys, longer_items = np.empty(2 * keys.size, keys.dtype), np.empty(2 * keys.size, items.dtype)
    longer_keys[:size], longer_items[:size] = keys[:size], items[:size]
    return longer_keys, longer_items


@njit(cache=True, nogil=True)
def drop(keys: Any, items: Any, size: Any) -> None:
    """Remove the first entry, which leaves ``size``. The hole sinks to a leaf; the last entry rises from there."""
    hole, child = 0, 1
    while child < size:
        other = child + 1
        if other < size and (keys[other] < keys[child] or (keys[other] == keys[child] and items[other] < items[child])):
            child = other
        keys[hole], items[hole] = keys[child], items[child]
        hole, child = child, 2 * child + 1
    _rise(keys, items, hole, keys[size], items[size])


@njit(cache=True, nogil=True)
def heap_sort(keys: Any, held: Any) -> Any:
    """All keys through a heap that holds ``held`` of them: what one entry costs. Returns the last that left it."""
    heap, items, size, last = np.empty(1024, np.int64), np.empty(1024, np.int32), 0, 0
    for index in range(keys.size):
        heap, items = with_room(heap, items, size)
        _rise(heap, items, size, keys[index], index)
        size += 1
        if size > held:
            last, size = heap[0], size - 1
            drop(heap, items, size)
    return last


# Lengths are sums of STRAIGHT and DIAGONAL; an estimate is never above the length that is left.


@njit(cache=True, nogil=True, inline="always")
def estimate(rows: Any, columns: Any, heuristic: Any) -> Any:
    """The least length between cells that lie so many rows and columns apart; 0 without a heuristic."""
    if heuristic == NONE:
        return 0
    if heuristic == EUCLIDEAN:
        # Floor(STRAIGHT √square): the root in doubles is off by one at most, and the difference of squares, which is
        # small, is right though each square overflows.
        square = rows * rows + columns * columns
        root = np.int64(STRAIGHT * math.sqrt(square))
        rest = STRAIGHT * STRAIGHT * square - root * root
        return root - 1 if rest < 0 else root + 1 if rest > 2 * root else root
    return STRAIGHT * abs(rows - columns) + DIAGONAL * min(rows, columns)


@njit(cache=True, nogil=True)
def _straight(cells: Any, cell: Any, step: Any, across: Any, target: Any, cutting: bool) -> Any:
    """The next jump point in a line, or -1, and how many cells were looked at. ``across``: to the side of the line."""
    looked = 0
    left, right = cells[cell - across] != 0, cells[cell + across] != 0
    while True:
        cell += step
        looked += 1
        before_left, before_right = left, right
        left, right = cells[cell - across] != 0, cells[cell + across] != 0
        # Forced: an obstacle beside this cell with a free one behind it; where no corner is cut, a free cell beside
        # this one with an obstacle before it.
        if cutting:
            forced = (not left and cells[cell + step - across] != 0) or (not right and cells[cell + step + across] != 0)
        else:
            forced = (left and not before_left) or (right and not before_right)
        if forced or cell == target:
            return cell, looked
        if cells[cell + step] == 0:
            return -1, looked


@njit(cache=True, nogil=True)
def _diagonal(cells: Any, cell: Any, down: Any, right: Any, target: Any, cutting: bool) -> Any:
    """The next jump point on a diagonal, or -1, and how many cells were looked at."""
    looked = 0
    while True:
        cell += down + right
        looked += 1
        if cell == target:
            return cell, looked
        below, beside = cells[cell + down] != 0, cells[cell + right] != 0
        beyond = cells[cell + down + right] != 0
        if cutting and (
            (cells[cell - down] == 0 and cells[cell - down + right] != 0)
            or (cells[cell - right] == 0 and cells[cell - right + down] != 0)
        ):
            return cell, looked
        if below:
            found, more = _straight(cells, cell, down, right, target, cutting)
            looked += more
            if found >= 0:
                return cell, looked
        if beside:
            found, more = _straight(cells, cell, right, down, target, cutting)
            looked += more
            if found >= 0:
                return cell, looked
        if not beyond or not (cutting or (below and beside)):
            return -1, looked


@njit(cache=True, nogil=True, inline="always")
def _mask(cells: Any, cell: Any, offsets: Any) -> Any:
    """The free neighbours of a cell, a bit for each side."""
    mask = 0
    for side in range(8):
        mask |= (cells[cell + offsets[side]] != 0) << side
    return mask


@njit(cache=True, nogil=True, inline="always")
def _jump(cells: Any, cell: Any, side: Any, stride: Any, target: Any, cutting: bool) -> Any:
    """The next jump point to ``side`` of a cell, or -1, and how many cells were looked at."""
    if side < 4:
        step, across = DOWN[side] * stride + RIGHT[side], 1 if side < 2 else stride
        return _straight(cells, cell, step, across, target, cutting)
    return _diagonal(cells, cell, DOWN[side] * stride, RIGHT[side], target, cutting)


@njit(cache=True, nogil=True, inline="always")
def _key(length: Any, left: Any) -> Any:
    """The key of a cell with ``length`` behind it and an estimate of ``left``: of equal sums the nearer goes first."""
    return ((length + left) << TIE_BITS) | min(left >> TIE_SHIFT, MOST_TIE)


@njit(cache=True, nogil=True)
def _open(cells: Any, sources: Any, keys: Any, items: Any, first: Any) -> Any:
    """The heap with every source once, with the keys ``first``: its arrays and its size."""
    size = 0
    for index in range(sources.size):
        source = sources[index]
        if cells[source] == FREE:
            cells[source] = OPEN
            keys, items = with_room(keys, items, size)
            _rise(keys, items, size, first[index], source)
            size += 1
    return keys, items, size


@njit(cache=True, nogil=True)
def astar(
    cells: Any, stride: Any, sources: Any, target: Any, heuristic: Any, successors: Any, cutting: bool, jumping: bool
) -> Any:
    """A* from the goals, as ``search`` explains.

    Args:
        cells: uint8, padded and flat; overwritten: a cell that was expanded is CLOSED.
        stride: length of a padded row. sources: their indices. target: its index, or -1.
        heuristic: OCTILE, EUCLIDEAN or NONE.
        successors: uint8 9 × 256, of ``search.successors(cutting)``.

    Returns:
        end (the target, or -1), lengths (int64, valid where a cell is not FREE), before (int32, as lengths), expanded,
        entries, looked.
    """
    row, column = (target // stride, target % stride) if target >= 0 else (0, 0)
    rule = heuristic if target >= 0 else NONE
    # Only cells that entered the heap have a length: so there is nothing to clear.
    lengths, before = np.empty(cells.size, np.int64), np.empty(cells.size, np.int32)
    came = np.empty(cells.size, np.uint8)
    offsets = np.array((-stride, stride, -1, 1, -stride - 1, -stride + 1, stride - 1, stride + 1))
    first = np.empty(sources.size, np.int64)
    for index in range(sources.size):
        source = sources[index]
        lengths[source], before[source], came[source] = 0, source, ANY
        first[index] = _key(0, estimate(abs(source // stride - row), abs(source % stride - column), rule))
    keys, items, size = _open(cells, sources, np.empty(1024, np.int64), np.empty(1024, np.int32), first)
    expanded, looked, entries = 0, 0, size
    while size > 0:
        cell = np.int64(items[0])
        size -= 1
        drop(keys, items, size)
        if cells[cell] == CLOSED:
            continue
        cells[cell] = CLOSED
        if cell == target:
            return target, lengths, before, expanded, entries, looked
        expanded += 1
        if size + MOST_PUSHED > keys.size:
            keys, items = with_room(keys, items, size)
        here = cell // stride
        there = cell - here * stride
        allowed = successors[came[cell], _mask(cells, cell, offsets)]
        for side in range(8):
            if allowed >> side & 1 == 0:
                continue
            near, steps = cell + offsets[side], 1
            if jumping:
                near, more = _jump(cells, cell, side, stride, target, cutting)
                looked += more
                if near < 0:
                    continue
                steps = (near - cell) // offsets[side]
            if cells[near] == CLOSED:
                continue
            length = lengths[cell] + steps * (STRAIGHT if side < 4 else DIAGONAL)
            if cells[near] == OPEN and length >= lengths[near]:
                continue
            lengths[near], before[near], came[near], cells[near] = length, cell, side, OPEN
            left = estimate(abs(here + steps * DOWN[side] - row), abs(there + steps * RIGHT[side] - column), rule)
            _rise(keys, items, size, _key(length, left), near)
            size, entries = size + 1, entries + 1
    return -1, lengths, before, expanded, entries, looked


@njit(cache=True, nogil=True)
def way(before: Any, cell: Any, stride: Any, exact: bool) -> Any:
    """Float64 n × 2: (row, column) in the map without its ring, from a cell along ``before`` to its end.

    The points of a piece lie a cell apart, or a little less; ``exact``: pieces of whole steps along rows, columns and
    diagonals.
    """
    points, count, at = np.empty((64, 2)), 0, cell
    while True:
        row, column, ahead = at // stride, at % stride, np.int64(before[at])
        down, right = ahead // stride - row, ahead % stride - column
        pieces = max(abs(down), abs(right)) if exact else math.ceil(math.sqrt(down * down + right * right))
        pieces = max(1, pieces)
        while count + pieces > len(points):
            longer = np.empty((2 * len(points), 2))
            longer[:count] = points[:count]
            points = longer
        for piece in range(pieces):
            share = piece / pieces
            points[count, 0], points[count, 1] = row - 1 + share * down, column - 1 + share * right
            count += 1
        if ahead == at:
            return points[:count].copy()
        at = ahead


@njit(cache=True, nogil=True)
def in_sight(cells: Any, stride: Any, begin: Any, end: Any) -> Any:
    """Whether the cells of Bresenham's line, and both beside its diagonal steps, are free; how many were asked."""
    row, column, last_row, last_column = begin // stride, begin % stride, end // stride, end % stride
    down, right = abs(last_row - row), abs(last_column - column)
    down_step, right_step = (stride if last_row > row else -stride), (1 if last_column > column else -1)
    cell, error, looked = begin, right - down, 0
    while cell != end:
        looked += 1
        if cells[cell] == 0:
            return False, looked
        twice = 2 * error
        if twice > -down and twice <= right:
            if cells[cell + right_step] == 0 or cells[cell + down_step] == 0:
                return False, looked
            cell, error = cell + right_step + down_step, error + right - down
        elif twice > -down:
            cell, error = cell + right_step, error - down
        else:
            cell, error = cell + down_step, error + right
    return True, looked


@njit(cache=True, nogil=True, inline="always")
def _apart(cell: Any, other: Any, stride: Any) -> Any:
    """The straight line between two cells."""
    rows, columns = cell // stride - other // stride, cell % stride - other % stride
    return math.sqrt(rows * rows + columns * columns)


@njit(cache=True, nogil=True)
def theta_star(cells: Any, stride: Any, sources: Any, target: Any) -> Any:
    """Lazy theta* as Nav2's ``ThetaStar``. Arguments and results as of ``astar``, with lengths in cells (float64)."""
    lengths, through = np.empty(cells.size), np.empty(cells.size)
    before = np.empty(cells.size, np.int32)
    offsets = np.array((-stride, stride, -1, 1, -stride - 1, -stride + 1, stride - 1, stride + 1))
    first = np.empty(sources.size)
    for index in range(sources.size):
        source = sources[index]
        lengths[source], before[source] = 0.0, source
        first[index] = through[source] = _apart(source, target, stride)
    keys, items, size = _open(cells, sources, np.empty(1024), np.empty(1024, np.int32), first)
    expanded, looked, entries = 0, 0, size
    while size > 0:
        key, cell = keys[0], np.int64(items[0])
        size -= 1
        drop(keys, items, size)
        if key > through[cell]:
            continue
        cells[cell] = CLOSED
        if cell == target:
            return target, lengths, before, expanded, entries, looked
        expanded += 1
        if size + MOST_PUSHED > keys.size:
            keys, items = with_room(keys, items, size)
        beyond = np.int64(before[before[cell]])
        seen, count = in_sight(cells, stride, cell, beyond)
        looked += count
        straight = lengths[beyond] + _apart(cell, beyond, stride)
        if seen and straight < lengths[cell]:
            lengths[cell], before[cell] = straight, beyond
            through[cell] = straight + _apart(cell, target, stride)
        for side in range(8):
            near = cell + offsets[side]
            if cells[near] == 0:
                continue
            if side >= 4 and (cells[cell + DOWN[side] * stride] == 0 or cells[cell + RIGHT[side]] == 0):
                continue
            length = lengths[cell] + (1.0 if side < 4 else ROOT_TWO)
            total = length + _apart(near, target, stride)
            if cells[near] == FREE or total < through[near]:
                cells[near] = max(cells[near], OPEN)
                lengths[near], before[near], through[near] = length, cell, total
                _rise(keys, items, size, total, near)
                size, entries = size + 1, entries + 1
    return -1, lengths, before, expanded, entries, looked
