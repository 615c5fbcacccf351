"""A mission at one time: the true map with its changes, the robot's belief, its path and its position.

``hwsw trace show FILE --at 12s`` prints it; ``codesign.views.report`` draws it.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import TraceError, printable
from codesign.ground.records import MapRecord, MissionRecord, PoseRecord, Record, Subject, kinds_about
from codesign.ground.units import counted, format_time
from codesign.views.trace.reader import Trace
from codesign.views.trace.shapes import BLOCKED, FREE, UNKNOWN

# A run as a timeline, and its last field as a picture of characters: hwsw trace show FILE.

HEADER = ("begin", "duration", "source", "what", "details")

WALL = "█"
SHADES = "·:-=+*%@"
"""Glyphs of a potential, from lowest to highest. A free cell with the value 0 is a space."""


@dataclass(frozen=True)
class TimelineRow:
    """One line of a timeline: ``begin`` and ``end`` in ps, and what happened."""

    begin: int
    end: int
    source: str
    what: str
    details: str

    def cells(self) -> tuple[str, str, str, str, str]:
        """The line for print, in the order of ``HEADER``."""
        duration = format_time(self.end - self.begin) if self.end != self.begin else ""
        return format_time(self.begin), duration, self.source, self.what, self.details


def timeline(
    trace: Trace, topics: Sequence[str] = (), limit: int | None = None, begin: int = 0, end: int | None = None
) -> list[TimelineRow]:
    """The first ``limit`` records of a trace as rows, in order of their begin, then of emission.

    ``begin`` and ``end``, ps: only records that end at ``begin`` or later, and begin at ``end`` or earlier.

    Raises:
        TraceError: see ``Trace.records``.
    """
    rows = map(row_of, trace.records(topics))
    shown = (row for row in rows if row.end >= begin and (end is None or row.begin <= end))
    numbered = ((row.begin, index, row) for index, row in enumerate(shown))
    chosen = sorted(numbered) if limit is None else heapq.nsmallest(limit, numbered)
    return [row for _, _, row in chosen]


def row_of(record: Record) -> TimelineRow:
    """The line of one record."""
    what, details = record.described()
    return TimelineRow(*record.between(), printable(record.source, 40), printable(what, 60), details)


def trace_thumbnail(trace: Trace, width: int = 72) -> list[str]:
    """The last field of a plan over the map, as lines of at most ``width`` characters, then a legend; [] without one.

    Raises:
        TraceError: see ``Trace.records``.
    """
    free: NDArray[np.bool_] | None = None
    field: NDArray[np.float64] | None = None
    scale = ""
    for record in trace.records(kinds=kinds_about(Subject.MAP, Subject.STAGE, Subject.FIELD)):
        values = getattr(record, record.ROLE.grid)
        if record.ROLE.about is Subject.MAP:
            free = values
        elif not values.size:
            continue
        elif record.ROLE.about is Subject.STAGE:
            field, scale = values, f"{SHADES[0]} lowest to {SHADES[-1]} highest potential"
        else:
            name = printable(vars(record)["name"])
            field, scale = _nearness(values), f"{SHADES[0]} highest to {SHADES[-1]} lowest {name}"
    if field is None:
        return []
    if free is not None and free.shape != field.shape:
        raise TraceError(f"a potential of {field.shape} on a map of {free.shape}", str(trace.path))
    rows, columns = tile_of(field.shape, width)
    size = "1 cell" if rows * columns == 1 else f"{rows} × {columns} cells"
    return [*thumbnail(field, free, width), f"one glyph is {size}; {WALL} wall, {scale}"]


def _nearness(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """A field v that grows away from the goal, such as a distance, as the potential exp((min v - v) / (max v - min v)).

    Equal steps of v are then equal steps of the logarithm, which ``thumbnail`` shows.
    """
    finite = np.isfinite(values)
    if not finite.any():
        return np.zeros(values.shape)
    least, most = float(values[finite].min()), float(values[finite].max())
    span = (most - least) or 1.0
    near: NDArray[np.float64] = np.where(finite, np.exp((least - np.where(finite, values, least)) / span), 0.0)
    return near


def thumbnail(potential: NDArray[np.float64], free: NDArray[np.bool_] | None = None, width: int = 72) -> list[str]:
    """A potential as lines of at most ``width`` characters.

    A map that fits is shown cell by cell. In a wider map each character is a tile with twice as many rows as columns,
    because a character is about twice as high as wide.

    The glyphs are steps of the logarithm, from the least positive value to the greatest, because a harmonic potential
    falls exponentially along corridors. A glyph shows the greatest value of its cells. It is a wall where obstacles
    cross the tile from side to side, or where most of its cells are obstacles.

    >>> thumbnail(np.array([[0.001, 0.03, 1.0]], dtype=np.float64), np.array([[True, True, True]]), width=3)
    ['·=@']
    """
    rows, columns = potential.shape
    if not rows or not columns:
        return []
    tile = tile_of(potential.shape, width)
    down, across = np.arange(0, rows, tile[0]), np.arange(0, columns, tile[1])
    values = np.nan_to_num(potential.astype(np.float64), nan=0.0, posinf=1.0, neginf=0.0)
    values = np.maximum.reduceat(np.maximum.reduceat(values, down, axis=0), across, axis=1)
    closed = np.zeros(values.shape, dtype=bool) if free is None else walls(free, tile)
    glyphs = np.full(values.shape, " ")
    shown = (values > 0) & ~closed
    if shown.any():
        logs = np.log(values[shown])
        span = float(logs.max() - logs.min()) or 1.0
        index = np.minimum(((logs - logs.min()) / span * len(SHADES)).astype(np.int64), len(SHADES) - 1)
        glyphs[shown] = np.array(list(SHADES))[index]
    glyphs[closed] = WALL
    return ["".join(line) for line in glyphs]


def tile_of(shape: tuple[int, ...], width: int) -> tuple[int, int]:
    """Rows and columns of cells in the tile of one character."""
    step = max(1, -(-shape[1] // max(width, 1)))
    return (2 * step if step > 1 else 1), step


def walls(free: NDArray[np.bool_], tile: tuple[int, int]) -> NDArray[np.bool_]:
    """The tiles that are walls: obstacles cross them from side to side, or fill more than half of them.

    The last row and column are repeated to fill the last tiles.
    """
    rows, columns = tile
    filled = np.pad(~free, [(0, -free.shape[0] % rows), (0, -free.shape[1] % columns)], mode="edge")
    tiles = filled.reshape(-1, rows, filled.shape[1] // columns, columns).swapaxes(1, 2)
    most: NDArray[np.bool_] = 2 * tiles.sum(axis=(2, 3)) > rows * columns
    return most | _crossed(tiles) | _crossed(tiles.swapaxes(2, 3))


def _crossed(tiles: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The tiles (the last two axes) with a line of obstacles from their first column to their last."""
    reached = tiles[..., 0]
    for column in range(1, tiles.shape[-1]):
        beside = reached.copy()
        beside[..., 1:] |= reached[..., :-1]
        beside[..., :-1] |= reached[..., 1:]
        reached = beside & tiles[..., column]
    return np.asarray(reached.any(axis=-1))


