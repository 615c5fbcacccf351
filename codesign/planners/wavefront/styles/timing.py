"""Cycles and clocks of the arrays.

Published: D_stop + 1 cycles for the wave. The paper does not count the loading of the map, the tracking of the path, or
the storage of p^d while p^t is computed. This module has the assumed costs of these, in phases of their own.

Clock: the paper assumes 20 MHz and shows no layout. On an FPGA both arrays are grids of small nodes with a broadcast,
like the array of harmonic control. So its law of the clock over the number of nodes is borrowed (``assumed``; interval
from the paper's 20 MHz up). The adder/comparator node has five chained operations over R bits in addition.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.figures import Figure, Status
from codesign.part import Part
from codesign.planners.clock_law import on_family
from codesign.planners.harmonic.styles import timing as harmonic_timing
from codesign.planners.wavefront import published
from codesign.planners.wavefront.plan.parameters import Paths

LOAD_CELLS = 32
"""Cells written a cycle: the array is addressed "like a RAM memory" (Conclusion), one word of 32 nodes. Assumed."""

SHORTEST_STEP = 9
"""Cycles of one step of equation 2: the eight neighbours read one a cycle, and one to choose. Assumed."""

SAFE_STEP = 17
"""Cycles of one step of equations 4 and 5: two passes over the neighbours, and one to choose. Assumed."""

TRACK_CLOCK = 185_000_000
"""Hz: the fastest clock of a tracker by itself, as that of breadth-first search's state machine. Assumed."""

TRACK_FITTED = "Virtex-II Pro"
"""The family of that machine."""

ADDER_LEVELS = 5
LEVEL_NS, CARRY_NS = 1.2, 0.05
"""An addition, three levels of minimum and one more comparison; ns each, and a bit of carry. Assumed."""


def load_cycles(cells: int) -> int:
    """Cycles to write one bit of every node."""
    return -(-cells // LOAD_CELLS)


def whole_map_cycles(bits: int) -> int:
    """Cycles of a wave with no stop: until the counter of R bits is full, which is infinity.

    >>> whole_map_cycles(11)
    2047
    """
    # The counter runs from 0 to 2^R - 1, and its last value is infinity for registers that are still open.
    return (1 << bits) - 1


def track_cycles(steps: int, paths: Paths) -> int:
    """Cycles to track ``steps`` steps of a path."""
    return steps * (SAFE_STEP if paths is Paths.SAFE else SHORTEST_STEP)


def exchange_cycles(rows: int, tiles: int) -> int:
    """Cycles of a tile's visit beside its wave.

    Every column of the tile has a memory of its own. In: F row by row, the cells above and below (2), those left and
    right row by row; out: potentials row by row; and a scan of the tiles for the earliest change. Assumed.
    """
    # F: rows. Above and below: 2. Left and right: rows. Potentials back: rows. The scan: tiles.
    return 3 * rows + 2 + tiles


def visit_cycles(span: NDArray[np.int64], longest_delay: int) -> NDArray[np.int64]:
    """Cycles of the waves of tiles: their spans, and the silence that proves each dead. int64."""
    return span + longest_delay + 1


def clock_limit(nodes: int, part: Part, adder_bits: int = 0) -> Figure:
    """The fastest clock of an array on a part, Hz; ``adder_bits``: the width of an adder/comparator node, or 0."""
    # Period of the borrowed grid, and of the operations that the adder/comparator node (equation 3) chains in a cycle.
    period = 1e9 / harmonic_timing.clock_fit().clock(nodes)
    chain = ADDER_LEVELS * (LEVEL_NS + CARRY_NS * adder_bits) if adder_bits else 0.0
    law = 1e9 / (period + chain)
    text = f"period of a grid of {nodes:,} small nodes, as of harmonic control, {period:.1f} ns"
    if chain:
        text += f", and {ADDER_LEVELS} chained operations over {adder_bits} bits, {chain:.1f} ns"
    value = min(law, part.block_ram_clock.value)
    limit = Figure(
        value=value,
        unit="Hz",
        status=Status.ASSUMED,
        source=f"{text}; {published.PAPER} assumes {published.CLOCK / 1e6:.0f} MHz for its own node",
        low=min(value, published.CLOCK),
        high=min(1.5 * law, part.block_ram_clock.interval[1]),
    )
    return on_family(limit, part, *harmonic_timing.FITTED)
