"""A map in words: what ``hwsw map`` prints above its picture."""

from __future__ import annotations

from collections.abc import Iterator

from codesign import maps
from codesign.ground.errors import InputError, outside_map
from codesign.ground.units import counted
from codesign.inputs.places import Point, cell_text, point_text
from codesign.maps import OccupancyGrid, Window
from codesign.maps.survey import Survey

Cell = tuple[int, int]


def place_on(grid: OccupancyGrid, place: Cell | Point, option: str) -> Cell:
    """The cell of a place that a user asks for.

    Raises:
        InputError: it is outside of the map, or in metres on a map without a resolution; at ``option``.
    """
    if isinstance(place, Point):
        if grid.frame is None:
            what = f"{place} is in metres, and the map does not say how large a cell is"
            raise InputError(what, option, "write ROW,COLUMN, or give the map a resolution, such as 5cm")
        place = grid.frame.cell(place.x, place.y)
    if not (0 <= place[0] < grid.rows and 0 <= place[1] < grid.columns):
        what, hint = outside_map(place, grid.shape)
        raise InputError(what, option, hint)
    return place


def map_lines(figures: Survey, at: Cell | None = None) -> Iterator[str]:
    """The facts of a map, a line each; ``at``: a cell to find the nearest free cell of."""
    grid = figures.grid
    yield f"{grid.source}: {grid.rows} × {grid.columns} cells (rows × columns)"
    frame = grid.frame
    if frame is None:
        yield "metres: unknown, as the map gives no resolution"
    else:
        size = f"{grid.columns * frame.resolution:g} × {grid.rows * frame.resolution:g} m (x × y)"
        left, below = frame.origin[:2]
        yield f"metres: {frame.resolution:g} m a cell, {size}, lower left corner {point_text(left, below)}"
        if frame.origin[2]:
            yield f"turned: {frame.origin[2]:g} rad around that corner"
    known = f"{figures.free:,} free, {figures.blocked:,} blocked, {figures.unknown:,} unknown"
    yield f"cells: {known}"
    count = len(figures.components)
    if count:
        largest = f"the largest has {figures.components[0]:,} cells"
        yield f"free space: {counted(count, 'component')} across the sides of cells, {largest}"
        for name, part in (("free", figures.around_free), ("reachable", figures.around_largest)):
            yield f"crop: {name} leaves {_saved(grid, part)}"
    else:
        yield "free space: none"
    if at is not None:
        yield _nearest(grid, at)
    yield from (f"note: {remark}" for remark in grid.remarks)


def _saved(grid: OccupancyGrid, part: Window) -> str:
    share = part.rows * part.columns / grid.free.size
    last = (part.row + part.rows - 1, part.column + part.columns - 1)
    cells = f"{cell_text(part.corner)} to {cell_text(last)}"
    return f"{part.rows} × {part.columns} cells, {cells}: {share:.1%} of the map"


def _nearest(grid: OccupancyGrid, at: Cell) -> str:
    near = maps.nearest_free(grid.free, at)
    if near is None:
        return f"at {_named(grid, at)}: no cell of the map is free"
    if near == at:
        return f"at {_named(grid, at)}: free"
    where = "unknown" if grid.unknown is not None and grid.unknown[at] else "blocked"
    return f"at {_named(grid, at)}: {where}; the nearest free cell is {_named(grid, near)}"


def _named(grid: OccupancyGrid, cell: Cell) -> str:
    frame = grid.frame
    return cell_text(cell) if frame is None else f"{cell_text(cell)}, {point_text(*frame.point(*cell))}"
