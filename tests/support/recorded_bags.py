"""Bags of a robot in a hall, made with the library's own types and none of ours: as a robot would record them.

The hall is 10 m × 6 m, its map has cells of 5 cm, lies at (-2, -1) and has walls, a block and unknown space behind it.
The robot drives from goal to goal on straight lines. A crate stands in the hall for a while.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

SIDE, ORIGIN, ROWS, COLUMNS = 0.05, (-2.0, -1.0), 120, 200
BLOCK = (4.0, 2.0, 5.0, 4.0)
"""x and y of two corners of the block that the map shows."""
UNKNOWN = (4.2, 2.2, 4.8, 3.8)
CRATE = (0.8, 0.6, 1.2, 1.0)
CRATE_TIMES = (20.0, 60.0)
GOALS = ((2.5, 0.0), (6.5, 0.0), (6.5, 4.0), (2.5, 4.0), (0.0, 4.0), (0.0, 0.5))
SPEED = 0.5
EPOCH = 1_700_000_000 * 10**9


def hall() -> np.ndarray:
    """The cells of the map: int8, the lowest row first, as an OccupancyGrid has them."""
    cells = np.zeros((ROWS, COLUMNS), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = 100, 100
    for (left, below, right, above), value in ((BLOCK, 100), (UNKNOWN, -1)):
        first, last = _column(left), _column(right)
        cells[_row(below) : _row(above), first:last] = value
    return cells


def _column(x: float) -> int:
    return round((x - ORIGIN[0]) / SIDE)


def _row(y: float) -> int:
    return round((y - ORIGIN[1]) / SIDE)


@dataclass
class Hall:
    """What a bag holds, and at which rates (Hz). ``late``: s that stamps are behind the times of the bag."""

    seconds: float = 60.0
    scan_rate: float = 10.0
    rays: int = 360
    odom_rate: float = 20.0
    reach: float = 3.5
    skip: frozenset[str] = frozenset()
    late: float = 0.0
    plan_after: float = 0.12


def route(seconds: float) -> tuple[np.ndarray, list[tuple[float, tuple[float, float]]]]:
    """Corners (time, x, y) of the way, and the goals with the times at which they are given."""
    rows, goals = [(0.0, 0.0, 0.0)], []
    time, place, index = 1.0, (0.0, 0.0), 0
    while time < seconds:
        goal = GOALS[index % len(GOALS)]
        goals.append((time, goal))
        rows.append((time + 0.2, *place))
        time += 0.2 + math.dist(place, goal) / SPEED
        rows.append((time, *goal))
        time, place, index = time + 1.0, goal, index + 1
    return np.array(rows), goals


def _hits(x: float, y: float, angles: np.ndarray, boxes: list[tuple[float, float, float, float]]) -> np.ndarray:
    """Ranges from (x, y) to the walls of the hall and to boxes, by geometry and not by cells."""
    along, up = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore", invalid="ignore"):
        left, right = ORIGIN[0] + SIDE, ORIGIN[0] + (COLUMNS - 1) * SIDE
        below, above = ORIGIN[1] + SIDE, ORIGIN[1] + (ROWS - 1) * SIDE
        reach = np.minimum(
            np.where(along > 0, (right - x) / along, np.where(along < 0, (left - x) / along, np.inf)),
            np.where(up > 0, (above - y) / up, np.where(up < 0, (below - y) / up, np.inf)),
        )
        for first_x, first_y, last_x, last_y in boxes:
            across = np.sort(np.stack([(first_x - x) / along, (last_x - x) / along]), axis=0)
            upward = np.sort(np.stack([(first_y - y) / up, (last_y - y) / up]), axis=0)
            enter, leave = np.maximum(across[0], upward[0]), np.minimum(across[1], upward[1])
            reach = np.where((enter <= leave) & (enter > 0), np.minimum(reach, enter), reach)
    return reach


def record(folder: Path, hall_of: Hall | None = None, storage: str = "mcap") -> Path:
    """Record a bag. The laser is mounted 10 cm ahead of the robot, turned by half a turn."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    plan = hall_of or Hall()
    store = get_typestore(Stores.ROS2_HUMBLE)
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with Writer(folder, version=8, storage_plugin=plugin) as writer:
        connections: dict[str, Any] = {}
        for time, topic, message in sorted(_messages(plan, store.types), key=lambda item: item[0]):
            if topic in plan.skip:
                continue
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], EPOCH + round(time * 1e9), store.serialize_cdr(message, kind))
    return folder


def _messages(plan: Hall, types: Any) -> list[tuple[float, str, Any]]:
    make = _Make(types, plan.late)
    way, goals = route(plan.seconds)
    out = [(0.0, "/map", make.map(hall())), (0.0, "/tf_static", make.static())]
    out += [(0.0, "/tf", make.tf(0.0, "map", "odom", 0.3, -0.2, 0.1))]
    for time, goal in goals:
        place = [float(np.interp(time, way[:, 0], way[:, axis])) for axis in (1, 2)]
        out += [
            (time, "/goal_pose", make.goal(time, goal)),
            (time + plan.plan_after, "/plan", make.path(time, place, goal)),
        ]
    for time in np.arange(0.0, plan.seconds, 1 / plan.odom_rate).tolist():
        pose = _pose(way, time)
        out += [(time, "/tf", make.tf(time, "odom", "base_link", *_in_odom(*pose)))]
        out += [(time, "/odom", make.odom(time, *_in_odom(*pose), _speed(way, time)))]
        out += [(time, "/cmd_vel", make.twist(_speed(way, time)))]
    angles = np.arange(plan.rays) * (2 * math.pi / plan.rays) - math.pi
    for time in np.arange(0.0, plan.seconds, 1 / plan.scan_rate).tolist():
        x, y, yaw = _pose(way, time)
        boxes = [BLOCK] + ([CRATE] if CRATE_TIMES[0] <= time < CRATE_TIMES[1] else [])
        at = x + 0.1 * math.cos(yaw), y + 0.1 * math.sin(yaw)
        ranges = _hits(*at, angles + yaw + math.pi, boxes)
        ranges[ranges > plan.reach] = np.inf
        out.append((time, "/scan", make.scan(time, ranges.astype(np.float32), plan.reach)))
    return out


