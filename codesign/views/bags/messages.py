"""ROS messages made of what a run records: poses in metres, grids with the lowest row first, times in nanoseconds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.frame import Frame
from codesign.views.bags.library import Types

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Cells of an OccupancyGrid, as map_server writes them in its mode ``trinary``."""

MAP = "map"
"""The frame of the map. In a run, odometry has no error, so frame ``odom`` is the same."""

INFORMATION, WARNING = 20, 30
"""Levels of rcl_interfaces/Log."""


@dataclass(frozen=True)
class Floor:
    """Where cells lie in metres. ``row``, ``column``: the first cell of the map, as records count cells."""

    frame: Frame
    row: int = 0
    column: int = 0

    def point(self, row: float, column: float) -> tuple[float, float]:
        """(x, y) of a place in cells."""
        return self.frame.point(row - self.row, column - self.column)

    def yaw(self, heading: float) -> float:
        """The yaw of a heading, radians. A heading turns from growing columns to growing rows, a yaw from x to y."""
        return wrapped(self.frame.origin[2] - heading)


def wrapped(angle: float) -> float:
    """The angle in [-π, π).

    >>> wrapped(0.5), wrapped(math.pi)
    (0.5, -3.141592653589793)
    """
    if -math.pi <= angle < math.pi:
        return angle
    return (angle + math.pi) % (2 * math.pi) - math.pi


class Messages:
    """Makes messages. ``begin``: nanoseconds that are added to every time."""

    def __init__(self, begin: int = 0) -> None:
        self.types = Types()
        self._begin = begin
        self._still = np.zeros(36)

    def nanoseconds(self, time: int) -> int:
        """The time of a message: ps since the begin of the run, rounded down to ns."""
        return self._begin + time // 1000

    def stamp(self, time: int) -> Any:
        """A time as ROS has it."""
        return self.types.time(*divmod(self.nanoseconds(time), 10**9))

    def header(self, time: int, frame: str = MAP) -> Any:
        """The header of a message in ``frame``."""
        return self.types.header(self.stamp(time), frame)

    def pose(self, x: float, y: float, yaw: float = 0.0) -> Any:
        """A pose on the floor."""
        return self.types.pose(self.types.point(x, y, 0.0), self._turn(yaw))

    def pose_stamped(self, time: int, x: float, y: float, yaw: float = 0.0) -> Any:
        """A pose in the frame of the map."""
        return self.types.pose_stamped(self.header(time), self.pose(x, y, yaw))

    def transforms(self, time: int, *edges: tuple[str, str, float, float, float]) -> Any:
        """A TFMessage; each edge is (parent, child, x, y, yaw)."""
        return self.types.tf(
            [
                self.types.transform_stamped(
                    self.header(time, parent),
                    child,
                    self.types.transform(self.types.vector(x, y, 0.0), self._turn(yaw)),
                )
                for parent, child, x, y, yaw in edges
            ]
        )

    def odometry(
        self, time: int, frames: tuple[str, str], place: tuple[float, float, float], speeds: tuple[float, float]
    ) -> Any:
        """``frames``: of the pose and of the robot. ``place``: x, y, yaw. ``speeds``: m/s ahead, rad/s to the left."""
        types = self.types
        forward, turning = types.vector(speeds[0], 0.0, 0.0), types.vector(0.0, 0.0, speeds[1])
        return types.odometry(
            self.header(time, frames[0]),
            frames[1],
            types.pose_with_covariance(self.pose(*place), self._still),
            types.twist_with_covariance(types.twist(forward, turning), self._still),
        )

    def grid(self, time: int, cells: NDArray[np.int8], frame: Frame) -> Any:
        """An OccupancyGrid of ``cells``, rows × columns with the highest row first, as records have them."""
        rows, columns = cells.shape
        x, y, yaw = frame.origin
        info = self.types.map_meta_data(self.stamp(time), frame.resolution, columns, rows, self.pose(x, y, yaw))
        return self.types.occupancy_grid(self.header(time), info, np.ascontiguousarray(cells[::-1]).ravel())

    def path(self, time: int, points: list[tuple[float, float]]) -> Any:
        """A Path through points in metres. Each pose looks to the next."""
        turns = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(points)]
        turns += turns[-1:] or [0.0] * len(points)
        poses = [self.pose_stamped(time, x, y, yaw) for (x, y), yaw in zip(points, turns, strict=True)]
        return self.types.path(self.header(time), poses)

    def scan(
        self, time: int, frame: str, first: float, ranges: NDArray[np.float32], reach: float, period: float
    ) -> Any:
        """A LaserScan over the full circle. ``first``: the angle of the first ray, from the robot's heading."""
        step = 2 * math.pi / len(ranges)
        last = first + step * (len(ranges) - 1)
        empty = np.zeros(0, np.float32)
        return self.types.laser_scan(
            self.header(time, frame), first, last, step, 0.0, period, 0.0, reach, ranges, empty
        )

    def log(self, time: int, level: int, name: str, text: str) -> Any:
        """A line of the log."""
        return self.types.log(self.stamp(time), level, name, text, "", "", 0)

    def _turn(self, yaw: float) -> Any:
        return self.types.quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
