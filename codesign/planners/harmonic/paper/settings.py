"""The settings of the paper's runs that may be moved."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from codesign.planners.reproduction import Settings

Seed = Annotated[int, Field(ge=0, lt=2**31)]


class HarmonicSettings(Settings):
    """Settings of the runs. Without a value, a run has that of the published rows."""

    labyrinth_seeds: tuple[Seed, ...] | None = Field(
        default=None,
        min_length=1,
        max_length=100,
        description="seeds of the labyrinths of Figure 5; published rows: 1, 2, 3",
    )
    maze_seeds: tuple[Seed, ...] | None = Field(
        default=None,
        min_length=1,
        max_length=100,
        description="seeds of the mazes that speed is measured on; published rows: 1, 2",
    )
