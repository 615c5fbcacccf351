"""A part: a chip with a vector of resource budgets, its limits, and the source of each number."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from codesign.ground.figures import Figure


class Part(BaseModel):
    """A chip in one speed grade.

    - ``resources``: budgets by kind: slices, lut4, flip_flops, block_rams, multipliers. Laws count LUT of four inputs,
      slices of two of them with two flip-flops, and block RAMs of 18 kbit; a part of another make is converted.
    - ``block_ram_shapes``: (depth, width) pairs that one block RAM may be configured as.
    - ``block_ram_clock``: the fastest clock of a block RAM in this speed grade, Hz.
    - ``static_power``: W. ``dynamic_power``: W for each occupied slice (as counted here) and Hz, at typical activity.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    family: str
    speed_grade: str
    resources: dict[str, Figure]
    block_ram_shapes: tuple[tuple[int, int], ...]
    block_ram_clock: Figure
    static_power: Figure
    dynamic_power: Figure

    @property
    def full_name(self) -> str:
        """Name and speed grade, as platforms name it: ``XC4VLX160-12``."""
        return f"{self.name}{self.speed_grade}"
