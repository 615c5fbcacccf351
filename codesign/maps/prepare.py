"""Reading a map of any format, and the steps from the map as it is read to the map that is planned on.

The order is fixed: unknown cells, inflation, downsampling, cropping. Inflation comes before downsampling, because it
measures in the fine cells: after it, wherever in a free coarse cell the robot is, the rule of ``inflate`` holds. In the
other order, a radius below the side of a coarse cell would change nothing.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError
from codesign.ground.late import late
from codesign.ground.units import counted
from codesign.maps.grid import Cell, OccupancyGrid, check_size
from codesign.maps.images import image_of, is_image, parse_image, read_ros
from codesign.maps.reach import clearance
from codesign.maps.text import parse_cells, parse_count, parse_text, read_bytes, show, split_lines

FREE = b".GS"
OBSTACLE = b"@OTW"
MAX_SCENARIOS = 2**18
_LENGTH = re.compile(rb"[0-9]{1,12}(\.[0-9]{1,20})?([eE][+-]?[0-9]{1,2})?")
_VERSIONS = (b"version 1", b"version 1.0")


@dataclass(frozen=True)
class MovingAiScenario:
    """One problem of a scenario file.

    ``optimal_length``: of the shortest 8-connected path without corner cutting, in cells; within 0.005 of
    ``distance_octile``. ``line``: of the file, the first is 1.
    """

    bucket: int
    map_name: str
    shape: tuple[int, int]
    start: Cell
    goal: Cell
    optimal_length: float
    line: int


def read_movingai(path: str | os.PathLike[str]) -> OccupancyGrid:
    """A MovingAI ``.map`` of type octile.

    Free: ``.``, ``G`` and swamp ``S``. Obstacles: ``@``, ``O``, trees ``T``, and water ``W``, which a ground robot
    cannot enter. Swamp has the cost of ground here.

    Raises:
        MapError: the file cannot be read, or has a wrong header, another count of rows or columns than its header,
            another character, no cell or too many (by the header, before memory is allocated).
    """
    return parse_movingai(read_bytes(path), str(path))


def parse_movingai(content: bytes, where: str) -> OccupancyGrid:
    """The grid of ``read_movingai`` from the content of a file. ``where``: the file, for errors."""
    lines = split_lines(content, where)
    if lines[0].split() != [b"type", b"octile"]:
        what = f"the first line is {show(lines[0])}, not 'type octile'"
        raise MapError(what, f"{where}:1:1", "a MovingAI map begins with the lines type octile, height, width, map")
    sizes: dict[bytes, int] = {}
    for number, line in enumerate(lines[1:3], 2):
        words = line.split()
        size = parse_count(words[1]) if len(words) == 2 else None
        if size is None or words[0] not in (b"height", b"width") or words[0] in sizes:
            raise MapError(f"{show(line)} is neither height nor width", f"{where}:{number}:1", "write, say, height 32")
        sizes[words[0]] = size
    if len(lines) < 5 or lines[3].strip() != b"map":
        what = "the header ends without the line 'map' and its rows"
        raise MapError(what, f"{where}:{min(len(lines), 4)}", "lines 1 to 4 are: type octile, height, width, map")
    check_size(sizes[b"height"], sizes[b"width"], where)
    rows = lines[4:]
    if len(rows) != sizes[b"height"]:
        what = f"the map has {counted(len(rows), 'row')}, its header says height {sizes[b'height']}"
        raise MapError(what, f"{where}:{4 + min(len(rows), sizes[b'height'] + 1)}", "the file may be cut")
    if len(rows[0]) != sizes[b"width"]:
        raise MapError(
            f"this row has {counted(len(rows[0]), 'cell')}, the header says width {sizes[b'width']}", f"{where}:5:1"
        )
    return OccupancyGrid(parse_cells(rows, FREE, OBSTACLE, where, first_line=5), source=where)


def read_scenarios(path: str | os.PathLike[str]) -> tuple[MovingAiScenario, ...]:
    """The problems of a MovingAI ``.scen`` file, in file order; x is the column, y the row.

    Raises:
        MapError: the file cannot be read, is not version 1, has a line without nine fields, a field that is no number,
            a cell outside of the map, or more than ``MAX_SCENARIOS`` problems (with FILE:LINE).
    """
    where = str(path)
    lines = split_lines(read_bytes(path), where)
    if lines[0].strip() not in _VERSIONS:
        raise MapError(f"the first line is {show(lines[0])}, not 'version 1'", f"{where}:1:1", "is this a .scen file?")
    if len(lines) - 1 > MAX_SCENARIOS:
        raise MapError(f"{len(lines) - 1} scenarios are above the limit of {MAX_SCENARIOS}", where)
    return tuple(_scenario(line, where, number) for number, line in enumerate(lines[1:], 2) if line.strip())


def _scenario(line: bytes, file: str, number: int) -> MovingAiScenario:
    where = f"{file}:{number}"
    # Names may contain blanks where tabs separate the fields, as in all but the oldest files.
    fields = [field.strip() for field in (line.split(b"\t") if b"\t" in line else line.split())]
    numbers = [parse_count(field) for field in (fields[:1] + fields[2:8])]
    if len(fields) != 9 or None in numbers:
        what = f"{show(line)} is not a scenario"
        raise MapError(what, where, "fields: bucket, map, width, height, start x, start y, goal x, goal y, length")
    bucket, width, height, start_x, start_y, goal_x, goal_y = (value or 0 for value in numbers)
    length = float(fields[8]) if _LENGTH.fullmatch(fields[8]) else math.inf
    if not math.isfinite(length):
        raise MapError(f"the length {show(fields[8])} is not a number from 0", where)
    if not (start_x < width and goal_x < width and start_y < height and goal_y < height):
        raise MapError(f"start or goal is outside of the map of {height} × {width} cells", where)
    name = fields[1].decode("utf-8", "backslashreplace")
    start, goal = (start_y, start_x), (goal_y, goal_x)
    return MovingAiScenario(bucket, name, (height, width), start, goal, length, number)


def choose_scenarios(
    scenarios: tuple[MovingAiScenario, ...],
    *,
    line: int | None = None,
    bucket: int | None = None,
    same_goal: bool = False,
) -> tuple[MovingAiScenario, ...]:
    """The problem of a line of the file, or the first one of a bucket; with ``same_goal`` all that share its goal.

    The problem that was named comes first, the others in file order.

    Raises:
        MapError: no problem stands there. ``where`` is ``line`` or ``bucket``.
    """
    chosen = next((each for each in scenarios if each.line == line or each.bucket == bucket), None)
    if chosen is None:
        key, value = ("bucket", bucket) if line is None else ("line", line)
        has = {each.line if line is not None else each.bucket for each in scenarios}
        what = f"the file has no problem in {key} {value}"
        raise MapError(what, key, f"from {min(has)} to {max(has)}" if has else "the file has no problems")
    if not same_goal:
        return (chosen,)
    others = (each for each in scenarios if each.goal == chosen.goal and each.start != chosen.start)
    return (chosen, *{each.start: each for each in others}.values())


_ROS = (".yaml", ".yml")


def read_map(path: str | os.PathLike[str], *, unknown_is_free: bool = False) -> OccupancyGrid:
    """A map of any format: ROS YAML by its suffix, the others by their content.

    PNG, BMP and PGM are recognised by their first bytes, MovingAI by ``type`` (or the suffix ``.map``). All other files
    are plain text. ``unknown_is_free`` affects ROS maps alone.

    Raises:
        MapError: see the reader of the format.
    """
    suffix = Path(path).suffix.lower()
    if suffix in _ROS:
        return read_ros(path, unknown_is_free=unknown_is_free)
    where = str(path)
    content = read_bytes(path)
    if is_image(content) or suffix in (".png", ".bmp", ".pgm"):
        return parse_image(content, where)
    if content.startswith(b"type ") or suffix == ".map":
        return parse_movingai(content, where)
    if suffix == ".scen":
        raise MapError("this is a file of scenarios, not a map", where, "name the .map file that belongs to it")
    return parse_text(content, where)


def map_files(path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """The files that ``read_map`` reads: the file itself and, for a ROS map, its image.

    A YAML file that cannot be read is listed alone. ``read_map`` reports its fault.
    """
    file = Path(path)
    if file.suffix.lower() not in _ROS:
        return (file,)
    try:
        return file, image_of(file)
    except MapError:
        return (file,)


def yaml_beside(path: str | os.PathLike[str]) -> Path | None:
    """The YAML of map_server that describes a bare image: of the same name, or one beside it that names the image."""
    file = Path(path)
    try:
        beside = [each for each in sorted(file.parent.iterdir())[:1000] if each.suffix.lower() in _ROS]
    except OSError:
        return None
    for each in sorted(beside, key=lambda each: each.stem != file.stem):
        with suppress(MapError):
            if image_of(each).name == file.name:
                return each
    return None


def map_stamp(path: str | os.PathLike[str]) -> tuple[tuple[str, int, int], ...]:
    """Name, modification time (ns) and size (bytes) of each of ``map_files``. The stamp changes with the map.

    A file that does not exist has time and size -1.
    """
    stamps = []
    for file in map_files(path):
        try:
            status = file.stat()
            stamps.append((str(file), status.st_mtime_ns, status.st_size))
        except (OSError, ValueError):
            stamps.append((str(file), -1, -1))
    return tuple(stamps)


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
