"""Compiled stamping of a footprint (imported on first use)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def stamp(
    covers: NDArray[np.int32],
    blocked: NDArray[np.bool_],
    cells: NDArray[np.int64],
    footprint: NDArray[np.int64],
    by: int,
) -> None:
    """Add ``by`` to ``covers`` under the footprint around each of the cells; ``blocked`` follows: where it is above 0.

    Args:
        covers: int32, rows × columns, changed in place.
        blocked: bool, rows × columns, changed in place.
        cells: int64 n × 2.
        footprint: int64 m × 2 offsets.
        by: 1 or -1.
    """
    # The inflated map is the Minkowski sum of the obstacles and the footprint. How many obstacles cover a cell is
    # counted, so that one can be taken away again without looking at the others:
    #
    #   obstacles    covers         blocked
    #   . x . x .    1 1 2 1 1      x x x x x        footprint of three cells in a row; without the right one
    #   . x . . .    1 1 1 0 0      x x x . .        one of the two covers goes, and the middle stays blocked
    rows, columns = covers.shape
    for index in range(cells.shape[0]):
        for part in range(footprint.shape[0]):
            row, column = cells[index, 0] + footprint[part, 0], cells[index, 1] + footprint[part, 1]
            if 0 <= row < rows and 0 <= column < columns:
                covers[row, column] += by
                blocked[row, column] = covers[row, column] > 0
