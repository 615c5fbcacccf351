"""The numbers of Vacariu et al. (2008) that laws use, of ``published.json``, and the settings of its runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from codesign.planners.reproduction import Settings, printed_numbers

NUMBERS = printed_numbers(Path(__file__).with_name("published.json"))
PAPER, FAMILY = NUMBERS.cited, str(NUMBERS.figures["family"])
CLOCK_LIMIT, SHOWN_CLOCK, DISPLAY_ROWS, DISPLAY_COLUMNS, MEMORY_WALL_SIDE = (
    int(NUMBERS.figures[name])
    for name in ("clock_limit", "shown_clock", "display_rows", "display_columns", "memory_wall_side")
)


@dataclass(frozen=True)
class HardwareRun:
    """A row of Tables 2 and 3: the circuit on the XC2VP30-6, µs at 120 and at 150 MHz."""

    side: int
    obstacles: float
    microseconds_at_120: float
    microseconds_at_150: float
    use: str

    @property
    def cycles_at_120(self) -> float:
        """Time × clock."""
        return self.microseconds_at_120 * 120

    @property
    def cycles_at_150(self) -> float:
        """Time × clock."""
        return self.microseconds_at_150 * 150


HARDWARE = tuple(HardwareRun(**row) for row in NUMBERS.tables["Tables 2, 3"])
SOFTWARE: dict[tuple[int, float], int] = {
    (row["side"], row["obstacles"]): row["milliseconds"] for row in NUMBERS.tables["Table 1"]
}
"""Table 1: ms by side and share of obstacles. The second row says "Almost 0"."""


class BreadthFirstSettings(Settings):
    """Settings of the runs. Without a value, a run has the setting of the published rows."""

    maps: Annotated[int, Field(ge=2, le=10_000)] | None = Field(
        default=None, description="maps of each family, size and share of obstacles; published rows: 100"
    )
