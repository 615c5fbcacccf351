"""The settings of the paper's runs that may be moved."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from codesign.planners.reproduction import Settings


class RelaxationSettings(Settings):
    """Settings of the runs. Without a value, a run has that of the published rows."""

    sor_omegas: tuple[Annotated[float, Field(gt=1, lt=2)], ...] | None = Field(
        default=None,
        min_length=1,
        max_length=50,
        description="relaxation factors of the runs by SOR and red-black; published rows: 1.9 to 1.98, eight of them",
    )
