"""The listener that keeps the records of a run in an MCAP file, with views of them for Foxglove and Rerun.

The file is complete or absent, and the same records give the same bytes.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import foxglove
import numpy as np
from foxglove import Channel, Context, Schema, channels
from foxglove import messages as fg
from foxglove.mcap import MCAPCompression, MCAPWriteOptions, MCAPWriter
from numpy.typing import NDArray

from codesign.ground.errors import TraceError
from codesign.ground.files import WholeOrAbsent, is_special, part_of, put
from codesign.ground.records import (
    RECORD_TYPES,
    BeliefRecord,
    Level,
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    Recorder,
    ScanRecord,
    Subject,
    TrajectoryRecord,
)
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.views.trace import shapes
from codesign.views.trace.messages import descriptor_set, encoder_of, schema_name, topic_of
from codesign.views.trace.shapes import BLOCKED, FREE, UNKNOWN, Floor, floor_of

# Views of robots: their frames, their bodies with headings and numbers, and their trails.

SHOWN_EACH, FLEET_SHOWN_EACH = PICOSECONDS_PER_SECOND // 5, PICOSECONDS_PER_SECOND * 2 // 5
FEW = 4
"""Picoseconds between two places of a robot, and of a fleet of more than 4 robots. Viewers move a frame smoothly."""

Place = tuple[float, float]

TRAIL = 64
"""Most positions of a trail. Of a fleet, ``TRAIL_OF_ALL`` positions in all."""

TRAIL_OF_ALL, TRAIL_EACH = 1024, PICOSECONDS_PER_SECOND * 2 // 5
TRAILS_A_LENGTH = 2
"""A trail is written each time that half of it is new, so each position is written twice."""

_CIRCLE = np.array([(math.cos(part * math.pi / 12), math.sin(part * math.pi / 12)) for part in range(24)])
_BEAK = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros(6)])


_VARINT = 5
"""Bytes of a number of a time. A varint may be longer than needed, so that the next number keeps its place."""

_PLACE_AND_TURN = struct.Struct("<BBBdBd BBBdBd")
"""A vector of x and y, and a quaternion of z and w, each number behind its field. What is left out is 0."""


class Encoded(NamedTuple):
    """A message that is encoded already, and its class in Foxglove's SDK."""

    kind: Any
    data: bytes


Show = Callable[[str, Any, int], None]
"""Takes a topic, a message of Foxglove's SDK or an ``Encoded`` one, and its time, ps."""


