"""The frame of a map: where its cells lie in metres."""

from __future__ import annotations

import math
from dataclasses import dataclass

_ROUNDING = 1e-9
"""Cells: a point this near below a side of a cell lies on that side."""


@dataclass(frozen=True)
class Frame:
    """Metres for the cells of a map, as map_server has them: x to the right, y up.

    - ``rows``: of the map. ``resolution``: metres a cell.
    - ``origin``: (x, y, yaw) of the lower left corner of the map, metres and radians. The yaw turns the map around this
      corner, counterclockwise.
    """

    rows: int
    resolution: float = 1.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def point(self, row: float, column: float) -> tuple[float, float]:
        """(x, y) in metres of a place in cells. Whole numbers of cells are middles.

        >>> Frame(rows=10, resolution=0.5, origin=(-1.0, 2.0, 0.0)).point(9, 0)
        (-0.75, 2.25)
        """
        return self._turned((column + 0.5) * self.resolution, (self.rows - row - 0.5) * self.resolution)

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """(row, column) of the cell that a point in metres lies in, inside of the map or not.

        A point on the side between two cells belongs to the right one and to the upper one.

        >>> Frame(rows=10, resolution=0.5, origin=(-1.0, 2.0, 0.0)).cell(-0.75, 2.25)
        (9, 0)
        """
        left, below, yaw = self.origin
        right, up = x - left, y - below
        across = right * math.cos(yaw) + up * math.sin(yaw)
        along = up * math.cos(yaw) - right * math.sin(yaw)
        column = math.floor(across / self.resolution + _ROUNDING)
        return self.rows - 1 - math.floor(along / self.resolution + _ROUNDING), column

    def part(self, row: int, column: int, rows: int) -> Frame:
        """The frame of a part of the map: ``rows`` rows from ``row`` on, columns from ``column`` on."""
        below = (self.rows - row - rows) * self.resolution
        corner = self._turned(column * self.resolution, below)
        return Frame(rows, self.resolution, (*corner, self.origin[2]))

    def _turned(self, right: float, up: float) -> tuple[float, float]:
        left, below, yaw = self.origin
        if not yaw:
            return left + right, below + up
        return (left + right * math.cos(yaw) - up * math.sin(yaw), below + right * math.sin(yaw) + up * math.cos(yaw))
