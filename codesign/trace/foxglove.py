"""Standard fields for Foxglove and similar viewers, beside a record's own fields.

A pose becomes a ``foxglove.PoseInFrame``, the positions of many robots become a ``foxglove.PosesInFrame``, and an event
of a mission becomes a ``foxglove.Log``. Maps and fields are grids (``grid.py``). Metres and quaternions are rounded for
display. The record's own fields are exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from codesign.frame import Frame
from codesign.records import MapRecord, MissionRecord, PoseRecord, PositionsRecord, Record
from codesign.units import PICOSECONDS_PER_SECOND

_INFORMATION, _WARNING = 2, 3
_ALARMS = {"no_way", "deadline_missed", "safety_stop", "contact", "livelock"}

# Decimals of metres and quaternions: more than a screen shows, and few enough to compress well.
_DECIMALS = 6

VECTOR = {axis: {"type": "number"} for axis in ("x", "y", "z")}

TIMESTAMP: dict[str, Any] = {
    "type": "object",
    "title": "time",
    "properties": {
        "sec": {"type": "integer", "minimum": 0},
        "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999},
    },
}

POSE: dict[str, Any] = {
    "type": "object",
    "title": "foxglove.Pose",
    "properties": {
        "position": {"type": "object", "title": "foxglove.Vector3", "properties": VECTOR},
        "orientation": {
            "type": "object",
            "title": "foxglove.Quaternion",
            "properties": {**VECTOR, "w": {"type": "number"}},
        },
    },
}


_NO_ROWS = Frame(0)


@dataclass(frozen=True)
class Floor:
    """The map as the floor of a scene.

    ``frame``: its cells in metres, 1 m each where their side is not known. Without an origin, the lower left corner of
    the map is the origin of frame ``map``. ``row``, ``column``: the first cell of the map as records count them.
    """

    frame: Frame = _NO_ROWS
    row: int = 0
    column: int = 0

    @property
    def cell_size(self) -> float:
        """Metres a cell."""
        return self.frame.resolution

    @property
    def yaw(self) -> float:
        """How far the map is turned in its frame, radians, counterclockwise."""
        return self.frame.origin[2]

    @property
    def corner(self) -> dict[str, float]:
        """The lower left corner of the map in metres."""
        return {axis: round(value, _DECIMALS) for axis, value in zip("xy", self.frame.origin, strict=False)}

    def place(self, row: float, column: float, height: float = 0.0) -> dict[str, float]:
        """The point in metres of a point in cells. Whole numbers of cells are middles.

        >>> Floor(Frame(rows=10, resolution=0.5)).place(9, 0)
        {'x': 0.25, 'y': 0.25, 'z': 0.0}
        """
        x, y = self.frame.point(row - self.row, column - self.column)
        return {"x": round(x, _DECIMALS), "y": round(y, _DECIMALS), "z": height}


def floor_of(record: MapRecord) -> Floor:
    """The floor of a map."""
    x, y, yaw = (0.0, 0.0, 0.0) if record.origin is None else record.origin.tolist()
    return Floor(Frame(record.free.shape[0], record.resolution or 1.0, (x, y, yaw)), *record.corner)


def timestamp(time: int) -> dict[str, int]:
    """A time in ps as seconds and nanoseconds, rounded down."""
    seconds, rest = divmod(time, PICOSECONDS_PER_SECOND)
    return {"sec": seconds, "nsec": rest // 1000}


def pose(position: dict[str, float], heading: float = 0.0) -> dict[str, Any]:
    """A pose at a position on the floor. ``heading``: as in ``PoseRecord``, radians.

    A heading turns from the columns towards the rows. The y axis of the scene points up, so it turns clockwise there.
    """
    half = -heading / 2
    # Adding 0 turns -0 into 0.
    turned = round(math.sin(half), _DECIMALS) + 0.0, round(math.cos(half), _DECIMALS) + 0.0
    return {"position": position, "orientation": {"x": 0.0, "y": 0.0, "z": turned[0], "w": turned[1]}}


@dataclass(frozen=True)
class Standard:
    """A schema that viewers know: its name, the JSON schemas of its fields, and how a record fills them."""

    schema: str
    properties: Mapping[str, Any]
    fill: Callable[[Any, Floor], dict[str, Any]]


def _fill_pose(record: PoseRecord, floor: Floor) -> dict[str, Any]:
    return {
        "timestamp": timestamp(record.time),
        "frame_id": "map",
        "pose": pose(floor.place(record.row, record.column), record.heading - floor.yaw),
    }


def _fill_positions(record: PositionsRecord, floor: Floor) -> dict[str, Any]:
    return {
        "timestamp": timestamp(record.time),
        "frame_id": "map",
        "poses": [pose(floor.place(row, column)) for row, column in record.positions.tolist()],
    }


def _fill_log(record: MissionRecord, _floor: Floor) -> dict[str, Any]:
    return {
        "timestamp": timestamp(record.time),
        "level": _WARNING if record.event in _ALARMS else _INFORMATION,
        "message": f"{record.event.replace('_', ' ')}: {record.text}",
        "name": record.source,
        "file": "",
        "line": 0,
    }


_IN_FRAME = {"timestamp": TIMESTAMP, "frame_id": {"type": "string"}}

STANDARDS: dict[type[Record], Standard] = {
    PoseRecord: Standard("foxglove.PoseInFrame", {**_IN_FRAME, "pose": POSE}, _fill_pose),
    PositionsRecord: Standard(
        "foxglove.PosesInFrame", {**_IN_FRAME, "poses": {"type": "array", "items": POSE}}, _fill_positions
    ),
    MissionRecord: Standard(
        "foxglove.Log",
        {
            "timestamp": TIMESTAMP,
            "level": {"type": "integer", "minimum": 0},
            "message": {"type": "string"},
            "name": {"type": "string"},
            "file": {"type": "string"},
            "line": {"type": "integer", "minimum": 0},
        },
        _fill_log,
    ),
}
"""The standard message of a record class."""
