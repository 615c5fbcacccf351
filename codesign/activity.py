"""What components and links do over time: the spans, marks and values of records, in one form for all exports.

A span has a *track*: the component or link, and the kind of its work (``stages``, ``visits``, ``plans``), or the
direction of its messages. Spans of one track may overlap, as several cores do; ``Lanes`` puts them side by side.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from codesign.records import (
    ENDED,
    FieldRecord,
    MessageRecord,
    MissionRecord,
    PoseRecord,
    Record,
    StageRecord,
    TaskRecord,
    VisitsRecord,
)

Detail = int | float | str
Kind = Literal["task", "stage", "visits", "message", "wait", "plan"]

ACTIVITY_KINDS: tuple[type[Record], ...] = (
    TaskRecord,
    MessageRecord,
    StageRecord,
    VisitsRecord,
    FieldRecord,
    MissionRecord,
    PoseRecord,
)
"""The records that say what is done when."""


@dataclass(frozen=True)
class Span:
    """Something that took from ``begin`` to ``end`` (ps).

    - ``where``: the component or link. ``track``: the row that it is drawn in.
    - ``sender``, ``receiver``: of a message, the components that it is between.
    """

    kind: Kind
    where: str
    track: str
    name: str
    begin: int
    end: int
    details: Mapping[str, Detail] = field(default_factory=dict)
    sender: str = ""
    receiver: str = ""


@dataclass(frozen=True)
class Mark:
    """Something that happened at ``time`` (ps). ``track``: its row; "": over all rows."""

    time: int
    track: str
    name: str
    details: Mapping[str, Detail] = field(default_factory=dict)


@dataclass(frozen=True)
class Value:
    """A quantity that is ``value`` from ``time`` (ps) on. ``track``: its name."""

    time: int
    track: str
    value: float
    unit: str


Activity = Span | Mark | Value


def activities(records: Iterable[Record]) -> Iterator[Activity]:
    """What the records say is done when, in the order of the records: each when it had ended.

    A plan of a mission is a span from its request to its answer, and ends with the mission at the latest.
    """
    requested: dict[str, int] = {}
    for record in records:
        if isinstance(record, MissionRecord):
            yield from _mission(record, requested)
        else:
            yield from _of(record)


def _of(record: Record) -> Iterator[Activity]:
    if isinstance(record, TaskRecord):
        name = record.task if record.outcome == ENDED else f"{record.task} ({record.outcome})"
        where = record.source
        yield Span("task", where, where, name, record.time, record.end, {"cycles": record.cycles})
    elif isinstance(record, StageRecord):
        counts = {
            "precision": record.precision,
            "sweeps": record.sweeps,
            "iterations": record.iterations,
            "cycles": record.cycles,
            "local_maxima": record.local_maxima,
        }
        track, name = f"{record.source}: stages", f"stage {record.stage}"
        yield Span("stage", record.source, track, name, record.begin, record.time, counts)
    elif isinstance(record, VisitsRecord):
        counts = {
            "precision": record.precision,
            "visits": len(record.block),
            "iterations": int(record.iterations.sum(dtype=np.int64)),
        }
        track, name = f"{record.source}: visits", f"stage {record.stage}"
        yield Span("visits", record.source, track, name, record.time, record.end, counts)
    elif isinstance(record, MessageRecord):
        yield from _message(record)
    elif isinstance(record, FieldRecord):
        yield Mark(record.time, record.source, f"field {record.name}")
    elif isinstance(record, PoseRecord):
        yield Value(record.time, f"{record.source}: speed", record.speed, "m/s")


def _message(record: MessageRecord) -> Iterator[Activity]:
    details: dict[str, Detail] = {
        "from": record.sender,
        "to": record.receiver,
        "bits": record.bits,
        "outcome": record.outcome,
        "attempts": record.attempts,
    }
    if record.reason is not None:
        details["reason"] = record.reason
    name = record.name if record.outcome == "delivered" else f"{record.name} ({record.outcome})"
    link, ends = record.source, (record.sender, record.receiver)
    if record.begin > record.time:
        yield Span("wait", link, f"{link}: waiting", record.name, record.time, record.begin, {}, *ends)
    track = f"{link}: {record.sender} to {record.receiver}"
    yield Span("message", link, track, name, record.begin, record.end, details, *ends)


def _mission(record: MissionRecord, requested: dict[str, int]) -> Iterator[Activity]:
    name = record.event.replace("_", " ")
    yield Mark(record.time, "", name, {"source": record.source, "text": record.text})
    if record.event == "plan_requested":
        requested.setdefault(record.source, record.time)
    elif record.event in ("plan_ready", "no_way", "ended"):
        begin = requested.pop(record.source, None)
        if begin is not None:
            where = record.source
            yield Span("plan", where, f"{where}: plans", "plan", begin, record.time, {"answer": name})


class Lanes:
    """Spans of one track side by side, where they overlap: the first lane is the track, the next are beside it."""

    def __init__(self) -> None:
        self._taken: dict[str, list[int]] = {}

    def lane(self, span: Span) -> str:
        """The name of the first lane that is free at its begin. It is then taken until its end."""
        lanes = self._taken.setdefault(span.track, [])
        place = next((place for place, taken in enumerate(lanes) if taken <= span.begin), len(lanes))
        if place == len(lanes):
            lanes.append(0)
        lanes[place] = span.end
        return span.track if place == 0 else f"{span.track} ({place + 1})"


def depth_over_time(spans: Iterable[Span]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """How many spans hold at a time: the times (ps, int64, rising) at which it changes, and the number from then on.

    >>> times, depth = depth_over_time([Span("wait", "pci", "", "", 0, 9), Span("wait", "pci", "", "", 4, 9)])
    >>> times.tolist(), depth.tolist()
    ([0, 4, 9], [1, 2, 0])
    """
    ends = np.array([(span.begin, span.end) for span in spans if span.end > span.begin], np.int64)
    if not len(ends):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    times, place = np.unique(ends.ravel(), return_inverse=True)
    steps = np.zeros(len(times), np.int64)
    np.add.at(steps, place.reshape(-1, 2)[:, 0], 1)
    np.add.at(steps, place.reshape(-1, 2)[:, 1], -1)
    depth = np.cumsum(steps)
    changed = np.diff(depth, prepend=0) != 0
    return times[changed], depth[changed]


def union(spans: Iterable[tuple[int, int]]) -> NDArray[np.int64]:
    """The time that any of the spans covers, as spans that do not touch: int64, n × 2, ps.

    >>> union([(5, 9), (0, 2), (1, 4), (4, 4)]).tolist()
    [[0, 4], [5, 9]]
    """
    ends = np.array(sorted(span for span in spans if span[1] > span[0]), np.int64).reshape(-1, 2)
    if not len(ends):
        return ends
    reach = np.maximum.accumulate(ends[:, 1])
    begins = np.flatnonzero(np.concatenate([[True], ends[1:, 0] > reach[:-1]]))
    return np.column_stack([ends[begins, 0], reach[np.append(begins[1:], len(ends)) - 1]])


def share_over_time(covered: NDArray[np.int64], begin: int, end: int, bins: int) -> NDArray[np.float64]:
    """The share of each of ``bins`` equal parts of the time from ``begin`` to ``end`` (ps) that ``covered`` covers.

    ``covered``: see ``union``. Returns float64, one a part.
    """
    edges = begin + (end - begin) * np.arange(bins + 1) / bins
    # F(t): the time covered before t. It rises only inside spans.
    times = np.concatenate([[begin], covered.ravel(), [end]]).astype(np.float64)
    lengths = covered[:, 1] - covered[:, 0]
    total = np.concatenate([[0], np.cumsum(lengths)])
    filled = np.concatenate([[0], np.column_stack([total[:-1], total[1:]]).ravel(), [total[-1]]])
    return np.diff(np.interp(edges, times, filled.astype(np.float64))) / max(1.0, (end - begin) / bins)
