"""The cost of an external memory: cycles of one access, cycles of a run of words, and the share of refreshing.

The papers give no figure for one. Vacariu et al. (2008), section 3.1.1, name "an external dynamic RAM" and section 4
says that "the working frequency will obviously be smaller". So all laws here are assumed. The platform
declares their numbers, each with its own status.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError

REFRESH_DENOMINATOR = 10_000
"""The share of refreshing is kept as a fraction with at most this denominator, so that cycles stay exact."""


@dataclass(frozen=True)
class Traffic:
    """The accesses of units of work to an external memory: int64, one entry a unit.

    ``cycles``: the memory works and the design waits. ``words``: words read and written.
    """

    cycles: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    words: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def part(self, first: int, last: int) -> Traffic:
        """The traffic of the units ``first`` to ``last`` - 1."""
        return Traffic(self.cycles[first:last], self.words[first:last])

    @property
    def total(self) -> Traffic:
        """The traffic of all units as one."""
        return Traffic(self.cycles.sum(keepdims=True), self.words.sum(keepdims=True))


@dataclass(frozen=True)
class ExternalMemoryLaw:
    """One memory on the pins of an FPGA, on the clock of its interface.

    - ``technology``: sram or dram. ``hz``: its clock; a design that uses it runs no faster.
    - ``width``: bits a word. ``capacity``: bits.
    - ``latency_cycles``: from an address to its word in an open row; at least one cycle is counted.
    - ``row_words``, ``row_cycles`` (dram): words of a row, and the cycles that opening another row adds.
    - ``refresh_share`` (dram): the share of time in which it serves no access.
    - ``burst_words``: the longest run of words that follow each other, one a cycle; None: as long as the row.

    Every random access counts as opening a row. That is an upper bound: neighbours in the map may lie in one row.

    Raises:
        InputError: a number out of its range.
    """

    technology: Literal["sram", "dram"]
    hz: int
    width: int
    capacity: int
    latency_cycles: int
    row_words: int | None = None
    row_cycles: int = 0
    refresh_share: float = 0.0
    burst_words: int | None = None
    name: str = "memory"

    def __post_init__(self) -> None:
        for key, least in (
            ("hz", 1),
            ("width", 1),
            ("capacity", 1),
            ("latency_cycles", 0),
            ("row_words", 1),
            ("row_cycles", 0),
            ("burst_words", 1),
        ):
            value = getattr(self, key)
            if value is not None and value < least:
                raise InputError(f"{key} of {value}", f"{self.name}.{key}", f"give at least {least}")
        if not 0 <= self.refresh_share < 1:
            what = f"refreshing takes a share of {self.refresh_share}"
            raise InputError(what, f"{self.name}.refresh_share", "give 0 or more, and less than 1")

    @property
    def words(self) -> int:
        """The number of words that it holds."""
        return self.capacity // self.width

    @property
    def access_cycles(self) -> int:
        """Cycles of one random access without refreshing."""
        return max(1, self.latency_cycles) + self.row_cycles

    def run_cycles(self, words: int) -> int:
        """Cycles of ``words`` words in order without refreshing: the latency once a burst, a row miss once a row.

        The run is assumed to begin at the start of a row.
        """
        if words < 1:
            return 0
        row = self.row_words or words
        burst = min(self.burst_words or row, row)
        rows, rest = divmod(words, row)
        bursts = rows * -(-row // burst) + -(-rest // burst)
        return bursts * (max(1, self.latency_cycles) - 1) + words + -(-words // row) * self.row_cycles

    def random_cycles(self, accesses: int) -> int:
        """Cycles of ``accesses`` accesses to words anywhere, one after the other, with the share of refreshing."""
        return self.refreshed(accesses * self.access_cycles)

    def sequential_cycles(self, words: int) -> int:
        """Cycles of ``words`` words in order, with the share of refreshing."""
        return self.refreshed(self.run_cycles(words))

    def refreshed(self, cycles: int) -> int:
        """The duration of ``cycles`` of service with refreshing, in cycles: ceil(cycles / (1 - share))."""
        served = 1 - self._refresh
        return -(-cycles * served.denominator // served.numerator)

    def refreshed_units(self, cycles: NDArray[np.int64]) -> NDArray[np.int64]:
        """``refreshed`` of a sequence of units, int64: each unit with the refreshing that falls into it.

        The rounding is over the whole sequence, so the sum is ``refreshed`` of the sum.
        """
        served = 1 - self._refresh
        ends = np.cumsum(cycles, dtype=np.int64)
        ends = -(-ends * served.denominator // served.numerator)
        return np.diff(ends, prepend=np.int64(0))

    @property
    def _refresh(self) -> Fraction:
        return Fraction(self.refresh_share).limit_denominator(REFRESH_DENOMINATOR)
