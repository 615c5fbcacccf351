"""Clock domains: edges at exact picoseconds from absolute cycle counts, so that no clock ever drifts."""

from __future__ import annotations

from dataclasses import dataclass

from codesign.errors import InputError
from codesign.units import cycles_by, edge

FASTEST = 10**12
"""Hz: above it two edges would fall on one picosecond."""


@dataclass(frozen=True)
class ClockDomain:
    """A clock of ``hz`` hertz whose edge 0 is at time 0.

    Edge n lies at ceil(n × 10¹² / hz) ps. Every edge is rounded on its own, never added up from periods:
    after any number of cycles the clock is less than one picosecond late.

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
        """The last edge at or before ``time`` (ps): how many whole cycles have passed since time 0."""
        return cycles_by(time, self.hz)

    def cycle_at_or_after(self, time: int) -> int:
        """The first edge at or after ``time`` (ps)."""
        return cycles_by(time - 1, self.hz) + 1 if time > 0 else 0

    def next_edge(self, time: int) -> int:
        """The time of the first edge at or after ``time``, ps: where work asked for at ``time`` can begin."""
        return self.edge(self.cycle_at_or_after(time))

    def duration(self, cycles: int, first: int = 0) -> int:
        """Picoseconds from edge ``first`` to the edge ``cycles`` later.

        It varies by 1 ps with ``first`` where the period is not a whole number of picoseconds.
        """
        return self.edge(first + cycles) - self.edge(first)
