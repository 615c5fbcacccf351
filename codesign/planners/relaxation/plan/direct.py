"""The potential from one sparse factorisation by SciPy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.maps.reach import reachable

MAX_DIRECT_CELLS = 1 << 20
"""Cells of the largest accepted map: the factors of a million unknowns hold about a gigabyte."""


def solve_direct(
    free: NDArray[np.bool_], goals: NDArray[np.int64], wall: float, goal: float
) -> tuple[NDArray[np.float64], int, int]:
    """The potential, float64 rows × columns, the number of unknowns, and of values in the factors.

    Unknowns are the free cells that a path joins to a goal. The other free cells are surrounded by obstacles, and take
    their value. The potential is ``wall`` + the solution of the case 0 and ``goal`` − ``wall``. In that case small
    values keep their leading digits, as the factorisation of such a matrix subtracts nothing.
    """
    from scipy import sparse
    from scipy.sparse.linalg import splu

    cells = [(int(row), int(column)) for row, column in goals]
    unknown = np.pad(reachable(free, cells), 1)
    above = np.zeros(unknown.shape)
    for row, column in cells:
        unknown[row + 1, column + 1] = False
        above[row + 1, column + 1] = goal - wall
    count, values = int(unknown.sum()), 0
    if count:
        number = np.full(unknown.shape, -1, np.int32)
        number[unknown] = np.arange(count, dtype=np.int32)
        right = np.zeros(count)
        rows, columns = [np.arange(count, dtype=np.int32)], [np.arange(count, dtype=np.int32)]
        data = [np.full(count, 4.0)]
        for axis, by in ((0, 1), (0, -1), (1, 1), (1, -1)):
            beside = np.roll(number, by, axis)[unknown]
            right += np.roll(above, by, axis)[unknown]
            inner = beside >= 0
            rows.append(np.flatnonzero(inner).astype(np.int32))
            columns.append(beside[inner])
            data.append(np.full(int(inner.sum()), -1.0))
        matrix = sparse.csc_matrix(
            (np.concatenate(data), (np.concatenate(rows), np.concatenate(columns))), shape=(count, count)
        )
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        above[unknown], values = factors.solve(right), int(factors.nnz)
    potential = wall + above[1:-1, 1:-1]
    return np.ascontiguousarray(potential), count, values
