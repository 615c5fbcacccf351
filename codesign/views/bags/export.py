"""The records of a run as a ROS 2 bag, with the topics that Nav2 has.

A drive has one robot, with the topics ``/map``, ``/belief``, ``/true_map``, ``/plan``, ``/odom``, ``/tf``,
``/tf_static``, ``/scan``, ``/goal_pose`` and ``/rosout``. The robots of a fleet have a namespace each. The traces of
runs hold no ranges: the ranges of ``/scan`` are computed again from the true map, the sensor and the robot's place.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.components.kernels import ranges
from codesign.components.sensor import RaySensor
from codesign.ground.errors import InputError, RunError, printable, reason_of
from codesign.ground.files import WholeOrAbsent, landing, part_of, put
from codesign.ground.models import Frame
from codesign.ground.records import (
    BeliefRecord,
    GoalRecord,
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    RobotRecord,
    Subject,
    TrajectoryRecord,
    kinds_about,
)
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.views.bags.library import Types, load, typestore

# A rosbag2 folder with MCAP storage, written message by message: whole or absent, the same bytes each time.

VERSION: Any = 9
"""Of the format of rosbag2: the version of ROS 2 Jazzy."""


def check_new(folder: Path, option: str) -> None:
    """Check, before any work, that a bag can be written to ``folder``, which does not exist or is empty.

    Raises:
        InputError: it cannot. RunError: the library is missing.
    """
    load("rosbag2")
    where = f"{option} {folder}"
    try:
        target = landing(folder)
        if target.exists() and not target.is_dir():
            raise InputError("is a file, and a bag is a folder", where, "name a folder that does not exist")
        if target.exists() and any(target.iterdir()):
            hint = "name a folder that does not exist, or remove this one"
            raise InputError("exists already, and is not empty", where, hint)
        if not target.parent.is_dir():
            raise InputError(f"folder {target.parent} does not exist", where, "make it first")
        with tempfile.TemporaryDirectory(dir=target.parent):
            pass
    except (OSError, ValueError) as fault:
        hint = "name a folder in one that exists and can be written to"
        raise InputError(reason_of(fault), where, hint) from fault


class BagFolder(WholeOrAbsent):
    """Writes messages to a bag. As a context manager it is closed at the end of the block, or removed by an error.

    The bag is written to a temporary folder beside ``path``, and renamed by ``close``.

    Raises:
        RunError: the library is missing, or the bag cannot be written. The temporary folder is removed.
    """

    def __init__(self, path: Path) -> None:
        library = load("rosbag2")
        super().__init__(path)
        self._open: dict[str, Any] = {}
        self._writer: Any = None
        with self._guard():
            part = part_of(self._target)
            self._hold(part)
            part.mkdir()
            # The library names the file of messages after the folder.
            self._part = part / self._target.name
            self._writer = library.Writer(self._part, version=VERSION, storage_plugin=library.StoragePlugin.MCAP)
            # The chunks of the file, which every reader of MCAP unpacks.
            self._writer.set_compression(library.CompressionMode.STORAGE, library.CompressionFormat.ZSTD)
            self._writer.open()

    def write(self, topic: str, time: int, message: Any, latched: bool = False) -> None:
        """Write a message at ``time``, ns. ``latched``: a reader that comes later gets the last one."""
        with self._guard():
            kind = message.__msgtype__
            connection = self._open.get(topic)
            if connection is None:
                qos = [_qos(latched)]
                connection = self._writer.add_connection(topic, kind, typestore=typestore(), offered_qos_profiles=qos)
                self._open[topic] = connection
            self._writer.write(connection, time, typestore().serialize_cdr(message, kind))

    def _finish(self) -> None:
        with self._guard():
            self._writer.close()
            if self._target.is_dir():
                self._target.rmdir()
            put(self._part, self._target)

    def _drop(self) -> None:
        if self._writer is not None:
            with suppress(AttributeError):
                self._writer.abort()

    @contextmanager
    def _guard(self) -> Iterator[None]:
        if self._finished:
            raise RunError("is closed", str(self.path), "write no message after the end of the run")
        try:
            yield
        except (OSError, ValueError) as fault:
            self.abort()
            hint = "name a new folder in one that exists, can be written to and has free space"
            raise RunError(f"the bag cannot be written: {reason_of(fault)}", str(self.path), hint) from fault


def _qos(latched: bool) -> Any:
    ros = load("interfaces")
    durability = getattr(ros.QosDurability, "TRANSIENT_LOCAL" if latched else "VOLATILE")
    forever = ros.QosTime(0, 0)
    return ros.Qos(
        ros.QosHistory.KEEP_LAST, 1 if latched else 10, ros.QosReliability.RELIABLE, durability, forever, forever,
        ros.QosLiveliness.AUTOMATIC, forever, False,
    )  # fmt: skip


# ROS messages made of what a run records: poses in metres, grids with the lowest row first, times in nanoseconds.

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Cells of an OccupancyGrid, as map_server writes them in its mode ``trinary``."""

