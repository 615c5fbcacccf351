"""The self-contained page of one result: its figures, its pictures, and its course over time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.records import Record
from codesign.ground.units import PICOSECONDS_PER_SECOND, counted, format_time
from codesign.system.results.result import Result
from codesign.views.report.canvas import with_palette
from codesign.views.report.page import Columns, Entry, rendered, script_json, template_text, write_page
from codesign.views.report.pictures import account_picture
from codesign.views.report.result_tables import figure_tables, result_reasons_table, sources_table
from codesign.views.report.scrub import UNKNOWN, Event, Field, Scrub, Timed, Track, greatest_in_tiles, scrub_of
from codesign.views.report.sentences import headline, run_pace_text
from codesign.views.report.wording import ABSENT, ENDED, PACE, Cell, Table, left, number_scales, quantity_cell, right

if TYPE_CHECKING:
    from codesign.views.report.canvas import Picture

# What the page of a run shows of its course: the data of the script, the events, the legend, the table of robots.

MOST_TICKS = 4_000_000
"""A run has no more ticks: they are too short to be seen."""

PARTS = 64
"""Parts of a cell that a place is rounded to."""

_HEADINGS = 256
_LEVELS = 254

MOST_EVENTS = 1500
_SCRIPTS = ("numbers.js", "columns.js", *(f"run/{name}.js" for name in ("timeline", "drawing", "charts", "player")))
_MOST_PAIRS = 10**8

Legend = list[tuple[str, str]]
"""Each colour of the map by its name in ``run.css``, with what it means."""


@dataclass(frozen=True)
class EventLine:
    """An event in the list: its time in ticks and in words, and what happened."""

    at: int
    time: str
    text: str


@dataclass(frozen=True)
class ScrubPart:
    """The part of a page that shows a run over time."""

    title: str
    alt: str
    end: int
    robots: bool
    many: bool
    legend: Legend
    events: list[EventLine]
    more: str
    table: Table | None
    data: str
    script: str
    style: str


def scrub_part(scrub: Scrub) -> ScrubPart:
    """The parts of a run over time that the template places."""
    data, many = scrub_data(scrub), len(scrub.tracks) > 1
    rows, columns = scrub.map.free.shape
    robots = f", {counted(len(scrub.tracks), 'robot')}" if scrub.tracks else ""
    listed = _listed(scrub.events)
    left_out = len(scrub.events) - len(listed)
    return ScrubPart(
        title="The fleet over time" if scrub.is_fleet else "The run over time" if scrub.tracks else "Stage by stage",
        alt=f"Map of {rows} by {columns} cells{robots}, over {format_time(scrub.end)}",
        end=data["end"],
        robots=bool(scrub.tracks),
        many=many,
        legend=_legend(scrub),
        events=[_line(event, scrub, tick_of(scrub.end)) for event in listed],
        more=f"{counted(left_out, 'more event')} in a trace (--trace)" if left_out else "",
        table=robots_table(scrub) if many else None,
        data=script_json(data),
        script="\n".join(template_text(name) for name in _SCRIPTS),
        style=template_text("run/run.css"),
    )


def _listed(events: Sequence[Event]) -> list[Event]:
    """The events of the list. Of too many, those come first that are neither request nor answer of a plan."""
    if len(events) <= MOST_EVENTS:
        return list(events)
    is_plan = {"plan_requested", "plan_ready"}
    ranked = sorted(range(len(events)), key=lambda place: (events[place].kind in is_plan, place))
    return [events[place] for place in sorted(ranked[:MOST_EVENTS])]


def _line(event: Event, scrub: Scrub, tick: int) -> EventLine:
    kind = event.kind.replace("_", " ")
    # A fleet, and a robot that is alone, say everything without their name.
    who = "" if len(scrub.tracks) < 2 or scrub.is_fleet else f"{event.robot}: "
    return EventLine(event.time // tick, format_time(event.time) if event.time else "0 s", f"{who}{kind}: {event.text}")


def _legend(scrub: Scrub) -> Legend:
    cells, kinds = scrub.cells, set(scrub.cells.changes.kinds.tolist())
    legend: Legend = [] if cells.free.all() else [("wall", "wall")]
    if cells.believed is not None:
        legend += [("unknown", "not known")] if (cells.believed == UNKNOWN).any() else []
        legend += [("wall-unknown", "wall, not known")]
        legend += [("stale", "free, believed blocked")] if kinds & {0, 1} else []
    legend += [("came", "obstacle that came")] if 0 in kinds else []
    legend += [("ramp", "potential after the stage, by its logarithm")] if scrub.fields else []
    legend += [("path", "path")] if scrub.paths else []
    if scrub.is_fleet:
        legend += [("drives", "drives"), ("arrived", "rests at its target")]
        legend += [("still", "stands"), ("near", "touches another")]
    elif scrub.tracks:
        legend += [("drives", "robot that drives, and its trail"), ("still", "robot that stands")]
    return [*legend, ("goal", "target" if scrub.is_fleet else "goal")]


def robots_table(scrub: Scrub) -> Table:
    """Each robot in a row, the worst first: those that do not rest at their targets, then those that came last."""
    cell = scrub.map.resolution or 1.0
    unit = "m" if scrub.map.resolution else "cells"
    nearest = _nearest(scrub.tracks)
    rows = []
    arrivals = [math.inf if track.arrived is None else track.arrived for track in scrub.tracks]
    for number, track in sorted(enumerate(scrub.tracks), key=lambda pair: (-arrivals[pair[0]], pair[0])):
        steps = np.hypot(np.diff(track.rows), np.diff(track.columns))
        driven = float(steps.sum())
        straight = float(np.hypot(track.rows[-1] - track.rows[0], track.columns[-1] - track.columns[0]))
        stood = float(np.diff(track.times)[steps == 0][: _moving(steps)].sum()) / PICOSECONDS_PER_SECOND
        gap, other = nearest[number]
        arrived = None if track.arrived is None else track.arrived / PICOSECONDS_PER_SECOND
        rows.append(
            (
                Cell(track.name, number),
                quantity_cell(arrived, "s"),
                quantity_cell(_digits(driven * cell), unit),
                quantity_cell(_digits(driven / straight), "1") if straight else Cell(ABSENT),
                quantity_cell(stood, "s"),
                quantity_cell(None if gap is None else _digits(gap * cell), unit),
                Cell(ABSENT if other is None else scrub.tracks[other].name, other),
            )
        )
    columns = (
        *(*left("robot"), *right("rests from", unit="s"), *right("driven", unit=unit)),
        *(*right("over the straight line", unit="1"), *right("stood on its way", unit="s")),
        *(*right("least distance to another", unit=unit), *right("to robot")),
    )
    notes = (
        "The worst come first: robots that do not rest at their targets, then those that came last. A robot has"
        " arrived some updates before it rests. A click on a heading sorts. Distances are between middles, at updates.",
    )
    return Table("Robots", columns, tuple(rows), notes)


def _moving(steps: np.ndarray[tuple[int], np.dtype[np.float64]]) -> int:
    """The number of steps without a move before the last one with a move."""
    moves = np.flatnonzero(steps)
    return int((steps[: moves[-1] + 1] == 0).sum()) if len(moves) else 0


def _digits(value: float) -> float:
    return float(f"{value:.4g}")


def _nearest(tracks: Sequence[Track]) -> list[tuple[float | None, int | None]]:
    """The least distance of each robot to another at a common time, cells, and to which one."""
    unknown: list[tuple[float | None, int | None]] = [(None, None)] * len(tracks)
    samples = len(tracks[0].times)
    if any(len(track.times) != samples or (track.times != tracks[0].times).any() for track in tracks):
        return unknown
    step = max(1, -(-samples * len(tracks) ** 2 // _MOST_PAIRS))
    rows, columns = (np.array([vars(track)[name] for track in tracks])[:, ::step] for name in ("rows", "columns"))
    pairs: list[tuple[float | None, int | None]] = []
    for number in range(len(tracks)):
        far = np.hypot(rows - rows[number], columns - columns[number]).min(axis=1)
        far[number] = np.inf
        other = int(far.argmin())
        pairs.append((float(far[other]), other))
    return pairs


def tick_of(end: int) -> int:
    """Picoseconds a tick: the least power of ten with which a run has at most ``MOST_TICKS``.

    >>> tick_of(3_999_999), tick_of(200 * 10**12)
    (1, 100000000)
    """
    tick = 1
    while end // tick > MOST_TICKS:
        tick *= 10
    return tick


def scrub_data(scrub: Scrub) -> dict[str, Any]:
    """The run, ready for JSON.

    - ``tick``: ps; ``end`` in ticks. ``rows``, ``columns``: of tiles; ``tile``: cells on its side; ``corner``: the
      first row and column. ``view``: top, left, bottom and right of what is drawn, cells.
    - ``free``, ``believed``: the tiles at the begin; ``changes``: what becomes of them.
    - ``robots``, ``paths``, ``goals``, ``events``, ``fields``, ``series``: as in ``Scrub``.
    - ``packed``: the columns; all else names its place there (``Columns``).
    """
    columns, tick = Columns(), tick_of(scrub.end)
    cells, changes = scrub.cells, scrub.cells.changes.coarsened(scrub.end)
    names = [track.name for track in scrub.tracks]
    return {
        "tick": tick,
        "end": max(1, scrub.end // tick),
        "rows": cells.free.shape[0],
        "columns": cells.free.shape[1],
        "tile": cells.tile,
        "corner": list(scrub.map.corner),
        "resolution": scrub.map.resolution,
        "view": _view(scrub),
        "isFleet": scrub.is_fleet,
        "free": columns.add(cells.free.ravel().astype(np.uint8)),
        "believed": None if cells.believed is None else columns.add(cells.believed.ravel()),
        "changes": {
            "time": columns.steps(changes.times // tick),
            "cell": columns.steps(changes.cells),
            "kind": columns.add(changes.kinds),
        },
        "robots": _robots(scrub.tracks, tick, columns),
        "paths": _timed(scrub.paths, names, tick, columns),
        "goals": _timed(scrub.goals, names, tick, columns),
        "targets": [[float(row), float(column)] for row, column in scrub.map.goals.tolist()],
        "events": [[event.time // tick, _place(names, event.robot), event.kind] for event in scrub.events],
        "fields": _fields(scrub.fields, cells.tile, tick, columns),
        "series": [vars(each) | {"values": columns.add(np.round(each.values, 4))} for each in scrub.series],
        "scales": number_scales(),
        "packed": columns.packed,
    }


def _place(names: Sequence[str], name: str) -> int:
    """The number of a robot; -1 for another name."""
    return names.index(name) if name in names else -1


def _view(scrub: Scrub) -> list[float]:
    """Top, left, bottom and right of the map and of all places of robots, which may lead out of it; cells."""
    first = np.array(scrub.map.corner, np.float64)
    parts = [np.array([first - 0.5, first + np.array(scrub.map.free.shape) - 0.5])]
    for track in scrub.tracks:
        margin = track.radius
        parts += [np.column_stack([track.rows, track.columns]) + side for side in (-margin, margin)]
    points = np.concatenate(parts)
    return [*points.min(axis=0).tolist(), *points.max(axis=0).tolist()]


def _parts(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Places in parts of a cell; what lies absurdly far away is brought near."""
    return np.round(np.clip(values, -1e6, 1e6) * PARTS).astype(np.int64)


