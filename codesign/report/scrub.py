"""A run over time, for a page that is scrubbed: its records reduced to tracks, changed cells, paths, events and series.

``scrub_of`` takes records of a run in memory, or those of a trace. ``report/scrub_data.py`` packs what it returns.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from codesign.records import (
    BeliefRecord,
    FieldRecord,
    GoalRecord,
    MapRecord,
    MessageRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    RobotRecord,
    StageRecord,
    TaskRecord,
    TrajectoryRecord,
    VisitsRecord,
)
from codesign.report.scrub_cells import Cells
from codesign.report.scrub_series import Series, Track, series_of
from codesign.units import counted

Floats = NDArray[np.float64]

SCRUB_KINDS: tuple[type[Record], ...] = (
    MapRecord,
    RobotRecord,
    GoalRecord,
    PoseRecord,
    PositionsRecord,
    ObstacleRecord,
    BeliefRecord,
    TrajectoryRecord,
    MissionRecord,
    StageRecord,
    FieldRecord,
    TaskRecord,
    VisitsRecord,
    MessageRecord,
)
"""The record classes that a page of a run is made from, with its pictures."""

MOST_SAMPLES = 160_000
"""Positions of all robots together; of more, some updates are left out, and the page draws between."""

MOST_POINTS = 200_000
"""Points of all paths together; of more, the last paths are kept."""

MOST_LEVELS = 4_000_000
"""Cells of the fields of all stages together; of more, some stages are left out."""


@dataclass(frozen=True)
class Timed:
    """Places that hold from ``time`` on, float64 n × 2, (row, column): a path, or goals. ``robot``: whose."""

    time: int
    robot: str
    points: Floats


@dataclass(frozen=True)
class Event:
    """Something that happened: when (ps), to which robot or component, its kind, and in words."""

    time: int
    robot: str
    kind: str
    text: str


@dataclass(frozen=True)
class Field:
    """The field that a stage left at ``time`` (ps): ``values``, float64, rows × columns of cells."""

    time: int
    stage: int
    values: Floats


@dataclass
class Scrub:
    """A run over time. All places are in cells of the whole map; ``end``: its last time, ps.

    A fleet has tracks without headings and ``is_fleet``. A plan has ``fields`` and no track.
    """

    cells: Cells
    end: int = 0
    is_fleet: bool = False
    tracks: list[Track] = field(default_factory=list)
    paths: list[Timed] = field(default_factory=list)
    goals: list[Timed] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    fields: list[Field] = field(default_factory=list)
    series: list[Series] = field(default_factory=list)

    @property
    def map(self) -> MapRecord:
        """The map at the begin."""
        return self.cells.start


def scrub_of(records: Iterable[Record]) -> Scrub | None:
    """The run of these records over time; None where nothing moves and no stage left a field, or there is no map."""
    # Records are written when what they say has ended: a damaged trace may hold them in any order.
    all_records = sorted(records, key=lambda record: record.time)
    start = next((record for record in all_records if isinstance(record, MapRecord)), None)
    if start is None or not start.free.size:
        return None
    scrub = Scrub(Cells(start))
    poses, positions = _places(all_records)
    radii = {record.source: record.radius for record in all_records if isinstance(record, RobotRecord)}
    if poses:
        scrub.tracks = [
            _driven(name, track, _in_cells(radii.get(name, 0.0), start)) for name, track in poses.items()
        ]
    elif positions:
        scrub.is_fleet, scrub.tracks = True, _fleet(positions, start.radius, _arrivals(all_records))
    else:
        scrub.fields = _fields(all_records)
    if not (scrub.tracks or len(scrub.fields) > 1):
        return None
    for record in all_records:
        _take(scrub, record)
    scrub.paths = _kept_paths(scrub)
    ends = [int(track.times[-1]) for track in scrub.tracks]
    ends += [event.time for event in scrub.events] + [each.time for each in scrub.fields]
    ends += [path.time for path in scrub.paths]
    scrub.end = max(1, *ends)
    scrub.series = series_of(all_records, scrub.end, scrub.tracks)
    return scrub


def _places(records: Sequence[Record]) -> tuple[dict[str, list[PoseRecord]], list[PositionsRecord]]:
    poses: dict[str, list[PoseRecord]] = {}
    positions: list[PositionsRecord] = []
    for record in records:
        if isinstance(record, PoseRecord):
            if np.isfinite([record.row, record.column, record.heading, record.speed]).all():
                poses.setdefault(record.source, []).append(record)
        elif isinstance(record, PositionsRecord) and record.positions.size:
            same = not positions or record.positions.shape == positions[0].positions.shape
            positions += [record] if same and np.isfinite(record.positions).all() else []
    return poses, positions


def _in_cells(radius: float, start: MapRecord) -> float:
    return radius / start.resolution if start.resolution else radius


def _driven(name: str, poses: Sequence[PoseRecord], radius: float) -> Track:
    step = -(-len(poses) // MOST_SAMPLES)
    kept = [*poses[:-1:step], poses[-1]]
    times = np.array([each.time for each in kept], np.int64)
    values = np.array([(each.row, each.column, each.heading, each.speed) for each in kept], np.float64)
    rows, columns, headings, speeds = values.T
    return Track(name, times, rows, columns, headings, speeds, radius)


def _arrivals(records: Iterable[Record]) -> list[bool]:
    """Whether each robot of a fleet arrived, in the order of their numbers."""
    return [record.arrived for record in records if isinstance(record, TrajectoryRecord)]


def _fleet(positions: Sequence[PositionsRecord], radius: float, arrivals: Sequence[bool]) -> list[Track]:
    """The tracks of the robots, named by their numbers from 0."""
    count = len(positions[0].positions)
    step = -(-len(positions) * count // MOST_SAMPLES)
    kept = [*positions[:-1:step], positions[-1]]
    times = np.array([each.time for each in kept], np.int64)
    places = np.array([each.positions for each in kept], np.float64)
    tracks = []
    for number in range(count):
        stands = np.flatnonzero(np.any(np.diff(places[:, number], axis=0), axis=1))
        arrived = int(times[stands[-1] + 1 if len(stands) else 0])
        has_arrived = len(arrivals) == count and arrivals[number]
        rows, columns = places[:, number].T
        tracks.append(
            Track(str(number), times, rows, columns, radius=radius, arrived=arrived if has_arrived else None)
        )
    return tracks


def _fields(records: Iterable[Record]) -> list[Field]:
    stages = [record for record in records if isinstance(record, StageRecord) and record.potential.size]
    if not stages:
        return []
    most = max(2, MOST_LEVELS // stages[-1].potential.size)
    step = -(-len(stages) // most)
    kept = [*stages[:-1:step], stages[-1]]
    return [Field(stage.time, stage.stage, stage.potential) for stage in kept]


def _take(scrub: Scrub, record: Record) -> None:
    """Add what one record says of cells, paths, goals and events."""
    if isinstance(record, RobotRecord):
        scrub.cells.begin(record)
    elif isinstance(record, ObstacleRecord):
        scrub.cells.changed(record)
    elif isinstance(record, BeliefRecord):
        scrub.cells.learnt(record)
    elif isinstance(record, GoalRecord):
        scrub.goals.append(Timed(record.time, record.source, record.cells.astype(np.float64)))
    elif isinstance(record, TrajectoryRecord):
        if not scrub.is_fleet and np.isfinite(record.points).all():
            scrub.paths.append(Timed(record.time, record.source, record.points))
    elif isinstance(record, MissionRecord):
        scrub.events.append(Event(record.time, record.source, record.event, record.text))
    elif isinstance(record, StageRecord) and scrub.fields:
        text = (
            f"{counted(record.precision, 'bit')}, {counted(record.sweeps, 'sweep')},"
            f" {counted(record.visits, 'visit')}, {counted(record.local_maxima, 'local maximum', 'local maxima')} left"
        )
        scrub.events.append(Event(record.time, record.source, f"stage {record.stage}", text))


def _kept_paths(scrub: Scrub) -> list[Timed]:
    """The last paths that have no more than ``MOST_POINTS`` points."""
    total, kept = 0, []
    for path in reversed(scrub.paths):
        total += len(path.points)
        if total > MOST_POINTS:
            break
        kept.append(path)
    return kept[::-1]
