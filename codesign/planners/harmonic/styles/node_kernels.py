"""The relaxation node after node, as styles ``software`` count it: one block over the map, integers of 64 bits.

The planner computes in bit planes, which skip what is settled (``plan.kernels``). A unit of the styles is a node's
update in a plain loop, so that loop is what ``hwsw calibrate host`` times. A test holds its field and its iterations
against the planner's.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def iterate(values: NDArray[np.int64], spare: NDArray[np.int64], movable: NDArray[np.bool_], most: int) -> Any:
    """Iterations until one changes no bit, which counts, or ``most``; returns their number.

    Args:
        values: int64, padded by a ring of 0; changed in place. spare: equal to ``values``. movable: bool, padded.
    """
    rows, columns = values.shape
    source, target, done = values, spare, 0
    while done < most:
        changed = np.int64(0)
        for i in range(1, rows - 1):
            for j in range(1, columns - 1):
                # h' = floor((N + E + S + W) / 4), section 4 of the paper.
                old = source[i, j]
                new = (source[i - 1, j] + source[i, j - 1] + source[i, j + 1] + source[i + 1, j]) >> 2
                new = new if movable[i, j] else old
                target[i, j] = new
                changed |= new ^ old
        source, target = target, source
        done += 1
        if changed == 0:
            break
    if done % 2:
        values[:] = spare
    return done


def relax_nodes(
    free: NDArray[np.bool_], goals: Sequence[tuple[int, int]], schedule: Sequence[int], most: int = 1 << 40
) -> tuple[NDArray[np.int64], list[int]]:
    """The field at the last precision, int64 rows × columns, and the iterations of each stage.

    ``schedule``: precisions of at most 60, as four values of 2^60 stay below 2^63. ``most``: iterations of a stage.
    """
    movable, values = np.pad(free, 1), np.zeros((free.shape[0] + 2, free.shape[1] + 2), np.int64)
    iterations, before = [], 0
    for row, column in goals:
        movable[row + 1, column + 1] = False
        values[row + 1, column + 1] = 1
    for precision in schedule:
        values <<= precision - before
        iterations.append(int(iterate(values, values.copy(), movable, most)))
        before = precision
    return values[1:-1, 1:-1].copy(), iterations