class Robots:
    """The robots of a run, alone or as a fleet."""

    def __init__(self, show: Show) -> None:
        self._show = show
        self.begin(Floor(), 0.0)

    def begin(self, floor: Floor, radius: float) -> None:
        """A map has come: no robot is drawn on it. ``radius``: of their bodies, m; 0: not known."""
        self._floor = floor
        self._radius = radius or floor.cell_size / 2
        self._drawn: dict[str, int] = {}
        self._trails: dict[str, list[list[Place]]] = {}
        self._last: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        self._transforms: dict[str, Transforms] = {}
        self._new = 0
        self._due: dict[str, int] = {}
        self._trail_due: dict[str, int] = {}
        self._kept: dict[str, Callable[[], None]] = {}

    def posed(self, record: PoseRecord) -> None:
        """Show a robot, where the last place that was shown is old enough."""
        if record.time < self._due.get(record.source, 0):
            self._kept[record.source] = partial(self._posed, record)
        else:
            self._posed(record)

    def _posed(self, record: PoseRecord) -> None:
        place = self._floor.point(record.row, record.column)
        time, frame, angle = record.time, record.source, self._floor.turned(record.heading)
        self._kept.pop(frame, None)
        if not math.isfinite(place[0] + place[1] + angle):
            return
        self._due[frame] = time + SHOWN_EACH
        self._move(frame, [frame], time, [(*place, angle)])
        if self._drawn.get(frame) != 1:
            self._bodies(time, frame, [frame], [""])
            # Rerun has no scenes. The body there is a circle of points with a beak, in the frame of the robot.
            outline = np.concatenate([_CIRCLE, 1.5 * _BEAK]) * self._radius
            body = shapes.cloud(outline, shapes.ROBOT, time, self._radius / 2, frame)
            self._show("/robots/points", body, time)
        self._trail(time, frame, [place])

    def placed(self, record: PositionsRecord) -> None:
        """Show a fleet, where the last places that were shown are old enough."""
        if record.time < self._due.get(record.source, 0):
            self._kept[record.source] = partial(self._placed, record)
        else:
            self._placed(record)

    def _placed(self, record: PositionsRecord) -> None:
        """A robot points where it last moved."""
        time, source, places = record.time, record.source, self._floor.points(record.positions)
        self._kept.pop(source, None)
        if not (len(places) and np.isfinite(places).all()):
            return
        before, angles = self._last.get(source, (places, np.zeros(len(places))))
        if len(before) != len(places):
            before, angles = places, np.zeros(len(places))
        moved = places - before
        moves = np.abs(moved).max(axis=1) > 1e-6 * self._floor.cell_size
        angles = np.where(moves, np.arctan2(moved[:, 1], moved[:, 0]), angles)
        self._last[source] = places, angles
        self._due[source] = time + (SHOWN_EACH if len(places) <= FEW else FLEET_SHOWN_EACH)
        numbers = [str(number) for number in range(len(places))]
        frames = [f"{source}/{number}" for number in numbers]
        self._move(source, frames, time, np.column_stack([places, angles]).tolist())
        if self._drawn.get(source) != len(places):
            self._bodies(time, source, frames, numbers)
        if self._trail(time, source, places.tolist()):
            self._show("/robots/points", shapes.cloud(places, shapes.ROBOT, time, self._radius / 2), time)

    def finish(self, time: int) -> None:
        """Show the last positions, and the trails where they have grown."""
        for show in list(self._kept.values()):
            show()
        if self._new:
            self._trails_of_all(time)

    def _move(self, source: str, frames: list[str], time: int, poses: Iterable[Sequence[float]]) -> None:
        """Show the frames at their poses, each x and y in metres and the angle in radians."""
        transforms = self._transforms.get(source)
        if transforms is None or len(transforms.frames) != len(frames):
            transforms = self._transforms[source] = Transforms(frames)
        self._show("/tf", Encoded(fg.FrameTransforms, transforms.message(time, poses)), time)

    def _bodies(self, time: int, source: str, frames: list[str], numbers: list[str]) -> None:
        """Show a disc, an arrow and a number in each frame."""
        self._drawn[source] = len(frames)
        radius = self._radius
        disc = fg.CylinderPrimitive(
            pose=shapes.pose(0.0, 0.0, 0.0, radius / 4),
            size=fg.Vector3(x=2 * radius, y=2 * radius, z=radius / 2),
            bottom_scale=1.0,
            top_scale=1.0,
            color=shapes.colour(shapes.ROBOT),
        )
        arrow = fg.ArrowPrimitive(
            pose=shapes.pose(0.0, 0.0, 0.0, radius),
            shaft_length=radius,
            shaft_diameter=radius / 3,
            head_length=radius / 2,
            head_diameter=radius * 2 / 3,
            color=shapes.colour(shapes.PATH),
        )
        above = shapes.pose(0.0, 0.0, 0.0, 2 * radius)
        texts = [
            fg.TextPrimitive(
                pose=above,
                billboard=True,
                font_size=radius,
                scale_invariant=False,
                color=fg.Color(r=0.0, g=0.0, b=0.0, a=1.0),
                text=number,
            )
            for number in numbers
        ]
        entities = [
            shapes.entity(frame, time, frame, cylinders=[disc], arrows=[arrow], texts=[text] if number else [])
            for frame, number, text in zip(frames, numbers, texts, strict=True)
        ]
        self._show("/robots", fg.SceneUpdate(entities=entities), time)

    def _trail(self, time: int, source: str, places: list[Place]) -> bool:
        """A place is part of the trail where the one before is old enough. Returns whether this one is."""
        if time < self._trail_due.get(source, 0):
            return False
        self._trail_due[source] = time + TRAIL_EACH
        before = self._trails.get(source, [])
        trail = self._trails[source] = before if before and len(before[-1]) == len(places) else []
        trail.append(places)
        self._new += 1
        length = max(min(TRAIL, TRAIL_OF_ALL // max(len(places), 1)), 2)
        if self._new >= length // TRAILS_A_LENGTH:
            del trail[:-length]
            self._trails_of_all(time)
        return True

    def _trails_of_all(self, time: int) -> None:
        self._new = 0
        # robots × positions × 2
        trails = [path for trail in self._trails.values() for path in np.array(trail).swapaxes(0, 1)]
        lines = [shapes.line(path, shapes.TRAIL, 0.005) for path in trails]
        self._show("/trails", shapes.scene("trails", time, lines=lines), time)
        points = np.concatenate(trails) if trails else np.zeros((0, 2))
        self._show("/trails/points", shapes.cloud(points, shapes.TRAIL, time, 0.005), time)


class Transforms:
    """From frame ``map`` to each of ``frames``, in their order: ``foxglove.FrameTransforms`` as bytes.

    Only the numbers in a template of the message change. A run has thousands of messages, and building an object for
    each number would take most of their time.
    """

    def __init__(self, frames: Sequence[str]) -> None:
        self.frames = tuple(frames)
        stamp = 2 + 2 * (1 + _VARINT)
        self._parts = []
        for frame in frames:
            names = _text(2, shapes.MAP_FRAME) + _text(3, frame)
            size = stamp + len(names) + _PLACE_AND_TURN.size
            self._parts.append((b"\x0a" + _varint(size), names))

    def message(self, time: int, poses: Iterable[Sequence[float]]) -> bytes:
        """The message at ``time``, ps. ``poses``: of each frame x and y in metres, and the angle in radians."""
        seconds, rest = divmod(time, 10**12)
        numbers = b"\x08" + _varint(seconds, _VARINT) + b"\x10" + _varint(rest // 1000, _VARINT)
        stamp, grain, content = b"\x0a" + bytes([len(numbers)]) + numbers, shapes.GRAIN, []
        for (head, names), (right, up, angle) in zip(self._parts, poses, strict=True):
            x, y = round(right * grain) / grain, round(up * grain) / grain
            z, w = round(math.sin(angle / 2) * grain) / grain, round(math.cos(angle / 2) * grain) / grain
            place = _PLACE_AND_TURN.pack(0x22, 18, 9, x, 0x11, y, 0x2A, 18, 0x19, z, 0x21, w)
            content += [head, stamp, names, place]
        return b"".join(content)


def _varint(number: int, size: int = 0) -> bytes:
    """A number as protobuf has it, in at least ``size`` bytes."""
    parts: list[int] = []
    while number >= 0x80 or len(parts) + 1 < size:
        parts.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*parts, number])


def _text(field: int, text: str) -> bytes:
    content = text.encode()
    return bytes([field << 3 | 2]) + _varint(len(content)) + content


# Messages for viewers, derived from the stream of records. Our reader ignores them.

SHORTEST_INTERVAL = PICOSECONDS_PER_SECOND
INTERVAL_A_CELL = 72 * 10**6
"""Picoseconds between two whole grids: at least 1 s, and 72 us a cell."""

VOXELS_A_GRID = 4
"""Of a large map, the voxels for Rerun are written with each fourth grid."""

OBSTACLES_INTERVAL, INTERVAL_A_CAME = PICOSECONDS_PER_SECOND // 2, PICOSECONDS_PER_SECOND // 100
"""Picoseconds between two messages of the obstacles that came: at least 0.5 s, and 10 ms a cell."""

MOST_SHOWN = 2**18
"""Most cells of a grid for viewers. Of a larger map, n × n cells are shown as one."""

MOST_CUBES = 1024
"""Most bars of obstacles in a scene. Where there are more, the grid of the map shows the rest."""

_POINTS_OF_PATH = 1024
_BELIEFS = np.array([FREE, BLOCKED], np.uint8)
_ALARMS = {"no_way", "deadline_missed", "safety_stop", "contact", "livelock"}
_HEIGHTS = {"true": -0.03, "belief": -0.02, "field": -0.01}
"""The heights of grids in metres. They lie above each other, so that they do not flicker in one plane."""


class Views:
    """Takes the records of a run in the order of emission, and shows the views after each.

    ``show`` takes each view. A record that does not fit the map of its run, or comes before the map, has no view.
    """

    def __init__(self, show: Show) -> None:
        self._show = show
        self._floor = Floor()
        self._shape = (0, 0)
        self._corner = np.zeros(2, np.int64)
        self._start: NDArray[np.bool_] = np.zeros((0, 0), np.bool_)
        self._grids: dict[str, _Grid] = {}
        self._came: NDArray[np.bool_] = np.zeros(0, np.bool_)
        self._came_due = _Due(0)
        self._paths: list[NDArray[np.float64]] = []
        self._path_time: int | None = None
        self._robots = Robots(show)
        self.mission = False
        """True if the run is a mission, known from its first event."""
        self._makers: dict[Subject, Callable[[Any], None]] = {
            Subject.MAP: self._map,
            Subject.CHANGE: self._obstacle,
            Subject.BELIEF: self._belief,
            Subject.PATH: self._trajectory,
            Subject.POSE: self._robots.posed,
            Subject.FLEET: self._robots.placed,
            Subject.STAGE: self._field,
            Subject.FIELD: self._field,
            Subject.SCAN: self._scan,
            Subject.EVENT: self._event,
            Subject.RESULT: lambda record: self.finish(record.time),
        }

    def of(self, record: Record) -> None:
        """Show the views after ``record``."""
        maker = self._makers.get(record.ROLE.about)
        if self._paths and (maker is not None and record.time != self._path_time):
            self._path()
        if maker is not None:
            maker(record)

    def finish(self, time: int) -> None:
        """Show the last state of everything that has changed since it was shown."""
        if self._paths:
            self._path()
        for grid in self._grids.values():
            grid.shown(self._show, time, self._floor, last=True)
        if self._came_due.now(time, last=True):
            self._obstacles(time)
        self._robots.finish(time)

    def _map(self, record: MapRecord) -> None:
        self._floor, self._shape = floor_of(record), record.free.shape
        self._corner, self._start = np.array(record.corner), record.free
        self._grids.clear()
        self._came = np.zeros(record.free.size, np.bool_)
        self._robots.begin(self._floor, record.radius * self._floor.cell_size)
        if record.free.size:
            walls = np.where(record.free, shapes.FREE_NOW, shapes.WALL).astype(np.uint8)
            self._grid("/map", "true", walls).shown(self._show, record.time, self._floor)
        side, goals = self._floor.cell_size, self._floor.points(record.goals)
        spheres = [
            fg.SpherePrimitive(
                pose=shapes.pose(x, y), size=fg.Vector3(x=side, y=side, z=side), color=shapes.colour(shapes.GOAL)
            )
            for x, y in goals.tolist()
        ]
        self._show("/goals", shapes.scene("goals", record.time, spheres=spheres), record.time)
        self._show("/goals/points", shapes.cloud(goals, shapes.GOAL, record.time, 0.03), record.time)
        # What the run before showed is cleared: there are no obstacles that came, and no path.
        self._came_due = _Due(record.time)
        self._obstacles(record.time)
        self._show("/path", shapes.scene("path", record.time), record.time)

    def _obstacle(self, record: ObstacleRecord) -> None:
        places = self._places(record.cells)
        if places is None:
            return
        began_free = self._start.ravel()[places]
        states = (shapes.WALL, shapes.CAME) if record.appeared else (shapes.GONE, shapes.FREE_NOW)
        grid = self._grids["/map"]
        grid.cells.ravel()[places] = np.array(states, np.uint8)[began_free.view(np.uint8)]
        grid.due.changed = True
        self._came[places[began_free]] = record.appeared
        self._came_due.changed = True
        grid.shown(self._show, record.time, self._floor)
        if self._came_due.now(record.time):
            self._obstacles(record.time)

    def _obstacles(self, time: int) -> None:
        """All cells that came, as bars along the rows and as points."""
        came = np.flatnonzero(self._came)
        self._came_due.interval = max(OBSTACLES_INTERVAL, INTERVAL_A_CAME * len(came))
        cells = np.column_stack(np.divmod(came, max(self._shape[1], 1)))
        side, turned = self._floor.cell_size, self._floor.yaw
        first = np.ones(len(cells), bool)
        first[1:] = (np.diff(cells, axis=0) != (0, 1)).any(axis=1)
        starts = np.flatnonzero(first)
        lengths = np.diff(np.r_[starts, len(cells)])
        middles = cells[starts] + np.column_stack([np.zeros(len(starts)), (lengths - 1) / 2])
        places = self._floor.points(middles + self._corner)
        cubes = [
            fg.CubePrimitive(
                pose=shapes.pose(x, y, turned, side / 2),
                size=fg.Vector3(x=side * length, y=side, z=side),
                color=shapes.colour(shapes.OBSTACLE),
            )
            for (x, y), length in zip(places[:MOST_CUBES].tolist(), lengths.tolist(), strict=False)
        ]
        self._show("/obstacles", shapes.scene("obstacles", time, cubes=cubes), time)
        points = self._floor.points(cells + self._corner)
        self._show("/obstacles/points", shapes.cloud(points, shapes.OBSTACLE, time, side), time)

    def _belief(self, record: BeliefRecord) -> None:
        places = self._places(record.cells)
        if places is None:
            return
        name = f"/{record.source}"
        grid = self._grids.get(name) or self._grid(name, "belief", np.full(self._shape, UNKNOWN, np.uint8))
        grid.cells.ravel()[places] = _BELIEFS[record.blocked.view(np.uint8)]
        grid.due.changed = True
        grid.shown(self._show, record.time, self._floor)

    def _places(self, cells: NDArray[np.int32]) -> NDArray[np.intp] | None:
        """The numbers of the cells, row by row; None where one lies outside of the map."""
        rows, columns = (cells - self._corner).T
        try:
            places: NDArray[np.intp] = np.ravel_multi_index((rows, columns), self._shape)
        except ValueError:
            return None
        return places

    def _field(self, record: Record) -> None:
        """Keep the field until its plan is ready. A harmonic plan has a field for each stage."""
        values: NDArray[np.float64] = getattr(record, record.ROLE.grid)
        if values.shape != self._shape or not values.size:
            return
        topic = f"/{record.source}/plan"
        if topic not in self._grids:
            self._grid(topic, "field", values)
        grid = self._grids[topic]
        grid.cells, grid.due.changed = values, True
        if not self.mission:
            grid.shown(self._show, record.time, self._floor, last=True)

    def _grid(self, topic: str, kind: str, cells: NDArray[Any]) -> _Grid:
        self._grids[topic] = _Grid(topic, kind, cells)
        return self._grids[topic]

    def _trajectory(self, record: TrajectoryRecord) -> None:
        """Keep the path until the time goes on. Paths of one time are shown side by side."""
        self._path_time = record.time
        self._paths.append(self._floor.points(record.points))

    def _path(self) -> None:
        time, paths, self._paths = self._path_time or 0, self._paths, []
        most = _POINTS_OF_PATH // len(paths)
        lines = [shapes.line(shapes.thinned(path, most), shapes.PATH, 0.01) for path in paths]
        dense = [shapes.densified(path, self._floor.cell_size, most) for path in paths]
        self._show("/path", shapes.scene("path", time, lines=lines), time)
        self._show("/path/points", shapes.cloud(np.concatenate(dense), shapes.PATH, time, 0.01), time)

    def _scan(self, record: ScanRecord) -> None:
        """Rays turn clockwise in frame ``map``, whose y axis points up."""
        x, y = self._floor.point(record.row, record.column)
        rays = len(record.ranges)
        self._show(
            f"/{record.source}/laser",
            fg.LaserScan(
                timestamp=shapes.stamp(record.time),
                frame_id=shapes.MAP_FRAME,
                pose=shapes.pose(x, y, self._floor.yaw),
                start_angle=0.0,
                end_angle=-2 * math.pi * (rays - 1) / max(rays, 1),
                ranges=shapes.rounded(record.ranges * np.float64(self._floor.cell_size)).tolist(),
                intensities=[],
            ),
            record.time,
        )

    def _event(self, record: MissionRecord) -> None:
        self.mission = True
        self._show(
            "/log",
            fg.Log(
                timestamp=shapes.stamp(record.time),
                level=fg.LogLevel.Warning if record.event in _ALARMS else fg.LogLevel.Info,
                message=f"{record.event.replace('_', ' ')}: {record.text}",
                name=record.source,
                file="",
                line=0,
            ),
            record.time,
        )
        if record.event == "plan_ready":
            for grid in self._grids.values():
                if grid.kind == "field":
                    grid.shown(self._show, record.time, self._floor)
        if record.event == "ended":
            self.finish(record.time)


class _Due:
    """The time at which a changing state is to be written again: ``interval`` picoseconds after the last time."""

    def __init__(self, interval: int) -> None:
        self.interval = interval
        self.changed = False
        self._written: int | None = None

    def now(self, time: int, *, last: bool = False) -> bool:
        """True if it is due now. True counts as written."""
        soon = self._written is not None and time - self._written < self.interval
        if not self.changed or (soon and not last):
            return False
        self._written, self.changed = time, False
        return True


class _Grid:
    """A grid that changes (uint8 or float64, rows × columns), under ``topic`` with an ending."""

    def __init__(self, topic: str, kind: str, cells: NDArray[Any]) -> None:
        self.kind, self.cells = kind, cells
        self.topic = f"{topic}_" if kind == "field" else f"{topic}/"
        self.due = _Due(max(SHORTEST_INTERVAL, INTERVAL_A_CELL * cells.size))
        self.due.changed = True
        self._voxels = _Due(max(SHORTEST_INTERVAL, VOXELS_A_GRID * INTERVAL_A_CELL * cells.size))

    def shown(self, show: Show, time: int, floor: Floor, *, last: bool = False) -> None:
        """Show the grid, where it is due, and its voxels."""
        if self.due.now(time, last=last):
            step = math.isqrt(max(self.cells.size - 1, 0) // MOST_SHOWN) + 1
            grid, voxels = shapes.grids(self.kind, self.cells, time, floor, _HEIGHTS[self.kind], step)
            show(f"{self.topic}grid", grid, time)
            self._voxels.changed = True
            if self._voxels.now(time, last=last):
                show(f"{self.topic}voxels", voxels, time)


LIBRARY = "hwsw-codesign"
FORMAT = "2"
"""Increased when a reader of the old format would misread the new one. Format 1 had messages in JSON."""

CHUNK_BYTES = 2**20
"""A chunk is written when its records have so many bytes. A killed run loses at most the last chunk."""

COMPRESSION = 5
"""The level of zstd: up to 17 % smaller than its default of 3. Level 7 makes 4 % of that again, for twice the time."""

BATCH = 512
"""So many records are kept before they are written, so a killed run loses them too."""

RUN = "run"
RUN_ATTACHMENT = "run.json"


class McapListener(WholeOrAbsent, Recorder):
    """Writes records to an MCAP file, and views of them for Foxglove and Rerun.

    - ``path``: the file, overwritten at the end. ``identity``: texts that identify the run (names, digests, seed,
      version). They are written into the metadata ``run`` and the attachment ``run.json``. No clock, host or user is
      written. ``level``: how much is written (``Level``).

    The file is written under a temporary name beside ``path`` (a dot, the name, ``.part``) and renamed by ``close``. As
    a context manager it closes at the end of the block. If an exception or Ctrl-C ends the block, the temporary file is
    removed: a trace is complete or absent. Only a killed process leaves its temporary file, and all its complete chunks
    can be read until another trace is written there.

    Raises:
        TraceError: the file cannot be made or written (missing folder, no permission, full disk). The temporary file is
            removed.
    """

    def __init__(
        self, path: str | Path, identity: Mapping[str, str] | None = None, level: Level = Level.BLOCKS
    ) -> None:
        super().__init__(path)
        self.level = level
        self._part = part_of(self._target)
        self._channels: dict[tuple[type, str], Any] = {}
        self._shown: dict[str, Any] = {}
        self._taken: list[Record] = []
        self._time = 0
        if self.path.is_dir():
            raise TraceError("is a folder", str(self.path), "name a file in it")
        if is_special(self.path):
            raise TraceError("is no regular file", str(self.path), "name a regular file: a trace needs one")
        self._views, levels = Views(self._show), list(Level)
        above = levels[levels.index(level) + 1 :]
        self._unwanted = frozenset(kind for kind in RECORD_TYPES.values() if kind.ROLE.level in above)
        self._file: _File | None = None
        with self._guard():
            self._hold(self._part)
            self._file = _File(self._part.open("xb", buffering=0))
            self._context, self._writer = _writer(self._file)
        run = {"format": FORMAT, "library": LIBRARY, "level": level.value, **(identity or {})}
        self._writer.write_metadata(RUN, run)
        self.attach(
            RUN_ATTACHMENT,
            "application/json",
            json.dumps(run, indent=1, ensure_ascii=False, allow_nan=False).encode() + b"\n",
        )

    @property
    def unwanted(self) -> frozenset[type[Record]]:
        """The classes of records that its level leaves out."""
        return self._unwanted

    def __call__(self, record: Record) -> None:
        """Take one record. Records are written by hundreds, which takes less time than one by one.

        Raises:
            TraceError: see the class. Also: a trace cannot hold a record, or the file is closed.
        """
        if self._finished:
            self._refuse_closed()
        kind = type(record)
        if kind not in self._unwanted:
            self._taken.append(record)
            if len(self._taken) >= BATCH or kind.ROLE.grid or kind.ROLE.about is Subject.RESULT:
                self._flush()

    def _flush(self) -> None:
        taken, self._taken = self._taken, []
        for record in taken:
            self._put(record)
        self._check()

    def _put(self, record: Record) -> None:
        """Write one record, then its views. Their times are rounded down to nanoseconds."""
        for each in record.singles() if self.level is Level.ITERATIONS else (record,):
            # A mission may plan a thousand times, so its fields are left out here and shown by the views at intervals.
            is_bare = self._views.mission and self.level is not Level.ITERATIONS
            self._write(each.bare() if is_bare else each)
        self._time = record.time
        self._views.of(record)

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment, such as the text of a spec.

        Raises:
            TraceError: see the class.
        """
        if self._finished:
            self._refuse_closed()
        self._writer.attach(log_time=0, create_time=0, name=name, media_type=media_type, data=data)
        self._check()

    def _finish(self) -> None:
        self._flush()
        self._views.finish(self._time)
        self._writer.close()
        self._check()
        with self._guard():
            self._drop()
            put(self._part, self._target)

    def _drop(self) -> None:
        if self._file is not None:
            self._file.raw.close()

    def _write(self, record: Record) -> None:
        kind = type(record)
        key = kind, record.source
        pair = self._channels.get(key)
        if pair is None:
            # Records of the run as a whole share a topic, whatever their source is.
            topic = kind, topic_of(kind, record.source)
            if topic not in self._channels:
                self._channels[topic] = Channel(
                    topic_of(kind, record.source),
                    message_encoding="protobuf",
                    schema=Schema(name=schema_name(kind), encoding="protobuf", data=descriptor_set(kind)),
                    metadata={"record": kind.__name__, "source": record.source},
                    context=self._context,
                ).base
            pair = self._channels[key] = encoder_of(kind), self._channels[topic].log
        encode, log = pair
        log(encode(record), record.time // 1000)

    def _show(self, topic: str, message: Any, time: int) -> None:
        channel = self._shown.get(topic)
        if channel is None:
            channel = self._shown[topic] = _view_channel(message, topic, self._context)
        channel.log(message.data if isinstance(message, Encoded) else message, log_time=time // 1000)

    def _check(self) -> None:
        """Report what the file could not take."""
        if self._file is not None and self._file.fault is not None:
            with self._guard():
                raise self._file.fault

    def _refuse_closed(self) -> None:
        raise TraceError("is closed", str(self.path), "emit no record after the end of the run")

    @contextmanager
    def _guard(self) -> Iterator[None]:
        """Remove the temporary file where a write fails, and raise a ``TraceError``."""
        try:
            yield
        except OSError as fault:
            self.abort()
            hint = "name a file in a folder that exists, can be written to and has free space"
            raise TraceError(f"cannot be written: {fault.strerror or fault}", str(self.path), hint) from fault


class _File:
    """A file for the writer of the SDK, which would only log a failed write: the first fault is kept in ``fault``.

    What the writer gives after a fault, or after the file was closed, is dropped.
    """

    def __init__(self, raw: BinaryIO) -> None:
        self.raw = raw
        self.fault: OSError | None = None
        self._at = 0

    def write(self, data: bytes) -> int:
        """Write all of ``data``."""
        if self.fault is None and not self.raw.closed:
            try:
                rest = memoryview(data)
                while rest:
                    rest = rest[self.raw.write(rest) :]
            except OSError as fault:
                self.fault = fault
        self._at += len(data)
        return len(data)

    def seek(self, _offset: int, _whence: int = 0) -> int:
        """The place in the file. The writer does not move (``disable_seeking``)."""
        return self._at

    def flush(self) -> None:
        """Nothing: the file has no buffer."""


def _writer(file: _File) -> tuple[Context, MCAPWriter]:
    """A writer of whole chunks: the header of a chunk is never written before its content."""
    context = foxglove.Context()
    options = MCAPWriteOptions(
        compression=MCAPCompression.Zstd,
        compression_level=COMPRESSION,
        chunk_size=CHUNK_BYTES,
        profile="",
        disable_seeking=True,
        compression_threads=0,
    )
    return context, foxglove.open_mcap(file, context=context, writer_options=options)  # type: ignore[arg-type]


def _view_channel(message: Any, topic: str, context: Context) -> Any:
    if isinstance(message, Encoded):
        schema = message.kind.get_schema()
        return Channel(topic, message_encoding="protobuf", schema=schema, context=context).base
    return vars(channels)[f"{type(message).__name__}Channel"](topic, context=context)