def _robots(tracks: Sequence[Track], tick: int, columns: Columns) -> list[dict[str, Any]]:
    times: dict[int, Entry] = {}
    robots = []
    for track in tracks:
        # The robots of a fleet share their times.
        time = times.get(id(track.times)) or columns.steps(track.times // tick)
        times[id(track.times)] = time
        robot: dict[str, Any] = {
            "name": track.name,
            "radius": track.radius,
            "arrived": None if track.arrived is None else track.arrived // tick,
            "time": time,
            "row": columns.steps(_parts(track.rows)),
            "column": columns.steps(_parts(track.columns)),
        }
        if track.headings is not None and track.speeds is not None:
            turns = np.round(track.headings / (2 * math.pi) * _HEADINGS).astype(np.int64) % _HEADINGS
            robot |= {"heading": columns.add(turns), "speed": columns.add(np.round(track.speeds, 4))}
        robots.append(robot)
    return robots


def _timed(each: Sequence[Timed], names: Sequence[str], tick: int, columns: Columns) -> dict[str, Any]:
    """Paths or goals: when, whose, how many points, and all points behind one another."""
    points = np.concatenate([np.zeros((0, 2)), *(one.points.reshape(-1, 2) for one in each)])
    return {
        "time": [one.time // tick for one in each],
        "robot": [_place(names, one.robot) for one in each],
        "count": [len(one.points) for one in each],
        "row": columns.steps(_parts(points[:, 0])),
        "column": columns.steps(_parts(points[:, 1])),
    }


def _fields(fields: Sequence[Field], tile: int, tick: int, columns: Columns) -> dict[str, Any] | None:
    """The fields of stages in levels: 0 for no value above 0, then 1 to 255 from ``low`` to ``high`` (log10)."""
    grids = [greatest_in_tiles(each.values, tile) for each in fields]
    above = [grid[np.isfinite(grid) & (grid > 0)] for grid in grids]
    values = np.concatenate(above) if above else np.zeros(0)
    if not len(values):
        return None
    low, high = math.log10(values.min()), math.log10(values.max())
    levels = []
    for grid in grids:
        has_value = np.isfinite(grid) & (grid > 0)
        share = (np.log10(np.where(has_value, grid, 1.0)) - low) / max(high - low, 1e-12)
        levels.append(np.where(has_value, 1 + np.round(_LEVELS * np.clip(share, 0, 1)), 0).astype(np.uint8))
    return {
        "time": [each.time // tick for each in fields],
        "stage": [each.stage for each in fields],
        "levels": columns.add(np.concatenate([level.ravel() for level in levels])),
        "low": low,
        "high": high,
    }


_NARROW_COLUMNS, _NARROW_LETTERS = 4, 68
"""Tables of at most so many columns, whose headings and numbers need at most so many letters, stand side by side."""


def result_page(
    result: Result,
    path: Path,
    *,
    pictures: Sequence[Picture] = (),
    records: Iterable[Record] = (),
    command: str | None = None,
) -> None:
    """Write the page of one result: its costs, the quality of the plan, the sources of the figures.

    ``records``: of the run, in memory or of a trace. A page with them shows the run over time.

    Raises:
        RunError: the file cannot be written.
    """
    write_page(path, result_html(result, pictures=pictures, records=records, command=command))


def result_html(
    result: Result, *, pictures: Sequence[Picture] = (), records: Iterable[Record] = (), command: str | None = None
) -> str:
    """The page of ``result_page`` as text."""
    tables = [_without_head(table) for table in figure_tables(result)]
    mission, fleet = result.mission, result.fleet
    scrub = scrub_of(records)
    account = None if mission is None else account_picture(mission.account)
    return rendered(
        "result.html.j2",
        result.provenance,
        title=f"{result.workload} on {result.platform}",
        headline=headline(result),
        ended=next((run.ended for run in (mission, fleet) if run is not None), ""),
        bottleneck=run_pace_text(result),
        reasons=result_reasons_table(result) if result.reasons else None,
        narrow=[table for table in tables if _is_narrow(table)],
        wide=[table for table in tables if not _is_narrow(table)],
        sources=sources_table([result]),
        scrub=None if scrub is None else scrub_part(scrub),
        pictures=(*pictures, *([with_palette(account)] if account else [])),
        command=command or f"hwsw run {result.platform} {result.workload} --html report.html",
    )


def records_page(
    records: Iterable[Record], path: Path, *, title: str, pictures: Sequence[Picture] = (), command: str
) -> None:
    """Write the page of a run of which the records alone are there, such as the records of a cut trace.

    Raises:
        RunError: the file cannot be written.
    """
    scrub = scrub_of(records)
    nothing: dict[str, Any] = {"headline": (), "ended": "", "bottleneck": "", "reasons": None, "narrow": (), "wide": ()}
    page = rendered(
        "result.html.j2",
        None,
        **nothing,
        title=title,
        sources=sources_table([]),
        pictures=pictures,
        scrub=None if scrub is None else scrub_part(scrub),
        command=command,
    )
    write_page(path, page)


def _without_head(table: Table) -> Table:
    """The table less the rows that stand in the head of the page."""
    return replace(table, rows=tuple(row for row in table.rows if row[0].text not in (ENDED, PACE)))


def _is_narrow(table: Table) -> bool:
    """True if half of the page is wide enough. Of two columns the second is words, which may be wrapped."""
    if len(table.columns) > _NARROW_COLUMNS:
        return False
    if len(table.columns) <= 2:
        return True
    texts = zip(*([cell.text for cell in row] for row in table.rows), strict=True)
    widths = (max(map(len, column)) for column in texts)
    columns = zip(table.columns, widths, strict=False)
    return sum(max(len(column.name), width) for column, width in columns) <= _NARROW_LETTERS
