"""The grid in the order of its anti-diagonals, with a ring of obstacles around it.

A sweep in raster order needs the new values to the north and to the west, and the old values to the south and to the
east. For the anti-diagonal i + j = d the new values lie on d - 1 and the old values on d + 1. So the nodes of a
diagonal do not depend on each other. Side by side they are computed as vectors, with the arithmetic of the raster
order. Red nodes are the even diagonals, black nodes the odd ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Diagonals:
    """The places of nodes: node (i, j) of the padded grid lies at ``base[i + j] + i``.

    ``rows``, ``columns``: of the grid with its ring. ``base``: int64, one value a diagonal. ``position``: int64, rows ×
    columns, ``base[i + j] + i`` written out.
    """

    rows: int
    columns: int
    base: NDArray[np.int64]
    position: NDArray[np.int64]

    def pack(self, padded: NDArray[Any]) -> NDArray[Any]:
        """A padded array, rows × columns, in the order of the diagonals."""
        packed = np.empty(padded.size, padded.dtype)
        packed[self.position] = padded
        return packed


def diagonals(rows: int, columns: int) -> Diagonals:
    """The layout of a padded grid of ``rows`` × ``columns``.

    >>> diagonals(3, 3).position.tolist()
    [[0, 1, 3], [2, 4, 6], [5, 7, 8]]
    """
    number = np.arange(rows + columns - 1, dtype=np.int64)
    first_row = np.maximum(0, number - columns + 1)
    last_row = np.minimum(rows - 1, number)
    ends = np.cumsum(last_row - first_row + 1)
    base = np.concatenate([[0], ends[:-1]]).astype(np.int64) - first_row
    row, column = np.arange(rows, dtype=np.int64)[:, None], np.arange(columns, dtype=np.int64)[None, :]
    return Diagonals(rows, columns, base, base[row + column] + row)
