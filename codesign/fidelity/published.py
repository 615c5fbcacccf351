"""Reports of power that were published for designs of others, and that the power of a part is held against."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PowerReport:
    """A report of a vendor's tool. ``dynamic``: W of the fabric; ``static``: W; ``clock`` in Hz.

    ``counted_a_slice``: the slices of two LUT that laws count in one of the part.
    """

    source: str
    part: str
    slices: int
    clock: int
    dynamic: float
    static: float
    counted_a_slice: int = 2


POWER = (
    PowerReport("Mucha, Scechura 2023, the smaller array", "XC7Z020-1", 7_847, 100_000_000, 0.070, 0.136),
    PowerReport("Mucha, Scechura 2023, the larger array", "XC7Z020-1", 9_709, 100_000_000, 0.084, 0.136),
)
"""Vivado's reports of an A* array. The power of a slice of this part comes from the same two."""
