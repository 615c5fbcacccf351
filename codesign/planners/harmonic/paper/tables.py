"""Tables 1 to 3 and the counts of section 5.4 of Girau et al. (2008): the rows without a simulation."""

from __future__ import annotations

from functools import partial

from codesign.figures import Status
from codesign.planners.harmonic import published
from codesign.planners.harmonic.plan.fixed_point import limbs_needed
from codesign.planners.harmonic.published import Synthesis
from codesign.planners.harmonic.styles import geometry, resources, timing
from codesign.planners.reproduction import Row, Use, row

_text_row = partial(row, "Section 5.4", status=Status.PUBLISHED, use=Use.HELD_OUT)
_introduction_row = partial(row, "Section 1", status=Status.PUBLISHED, use=Use.HELD_OUT)
"""Most rows rest on published figures and are held out; the others override it."""

BLOCK_RAMS_OF_XC4VLX160 = 288
BLOCK_RAMS_OF_LARGEST_VIRTEX_4 = 336
"""18-kbit block RAMs of the XC4VLX200, the largest Virtex-4 when the paper was written (DS112)."""


def table_rows() -> tuple[Row, ...]:
    """Every row of Tables 1 to 3 and of the text, in the order of the paper."""
    return (*_synthesis_rows(), *_count_rows(), *_depth_rows(), *_largest_block_rows(), *_clock_rows())


def _synthesis_rows() -> list[Row]:
    """Tables 1 to 3: a node, a cluster of 18 nodes, a block of 48 × 96."""
    rows: list[Row] = []
    for synthesis in (published.NODE, published.CLUSTER, published.BLOCK):
        rows += _synthesis(synthesis)
    return rows


def _synthesis(synthesis: Synthesis) -> list[Row]:
    array = synthesis is published.BLOCK
    held_out = synthesis is published.CLUSTER
    kinds = (
        ("flip-flops", synthesis.flip_flops, resources.NODE_FLIP_FLOPS, resources.ARRAY_FLIP_FLOPS),
        ("LUT", synthesis.lut4, resources.NODE_LUT4, resources.ARRAY_LUT4),
        ("slices", synthesis.slices, resources.NODE_SLICES, resources.ARRAY_SLICES),
    )
    rows = []
    for name, count, a_node, constant in kinds:
        law = f"{a_node}N" + (f" + {constant}" if array else "")
        note = ""
        if held_out and name == "LUT":
            note = "18 nodes and 2 LUT: the counters said to be in it cannot be"
        elif array:
            note = f"the constant {constant} is fitted to this row; no OR tree can be in it"
        rows.append(
            row(
                synthesis.table,
                name,
                count,
                a_node * synthesis.nodes + (constant if array else 0),
                status=Status.CALIBRATED if array else Status.PUBLISHED,
                source=f"{law}, N = {synthesis.nodes}",
                use=Use.HELD_OUT if held_out else Use.FITTED,
                note=note,
            )
        )
    fit = timing.clock_fit()
    rows.append(
        row(
            synthesis.table,
            "clock",
            synthesis.clock,
            fit.clock(synthesis.nodes),
            unit="Hz",
            status=Status.CALIBRATED,
            source=f"period {fit.offset:.2f} ns + {fit.slope:.3f} ns × {fit.form}",
            use=Use.FITTED,
            note=f"{synthesis.part}; one of the three points of the fit",
        )
    )
    return rows


def _count_rows() -> list[Row]:
    """Logic cells, block RAMs and slices of the 36 × 66 block on the XC2V6000."""
    shape = published.WHOLE_DESIGN_ROWS, published.WHOLE_DESIGN_COLUMNS
    nodes = shape[0] * shape[1]
    cells = 2 * resources.NODE_SLICES
    share = 100 * cells * nodes / (2 * published.SLICES_OF_XC2V6000)
    demand = resources.totals(resources.Machine(*shape, published.WHOLE_DESIGN_PRECISION), "Virtex-II")[
        "slices"
    ]
    listed = demand - resources.border_slices(*shape)
    budget = published.SLICES_OF_XC2V6000
    law = "two logic cells a slice, 13 slices a node"
    return [
        _text_row("logic cells a node", 26, cells, source=law),
        _text_row(
            "logic cells a cluster",
            470,
            cells * published.CLUSTER.nodes,
            source=law,
            note="Table 2 has 235 slices; 18 nodes have 234",
        ),
        _text_row(
            "logic cells of XC2V6000 for 36×66 nodes",
            "< 92 %",
            share,
            unit="%",
            source=law,
            note="holds" if share < 92 else "does not hold",
        ),
        _text_row(
            "block RAMs for 36×66 nodes", 132, geometry.cluster_count(*shape), source="one a 3×6 cluster"
        ),
        _text_row(
            "block RAMs for its 204 border nodes",
            12,
            geometry.border_rams(*shape),
            source="one for 18 border nodes of a side",
        ),
        _text_row(
            "slices of XC2V6000, 4 blocks, p = 255",
            100 * published.WHOLE_DESIGN_SHARE,
            100 * demand / budget,
            unit="%",
            status=Status.CALIBRATED,
            source="13N + 10, 844, 3p + 682, 10, and the border nodes",
            use=Use.FITTED,
            note=f"border nodes ({resources.SLICES_A_BORDER_NODE:.2f} slices each) are fitted to this row; all"
            f" else is published and comes to {100 * listed / budget:.1f} %",
        ),
    ]


