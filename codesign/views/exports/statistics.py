"""The busy times of the components and links of a run, as a table (``hwsw trace stats``) and a chart (``timeline``)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.activity import (
    WORKS,
    Mark,
    Span,
    activities,
    depth_over_time,
    share_over_time,
    spans_by_place,
    spans_of,
    union,
)
from codesign.ground.errors import printable
from codesign.ground.records import Record
from codesign.ground.units import format_time
from codesign.views.report.wording import ABSENT, Cell, Table, count_cell, left, number_cell, right, time_cell, word

_BARS = "▁▂▃▄▅▆▇█"
_HISTOGRAM = 12
"""The parts of a histogram. They are equal in the logarithm, from the shortest to the longest."""


@dataclass(frozen=True)
class Share:
    """The times of one component or link, in ps of the whole run.

    - ``busy``: it worked, or carried a message. ``waiting``: it did neither, while a message from it or to it was under
      way or waited for its link; of a link, always 0. ``idle``: the rest. The three add up to the run.
    - ``queued``: the sum of the times that messages waited for a link. ``deepest``: the most that waited at a time.
    """

    where: str
    is_link: bool
    busy: int
    waiting: int
    idle: int
    queued: int = 0
    deepest: int = 0


@dataclass(frozen=True, eq=False)
class Latency:
    """The durations of things of one kind: ``times``, int64, ps, rising."""

    what: str
    times: NDArray[np.int64]

    def percentile(self, share: float) -> int:
        """The time that this share of them did not exceed, ps: the nearest rank."""
        return int(self.times[max(0, int(np.ceil(share * len(self.times))) - 1)])

    def histogram(self, bins: int = _HISTOGRAM) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The number in each part, and the ``bins + 1`` ends of the parts in ps, equal steps of the logarithm."""
        low, high = max(1, int(self.times[0])), max(1, int(self.times[-1]))
        ends = np.geomspace(low, high, bins + 1) if high > low else np.linspace(low, high + 1, bins + 1)
        ends[0], ends[-1] = min(ends[0], self.times[0]), max(ends[-1], self.times[-1])
        return np.histogram(self.times, ends)[0], ends


@dataclass(frozen=True)
class Statistics:
    """Of one run: ``end`` is its last time, ps."""

    end: int
    shares: tuple[Share, ...]
    latencies: tuple[Latency, ...]


_TOOK = {
    "task": "task {}",
    "message": "message {}",
    "wait": "waiting for the link",
    "stage": "stage",
    "plan": "from the request to the plan",
}
"""The words for the times of spans, by their kind."""


def statistics(records: Iterable[Record]) -> Statistics:
    """The busy times of components and links, and the durations of messages, tasks, stages, plans and commands."""
    took: list[tuple[str, int]] = []
    end = 0

    def watched() -> Iterable[Record]:
        nonlocal end
        for record in records:
            end = max(end, record.time)
            took.extend((f"{record.source}: {what}", time) for what, time in record.lasted())
            yield record

    spans = spans_of(watched())
    end = max([end, *(span.end for span in spans)])
    took += [
        (f"{span.where}: {_TOOK[span.kind].format(span.name)}", span.end - span.begin)
        for span in spans
        if span.kind in _TOOK
    ]
    times = map_reduce(took, itemgetter(0), itemgetter(1))
    carried = spans_by_place(spans, "message", "wait")
    around = map_reduce(
        ((name, span) for own in carried.values() for span in own for name in (span.sender, span.receiver)),
        itemgetter(0),
        itemgetter(1),
    )
    waits = spans_by_place(spans, "wait")
    shares = [
        _link(where, works, waits.get(where, []), end)
        if where in carried
        else _component(where, works, around.get(where, []), end)
        for where, works in sorted(spans_by_place(spans, *WORKS).items())
    ]
    latencies = (Latency(what, np.sort(np.array(each, np.int64))) for what, each in sorted(times.items()))
    return Statistics(end, tuple(sorted(shares, key=lambda share: share.is_link)), tuple(latencies))


def _link(where: str, works: Sequence[Span], waits: Sequence[Span], end: int) -> Share:
    """A link. A message that stops waiting when another begins is not beside it."""
    busy, queued = _length(works), sum(span.end - span.begin for span in waits)
    return Share(where, True, busy, 0, end - busy, queued, int(depth_over_time(waits)[1].max(initial=0)))


def _component(where: str, works: Sequence[Span], around: Sequence[Span], end: int) -> Share:
    busy, either = _length(works), _length([*works, *around])
    return Share(where, False, busy, either - busy, end - either)


def _length(spans: Iterable[Span]) -> int:
    return int(np.diff(union(span.times for span in spans), axis=1).sum())


