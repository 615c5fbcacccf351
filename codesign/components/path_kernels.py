"""Compiled traversal of a polyline through the cells of a grid (imported on first use)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

CORNER = 1e-9
"""Cells: a line that passes a corner of four cells within this distance counts as passing through the corner."""


@njit(cache=True, nogil=True)
def crossings(points: NDArray[np.float64], arcs: NDArray[np.float64]) -> Any:
    """Every cell that a polyline enters, in order, the first cell included.

    After Amanatides and Woo (1987). Here the number of borders to cross follows from the two end cells, so rounding can
    neither skip the end cell nor pass it.

    Args:
        points: float64 n × 2, (row, column) in cells.
        arcs: float64 n, arc length at each of them, cells.

    Returns:
        entry: float64 m, arc length at which each cell is entered.
        cells: int64 m × 6: the cell, then the two cells beside the corner where it is entered through one (otherwise
        the cell itself, twice).
    """
    entry = np.empty(64)
    cells = np.empty((64, 6), np.int64)
    row, column = int(np.floor(points[0, 0] + 0.5)), int(np.floor(points[0, 1] + 0.5))
    entry[0] = arcs[0]
    cells[0] = np.array([row, column, row, column, row, column])
    used = 1
    for index in range(points.shape[0] - 1):
        y, x = points[index]
        down, along = points[index + 1, 0] - y, points[index + 1, 1] - x
        length = arcs[index + 1] - arcs[index]
        last_row = int(np.floor(points[index + 1, 0] + 0.5))
        last_column = int(np.floor(points[index + 1, 1] + 0.5))
        row_step, column_step = np.sign(last_row - row), np.sign(last_column - column)
        while row != last_row or column != last_column:
            # The segment is (y, x) + s (down, along). The next border between rows lies at s = to_row, that between
            # columns at s = to_column; above 1: no border of that kind is left.
            to_row = min(max((row + 0.5 * row_step - y) / down, 0.0), 1.0) if row != last_row else 2.0
            to_column = min(max((column + 0.5 * column_step - x) / along, 0.0), 1.0) if column != last_column else 2.0
            # Through a corner the segment touches both cells beside it, so they are reported with the cell that it
            # enters:
            #
            #   from      | in_row
            #   ----------+-------
            #   in_column | to
            corner = abs(to_row - to_column) * length <= CORNER
            in_column, in_row = (row + row_step, column), (row, column + column_step)
            if corner or to_row < to_column:
                row += row_step
            if corner or to_column < to_row:
                column += column_step
            if used == entry.size:
                larger_entry, larger_cells = np.empty(2 * used), np.empty((2 * used, 6), np.int64)
                larger_entry[:used], larger_cells[:used] = entry, cells
                entry, cells = larger_entry, larger_cells
            entry[used] = arcs[index] + min(to_row, to_column) * length
            cells[used, 0], cells[used, 1] = row, column
            if corner:
                cells[used, 2], cells[used, 3] = in_column
                cells[used, 4], cells[used, 5] = in_row
            else:
                cells[used, 2], cells[used, 3] = row, column
                cells[used, 4], cells[used, 5] = row, column
            used += 1
    return entry[:used].copy(), cells[:used].copy()


@njit(cache=True, nogil=True)
def first_closed(cells: NDArray[np.int64], grid: NDArray[np.bool_], is_open: bool, first: int, last: int) -> int:
    """Index of the first crossing, from ``first`` to before ``last``, into a closed cell or past a corner beside one.

    -1 where all are open. Cells outside of the grid are closed.

    Args:
        cells: as ``crossings`` returns them.
        grid: bool, rows × columns.
        is_open: the value that an open cell has in it.
        first, last: the range of crossings.
    """
    rows, columns = grid.shape
    for index in range(first, last):
        # The cell, then the two beside its corner; without a corner all three are the same cell.
        for part in range(0, 6, 2):
            row, column = cells[index, part], cells[index, part + 1]
            if row < 0 or row >= rows or column < 0 or column >= columns or grid[row, column] != is_open:
                return index
    return -1
