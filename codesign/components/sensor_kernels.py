"""Compiled casting of rays over a grid (imported on first use). The tests hold it against a plain reference."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from codesign.components.path_kernels import CORNER

UNSEEN, FREE, BLOCKED = 0, 1, 2


@njit(cache=True, nogil=True)
def cast(free: NDArray[np.bool_], y: float, x: float, reach: float, directions: NDArray[np.float64]) -> Any:
    """The cells that rays from (y, x) see: int64 n × 2 free ones and int64 m × 2 blocked ones, in raster order.

    Args:
        free: bool, rows × columns.
        y, x: row and column, in cells, inside the grid.
        reach: length of a ray, cells.
        directions: float64 k × 2, unit vectors (row, column).
    """
    # Only the square that rays can reach is stored, so that the cost does not grow with the map:
    #
    #   top, left +---------------+
    #             |   margin      |
    #             |     (y, x)    |   margin = ceil(reach) + 1
    #             +---------------+ bottom, right (excluded)
    rows, columns = free.shape
    row_of_robot, column_of_robot = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
    margin = int(np.ceil(reach)) + 1
    top, bottom = max(row_of_robot - margin, 0), min(row_of_robot + margin + 1, rows)
    left, right = max(column_of_robot - margin, 0), min(column_of_robot + margin + 1, columns)
    seen = np.zeros((bottom - top, right - left), np.int8)
    for ray in range(directions.shape[0]):
        _cast_ray(free, seen, top, left, y, x, reach, directions[ray, 0], directions[ray, 1])
    # Two passes over the square: the first counts the cells, the second lists them in raster order.
    count_free = count_blocked = 0
    for value in seen.flat:
        count_free += value == FREE
        count_blocked += value == BLOCKED
    free_cells, blocked_cells = np.empty((count_free, 2), np.int64), np.empty((count_blocked, 2), np.int64)
    count_free = count_blocked = 0
    for row in range(seen.shape[0]):
        for column in range(seen.shape[1]):
            if seen[row, column] == FREE:
                free_cells[count_free, 0], free_cells[count_free, 1] = row + top, column + left
                count_free += 1
            elif seen[row, column] == BLOCKED:
                blocked_cells[count_blocked, 0], blocked_cells[count_blocked, 1] = row + top, column + left
                count_blocked += 1
    return free_cells, blocked_cells


@njit(cache=True, nogil=True)
def _cast_ray(
    free: NDArray[np.bool_],
    seen: NDArray[np.int8],
    top: int,
    left: int,
    y: float,
    x: float,
    reach: float,
    down: float,
    along: float,
) -> None:
    rows, columns = free.shape
    row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
    row_step, column_step = (1 if down > 0.0 else -1), (1 if along > 0.0 else -1)
    while True:
        if row < 0 or row >= rows or column < 0 or column >= columns:
            return
        if not free[row, column]:
            seen[row - top, column - left] = BLOCKED
            return
        seen[row - top, column - left] = FREE
        # The ray is (y, x) + s (down, along). Cells are centred on whole coordinates, so borders lie at halves. The s
        # of the next border in each axis decides which cell is next (Amanatides and Woo 1987):
        #
        #       column + 0.5
        #   +--------|--------+
        #   |   .    |        |        to_row: s where y + s down = row ± 0.5
        #   +---'----|--------+  row + 0.5
        #   |      ' |        |        to_column: s where x + s along = column ± 0.5
        to_row = (row + 0.5 * row_step - y) / down if down != 0.0 else np.inf
        to_column = (column + 0.5 * column_step - x) / along if along != 0.0 else np.inf
        if min(to_row, to_column) > reach:
            return
        #    free    | blocked
        #   ---------+---------        The ray sees both blocked cells, and ends between them.
        #    blocked | behind
        if abs(to_row - to_column) <= CORNER:
            # Through a corner: no ray passes between two blocked cells that touch there.
            if _blocked(free, row + row_step, column) and _blocked(free, row, column + column_step):
                _mark(seen, rows, columns, top, left, row + row_step, column)
                _mark(seen, rows, columns, top, left, row, column + column_step)
                return
            row += row_step
            column += column_step
        elif to_row < to_column:
            row += row_step
        else:
            column += column_step


@njit(cache=True, nogil=True)
def _blocked(free: NDArray[np.bool_], row: int, column: int) -> bool:
    inside = 0 <= row < free.shape[0] and 0 <= column < free.shape[1]
    return not inside or not free[row, column]


@njit(cache=True, nogil=True)
def _mark(seen: NDArray[np.int8], rows: int, columns: int, top: int, left: int, row: int, column: int) -> None:
    if 0 <= row < rows and 0 <= column < columns:
        seen[row - top, column - left] = BLOCKED
