"""Cycles and clocks of the arrays.

Published: D_stop + 1 cycles for the wave. The paper does not count the loading of the map, the end of a wave without a
stop, the read-out, or the tracking of the path. The RTL of this package (``rtl/``) does: ``hwsw verify`` compares
every cycle of it with these laws.

Clock: the paper assumes 20 MHz and shows no layout. Arrays of this package were placed and routed on ECP5 and Gowin;
their law has a line for each kind of node and of read-out. A family that was never placed lies between these two. On
the families of harmonic control's published clocks, its law over the number of nodes is borrowed, as both are grids of
small nodes with a broadcast (``assumed``): ECP5 and Gowin reach 0.4 to 0.8 of it. The adder/comparator node has five
chained operations over R bits in addition.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import Figure, Status
from codesign.ground.late import late
from codesign.ground.models import Part
from codesign.planners.clock_law import LEAST_SHARE, MOST_SHARE, Placement, Registers, on_family
from codesign.planners.harmonic.styles import timing as harmonic_timing
from codesign.planners.interface import Cell, Problem
from codesign.planners.job import Job
from codesign.planners.measured import clock_rows
from codesign.planners.styles import Step, one_step
from codesign.planners.wavefront import published
from codesign.planners.wavefront.plan.grid import WaveMap
from codesign.planners.wavefront.plan.parameters import Course, PropagateParameters, ReadOut
from codesign.planners.wavefront.plan.plan import WavefrontPlan, cached_plan, plan_key
from codesign.planners.wavefront.plan.wave import run_wave, stop_cycle
from codesign.planners.wavefront.styles.resources import ArrayLayout

kernels = late("codesign.planners.wavefront.plan.kernels")

LOAD, OBSTACLES, PROPAGATE, EXCHANGE = "load", "propagate_obstacles", "propagate", "exchange"
READ_OUT, TRACK = "read_out", "track"
"""The phases to which cycles are booked."""


def planned(job: Job[Problem, PropagateParameters]) -> WavefrontPlan:
    """The plan, once for all design points that have it in common."""
    return job.shared(plan_key(job.problem, job.parameters), lambda: cached_plan(job.problem, job.parameters))


def read_out_steps(job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
    """The shift of a chain after a wave; an addressed array takes none."""
    if job.parameters.read_out is ReadOut.CHAIN:
        yield one_step(READ_OUT, read_out_cycles(job.problem.free.size))


def tracked_steps(job: Job[Problem, PropagateParameters], plan: WavefrontPlan, start: Cell | None = None) -> int:
    """Steps that are tracked before a decision: at least 1, even from a start on the goal.

    ``start``: the first cell of the path; by default the first start of the problem.
    """
    if start is None:
        start = job.problem.starts[0] if job.problem.starts else None
    if start is None or plan.potentials[start] < 0:
        return 1
    most = job.parameters.steps if job.parameters.course is Course.LOCAL else None
    return max(1, len(plan.tracker.follow(start, most)) - 1)


def updates(wave_map: WaveMap, sources: NDArray[np.int64]) -> tuple[int, int]:
    """The largest potential of a wave without a stop, and the parallel updates of equation 3 until it is final."""
    potentials, order = run_wave(wave_map, sources, np.zeros((0, 2), np.int64))
    unreached = np.where(wave_map.free, np.int32(kernels.OPEN), np.int32(kernels.CLOSED))
    flat = wave_map.pad(np.where(potentials >= 0, potentials, unreached).astype(np.int32), kernels.CLOSED)
    return int(potentials.max()), int(kernels.rounds(flat, order, *wave_map.arrays))


LOAD_CELLS = 32
"""Cells of a word of the load stream: F and Z of each, and P where nodes are penalised. The words shift on."""

NEIGHBOURS = 8
"""A step of a path reads them one a cycle. Equations 4 and 5 need no second pass: p^d and p^t arrive together."""

READ_LATENCY = 2
"""Edges from the address of a node to its word: one to register the address, or to read a memory; one for the word."""

TRACK_CLOCK = 185_000_000
"""Hz: the fastest clock of a tracker by itself, as of breadth-first search's state machine. Assumed."""

TRACK_FITTED = "Virtex-II Pro"
"""The family of that machine."""

ADDER_LEVELS = 5
LEVEL_NS, CARRY_NS = 1.2, 0.05
"""An addition, three levels of minimum and one more comparison; ns each, and a bit of carry. Assumed."""


