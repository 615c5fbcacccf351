"""The distance of a robot from obstacles: over all of the path that it drove, and whatever moved towards it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from codesign.system.scenarios.drive.world import clearance_kernels

STEP = 0.1
"""Cells between two looks for the mean. The distance changes by no more than what is driven, so the mean is within
a quarter of this."""


class Clearance:
    """The distance from the robot's middle to the nearest obstacle of the true map, or to its rim, cells.

    Attributes:
        least: the least of all time, to rounding: over every piece of path in the world at that time, and at every
            change of the world.
    """

    def __init__(self) -> None:
        self.least = math.inf
        self._first: float | None = None
        self._driven = self._integral = 0.0

    @property
    def mean(self) -> float:
        """The mean over the length of the driven path; of a robot that never drove, that at its start."""
        if self._driven > 0.0:
            return self._integral / self._driven
        return math.inf if self._first is None else self._first

    def stand(self, free: NDArray[np.bool_], position: tuple[float, float]) -> None:
        """The robot is at ``position`` (row, column) in a world that is ``free`` (bool, rows × columns) from now on."""
        here = float(clearance_kernels.at_point(free, *position))
        self._first = here if self._first is None else self._first
        self.least = min(self.least, here)

    def drive(self, free: NDArray[np.bool_], points: NDArray[np.float64]) -> None:
        """The robot drove along ``points``, float64 n × 2, in a world that was ``free`` all the time."""
        if len(points) < 2:
            return
        self.least, integral = clearance_kernels.along_path(free, points, self.least, STEP)
        self._integral += integral
        self._driven += float(np.hypot(*np.diff(points, axis=0).T).sum())