MOMENT_KINDS = kinds_about(
    Subject.MAP, Subject.CHANGE, Subject.BELIEF, Subject.PATH, Subject.POSE, Subject.FLEET, Subject.EVENT
)
"""The record classes that a moment is made from."""

_CAME, _UNSEEN_WALL, _SEEN, _STALE, _PATH, _GOAL, _ROBOT = "▓", "▒", "·", "?", "*", "G", "@"


@dataclass(frozen=True)
class Moment:
    """The state of a mission at ``time`` (ps).

    - ``start``: bool, rows × columns: the cells that were free at the start. ``free``: the cells that are free now.
    - ``belief``: uint8, rows × columns, ``FREE``, ``UNKNOWN`` or ``BLOCKED``; None without a record of a belief.
    - ``goals``: int32, n × 2. ``path``: float64, n × 2, the last planned path, (row, column) in cells; None before.
    - ``driven``: float64, n × 2, the positions of the robot's poses up to now.
    - ``pose``: the last pose; None before the first. ``robots``: float64, n × 2, all robots of a fleet, or None.
    - ``corner``: (row, column) of the first cell of these arrays; all places are counted in the whole map.
    - ``resolution``: metres a cell, or None. ``events``: the events of the mission up to now.
    """

    time: int
    start: NDArray[np.bool_]
    free: NDArray[np.bool_]
    belief: NDArray[np.uint8] | None
    goals: NDArray[np.int32]
    path: NDArray[np.float64] | None
    driven: NDArray[np.float64]
    pose: PoseRecord | None
    robots: NDArray[np.float64] | None
    resolution: float | None
    events: tuple[MissionRecord, ...]
    corner: tuple[int, int] = (0, 0)

    @property
    def drawn(self) -> dict[str, Any]:
        """The arguments of ``codesign.views.report.moment_picture``."""
        names = ("time", "start", "free", "goals", "corner", "driven", "robots")
        unknown = None if self.belief is None else self.belief == UNKNOWN
        return {name: vars(self)[name] for name in names} | {"unknown": unknown, "way": self.path}


