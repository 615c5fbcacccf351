"""A mission at one moment: the true map with what came and went, what the robot knew, its way and where it was.

``hwsw trace show FILE --at 12s`` prints it; ``codesign.report`` draws it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import TraceError, printable
from codesign.records import (
    BeliefRecord,
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    TrajectoryRecord,
)
from codesign.trace.grid import BLOCKED, FREE, UNKNOWN
from codesign.trace.show import WALL, tile_of, walls
from codesign.units import format_time

MOMENT_KINDS: tuple[type[Record], ...] = (
    MapRecord,
    ObstacleRecord,
    BeliefRecord,
    TrajectoryRecord,
    PoseRecord,
    PositionsRecord,
    MissionRecord,
)
"""The records that a moment is made of: all that need be read."""

_CAME, _UNSEEN_WALL, _SEEN, _STALE, _WAY, _GOAL, _ROBOT = "▓", "▒", "·", "?", "*", "G", "@"


@dataclass(frozen=True)
class Moment:
    """The state of a mission at ``time`` (ps).

    - ``start``: bool, rows × columns: the cells that were free at the start. ``free``: those that are free now.
    - ``belief``: uint8, rows × columns, ``FREE``, ``UNKNOWN`` or ``BLOCKED``; None where no robot told what it knows.
    - ``goals``: int32, n × 2. ``way``: float64, n × 2, the way last planned, (row, column) in cells; None before.
    - ``driven``: float64, n × 2, where the robot said it was up to now.
    - ``pose``: the robot's last; None before the first. ``robots``: float64, n × 2, all robots of a fleet, or None.
    - ``resolution``: metres a cell, or None. ``events``: of the mission, up to now.
    """

    time: int
    start: NDArray[np.bool_]
    free: NDArray[np.bool_]
    belief: NDArray[np.uint8] | None
    goals: NDArray[np.int32]
    way: NDArray[np.float64] | None
    driven: NDArray[np.float64]
    pose: PoseRecord | None
    robots: NDArray[np.float64] | None
    resolution: float | None
    events: tuple[MissionRecord, ...]


def moment(records: Iterable[Record], time: int | None = None, where: str | None = None) -> Moment:
    """What the records say of ``time`` (ps, that moment included), or of the end of the run where it is None.

    ``where``: the file they are from, for the words of an error.

    Raises:
        TraceError: there is no map among them, or a change of it lies outside of it.
    """
    start: MapRecord | None = None
    free, belief = np.zeros((0, 0), np.bool_), np.zeros((0, 0), np.uint8)
    known = False
    last = 0
    way, pose, robots = None, None, None
    driven: list[tuple[float, float]] = []
    events: list[MissionRecord] = []
    for record in records:
        if time is not None and record.time > time:
            continue
        last = max(last, record.time)
        if isinstance(record, MapRecord):
            start = record
            free, belief = record.free.copy(), np.full(record.free.shape, UNKNOWN, np.uint8)
        elif isinstance(record, ObstacleRecord):
            _put(free, record.cells, not record.appeared, where)
        elif isinstance(record, BeliefRecord):
            known = True
            _put(belief, record.cells, np.where(record.blocked, BLOCKED, FREE), where)
        elif isinstance(record, TrajectoryRecord):
            way = record.points
        elif isinstance(record, PoseRecord):
            pose = record
            driven.append((record.row, record.column))
        elif isinstance(record, PositionsRecord):
            robots = record.positions
        elif isinstance(record, MissionRecord):
            events.append(record)
    if start is None:
        raise TraceError("no map by then", where, "ask for a later time, or for a trace of hwsw run --trace")
    return Moment(
        time=last if time is None else time,
        start=start.free,
        free=free,
        belief=belief if known else None,
        goals=start.goals,
        way=way,
        driven=np.array(driven, np.float64).reshape(-1, 2),
        pose=pose,
        robots=robots,
        resolution=start.resolution,
        events=tuple(events),
    )


def _put(grid: NDArray[Any], cells: NDArray[np.int32], values: Any, where: str | None) -> None:
    if len(cells) and not ((cells >= 0) & (cells < grid.shape)).all():
        raise TraceError("a cell outside of the map", where, "the file was damaged, or not written by hwsw")
    grid[cells[:, 0], cells[:, 1]] = values


def moment_lines(seen: Moment, width: int = 72) -> list[str]:
    """The moment as a map of at most ``width`` characters a line, what its glyphs are, and the facts in words.

    Where a character stands for several cells, a robot goes before a goal, a goal before the way, and these before
    what is in the way.
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
    _mark(glyphs, tile, [] if seen.way is None else _dense(seen.way), _WAY)
    _mark(glyphs, tile, seen.goals.astype(np.float64), _GOAL)
    robots = [(seen.pose.row, seen.pose.column)] if seen.pose is not None else seen.robots
    _mark(glyphs, tile, [] if robots is None else robots, _ROBOT)
    size = "1 cell" if tile == (1, 1) else f"{tile[0]} × {tile[1]} cells"
    legend = (
        f"one glyph is {size}; {_ROBOT} robot, {_GOAL} goal, {_WAY} way, {WALL} wall, {_CAME} an obstacle that came,"
        f" {_SEEN} free"
    )
    if seen.belief is not None:
        legend += f" and known, {_UNSEEN_WALL} wall not known, {_STALE} taken for blocked"
    return [*("".join(line) for line in glyphs), legend, *facts(seen)]


