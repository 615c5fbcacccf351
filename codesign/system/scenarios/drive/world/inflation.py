"""Obstacles grown by the robot's radius: where the middle of a disc may be (its configuration space)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.system.scenarios.drive.world import inflation_kernels

_ROUNDING = 1e-9


class Inflation:
    """Cells that the middle of a robot may not enter, kept up to date cell by cell.

    A cell is blocked if it is an obstacle, or if a disc of ``radius`` cells somewhere in it could overlap one:
    its square lies nearer than ``radius`` to the square of an obstacle cell, or to the outside of the map. Wherever
    in its cell the robot is, its body is clear. The price of planning in cells: every radius above 0 keeps the robot
    out of all cells beside an obstacle, and out of gaps that a robot driving along their middle might pass.

    Args:
        obstacles: bool, rows × columns.
        radius: cells.

    Attributes:
        blocked: bool, rows × columns, a view that changes with ``change``.

    Raises:
        InputError: a radius below 0 or not finite.
    """

    def __init__(self, obstacles: NDArray[np.bool_], radius: float) -> None:
        if not (math.isfinite(radius) and radius >= 0.0):
            raise InputError(f"a radius of {radius} cells", "radius", "give 0 or more")
        self.radius = radius
        self.footprint = footprint(radius)
        self._grows = len(self.footprint) > 1
        rows, columns = obstacles.shape
        if not self._grows:
            self.blocked = obstacles.copy()
            return
        # The outside counts once for each cell that is too near to it: it never leaves.
        edge = np.minimum.outer(np.minimum(np.arange(rows), np.arange(rows)[::-1]), np.full(columns, rows + columns))
        edge = np.minimum(edge, np.minimum(np.arange(columns), np.arange(columns)[::-1]))
        self._covers = (edge < radius - _ROUNDING).astype(np.int32) + _counts(obstacles, self.footprint)
        self.blocked = self._covers > 0

    def change(self, appeared: NDArray[np.int64], gone: NDArray[np.int64]) -> None:
        """Obstacle cells appeared, others are gone: int64 n × 2 each, cells that changed and no others."""
        if not self._grows:
            self.blocked[appeared[:, 0], appeared[:, 1]] = True
            self.blocked[gone[:, 0], gone[:, 1]] = False
            return
        inflation_kernels.stamp(self._covers, self.blocked, appeared, self.footprint, 1)
        inflation_kernels.stamp(self._covers, self.blocked, gone, self.footprint, -1)


def _counts(obstacles: NDArray[np.bool_], footprint: NDArray[np.int64]) -> NDArray[np.int32]:
    """The number of obstacle cells under the footprint around each cell: int32, rows × columns.

    A row of the footprint is one run of cells, as wide to the left as to the right. The obstacles under it are a
    difference of two running sums, so that the time grows with the footprint's rows, not with its cells.
    """
    rows, columns = obstacles.shape
    reach = int(footprint[:, 1].max())
    sums = np.zeros((rows, reach + columns + 1 + reach), np.int32)
    sums[:, reach + 1 : reach + 1 + columns] = np.cumsum(obstacles, axis=1)
    sums[:, reach + 1 + columns :] = sums[:, reach + columns, None]
    counts = np.zeros((rows, columns), np.int32)
    for down in range(max(-reach, 1 - rows), min(reach, rows - 1) + 1):
        half = int(footprint[footprint[:, 0] == down, 1].max())
        right, left = reach + half + 1, reach - half
        run = sums[:, right : right + columns] - sums[:, left : left + columns]
        counts[max(-down, 0) : rows - max(down, 0)] += run[max(down, 0) : rows - max(-down, 0)]
    return counts


def footprint(radius: float) -> NDArray[np.int64]:
    """Offsets (row, column) of the obstacle cells that block a cell, itself included: int64 n × 2.

    >>> footprint(0.0).tolist()
    [[0, 0]]
    >>> len(footprint(0.5)), len(footprint(1.0)), len(footprint(1.1)), len(footprint(1.5))
    (9, 9, 21, 25)
    """
    reach = math.ceil(radius)
    side = np.arange(-reach, reach + 1)
    gap = np.maximum(np.abs(side) - 1.0, 0.0)
    near = np.hypot(gap[:, None], gap) < radius - _ROUNDING
    near[reach, reach] = True
    return np.argwhere(near) - reach
