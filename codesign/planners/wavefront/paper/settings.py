"""The settings of the paper's runs that may be moved."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from codesign.planners.reproduction import Settings

SampleName = Literal["rooms of 24", "rooms of 40", "corridors of 16", "corridors of 12", "corridors of 6"]


class WavefrontSettings(Settings):
    """Settings of the runs. Without a value, a run has that of the published rows."""

    maps: tuple[SampleName, ...] | None = Field(
        default=None, min_length=2, max_length=5, description="maps, two or more; published rows: all five"
    )
