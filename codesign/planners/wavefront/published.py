"""The numbers of Möller and Paschke (1998) that laws use, of ``published.json``, and the settings of its runs."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from codesign.planners.reproduction import Settings, printed_numbers

NUMBERS = printed_numbers(Path(__file__).with_name("published.json"))
PAPER = NUMBERS.cited
SIDE, CLOCK, STOP_POTENTIAL, DELAY_ELEMENTS = (
    int(NUMBERS.figures[name]) for name in ("side", "clock", "stop_potential", "delay_elements")
)
SOFTWARE_SECONDS = float(NUMBERS.figures["software_seconds"])
SampleName = Literal["rooms of 24", "rooms of 40", "corridors of 16", "corridors of 12", "corridors of 6"]


class WavefrontSettings(Settings):
    """Settings of the runs. Without a value, a run has the setting of the published rows."""

    maps: tuple[SampleName, ...] | None = Field(
        default=None, min_length=2, max_length=5, description="maps, two or more; published rows: all five"
    )
