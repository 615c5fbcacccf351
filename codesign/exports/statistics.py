"""How busy each component and link of a run was, and how long things took: ``hwsw trace stats FILE``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from codesign.activity import Span, activities, union
from codesign.records import CommandRecord, Record
from codesign.report.table import Cell, Column, Table, left, right, word
from codesign.units import PICOSECONDS_PER_SECOND, format_time

_BARS = "▁▂▃▄▅▆▇█"
_HISTOGRAM = 12
"""The parts of a histogram. They are equal in the logarithm, from the shortest to the longest."""

BUSY_KINDS = ("task", "stage", "message")


@dataclass(frozen=True)
class Share:
    """What one component or link did, in ps of the whole run.

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
    """How long things of one kind took: ``times``, int64, ps, rising."""

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


@dataclass
class _Gathered:
    works: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    around: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    waits: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    times: dict[str, list[int]] = field(default_factory=dict)
    links: set[str] = field(default_factory=set)
    end: int = 0


def statistics(records: Iterable[Record]) -> Statistics:
    """How busy components and links were, and how long messages, tasks, stages, plans and commands took."""
    gathered = _Gathered()

    def watched() -> Iterable[Record]:
        for record in records:
            gathered.end = max(gathered.end, record.time)
            if isinstance(record, CommandRecord):
                what = f"{record.source}: from the scan to the command"
                gathered.times.setdefault(what, []).append(record.time - record.seen)
            yield record

    for activity in activities(watched()):
        if isinstance(activity, Span):
            _take(gathered, activity)
    shares = [_share(gathered, where) for where in sorted(gathered.works)]
    shares.sort(key=lambda share: share.is_link)
    latencies = (
        Latency(what, np.sort(np.array(times, np.int64))) for what, times in sorted(gathered.times.items())
    )
    return Statistics(gathered.end, tuple(shares), tuple(latencies))


def _take(gathered: _Gathered, span: Span) -> None:
    gathered.end = max(gathered.end, span.end)
    if span.kind in BUSY_KINDS:
        gathered.works.setdefault(span.where, []).append((span.begin, span.end))
    if span.kind in ("message", "wait"):
        gathered.links.add(span.where)
        for component in (span.sender, span.receiver):
            gathered.around.setdefault(component, []).append((span.begin, span.end))
    if span.kind == "wait":
        gathered.waits.setdefault(span.where, []).append((span.begin, span.end))
    what = {
        "task": f"{span.where}: task {span.name}",
        "message": f"{span.where}: message {span.name}",
        "wait": f"{span.where}: waiting for the link",
        "stage": f"{span.where}: stage",
        "plan": f"{span.where}: from the request to the plan",
    }.get(span.kind)
    if what is not None:
        gathered.times.setdefault(what, []).append(span.end - span.begin)


def _share(gathered: _Gathered, where: str) -> Share:
    works = gathered.works[where]
    busy = _length(works)
    if where in gathered.links:
        waits = gathered.waits.get(where, [])
        queued = sum(end - begin for begin, end in waits)
        return Share(where, True, busy, 0, gathered.end - busy, queued, _deepest(waits))
    either = _length([*works, *gathered.around.get(where, [])])
    return Share(where, False, busy, either - busy, gathered.end - either)


def _length(spans: Sequence[tuple[int, int]]) -> int:
    return int(np.diff(union(spans), axis=1).sum())


def _deepest(spans: Sequence[tuple[int, int]]) -> int:
    """The most spans at a time; one that ends when another begins is not beside it."""
    steps = sorted([(begin, 1) for begin, _ in spans] + [(end, -1) for _, end in spans])
    return int(np.cumsum([step for _, step in steps]).max()) if steps else 0


def shares_table(found: Statistics) -> Table:
    """Busy, waiting and idle of each component, and of each link also its queue."""
    columns = (
        *left("where", "kind"),
        *right("busy", "waiting", "idle", unit="%"),
        Column("waited for the link", "s", "right"),
        Column("most waiting", "", "right"),
    )
    rows = []
    for share in found.shares:
        parts = (share.busy, share.waiting, share.idle)
        queued = (
            (
                Cell(format_time(share.queued), share.queued / PICOSECONDS_PER_SECOND),
                Cell(str(share.deepest), share.deepest),
            )
            if share.is_link
            else (Cell("–"), Cell("–"))
        )
        kind = "link" if share.is_link else "component"
        rows.append((word(share.where), word(kind), *(_percent(part, found.end) for part in parts), *queued))
    notes = (
        "A component waits while it does not work, and a message from it or to it is under way or waits for its link.",
    )
    return Table(f"components and links over {format_time(found.end)}", columns, tuple(rows), notes)


def latencies_table(found: Statistics) -> Table:
    """How long things took, each kind with a histogram."""
    columns = (
        *left("what"),
        Column("number", "", "right"),
        *right("least", "half within", "95 % within", "greatest", unit="s"),
        *left("histogram"),
    )
    rows = []
    for latency in found.latencies:
        times = (
            int(latency.times[0]),
            latency.percentile(0.5),
            latency.percentile(0.95),
            int(latency.times[-1]),
        )
        number = len(latency.times)
        rows.append(
            (
                word(latency.what),
                Cell(f"{number:,}", number),
                *(Cell(format_time(time), time / PICOSECONDS_PER_SECOND) for time in times),
                Cell(bars(latency.histogram()[0])),
            )
        )
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
