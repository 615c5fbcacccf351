"""A run as a waveform (VCD) for GTKWave and Surfer: ``hwsw trace export FILE --vcd OUT``.

Each component and link is a scope. Signals change at the times of the records, in ps, so at clock edges where a clock
makes them.

- A component: ``busy``; ``task``, and of a design with stages ``stage``, ``precision``, ``block``, ``iterations`` (of
  the visit) and ``local_maxima`` (of the stage that ended last).
- A link: ``busy``, the ``message`` on it, the messages ``waiting`` for it.
- ``mission.event``: the last event of a mission. A robot's ``speed`` is a real number. Its ``plan`` is 1 while it waits
  for a plan.

A signal of names (``task``, ``message``, ``event``) is a number. Beside the VCD lie a translate file for each of these
signals, and a save file of GTKWave that applies them and puts the signals in groups.
"""

from __future__ import annotations

import heapq
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import count
from operator import itemgetter
from pathlib import Path
from typing import Any, Literal

from more_itertools import map_reduce
from vcd.writer import VCDWriter

from codesign.ground.activity import WORKS, Span, Value, activities, depth_over_time, spans_by_place, union
from codesign.ground.files import write_atomically, written_atomically
from codesign.ground.gtkwave import NOTHING, Shown, ascii_text, save_file, translation
from codesign.ground.records import Record

Kind = Literal["bit", "number", "name", "real"]

_TIMESCALE = "1 ps"
_REAL_BITS = 64
_MISSION, _LEAST_BITS = "mission", 8
_UNSAFE = re.compile(r"[^0-9A-Za-z_]")
Change = tuple[int, Any]


@dataclass
class Signal:
    """One signal: its changes (time in ps, new value), in any order. Of the changes at one time the last one counts."""

    kind: Kind
    changes: list[Change] = field(default_factory=list)
    names: dict[str, int] = field(default_factory=lambda: defaultdict(count(1).__next__, {NOTHING: 0}))

    def put(self, time: int, value: Any) -> None:
        """The signal has this value from ``time`` (ps) on. A name becomes its number."""
        if self.kind == "name":
            value = self.names[value]
        self.changes.append((time, value))

    @property
    def bits(self) -> int:
        """Its width."""
        if self.kind == "bit":
            return 1
        if self.kind == "real":
            return _REAL_BITS
        largest = max((value for _, value in self.changes), default=0)
        if self.kind == "name":
            largest = max(largest, len(self.names) - 1)
        return max(_LEAST_BITS, int(largest).bit_length())

    def settled(self) -> Iterator[Change]:
        """The changes in the order of time, those that change nothing left out."""
        last: Any = None
        ordered = sorted(enumerate(self.changes), key=lambda item: (item[1][0], item[0]))
        for place, (_, (time, value)) in enumerate(ordered):
            overtaken = place + 1 < len(ordered) and ordered[place + 1][1][0] == time
            if not overtaken and value != last:
                last = value
                yield time, value


class Waveform:
    """The signals of a run by scope and name."""

    def __init__(self) -> None:
        self.signals: dict[tuple[str, str], Signal] = {}

    def signal(self, scope: str, name: str, kind: Kind) -> Signal:
        """The signal of a scope, made where it is not there."""
        if (scope, name) not in self.signals:
            self.signals[scope, name] = Signal(kind)
        return self.signals[scope, name]

    @property
    def every(self) -> list[tuple[str, str, Signal]]:
        """Scope, name and signal of each, sorted."""
        return [(*names, signal) for names, signal in sorted(self.signals.items(), key=itemgetter(0))]


def waveform_of(records: Iterable[Record], begin: int = 0, end: int | None = None) -> Waveform:
    """The signals of a run, of records that have a part between ``begin`` and ``end`` (ps; None: the end)."""
    wave = Waveform()
    spans: list[Span] = []

    def watched() -> Iterator[Record]:
        for record in records:
            if _within(*record.between(), begin, end):
                for name, changes in record.signals().items():
                    wave.signal(record.source, name, "number").changes += changes
            yield record

    for activity in activities(watched()):
        if isinstance(activity, Span):
            if _within(*activity.times, begin, end):
                spans.append(activity)
                _put_span(wave, activity)
        elif not _within(activity.time, activity.time, begin, end):
            continue
        elif isinstance(activity, Value):
            scope, _, name = activity.track.partition(": ")
            wave.signal(scope, name, "real").put(activity.time, activity.value)
        elif not activity.track:
            wave.signal(_MISSION, "event", "name").put(activity.time, activity.name)
    for where, work in spans_by_place(spans, *WORKS).items():
        busy = union(span.times for span in work).tolist()
        wave.signal(where, "busy", "bit").changes += [
            (0, 0), *((time, 1 - place) for times in busy for place, time in enumerate(times))
        ]  # fmt: skip
    for link, waiting in spans_by_place(spans, "wait").items():
        depths = zip(*(each.tolist() for each in depth_over_time(waiting)), strict=True)
        wave.signal(link, "waiting", "number").changes += [(0, 0), *depths]
    return wave


