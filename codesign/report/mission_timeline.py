"""How busy each component and link of a mission was over time, with its plans and events."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.records import (
    MessageRecord,
    MissionRecord,
    PoseRecord,
    Record,
    StageRecord,
    TaskRecord,
    VisitsRecord,
)
from codesign.report.plots import Format, Picture, canvas, picture_bytes, style
from codesign.report.wording import prefix
from codesign.units import PICOSECONDS_PER_SECOND, counted, format_time

_BINS = 240

_NUMBER = re.compile(r"_\d+$")
_MOST_ALIKE = 8
_ANY = "any of"
_SPREAD_ROW = "; many components that are alike, such as the FPGAs of a fleet, share a row, which is busy where any of them is"

MARKS: dict[str, tuple[str, str, str]] = {
    "plan_requested": ("new plan asked for", "o", "#7b3294"),
    "deadline_missed": ("deadline missed", "v", "#e08214"),
    "safety_stop": ("safety stop", "s", "#b35806"),
    "no_way": ("no path", "D", "#000000"),
    "contact": ("contact", "X", "#d7191c"),
    "livelock": ("livelock", "P", "#542788"),
    "goal_reached": ("goal reached", "*", "#1a9850"),
}
"""How an event of a mission is marked: its words, its marker and its colour."""


def mission_timeline_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """How busy each component and link was over the mission, with its plans and events; None without a mission.

    The mission is divided into 240 spans. Each shows the share of it in which work was under way, or a robot moved.
    Small shares are drawn darker than in proportion, so that they can be seen.
    """
    spans: dict[str, list[tuple[int, int]]] = {}
    events: list[MissionRecord] = []
    poses: dict[str, PoseRecord] = {}
    last = 0
    for record in records:
        span = _span(record)
        if isinstance(record, PoseRecord):
            before = poses.get(record.source, record)
            # Between two poses it moved, unless it stood at both.
            span = (before.time, record.time) if before.speed or record.speed else None
            poses[record.source] = record
        elif isinstance(record, MissionRecord):
            events.append(record)
            last = max(last, record.time)
        if span is not None:
            spans.setdefault(record.source, []).append(span)
            last = max(last, span[1])
    if not events or not spans or not last:
        return None
    from matplotlib.colors import PowerNorm

    size, unit = prefix([last / PICOSECONDS_PER_SECOND], "s")
    scale = size * PICOSECONDS_PER_SECOND
    rows = _busy_rows(spans, last)
    sources, shares = list(rows), np.array(list(rows.values()))
    with style():
        picture, axes = canvas((9.0, 1.9 + 0.36 * len(sources)))
        shades = axes.imshow(
            shares, cmap="Blues", norm=PowerNorm(0.35, 0, 1), aspect="auto", interpolation="nearest",
            extent=(0, last / scale, len(sources) - 0.5, -0.5),
        )  # fmt: skip
        picture.colorbar(shades, ax=axes, pad=0.02, ticks=[0, 0.01, 0.1, 0.5, 1]).set_label("busy share")
        _draw_events(axes, events, scale)
        axes.set_yticks([-1.0, *range(len(sources))], ["plans, events", *sources])
        axes.set(xlabel=f"time ({unit})", xlim=(0, last / scale), ylim=(len(sources) - 0.5, -1.6))
        legend(picture)
        data = picture_bytes(picture, format)
    busiest = max(sources, key=lambda source: float(shares[sources.index(source)].mean()), default="nothing")
    title = "How busy each component and link was"
    return Picture(
        title=title,
        alt=f"Time line of {', '.join(sources)} over {format_time(last)}, {counted(len(events), 'event')};"
        f" the busiest is {busiest}",
        format=format,
        data=data,
        caption=f"{title}{_SPREAD_ROW if any(_ANY in source for source in sources) else ''}",
    )


def _busy_rows(spans: Mapping[str, list[tuple[int, int]]], last: int) -> dict[str, NDArray[np.float64]]:
    """The busy shares of each source, by name; many that differ by a number only share a row."""
    alike: dict[str, list[str]] = {}
    for source in sorted(spans):
        alike.setdefault(_NUMBER.sub("", source), []).append(source)
    rows: dict[str, NDArray[np.float64]] = {}
    for stem, sources in alike.items():
        if len(sources) <= _MOST_ALIKE:
            for source in sorted(sources, key=_numbered):
                rows[source] = busy_shares(spans[source], last, _BINS)
        else:
            together = [span for source in sources for span in spans[source]]
            rows[f"{stem}, {_ANY} {len(sources)}"] = busy_shares(together, last, _BINS)
    return rows


def _numbered(source: str) -> int:
    """The number at the end of a name."""
    ending = _NUMBER.search(source)
    return int(ending[0][1:]) if ending else 0


def _span(record: Record) -> tuple[int, int] | None:
    """From when to when ``record.source`` was at work, ps."""
    if isinstance(record, MessageRecord):
        return record.begin, record.end
    if isinstance(record, TaskRecord | VisitsRecord):
        return record.time, record.end
    if isinstance(record, StageRecord):
        return record.begin, record.time
    return None


def busy_shares(spans: Sequence[tuple[int, int]], end: int, bins: int) -> NDArray[np.float64]:
    """The share of each of ``bins`` equal parts of the time from 0 to ``end`` that the spans (ps) cover.

    What overlaps counts once.
    """
    edges = np.linspace(0.0, float(end), bins + 1)
    covered = np.zeros(bins + 1)
    until = 0
    merged: list[tuple[int, int]] = []
    for begin, stop in sorted(spans):
        if stop > max(begin, until):
            merged.append((max(begin, until), stop))
            until = stop
    if merged:
        # Time covered up to each edge: piecewise linear between the ends of the spans.
        times = np.array(merged, np.float64).ravel()
        total = np.concatenate(([0.0], np.cumsum(times[1::2] - times[::2])))
        at_ends = np.column_stack((total[:-1], total[1:])).ravel()
        covered = np.interp(edges, times, at_ends)
    shares: NDArray[np.float64] = np.diff(covered) / (end / bins)
    return np.clip(shares, 0.0, 1.0)


def _draw_events(axes: Any, events: Sequence[MissionRecord], scale: float) -> None:
    """Each plan as a bar from when it was asked for to its answer, and each event as a mark, above all rows."""
    asked: dict[str, int] = {}
    bars = []
    marks: dict[str, list[float]] = {}
    for event in events:
        if event.event == "plan_requested":
            asked.setdefault(event.source, event.time)
        elif event.event in ("plan_ready", "no_way", "ended") and event.source in asked:
            begin = asked.pop(event.source)
            bars.append((begin / scale, (event.time - begin) / scale))
        if event.event in MARKS and event.event != "plan_requested":
            marks.setdefault(event.event, []).append(event.time / scale)
    if bars:
        axes.broken_barh(
            bars,
            (-0.9, 0.35),
            facecolors="#7b3294",
            edgecolors="#7b3294",
            linewidth=0.6,
            label="plan under way",
        )
    for event_name, times in marks.items():
        words, marker, colour = MARKS[event_name]
        axes.plot(
            times, [-1.2] * len(times), marker, color=colour, markersize=marker_size(marker), linestyle="none",
            clip_on=False, label=f"{words} ({len(times)})",
        )  # fmt: skip


def marker_size(marker: str) -> int:
    """Points across: a star needs more to be seen."""
    return 9 if marker == "*" else 5


def legend(picture: Any) -> None:
    """A legend below the axes; none where there is nothing to name."""
    if any(axes.get_legend_handles_labels()[1] for axes in picture.axes):
        picture.legend(loc="outside lower center", ncols=4, frameon=False, fontsize=8)
