"""A run as a timeline, and its last field as a picture of characters: ``hwsw trace show FILE``."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import TraceError, printable
from codesign.records import (
    ENDED,
    BeliefRecord,
    CommandRecord,
    FieldRecord,
    GoalRecord,
    MapRecord,
    MessageRecord,
    MissionRecord,
    ObstacleRecord,
    PlanRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    RobotRecord,
    SampleRecord,
    ScanRecord,
    StageRecord,
    SummaryRecord,
    TaskRecord,
    TrajectoryRecord,
    UtilisationRecord,
    VisitsRecord,
)
from codesign.trace.reader import Trace
from codesign.units import counted, format_count, format_data, format_time

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
    trace: Trace,
    topics: Sequence[str] = (),
    limit: int | None = None,
    begin: int = 0,
    end: int | None = None,
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
    describe = _DESCRIPTIONS.get(type(record), _describe_any)
    begin, end, what, details = describe(record)
    return TimelineRow(begin, end, printable(record.source, 40), printable(what, 60), details)


_Description = tuple[int, int, str, str]


def _describe_map(record: MapRecord) -> _Description:
    rows, columns = record.free.shape
    scale = "" if record.resolution is None else f", {record.resolution:g} m a cell"
    free = format_count(int(record.free.sum()))
    part = f" from {record.corner} on" if any(record.corner) else ""
    return (
        record.time,
        record.time,
        "map",
        f"{rows} × {columns} cells{part}, {free} free, {counted(len(record.goals), 'goal')}{scale}",
    )


def _describe_stage(record: StageRecord) -> _Description:
    costs = ", ".join(
        counted(count, name)
        for count, name in (
            (record.sweeps, "sweep"),
            (record.visits, "visit"),
            (record.iterations, "iteration"),
            (record.cycles, "cycle"),
        )
        if count
    )
    details = (
        f"p = {record.precision}: {costs}; {counted(record.local_maxima, 'local maximum', 'local maxima')}"
    )
    return record.begin, record.time, f"stage {record.stage}", details


def _describe_visits(record: VisitsRecord) -> _Description:
    details = f"p = {record.precision}: {counted(record.block.size, 'visit')}"
    if record.block.size:
        each = record.iterations
        blocks, total = len(np.unique(record.block)), int(each.sum(dtype=np.int64))
        details += f" of {counted(blocks, 'block')}, {counted(total, 'iteration')} ({each.min()} to {each.max()} each)"
    return record.time, record.end, f"visits of stage {record.stage}", details


def _describe_message(record: MessageRecord) -> _Description:
    waited = record.begin - record.time
    queue = f", waited {format_time(waited)}" if waited else ""
    ends = f"{printable(record.sender, 40)} to {printable(record.receiver, 40)}"
    details = f"{ends}, {format_data(record.bits)}{queue}"
    if record.attempts > 1:
        details += f", {record.attempts} attempts"
    if record.damaged:
        details += ", damage not detected"
    if record.outcome != "delivered":
        details += f", {printable(record.outcome, 40)}: {printable(record.reason or 'no reason', 120)}"
    return record.begin, record.end, f"message {record.name}", details


def _describe_task(record: TaskRecord) -> _Description:
    details = counted(record.cycles, "cycle")
    if record.outcome != ENDED:
        details += f", {printable(record.outcome, 40)}"
    return record.time, record.end, f"task {record.task}", details


def _describe_trajectory(record: TrajectoryRecord) -> _Description:
    if not len(record.points):
        return record.time, record.time, "trajectory", "empty"
    with np.errstate(all="ignore"):
        steps = np.diff(record.points, axis=0)
        length = float(np.hypot(steps[:, 0], steps[:, 1]).sum())
    ends = " to ".join(f"({row:.4g}, {column:.4g})" for row, column in record.points[[0, -1]])
    how = "arrives" if record.arrived else "does not arrive"
    return record.time, record.time, "trajectory", f"{ends}, {length:.4g} cells long, {how}"


def _describe_field(record: FieldRecord) -> _Description:
    if not record.values.size:
        return record.time, record.time, f"field {record.name}", "its values are left out in a mission"
    values = record.values[np.isfinite(record.values)]
    unit = "" if record.unit in ("", "1") else f" {printable(record.unit, 40)}"
    span = f", {values.min():.4g} to {values.max():.4g}{unit}" if values.size else ""
    what = f"field {record.name}"
    return record.time, record.time, what, f"{format_count(values.size)} cells with a value{span}"


def _describe_pose(record: PoseRecord) -> _Description:
    place = f"row {record.row:.2f}, column {record.column:.2f}"
    return record.time, record.time, "pose", f"{place}, {record.speed:.3g} m/s"


def _describe_robot(record: RobotRecord) -> _Description:
    rays = counted(record.rays, "ray") if record.rays else "all within a radius"
    details = (
        f"radius {record.radius:.4g} m, at most {record.speed:.4g} m/s, sees {record.reach:.4g} m with {rays}"
    )
    return record.time, record.time, "robot", details


def _describe_goal(record: GoalRecord) -> _Description:
    cells = ", ".join(f"({row}, {column})" for row, column in record.cells[:3].tolist())
    more = f" and {len(record.cells) - 3} more" if len(record.cells) > 3 else ""
    return record.time, record.time, "goal", f"{cells}{more}" if cells else "the robot chooses its goals"


def _describe_positions(record: PositionsRecord) -> _Description:
    return record.time, record.time, f"update {record.update}", counted(len(record.positions), "robot")


def _describe_obstacle(record: ObstacleRecord) -> _Description:
    how = "blocked" if record.appeared else "free again"
    return record.time, record.time, "obstacle", f"{counted(len(record.cells), 'cell')} {how}"


def _describe_belief(record: BeliefRecord) -> _Description:
    blocked = int(record.blocked.sum())
    details = f"{counted(len(record.cells), 'cell')} learnt, {format_count(blocked)} blocked"
    return record.time, record.time, "belief", details


def _describe_plan(record: PlanRecord) -> _Description:
    return record.asked, record.time, f"plan {record.number}", f"last scan at {format_time(record.seen)}"


def _describe_command(record: CommandRecord) -> _Description:
    details = f"plan {record.plan}, seen at {format_time(record.seen)}, to drive {record.end:.4g} cells"
    return record.composed, record.time, "command", details


def _describe_mission(record: MissionRecord) -> _Description:
    return record.time, record.time, record.event.replace("_", " "), printable(record.text, 200)


def _describe_utilisation(record: UtilisationRecord) -> _Description:
    share = f"{record.busy / record.span:.1%} of {format_time(record.span)}" if record.span > 0 else "no time"
    return record.time, record.time, "utilisation", f"busy {format_time(record.busy)}, {share}"


def _describe_sample(record: SampleRecord) -> _Description:
    unit = "" if record.unit == "1" else f" {printable(record.unit, 40)}"
    return record.time, record.time, "sample", f"{printable(record.quantity, 60)} {record.value:.4g}{unit}"


def _describe_scan(record: ScanRecord) -> _Description:
    met = int(np.isfinite(record.ranges).sum())
    where = f"row {record.row:.2f}, column {record.column:.2f}"
    return (
        record.time,
        record.time,
        "scan",
        f"{counted(len(record.ranges), 'ray')} at {where}, {met} met obstacles",
    )


def _describe_summary(record: SummaryRecord) -> _Description:
    return record.time, record.time, "result", counted(len(record.result), "figure")


def _describe_any(record: Any) -> _Description:
    values = [
        f"{item.name} {printable(str(getattr(record, item.name)), 40)}"
        for item in fields(record)
        if item.name not in ("time", "source") and not isinstance(getattr(record, item.name), np.ndarray)
    ]
    return record.time, record.time, type(record).__name__.removesuffix("Record").lower(), ", ".join(values)


_DESCRIPTIONS: dict[type[Record], Callable[[Any], _Description]] = {
    MapRecord: _describe_map,
    StageRecord: _describe_stage,
    VisitsRecord: _describe_visits,
    MessageRecord: _describe_message,
    TaskRecord: _describe_task,
    TrajectoryRecord: _describe_trajectory,
    FieldRecord: _describe_field,
    PoseRecord: _describe_pose,
    RobotRecord: _describe_robot,
    GoalRecord: _describe_goal,
    PositionsRecord: _describe_positions,
    ObstacleRecord: _describe_obstacle,
    BeliefRecord: _describe_belief,
    PlanRecord: _describe_plan,
    CommandRecord: _describe_command,
    MissionRecord: _describe_mission,
    UtilisationRecord: _describe_utilisation,
    SummaryRecord: _describe_summary,
    SampleRecord: _describe_sample,
    ScanRecord: _describe_scan,
}


def trace_thumbnail(trace: Trace, width: int = 72) -> list[str]:
    """The last field of a plan over the map, as lines of at most ``width`` characters, then a legend; [] without one.

    Raises:
        TraceError: see ``Trace.records``.
    """
    free: NDArray[np.bool_] | None = None
    field: NDArray[np.float64] | None = None
    scale = ""
    for record in trace.records(kinds=(MapRecord, StageRecord, FieldRecord)):
        if isinstance(record, MapRecord):
            free = record.free
        elif isinstance(record, StageRecord):
            if not record.potential.size:
                continue
            field, scale = record.potential, f"{SHADES[0]} lowest to {SHADES[-1]} highest potential"
        elif isinstance(record, FieldRecord) and record.values.size:
            field, scale = (
                _nearness(record.values),
                f"{SHADES[0]} highest to {SHADES[-1]} lowest {printable(record.name)}",
            )
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
    near: NDArray[np.float64] = np.where(
        finite, np.exp((least - np.where(finite, values, least)) / span), 0.0
    )
    return near


def thumbnail(
    potential: NDArray[np.float64], free: NDArray[np.bool_] | None = None, width: int = 72
) -> list[str]:
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