def shares_table(found: Statistics) -> Table:
    """Busy, waiting and idle of each component, and of each link also its queue."""
    queue = (*right("waited for the link", unit="s"), *right("most waiting"))
    columns = (*left("where", "kind"), *right("busy", "waiting", "idle", unit="%"), *queue)
    rows = []
    for share in found.shares:
        parts = (share.busy, share.waiting, share.idle)
        queued = (time_cell(share.queued), number_cell(share.deepest)) if share.is_link else (Cell(ABSENT),) * 2
        kind = "link" if share.is_link else "component"
        rows.append((word(share.where), word(kind), *(_percent(part, found.end) for part in parts), *queued))
    notes = (
        "A component waits while it does not work, and a message from it or to it is under way or waits for its link.",
    )
    return Table(f"components and links over {format_time(found.end)}", columns, tuple(rows), notes)


def latencies_table(found: Statistics) -> Table:
    """The durations of things, each kind with a histogram."""
    times = right("least", "half within", "95 % within", "greatest", unit="s")
    columns = (*left("what"), *right("number"), *times, *left("histogram"))
    rows = []
    for latency in found.latencies:
        took = (int(latency.times[0]), latency.percentile(0.5), latency.percentile(0.95), int(latency.times[-1]))
        histogram = Cell(bars(latency.histogram()[0]))
        rows.append((word(latency.what), count_cell(len(latency.times)), *map(time_cell, took), histogram))
    notes = ("A histogram goes from the least to the greatest time in equal steps of the logarithm.",)
    return Table("how long things took", columns, tuple(rows), notes)


def bars(counts: NDArray[np.int64]) -> str:
    """A bar for each count; none for 0.

    >>> bars(np.array([0, 1, 4, 8]))
    ' ▁▄█'
    """
    most = int(counts.max(initial=0))
    return "".join(_BARS[-(-len(_BARS) * count // most) - 1] if count else " " for count in counts.tolist())


def _percent(part: int, whole: int) -> Cell:
    share = 100 * part / whole if whole else 0.0
    return Cell(f"{share:.3g} %", share)


_SHADES = " ░▒▓█"
_MARK = "▾"
_LEAST_WIDTH = 20
_MOST_NAME = 32


@dataclass(frozen=True, eq=False)
class Row:
    """A track: the share of each part of the time in which it was busy, float64; of marks, how many fall into it."""

    name: str
    values: NDArray[np.float64]
    marks: bool = False

    def line(self) -> str:
        """A character for each part: none, up to a quarter, a half, three quarters, more."""
        if self.marks:
            return "".join(_MARK if value else " " for value in self.values)
        steps = np.minimum(np.ceil(self.values * (len(_SHADES) - 1)), len(_SHADES) - 1).astype(np.intp)
        return "".join(_SHADES[step] for step in steps)


@dataclass(frozen=True)
class Gantt:
    """Rows over so many equal parts of the time from ``begin`` to ``end``, ps."""

    begin: int
    end: int
    rows: tuple[Row, ...]
    parts: int

    def lines(self) -> list[str]:
        """The chart as text: a head with times, a line a row, and what the shades mean."""
        names = [printable(row.name, _MOST_NAME) for row in self.rows]
        wide = max(map(len, names), default=0)
        head = f"{'':<{wide}}  {_scale(self.begin, self.end, self.parts)}"
        body = [f"{name:<{wide}}  {row.line()}{_share(row)}" for name, row in zip(names, self.rows, strict=True)]
        part = format_time((self.end - self.begin) // self.parts)
        return [head, *body, f"one character is {part}; busy in it:  ░ up to 25 %  ▒ 50 %  ▓ 75 %  █ more"]


def _columns(terminal: int, names: Iterable[str]) -> int:
    """The number of characters of a terminal that are left for the time."""
    wide = max((min(len(name), _MOST_NAME) for name in names), default=0)
    return max(_LEAST_WIDTH, terminal - wide - len("  ") - len("  100 %"))


def gantt(records: Iterable[Record], terminal: int, begin: int = 0, end: int | None = None) -> Gantt:
    """The rows of all tracks between ``begin`` and ``end`` (ps; None: the end of the run), for so wide a terminal."""
    said = list(activities(records))
    spans = map_reduce((each for each in said if isinstance(each, Span)), lambda each: each.track)
    marks = [each.time for each in said if isinstance(each, Mark) and not each.track]
    last = max([*marks, *(each.end for own in spans.values() for each in own)], default=0)
    until = max(begin + 1, last if end is None else min(end, max(last, begin + 1)))
    names = sorted(spans)
    bins = _columns(terminal, names)
    rows = [Row(name, share_over_time(union(each.times for each in spans[name]), begin, until, bins)) for name in names]
    if marks:
        inside = [time for time in marks if begin <= time <= until]
        counts = np.histogram(inside, bins, (begin, until))[0].astype(np.float64)
        rows.insert(0, Row("events", counts, marks=True))
    return Gantt(begin, until, tuple(rows), bins)


def _scale(begin: int, end: int, width: int) -> str:
    first, last = format_time(begin), format_time(end)
    return f"{first}{'':<{max(1, width - len(first) - len(last))}}{last}"


def _share(row: Row) -> str:
    if row.marks:
        return f"  {int(row.values.sum()):,}"
    share = 100 * float(row.values.mean())
    return f"  {share:.3g} %" if share else ""
