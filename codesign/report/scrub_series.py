"""Quantities of a run over time, in equal spans of it: speeds, busy shares, messages in queues, robots that arrived."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.activity import Span, activities, depth_over_time, share_over_time, union
from codesign.records import MessageRecord, Record, TaskRecord, VisitsRecord

BINS = 480
_WORK = (TaskRecord, VisitsRecord, MessageRecord)
_MOST_LINES = 4


@dataclass(frozen=True)
class Track:
    """The places of a robot: ``times`` (ps, int64, rising), ``rows``, ``columns`` (cells).

    ``arrived``: when it came to stand at its target, ps; None where it did not, and of a robot that drives on.
    ``headings`` (radians, from growing columns to growing rows) and ``speeds`` (m/s) are None in a fleet, which reports
    places alone. ``radius``: of its body, cells; 0: not known.
    """

    name: str
    times: NDArray[np.int64]
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    headings: NDArray[np.float64] | None = None
    speeds: NDArray[np.float64] | None = None
    radius: float = 0.0
    arrived: int | None = None


@dataclass(frozen=True)
class Series:
    """A quantity in ``BINS`` equal spans of the run, in ``unit``. ``counted``: measure, count or share."""

    name: str
    unit: str
    counted: str
    values: NDArray[np.float64]


def series_of(records: Sequence[Record], end: int, tracks: Sequence[Track]) -> list[Series]:
    """The series that the records allow."""
    spans = [
        each
        for each in activities(record for record in records if isinstance(record, _WORK))
        if isinstance(each, Span)
    ]
    return [*_speeds(tracks, end), *_busy(spans, end), *_queues(spans, end)]


def _speeds(tracks: Sequence[Track], end: int) -> list[Series]:
    """The speed of each robot; of many robots, and of a fleet, the share of them that move."""
    middles = (np.arange(BINS) + 0.5) * end / BINS
    if tracks and all(track.speeds is not None for track in tracks) and len(tracks) <= _MOST_LINES:
        names = [f"speed of {track.name}" if len(tracks) > 1 else "speed" for track in tracks]
        return [
            Series(name, "m/s", "measure", np.interp(middles, track.times, track.speeds))
            for name, track in zip(names, tracks, strict=True)
            if track.speeds is not None
        ]
    if not tracks:
        return []
    moving = np.zeros(BINS)
    for track in tracks:
        moves = np.append(np.hypot(np.diff(track.rows), np.diff(track.columns)) > 0, [False])
        moving += moves[np.clip(np.searchsorted(track.times, middles, "right") - 1, 0, len(moves) - 1)]
    return [Series("robots that move", "1", "count", moving)]


def _busy(spans: Sequence[Span], end: int) -> list[Series]:
    """The busy shares of the busiest components; components of a fleet, one for each robot, count together."""
    by_name: dict[str, list[tuple[int, int]]] = {}
    for span in spans:
        if span.kind in {"task", "visits"}:
            # The boards of a fleet have the names COMPONENT and COMPONENT.ROBOT.
            by_name.setdefault(span.where.partition(".")[0], []).append((span.begin, span.end))
    shares = {name: share_over_time(union(each), 0, end, BINS) for name, each in by_name.items()}
    busiest = sorted(shares, key=lambda name: -float(shares[name].mean()))[:_MOST_LINES]
    return [Series(f"{name} busy", "1", "share", np.clip(shares[name], 0.0, 1.0)) for name in busiest]


def _queues(spans: Sequence[Span], end: int) -> list[Series]:
    """The most messages at a time at each link, waiting or on the wire; the longest queues first."""
    links: dict[str, list[Span]] = {}
    for span in spans:
        if span.kind in {"message", "wait"}:
            links.setdefault(span.where, []).append(span)
    depths = {name: _most_over_time(*depth_over_time(each), end) for name, each in links.items()}
    longest = sorted(depths, key=lambda name: -float(depths[name].sum()))[:_MOST_LINES]
    return [Series(f"messages at {name}", "1", "count", depths[name]) for name in longest]


def _most_over_time(times: NDArray[np.int64], depth: NDArray[np.int64], end: int) -> NDArray[np.float64]:
    """The greatest depth in each span of the run."""
    most = np.zeros(BINS)
    if len(times):
        places = np.clip(times * BINS // end, 0, BINS - 1)
        np.maximum.at(most, places, depth)
        # What is there at the begin of a span counts, too.
        begins = np.searchsorted(times, np.arange(BINS) * end // BINS, "right") - 1
        at_begin = np.where(begins >= 0, depth[np.maximum(begins, 0)], 0)
        most = np.maximum(most, at_begin)
    return most
