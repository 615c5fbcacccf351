"""The settings of the paper's runs that may be moved."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from codesign.planners.reproduction import Settings


class VelocityObstacleSettings(Settings):
    """Settings of the runs. Without a value, a run has that of the published rows."""

    seeds: Annotated[int, Field(ge=1, le=1_000)] | None = Field(
        default=None, description="seeds of each arrangement and number of robots; published rows: 20"
    )
