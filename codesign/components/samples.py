"""Samples of quantities that change often: queues, FIFOs, busy shares. Few of them, whatever the length of the run."""

from __future__ import annotations

from collections.abc import Callable

from codesign.records import SampleRecord

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
        self._last: dict[str, int] = {}
        self._peaks: dict[str, tuple[str, float, float]] = {}
        self._shown: dict[str, float] = {}
        self._busy = 0

    def level(self, now: int, quantity: str, unit: str, value: float) -> None:
        """A level that has changed to ``value``."""
        peak = max(value, self._peaks[quantity][1]) if quantity in self._peaks else value
        self._peaks[quantity] = unit, peak, value
        if self._due(now, quantity):
            self._peak(now, quantity)

    def busy(self, now: int, busy: int) -> None:
        """``busy``: picoseconds of work up to now."""
        span = now - self._last.get("busy", 0)
        if span and self._due(now, "busy"):
            self._emit(SampleRecord(now, self._source, "busy", "1", (busy - self._busy) / span))
            self._busy, self._last["busy"] = busy, now

    def finish(self, now: int, busy: int) -> None:
        """The last samples of the run."""
        for quantity in self._peaks:
            self._peak(now, quantity)
        span = now - self._last.get("busy", 0)
        if span:
            self._emit(SampleRecord(now, self._source, "busy", "1", (busy - self._busy) / span))

    def _peak(self, now: int, quantity: str) -> None:
        unit, peak, value = self._peaks[quantity]
        if self._shown.get(quantity) != peak:
            self._emit(SampleRecord(now, self._source, quantity, unit, float(peak)))
        self._peaks[quantity], self._last[quantity], self._shown[quantity] = (unit, value, value), now, peak

    def _due(self, now: int, quantity: str) -> bool:
        last = self._last.get(quantity)
        return last is None or now - last >= max(SHORTEST, now // 64)
