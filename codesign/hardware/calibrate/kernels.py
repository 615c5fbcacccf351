"""A host's work beside planning, as compiled code (imported on first use), for timing only.

``enter_scan`` is the compiled twin of ``Belief.update`` (``system.scenarios.drive.world.belief``) with the scan of a
``RaySensor``, ``authority_ahead`` that of ``components.path.authority`` of a robot on its path. Tests hold the twins
together. Points and cells are as in ``components.path``.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from codesign.components.kernels import CORNER
from codesign.components.path import STANDING_ROOM

UNKNOWN, FREE, BLOCKED = 0, 1, 2


@njit(cache=True, nogil=True)
def measure_ranges(
    free: NDArray[np.bool_], y: float, x: float, limit: float, directions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The length of each ray from (y, x) up to the first cell that is not free: float64 k, cells; inf past ``limit``.

    Args:
        free: bool, rows × columns. directions: float64 k × 2, unit vectors (row, column).
    """
    ranges = np.full(directions.shape[0], np.inf)
    for ray in range(directions.shape[0]):
        down, along = directions[ray]
        row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
        row_step, column_step = (1 if down > 0.0 else -1), (1 if along > 0.0 else -1)
        a_row, a_column = 1.0 / (down if down != 0.0 else 1.0), 1.0 / (along if along != 0.0 else 1.0)
        # The ray is (y, x) + s (down, along), with its next borders at s = to_row and s = to_column.
        while True:
            to_row = (row + 0.5 * row_step - y) * a_row if down != 0.0 else np.inf
            to_column = (column + 0.5 * column_step - x) * a_column if along != 0.0 else np.inf
            reached = min(to_row, to_column)
            if reached > limit:
                break
            if to_row < to_column:
                row += row_step
            else:
                column += column_step
            if row < 0 or row >= free.shape[0] or column < 0 or column >= free.shape[1]:
                break
            if not free[row, column]:
                ranges[ray] = reached
                break
    return ranges


@njit(cache=True, nogil=True)
def enter_scan(
    believed: NDArray[np.int8],
    obstacles: NDArray[np.int32],
    risks: NDArray[np.int32],
    seen: NDArray[np.int32],
    turn: int,
    y: float,
    x: float,
    limit: float,
    ranges: NDArray[np.float64],
    directions: NDArray[np.float64],
    footprint: NDArray[np.int64],
) -> int:
    """Enter a scan into the map, and into the maps of the cells that the robot's middle may enter.

    Cells are free up to the end of their ray. The cell at its end is blocked where the end is within ``limit``.

    Args:
        believed: int8, rows × columns: ``UNKNOWN``, ``FREE`` or ``BLOCKED``; changed.
        obstacles, risks: int32, rows × columns: how many cells believed blocked, and how many not believed free, the
            robot would cover with its middle in each cell; changed.
        seen: int32, rows × columns: the last turn that saw each cell; changed. turn: this turn, above all entries.
        y, x, limit, ranges, directions: as for ``measure_ranges``.
        footprint: int64 n × 2, offsets of the cells that the robot covers.

    Returns:
        How many cells the scan saw.
    """
    rows, columns = believed.shape
    cells = 0
    for ray in range(directions.shape[0]):
        down, along = directions[ray]
        row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
        row_step, column_step = (1 if down > 0.0 else -1), (1 if along > 0.0 else -1)
        a_row, a_column = 1.0 / (down if down != 0.0 else 1.0), 1.0 / (along if along != 0.0 else 1.0)
        end, reached = min(ranges[ray], limit), 0.0
        while reached <= end and 0 <= row < rows and 0 <= column < columns:
            if seen[row, column] != turn:
                seen[row, column] = turn
                cells += 1
                now = BLOCKED if reached == ranges[ray] else FREE
                before = believed[row, column]
                if before != now:
                    believed[row, column] = now
                    _stamp(obstacles, row, column, footprint, (now == BLOCKED) - (before == BLOCKED))
                    _stamp(risks, row, column, footprint, (now != FREE) - (before != FREE))
            to_row = (row + 0.5 * row_step - y) * a_row if down != 0.0 else np.inf
            to_column = (column + 0.5 * column_step - x) * a_column if along != 0.0 else np.inf
            reached = min(to_row, to_column)
            if to_row < to_column:
                row += row_step
            else:
                column += column_step
    return cells


