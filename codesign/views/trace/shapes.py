"""Viewers' messages of single shapes: poses, points, lines, coloured grids, in Foxglove's schemas.

Foxglove draws grids and scenes. Rerun draws neither, but clouds of points and voxels. So each grid is written as both,
from the same bytes, and each path and set of cells as a scene and a cloud.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from foxglove import messages as fg
from numpy.typing import NDArray

from codesign.ground.models import Frame
from codesign.ground.records import MapRecord

# Where the cells of a map lie for viewers, in metres, and the belief of a robot about them.

FREE, UNKNOWN, BLOCKED = 0, 1, 2
"""The belief of a robot about a cell."""

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
        """The angle by which the map is turned in its frame, radians, counterclockwise."""
        return self.frame.origin[2]

    def point(self, row: float, column: float) -> tuple[float, float]:
        """(x, y) in metres of a point in cells. Whole numbers of cells are middles.

        >>> Floor(Frame(rows=10, resolution=0.5)).point(9, 0)
        (0.25, 0.25)
        """
        return self.frame.point(row - self.row, column - self.column)

    def points(self, places: NDArray[np.generic]) -> NDArray[np.float64]:
        """(x, y) in metres, n × 2, of places in cells, n × 2."""
        x, y, yaw = self.frame.origin
        side = self.cell_size
        right = (places[:, 1].astype(np.float64) - self.column + 0.5) * side
        up = (self.frame.rows - (places[:, 0].astype(np.float64) - self.row) - 0.5) * side
        if not yaw:
            return np.column_stack([x + right, y + up])
        cos, sin = math.cos(yaw), math.sin(yaw)
        return np.column_stack([x + right * cos - up * sin, y + right * sin + up * cos])

    def turned(self, heading: float) -> float:
        """The angle in frame ``map``, radians counterclockwise, of a heading as in ``PoseRecord``.

        A heading turns from the columns towards the rows, so clockwise in the frame: its y axis points up.
        """
        return self.yaw - heading


def floor_of(record: MapRecord) -> Floor:
    """The floor of a map."""
    x, y, yaw = (0.0, 0.0, 0.0) if record.origin is None else record.origin.tolist()
    return Floor(Frame(record.free.shape[0], record.resolution or 1.0, (x, y, yaw)), *record.corner)


MAP_FRAME = "map"

Colour = tuple[int, int, int, int]
GOAL, PATH, OBSTACLE, ROBOT = (30, 150, 60, 255), (209, 74, 92, 255), (217, 140, 33, 255), (40, 100, 200, 255)
TRAIL = (110, 160, 230, 255)

FREE_NOW, WALL, CAME, GONE = range(4)
"""States of a cell of the true map: free, an obstacle from the start, one that came, and free where one was."""

_TRUE = {FREE_NOW: (250, 250, 250, 255), WALL: (55, 60, 70, 255), CAME: OBSTACLE, GONE: (225, 235, 225, 255)}
_BELIEF = {FREE: (214, 232, 250, 255), UNKNOWN: (150, 150, 150, 160), BLOCKED: (40, 60, 140, 255)}

_BANDS = 32
"""As many as one can tell apart beside each other: more of them take more bytes."""

_LOGARITHMIC = 1e3
"""A field with so much between its least positive value and its greatest is coloured by its logarithm."""

# A field from its least value to its greatest: dark blue, green, yellow (five points of viridis).
_FIELD = [(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)]
_LEVELS = 64
"""Colours of a field. Few, so that pictures pack well."""

GRAIN = 2.0**12

_UINT8 = fg.PackedElementFieldNumericType.Uint8
_FLOAT32 = fg.PackedElementFieldNumericType.Float32
_CHANNELS = ("red", "green", "blue", "alpha")
_FLAT = fg.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
_ORIGIN = fg.Pose(position=fg.Vector3(x=0.0, y=0.0, z=0.0), orientation=_FLAT)
_POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("rgba", "u1", 4)])
_CLOUD_FIELDS = [
    *(fg.PackedElementField(name=name, offset=4 * at, type=_FLOAT32) for at, name in enumerate("xyz")),
    *(fg.PackedElementField(name=name, offset=12 + at, type=_UINT8) for at, name in enumerate(_CHANNELS)),
]
_GRID_FIELDS = [fg.PackedElementField(name=name, offset=at, type=_UINT8) for at, name in enumerate(_CHANNELS)]


def rounded(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The values to 2^-12, about 0.2 mm: more than a screen shows, and few enough bits to pack well."""
    grained: NDArray[np.float64] = np.rint(values * GRAIN) / GRAIN
    return grained


