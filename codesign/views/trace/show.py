"""A run as a timeline, and its last field as a picture of characters: ``hwsw trace show FILE``."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import TraceError, printable
from codesign.ground.records import Record, Subject, kinds_about
from codesign.ground.units import format_time
from codesign.views.trace.reader import Trace

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
