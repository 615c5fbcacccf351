"""Clock edges of many clocks side by side: the arrays of ``units.edge`` and ``units.cycles_by``, exact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.errors import RunError
from codesign.units import PICOSECONDS_PER_SECOND, cycles_by, edge

Times = NDArray[np.int64]
"""Picoseconds or cycles, one entry a machine."""

_MOST = 2**62
_EXACT = 2**50
"""Above it, a float is too coarse to find a cycle by a quotient."""


@dataclass(frozen=True, eq=False)
class Clocks:
    """A clock of each of many machines. ``hz``: int64, 1 to 10¹²; edge 0 of each lies at time 0.

    >>> clocks = Clocks(np.array([150_000_000, 10**9]))
    >>> clocks.edge(np.array([3, 3])).tolist(), clocks.at_or_after(np.array([6668, 6668])).tolist()
    ([20000, 3000], [2, 7])
    """

    hz: Times

    @cached_property
    def _period(self) -> tuple[Times, Times]:
        """Whole picoseconds of a period, and what remains of 10¹² after as many cycles as the clock has a second."""
        whole, rest = np.divmod(np.int64(PICOSECONDS_PER_SECOND), self.hz)
        return whole, rest

    def edge(self, cycle: Times) -> Times:
        """The time of an edge, ps: ceil(cycle · 10¹² / hz) = cycle · whole + ceil(cycle · rest / hz).

        Raises:
            RunError: a time is beyond 2^62 ps.
        """
        whole, rest = self._period
        if (cycle.astype(np.float64) * np.maximum(whole, rest)).max(initial=0.0) > _MOST:
            return self._one_by_one(edge, cycle)
        return np.asarray(cycle * whole - (-cycle * rest) // self.hz, np.int64)

    def at_or_after(self, time: Times) -> Times:
        """The first edge at or after a time, ps. A quotient of floats finds it, exact edges correct it."""
        quotient = np.ceil(time * (self.hz / PICOSECONDS_PER_SECOND))
        if quotient.max(initial=0.0) > _EXACT:
            return self._one_by_one(
                lambda until, hertz: cycles_by(until - 1, hertz) + 1 if until else 0, time
            )
        cycle = quotient.astype(np.int64)
        cycle = cycle - ((cycle > 0) & (self.edge(np.maximum(cycle - 1, 0)) >= time))
        return np.asarray(cycle + (self.edge(cycle) < time), np.int64)

    def _one_by_one(self, of: Callable[[int, int], int], numbers: Times) -> Times:
        """What is beyond 64 bits on its way is computed in whole numbers of any size."""
        found = [of(number, hertz) for number, hertz in zip(numbers.tolist(), self.hz.tolist(), strict=True)]
        if max(found, default=0) > _MOST:
            raise RunError("a time beyond 2^62 ps", hint="make the problem smaller")
        return np.array(found, np.int64)
