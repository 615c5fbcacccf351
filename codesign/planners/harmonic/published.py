"""The numbers of Girau, Boumaza, Scherrer and Torres-Huitzil (2008) on their circuit: section 5.4, Tables 1 to 3.

The laws of this room are fitted to some of these rows and compared with the others; ``paper`` names the use of each
row. The numbers are as printed, also where they contradict each other.
"""

from __future__ import annotations

from dataclasses import dataclass

PAPER = "Girau et al. 2008"


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

    @property
    def nodes(self) -> int:
        """Nodes of the grid."""
        return self.rows * self.columns


NODE = Synthesis("Table 1", 1, 1, "XC2V6000-5", flip_flops=11, lut4=22, slices=13, clock=361_000_000)
CLUSTER = Synthesis("Table 2", 3, 6, "XC2V6000-5", flip_flops=198, lut4=398, slices=235, clock=300_000_000)
BLOCK = Synthesis(
    "Table 3", 48, 96, "XC4VLX160-12", flip_flops=50_699, lut4=101_396, slices=59_914, clock=150_000_000
)

CLUSTER_ROWS, CLUSTER_COLUMNS = CLUSTER.rows, CLUSTER.columns
"""Nodes that share one block RAM: 3 × 6 = 18, its width in bits (section 5.1)."""

CONTROL_SLICES = 844
ADDRESS_SLICES = 10
"""Addresses of the border RAMs: "around 10 for up to 5x5 blocks"."""
DECISION_SLICES_A_BIT, DECISION_SLICES = 3, 682
"""The decision module takes 3p + 682 slices."""

SLICES_OF_XC2V6000 = 33_792
WHOLE_DESIGN_ROWS, WHOLE_DESIGN_COLUMNS = 36, 66
WHOLE_DESIGN_PRECISION, WHOLE_DESIGN_BLOCKS = 255, 4
WHOLE_DESIGN_SHARE = 0.994
"""Share of the slices of an XC2V6000 that the whole circuit takes: 36×66 nodes, 4 blocks, p = 255."""

ESTIMATED_CLOCK = 150_000_000
"""Hz: "an estimated clock frequency of 150 MHz", said of the design on the Virtex-2 board."""

SOFTWARE_ITERATION_PS = 100_000_000
"""ps: "around 100 µs per iteration with a 36x66 block" on a "Pentium 4,2 GHz"."""