def _pose(way: np.ndarray, time: float) -> tuple[float, float, float]:
    index = min(int(np.searchsorted(way[:, 0], time, side="right")), len(way) - 1)
    step = way[index, 1:] - way[index - 1, 1:]
    while index > 1 and not step.any():
        index -= 1
        step = way[index, 1:] - way[index - 1, 1:]
    x, y = (float(np.interp(time, way[:, 0], way[:, axis])) for axis in (1, 2))
    return x, y, math.atan2(step[1], step[0]) if step.any() else 0.0


def _in_odom(x: float, y: float, yaw: float) -> tuple[float, float, float]:
    right, up = x - 0.3, y + 0.2
    return right * math.cos(0.1) + up * math.sin(0.1), up * math.cos(0.1) - right * math.sin(0.1), yaw - 0.1


def _speed(way: np.ndarray, time: float) -> float:
    index = int(np.searchsorted(way[:, 0], time, side="right"))
    return SPEED if 0 < index < len(way) and (way[index, 1:] != way[index - 1, 1:]).any() else 0.0


class _Make:
    """Messages of plain values."""

    def __init__(self, types: Any, late: float) -> None:
        self.types, self.late = types, late

    def header(self, time: float, frame: str) -> Any:
        nanoseconds = EPOCH + round((time - self.late) * 1e9)
        stamp = self.types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 10**9))
        return self.types["std_msgs/msg/Header"](stamp, frame)

    def pose(self, x: float, y: float, yaw: float) -> Any:
        point = self.types["geometry_msgs/msg/Point"](x, y, 0.0)
        return self.types["geometry_msgs/msg/Pose"](point, self.turn(yaw))

    def turn(self, yaw: float) -> Any:
        return self.types["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))

    def stamped(self, time: float, x: float, y: float) -> Any:
        return self.types["geometry_msgs/msg/PoseStamped"](self.header(time, "map"), self.pose(x, y, 0.0))

    def goal(self, time: float, goal: tuple[float, float]) -> Any:
        return self.stamped(time, *goal)

    def path(self, time: float, *ends: Any) -> Any:
        return self.types["nav_msgs/msg/Path"](self.header(time, "map"), [self.stamped(time, *end) for end in ends])

    def map(self, cells: np.ndarray) -> Any:
        header = self.header(0.0, "map")
        info = self.types["nav_msgs/msg/MapMetaData"](header.stamp, SIDE, COLUMNS, ROWS, self.pose(*ORIGIN, 0.0))
        return self.types["nav_msgs/msg/OccupancyGrid"](header, info, cells.ravel())

    def edge(self, time: float, parent: str, child: str, x: float, y: float, yaw: float) -> Any:
        moved = self.types["geometry_msgs/msg/Vector3"](x, y, 0.0)
        transform = self.types["geometry_msgs/msg/Transform"](moved, self.turn(yaw))
        return self.types["geometry_msgs/msg/TransformStamped"](self.header(time, parent), child, transform)

    def tf(self, *edge: Any) -> Any:
        return self.types["tf2_msgs/msg/TFMessage"]([self.edge(*edge)])

    def static(self) -> Any:
        return self.tf(0.0, "base_link", "laser", 0.1, 0.0, math.pi)

    def twist(self, speed: float) -> Any:
        vector = self.types["geometry_msgs/msg/Vector3"]
        return self.types["geometry_msgs/msg/Twist"](vector(speed, 0.0, 0.0), vector(0.0, 0.0, 0.0))

    def odom(self, time: float, x: float, y: float, yaw: float, speed: float) -> Any:
        still = np.zeros(36)
        pose = self.types["geometry_msgs/msg/PoseWithCovariance"](self.pose(x, y, yaw), still)
        twist = self.types["geometry_msgs/msg/TwistWithCovariance"](self.twist(speed), still)
        return self.types["nav_msgs/msg/Odometry"](self.header(time, "odom"), "base_link", pose, twist)

    def scan(self, time: float, ranges: np.ndarray, reach: float) -> Any:
        step = 2 * math.pi / len(ranges)
        return self.types["sensor_msgs/msg/LaserScan"](
            self.header(time, "laser"), -math.pi, math.pi - step, step, 0.0, 0.1, 0.12, reach, ranges,
            np.zeros(0, np.float32),
        )  # fmt: skip


def main() -> None:
    """Record the bag of docs/ros2.md: ``python tests/support/recorded_bags.py FOLDER [SECONDS]``."""
    import sys

    record(Path(sys.argv[1]), Hall(seconds=float(sys.argv[2]) if len(sys.argv) > 2 else 60.0))


if __name__ == "__main__":
    main()
