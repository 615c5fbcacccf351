"""What the page of a run shows of its course: the data of the script, the events, the legend, the table of robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from codesign.report.page import script_json, template_text
from codesign.report.scrub import Event, Scrub
from codesign.report.scrub_cells import UNKNOWN
from codesign.report.scrub_data import scrub_data, tick_of
from codesign.report.scrub_series import Track
from codesign.report.table import Cell, Table, left, right
from codesign.report.wording import ABSENT, quantity_cell
from codesign.units import PICOSECONDS_PER_SECOND, counted, format_time

MOST_EVENTS = 1500
_SCRIPTS = (
    "numbers.js",
    "columns.js",
    *(f"run/{name}.js" for name in ("timeline", "drawing", "charts", "player")),
)
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
    """What the template places of a run over time."""
    data, many = scrub_data(scrub), len(scrub.tracks) > 1
    rows, columns = scrub.map.free.shape
    robots = f", {counted(len(scrub.tracks), 'robot')}" if scrub.tracks else ""
    listed = _listed(scrub.events)
    left_out = len(scrub.events) - len(listed)
    return ScrubPart(
        title="The fleet over time"
        if scrub.is_fleet
        else "The run over time"
        if scrub.tracks
        else "Stage by stage",
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
    return EventLine(
        event.time // tick, format_time(event.time) if event.time else "0 s", f"{who}{kind}: {event.text}"
    )


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
        legend += [
            ("drives", "drives"),
            ("arrived", "rests at its target"),
            ("still", "stands"),
            ("near", "touches another"),
        ]
    elif scrub.tracks:
        legend += [("drives", "robot that drives, and its trail"), ("still", "robot that stands")]
    return [*legend, ("goal", "target" if scrub.is_fleet else "goal")]


def robots_table(scrub: Scrub) -> Table:
    """Each robot in a row, the worst first: those that do not rest at their targets, then those that came last."""
    cell = scrub.map.resolution or 1.0
    unit = "m" if scrub.map.resolution else "cells"
    nearest = _nearest(scrub.tracks)
    rows = []
    for number, track in sorted(enumerate(scrub.tracks), key=lambda pair: (-_arrival(pair[1]), pair[0])):
        steps = np.hypot(np.diff(track.rows), np.diff(track.columns))
        driven = float(steps.sum())
        straight = float(np.hypot(track.rows[-1] - track.rows[0], track.columns[-1] - track.columns[0]))
        stood = float(np.diff(track.times)[steps == 0][: _moving(steps)].sum()) / PICOSECONDS_PER_SECOND
        gap, other = nearest[number]
        arrived = None if track.arrived is None else track.arrived / PICOSECONDS_PER_SECOND
        rows.append(
            (
                Cell(track.name, number),
                Cell(ABSENT, None) if arrived is None else quantity_cell(arrived, "s"),
                quantity_cell(_digits(driven * cell), unit),
                quantity_cell(_digits(driven / straight), "1") if straight else Cell(ABSENT),
                quantity_cell(stood, "s"),
                quantity_cell(None if gap is None else _digits(gap * cell), unit),
                Cell(ABSENT if other is None else scrub.tracks[other].name, other),
            )
        )
    columns = (
        *left("robot"),
        *right("rests from", unit="s"),
        *right("driven", unit=unit),
        *right("over the straight line", unit="1"),
        *right("stood on its way", unit="s"),
        *right("least distance to another", unit=unit),
        *right("to robot"),
    )
    notes = (
        "The worst come first: robots that do not rest at their targets, then those that came last. A robot has"
        " arrived some updates before it rests. A click on a heading sorts. Distances are between middles, at updates.",
    )
    return Table("Robots", columns, tuple(rows), notes)


def _arrival(track: Track) -> float:
    return float("inf") if track.arrived is None else float(track.arrived)


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
    rows, columns = (
        np.array([vars(track)[name] for track in tracks])[:, ::step] for name in ("rows", "columns")
    )
    pairs: list[tuple[float | None, int | None]] = []
    for number in range(len(tracks)):
        far = np.hypot(rows - rows[number], columns - columns[number]).min(axis=1)
        far[number] = np.inf
        other = int(far.argmin())
        pairs.append((float(far[other]), other))
    return pairs
