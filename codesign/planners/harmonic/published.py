"""The numbers of Girau et al. (2008) that laws use, of ``published.json``, and the settings of its runs.

The laws of this room are fitted to some of these rows and compared with the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from codesign.planners.reproduction import Settings, printed_numbers

NUMBERS = printed_numbers(Path(__file__).with_name("published.json"))
PAPER = NUMBERS.cited


@dataclass(frozen=True)
class Synthesis:
    """A table of synthesis results: a grid of nodes on a part. ``clock`` in Hz."""

    table: str
    rows: int
    columns: int
    part: str
    flip_flops: int
    lut4: int
    slices: int
    clock: int
    use: str

    @property
    def nodes(self) -> int:
        """Nodes of the grid."""
        return self.rows * self.columns


NODE, CLUSTER, BLOCK = (Synthesis(**row) for row in NUMBERS.tables["Synthesis"])
CLUSTER_ROWS, CLUSTER_COLUMNS = CLUSTER.rows, CLUSTER.columns
"""Nodes that share one block RAM: 3 × 6 = 18, its width in bits (section 5.1)."""

CONTROL_SLICES, ADDRESS_SLICES, DECISION_SLICES_A_BIT, DECISION_SLICES, SLICES_OF_XC2V6000 = (
    int(NUMBERS.figures[name])
    for name in ("control_slices", "address_slices", "decision_slices_a_bit", "decision_slices", "slices_of_xc2v6000")
)
WHOLE_DESIGN_ROWS, WHOLE_DESIGN_COLUMNS, WHOLE_DESIGN_PRECISION = (
    int(NUMBERS.figures[f"design_{name}"]) for name in ("rows", "columns", "precision")
)
WHOLE_DESIGN_SHARE = float(NUMBERS.figures["design_share"])
"""Share of the slices of an XC2V6000 that the whole circuit takes."""

ESTIMATED_CLOCK, SOFTWARE_ITERATION_PS = (
    int(NUMBERS.figures[name]) for name in ("estimated_clock", "software_iteration_ps")
)

Seed = Annotated[int, Field(ge=0, lt=2**31)]


class HarmonicSettings(Settings):
    """Settings of the runs. Without a value, a run has the setting of the published rows."""

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
