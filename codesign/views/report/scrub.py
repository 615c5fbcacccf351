"""A run over time, for a page that is scrubbed: its records reduced to tracks, changed cells, paths, events and series.

``scrub_of`` takes records of a run in memory, or of a trace. ``scrub_page`` packs what it returns.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.activity import Span, depth_over_time, share_over_time, spans_by_place, spans_of, union
from codesign.ground.records import (
    ACTIVITY_KINDS,
    BeliefRecord,
    MapRecord,
    ObstacleRecord,
    Record,
    RobotRecord,
    Subject,
    kinds_about,
)
from codesign.ground.units import counted
from codesign.study.groups import Groups

# The cells of a run over time: a grid at the begin, and what becomes of each cell at what time.

LARGEST_SIDE = 800
MOST_CHANGES = 400_000
_BINS = 4096

FREE, UNKNOWN, BLOCKED = 0, 1, 2
"""The belief of the robot about a tile, as the script of the page takes it."""

NOW_BLOCKED, NOW_FREE, NOW_UNKNOWN, BELIEVED_FREE, BELIEVED_BLOCKED = range(5)
"""The fate of a cell: of the true map, or of the belief of the robot."""

_BELIEF = {FREE: BELIEVED_FREE, UNKNOWN: NOW_UNKNOWN, BLOCKED: BELIEVED_BLOCKED}


@dataclass(frozen=True)
class Changes:
    """Cells that changed, in the order of time: when (ps, int64), which (int64, row by row), and into what (uint8)."""

    times: NDArray[np.int64]
    cells: NDArray[np.int64]
    kinds: NDArray[np.uint8]

    def coarsened(self, end: int) -> Changes:
        """The same, where there are too many: of the changes of a cell in a short span only the last one."""
        if len(self.times) <= MOST_CHANGES:
            return self
        spans = self.times * _BINS // max(end, 1)
        of_belief = self.kinds >= NOW_UNKNOWN
        # The last of each is the first of the reversed.
        lasts = Groups.of(spans[::-1], of_belief[::-1], self.cells[::-1]).firsts
        kept = np.sort(len(spans) - 1 - lasts)
        return Changes(self.times[kept], self.cells[kept], self.kinds[kept])


@dataclass
class Cells:
    """The true map, and the belief of the robot, in tiles of ``tile`` × ``tile`` cells.

    ``free``: bool, rows × columns, at the begin. ``believed``: uint8, the same shape, or None without a belief.
    """

    start: MapRecord
    tile: int = field(init=False)
    free: NDArray[np.bool_] = field(init=False)
    believed: NDArray[np.uint8] | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self.tile = max(1, -(-max(self.start.free.shape) // LARGEST_SIDE))
        self._free, self._known = self.start.free.copy(), np.full(self.start.free.shape, UNKNOWN, np.uint8)
        self.free = self._tiles(~self._free) == 0
        self._parts: list[tuple[int, NDArray[np.int64], NDArray[np.uint8]]] = []

    def begin(self, robot: RobotRecord) -> None:
        """The map that the robot has at the begin: without what is hidden from it, or nothing."""
        if robot.knows:
            self._known = np.where(self.start.free, FREE, BLOCKED).astype(np.uint8)
            if self.start.unknown is not None and self.start.unknown.shape == self._known.shape:
                self._known[self.start.unknown] = UNKNOWN
            hidden = self._inside(robot.hidden)[0]
            self._known[hidden[:, 0], hidden[:, 1]] = FREE
        self.believed = self._tiles(self._known)

    def changed(self, record: ObstacleRecord) -> None:
        """Cells of the true map became blocked, or free."""
        cells, _ = self._inside(record.cells)
        self._free[cells[:, 0], cells[:, 1]] = not record.appeared
        self._note(record.time, cells, ~self._free, {0: NOW_FREE, 1: NOW_BLOCKED})

    def learnt(self, record: BeliefRecord) -> None:
        """The robot saw cells."""
        if self.believed is None:
            self.believed = self._tiles(self._known)
        cells, kept = self._inside(record.cells)
        self._known[cells[:, 0], cells[:, 1]] = np.where(record.blocked[kept], BLOCKED, FREE)
        self._note(record.time, cells, self._known, _BELIEF)

    @property
    def changes(self) -> Changes:
        """All changes, in the order of time."""
        parts = sorted(self._parts, key=lambda part: part[0])
        if not parts:
            return Changes(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.uint8))
        times = np.repeat(np.array([part[0] for part in parts], np.int64), [len(part[1]) for part in parts])
        return Changes(times, np.concatenate([part[1] for part in parts]), np.concatenate([part[2] for part in parts]))

    def _inside(self, cells: NDArray[np.int32]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """The cells in rows and columns of the arrays, without those outside; and which of them were kept."""
        here = cells.reshape(-1, 2).astype(np.int64) - np.array(self.start.corner)
        kept: NDArray[np.bool_] = ((here >= 0) & (here < self._free.shape)).all(axis=1)
        return here[kept], kept

    def _note(self, time: int, cells: NDArray[np.int64], grid: NDArray[Any], kinds: dict[int, int]) -> None:
        """Keep what became of these cells; of tiles the greatest value of their cells."""
        if not len(cells):
            return
        tiles = np.unique(cells // self.tile, axis=0) if self.tile > 1 else cells
        steps = range(self.tile)
        values = np.zeros(len(tiles), np.int64)
        for down in steps:
            for across in steps:
                row, column = (tiles * self.tile + (down, across)).T
                is_in = (row < grid.shape[0]) & (column < grid.shape[1])
                values[is_in] = np.maximum(values[is_in], grid[row[is_in], column[is_in]])
        codes = np.array([kinds.get(value, 0) for value in range(max(kinds) + 1)], np.uint8)
        self._parts.append((time, tiles[:, 0] * self.free.shape[1] + tiles[:, 1], codes[values]))

    def _tiles(self, grid: NDArray[Any]) -> NDArray[np.uint8]:
        return greatest_in_tiles(grid.astype(np.uint8), self.tile)


def greatest_in_tiles(grid: NDArray[Any], tile: int) -> NDArray[Any]:
    """The greatest value, but for NaN, in each tile of ``tile`` × ``tile`` cells."""
    if tile == 1 or not grid.size:
        return grid
    down, across = (np.arange(0, side, tile) for side in grid.shape)
    most: NDArray[Any] = np.fmax.reduceat(np.fmax.reduceat(grid, down, axis=0), across, axis=1)
    return most


Floats = NDArray[np.float64]

SCRUB_KINDS = tuple(
    {
        *ACTIVITY_KINDS,
        *kinds_about(
            Subject.MAP, Subject.ROBOT, Subject.GOALS, Subject.POSE, Subject.FLEET, Subject.CHANGE,
            Subject.BELIEF, Subject.PATH, Subject.EVENT, Subject.STAGE, Subject.FIELD,
        ),
    }
)  # fmt: skip
"""The record classes that a page of a run is made from, with its pictures."""

MOST_SAMPLES = 160_000
"""Positions of all robots together; of more, some updates are left out, and the page draws between."""

MOST_POINTS = 200_000
"""Points of all paths together; of more, the last paths are kept."""

MOST_LEVELS = 4_000_000
"""Cells of the fields of all stages together; of more, some stages are left out."""


BINS = 480
_MOST_LINES = 4


@dataclass(frozen=True)
class Track:
    """The places of a robot: ``times`` (ps, int64, rising), ``rows``, ``columns`` (cells).

    ``arrived``: when it came to stand at its target, ps; None where it did not, and of a robot that drives on.
    ``headings`` (radians, from growing columns to growing rows) and ``speeds`` (m/s) are None in a fleet, which reports
    places alone. ``radius``: of its body, cells; 0: not known.
    """

    name: str
    times: NDArray[np.int64]
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    headings: NDArray[np.float64] | None = None
    speeds: NDArray[np.float64] | None = None
    radius: float = 0.0
    arrived: int | None = None


@dataclass(frozen=True)
class Series:
    """A quantity in ``BINS`` equal spans of the run, in ``unit``. ``counted``: measure, count or share."""

    name: str
    unit: str
    counted: str
    values: NDArray[np.float64]


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
    groups = map_reduce(all_records, lambda record: record.ROLE.about)

    def about(subject: Subject) -> list[Any]:
        return list(groups.get(subject, ()))

    start = next(iter(about(Subject.MAP)), None)
    if start is None or not start.free.size:
        return None
    scrub = Scrub(Cells(start))
    poses = map_reduce(filter(_is_finite, about(Subject.POSE)), lambda record: record.source)
    positions = _alike(about(Subject.FLEET))
    radii = {record.source: record.radius / (start.resolution or 1.0) for record in about(Subject.ROBOT)}
    if poses:
        scrub.tracks = [_driven(name, track, radii.get(name, 0.0)) for name, track in poses.items()]
    elif positions:
        scrub.is_fleet = True
        scrub.tracks = _fleet(positions, start.radius, [record.arrived for record in about(Subject.PATH)])
    else:
        scrub.fields = _fields(about(Subject.STAGE))
    if not (scrub.tracks or len(scrub.fields) > 1):
        return None
    takers = _takers(scrub)
    for record in all_records:
        take = takers.get(record.ROLE.about)
        if take is not None:
            take(record)
    scrub.paths = _kept_paths(scrub)
    ends = [int(track.times[-1]) for track in scrub.tracks]
    ends += [event.time for event in scrub.events] + [each.time for each in scrub.fields]
    ends += [path.time for path in scrub.paths]
    scrub.end = max(1, *ends)
    scrub.series = series_of(all_records, scrub.end, scrub.tracks)
    return scrub


def _is_finite(pose: Any) -> bool:
    return bool(np.isfinite([pose.row, pose.column, pose.heading, pose.speed]).all())


def _alike(updates: Iterable[Any]) -> list[Any]:
    """The updates of a fleet with finite positions of as many robots as the first one has."""
    finite = [each for each in updates if each.positions.size and np.isfinite(each.positions).all()]
    return [each for each in finite if each.positions.shape == finite[0].positions.shape]


def _driven(name: str, poses: Sequence[Any], radius: float) -> Track:
    kept = _thinned(poses, MOST_SAMPLES)
    times = np.array([each.time for each in kept], np.int64)
    values = np.array([(each.row, each.column, each.heading, each.speed) for each in kept], np.float64)
    rows, columns, headings, speeds = values.T
    return Track(name, times, rows, columns, headings, speeds, radius)


def _fleet(positions: Sequence[Any], radius: float, arrivals: Sequence[bool]) -> list[Track]:
    """The tracks of the robots, named by their numbers from 0."""
    count = len(positions[0].positions)
    kept = _thinned(positions, MOST_SAMPLES, count)
    times = np.array([each.time for each in kept], np.int64)
    places = np.array([each.positions for each in kept], np.float64)
    tracks = []
    for number in range(count):
        stands = np.flatnonzero(np.any(np.diff(places[:, number], axis=0), axis=1))
        arrived = int(times[stands[-1] + 1 if len(stands) else 0])
        has_arrived = len(arrivals) == count and arrivals[number]
        rows, columns = places[:, number].T
        tracks.append(Track(str(number), times, rows, columns, radius=radius, arrived=arrived if has_arrived else None))
    return tracks


def _fields(records: Iterable[Any]) -> list[Field]:
    stages = [record for record in records if record.potential.size]
    if not stages:
        return []
    kept = _thinned(stages, max(2, MOST_LEVELS // stages[-1].potential.size))
    return [Field(stage.time, stage.stage, stage.potential) for stage in kept]


def _thinned(records: Sequence[Any], most: int, size: int = 1) -> list[Any]:
    """Each n-th of the records, ``size`` things each, so that about ``most`` things are left, and the last one."""
    return [*records[: -1 : -(-len(records) * size // most)], records[-1]]


def _takers(scrub: Scrub) -> dict[Subject, Callable[[Any], None]]:
    """The functions that add a record to the cells, paths, goals and events, by what the record is about."""

    def path(record: Any) -> None:
        if not scrub.is_fleet and np.isfinite(record.points).all():
            scrub.paths.append(Timed(record.time, record.source, record.points))

    def goals(record: Any) -> None:
        scrub.goals.append(Timed(record.time, record.source, record.cells.astype(np.float64)))

    def event(record: Any) -> None:
        scrub.events.append(Event(record.time, record.source, record.event, record.text))

    def stage(record: Any) -> None:
        if scrub.fields:
            left = counted(record.local_maxima, "local maximum", "local maxima")
            costs = f"{counted(record.sweeps, 'sweep')}, {counted(record.visits, 'visit')}"
            text = f"{counted(record.precision, 'bit')}, {costs}, {left} left"
            scrub.events.append(Event(record.time, record.source, f"stage {record.stage}", text))

    return {
        Subject.ROBOT: scrub.cells.begin,
        Subject.CHANGE: scrub.cells.changed,
        Subject.BELIEF: scrub.cells.learnt,
        Subject.GOALS: goals,
        Subject.PATH: path,
        Subject.EVENT: event,
        Subject.STAGE: stage,
    }


def _kept_paths(scrub: Scrub) -> list[Timed]:
    """The last paths that have no more than ``MOST_POINTS`` points."""
    total, kept = 0, []
    for path in reversed(scrub.paths):
        total += len(path.points)
        if total > MOST_POINTS:
            break
        kept.append(path)
    return kept[::-1]


def series_of(records: Sequence[Record], end: int, tracks: Sequence[Track]) -> list[Series]:
    """The series that the records allow."""
    spans = spans_of(records)
    return [*_speeds(tracks, end), *_busy(spans, end), *_queues(spans, end)]


def _speeds(tracks: Sequence[Track], end: int) -> list[Series]:
    """The speed of each robot; of many robots, and of a fleet, the share of them that move."""
    middles = (np.arange(BINS) + 0.5) * end / BINS
    if tracks and all(track.speeds is not None for track in tracks) and len(tracks) <= _MOST_LINES:
        names = [f"speed of {track.name}" if len(tracks) > 1 else "speed" for track in tracks]
        return [
            Series(name, "m/s", "measure", np.interp(middles, track.times, track.speeds))
            for name, track in zip(names, tracks, strict=True)
            if track.speeds is not None
        ]
    if not tracks:
        return []
    moving = np.zeros(BINS)
    for track in tracks:
        moves = np.append(np.hypot(np.diff(track.rows), np.diff(track.columns)) > 0, [False])
        moving += moves[np.clip(np.searchsorted(track.times, middles, "right") - 1, 0, len(moves) - 1)]
    return [Series("robots that move", "1", "count", moving)]


def _busy(spans: Sequence[Span], end: int) -> list[Series]:
    """The busy shares of the busiest components; components of a fleet, one for each robot, count together."""
    works = (span for span in spans if span.kind in ("task", "visits"))
    # The boards of a fleet have the names COMPONENT and COMPONENT.ROBOT.
    by_name = map_reduce(works, lambda span: span.where.partition(".")[0], lambda span: span.times)
    shares = {name: share_over_time(union(each), 0, end, BINS) for name, each in by_name.items()}
    busiest = sorted(shares, key=lambda name: -float(shares[name].mean()))[:_MOST_LINES]
    return [Series(f"{name} busy", "1", "share", np.clip(shares[name], 0.0, 1.0)) for name in busiest]


def _queues(spans: Sequence[Span], end: int) -> list[Series]:
    """The most messages at a time at each link, waiting or on the wire; the longest queues first."""
    links = spans_by_place(spans, "message", "wait")
    depths = {name: _most_over_time(*depth_over_time(each), end) for name, each in links.items()}
    longest = sorted(depths, key=lambda name: -float(depths[name].sum()))[:_MOST_LINES]
    return [Series(f"messages at {name}", "1", "count", depths[name]) for name in longest]


def _most_over_time(times: NDArray[np.int64], depth: NDArray[np.int64], end: int) -> NDArray[np.float64]:
    """The greatest depth in each span of the run."""
    most = np.zeros(BINS)
    if len(times):
        places = np.clip(times * BINS // end, 0, BINS - 1)
        np.maximum.at(most, places, depth)
        # What is there at the begin of a span counts, too.
        begins = np.searchsorted(times, np.arange(BINS) * end // BINS, "right") - 1
        at_begin = np.where(begins >= 0, depth[np.maximum(begins, 0)], 0)
        most = np.maximum(most, at_begin)
    return most