def stamp(time: int) -> fg.Timestamp:
    """A time in ps, rounded down to nanoseconds."""
    seconds, rest = divmod(time, 10**12)
    return fg.Timestamp(sec=seconds, nsec=rest // 1000)


def quaternion(angle: float) -> fg.Quaternion:
    """A turn around the upright axis, radians counterclockwise."""
    return fg.Quaternion(x=0.0, y=0.0, z=math.sin(angle / 2), w=math.cos(angle / 2))


def pose(x: float, y: float, angle: float = 0.0, height: float = 0.0) -> fg.Pose:
    """A pose on the floor, metres and radians."""
    return fg.Pose(position=fg.Vector3(x=x, y=y, z=height), orientation=quaternion(angle))


def colour(rgba: Colour) -> fg.Color:
    """A colour of four bytes."""
    red, green, blue, alpha = (part / 255 for part in rgba)
    return fg.Color(r=red, g=green, b=blue, a=alpha)


@cache
def _table(kind: str) -> NDArray[np.uint32]:
    """The colours of the values of a grid, four bytes each: ``true`` or ``belief``, or the colours of a ``field``."""
    if kind == "field":
        knots = np.linspace(0, 1, len(_FIELD))
        shades = np.linspace(0, 1, _LEVELS)
        parts = [np.interp(shades, knots, [row[part] for row in _FIELD]).round() for part in range(3)]
        table = np.column_stack([*parts, np.full(_LEVELS, 255)]).astype(np.uint8)
        table = np.vstack([table, np.zeros((1, 4), np.uint8)])
    else:
        colours = _TRUE if kind == "true" else _BELIEF
        table = np.array([colours[value] for value in sorted(colours)], np.uint8)
    return np.ascontiguousarray(table).view(np.uint32).ravel()


def coloured(kind: str, cells: NDArray[Any]) -> bytes:
    """The colours of the cells, rows × columns: red, green, blue, alpha, a byte each.

    A ``field`` of float64 is spread over the colours; a cell without a value is transparent.
    """
    if kind == "field":
        known = np.isfinite(cells)
        values = _evenly(cells[known])
        least, most = (values.min(), values.max()) if values.size else (0.0, 0.0)
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            shades = (values - least) * (_LEVELS / ((most - least) or 1.0))
        cells = np.full(cells.shape, _LEVELS, np.uint8)
        cells[known] = np.nan_to_num(shades).clip(0, _LEVELS - 1)
    return bytes(_table(kind)[cells].tobytes())


def _evenly(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The logarithms of values over many powers of ten, such as a potential, in bands; else the values."""
    positive = values[values > 0]
    if not positive.size or values.min() < 0 or positive.max() < _LOGARITHMIC * positive.min():
        return values
    logarithms = np.log2(np.maximum(values, positive.min()) / positive.min())
    bands: NDArray[np.float64] = np.floor(logarithms * (_BANDS / logarithms.max()))
    return bands


def grids(
    kind: str, cells: NDArray[Any], time: int, floor: Floor, height: float, step: int = 1
) -> tuple[fg.Grid, fg.VoxelGrid]:
    """A coloured grid, rows × columns, on the floor, and the same as flat voxels for Rerun.

    ``step``: so many rows and columns are shown as one, from the lower left corner on. An obstacle in them shows.
    """
    cells = _reduced(cells[::-1], step)
    rows, columns = cells.shape
    x, y, yaw = floor.frame.origin
    side, place, data = floor.cell_size * step, pose(x, y, yaw, height), coloured(kind, cells)
    grid = fg.Grid(
        timestamp=stamp(time),
        frame_id=MAP_FRAME,
        pose=place,
        column_count=columns,
        cell_size=fg.Vector2(x=side, y=side),
        row_stride=4 * columns,
        cell_stride=4,
        fields=_GRID_FIELDS,
        data=data,
    )
    voxels = fg.VoxelGrid(
        timestamp=stamp(time),
        frame_id=MAP_FRAME,
        pose=place,
        row_count=rows,
        column_count=columns,
        cell_size=fg.Vector3(x=side, y=side, z=side / 100),
        slice_stride=4 * columns * rows,
        row_stride=4 * columns,
        cell_stride=4,
        fields=_GRID_FIELDS,
        data=data,
    )
    return grid, voxels


def _reduced(cells: NDArray[Any], step: int) -> NDArray[Any]:
    """The greatest value of each ``step`` × ``step`` cells; of a field the first."""
    if step == 1 or cells.dtype != np.uint8:
        return cells[::step, ::step]
    rows, columns = (-side % step for side in cells.shape)
    padded = np.pad(cells, [(0, rows), (0, columns)])
    blocks = padded.reshape(padded.shape[0] // step, step, padded.shape[1] // step, step)
    reduced: NDArray[Any] = blocks.max(axis=(1, 3))
    return reduced


def cloud(points: NDArray[np.float64], rgba: Colour, time: int, height: float, frame: str = MAP_FRAME) -> fg.PointCloud:
    """Points (x, y) in metres, n × 2, at one height. None clears those that were shown."""
    packed = np.zeros(len(points), _POINT)
    packed["x"], packed["y"], packed["z"], packed["rgba"] = *rounded(points).T, height, rgba
    return fg.PointCloud(
        timestamp=stamp(time),
        frame_id=frame,
        pose=_ORIGIN,
        point_stride=_POINT.itemsize,
        fields=_CLOUD_FIELDS,
        data=packed.tobytes(),
    )


def line(points: NDArray[np.float64], rgba: Colour, height: float) -> fg.LinePrimitive:
    """A line through points (x, y) in metres, n × 2, two pixels wide."""
    return fg.LinePrimitive(
        type=fg.LinePrimitiveLineType.LineStrip,
        pose=_ORIGIN,
        thickness=2.0,
        scale_invariant=True,
        points=[fg.Point3(x=x, y=y, z=height) for x, y in rounded(points).tolist()],
        color=colour(rgba),
    )


def entity(name: str, time: int, frame: str = MAP_FRAME, **primitives: Any) -> fg.SceneEntity:
    """An entity that replaces the last one of that name, and moves with its frame. It stays until it is replaced."""
    return fg.SceneEntity(timestamp=stamp(time), frame_id=frame, id=name, frame_locked=True, **primitives)


def scene(name: str, time: int, **primitives: Any) -> fg.SceneUpdate:
    """A scene of one entity in frame ``map``. Without primitives it shows nothing."""
    return fg.SceneUpdate(entities=[entity(name, time, **primitives)])


def densified(points: NDArray[np.float64], step: float, most: int) -> NDArray[np.float64]:
    """Points along the line through ``points``, n × 2, at most ``step`` apart, and at most about ``most`` of them."""
    if len(points) < 2:
        return points
    lengths = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    count = int(min(max(lengths[-1] / step if math.isfinite(lengths[-1]) else 0, len(points)), most)) + 1
    along = np.linspace(0.0, lengths[-1], count)
    return np.column_stack([np.interp(along, lengths, points[:, axis]) for axis in (0, 1)])


def thinned(points: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """At most ``most`` of the points, evenly chosen, the first and the last among them."""
    if len(points) <= most:
        return points
    return points[np.linspace(0, len(points) - 1, max(most, 2)).astype(np.int64)]
