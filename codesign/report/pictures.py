"""What the records of one run show: the map with its field and paths, and when each component and link was busy."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any

from codesign.figures import label
from codesign.records import (
    ENDED,
    FieldRecord,
    MapRecord,
    MessageRecord,
    Record,
    StageRecord,
    TaskRecord,
    TrajectoryRecord,
)
from codesign.report.mission_pictures import drive_picture
from codesign.report.mission_timeline import mission_timeline_picture
from codesign.report.plots import Format, Picture, canvas, map_picture, picture_bytes, style
from codesign.report.wording import prefix
from codesign.units import PICOSECONDS_PER_SECOND, counted, format_time

_MOST_BARS = 400


def run_pictures(records: Iterable[Record]) -> tuple[Picture, ...]:
    """The pictures that these records allow, in reading order; none for a run that never began.

    A mission is shown as its drive and its time line in place of the plans' bars.
    """
    all_records = tuple(records)
    drive, busy = drive_picture(all_records), mission_timeline_picture(all_records)
    if drive is not None or busy is not None:
        return tuple(picture for picture in (drive, busy) if picture is not None)
    pictures = []
    maps = [record for record in all_records if isinstance(record, MapRecord)]
    if maps:
        pictures.append(_map(maps[-1], all_records))
    bars = _bars(all_records)
    if bars:
        pictures.append(timeline_picture(bars))
    return tuple(pictures)


def _map(start: MapRecord, records: tuple[Record, ...]) -> Picture:
    stages = [record for record in records if isinstance(record, StageRecord)]
    paths = [record for record in records if isinstance(record, TrajectoryRecord)]
    fields = [record for record in records if isinstance(record, FieldRecord)]
    potential, shades, title = None, "", "Map"
    if stages:
        potential = stages[-1].potential
        title = f"Map, and the field after the stage of {stages[-1].precision} bits"
    elif fields and fields[-1].values.shape == start.free.shape:
        potential, shades = fields[-1].values, _quantity(fields[-1])
        title = f"Map, and the field of {label(fields[-1].name)}"
    if paths:
        arrived = sum(path.arrived for path in paths)
        title += f"; {counted(len(paths), 'path')} drawn, {arrived} of them to the goal"
    return map_picture(
        start.free,
        [(int(row), int(column)) for row, column in start.goals],
        potential=potential,
        shades=shades,
        trajectories=[path.points for path in paths if len(path.points)],
        title=title,
    )


def _quantity(field: FieldRecord) -> str:
    return label(field.name) if field.unit in ("", "1") else f"{label(field.name)} ({field.unit})"


Bar = tuple[str, str, int, int]
"""The component or link, what it did, from, to (ps)."""


def _bars(records: tuple[Record, ...]) -> list[Bar]:
    bars: list[Bar] = []
    for record in records:
        if isinstance(record, TaskRecord):
            outcome = "" if record.outcome == ENDED else f" ({record.outcome})"
            bars.append((record.source, f"{label(record.task)}{outcome}", record.time, record.end))
        elif isinstance(record, MessageRecord):
            bars.append((record.source, f"message: {record.name}", record.begin, record.end))
        elif isinstance(record, StageRecord):
            bars.append((record.source, "stages", record.begin, record.time))
    # Only the longest can be seen, and a thousand slivers would make the picture heavy.
    return sorted(bars, key=lambda bar: (bar[2] - bar[3], bar))[:_MOST_BARS]


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
        data = picture_bytes(picture, format)
    return Picture(
        title="When each component and link was busy",
        alt=f"Time line of {', '.join(sources)} over {format_time(last)}; utilisation stands in its table",
        format=format,
        data=data,
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
