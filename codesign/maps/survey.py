"""The contents of a map: size, free, blocked and unknown cells, components, and what cropping would save."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.maps.grid import Cell, OccupancyGrid
from codesign.maps.prepare import Crop, Window, window
from codesign.maps.reach import largest_component, nearest_free

ndimage = late("scipy.ndimage")

MOST_COLUMNS, MOST_ROWS = 72, 40
_OPEN, _WALL, _DARK = 0, 1, 2
_GLYPHS = {
    (_OPEN, _OPEN): " ",
    (_OPEN, _WALL): "▄",
    (_OPEN, _DARK): " ",
    (_WALL, _OPEN): "▀",
    (_WALL, _WALL): "█",
    (_WALL, _DARK): "▀",
    (_DARK, _OPEN): " ",
    (_DARK, _WALL): "▄",
    (_DARK, _DARK): "░",
}
"""The character of two shades, the upper one first."""


@dataclass(frozen=True)
class Survey:
    """The figures of a map.

    - ``components``: free cells that are joined across the sides of cells, as counts, the largest first.
    - ``part``: what cropping leaves. ``around_free``, ``around_largest``: what it would leave around all free cells,
      and around the largest component.
    """

    grid: OccupancyGrid
    components: tuple[int, ...]
    part: Window
    around_free: Window
    around_largest: Window

    @property
    def unknown(self) -> int:
        """Cells that the map says nothing about."""
        return 0 if self.grid.unknown is None else int(self.grid.unknown.sum())

    @property
    def free(self) -> int:
        """Free cells."""
        return int(self.grid.free.sum())

    @property
    def blocked(self) -> int:
        """Cells that are neither free nor unknown."""
        unknown = False if self.grid.unknown is None else self.grid.unknown
        return int((~self.grid.free & ~np.asarray(unknown)).sum())

    def as_json(self) -> dict[str, Any]:
        """The figures as JSON has them."""
        grid = self.grid
        return {
            "source": grid.source,
            "rows": grid.rows,
            "columns": grid.columns,
            "resolution": grid.resolution,
            "origin": grid.origin,
            "free": self.free,
            "blocked": self.blocked,
            "unknown": self.unknown,
            "components": len(self.components),
            "largest_component": self.components[0] if self.components else 0,
            "part": vars(self.part),
            "around_free": vars(self.around_free),
            "around_largest": vars(self.around_largest),
            "remarks": grid.remarks,
        }


def survey(grid: OccupancyGrid, crop: Crop = Crop.NONE, at: Cell | None = None) -> Survey:
    """The figures of a map that is prepared but not cropped.

    ``at``: ``Crop.REACHABLE`` keeps what is joined to the free cell that is nearest to it; without it, to the largest
    component.
    """
    # Label 0 is all cells that are not free.
    labels, count = ndimage.label(grid.free)
    sizes = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    largest = _first(largest_component(grid.free)) if count else None
    kept = nearest_free(grid.free, at) if at is not None and count else largest
    kept_cells, largest_cells = ([] if cell is None else [cell] for cell in (kept, largest))
    return Survey(
        grid,
        components=tuple(sorted((int(size) for size in sizes), reverse=True)),
        part=window(grid, crop, kept_cells),
        around_free=window(grid, Crop.FREE),
        around_largest=window(grid, Crop.REACHABLE, largest_cells),
    )


def _first(cells: NDArray[np.bool_]) -> Cell:
    row, column = np.unravel_index(int(cells.argmax()), cells.shape)
    return int(row), int(column)


def picture(grid: OccupancyGrid, part: Window, at: Cell | None = None) -> list[str]:
    """A part of a map as lines with its coordinates, at most 72 × 40 characters of cells; a character has two rows.

    A half of a character stands for a square of cells. It is filled where a wall crosses the square: where its blocked
    cells, times its side, are as many as its free cells. ``░`` stands for squares with neither. ``X`` marks the cell
    ``at``. Rows and columns at the rim that hold only unknown cells are left out.
    """
    whole, part = part, _known(grid, part, at)
    free = part.of(grid.free)
    unknown = np.zeros(free.shape, np.bool_) if grid.unknown is None else part.of(grid.unknown) & ~free
    side = max(1, -(-part.columns // MOST_COLUMNS), -(-part.rows // (2 * MOST_ROWS)))
    # Each square of cells becomes one shade. A character shows two rows, so an odd last row is repeated.
    open_, walls = _counts(free, side), _counts(~free & ~unknown, side)
    filled = (walls > 0) & (side * walls >= open_)
    shades = np.where(filled, _WALL, np.where(open_ > 0, _OPEN, _DARK))
    shades = np.pad(shades, ((0, shades.shape[0] % 2), (0, 0)), mode="edge")
    width = len(str(part.row + part.rows - 1))
    lines = [f"{'':{width}}  column {part.column} to {part.column + part.columns - 1}"]
    for upper in range(0, shades.shape[0], 2):
        pairs = zip(shades[upper].tolist(), shades[upper + 1].tolist(), strict=True)
        marks = [_GLYPHS[pair] for pair in pairs]
        if at is not None and part.holds(at) and (at[0] - part.row) // side in (upper, upper + 1):
            marks[(at[1] - part.column) // side] = "X"
        lines.append(f"{part.row + upper * side:{width}}  {''.join(marks)}".rstrip())
    cells = "1 cell" if side == 1 else f"{side} × {side} cells"
    asked = ", X the place asked for" if at is not None else ""
    around = "" if part == whole else "; all cells around are unknown"
    return [*lines, f"half a character is {cells}: blank free, █ blocked, ░ unknown{asked}{around}"]


def _known(grid: OccupancyGrid, part: Window, at: Cell | None) -> Window:
    """The part without the rows and columns at its rim that hold only unknown cells, and with the cell ``at``."""
    if grid.unknown is None:
        return part
    known = part.of(~grid.unknown | grid.free)
    if at is not None and part.holds(at):
        known = known.copy()
        known[at[0] - part.row, at[1] - part.column] = True
    # The least rectangle around all known cells.
    rows, columns = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return part
    height, width = int(rows[-1] - rows[0]) + 1, int(columns[-1] - columns[0]) + 1
    return Window(part.row + int(rows[0]), part.column + int(columns[0]), height, width)


def _counts(cells: NDArray[np.bool_], side: int) -> NDArray[np.int64]:
    filled = np.pad(cells, ((0, -cells.shape[0] % side), (0, -cells.shape[1] % side)))
    tiles = filled.reshape(filled.shape[0] // side, side, -1, side)
    counts: NDArray[np.int64] = np.asarray(tiles.sum(axis=(1, 3)), np.int64)
    return counts
