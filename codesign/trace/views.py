"""Messages for viewers, derived from the stream of records. Our reader ignores them.

Each topic shows one thing, and each of its messages the whole state of it, so that a viewer may jump to any time:

    /map/grid, /SOURCE/grid         the true map; what a robot believes        foxglove.Grid
    /SOURCE/plan_grid               the field of the last plan                 foxglove.Grid
    /map/voxels, ...                the same grids, for Rerun                  foxglove.VoxelGrid
    /path, /obstacles, /goals       the planned path, cells that came, goals   foxglove.SceneUpdate
    /trails                         the last positions of the robots           foxglove.SceneUpdate
    /path/points, ...               the same four, for Rerun                   foxglove.PointCloud
    /tf                             frame ``map`` to the frames of the robots  foxglove.FrameTransforms
    /robots, /robots/points         robots, each in its own frame              foxglove.SceneUpdate, PointCloud
    /SOURCE/laser                   the last scan of a sensor of rays          foxglove.LaserScan
    /log                            the events of a mission                    foxglove.Log

Large states are written at intervals that grow with them, so the bytes for each second of a mission are bounded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from foxglove import messages as fg
from numpy.typing import NDArray

from codesign.records import (
    BeliefRecord,
    FieldRecord,
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    ScanRecord,
    StageRecord,
    SummaryRecord,
    TrajectoryRecord,
)
from codesign.trace import shapes
from codesign.trace.floor import BLOCKED, FREE, UNKNOWN, Floor, floor_of
from codesign.trace.robots import Robots
from codesign.units import PICOSECONDS_PER_SECOND

View = tuple[str, Any]
"""A topic and a message of Foxglove's SDK."""

SHORTEST_INTERVAL = PICOSECONDS_PER_SECOND
INTERVAL_A_CELL = 64 * 10**6
"""Picoseconds between two whole grids: at least 1 s, and 64 us a cell."""

OBSTACLES_INTERVAL, INTERVAL_A_CAME = PICOSECONDS_PER_SECOND // 5, PICOSECONDS_PER_SECOND // 1000
"""Picoseconds between two messages of the obstacles that came: at least 0.2 s, and 1 ms a cell."""

MOST_SHOWN = 2**20
"""Most cells of a grid for viewers. Of a larger map, each n-th row and column is shown."""

MOST_CUBES = 2048
"""Most bars of obstacles in a scene. Where there are more, the grid of the map shows the rest."""

_POINTS_OF_PATH = 4096
_ALARMS = {"no_way", "deadline_missed", "safety_stop", "contact", "livelock"}
_HEIGHTS = {"true": -0.03, "belief": -0.02, "field": -0.01}
"""The heights of grids in metres. They lie above each other, so that they do not flicker in one plane."""


