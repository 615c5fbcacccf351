"""The steps from a map as it is read to the map that is planned on.

The order is fixed: unknown cells, inflation, downsampling, cropping. Inflation comes before downsampling, because it
measures in the fine cells: after it, wherever in a free coarse cell the robot is, the rule of ``inflate`` holds. In the
other order, a radius below the side of a coarse cell would change nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError
from codesign.ground.late import late
from codesign.maps.grid import Cell, OccupancyGrid
from codesign.maps.reach import clearance
from codesign.maps.read import read_map, yaml_beside

ndimage = late("scipy.ndimage")

_ROUNDING = 1e-9


class Unknown(StrEnum):
    """The meaning of a cell that the map says nothing about."""

    BLOCKED = "blocked"
    FREE = "free"


class Crop(StrEnum):
    """The part of the map that is planned on.

    ``none``: all of it. ``free``: the rectangle around all free cells. ``reachable``: the rectangle around the free
    cells that are joined to a goal or to a named start, across sides or corners.
    """

    NONE = "none"
    FREE = "free"
    REACHABLE = "reachable"


@dataclass(frozen=True)
class Radius:
    """A radius in metres, or in cells of the map as it is read."""

    value: float
    unit: str

    def __str__(self) -> str:
        return f"{self.value:g} {self.unit}"

    def in_cells(self, resolution: float | None) -> float:
        """The radius in cells.

        Raises:
            MapError: it is in metres, and the map has no resolution. ``where`` is ``inflate``.
        """
        if self.unit != "m":
            return self.value
        if resolution is None:
            what = f"a radius of {self} on a map that does not say how large a cell is"
            raise MapError(what, "inflate", "give the map its resolution, such as 5 cm, or write a radius in cells")
        return self.value / resolution


@dataclass(frozen=True)
class Steps:
    """The steps that prepare a map before cropping.

    ``resolution``: metres a cell, for a map that does not say it itself.
    """

    unknown: Unknown = Unknown.BLOCKED
    inflate: Radius | None = None
    downsample: int = 1
    resolution: float | None = None


def read_prepared(path: Path, steps: Steps) -> OccupancyGrid:
    """The map of a file after the steps, with remarks on its unknown cells and on the greys of a bare image.

    Raises:
        MapError: see ``read_map`` and ``prepare``.
    """
    raw = read_map(path)
    remarks = list(raw.remarks)
    beside = yaml_beside(path) if remarks else None
    if beside is not None:
        remarks[-1] += f"; name {beside.name} in its place, which describes it"
    if raw.unknown is not None and raw.unknown.any():
        share = f"{int(raw.unknown.sum()):,} of {raw.free.size:,} cells are unknown"
        remarks.append(f"{share}, and count as {steps.unknown} (unknown: {steps.unknown})")
    return replace(prepare(raw, steps), remarks=tuple(remarks))


def prepare(grid: OccupancyGrid, steps: Steps) -> OccupancyGrid:
    """The map after the steps: unknown cells, inflation, downsampling.

    Raises:
        MapError: the key of a step is at fault; ``where`` names it.
    """
    if steps.resolution is not None:
        if grid.resolution is not None and grid.resolution != steps.resolution:
            what = f"the map itself says {grid.resolution:g} m a cell"
            raise MapError(what, "resolution", "remove resolution")
        grid = replace(grid, resolution=steps.resolution)
    if steps.unknown is Unknown.FREE and grid.unknown is not None:
        grid = replace(grid, free=grid.free | grid.unknown)
    if steps.inflate is not None:
        grid = inflate(grid, steps.inflate.in_cells(grid.resolution))
    return downsample(grid, steps.downsample) if steps.downsample > 1 else grid


def inflate(grid: OccupancyGrid, radius: float) -> OccupancyGrid:
    """The map with the surroundings of obstacles blocked; ``radius`` in cells.

    A cell is blocked where the distance from its middle to the middle of an obstacle cell is at most the radius, as in
    the costmaps of Nav2. Unknown cells that count as blocked are obstacles. So is everything outside of the map.
    """
    return replace(grid, free=clearance(grid.free) > radius + _ROUNDING)


def downsample(grid: OccupancyGrid, factor: int) -> OccupancyGrid:
    """The map in cells of ``factor`` × ``factor`` cells, counted from the top left.

    A coarse cell is free where all its cells are free, so a path of the coarse map is one of the fine map. It is
    unknown where one of its cells is unknown and it is not free. Where the size is no multiple, the last row and column
    of coarse cells reach beyond the map, and are blocked. The resolution grows by the factor. The origin belongs to
    the lower left coarse cell.
    """
    down, right = -grid.rows % factor, -grid.columns % factor

    def tiles(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        # Axes 1 and 3 run within a coarse cell.
        filled = np.pad(cells, ((0, down), (0, right)))
        return filled.reshape(filled.shape[0] // factor, factor, -1, factor)

    free: NDArray[np.bool_] = np.asarray(tiles(grid.free).all(axis=(1, 3)))
    unknown: NDArray[np.bool_] | None = None
    if grid.unknown is not None:
        unknown = np.asarray(tiles(grid.unknown).any(axis=(1, 3))) & ~free
    frame = grid.frame
    return replace(
        grid,
        free=free,
        unknown=unknown,
        resolution=None if frame is None else frame.resolution * factor,
        origin=None if frame is None else frame.part(0, 0, grid.rows + down).origin,
    )


@dataclass(frozen=True)
class Window:
    """A rectangle of cells of a map: its first row and column, and its size."""

    row: int
    column: int
    rows: int
    columns: int

    @property
    def corner(self) -> Cell:
        """The first row and column."""
        return self.row, self.column

    def of(self, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """The cells of the window, contiguous."""
        inside = cells[self.row : self.row + self.rows, self.column : self.column + self.columns]
        return np.ascontiguousarray(inside)

    def holds(self, cell: Cell) -> bool:
        """True if the cell lies in the window."""
        return 0 <= cell[0] - self.row < self.rows and 0 <= cell[1] - self.column < self.columns


def cropped(grid: OccupancyGrid, part: Window) -> OccupancyGrid:
    """The part of a map, with the origin of its own lower left corner."""
    frame = grid.frame
    origin = None if frame is None else frame.part(part.row, part.column, part.rows).origin
    unknown = None if grid.unknown is None else part.of(grid.unknown)
    return replace(grid, free=part.of(grid.free), unknown=unknown, origin=origin)


def window(grid: OccupancyGrid, crop: Crop, kept: Iterable[Cell] = ()) -> Window:
    """The part of a map that cropping leaves, without a margin.

    ``kept``: the free cells that ``Crop.REACHABLE`` keeps, with all that is joined to them. A map without a free cell
    is left whole.
    """
    cells = grid.free
    if crop is Crop.REACHABLE:
        # Across corners too, so that no planner loses a cell, whatever its moves are.
        labels, _ = ndimage.label(cells, structure=np.ones((3, 3), np.int8))
        joined = {int(labels[cell]) for cell in kept} - {0}
        cells = np.isin(labels, list(joined))
    rows, columns = np.nonzero(cells.any(axis=1))[0], np.nonzero(cells.any(axis=0))[0]
    if crop is Crop.NONE or not rows.size:
        return Window(0, 0, grid.rows, grid.columns)
    first, last = (int(rows[0]), int(columns[0])), (int(rows[-1]), int(columns[-1]))
    return Window(*first, last[0] - first[0] + 1, last[1] - first[1] + 1)
