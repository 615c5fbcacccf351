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


@dataclass(frozen=True)
class Floor:
    """The map as the floor of a scene: ``rows`` of cells, ``cell_size`` metres each (1 where it is not known).

    The lower left corner of the map is the origin of frame ``map``; x grows with the columns, and y against the rows.
    """

    rows: int = 0
    cell_size: float = 1.0

    def place(self, row: float, column: float, height: float = 0.0) -> dict[str, float]:
        """The point in metres of a point in cells. Whole numbers of cells are middles.

        >>> Floor(rows=10, cell_size=0.5).place(9, 0)
        {'x': 0.25, 'y': 0.25, 'z': 0.0}
        """
        x = round((column + 0.5) * self.cell_size, _DECIMALS)
        y = round((self.rows - row - 0.5) * self.cell_size, _DECIMALS)
        return {"x": x, "y": y, "z": height}


def floor_of(record: MapRecord) -> Floor:
    """The floor of a map."""
    return Floor(record.free.shape[0], record.resolution or 1.0)


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
        "pose": pose(floor.place(record.row, record.column), record.heading),
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