def _depth_rows() -> list[Row]:
    """Blocks against bits a word."""
    depth = 1024
    law = "blocks × (p + 1) ≤ 1,024 words of 18 bits"
    most_blocks = depth // 64
    return [
        _text_row(
            "precision with 4 blocks",
            published.WHOLE_DESIGN_PRECISION,
            resources.largest_precision(published.WHOLE_DESIGN_BLOCKS, depth),
            unit="bit",
            source=law,
        ),
        _text_row(
            "word with 1 block (up to 1K bits)",
            1024,
            resources.largest_precision(1, depth) + 1,
            unit="bit",
            source=law,
        ),
        _introduction_row(
            "blocks of 96×48 with 64 bits",
            16,
            most_blocks,
            source=law,
            note=f"64 bits with the flag, p = 63; p = 64 would take {resources.words(16, 64):,} words",
        ),
        _introduction_row("nodes of 16 such blocks", 73_728, most_blocks * 96 * 48, source=law),
    ]


def _largest_block_rows() -> list[Row]:
    """Block RAMs of the largest blocks that the paper names."""
    large = resources.totals(resources.Machine(48, 96, 63), "Virtex-4")
    largest = resources.totals(resources.Machine(54, 108, 63), "Virtex-4")
    return [
        _introduction_row(
            "block RAMs of XC4VLX160 for a 96×48 block",
            f"≤ {BLOCK_RAMS_OF_XC4VLX160}",
            large["block_rams"],
            source="clusters and borders, 18 nodes a block RAM",
            note="fits" if large["block_rams"] <= BLOCK_RAMS_OF_XC4VLX160 else "does not fit",
        ),
        _text_row(
            "block RAMs for a 54×108 block, largest FPGA",
            BLOCK_RAMS_OF_LARGEST_VIRTEX_4,
            largest["block_rams"],
            source="clusters and borders, 18 nodes a block RAM",
            note=f"{BLOCK_RAMS_OF_LARGEST_VIRTEX_4} is what the XC4VLX200 has; the paper says the block fits,"
            f" {largest['block_rams'] - BLOCK_RAMS_OF_LARGEST_VIRTEX_4} would be missing",
        ),
    ]


def _clock_rows() -> list[Row]:
    """The estimated clock and the speed-up at 128 bits."""
    nodes = published.WHOLE_DESIGN_ROWS * published.WHOLE_DESIGN_COLUMNS
    software = published.SOFTWARE_ITERATION_PS / 1e12
    hardware = timing.iteration_cycles(128) / published.ESTIMATED_CLOCK
    break_even = round(software / 100 * published.ESTIMATED_CLOCK) - 2
    return [
        _text_row(
            "clock of 36×66 nodes on the Virtex-2 board",
            published.ESTIMATED_CLOCK,
            timing.clock_fit().clock(nodes),
            unit="Hz",
            status=Status.CALIBRATED,
            source=f"period linear in {timing.clock_fit().form}, fitted to Tables 1 to 3",
            note="an estimate of the paper; the interval of the law is twice this miss",
        ),
        _text_row(
            "speed-up at 128 bits, 100 µs at any precision",
            100,
            software / hardware,
            source="100 µs an iteration of 36×66 nodes over (p + 2) / 150 MHz",
            note=f'"up to 100x"; exactly 100 would be p = {break_even}',
        ),
        _text_row(
            "speed-up at 128 bits, 100 µs a 64-bit limb",
            100,
            limbs_needed(128) * software / hardware,
            status=Status.ASSUMED,
            source=f"the same, {limbs_needed(128)} limbs of software",
            note="so the paper's 100 µs cannot be for one limb of several",
        ),
    ]