class Views:
    """Takes the records of a run in the order of emission, and returns the views after each.

    A record that does not fit the map of its run, or comes before the map, has no view.
    """

    def __init__(self) -> None:
        self._floor = Floor()
        self._shape = (0, 0)
        self._corner = np.zeros(2, np.int64)
        self._start: NDArray[np.bool_] = np.zeros((0, 0), np.bool_)
        self._grids: dict[str, _Grid] = {}
        self._came: set[tuple[int, int]] = set()
        self._came_due = _Due(0)
        self._paths: list[NDArray[np.float64]] = []
        self._path_time: int | None = None
        self._robots = Robots(self._floor, 0.0)
        self.mission = False
        """Whether the run is a mission, known from its first event."""
        self._makers: dict[type[Record], Callable[[Any], Iterator[View]]] = {
            MapRecord: self._map,
            ObstacleRecord: self._obstacle,
            BeliefRecord: self._belief,
            TrajectoryRecord: self._trajectory,
            PoseRecord: self._posed,
            PositionsRecord: self._placed,
            StageRecord: lambda record: self._field(record, record.potential),
            FieldRecord: lambda record: self._field(record, record.values),
            ScanRecord: self._scan,
            MissionRecord: self._event,
            SummaryRecord: lambda record: self.finish(record.time),
        }

    def shows(self, record_type: type[Record]) -> bool:
        """Whether records of this class have views."""
        return record_type in self._makers

    def of(self, record: Record) -> Iterator[View]:
        """The views after ``record``."""
        maker = self._makers.get(type(record))
        if self._paths and (maker is not None and record.time != self._path_time):
            yield from self._path()
        if maker is not None:
            yield from maker(record)

    def finish(self, time: int) -> Iterator[View]:
        """The last state of everything that has changed since it was shown."""
        if self._paths:
            yield from self._path()
        for grid in self._grids.values():
            yield from grid.shown(time, self._floor, last=True)
        if self._came_due.now(time, last=True):
            yield from self._obstacles(time)
        yield from self._robots.finish(time)

    def _map(self, record: MapRecord) -> Iterator[View]:
        self._floor, self._shape = floor_of(record), record.free.shape
        self._corner, self._start = np.array(record.corner), record.free
        self._grids.clear()
        self._came.clear()
        self._robots = Robots(self._floor, record.radius * self._floor.cell_size)
        if record.free.size:
            walls = np.where(record.free, shapes.FREE_NOW, shapes.WALL).astype(np.uint8)
            yield from self._grid("/map", "true", walls).shown(record.time, self._floor)
        side, goals = self._floor.cell_size, self._floor.points(record.goals)
        spheres = [
            fg.SpherePrimitive(
                pose=shapes.pose(x, y),
                size=fg.Vector3(x=side, y=side, z=side),
                color=shapes.colour(shapes.GOAL),
            )
            for x, y in goals.tolist()
        ]
        yield "/goals", shapes.scene("goals", record.time, spheres=spheres)
        yield "/goals/points", shapes.cloud(goals, shapes.GOAL, record.time, 0.03)
        # What the run before showed is cleared: there are no obstacles that came, and no path.
        self._came_due = _Due(record.time)
        yield from self._obstacles(record.time)
        yield "/path", shapes.scene("path", record.time)

    def _obstacle(self, record: ObstacleRecord) -> Iterator[View]:
        here = record.cells - self._corner
        if not self._inside(here):
            return
        cells = here[:, 0], here[:, 1]
        began_free = self._start[cells]
        states = (shapes.CAME, shapes.WALL) if record.appeared else (shapes.FREE_NOW, shapes.GONE)
        grid = self._grids["/map"]
        grid.cells[cells] = np.where(began_free, *states)
        grid.due.changed = True
        new = set(map(tuple, here[began_free].tolist()))
        self._came = self._came | new if record.appeared else self._came - new
        self._came_due.changed = True
        yield from grid.shown(record.time, self._floor)
        if self._came_due.now(record.time):
            yield from self._obstacles(record.time)

    def _obstacles(self, time: int) -> Iterator[View]:
        """All cells that came, as bars along the rows and as points."""
        self._came_due.interval = max(OBSTACLES_INTERVAL, INTERVAL_A_CAME * len(self._came))
        cells = np.array(sorted(self._came), np.int64).reshape(-1, 2)
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
        yield "/obstacles", shapes.scene("obstacles", time, cubes=cubes)
        points = self._floor.points(cells + self._corner)
        yield "/obstacles/points", shapes.cloud(points, shapes.OBSTACLE, time, side)

    def _belief(self, record: BeliefRecord) -> Iterator[View]:
        here = record.cells - self._corner
        if not self._inside(here):
            return
        name = f"/{record.source}"
        grid = self._grids.get(name) or self._grid(name, "belief", np.full(self._shape, UNKNOWN, np.uint8))
        grid.cells[here[:, 0], here[:, 1]] = np.where(record.blocked, BLOCKED, FREE)
        grid.due.changed = True
        yield from grid.shown(record.time, self._floor)

    def _inside(self, here: NDArray[np.integer[Any]]) -> bool:
        return bool(self._shape[0] and ((here >= 0) & (here < self._shape)).all())

    def _field(self, record: Record, values: NDArray[np.float64]) -> Iterator[View]:
        """Keep the field until its plan is ready. A harmonic plan has a field for each stage."""
        if values.shape != self._shape or not values.size:
            return
        topic = f"/{record.source}/plan"
        if topic not in self._grids:
            self._grid(topic, "field", values)
        grid = self._grids[topic]
        grid.cells, grid.due.changed = values, True
        if not self.mission:
            yield from grid.shown(record.time, self._floor, last=True)

    def _grid(self, topic: str, kind: str, cells: NDArray[Any]) -> _Grid:
        self._grids[topic] = _Grid(topic, kind, cells)
        return self._grids[topic]

    def _trajectory(self, record: TrajectoryRecord) -> Iterator[View]:
        """Keep the path until the time goes on. Paths of one time are shown side by side."""
        self._path_time = record.time
        self._paths.append(self._floor.points(record.points))
        yield from ()

    def _path(self) -> Iterator[View]:
        time, paths, self._paths = self._path_time or 0, self._paths, []
        most = _POINTS_OF_PATH // len(paths)
        lines = [shapes.line(path[:_POINTS_OF_PATH], shapes.PATH, 0.01) for path in paths]
        dense = [shapes.densified(path, self._floor.cell_size / 2, most) for path in paths]
        yield "/path", shapes.scene("path", time, lines=lines)
        yield "/path/points", shapes.cloud(np.concatenate(dense), shapes.PATH, time, 0.01)

    def _posed(self, record: PoseRecord) -> Iterator[View]:
        return self._robots.posed(record)

    def _placed(self, record: PositionsRecord) -> Iterator[View]:
        return self._robots.placed(record)

    def _scan(self, record: ScanRecord) -> Iterator[View]:
        """Rays turn clockwise in frame ``map``, whose y axis points up."""
        x, y = self._floor.point(record.row, record.column)
        rays = len(record.ranges)
        yield (
            f"/{record.source}/laser",
            fg.LaserScan(
                timestamp=shapes.stamp(record.time),
                frame_id=shapes.MAP_FRAME,
                pose=shapes.pose(x, y, self._floor.yaw),
                start_angle=0.0,
                end_angle=-2 * math.pi * (rays - 1) / max(rays, 1),
                ranges=(record.ranges * self._floor.cell_size).tolist(),
                intensities=[],
            ),
        )

    def _event(self, record: MissionRecord) -> Iterator[View]:
        self.mission = True
        yield (
            "/log",
            fg.Log(
                timestamp=shapes.stamp(record.time),
                level=fg.LogLevel.Warning if record.event in _ALARMS else fg.LogLevel.Info,
                message=f"{record.event.replace('_', ' ')}: {record.text}",
                name=record.source,
                file="",
                line=0,
            ),
        )
        if record.event == "plan_ready":
            for grid in self._grids.values():
                if grid.kind == "field":
                    yield from grid.shown(record.time, self._floor)
        if record.event == "ended":
            yield from self.finish(record.time)


class _Due:
    """When a state that changes is to be written again: ``interval`` picoseconds after the last time."""

    def __init__(self, interval: int) -> None:
        self.interval = interval
        self.changed = False
        self._written: int | None = None

    def now(self, time: int, *, last: bool = False) -> bool:
        """Whether it is due now. True counts as written."""
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

    def shown(self, time: int, floor: Floor, *, last: bool = False) -> Iterator[View]:
        """The grid and its voxels, where they are due."""
        if self.due.now(time, last=last):
            step = math.isqrt(max(self.cells.size - 1, 0) // MOST_SHOWN) + 1
            grid, voxels = shapes.grids(self.kind, self.cells, time, floor, _HEIGHTS[self.kind], step)
            yield f"{self.topic}grid", grid
            yield f"{self.topic}voxels", voxels
