"""The figures that Dubey, Pradhan, Krishna and Roy Chowdhury (2013) publish: Tables I to III, and those of the text.

Numbers are as printed. ``resources`` and ``power`` say which figures the laws are fitted to, and which are held out.
"""

from __future__ import annotations

from enum import StrEnum

PAPER = "Dubey et al. 2013"
PART, FAMILY = "XC3S500E", "Spartan-3E"
CLOCK = 50_000_000
"""Hz: the oscillator of the Nexys-2 board (section VI)."""
UPDATES_A_RUN = 500
""""A full run of algorithm requires nearly 500 of such updates"."""


class Style(StrEnum):
    """The three architectures of section III."""

    SEQUENTIAL = "sequential"
    PIPELINED = "pipelined"
    HYBRID = "hybrid"


TABLE_I: dict[Style, tuple[int, int, int]] = {
    Style.SEQUENTIAL: (52, 32, 96),
    Style.PIPELINED: (63, 41, 104),
    Style.HYBRID: (79, 70, 128),
}
"""Two robots: CLBs in % (taken as slices, as the mapper reports them), LUTs in %, power in mW."""

TABLE_II: dict[Style, dict[int, int]] = {
    Style.SEQUENTIAL: {2: 24, 4: 58, 8: 126},
    Style.PIPELINED: {2: 24, 4: 44, 8: 84},
    Style.HYBRID: {2: 17, 4: 17, 8: 17},
}
"""Clock cycles by number of robots."""

TABLE_III: dict[Style, dict[int, int]] = {
    Style.SEQUENTIAL: {2: 96, 4: 112, 8: 136},
    Style.PIPELINED: {2: 104, 4: 127, 8: 153},
    Style.HYBRID: {2: 128, 4: 161},
}
"""Power, mW, by number of robots; none for the hybrid style with 8, which does not fit the part."""

UPDATE_CYCLES, DETECT_CYCLES = 7, 10
"""Cycles of pos_vel_update and of coll_detect (section III)."""

LUT4_OF_PART, SLICES_OF_PART = 9_312, 4_656
"""Budgets of the XC3S500E that the percentages of Table I are taken of (DS312)."""
