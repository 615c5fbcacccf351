"""The acts of components and links over time: the spans, marks and values of records, in one form for all exports.

A span has a *track*: the component or link, and the kind of its work (``stages``, ``visits``, ``plans``), or the
direction of its messages. Spans of one track may overlap, as several cores do; ``Lanes`` puts them side by side.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from typing import Literal, Protocol

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

Detail = int | float | str
Kind = Literal["task", "stage", "visits", "message", "wait", "plan"]
Change = tuple[int, int]

WORKS: tuple[Kind, ...] = ("task", "stage", "message")
"""The work that a component or a link is busy with. Visits are inside stages."""


@dataclass(frozen=True)
class Span:
    """Something that took from ``begin`` to ``end`` (ps).

    - ``where``: the component or link. ``track``: the row that it is drawn in. ``what``: its name.
    - ``sender``, ``receiver``: of a message, the components that it is between.
    - ``outcome``: how it ended; "" where it ended well.
    """

    kind: Kind
    where: str
    track: str
    what: str
    begin: int
    end: int
    details: Mapping[str, Detail] = field(default_factory=dict)
    sender: str = ""
    receiver: str = ""
    outcome: str = ""

    @property
    def tail(self) -> str:
        """The outcome behind a name; "" where it ended well."""
        return f" ({self.outcome})" if self.outcome else ""

    @property
    def name(self) -> str:
        """Its name, with how it ended."""
        return f"{self.what}{self.tail}"

    @property
    def times(self) -> tuple[int, int]:
        """From when to when, ps."""
        return self.begin, self.end


@dataclass(frozen=True)
class Mark:
    """Something that happened at ``time`` (ps). ``track``: its row; "": over all rows.

    ``plan``: ``where`` asked for a plan with it, or got its answer.
    """

    time: int
    track: str
    name: str
    details: Mapping[str, Detail] = field(default_factory=dict)
    where: str = ""
    plan: Literal["asked", "answered", ""] = ""


@dataclass(frozen=True)
class Value:
    """A quantity that is ``value`` from ``time`` (ps) on. ``track``: its name."""

    time: int
    track: str
    value: float
    unit: str


Activity = Span | Mark | Value


class Acting(Protocol):
    """Something that says what is done when: a record."""

    def acts(self) -> Iterable[Activity]:
        """Its spans, marks and values."""


def activities(records: Iterable[Acting]) -> Iterator[Activity]:
    """The acts that the records tell, in the order of the records: each when it had ended.

    A plan of a mission is a span from its request to its answer, and ends with the mission at the latest.
    """
    requested: dict[str, int] = {}
    for record in records:
        for each in record.acts():
            yield each
            if isinstance(each, Mark) and each.plan == "asked":
                requested.setdefault(each.where, each.time)
            elif isinstance(each, Mark) and each.plan == "answered" and each.where in requested:
                begin, track = requested.pop(each.where), f"{each.where}: plans"
                yield Span("plan", each.where, track, "plan", begin, each.time, {"answer": each.name})


def spans_of(records: Iterable[Acting]) -> list[Span]:
    """The spans of the records."""
    return [each for each in activities(records) if isinstance(each, Span)]


def spans_by_place(spans: Iterable[Span], *kinds: Kind) -> dict[str, list[Span]]:
    """The spans of some kinds by the component or link."""
    return map_reduce((span for span in spans if span.kind in kinds), lambda span: span.where)


class Lanes:
    """Spans of one track side by side, where they overlap: the first lane is the track, the next are beside it."""

    def __init__(self) -> None:
        self._taken: dict[tuple[str, int], int] = {}

    def lane(self, span: Span) -> str:
        """The name of the first lane that is free at its begin. It is then taken until its end."""
        place = next(n for n in count() if self._taken.get((span.track, n), span.begin) <= span.begin)
        self._taken[span.track, place] = span.end
        return span.track if place == 0 else f"{span.track} ({place + 1})"


def depth_over_time(spans: Iterable[Span]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The number of spans at a time: the times (ps, int64, rising) at which it changes, and the number from then on.

    >>> times, depth = depth_over_time([Span("wait", "pci", "", "", 0, 9), Span("wait", "pci", "", "", 4, 9)])
    >>> times.tolist(), depth.tolist()
    ([0, 4, 9], [1, 2, 0])
    """
    ends = np.array([(span.begin, span.end) for span in spans if span.end > span.begin], np.int64)
    if not len(ends):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    times, (begins, stops) = np.unique(ends), np.sort(ends, axis=0).T
    depth = np.searchsorted(begins, times, "right") - np.searchsorted(stops, times, "right")
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
