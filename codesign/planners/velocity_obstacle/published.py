"""The figures of Dubey et al. (2013) that laws use, of ``published.json``, and the settings of its runs.

``resources`` and ``power`` say which figures the laws are fitted to, and which are held out.
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

from pydantic import Field

from codesign.planners.reproduction import Settings, printed_numbers

NUMBERS = printed_numbers(Path(__file__).with_name("published.json"))
PAPER = NUMBERS.cited
PART, FAMILY = (str(NUMBERS.figures[name]) for name in ("part", "family"))
CLOCK, LUT4_OF_PART, SLICES_OF_PART = (
    int(NUMBERS.figures[name]) for name in ("clock", "lut4_of_part", "slices_of_part")
)


class Style(StrEnum):
    """The three architectures of section III."""

    SEQUENTIAL = "sequential"
    PIPELINED = "pipelined"
    HYBRID = "hybrid"


def _by_robots(table: str, column: str) -> dict[Style, dict[int, int]]:
    rows = NUMBERS.tables[table]
    return {style: {row["robots"]: row[column] for row in rows if row["style"] == style} for style in Style}


TABLE_I: dict[Style, tuple[int, int, int]] = {
    Style(row["style"]): (row["slices"], row["luts"], row["power"]) for row in NUMBERS.tables["Table I"]
}
"""Two robots: CLBs in % (taken as slices, as the mapper reports them), LUTs in %, power in mW."""

TABLE_II, TABLE_III = _by_robots("Table II", "cycles"), _by_robots("Table III", "power")
"""Clock cycles, and power in mW, by number of robots; no power of the hybrid style with 8, which does not fit."""


class VelocityObstacleSettings(Settings):
    """Settings of the runs. Without a value, a run has the setting of the published rows."""

    seeds: Annotated[int, Field(ge=1, le=1_000)] | None = Field(
        default=None, description="seeds of each arrangement and number of robots; published rows: 20"
    )
