"""The sweeps as plain loops, as the paper writes them: what the kernels are held against, bit for bit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from codesign.planners.relaxation.plan.parameters import Method

Doubles = NDArray[np.float64]
Cells = list[tuple[int, int]]

ORTHOGONAL = ((-1, 0), (0, -1), (0, 1), (1, 0))
DIAGONAL = ((-1, -1), (-1, 1), (1, -1), (1, 1))


def iterate(
    values: Doubles, movable: NDArray[np.bool_], method: Method, omega: float | None, r: float | None
) -> Doubles:
    """One iteration of ``method`` on a padded grid; returns the new values.

    Args:
        values: float64 rows × columns, with a ring of obstacles around.
        movable: bool of that shape, the nodes that are computed, in raster order.
    """
    cells = [(int(i), int(j)) for i, j in np.argwhere(movable)]
    if method is Method.JACOBI:
        return _sweep(values, values, values.copy(), cells, 1.0)
    if method in {Method.GS, Method.SOR}:
        new = values.copy()
        return _sweep(new, new, new, cells, omega or 1.0)
    if method is Method.RED_BLACK:
        new = values.copy()
        red = [cell for cell in cells if sum(cell) % 2 == 0]
        black = [cell for cell in cells if sum(cell) % 2]
        return _sweep(new, new, new, red + black, omega or 1.0)
    assert omega is not None
    around = DIAGONAL if method is Method.HALF_SWEEP_AM else ORTHOGONAL
    one, two = values.copy(), values.copy()
    _sweep(one, values, one, cells, omega, around, values)
    _sweep(values, two, two, cells[::-1], r or omega, around, values)
    return 0.5 * (one + two)


def _sweep(
    before: Doubles,
    after: Doubles,
    target: Doubles,
    cells: Cells,
    omega: float,
    around: tuple[tuple[int, int], ...] = ORTHOGONAL,
    own: Doubles | None = None,
) -> Doubles:
    """Write every cell of ``target``: two neighbours from ``before``, two from ``after``, in that order of ``around``.

    ``own`` holds the old value of the cell itself, ``target`` by default.
    """
    for i, j in cells:
        value: Callable[[int, Doubles], float] = lambda k, of, i=i, j=j: float(  # type: ignore[misc]  # noqa: E731
            of[i + around[k][0], j + around[k][1]]
        )
        total = (value(0, before) + value(1, before)) + (value(2, after) + value(3, after))
        old = float((target if own is None else own)[i, j])
        target[i, j] = omega / 4.0 * total + (1.0 - omega) * old
    return target