@njit(cache=True, nogil=True)
def _stamp(covers: NDArray[np.int32], row: int, column: int, footprint: NDArray[np.int64], change: int) -> None:
    if change == 0:
        return
    for index in range(footprint.shape[0]):
        there, across = row + footprint[index, 0], column + footprint[index, 1]
        if 0 <= there < covers.shape[0] and 0 <= across < covers.shape[1]:
            covers[there, across] += change


@njit(cache=True, nogil=True)
def authority_ahead(
    points: NDArray[np.float64], risks: NDArray[np.int32], y: float, x: float, lookahead: float
) -> float:
    """The distance that a robot at (y, x) on a path may drive along it: cells, at most ``lookahead``.

    The nearest point is searched on all segments of the path. From there, ``STANDING_ROOM`` is left before the first
    cell, other than the robot's own, that is not known to be free. At a corner both cells beside it must be free too.

    Args:
        points: float64 n × 2, n ≥ 2, (row, column), the path; no point repeats the previous one.
        risks: int32, rows × columns: 0 where the robot may be.
    """
    # On the segment from a to a + d the closest point to p is a + s d, with s = (p - a)·d / d·d clipped to 0..1.
    nearest, segment, share = np.inf, 0, 0.0
    for index in range(points.shape[0] - 1):
        down, along = points[index + 1, 0] - points[index, 0], points[index + 1, 1] - points[index, 1]
        part = ((y - points[index, 0]) * down + (x - points[index, 1]) * along) / (down * down + along * along)
        part = min(max(part, 0.0), 1.0)
        off = (points[index, 0] + part * down - y) ** 2 + (points[index, 1] + part * along - x) ** 2
        if off <= nearest:
            nearest, segment, share = off, index, part
    ahead = 0.0
    for index in range(segment, points.shape[0] - 1):
        begin = share if index == segment else 0.0
        down, along = points[index + 1, 0] - points[index, 0], points[index + 1, 1] - points[index, 1]
        length = np.sqrt(down * down + along * along)
        free = _free_along(points[index], down, along, length, begin, risks)
        if free < 1.0:
            return float(min(max(ahead + (free - begin) * length - STANDING_ROOM, 0.0), lookahead))
        ahead += (1.0 - begin) * length
        if ahead >= lookahead:
            return lookahead
    return ahead


@njit(cache=True, nogil=True)
def follow(points: NDArray[np.float64], risks: NDArray[np.int32], lookahead: float) -> float:
    """The sum of the authorities of commands from each point of a path, in one call from Python, cells."""
    total = 0.0
    for index in range(points.shape[0]):
        total += authority_ahead(points, risks, points[index, 0], points[index, 1], lookahead)
    return total


@njit(cache=True, nogil=True)
def _free_along(
    point: NDArray[np.float64], down: float, along: float, length: float, begin: float, risks: NDArray[np.int32]
) -> float:
    """The share of a segment, from ``begin``, at which it enters the first cell that is not free; 2 without one."""
    y, x = point[0] + begin * down, point[1] + begin * along
    row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
    last_row, last_column = int(np.floor(point[0] + down + 0.5)), int(np.floor(point[1] + along + 0.5))
    row_step, column_step = (1 if last_row > row else -1), (1 if last_column > column else -1)
    # The segment is point + s (down, along), with its next borders at s = to_row and s = to_column.
    while row != last_row or column != last_column:
        to_row = (row + 0.5 * row_step - point[0]) / down if row != last_row else np.inf
        to_column = (column + 0.5 * column_step - point[1]) / along if column != last_column else np.inf
        entry = min(to_row, to_column)
        if abs(to_row - to_column) * length <= CORNER:
            if _risky(risks, row + row_step, column) or _risky(risks, row, column + column_step):
                return entry
            row += row_step
            column += column_step
        elif to_row < to_column:
            row += row_step
        else:
            column += column_step
        if _risky(risks, row, column):
            return entry
    return 2.0


@njit(cache=True, nogil=True)
def _risky(risks: NDArray[np.int32], row: int, column: int) -> bool:
    return not (0 <= row < risks.shape[0] and 0 <= column < risks.shape[1]) or risks[row, column] != 0
