"""``foxglove.Grid`` messages, which viewers show as pictures on the floor, with the fields that Foxglove documents.

Row 0 of our maps is at the top, and a viewer's y axis points up. So rows are written from the last to the first, and
the lower left corner of the map lies at its origin in frame ``map``, (0, 0) where it declares none:

    - obstacles of a map: one byte a cell, 1 for an obstacle (field ``occupied``, ``occupied_now`` after changes);
    - the belief of a robot: one byte a cell (field ``belief``: ``FREE``, ``UNKNOWN`` or ``BLOCKED``);
    - a potential or any other field: one float64 a cell, under its name.

Maps lie lower than fields, so that the two do not flicker in one plane.
"""

from __future__ import annotations

import base64
import binascii
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import TraceError
from codesign.trace.foxglove import POSE, TIMESTAMP, Floor, pose, timestamp

FREE, UNKNOWN, BLOCKED = 0, 1, 2
"""The belief of a robot about a cell, in the order of a viewer's shades."""

# foxglove.NumericType
_UINT8 = 1
_FLOAT64 = 8

_GRID_TYPES = (np.dtype(bool), np.dtype(np.uint8), np.dtype(np.float64))

GRID_PROPERTIES: dict[str, Any] = {
    "timestamp": TIMESTAMP,
    "frame_id": {"type": "string"},
    "pose": POSE,
    "column_count": {"type": "integer", "minimum": 0},
    "cell_size": {
        "type": "object",
        "title": "foxglove.Vector2",
        "properties": {"x": {"type": "number"}, "y": {"type": "number"}},
    },
    "row_stride": {"type": "integer", "minimum": 0},
    "cell_stride": {"type": "integer", "minimum": 0},
    "fields": {
        "type": "array",
        "items": {
            "type": "object",
            "title": "foxglove.PackedElementField",
            "properties": {
                "name": {"type": "string"},
                "offset": {"type": "integer", "minimum": 0},
                "type": {"type": "integer", "minimum": 0},
            },
        },
    },
    "data": {"type": "string", "contentEncoding": "base64"},
}
GRID_REQUIRED = tuple(GRID_PROPERTIES)


_HEIGHTS = {"occupied": -0.02, "occupied_now": -0.015, "belief": -0.01}
"""The heights of grids in metres; 0 for all others."""


def encode_grid(values: NDArray[Any], time: int, floor: Floor, name: str) -> dict[str, Any]:
    """The standard fields of a grid, rows × columns: a bool array of free cells, a uint8 or a float64 array.

    ``floor``: where the grid lies. ``name``: of the field; a bool array is named ``occupied``.

    Raises:
        TraceError: the array is none of these.
    """
    if values.ndim != 2 or values.dtype not in _GRID_TYPES:
        raise TraceError(f"no grid: an array of {values.ndim} dimensions and {values.dtype}")
    if values.dtype == bool:
        values, name = (~values).view(np.uint8), "occupied"
    cells = values.astype(values.dtype.newbyteorder("<"))
    return {
        "timestamp": timestamp(time),
        "frame_id": "map",
        "pose": pose({**floor.corner, "z": _HEIGHTS.get(name, 0.0)}, -floor.yaw),
        "column_count": values.shape[1],
        "cell_size": {"x": floor.cell_size, "y": floor.cell_size},
        "row_stride": values.shape[1] * cells.itemsize,
        "cell_stride": cells.itemsize,
        "fields": [{"name": name, "offset": 0, "type": _UINT8 if cells.itemsize == 1 else _FLOAT64}],
        "data": base64.b64encode(np.flipud(cells).tobytes()).decode("ascii"),
    }


def decode_grid(message: dict[str, Any], dtype: np.dtype[Any], most_cells: int) -> NDArray[Any]:
    """The array of a message of ``encode_grid``, with ``dtype`` bool or float64.

    Raises:
        TraceError: the message has no such grid, or one of more than ``most_cells`` cells.
    """
    is_map = dtype == np.dtype(bool)
    itemsize = 1 if is_map else 8
    columns, text = message.get("column_count"), message.get("data")
    if type(columns) is not int or not 0 < columns <= most_cells or not isinstance(text, str):
        raise TraceError("a grid without columns or data")
    if len(text) > most_cells * itemsize * 4 // 3 + 4:
        raise TraceError(f"a grid of more than {most_cells} cells")
    data = decode_base64(text)
    if message.get("cell_stride") != itemsize or len(data) % (columns * itemsize):
        raise TraceError(f"a grid of {len(data)} bytes with {columns} columns of {itemsize} bytes")
    if is_map:
        cells = np.frombuffer(data, np.uint8).reshape(-1, columns)
        if cells.size and cells.max() > 1:
            raise TraceError("a map with cells that are neither free nor occupied")
        free: NDArray[Any] = np.flipud(cells) == 0
        return free
    return np.flipud(np.frombuffer(data, "<f8").reshape(-1, columns)).astype(np.float64)


def decode_base64(text: Any) -> bytes:
    """The bytes of a base64 text.

    Raises:
        TraceError: it is no base64 text.
    """
    if not isinstance(text, str):
        raise TraceError("an array without its base64 text")
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError) as fault:
        raise TraceError(f"an array that is not base64: {fault}") from fault
