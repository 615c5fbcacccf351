"""The potential of Nav2's NavFn and the path down its gradient, compiled (imported on first use).

After ``navfn.cpp`` and ``navfn.hpp`` of nav2_navfn_planner (BSD, Willow Garage 2008): ``setupNavFn``, ``initCost``,
``updateCell``, ``propNavFnDijkstra`` with ``atStart``, ``calcPath`` and ``gradCell``, in floats of 32 bits where the
source has them. The map has two costs, 50 for a free cell and 254 for an obstacle: nothing is inflated.
docs/grid_search.md lists what differs.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

NEUTRAL, OBSTACLE = np.float32(50.0), np.float32(254.0)
"""COST_NEUTRAL of a free cell; COST_OBS of an obstacle, and the first threshold."""

HIGH = np.float32(1.0e10)
"""POT_HIGH: the potential of a cell that the wave did not reach."""

BLOCK = 10_000
"""PRIORITYBUFSIZE: cells that a priority block holds; more are lost, as in NavFn."""

RISE = np.float32(100.0)
"""priInc: what the threshold rises by."""

NEAR = np.float32(0.707106781 * 50.0)
"""INVSQRT2 × cost: how far above a cell a neighbour must be to be looked at again."""


@njit(cache=True, nogil=True, inline="always")
def _updated(least: Any, other: Any) -> Any:
    """The potential of a free cell above its lowest neighbours in a column and in a row: a planar wave."""
    apart = other - least
    if apart < np.float32(0.0):
        apart, least = -apart, other
    if apart >= NEUTRAL:
        return least + NEUTRAL
    share = np.float64(apart / NEUTRAL)
    return least + NEUTRAL * np.float32(-0.2301 * share * share + 0.5307 * share + 0.7040)


@njit(cache=True, nogil=True, inline="always")
def _spread(cells: Any, values: Any, pending: Any, cell: int, sides: Any, block: Any, held: int) -> Any:
    """Put the neighbours that lie far enough above a cell into a block with ``held`` cells. Returns how many it holds.

    A neighbour that is an obstacle has another margin in the source, and is never put there.
    """
    for side in sides:
        near = cell + side
        waits = pending[near] or cells[near] == 0 or held >= BLOCK
        if not waits and values[near] > values[cell] + NEAR:
            block[held], pending[near] = near, True
            held += 1
    return held


@njit(cache=True, nogil=True)
def potential(cells: NDArray[np.uint8], stride: int, begin: int, ends: NDArray[np.int64]) -> Any:
    """The wave from ``begin`` until it reaches a cell of ``ends``, or is over.

    Args:
        cells: uint8, padded and flat, not 0 for a free cell. stride: length of a padded row.
        begin: the index of the robot's cell. ends: indices of the goals; none for the whole map.

    Returns:
        float32 potentials by cell, HIGH where the wave did not come; and the number of updates of a cell.
    """
    values, pending = np.full(cells.size, HIGH, np.float32), np.zeros(cells.size, np.bool_)
    current, following, over = np.empty(BLOCK, np.int32), np.empty(BLOCK, np.int32), np.empty(BLOCK, np.int32)
    sides = (-1, 1, -stride, stride)
    now, later, last, updates = 0, 0, 0, 0
    values[begin] = 0.0
    for side in (1, -1, -stride, stride):
        if cells[begin + side] != 0:
            current[now], pending[begin + side] = begin + side, True
            now += 1
    threshold = OBSTACLE
    # A cycle goes through the current block. Cells below the threshold go on in the next one, others wait in the block
    # that is over it.
    for _ in range(max(cells.size // 20, stride + cells.size // stride)):
        if now == 0 and later == 0:
            break
        for index in range(now):
            pending[current[index]] = False
        for index in range(now):
            cell = current[index]
            updates += 1
            left, right, up, down = values[cell - 1], values[cell + 1], values[cell - stride], values[cell + stride]
            value = _updated(min(up, down), min(left, right))
            if value < values[cell]:
                values[cell] = value
                if value < threshold:
                    later = _spread(cells, values, pending, cell, sides, following, later)
                else:
                    last = _spread(cells, values, pending, cell, sides, over, last)
        current, following, now, later = following, current, later, 0
        if now == 0:
            threshold += RISE
            current, over, now, last = over, current, last, 0
        for end in ends:
            if values[end] < HIGH:
                return values, updates
    return values, updates


@njit(cache=True, nogil=True, inline="always")
def _rounded(value: Any) -> Any:
    """The nearest integer, halves away from 0, as ``round`` of C."""
    return math.floor(value + 0.5) if value >= 0 else -math.floor(-value + 0.5)


@njit(cache=True, nogil=True)
def _gradient(values: Any, along: Any, across: Any, cell: int, stride: int) -> None:
    """``gradCell``: the unit vector downhill at a cell, kept in ``along`` (columns) and ``across`` (rows)."""
    if along[cell] + across[cell] > 0.0 or cell < stride or cell > values.size - stride:
        return
    here, right, down = values[cell], np.float32(0.0), np.float32(0.0)
    west, east, north, south = values[cell - 1], values[cell + 1], values[cell - stride], values[cell + stride]
    if here >= HIGH:
        right = -OBSTACLE if west < HIGH else OBSTACLE if east < HIGH else right
        down = -OBSTACLE if north < HIGH else OBSTACLE if south < HIGH else down
    else:
        right += west - here if west < HIGH else np.float32(0.0)
        right += here - east if east < HIGH else np.float32(0.0)
        down += north - here if north < HIGH else np.float32(0.0)
        down += here - south if south < HIGH else np.float32(0.0)
    norm = np.float32(math.sqrt(np.float64(right) * right + np.float64(down) * down))
    if norm > 0.0:
        norm = np.float32(1.0 / norm)
        along[cell], across[cell] = norm * right, norm * down


@njit(cache=True, nogil=True, inline="always")
def _between(values: Any, cell: int, stride: int, dx: Any, dy: Any) -> Any:
    """A value of the four cells from ``cell`` on, at (dx, dy) between them."""
    first = np.float32((1.0 - dx) * values[cell] + dx * values[cell + 1])
    second = np.float32((1.0 - dx) * values[cell + stride] + dx * values[cell + stride + 1])
    return np.float32((1.0 - dy) * first + dy * second)


@njit(cache=True, nogil=True, inline="always")
def _lowest(values: Any, cell: int, around: Any) -> Any:
    """The lowest of a cell and its neighbours; the least so far is kept as an int, as in the source."""
    least, lowest = int(values[cell]), cell
    for offset in around:
        if values[cell + offset] < least:
            least, lowest = int(values[cell + offset]), cell + offset
    return lowest


@njit(cache=True, nogil=True, inline="always")
def _carried(cell: int, off: Any, step: int) -> Any:
    """The cell and the offset from it, which is a cell at most."""
    if off > np.float32(1.0):
        return cell + step, off - np.float32(1.0)
    if off < np.float32(-1.0):
        return cell - step, off + np.float32(1.0)
    return cell, off


@njit(cache=True, nogil=True, inline="always")
def _follows_cells(values: Any, points: Any, count: int, cell: int, around: Any) -> Any:
    """True if one of the nine cells around has no potential, or the path is where it was two points ago."""
    stuck = values[cell] >= HIGH
    for offset in around:
        stuck = stuck or values[cell + offset] >= HIGH
    if stuck or count < 3:
        return stuck
    return points[count - 1, 0] == points[count - 3, 0] and points[count - 1, 1] == points[count - 3, 1]


@njit(cache=True, nogil=True)
def descend(values: NDArray[np.float32], stride: int, begin: int, end: int, most: int) -> Any:
    """``calcPath``: from the middle of ``begin`` down the gradient in half cells to ``end``, whose potential is 0.

    Where one of the nine cells around has no potential, or the path oscillates, it goes to the middle of the lowest of
    the eight neighbours.

    Returns:
        float32 n × 2 (row, column) in the padded map; 0 × 2 where ``most`` points do not suffice, or it is stuck.
    """
    points, count = np.empty((most, 2), np.float32), 0
    none = np.empty((0, 2), np.float32)
    along, across = np.zeros(values.size, np.float32), np.zeros(values.size, np.float32)
    around = (-stride - 1, -stride, -stride + 1, -1, 1, stride - 1, stride, stride + 1)
    cell, dx, dy, half = begin, np.float32(0.0), np.float32(0.0), np.float32(0.5)
    while count < most:
        near = max(0, min(values.size - 1, cell + _rounded(dx) + stride * _rounded(dy)))
        if values[near] < NEUTRAL:
            points[count, 0], points[count, 1] = end // stride, end % stride
            return points[: count + 1]
        if cell < stride or cell > values.size - stride:
            return none
        points[count, 0], points[count, 1] = np.float32(cell // stride) + dy, np.float32(cell % stride) + dx
        count += 1
        if _follows_cells(values, points, count, cell, around):
            cell, dx, dy = _lowest(values, cell, around), np.float32(0.0), np.float32(0.0)
            if values[cell] >= HIGH:
                return none
            continue
        for corner in (cell, cell + 1, cell + stride, cell + stride + 1):
            _gradient(values, along, across, corner, stride)
        right, down = _between(along, cell, stride, dx, dy), _between(across, cell, stride, dx, dy)
        if right == 0.0 and down == 0.0:
            return none
        pace = half / np.float32(math.sqrt(np.float64(right) * right + np.float64(down) * down))
        dx, dy = dx + right * pace, dy + down * pace
        cell, dx = _carried(cell, dx, 1)
        cell, dy = _carried(cell, dy, stride)
    return none


@njit(cache=True, nogil=True)
def from_cell_to_cell(values: NDArray[np.float32], cells: NDArray[np.uint8], stride: int, begin: int, end: int) -> Any:
    """From the middle of ``begin`` to ``end`` by the lowest neighbour that a step reaches without cutting a corner.

    Every cell with a potential has a lower one beside it, which the wave came from.

    Returns:
        int64 indices of the cells.
    """
    path, count, cell = np.empty(values.size, np.int64), 1, begin
    path[0] = begin
    while cell != end:
        lowest = cell
        for down in (-stride, 0, stride):
            for right in (-1, 0, 1):
                clear = cells[cell + down] != 0 and cells[cell + right] != 0
                if clear and cells[cell + down + right] != 0 and values[cell + down + right] < values[lowest]:
                    lowest = cell + down + right
        cell = lowest
        path[count] = cell
        count += 1
    return path[:count]
