"""A run as a readable timeline, and its last potential as a picture of characters: ``hwsw trace show
FILE``."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import TraceError, printable
from codesign.records import (
    MapRecord,
    MessageRecord,
    Record,
    StageRecord,
    SummaryRecord,
    TaskRecord,
    TrajectoryRecord,
    UtilisationRecord,
    VisitsRecord,
)
from codesign.trace.reader import Trace
from codesign.units import format_count, format_data, format_time

HEADER = ("begin", "duration", "source", "what", "details")

WALL = "█"
SHADES = "·:-=+*%@"
"""Glyphs of a potential, lowest to highest; a free cell whose value is 0 is a space."""


@dataclass(frozen=True)
class Row:
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


def timeline(trace: Trace, topics: Sequence[str] = (), limit: int | None = None) -> list[Row]:
    """The records of a trace as rows in the order of their begin, the first ``limit`` of them.

    Raises:
        TraceError: see ``Trace.records``.
    """
    return rows_of(trace.records(topics), limit)


def rows_of(records: Iterable[Record], limit: int | None = None) -> list[Row]:
    """Records as rows in the order of their begin; those that begin together stay in their order."""
    rows = ((row.begin, index, row) for index, row in enumerate(map(row_of, records)))
    chosen = sorted(rows) if limit is None else heapq.nsmallest(limit, rows)
    return [row for _, _, row in chosen]


def row_of(record: Record) -> Row:
    """The line of one record."""
    tell = _TELLERS.get(type(record), _tell_any)
    begin, end, what, details = tell(record)
    return Row(begin, end, printable(record.source, 40), printable(what, 60), details)


_Told = tuple[int, int, str, str]


def _tell_map(record: MapRecord) -> _Told:
    rows, columns = record.free.shape
    scale = "" if record.resolution is None else f", {record.resolution:g} m a cell"
    free = format_count(int(record.free.sum()))
    return (
        record.time,
        record.time,
        "map",
        (f"{rows} × {columns} cells, {free} free, {_some(len(record.goals), 'goal')}{scale}"),
    )


def _tell_stage(record: StageRecord) -> _Told:
    costs = ", ".join(
        _some(count, name)
        for count, name in (
            (record.sweeps, "sweep"),
            (record.visits, "visit"),
            (record.iterations, "iteration"),
            (record.cycles, "cycle"),
        )
        if count
    )
    details = (
        f"p = {record.precision}: {costs}; {_some(record.local_maxima, 'local maximum', 'local maxima')}"
    )
    return record.begin, record.time, f"stage {record.stage}", details


def _tell_visits(record: VisitsRecord) -> _Told:
    details = f"p = {record.precision}: {_some(record.block.size, 'visit')}"
    if record.block.size:
        each = record.iterations
        blocks, total = len(np.unique(record.block)), int(each.sum(dtype=np.int64))
        details += (
            f" of {_some(blocks, 'block')}, {_some(total, 'iteration')} ({each.min()} to {each.max()} each)"
        )
    return record.time, record.end, f"visits of stage {record.stage}", details


def _tell_message(record: MessageRecord) -> _Told:
    waited = record.begin - record.time
    queue = f", waited {format_time(waited)}" if waited else ""
    way = f"{printable(record.sender, 40)} to {printable(record.receiver, 40)}"
    return record.begin, record.end, f"message {record.name}", f"{way}, {format_data(record.bits)}{queue}"


def _tell_task(record: TaskRecord) -> _Told:
    return record.time, record.end, f"task {record.task}", _some(record.cycles, "cycle")


def _tell_trajectory(record: TrajectoryRecord) -> _Told:
    if not len(record.points):
        return record.time, record.time, "trajectory", "empty"
    with np.errstate(all="ignore"):
        steps = np.diff(record.points, axis=0)
        length = float(np.hypot(steps[:, 0], steps[:, 1]).sum())
    ends = " to ".join(f"({row:.4g}, {column:.4g})" for row, column in record.points[[0, -1]])
    how = "arrives" if record.arrived else "does not arrive"
    return record.time, record.time, "trajectory", f"{ends}, {length:.4g} cells long, {how}"


def _tell_utilisation(record: UtilisationRecord) -> _Told:
    share = f"{record.busy / record.span:.1%} of {format_time(record.span)}" if record.span > 0 else "no time"
    return record.time, record.time, "utilisation", f"busy {format_time(record.busy)}, {share}"


def _tell_summary(record: SummaryRecord) -> _Told:
    return record.time, record.time, "result", _some(len(record.result), "figure")


def _tell_any(record: Any) -> _Told:
    told = [
        f"{item.name} {printable(str(getattr(record, item.name)), 40)}"
        for item in fields(record)
        if item.name not in ("time", "source") and not isinstance(getattr(record, item.name), np.ndarray)
    ]
    return record.time, record.time, type(record).__name__.removesuffix("Record").lower(), ", ".join(told)


_TELLERS: dict[type[Record], Callable[[Any], _Told]] = {
    MapRecord: _tell_map,
    StageRecord: _tell_stage,
    VisitsRecord: _tell_visits,
    MessageRecord: _tell_message,
    TaskRecord: _tell_task,
    TrajectoryRecord: _tell_trajectory,
    UtilisationRecord: _tell_utilisation,
    SummaryRecord: _tell_summary,
}


def _some(count: int, name: str, names: str | None = None) -> str:
    return f"{format_count(count)} {name if count == 1 else names or name + 's'}"


def trace_thumbnail(trace: Trace, width: int = 72) -> list[str]:
    """The potential of the last stage over the map, as lines of at most ``width`` characters, and a line that
    says what a character stands for; [] without a stage.

    Raises:
        TraceError: see ``Trace.records``.
    """
    free: NDArray[np.bool_] | None = None
    potential: NDArray[np.float64] | None = None
    for record in trace.records():
        if isinstance(record, MapRecord):
            free = record.free
        elif isinstance(record, StageRecord):
            potential = record.potential
    if potential is None:
        return []
    if free is not None and free.shape != potential.shape:
        raise TraceError(f"a potential of {potential.shape} on a map of {free.shape}", str(trace.path))
    rows, columns = _tile(potential.shape, width)
    size = "1 cell" if rows * columns == 1 else f"{rows} × {columns} cells"
    legend = f"one glyph is {size}; {WALL} wall, {SHADES[0]} lowest to {SHADES[-1]} highest potential"
    return [*thumbnail(potential, free, width), legend]


def thumbnail(
    potential: NDArray[np.float64], free: NDArray[np.bool_] | None = None, width: int = 72
) -> list[str]:
    """A potential as lines of at most ``width`` characters.

    A map that fits is shown cell by cell. In a wider one, twice as many rows as columns are joined, for a
    character is about twice as high as wide.

    The glyphs are steps of the logarithm, from the least positive value to the greatest: a harmonic potential
    falls off exponentially along corridors. Each shows the greatest value of its cells, or a wall where
    obstacles cross it from side to side or most of its cells are obstacles.

    >>> thumbnail(np.array([[0.001, 0.03, 1.0]], dtype=np.float64), np.array([[True, True, True]]), width=3)
    ['·=@']
    """
    rows, columns = potential.shape
    if not rows or not columns:
        return []
    tile = _tile(potential.shape, width)
    down, across = np.arange(0, rows, tile[0]), np.arange(0, columns, tile[1])
    values = np.nan_to_num(potential.astype(np.float64), nan=0.0, posinf=1.0, neginf=0.0)
    values = np.maximum.reduceat(np.maximum.reduceat(values, down, axis=0), across, axis=1)
    walls = np.zeros(values.shape, dtype=bool) if free is None else _walls(free, tile)
    glyphs = np.full(values.shape, " ")
    shown = (values > 0) & ~walls
    if shown.any():
        logs = np.log(values[shown])
        span = float(logs.max() - logs.min()) or 1.0
        index = np.minimum(((logs - logs.min()) / span * len(SHADES)).astype(np.int64), len(SHADES) - 1)
        glyphs[shown] = np.array(list(SHADES))[index]
    glyphs[walls] = WALL
    return ["".join(line) for line in glyphs]


def _tile(shape: tuple[int, ...], width: int) -> tuple[int, int]:
    """Rows and columns of cells that one character stands for."""
    step = max(1, -(-shape[1] // max(width, 1)))
    return (2 * step if step > 1 else 1), step


def _walls(free: NDArray[np.bool_], tile: tuple[int, int]) -> NDArray[np.bool_]:
    """Which tiles are walls: crossed by obstacles from side to side, straight or aslant, or most of it obstacles.

    The last row and column are repeated to fill the last tiles.
    """
    rows, columns = tile
    filled = np.pad(~free, [(0, -free.shape[0] % rows), (0, -free.shape[1] % columns)], mode="edge")
    tiles = filled.reshape(-1, rows, filled.shape[1] // columns, columns).swapaxes(1, 2)
    most: NDArray[np.bool_] = 2 * tiles.sum(axis=(2, 3)) > rows * columns
    return most | _crossed(tiles) | _crossed(tiles.swapaxes(2, 3))


def _crossed(tiles: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which tiles (the last two axes) have a line of obstacles from their first column to their last."""
    reached = tiles[..., 0]
    for column in range(1, tiles.shape[-1]):
        beside = reached.copy()
        beside[..., 1:] |= reached[..., :-1]
        beside[..., :-1] |= reached[..., 1:]
        reached = beside & tiles[..., column]
    return np.asarray(reached.any(axis=-1))