MAP = "map"
"""The frame of the map. In a run, odometry has no error, so frame ``odom`` is the same."""

INFORMATION, WARNING = 20, 30
"""Levels of rcl_interfaces/Log."""


@dataclass(frozen=True)
class Floor:
    """The place of cells in metres. ``row``, ``column``: the first cell of the map, as records count cells."""

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


BAG_KINDS = kinds_about(
    Subject.MAP, Subject.ROBOT, Subject.GOALS, Subject.POSE, Subject.FLEET, Subject.PATH, Subject.CHANGE,
    Subject.BELIEF, Subject.EVENT,
)  # fmt: skip
"""The records that a bag shows."""

_ALARMS = {"no_way", "deadline_missed", "safety_stop", "contact", "livelock"}
_SHORTEST_INTERVAL = PICOSECONDS_PER_SECOND
_INTERVAL_A_CELL = 64 * 10**6
"""Picoseconds between two whole grids: at least 1 s, and 64 us a cell, as in native traces."""

_NAMESPACE = "robot_"


@dataclass
class _Grid:
    """A grid that changes: int8, rows × columns, and the time of its last message."""

    topic: str
    cells: NDArray[np.int8]
    written: int | None = None
    changed: bool = True

    def put(self, cells: NDArray[np.integer], values: NDArray[np.int8] | int) -> None:
        self.cells[cells[:, 0], cells[:, 1]] = values
        self.changed = True

    def due(self, time: int, last: bool) -> bool:
        interval = max(_SHORTEST_INTERVAL, _INTERVAL_A_CELL * self.cells.size)
        soon = self.written is not None and time - self.written < interval
        if not self.changed or (soon and not last):
            return False
        self.written, self.changed = time, False
        return True


@dataclass
class _Robot:
    """The last place of a robot: time (ps), x, y, yaw; and the prefix of its topics and frames."""

    topics: str = ""
    frames: str = ""
    last: tuple[int, float, float, float] | None = None


@dataclass
class _World:
    """The map and what changes on it."""

    floor: Floor = field(default_factory=lambda: Floor(Frame(0)))
    free: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), bool))
    known: NDArray[np.int8] = field(default_factory=lambda: np.zeros((0, 0), np.int8))
    corner: NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, np.int64))

    def here(self, cells: NDArray[np.integer]) -> NDArray[np.int64] | None:
        """Cells counted on the map; None where one lies outside."""
        if cells.ndim != 2 or cells.shape[1:] != (2,):
            return None
        here = cells - self.corner
        return here if bool(((here >= 0) & (here < self.free.shape)).all()) else None


