"""The numbers that Vacariu, Roman, Timar, Stanciu, Banabic and Cret (2008) publish: Tables 1 to 3 and the text.

The numbers are as printed, also where they contradict each other.
"""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "Vacariu et al. 2008"
FAMILY = "Virtex-II Pro"
"""The family of the XC2VP30, which the circuit was synthesised for."""


@dataclass(frozen=True)
class SoftwareRun:
    """A row of Table 1: the Java program on a Pentium 4. ``milliseconds`` as read from the system's clock."""

    side: int
    obstacles: float
    spreading: str
    milliseconds: int


SOFTWARE = (
    SoftwareRun(30, 0.25, "High", 10),
    SoftwareRun(30, 0.50, "Medium", 0),
    SoftwareRun(40, 0.25, "High", 40),
    SoftwareRun(40, 0.50, "High", 10),
    SoftwareRun(100, 0.25, "High", 120),
    SoftwareRun(100, 0.50, "High", 40),
)
"""Table 1. The second row says "Almost 0"."""

SOFTWARE_TICK_MS = 10
"""Every time of Table 1 is a multiple of 10 ms: the tick of the clock. So each time is good to ±10 ms."""


@dataclass(frozen=True)
class HardwareRun:
    """A row of Tables 2 and 3: the circuit on the XC2VP30-6, µs at 120 and at 150 MHz."""

    side: int
    obstacles: float
    microseconds_at_120: float
    microseconds_at_150: float

    @property
    def cycles_at_120(self) -> float:
        """Time × clock."""
        return self.microseconds_at_120 * 120

    @property
    def cycles_at_150(self) -> float:
        """Time × clock."""
        return self.microseconds_at_150 * 150


HARDWARE = (
    HardwareRun(10, 0.25, 2.78, 2.35),
    HardwareRun(30, 0.25, 34.95, 28.2),
    HardwareRun(40, 0.50, 73.81, 59.54),
    HardwareRun(50, 0.50, 112.15, 90.14),
    HardwareRun(100, 0.50, 475.38, 380.3),
)
"""Tables 2 and 3; the spreading of every row is High."""

CLOCK_LIMIT = 185_000_000
"""Hz: "the system can work at a maximum frequency of 185 MHz" (section 3.2)."""
SHOWN_CLOCK = 150_000_000
"""Hz: the fastest clock with published times."""

DISPLAY_ROWS, DISPLAY_COLUMNS = 600, 800
DISPLAY_CLOCK = 65_000_000
DISPLAY_REFRESH = 60
"""The VGA controller: 800×600 pixels, a 65 MHz clock, 60 ± 1 Hz (section 3.1.1)."""

MEMORY_WALL_SIDE = 200
"""Side of the map for which the Java program "required more virtual memory ... than the operating system could
give" (section 2.2). It ran at 100."""
