"""The place of the cells of a map for viewers, in metres, and the belief of a robot about them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.ground.models import Frame
from codesign.ground.records import MapRecord

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
