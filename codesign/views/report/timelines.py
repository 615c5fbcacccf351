"""The time lines of components and links: each span of a plan, the busy shares of a mission, the sums."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from operator import itemgetter
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.activity import Span, share_over_time, spans_of, union
from codesign.ground.figures import label
from codesign.ground.late import late
from codesign.ground.records import Record, Subject
from codesign.ground.units import PICOSECONDS_PER_SECOND, counted, format_time
from codesign.system.results.mission import Account
from codesign.views.report.canvas import MARKS, Format, Picture, canvas, drawn, legend, marker_size, style
from codesign.views.report.scenario_tables import busy_share
from codesign.views.report.wording import prefix, share_text

colours = late("matplotlib.colors")

_MOST_BARS = 400
_BINS = 240

_NUMBER = re.compile(r"_\d+$")
_MOST_ALIKE = 8
_ANY = "any of"
_SPREAD_ROW = "; many components of a kind, such as the FPGAs of a fleet, share a row: it is busy where any of them is"

Bar = tuple[str, str, int, int]
"""The component or link, what it did, from, to (ps)."""


def bars_of(records: Iterable[Record]) -> list[Bar]:
    """The spans of work that a picture shows, longest first: a thousand slivers would make it heavy."""
    bars = [
        (span.where, _BARS[span.kind].format(span.what, label(span.what) + span.tail), *span.times)
        for span in spans_of(records)
        if span.kind in _BARS
    ]
    return sorted(bars, key=lambda bar: (bar[2] - bar[3], bar))[:_MOST_BARS]


_BARS = {"message": "message: {0}", "task": "{1}", "stage": "stages"}
"""The words of a bar, by the kind of its span: with the name, and with its words and its outcome."""


def timeline_picture(bars: Iterable[Bar], *, format: Format = "png") -> Picture:
    """The busy times of each component and link, and the work: a row for each, and a bar for each span of work."""
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
    # Only the first of a kind stands in the legend; an underscore keeps the others out.
    labels = itertools.chain([kind], itertools.repeat("_"))
    for row, source in enumerate(sources):
        spans = sorted((begin / scale, (end - begin) / scale) for busy, _, begin, end in bars if busy == source)
        if spans:
            # Shades alternate, so that neighbours can be told apart; the edge keeps slivers in sight.
            shades = [colours.to_rgba(colour, 0.55 if number % 2 else 0.9) for number in range(len(spans))]
            axes.broken_barh(
                spans, (row - 0.34, 0.68), facecolors=shades, edgecolors=colour, linewidth=0.6, label=next(labels)
            )


def mission_timeline_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """The busy shares of each component and link over the mission, with plans and events; None without a mission.

    The mission is divided into 240 spans. Each shows the share of it in which work was under way, or a robot moved.
    Small shares are drawn darker than in proportion, so that they can be seen.
    """
    all_records = list(records)
    spans = spans_of(all_records)
    works = [(span.where, span.times) for span in spans if span.kind not in ("wait", "plan")]
    works += [(name, times) for name, poses in _poses(all_records).items() for times in _moves(poses)]
    events = [record for record in all_records if record.ROLE.about is Subject.EVENT]
    if not events or not works:
        return None
    last = max(*(event.time for event in events), *(times[1] for _, times in works), 0)
    if not last:
        return None
    size, unit = prefix([last / PICOSECONDS_PER_SECOND], "s")
    scale = size * PICOSECONDS_PER_SECOND
    rows = _busy_rows(map_reduce(works, itemgetter(0), itemgetter(1)), last)
    sources, shares = list(rows), np.array(list(rows.values()))
    with style():
        picture, axes = canvas((9.0, 1.9 + 0.36 * len(sources)))
        shades = axes.imshow(
            shares, cmap="Blues", norm=colours.PowerNorm(0.35, 0, 1), aspect="auto", interpolation="nearest",
            extent=(0, last / scale, len(sources) - 0.5, -0.5),
        )  # fmt: skip
        picture.colorbar(shades, ax=axes, pad=0.02, ticks=[0, 0.01, 0.1, 0.5, 1]).set_label("busy share")
        _draw_events(axes, events, [span for span in spans if span.kind == "plan"], scale)
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


def _poses(records: Iterable[Record]) -> dict[str, list[Any]]:
    """The poses of each robot."""
    poses = (record for record in records if record.ROLE.about is Subject.POSE)
    return map_reduce(poses, lambda record: record.source)


def _moves(poses: Sequence[Any]) -> list[tuple[int, int]]:
    """Between two poses a robot moved, unless it stood at both."""
    pairs = pairwise([poses[0], *poses])
    return [(before.time, after.time) for before, after in pairs if before.speed or after.speed]


def _busy_rows(spans: Mapping[str, list[tuple[int, int]]], last: int) -> dict[str, NDArray[np.float64]]:
    """The busy shares of each source, by name; many that differ by a number only share a row."""
    alike = map_reduce(sorted(spans), lambda source: _NUMBER.sub("", source))
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


def busy_shares(spans: Iterable[tuple[int, int]], end: int, bins: int) -> NDArray[np.float64]:
    """The share of each of ``bins`` equal parts of the time from 0 to ``end`` that the spans (ps) cover.

    What overlaps counts once.
    """
    return np.clip(share_over_time(union(spans), 0, end, bins), 0.0, 1.0)


def _draw_events(axes: Any, events: Sequence[Any], plans: Sequence[Span], scale: float) -> None:
    """Each plan as a bar from when it was asked for to its answer, and each event as a mark, above all rows."""
    bars = [(plan.begin / scale, (plan.end - plan.begin) / scale) for plan in plans]
    marked = (each for each in events if each.event in MARKS and each.event != "plan_requested")
    marks = map_reduce(marked, lambda each: each.event, lambda each: each.time / scale)
    if bars:
        axes.broken_barh(
            bars, (-0.9, 0.35), facecolors="#7b3294", edgecolors="#7b3294", linewidth=0.6, label="plan under way"
        )
    for event_name, times in marks.items():
        words, marker, colour = MARKS[event_name]
        axes.plot(
            times, [-1.2] * len(times), marker, color=colour, markersize=marker_size(marker), linestyle="none",
            clip_on=False, label=f"{words} ({len(times)})",
        )  # fmt: skip


def account_picture(accounts: Mapping[str, Account], *, format: Format = "png") -> Picture | None:
    """The time of each component and link by what it was spent on, as stacked bars; None if there are none.

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
            axes.text(left[row], row, f"  {share_text(busy_share(accounts[name]))} busy", va="center", fontsize=8)
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