def facts(seen: Moment) -> list[str]:
    """The moment in words, a line each."""
    told = [f"at {format_time(seen.time)}"]
    if seen.pose is not None:
        turned = math.degrees(seen.pose.heading) % 360 if math.isfinite(seen.pose.heading) else math.nan
        told.append(
            f"{printable(seen.pose.source, 40)} at row {seen.pose.row:.2f}, column {seen.pose.column:.2f},"
            f" heading {turned:.0f}°, {seen.pose.speed:.3g} m/s"
        )
    if seen.robots is not None:
        told.append(f"{len(seen.robots)} robots")
    came = int((seen.start & ~seen.free).sum())
    went = int((~seen.start & seen.free).sum())
    if came or went:
        told.append(f"{came} cells blocked and {went} freed since the start")
    if seen.belief is not None:
        known = seen.belief != UNKNOWN
        wrong = known & ((seen.belief == FREE) != seen.free)
        told.append(f"{known.mean():.1%} of the cells known, {int(wrong.sum())} of them otherwise by now")
    told += [
        f"{format_time(event.time)}: {printable(event.event, 40).replace('_', ' ')}: {printable(event.text, 200)}"
        for event in seen.events[-3:]
    ]
    return told


def _any(cells: NDArray[np.bool_], tile: tuple[int, int]) -> NDArray[np.bool_]:
    """Which tiles have any of these cells."""
    down, across = (np.arange(0, side, step) for side, step in zip(cells.shape, tile, strict=True))
    found: NDArray[np.bool_] = np.logical_or.reduceat(
        np.logical_or.reduceat(cells, down, axis=0), across, axis=1
    )
    return found


def _mark(glyphs: NDArray[np.str_], tile: tuple[int, int], points: Any, glyph: str) -> None:
    """Put ``glyph`` where any of these points (row, column) lies; what lies outside is left out."""
    places = np.asarray(points, np.float64).reshape(-1, 2)
    places = places[np.isfinite(places).all(axis=1)]
    cells = np.floor(np.clip(places, -1e6, 1e6) + 0.5).astype(np.int64) // tile
    cells = cells[((cells >= 0) & (cells < glyphs.shape)).all(axis=1)]
    glyphs[cells[:, 0], cells[:, 1]] = glyph


_MOST_POINTS = 1_000_000


def _dense(way: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of the way no more than half a cell apart."""
    if len(way) < 2 or not np.isfinite(way).all():
        return way
    arcs = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))))
    count = min(int(min(arcs[-1], _MOST_POINTS) * 2) + 2, _MOST_POINTS)
    at = np.linspace(0.0, arcs[-1], count)
    return np.column_stack([np.interp(at, arcs, way[:, axis]) for axis in (0, 1)])