def moment(records: Iterable[Record], time: int | None = None, where: str | None = None) -> Moment:
    """The state at ``time`` (ps, included), or at the end of the run where it is None.

    ``where``: the file of the records, for errors.

    Raises:
        TraceError: the records have no map, or a change outside of it.
    """
    seen = _Seen(where)
    for record in records:
        if time is None or record.time <= time:
            seen.take(record)
    start = seen.start
    if start is None:
        raise TraceError("no map at that time", where, "name a later time, or a trace of hwsw run --trace")
    return Moment(
        time=seen.last if time is None else time,
        start=start.free,
        free=seen.free,
        belief=seen.belief,
        goals=start.goals,
        path=seen.path,
        driven=np.array([(pose.row, pose.column) for pose in seen.poses], np.float64).reshape(-1, 2),
        pose=seen.poses[-1] if seen.poses else None,
        robots=seen.robots,
        resolution=start.resolution,
        events=tuple(seen.events),
        corner=start.corner,
    )


class _Seen:
    """The facts that the records up to now say, each by what it is about."""

    def __init__(self, where: str | None) -> None:
        self._where, self.last = where, 0
        self.start: MapRecord | None = None
        self.free = np.zeros((0, 0), np.bool_)
        self.belief: NDArray[np.uint8] | None = None
        self.path: NDArray[np.float64] | None = None
        self.robots: NDArray[np.float64] | None = None
        self.poses: list[PoseRecord] = []
        self.events: list[MissionRecord] = []
        self._takers: dict[Subject, Callable[[Any], None]] = {
            Subject.MAP: self._map,
            Subject.CHANGE: self._change,
            Subject.BELIEF: self._learnt,
            Subject.PATH: lambda record: setattr(self, "path", record.points),
            Subject.POSE: self.poses.append,
            Subject.FLEET: lambda record: setattr(self, "robots", record.positions),
            Subject.EVENT: self.events.append,
        }

    def take(self, record: Record) -> None:
        """Take one record."""
        self.last = max(self.last, record.time)
        taker = self._takers.get(record.ROLE.about)
        if taker is not None:
            taker(record)

    def _map(self, record: MapRecord) -> None:
        self.start, self.free = record, record.free.copy()
        self.belief = None if self.belief is None else np.full(record.free.shape, UNKNOWN, np.uint8)

    def _change(self, record: Any) -> None:
        self._put(self.free, record.cells, not record.appeared)

    def _learnt(self, record: Any) -> None:
        if self.belief is None:
            self.belief = np.full(self.free.shape, UNKNOWN, np.uint8)
        self._put(self.belief, record.cells, np.where(record.blocked, BLOCKED, FREE))

    def _put(self, grid: NDArray[Any], cells: NDArray[np.integer[Any]], values: Any) -> None:
        here = cells - np.array(self.start.corner if self.start else (0, 0))
        if len(here) and not ((here >= 0) & (here < grid.shape)).all():
            raise TraceError(
                "a cell is outside of the map", self._where, "the file is damaged, or was not written by hwsw"
            )
        grid[here[:, 0], here[:, 1]] = values


