"""Where the time of components and links went: each span of a plan, the busy shares of a mission, the sums."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.figures import label
from codesign.records import (
    ENDED,
    MessageRecord,
    MissionRecord,
    PoseRecord,
    Record,
    StageRecord,
    TaskRecord,
    VisitsRecord,
)
from codesign.report.canvas import MARKS, Format, Picture, canvas, drawn, legend, marker_size, style
from codesign.report.scenario_tables import busy_share
from codesign.report.wording import prefix, share_text
from codesign.results.mission import Account
from codesign.units import PICOSECONDS_PER_SECOND, counted, format_time

_MOST_BARS = 400
_BINS = 240

_NUMBER = re.compile(r"_\d+$")
_MOST_ALIKE = 8
_ANY = "any of"
_SPREAD_ROW = (
    "; many components of a kind, such as the FPGAs of a fleet, share a row: it is busy where any of them is"
)

Bar = tuple[str, str, int, int]
"""The component or link, what it did, from, to (ps)."""


def bars_of(records: Iterable[Record]) -> list[Bar]:
    """The spans of work that a picture shows, longest first: a thousand slivers would make it heavy."""
    works = [
        (record.source, *work)
        for record in records
        if not isinstance(record, VisitsRecord) and (work := _work(record)) is not None
    ]
    return sorted(works, key=lambda bar: (bar[2] - bar[3], bar))[:_MOST_BARS]


def _work(record: Record) -> tuple[str, int, int] | None:
    """What ``record.source`` did, from when to when, ps."""
    if isinstance(record, MessageRecord):
        return f"message: {record.name}", record.begin, record.end
    if isinstance(record, TaskRecord):
        outcome = "" if record.outcome == ENDED else f" ({record.outcome})"
        return f"{label(record.task)}{outcome}", record.time, record.end
    if isinstance(record, VisitsRecord):
        return "visits", record.time, record.end
    return ("stages", record.begin, record.time) if isinstance(record, StageRecord) else None


def timeline_picture(bars: Iterable[Bar], *, format: Format = "png") -> Picture:
    """When each component and link was busy, and with what: a row for each, and a bar for each span of work."""
    shown = list(bars)
    sources = list(dict.fromkeys(bar[0] for bar in sorted(shown, key=lambda bar: (bar[2], bar[0]))))
    kinds = list(dict.fromkeys(bar[1] for bar in sorted(shown, key=lambda bar: (bar[2], bar[1]))))
    last = max(bar[3] for bar in shown)
    size, unit = prefix([last / PICOSECONDS_PER_SECOND], "s")
    scale = size * PICOSECONDS_PER_SECOND
    with style():
        picture, axes = canvas((8.0, 0.9 + 0.42 * len(sources)))
        for number, kind in enumerate(kinds):
            _row_bars(axes, [bar for bar in shown if bar[1] == kind], sources, scale, kind, f"C{number % 10}")
        axes.set_yticks(range(len(sources)), sources)
        axes.set(xlabel=f"time ({unit})", xlim=(0, last / scale), ylim=(len(sources) - 0.5, -0.5))
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False, fontsize=8)
    return drawn(
        picture,
        format,
        title="When each component and link was busy",
        alt=f"Time line of {', '.join(sources)} over {format_time(last)}; utilisation stands in its table",
    )


def _row_bars(axes: Any, bars: list[Bar], sources: list[str], scale: float, kind: str, colour: str) -> None:
    from matplotlib.colors import to_rgba

    # Only the first of a kind stands in the legend; an underscore keeps the others out.
    labels = itertools.chain([kind], itertools.repeat("_"))
    for row, source in enumerate(sources):
        spans = sorted(
            (begin / scale, (end - begin) / scale) for busy, _, begin, end in bars if busy == source
        )
        if spans:
            # Shades alternate, so that neighbours can be told apart; the edge keeps slivers in sight.
            shades = [to_rgba(colour, 0.55 if number % 2 else 0.9) for number in range(len(spans))]
            axes.broken_barh(
                spans,
                (row - 0.34, 0.68),
                facecolors=shades,
                edgecolors=colour,
                linewidth=0.6,
                label=next(labels),
            )


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
        work = _work(record)
        span = None if work is None else work[1:]
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
    busiest = max(sources, key=lambda source: float(shares[sources.index(source)].mean()), default="nothing")
    title = "How busy each component and link was"
    return drawn(
        picture,
        format,
        title=title,
        alt=f"Time line of {', '.join(sources)} over {format_time(last)}, {counted(len(events), 'event')};"
        f" the busiest is {busiest}",
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


def account_picture(accounts: Mapping[str, Account], *, format: Format = "png") -> Picture | None:
    """Where the time of each component and link went, as stacked bars; None where there are none.

    ``accounts``: by name, with ``compute_s``, ``transfer_s`` and ``idle_s``, which make up the mission, and ``wait_s``,
    a bar of its own below.
    """
    if not accounts:
        return None
    names = list(accounts)
    size, unit = prefix(
        [max(account.compute_s + account.transfer_s + account.idle_s for account in accounts.values())], "s"
    )
    kinds = (("compute", "#2166ac"), ("transfer", "#4dac26"), ("idle", "#e6e9ed"))
    with style():
        picture, axes = canvas((8.0, 1.3 + 0.42 * len(names)))
        rows, left = np.arange(len(names)), np.zeros(len(names))
        for kind, colour in kinds:
            widths = np.array([vars(accounts[name])[f"{kind}_s"] for name in names]) / size
            axes.barh(rows, widths, left=left, color=colour, height=0.56, label=kind)
            left += widths
        # What waits does so side by side, and while others are served: it is no part of the bar.
        waits = np.array([accounts[name].wait_s for name in names]) / size
        axes.barh(rows + 0.38, waits, color="#f4a259", height=0.14, label="others wait for it")
        for row, name in enumerate(names):
            axes.text(
                left[row], row, f"  {share_text(busy_share(accounts[name]))} busy", va="center", fontsize=8
            )
        axes.set_yticks(range(len(names)), names)
        axes.margins(x=0.14)
        axes.set_xlim(left=0.0)
        axes.set(xlabel=f"time ({unit})", ylim=(len(names) - 0.5, -0.5))
        legend(picture)
    return drawn(
        picture,
        format,
        title="Where the time of each component and link went",
        alt=f"Stacked bars of compute, transfer and idle of {', '.join(names)}, waits below; figures stand in a table",
    )