def _within(begin: int, end: int, first: int, last: int | None) -> bool:
    return end >= first and (last is None or begin <= last)


def _put_span(wave: Waveform, span: Span) -> None:
    if span.kind in ("task", "message"):
        # One signal for each direction: both may carry a message at a time.
        name = "task" if span.kind == "task" else f"message_to_{span.receiver}"
        _hold(wave.signal(span.where, name, "name"), span, span.name, NOTHING)
    elif span.kind == "stage":
        _hold(wave.signal(span.where, "stage", "name"), span, span.name, NOTHING)
        _hold(wave.signal(span.where, "precision", "number"), span, span.details["precision"], 0)
        wave.signal(span.where, "local_maxima", "number").put(span.end, span.details["local_maxima"])
    elif span.kind == "plan":
        _hold(wave.signal(span.where, "plan", "bit"), span, 1, 0)


def _hold(signal: Signal, span: Span, value: Any, after: Any) -> None:
    """The value from the begin to the end of a span, unless another one has begun by then."""
    if not signal.changes:
        signal.put(0, after)
    signal.put(span.begin, value)
    signal.put(span.end, after)


def write_waveform(wave: Waveform, path: Path, comment: str = "") -> list[Path]:
    """Write the VCD, the save file of GTKWave (``.gtkw``) and the translate files; returns all of them.

    Raises:
        RunError: a file cannot be written.
    """
    # The date of an export would make each file of one run another one.
    with (
        written_atomically(path) as passing,
        passing.open("w", encoding="ascii") as file,
        VCDWriter(file, timescale=_TIMESCALE, date="", comment=ascii_text(comment)) as writer,
    ):
        variables = [
            (signal, writer.register_var(_safe(scope), _safe(name), *_type_of(signal)))
            for scope, name, signal in wave.every
        ]
        for time, value, variable in _in_time(variables):
            writer.change(variable, time, value)
    files = {_translate_path(path, scope, name): signal for scope, name, signal in _named(wave)}
    for file_path, signal in files.items():
        names = ((number, name) for name, number in signal.names.items())
        write_atomically(file_path, translation(names, signal.bits).encode())
    save = path.with_suffix(".gtkw")
    write_atomically(save, save_file(path, _groups(wave, path)).encode())
    return [path, save, *files]


def _named(wave: Waveform) -> list[tuple[str, str, Signal]]:
    return [each for each in wave.every if each[2].kind == "name"]


def _type_of(signal: Signal) -> tuple[Any, ...]:
    if signal.kind == "real":
        return "real", _REAL_BITS, 0.0
    return "wire", signal.bits, 0


def _in_time(variables: list[tuple[Signal, Any]]) -> Iterator[tuple[int, Any, Any]]:
    """The changes of all signals by time."""

    def of(number: int, signal: Signal, variable: Any) -> Iterator[tuple[int, int, Any, Any]]:
        for time, value in signal.settled():
            yield time, number, value, variable

    streams = (of(number, *pair) for number, pair in enumerate(variables))
    for time, _, value, variable in heapq.merge(*streams, key=lambda change: change[:2]):
        yield time, value, variable


def _groups(wave: Waveform, path: Path) -> dict[str, list[Shown]]:
    """A group for each scope."""

    def shown(scope: str, name: str, signal: Signal) -> Shown:
        file = _translate_path(path, scope, name).name if signal.kind == "name" else ""
        full = f"{_safe(scope)}.{_safe(name)}"
        return Shown(full, signal.bits, "real" if signal.kind == "real" else "dec", file)

    return map_reduce(wave.every, lambda each: _safe(each[0]), lambda each: shown(*each))


def _translate_path(path: Path, scope: str, name: str) -> Path:
    return path.with_suffix(f".{_safe(scope)}.{_safe(name)}.txt")


def _safe(name: str) -> str:
    """A name that every reader of VCD takes: letters, digits and underscores."""
    return _UNSAFE.sub("_", name) or "_"
