"""Compiled ranges of rays over a grid (imported on first use). The tests hold them against a plain reference."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from codesign.components.path_kernels import CORNER


@njit(cache=True, nogil=True)
def ranges(
    free: NDArray[np.bool_], y: float, x: float, reach: float, directions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The length of each ray from (y, x), cells, to the side of the first blocked cell; infinite within ``reach``.

    The rays are the rays of ``components.kernels.cast``, with the same arguments.
    """
    rows, columns = free.shape
    lengths = np.full(directions.shape[0], np.inf)
    for ray in range(directions.shape[0]):
        down, along = directions[ray, 0], directions[ray, 1]
        row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
        row_step, column_step = (1 if down > 0.0 else -1), (1 if along > 0.0 else -1)
        length = 0.0
        while 0 <= row < rows and 0 <= column < columns:
            if not free[row, column]:
                lengths[ray] = length
                break
            to_row = (row + 0.5 * row_step - y) / down if down != 0.0 else np.inf
            to_column = (column + 0.5 * column_step - x) / along if along != 0.0 else np.inf
            length = min(to_row, to_column)
            if length > reach:
                break
            if abs(to_row - to_column) <= CORNER:
                # No ray passes between two blocked cells that touch at a corner.
                beside = 0 <= row + row_step < rows and free[row + row_step, column]
                below = 0 <= column + column_step < columns and free[row, column + column_step]
                if not beside and not below:
                    lengths[ray] = length
                    break
                row += row_step
                column += column_step
            elif to_row < to_column:
                row += row_step
            else:
                column += column_step
    return lengths
