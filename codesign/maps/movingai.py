"""Benchmark maps and scenarios of movingai.com (Sturtevant, Benchmarks for Grid-Based Pathfinding, 2012)."""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass

from codesign.ground.errors import MapError
from codesign.ground.units import counted
from codesign.maps.files import parse_count, read_bytes, show
from codesign.maps.grid import Cell, OccupancyGrid, check_size
from codesign.maps.text import parse_cells, split_lines

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
        raise MapError(
            f"the first line is {show(lines[0])}, not 'type octile'",
            f"{where}:1:1",
            "a MovingAI map begins with the lines type octile, height, width, map",
        )
    sizes: dict[bytes, int] = {}
    for number, line in enumerate(lines[1:3], 2):
        words = line.split()
        size = parse_count(words[1]) if len(words) == 2 else None
        if size is None or words[0] not in (b"height", b"width") or words[0] in sizes:
            raise MapError(f"{show(line)} is neither height nor width", f"{where}:{number}:1", "write, say, height 32")
        sizes[words[0]] = size
    if len(lines) < 5 or lines[3].strip() != b"map":
        raise MapError(
            "the header ends without the line 'map' and its rows",
            f"{where}:{min(len(lines), 4)}",
            "lines 1 to 4 are: type octile, height, width, map",
        )
    check_size(sizes[b"height"], sizes[b"width"], where)
    rows = lines[4:]
    if len(rows) != sizes[b"height"]:
        raise MapError(
            f"the map has {counted(len(rows), 'row')}, its header says height {sizes[b'height']}",
            f"{where}:{4 + min(len(rows), sizes[b'height'] + 1)}",
            "the file may be cut",
        )
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
        raise MapError(
            f"{show(line)} is not a scenario",
            where,
            "fields: bucket, map, width, height, start x, start y, goal x, goal y, length",
        )
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
