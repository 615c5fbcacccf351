"""The base of all components: a clock domain, a name, listeners, and the account of busy time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import simpy

from codesign.ground.errors import InputError, RunError
from codesign.ground.records import Listener, Record, SampleRecord, UtilisationRecord, recorded_by, unwanted_by
from codesign.ground.units import cycles_by, edge

# Samples of quantities that change often: queues, FIFOs, busy shares. Few of them, whatever the length of the run.

SHORTEST = 10**6
"""Picoseconds between two samples of a quantity: at least 1 us, and a 64th of the time up to now.

So each tenfold of the time has at most about 150 samples of a quantity.
"""


class Samples:
    """Makes the samples of one component, and hands them to ``emit``.

    A queue or a FIFO is sampled by its greatest value since the last sample, so no peak is lost.
    A value that stays is not repeated.
    """

    def __init__(self, source: str, emit: Callable[[SampleRecord], None]) -> None:
        self._source = source
        self._emit = emit
        self._levels: dict[str, _Level] = {}
        self._busy = _Level("1")
        self._busy.last = 0

    def level(self, now: int, quantity: str, unit: str, value: float) -> None:
        """A level that has changed to ``value``."""
        level = self._levels.get(quantity)
        if level is None:
            level = self._levels[quantity] = _Level(unit)
        level.value = value
        level.peak = max(level.peak, value)
        if now >= level.earliest and level.due(now):
            self._peak(now, quantity, level)

    def busy(self, now: int, busy: int) -> None:
        """``busy``: picoseconds of work up to now."""
        share = self._busy
        if now >= share.earliest and now > share.last and (share.earliest == 0 or share.due(now)):
            self._share(now, busy)

    def finish(self, now: int, busy: int) -> None:
        """The last samples of the run."""
        for quantity, level in self._levels.items():
            self._peak(now, quantity, level)
        if now > self._busy.last:
            self._share(now, busy)

    def _share(self, now: int, busy: int) -> None:
        share = self._busy
        value = (busy - share.value) / (now - share.last)
        self._emit(SampleRecord(now, self._source, "busy", "1", value))
        share.value = busy
        share.sampled(now)

    def _peak(self, now: int, quantity: str, level: _Level) -> None:
        if level.shown != level.peak:
            self._emit(SampleRecord(now, self._source, quantity, level.unit, float(level.peak)))
        level.shown, level.peak = level.peak, level.value
        level.sampled(now)


class _Level:
    """The last sample of a quantity, and what has come since.

    ``value``: the last one; ``peak``: the greatest since ``last``, the time of the last sample (ps). ``earliest``: no
    sample is due before, so that most calls need one comparison.
    """

    __slots__ = ("earliest", "last", "peak", "shown", "unit", "value")

    def __init__(self, unit: str) -> None:
        self.unit = unit
        self.last = -SHORTEST
        self.earliest = 0
        self.value: float = 0
        self.peak: float = 0
        self.shown: float | None = None

    def due(self, now: int) -> bool:
        """True if the last sample is old enough."""
        return now - self.last >= max(SHORTEST, now // 64)

    def sampled(self, now: int) -> None:
        """A sample was made."""
        self.last = now
        self.earliest = max(now + SHORTEST, (now - 1) * 64 // 63)


Environment = simpy.Environment

FASTEST = 10**12
"""Hz: above it two edges would fall on one picosecond."""


@dataclass(frozen=True)
class ClockDomain:
    """A clock of ``hz`` hertz with edge 0 at time 0.

    Edge n lies at ceil(n × 10¹² / hz) ps. Each edge is rounded by itself and never summed from periods, so the clock
    does not drift: after any number of cycles it is less than one picosecond late.

    >>> clock = ClockDomain(150_000_000)
    >>> clock.edge(1), clock.edge(3), clock.edge(150_000_000)
    (6667, 20000, 1000000000000)

    Raises:
        InputError: ``hz`` is not a whole number from 1 to 10¹².
    """

    hz: int

    def __post_init__(self) -> None:
        if isinstance(self.hz, bool) or not isinstance(self.hz, int) or not 1 <= self.hz <= FASTEST:
            raise InputError(
                f"a clock of {self.hz!r} Hz", "clock", "give a whole number of hertz from 1 to 10^12 (1 THz)"
            )

    def edge(self, cycle: int) -> int:
        """The time of edge ``cycle``, ps."""
        return edge(cycle, self.hz)

    def cycles_by(self, time: int) -> int:
        """The last edge at or before ``time`` (ps), which is the number of whole cycles since time 0."""
        return cycles_by(time, self.hz)

    def cycle_at_or_after(self, time: int) -> int:
        """The first edge at or after ``time`` (ps)."""
        return cycles_by(time - 1, self.hz) + 1 if time > 0 else 0

    def next_edge(self, time: int) -> int:
        """The time of the first edge at or after ``time``, ps: work that is requested at ``time`` begins there."""
        return self.edge(self.cycle_at_or_after(time))

    def duration(self, cycles: int, first: int = 0) -> int:
        """Picoseconds from edge ``first`` to the edge ``cycles`` later.

        It varies by 1 ps with ``first`` where the period is not a whole number of picoseconds.
        """
        return self.edge(first + cycles) - self.edge(first)


class Component:
    """A part of a platform that does work or holds data.

    ``name`` is the source of its records. ``listeners`` take the records. Without a listener no record is built:
    subclasses ask ``wants`` first. ``environment`` starts at time 0, and all its times are whole picoseconds.
    """

    def __init__(self, environment: simpy.Environment, name: str, listeners: Sequence[Listener] = ()) -> None:
        self.environment = environment
        self.name = name
        self._listeners = tuple(listeners)
        self._unwanted = unwanted_by(self._listeners)
        self._samples = Samples(name, self.emit) if recorded_by(self._listeners, SampleRecord) else None
        self._busy = 0
        self._busy_since = 0
        self._in_progress = 0

    @property
    def now(self) -> int:
        """The simulated time, ps."""
        return int(self.environment.now)

    @property
    def listening(self) -> bool:
        """True if there is a listener. Without one no record is built."""
        return bool(self._listeners)

    def wants(self, kind: type[Record]) -> bool:
        """True if a listener wants records of this class. Others are not built."""
        return bool(self._listeners) and kind not in self._unwanted

    def emit(self, record: Record) -> None:
        """Hand ``record`` to every listener, in the order in which they were given."""
        for listener in self._listeners:
            listener(record)

    @property
    def busy(self) -> int:
        """Picoseconds in which at least one piece of work was in progress; at most ``now``."""
        return self._busy + (self.now - self._busy_since if self._in_progress else 0)

    def utilisation(self) -> UtilisationRecord:
        """The busy time of the component from time 0 to now."""
        return UtilisationRecord(time=self.now, source=self.name, busy=self.busy, span=self.now)

    def report_end(self) -> None:
        """Emit the tasks in progress as unfinished, then ``utilisation()``. Called once, at the end of a run."""
        if self.listening:
            self._report_unfinished()
            if self._samples is not None:
                self._samples.finish(self.now, self.busy)
                self._samples = None
            self.emit(self.utilisation())

    def _report_unfinished(self) -> None:
        """Emit a record of each task in progress. Most components have none."""

    @contextmanager
    def _working(self, *, alone: bool = True) -> Iterator[None]:
        """Book the simulated time of the block as busy. Time that several blocks share is booked once.

        Raises:
            RunError: with ``alone``, the component is working already.
        """
        if alone and self._in_progress:
            what = f"{self.name} was given work while it was working"
            hint = "wait for the end of the first task, or map the second to another component"
            raise RunError(what, self.name, hint)
        self._begin_work()
        try:
            yield
        finally:
            self._end_work()

    def _begin_work(self) -> None:
        if not self._in_progress:
            self._busy_since = self.now
        self._in_progress += 1

    def _end_work(self) -> None:
        self._in_progress -= 1
        if not self._in_progress:
            self._busy += self.now - self._busy_since
            if self._samples is not None:
                self._samples.busy(self.now, self._busy)