def moment_lines(seen: Moment, width: int = 72) -> list[str]:
    """The moment as a map of at most ``width`` characters a line, then the legend, then the facts.

    Where a character covers several cells, it shows the first of these: a robot, a goal, the path, an obstacle.
    """
    if not seen.free.size:
        return facts(seen)
    tile = tile_of(seen.free.shape, width)
    glyphs = np.full([-(-side // step) for side, step in zip(seen.free.shape, tile, strict=True)], " ")
    if seen.belief is None:
        glyphs[~walls(seen.free, tile)] = _SEEN
    else:
        glyphs[_any((seen.belief == FREE) & seen.free, tile)] = _SEEN
        glyphs[_any((seen.belief == BLOCKED) & seen.free, tile)] = _STALE
    closed = walls(seen.free, tile)
    glyphs[closed] = WALL
    if seen.belief is not None:
        glyphs[closed & ~_any((seen.belief == BLOCKED) & ~seen.free, tile)] = _UNSEEN_WALL
    glyphs[_any(~seen.free & seen.start, tile)] = _CAME
    first = np.array(seen.corner, np.float64)
    _mark(glyphs, tile, [] if seen.path is None else _dense(seen.path) - first, _PATH)
    _mark(glyphs, tile, seen.goals - first, _GOAL)
    robots = [(seen.pose.row, seen.pose.column)] if seen.pose is not None else seen.robots
    _mark(glyphs, tile, [] if robots is None else np.asarray(robots) - first, _ROBOT)
    size = "1 cell" if tile == (1, 1) else f"{tile[0]} × {tile[1]} cells"
    part = f" from {seen.corner} on" if any(seen.corner) else ""
    legend = (
        f"one glyph is {size}{part}; {_ROBOT} robot, {_GOAL} goal, {_PATH} path, {WALL} wall,"
        f" {_CAME} obstacle that appeared, {_SEEN} free"
    )
    if seen.belief is not None:
        legend += f" and known, {_UNSEEN_WALL} unknown wall, {_STALE} free but believed blocked"
    return [*("".join(line) for line in glyphs), legend, *facts(seen)]


def facts(seen: Moment) -> list[str]:
    """The facts of the moment, a line each."""
    lines = [f"at {format_time(seen.time)}"]
    if seen.pose is not None:
        turned = math.degrees(seen.pose.heading) % 360 if math.isfinite(seen.pose.heading) else math.nan
        lines.append(
            f"{printable(seen.pose.source, 40)} at row {seen.pose.row:.2f}, column {seen.pose.column:.2f},"
            f" heading {turned:.0f}°, {seen.pose.speed:.3g} m/s"
        )
    if seen.robots is not None:
        lines.append(counted(len(seen.robots), "robot"))
    blocked = int((seen.start & ~seen.free).sum())
    freed = int((~seen.start & seen.free).sum())
    if blocked or freed:
        lines.append(f"{counted(blocked, 'cell')} blocked and {freed} freed since the start")
    if seen.belief is not None:
        is_known = seen.belief != UNKNOWN
        wrong = is_known & ((seen.belief == FREE) != seen.free)
        lines.append(f"{is_known.mean():.1%} of the cells known, {int(wrong.sum())} of them no longer right")
    lines += [
        f"{format_time(event.time)}: {printable(event.event, 40).replace('_', ' ')}: {printable(event.text, 200)}"
        for event in seen.events[-3:]
    ]
    return lines


def _any(cells: NDArray[np.bool_], tile: tuple[int, int]) -> NDArray[np.bool_]:
    """The tiles with any of these cells."""
    down, across = (np.arange(0, side, step) for side, step in zip(cells.shape, tile, strict=True))
    marked: NDArray[np.bool_] = np.logical_or.reduceat(np.logical_or.reduceat(cells, down, axis=0), across, axis=1)
    return marked


def _mark(glyphs: NDArray[np.str_], tile: tuple[int, int], points: Any, glyph: str) -> None:
    """Put ``glyph`` at these points (row, column). Points outside are left out."""
    places = np.asarray(points, np.float64).reshape(-1, 2)
    places = places[np.isfinite(places).all(axis=1)]
    cells = np.floor(np.clip(places, -1e6, 1e6) + 0.5).astype(np.int64) // tile
    cells = cells[((cells >= 0) & (cells < glyphs.shape)).all(axis=1)]
    glyphs[cells[:, 0], cells[:, 1]] = glyph


_MOST_POINTS = 1_000_000


def _dense(path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of the path, at most half a cell apart."""
    if len(path) < 2 or not np.isfinite(path).all():
        return path
    arcs = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))))
    count = min(int(min(arcs[-1], _MOST_POINTS) * 2) + 2, _MOST_POINTS)
    at = np.linspace(0.0, arcs[-1], count)
    return np.column_stack([np.interp(at, arcs, path[:, axis]) for axis in (0, 1)])
