"""The rays of a sensor in a few plain lines, to hold ``kernels.cast`` against."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from codesign.components.kernels import CORNER
from codesign.components.path import Point, cell_of
from codesign.components.sensor import RangeScan


def cast_reference(
    free: NDArray[np.bool_], position: Point, reach: float, directions: NDArray[np.float64]
) -> RangeScan:
    """The result of ``kernels.cast``."""
    seen_free: set[tuple[int, int]] = set()
    seen_blocked: set[tuple[int, int]] = set()

    def inside(cell: tuple[int, int]) -> bool:
        return cell[0] in range(free.shape[0]) and cell[1] in range(free.shape[1])

    for down, along in directions.tolist():
        row, column = cell_of(position)
        row_step, column_step = (1 if down > 0 else -1), (1 if along > 0 else -1)
        while inside((row, column)):
            if not free[row, column]:
                seen_blocked.add((row, column))
                break
            seen_free.add((row, column))
            to_row = (row + 0.5 * row_step - position[0]) / down if down else math.inf
            to_column = (column + 0.5 * column_step - position[1]) / along if along else math.inf
            if min(to_row, to_column) > reach:
                break
            corner = abs(to_row - to_column) <= CORNER
            beside = [(row + row_step, column), (row, column + column_step)]
            if corner and not any(inside(cell) and bool(free[cell]) for cell in beside):
                seen_blocked.update(cell for cell in beside if inside(cell))
                break
            row += row_step if corner or to_row < to_column else 0
            column += column_step if corner or to_row >= to_column else 0
    shape = (-1, 2)
    return RangeScan(
        np.array(sorted(seen_free), np.int64).reshape(shape), np.array(sorted(seen_blocked), np.int64).reshape(shape)
    )