class BagListener:
    """Writes each record of a run as ROS messages into the bag ``path``; see ``BagFolder`` for its errors.

    ``begin``: ns that are added to every time of the run.
    """

    def __init__(self, path: Path, begin: int = 0) -> None:
        self._make = Messages(begin)
        self._bag = BagFolder(path)
        self._world = _World()
        self._map: MapRecord | None = None
        self._robot: RobotRecord | None = None
        self._grids: dict[str, _Grid] = {}
        self._robots: dict[str, _Robot] = {}
        self._pending: GoalRecord | None = None
        self._directions: NDArray[np.float64] = np.zeros((0, 2))
        self._last = 0
        self._takers: dict[Subject, Callable[[Any], None]] = {
            Subject.MAP: self._mapped,
            Subject.ROBOT: self._driver,
            Subject.GOALS: self._goal,
            Subject.POSE: self._pose,
            Subject.FLEET: self._positions,
            Subject.PATH: self._trajectory,
            Subject.CHANGE: self._obstacle,
            Subject.BELIEF: self._belief,
            Subject.EVENT: self._event,
        }

    def __call__(self, record: Record) -> None:
        """Write one record."""
        about = record.ROLE.about
        take = self._takers.get(about)
        if take is not None:
            self._last = max(self._last, record.time)
            if self._map is not None and about is not Subject.ROBOT:
                self._begin(self._map, None)
            take(record)

    def close(self) -> None:
        """Write the last grids, and finish the bag."""
        if self._map is not None:
            self._begin(self._map, None)
        for grid in self._grids.values():
            self._show(grid, self._last, last=True)
        self._bag.close()

    def abort(self) -> None:
        """Remove what was written."""
        self._bag.abort()

    def __enter__(self) -> BagListener:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_rest: object) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()

    def _mapped(self, record: MapRecord) -> None:
        """Keep the map: the robot, which follows, says what its map does not show."""
        self._map = record

    def _driver(self, record: RobotRecord) -> None:
        self._robot = record
        if self._map is not None:
            self._begin(self._map, record)

    def _event(self, record: MissionRecord) -> None:
        level = WARNING if record.event in _ALARMS else INFORMATION
        text = printable(f"{record.event.replace('_', ' ')}: {record.text}", 4000)
        self._write("/rosout", record.time, self._make.log(record.time, level, printable(record.source), text))

    def _write(self, topic: str, time: int, message: object, latched: bool = False) -> None:
        self._bag.write(topic, self._make.nanoseconds(time), message, latched)

    def _begin(self, record: MapRecord, robot: RobotRecord | None) -> None:
        """The map, as map_server has it: without the obstacles that the robot's map does not show."""
        self._map = None
        origin = (0.0, 0.0, 0.0) if record.origin is None else tuple(map(float, record.origin))
        frame = Frame(record.free.shape[0], record.resolution or 1.0, (origin[0], origin[1], origin[2]))
        cells = np.where(record.free, FREE, OCCUPIED).astype(np.int8)
        known = cells.copy()
        self._world = _World(Floor(frame, *record.corner), record.free.copy(), known, np.array(record.corner))
        if robot is not None and (hidden := self._world.here(robot.hidden)) is not None:
            known[hidden[:, 0], hidden[:, 1]] = FREE
        if record.unknown is not None and record.unknown.shape == known.shape:
            known[record.unknown] = UNKNOWN
        self._write("/map", record.time, self._make.grid(record.time, known, frame), latched=True)
        self._grids = {"/true_map": _Grid("/true_map", cells)}
        if robot is not None:
            begin = known if robot.knows else np.full_like(known, UNKNOWN)
            self._grids["/belief"] = _Grid("/belief", begin.copy())
            for grid in self._grids.values():
                self._show(grid, record.time)
        if robot is not None and robot.rays > 0:
            self._directions = RaySensor(robot.reach, robot.rays).directions
        self._pending = GoalRecord(record.time, record.source, record.goals)

    def _show(self, grid: _Grid, time: int, last: bool = False) -> None:
        if grid.due(time, last):
            message = self._make.grid(time, grid.cells, self._world.floor.frame)
            self._write(grid.topic, time, message, latched=True)

    def _obstacle(self, record: ObstacleRecord) -> None:
        here = self._world.here(record.cells)
        grid = self._grids.get("/true_map")
        if here is not None and grid is not None:
            self._world.free[here[:, 0], here[:, 1]] = not record.appeared
            grid.put(here, OCCUPIED if record.appeared else FREE)
            self._show(grid, record.time)

    def _belief(self, record: BeliefRecord) -> None:
        here = self._world.here(record.cells)
        grid = self._grids.get("/belief")
        if here is not None and grid is not None:
            grid.put(here, np.where(record.blocked, OCCUPIED, FREE).astype(np.int8))
            self._show(grid, record.time)

    def _goal(self, record: GoalRecord) -> None:
        """A single goal is written at once. Of several, the first plan shows which one is meant."""
        self._pending = None
        if len(record.cells) == 1:
            row, column = record.cells[0].tolist()
            x, y = self._world.floor.point(row, column)
            self._write("/goal_pose", record.time, self._make.pose_stamped(record.time, x, y))
        elif len(record.cells):
            self._pending = record

    def _trajectory(self, record: TrajectoryRecord) -> None:
        robot = self._robots.get(record.source)
        points = [self._world.floor.point(row, column) for row, column in record.points.tolist()]
        if robot is not None and robot.topics:
            self._write(f"{robot.topics}/path", record.time, self._make.path(record.time, points))
            return
        pending, self._pending = self._pending, None
        if pending is not None and len(pending.cells) == 1:
            self._goal(pending)
        elif pending is not None and record.arrived and points:
            self._write("/goal_pose", pending.time, self._make.pose_stamped(pending.time, *points[-1]))
        self._write("/plan", record.time, self._make.path(record.time, points))

    def _pose(self, record: PoseRecord) -> None:
        floor = self._world.floor
        robot = self._robots.get(record.source)
        if robot is None:
            robot = self._robots[record.source] = _Robot()
            edges = [("map", "odom", 0.0, 0.0, 0.0)]
            if len(self._directions):
                edges.append(("base_link", "base_scan", 0.0, 0.0, 0.0))
            self._write("/tf_static", record.time, self._make.transforms(record.time, *edges), latched=True)
        x, y = floor.point(record.row, record.column)
        yaw = floor.yaw(record.heading)
        last, robot.last = robot.last, (record.time, x, y, yaw)
        since = 0 if last is None else record.time - last[0]
        turning = 0.0 if last is None or not since else wrapped(yaw - last[3]) / since * PICOSECONDS_PER_SECOND
        self._move(record.time, robot, (record.speed, turning))
        if self._robot is not None and len(self._directions):
            self._scan(record, self._robot, yaw, since / PICOSECONDS_PER_SECOND)

    def _move(self, time: int, robot: _Robot, speeds: tuple[float, float]) -> None:
        assert robot.last is not None
        frames = f"{robot.frames}odom", f"{robot.frames}base_link"
        self._write(f"{robot.topics}/odom", time, self._make.odometry(time, frames, robot.last[1:], speeds))
        if not robot.topics:
            self._write("/tf", time, self._make.transforms(time, (*frames, *robot.last[1:])))

    def _scan(self, record: PoseRecord, robot: RobotRecord, yaw: float, period: float) -> None:
        """Write the scan. A run counts its rays clockwise from the x axis of the map, ROS the other way."""
        world = self._world
        row, column = record.row - world.corner[0], record.column - world.corner[1]
        side = world.floor.frame.resolution
        lengths = ranges(world.free, row, column, robot.reach / side, self._directions)
        counterclockwise = np.roll(lengths[::-1], 1) * side
        first = wrapped(world.floor.frame.origin[2] - yaw)
        message = self._make.scan(
            record.time, "base_scan", first, counterclockwise.astype(np.float32), robot.reach, period
        )
        self._write("/scan", record.time, message)

    def _positions(self, record: PositionsRecord) -> None:
        """The robots of a fleet. Each looks where it moves."""
        floor, count, edges = self._world.floor, len(record.positions), []
        if f"{_NAMESPACE}0" not in self._robots:
            for number in range(count):
                name = f"{_NAMESPACE}{number}"
                self._robots[name] = _Robot(f"/{name}", f"{name}/")
            roots = [("map", f"{_NAMESPACE}{number}/odom", 0.0, 0.0, 0.0) for number in range(count)]
            self._write("/tf_static", record.time, self._make.transforms(record.time, *roots), latched=True)
            self._targets(count)
        for number, (row, column) in enumerate(record.positions.tolist()):
            robot = self._robots.get(f"{_NAMESPACE}{number}")
            if robot is None:
                continue
            x, y = floor.point(row, column)
            before, x_before, y_before, yaw = robot.last or (record.time, x, y, 0.0)
            length = math.hypot(x - x_before, y - y_before)
            if length:
                yaw = math.atan2(y - y_before, x - x_before)
            since = record.time - before
            robot.last = (record.time, x, y, yaw)
            self._move(record.time, robot, (length / since * PICOSECONDS_PER_SECOND if since else 0.0, 0.0))
            edges.append((f"{robot.frames}odom", f"{robot.frames}base_link", x, y, yaw))
        self._write("/tf", record.time, self._make.transforms(record.time, *edges))

    def _targets(self, count: int) -> None:
        """The goal of each robot of a fleet."""
        pending, self._pending = self._pending, None
        if pending is None or len(pending.cells) != count:
            return
        for robot, (row, column) in enumerate(pending.cells.tolist()):
            x, y = self._world.floor.point(row, column)
            message = self._make.pose_stamped(pending.time, x, y)
            self._write(f"/{_NAMESPACE}{robot}/goal_pose", pending.time, message)


def export_bag(records: Iterable[Record], path: Path, begin: int = 0) -> None:
    """Write the records of a run as a bag; ``begin`` as in ``BagListener``."""
    with BagListener(path, begin) as listener:
        for record in records:
            listener(record)