def load_cycles(shape: tuple[int, int], element_cells: int = 1) -> int:
    """Cycles to load a map: a word with the start, then the words of the map.

    With elements of k cells the words of each of k rows of cells follow each other. The last of these rows reaches the
    memories one edge after its last word.

    >>> load_cycles((256, 256)), load_cycles((256, 256), 16)
    (2049, 2050)
    """
    if element_cells == 1:
        return 1 + -(-shape[0] * shape[1] // LOAD_CELLS)
    elements = -(-shape[0] // element_cells) * shape[1]
    return 1 + element_cells * -(-elements // LOAD_CELLS) + 1


def tile_load_cycles(tile: tuple[int, int], tiles: int) -> int:
    """Cycles to load a map in tiles: a word with the start, then each row of each tile, up to 32 cells a word.

    >>> tile_load_cycles((16, 16), 256), tile_load_cycles((64, 64), 16)
    (4097, 2049)
    """
    return 1 + tiles * tile[0] * -(-tile[1] // LOAD_CELLS)


def wave_cycles(largest: int, element_cells: int = 1) -> int:
    """Cycles of a wave up to the potential ``largest``: D + 1 steps.

    A wave ends at its stop, or where no wave is on its way to any node. In a step each element takes its cells one
    after the other.

    >>> wave_cycles(1355), wave_cycles(1355, 16)
    (1356, 21696)
    """
    return element_cells * stop_cycle(largest)


def adder_cycles(updates: int) -> int:
    """Cycles of the adder/comparator array: sources to 0 and all others to infinity, updates, and one more in which
    no potential changes.
    """
    return 1 + updates + 1


def read_out_cycles(cells: int) -> int:
    """Cycles in which a chain shifts the potentials of all cells into a memory."""
    return cells


def track_cycles(steps: int) -> int:
    """Cycles to track ``steps`` steps of a path; before them the potential of the first cell is read.

    A step takes eight addresses, and the words of the last ones.

    >>> track_cycles(1), track_cycles(10)
    (12, 102)
    """
    return READ_LATENCY + steps * (NEIGHBOURS + READ_LATENCY)


def scan_cycles(columns: int, tiles: int) -> int:
    """Cycles of a scan of the tiles for the earliest change; one is before the first visit, and one in each exchange.

    The least change of a row of the tile takes a level of comparators a cycle. Then a tile a cycle is read, its word is
    changed and compared, and the choice is made.

    >>> scan_cycles(16, 256)
    263
    """
    return (columns - 1).bit_length() + tiles + 3


def exchange_cycles(tile: tuple[int, int], tiles: int) -> int:
    """Cycles of a tile's visit beside its wave, with the scan after it.

    Every column of the tile has a memory of its own, which reads a word a cycle. In: the rows of the tile and the two
    around it; then the cells beside them, left and right at once (a tile of one column has them in one memory); the
    last word, and the first time into the counter. Out: potentials row by row, each over the word before.

    >>> exchange_cycles((16, 16), 256)
    318
    """
    rows, columns = tile
    sweeps = 2 if columns > 1 else 3
    return sweeps * (rows + 2) + 2 + rows + 1 + scan_cycles(columns, tiles)


def visit_cycles(span: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cycles of the waves of tiles, int64: from the first emission to the last emission or arrival, both counted.

    No wave is on its way then, which the nodes show in the same cycle.
    """
    return span + 1


def registers(layout: ArrayLayout, *, tiled: bool = False) -> Registers:
    """The variables of the clock of an array, or of a tile's: the kind of its nodes, and their number.

    Behind a chain the tracker reads a memory, which delay lines wait for. Adders are slower than both read-outs. The
    tracker of a tile reads the memories of its columns.
    """
    kinds = {
        "a tile of delay lines and the memories of its columns": tiled,
        "adders and comparators": layout.adders,
        "elements": layout.shared,
        "delay lines, read out by a chain": layout.chain,
        "delay lines with a penalty": bool(layout.extra),
        "delay lines": True,
    }
    words = {
        "no corner cutting": not layout.corner_cutting,
        "safe paths": layout.safe,
        "a penalty": bool(layout.extra) and (tiled or layout.adders or layout.shared or layout.chain),
        "a wave to its own end": not layout.waits and not layout.adders,
        "no tracker": not layout.tracked,
        "a complete course": layout.tracked and not layout.local,
        "a chain": layout.adders and layout.chain,
    }
    options = frozenset(word for word, present in words.items() if present)
    like = "delay lines" if tiled else ""
    return Registers(next(kind for kind, true in kinds.items() if true), layout.nodes, 0.0, options, like)


@cache
def placements() -> tuple[Placement, ...]:
    """The arrays that were placed and routed."""
    rows = (row for style in ("delay_line", "adder_comparator", "tiled") for row in clock_rows("wavefront", style))
    return tuple(Placement(row, _registers_of(row.style, row.variables)) for row in rows)


def _registers_of(style: str, variables: Mapping[str, int]) -> Registers:
    layout, tiled = ArrayLayout.of_row(variables), style == "tiled"
    if tiled:
        layout = replace(layout, shape=(variables["TILE_ROWS"], variables["TILE_COLUMNS"]))
    return registers(layout, tiled=tiled)


def clock_limit(layout: ArrayLayout, part: Part, *, tiled: bool = False) -> Figure:
    """The fastest clock of an array on a part, Hz.

    Args:
        layout: of the array, or of a tile's array; of its registers only the width of adders counts.
        part: the part.
        tiled: the array visits the tiles of a larger map.
    """
    nodes = layout.nodes
    # Period of the borrowed grid; of the operations that the adder/comparator node (equation 3) chains in a cycle; and
    # of the memory that an element, or a tracker behind a chain, reads in the same cycle.
    period = 1e9 / harmonic_timing.clock_fit().clock(nodes)
    text = f"period of a grid of {nodes:,} small nodes, as of harmonic control, {period:.1f} ns"
    if layout.adders:
        operations = ADDER_LEVELS * (LEVEL_NS + CARRY_NS * layout.bits)
        period += operations
        text += f", and {ADDER_LEVELS} chained operations over {layout.bits} bits, {operations:.1f} ns"
    elif layout.shared or layout.chain:
        memory = 1e9 / part.block_ram_clock.value
        period += memory
        text += f", and that of a block RAM, {memory:.1f} ns"
    law = 1e9 / period
    value = min(law, part.block_ram_clock.value)
    limit = Figure(
        value=value,
        unit="Hz",
        status=Status.ASSUMED,
        source=f"{text}; {published.PAPER} assumes {published.CLOCK / 1e6:.0f} MHz for its own node",
        low=value * LEAST_SHARE,
        high=min(law * MOST_SHARE, part.block_ram_clock.interval[1]),
    )
    kind = registers(layout, tiled=tiled)
    return on_family(limit, part, *harmonic_timing.FITTED, registers=kind, placements=placements())
