"""Messages for viewers, derived from the stream of records: the current maps, and a scene.

Changes of the true map (``ObstacleRecord``) and of a robot's belief (``BeliefRecord``) are small and exact, but viewers
do not draw them. So a whole grid of each is written beside them at intervals. The interval grows with the map, so the
bytes for each second of a mission are bounded. The fields of plans, which the records of a mission leave out, are shown
in the same manner, each when its plan is ready. The scene has the last planned path, and obstacles as cubes, without an
interval. Our reader ignores these messages.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.records import (
    BeliefRecord,
    FieldRecord,
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    Record,
    StageRecord,
    SummaryRecord,
    TrajectoryRecord,
)
from codesign.trace.encoding import packed, schema_of
from codesign.trace.foxglove import POSE, TIMESTAMP, VECTOR, Floor, floor_of, pose, timestamp
from codesign.trace.grid import BLOCKED, FREE, UNKNOWN, encode_grid
from codesign.units import PICOSECONDS_PER_SECOND

SHORTEST_INTERVAL = PICOSECONDS_PER_SECOND
INTERVAL_A_BYTE = 64 * 10**6
"""Picoseconds between two whole grids: at least 1 s, and 64 us a byte. A map has 1 byte a cell, a field 8.

In base64 that is at most 21 kB of JSON a second and grid, before compression.
"""

MOST_CUBES = 256
"""Most cells of a record that are shown as cubes. Larger changes are shown by the grids alone."""

_FLAT = {"x": 0.0, "y": 0.0, "z": 0.0}
_PATH = {"r": 0.82, "g": 0.29, "b": 0.36, "a": 1.0}
_OBSTACLE = {"r": 0.85, "g": 0.55, "b": 0.13, "a": 0.9}


@dataclass(frozen=True)
class View:
    """A message for viewers: its topic, its source, the name and the JSON of its schema, and its bytes."""

    topic: str
    source: str
    schema: str
    schema_json: bytes
    data: bytes


class Views:
    """Takes the records of a run in the order of emission, and returns the views after each.

    A record that does not fit the map of its run, or comes before the map, has no view.
    """

    def __init__(self) -> None:
        self._floor = Floor()
        self._shape = (0, 0)
        self._corner = np.zeros(2, np.int64)
        self._grids: dict[str, _Snapshots] = {}
        self._fields: dict[str, _Snapshots] = {}
        self.mission = False
        """Whether the run is a mission, known from its first event."""
        self._walls: NDArray[np.uint8] = np.zeros(self._shape, np.uint8)
        self._path_time = -1
        self._paths = 0

    def of(self, record: Record) -> Iterator[View]:
        """The views after ``record``."""
        if isinstance(record, MapRecord):
            self._begin(record)
        elif isinstance(record, ObstacleRecord) and self._inside(record.cells):
            grid = self._grid(record.source, "occupied_now", self._walls)
            grid.put(record.cells - self._corner, int(record.appeared))
            yield from self._shown(grid, record.time)
            if len(record.cells) <= MOST_CUBES:
                yield self._scene(record, *self._cubes(record))
        elif isinstance(record, BeliefRecord) and self._inside(record.cells):
            grid = self._grid(record.source, "belief", np.full(self._shape, UNKNOWN, np.uint8))
            grid.put(record.cells - self._corner, np.where(record.blocked, BLOCKED, FREE))
            yield from self._shown(grid, record.time)
        elif isinstance(record, TrajectoryRecord):
            yield self._scene(record, [self._line(record)], [])
        elif isinstance(record, StageRecord) and self.mission:
            self._field(record.source, "potential", record.potential)
        elif isinstance(record, FieldRecord) and self.mission:
            self._field(record.source, record.name, record.values)
        elif isinstance(record, MissionRecord | SummaryRecord):
            yield from self._happened(record)

    def _happened(self, record: MissionRecord | SummaryRecord) -> Iterator[View]:
        last = isinstance(record, SummaryRecord) or record.event == "ended"
        self.mission = self.mission or isinstance(record, MissionRecord)
        if last or (isinstance(record, MissionRecord) and record.event == "plan_ready"):
            for field in self._fields.values():
                yield from self._shown(field, record.time, last)
        if last:
            for grid in self._grids.values():
                yield from self._shown(grid, record.time, last)

    def _begin(self, record: MapRecord) -> None:
        self._floor = floor_of(record)
        self._shape = record.free.shape
        self._corner = np.array(record.corner)
        self._walls = (~record.free).astype(np.uint8)
        self._grids.clear()

    def _inside(self, cells: NDArray[np.int32]) -> bool:
        here = cells - self._corner
        return bool(self._shape[0] and ((here >= 0) & (here < self._shape)).all())

    def _field(self, source: str, name: str, values: NDArray[np.float64]) -> None:
        """Keep the field until its plan is ready. A harmonic plan has a field for each stage."""
        if values.ndim != 2 or not values.size:
            return
        topic = f"/{source}/plan_grid"
        if topic not in self._fields or self._fields[topic].cells.shape != values.shape:
            self._fields[topic] = _Snapshots(topic, source, name, values)
        self._fields[topic].replace(name, values)

    def _grid(self, source: str, name: str, begin: NDArray[np.uint8]) -> _Snapshots:
        topic = f"/{source}/grid"
        if topic not in self._grids:
            self._grids[topic] = _Snapshots(topic, source, name, begin)
        return self._grids[topic]

    def _shown(self, grid: _Snapshots, time: int, last: bool = False) -> Iterator[View]:
        if grid.due(time, last):
            message = encode_grid(grid.cells, time, self._floor, grid.name)
            yield _view(grid.topic, "foxglove.Grid", time, grid.source, message)

    def _scene(self, record: Record, entities: list[Any], deletions: list[Any]) -> View:
        message = {"deletions": deletions, "entities": entities}
        return _view("/scene", "foxglove.SceneUpdate", record.time, "scene", message)

    def _cubes(self, record: ObstacleRecord) -> tuple[list[Any], list[Any]]:
        """The new entities and the deletions, one a cell, so that each cell can be deleted."""
        entities, deletions = [], []
        side = self._floor.cell_size
        for row, column in record.cells.tolist():
            name = f"obstacle {row} {column}"
            if not record.appeared:
                deletions.append({"timestamp": timestamp(record.time), "type": 0, "id": name})
                continue
            middle = self._floor.place(row, column, side / 2)
            cube = {
                "pose": pose(middle, -self._floor.yaw),
                "size": {"x": side, "y": side, "z": side},
                "color": _OBSTACLE,
            }
            entities.append(_entity(record.time, name, cubes=[cube]))
        return entities, deletions

    def _line(self, record: TrajectoryRecord) -> dict[str, Any]:
        """The path as an entity that replaces the last one. Paths of one time are shown side by side."""
        self._paths = self._paths + 1 if record.time == self._path_time else 0
        self._path_time = record.time
        line = {
            "type": 0,
            "pose": pose(_FLAT),
            "thickness": 2.0,
            "scale_invariant": True,
            "points": [self._floor.place(row, column) for row, column in record.points.tolist()],
            "color": _PATH,
            "colors": [],
            "indices": [],
        }
        return _entity(record.time, f"way {self._paths}", lines=[line])


class _Snapshots:
    """A grid that changes (uint8 or float64, rows × columns), and the time of its last writing."""

    def __init__(self, topic: str, source: str, name: str, cells: NDArray[Any]) -> None:
        self.topic, self.source, self.name = topic, source, name
        self.cells = cells.copy()
        self._interval = max(SHORTEST_INTERVAL, INTERVAL_A_BYTE * cells.nbytes)
        self._written: int | None = None
        self._changed = False

    def put(self, cells: NDArray[np.integer[Any]], values: Any) -> None:
        self.cells[cells[:, 0], cells[:, 1]] = values
        self._changed = True

    def replace(self, name: str, cells: NDArray[Any]) -> None:
        self.name, self.cells, self._changed = name, cells, True

    def due(self, time: int, last: bool) -> bool:
        """Whether it is due now. True counts as written."""
        soon = self._written is not None and time - self._written < self._interval
        if not self._changed or (soon and not last):
            return False
        self._written, self._changed = time, False
        return True


def _view(topic: str, schema: str, time: int, source: str, message: dict[str, Any]) -> View:
    schema_json = schema_of(MapRecord) if schema == "foxglove.Grid" else SCENE_SCHEMA
    return View(
        topic, source, schema, schema_json, packed(schema, {"time": time, "source": source, **message})
    )


_PRIMITIVES = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")


def _entity(time: int, name: str, **primitives: list[Any]) -> dict[str, Any]:
    """An entity that stays until it is replaced or deleted."""
    return {
        "timestamp": timestamp(time),
        "frame_id": "map",
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": False,
        "metadata": [],
        **{kind: primitives.get(kind, []) for kind in _PRIMITIVES},
    }


def _object(title: str, **properties: Any) -> dict[str, Any]:
    return {"type": "object", "title": title, "properties": properties}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


def _scene_schema() -> bytes:
    """The JSON schema of the scene, UTF-8. The primitives in use are described in full."""
    text, number, truth = ({"type": kind} for kind in ("string", "number", "boolean"))
    whole = {"type": "integer"}
    place = _object("foxglove.Vector3", **VECTOR)
    color = _object("foxglove.Color", r=number, g=number, b=number, a=number)
    cube = _object("foxglove.CubePrimitive", pose=POSE, size=place, color=color)
    line = _object(
        "foxglove.LinePrimitive", type=whole, pose=POSE, thickness=number, scale_invariant=truth,
        points=_list(_object("foxglove.Point3", **VECTOR)), color=color, colors=_list(color), indices=_list(whole),
    )  # fmt: skip
    primitives = {kind: _list(_object("")) for kind in _PRIMITIVES}
    key_value = _object("foxglove.KeyValuePair", key=text, value=text)
    entity = _object(
        "foxglove.SceneEntity",
        timestamp=TIMESTAMP,
        frame_id=text,
        id=text,
        lifetime={**TIMESTAMP, "title": "duration"},
        frame_locked=truth,
        metadata=_list(key_value),
        **{**primitives, "cubes": _list(cube), "lines": _list(line)},
    )
    deletion = _object("foxglove.SceneEntityDeletion", timestamp=TIMESTAMP, type=whole, id=text)
    schema = _object(
        "foxglove.SceneUpdate", time=whole, source=text, deletions=_list(deletion), entities=_list(entity)
    )
    schema["required"] = ["time", "source", "deletions", "entities"]
    return json.dumps(schema).encode()


SCENE_SCHEMA = _scene_schema()
"""The JSON schema of the scene."""
