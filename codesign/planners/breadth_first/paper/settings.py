"""The settings of the paper's runs that may be moved."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from codesign.planners.reproduction import Settings


class BreadthFirstSettings(Settings):
    """Settings of the runs. Without a value, a run has that of the published rows."""

    maps: Annotated[int, Field(ge=2, le=10_000)] | None = Field(
        default=None, description="maps of each family, size and share of obstacles; published rows: 100"
    )
