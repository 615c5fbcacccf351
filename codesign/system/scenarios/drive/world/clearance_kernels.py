"""Compiled distances from points and segments to the nearest obstacle (imported on first use)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def at_point(free: NDArray[np.bool_], row: float, column: float) -> float:
    """Distance from a point to the nearest blocked cell (a square), or to the rim of the map, cells."""
    rows, columns = free.shape
    least: float = min(row + 0.5, column + 0.5, rows - 0.5 - row, columns - 0.5 - column)
    middle_row, middle_column = int(np.floor(row + 0.5)), int(np.floor(column + 0.5))
    ring = 0
    # Cells of ring k lie at least k - 1 from a point of the middle cell.
    while ring - 1 < least and ring <= max(rows, columns):
        top, bottom = middle_row - ring, middle_row + ring
        for i in range(max(top, 0), min(bottom, rows - 1) + 1):
            step = 1 if i in (top, bottom) else max(2 * ring, 1)
            for j in range(middle_column - ring, middle_column + ring + 1, step):
                if 0 <= j < columns and not free[i, j]:
                    down, along = max(abs(i - row) - 0.5, 0.0), max(abs(j - column) - 0.5, 0.0)
                    least = min(least, np.hypot(down, along))
        ring += 1
    return float(least)


@njit(cache=True, nogil=True)
def _to_segment(y: float, x: float, y0: float, x0: float, y1: float, x1: float) -> float:
    """Distance from a point to a segment."""
    down, along = y1 - y0, x1 - x0
    square = down * down + along * along
    share = 0.0 if square == 0.0 else min(max(((y - y0) * down + (x - x0) * along) / square, 0.0), 1.0)
    return float(np.hypot(y0 + share * down - y, x0 + share * along - x))


@njit(cache=True, nogil=True)
def along_path(free: NDArray[np.bool_], points: NDArray[np.float64], least: float, step: float) -> tuple[float, float]:
    """The least distance to a blocked cell or the rim along a polyline, and the integral of that distance over it.

    The first is exact, and never above ``least``, the least known before. The nearest points of two convex figures that
    do not meet lie at an end or corner of one of them: an end of the segment and the square, or a corner of the
    square and the segment. The second is by the trapezoid rule with steps of at most ``step`` cells.

    Args:
        free: bool, rows × columns.
        points: float64 n × 2, n ≥ 2, outside of blocked cells.
        least: cells.
        step: cells.
    """
    rows, columns = free.shape
    total = 0.0
    for index in range(len(points) - 1):
        y0, x0 = points[index]
        y1, x1 = points[index + 1]
        length = np.hypot(y1 - y0, x1 - x0)
        parts = max(1, int(np.ceil(length / step)))
        before = at_point(free, y0, x0)
        least = min(least, before)
        for part in range(1, parts + 1):
            share = part / parts
            here = at_point(free, y0 + share * (y1 - y0), x0 + share * (x1 - x0))
            total += 0.5 * (before + here) * length / parts
            before = here
            least = min(least, here)
        # Whatever lies nearer than the least so far has a corner in this box.
        first_row = max(int(np.ceil(min(y0, y1) - least - 0.5)), 0)
        last_row = min(int(np.floor(max(y0, y1) + least + 0.5)), rows - 1)
        first_column = max(int(np.ceil(min(x0, x1) - least - 0.5)), 0)
        last_column = min(int(np.floor(max(x0, x1) + least + 0.5)), columns - 1)
        for i in range(first_row, last_row + 1):
            for j in range(first_column, last_column + 1):
                if free[i, j]:
                    continue
                for y in (i - 0.5, i + 0.5):
                    for x in (j - 0.5, j + 0.5):
                        least = min(least, _to_segment(y, x, y0, x0, y1, x1))
    return least, total
