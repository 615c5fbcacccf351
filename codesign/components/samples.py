"""Samples of quantities that change often: queues, FIFOs, busy shares. Few of them, whatever the length of the run."""

from __future__ import annotations

from collections.abc import Callable

from codesign.ground.records import SampleRecord

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
        """Whether the last sample is old enough."""
        return now - self.last >= max(SHORTEST, now // 64)

    def sampled(self, now: int) -> None:
        """A sample was made."""
        self.last = now
        self.earliest = max(now + SHORTEST, (now - 1) * 64 // 63)
