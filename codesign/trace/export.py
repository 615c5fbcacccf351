"""Export a trace for other tools: Chrome's trace events for Perfetto, and a table of the robots' positions.

``hwsw trace export FILE --perfetto OUT`` and ``--poses OUT``. Both are written record by record.
"""

from __future__ import annotations

import csv
import io
import itertools
import json
from collections.abc import Iterable, Iterator
from typing import Any

from codesign.records import (
    ENDED,
    FieldRecord,
    MessageRecord,
    MissionRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    StageRecord,
    TaskRecord,
    VisitsRecord,
)

PERFETTO_KINDS: tuple[type[Record], ...] = (
    TaskRecord,
    MessageRecord,
    StageRecord,
    VisitsRecord,
    FieldRecord,
    MissionRecord,
    PoseRecord,
)
POSE_KINDS: tuple[type[Record], ...] = (PoseRecord, PositionsRecord)

_PROCESS = 1
_MICROSECOND = 10**6


def perfetto(records: Iterable[Record]) -> Iterator[str]:
    """The text of a JSON file of trace events, in pieces: open it at ui.perfetto.dev or chrome://tracing.

    - A track for each component with its work, and one for each direction of each link with its messages. Work that
      overlaps other work of its track has a second track beside it.
    - A track for waiting, for each link: from the request of a message to its begin.
    - Events of missions as marks over all tracks, each replan as a span, and the robot's speed as a counter.

    Times are microseconds with decimals, exact to the picosecond for 2.5 hours.
    """
    tracks = _Tracks()
    yield '{"displayTimeUnit":"ns","traceEvents":[\n'
    body = (event for record in records for event in _events(record, tracks))
    head = {"ph": "M", "pid": _PROCESS, "tid": 0, "name": "process_name", "args": {"name": "platform"}}
    for number, event in enumerate(itertools.chain([head], body, _End(tracks))):
        yield f"{',' if number else ''}{json.dumps(event, ensure_ascii=False, separators=(',', ':'))}\n"
    yield "]}\n"


class _Tracks:
    """Tracks by name: their numbers, and the end of the last span on each (ps)."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}
        self._taken: dict[str, list[int]] = {}
        self.waits = 0
        self.replans: dict[str, int] = {}

    def number(self, name: str) -> int:
        return self.numbers.setdefault(name, len(self.numbers) + 1)

    def lane(self, name: str, begin: int, end: int) -> int:
        """The first track of this name that is free at ``begin``. It is then taken until ``end``."""
        lanes = self._taken.setdefault(name, [])
        place = next((place for place, taken in enumerate(lanes) if taken <= begin), len(lanes))
        if place == len(lanes):
            lanes.append(0)
        lanes[place] = end
        return self.number(name if place == 0 else f"{name} ({place + 1})")


class _End:
    """The names and the order of the tracks, when all are known."""

    def __init__(self, tracks: _Tracks) -> None:
        self._tracks = tracks

    def __iter__(self) -> Iterator[dict[str, Any]]:
        for order, (name, number) in enumerate(sorted(self._tracks.numbers.items())):
            where = {"ph": "M", "pid": _PROCESS, "tid": number}
            yield {**where, "name": "thread_name", "args": {"name": name}}
            yield {**where, "name": "thread_sort_index", "args": {"sort_index": order}}


def _events(record: Record, tracks: _Tracks) -> Iterator[dict[str, Any]]:
    if isinstance(record, TaskRecord):
        name = record.task if record.outcome == ENDED else f"{record.task} ({record.outcome})"
        yield _span(tracks, record.source, name, record.time, record.end, cycles=record.cycles)
    elif isinstance(record, StageRecord):
        counts = {"precision": record.precision, "sweeps": record.sweeps, "local_maxima": record.local_maxima}
        name = f"stage {record.stage}"
        yield _span(tracks, f"{record.source}: stages", name, record.begin, record.time, **counts)
    elif isinstance(record, VisitsRecord):
        yield _span(
            tracks, f"{record.source}: visits", f"stage {record.stage}", record.time, record.end,
            visits=len(record.block), iterations=int(record.iterations.sum()),
        )  # fmt: skip
    elif isinstance(record, MessageRecord):
        yield from _message(record, tracks)
    elif isinstance(record, MissionRecord):
        yield from _mission(record, tracks)
    elif isinstance(record, FieldRecord):
        yield _event("i", record.time, f"field {record.name}", s="t", tid=tracks.number(record.source))
    elif isinstance(record, PoseRecord):
        yield _event("C", record.time, f"{record.source}: speed", args={"m/s": record.speed})


def _message(record: MessageRecord, tracks: _Tracks) -> Iterator[dict[str, Any]]:
    arguments = {
        "from": record.sender,
        "to": record.receiver,
        "bits": record.bits,
        "outcome": record.outcome,
        "attempts": record.attempts,
    }
    if record.reason is not None:
        arguments["reason"] = record.reason
    name = record.name if record.outcome == "delivered" else f"{record.name} ({record.outcome})"
    yield _span(
        tracks,
        f"{record.source}: {record.sender} to {record.receiver}",
        name,
        record.begin,
        record.end,
        **arguments,
    )
    if record.begin > record.time:
        # Messages wait side by side, so each wait is a span with its own id.
        tracks.waits += 1
        where = {
            "id": tracks.waits,
            "cat": f"{record.source}: waiting",
            "tid": tracks.number(f"{record.source}: waiting"),
        }
        yield _event("b", record.time, record.name, **where)
        yield _event("e", record.begin, record.name, **where)


def _mission(record: MissionRecord, tracks: _Tracks) -> Iterator[dict[str, Any]]:
    name = record.event.replace("_", " ")
    yield _event("i", record.time, name, s="g", tid=0, args={"source": record.source, "text": record.text})
    if record.event == "plan_requested":
        tracks.replans.setdefault(record.source, record.time)
    elif record.event in ("plan_ready", "no_way", "ended"):
        begin = tracks.replans.pop(record.source, None)
        if begin is not None:
            yield _span(tracks, f"{record.source}: plans", "plan", begin, record.time, answer=name)


def _span(tracks: _Tracks, track: str, name: str, begin: int, end: int, **args: Any) -> dict[str, Any]:
    number = tracks.lane(track, begin, end)
    return _event("X", begin, name, tid=number, dur=(end - begin) / _MICROSECOND, args=args)


def _event(kind: str, time: int, name: str, **fields: Any) -> dict[str, Any]:
    return {"ph": kind, "pid": _PROCESS, "ts": time / _MICROSECOND, "name": name, **fields}


def poses_csv(records: Iterable[Record]) -> Iterator[str]:
    """A table of positions and times of each robot in CSV, a line at a time.

    Columns: ``time_ps`` (exact), ``source``, ``robot`` (its number in a fleet, 0 alone), ``row`` and ``column`` in
    cells, ``heading`` in radians and ``speed`` in m/s (empty for a fleet).
    """
    yield _line("time_ps", "source", "robot", "row", "column", "heading", "speed")
    for record in records:
        if isinstance(record, PoseRecord):
            yield _line(
                record.time, record.source, 0, record.row, record.column, record.heading, record.speed
            )
        elif isinstance(record, PositionsRecord):
            for robot, (row, column) in enumerate(record.positions.tolist()):
                yield _line(record.time, record.source, robot, row, column, "", "")


_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def _line(*values: Any) -> str:
    out = io.StringIO()
    # A spreadsheet would read some names as formulas.
    safe = (
        f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value for value in values
    )
    csv.writer(out, lineterminator="\n").writerow(safe)
    return out.getvalue()
