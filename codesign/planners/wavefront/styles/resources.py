"""The demand of the arrays: items by resource, for nodes with registers of R bits.

A node of the delay line has the line's flip-flops (as many as the longest delay), F, and R bits of register; 5 LUT, and
R more for the chain that reads it out. Without the chain it takes a fiftieth of the LUT of an adder/comparator node
at R = 11, with it a sixteenth; flip-flops are not saved. A slice holds two of each; sharing slices between nodes is
not assumed, so that a node of R = 11 takes 8.
"""

from __future__ import annotations

from dataclasses import dataclass

from codesign.figures import Status
from codesign.part import Part
from codesign.planners.demand import Line
from codesign.planners.wavefront import published
from codesign.planners.wavefront.plan.grid import tile_count
from codesign.planners.wavefront.published import PAPER, RTL

Shape = tuple[int, int]

CORNER_LUT4 = 2
"""LUT more where corners may not be cut: each diagonal input waits for two F, 3 LUT in place of 1."""

RAM_FLAG_BITS = 1
"""Bits beside the potential in a word of a tile's memory: F."""


@dataclass(frozen=True)
class Node:
    """One node: flip-flops and LUT by purpose, with status and source."""

    flip_flops: tuple[tuple[str, int, Status, str], ...]
    lut4: tuple[tuple[str, int, Status, str], ...]

    @property
    def slices(self) -> int:
        """Slices of one node, not shared with others."""
        most = max(sum(part[1] for part in self.flip_flops), sum(part[1] for part in self.lut4))
        return -(-most // 2)


@dataclass(frozen=True)
class ArrayLayout:
    """The sizes that decide the demand of an array.

    ``shape``: rows and columns of nodes. ``bits``: of a register. ``obstacle_bits``: of a second register for p^d, 0:
    none. ``line``: flip-flops of the delay line. ``extra``: those of the longer line of penalised nodes.
    """

    shape: tuple[int, int]
    bits: int
    obstacle_bits: int = 0
    line: int = published.DELAY_ELEMENTS
    extra: int = 0
    corner_cutting: bool = True

    @property
    def nodes(self) -> int:
        """Nodes of the array."""
        return self.shape[0] * self.shape[1]


def delay_line_node(layout: ArrayLayout) -> Node:
    """A node of Figure 2: 4 + R flip-flops and 5 + R LUT in the paper's own form.

    >>> node = delay_line_node(ArrayLayout((256, 256), 11))
    >>> sum(part[1] for part in node.flip_flops), sum(part[1] for part in node.lut4), node.slices
    (15, 16, 8)
    """
    figure_2, own, hand = f"{PAPER}, Figure 2", RTL, "counted by hand, not synthesised"
    flip_flops = [
        ("delay lines", layout.line, Status.PUBLISHED, f"{figure_2}: as many as the longest delay"),
        ("F", 1, Status.PUBLISHED, figure_2),
        ("registers", layout.bits, Status.PUBLISHED, f"{figure_2}: R bits"),
    ]
    lut4 = [
        ("node logic", published.NODE_LUT4, Status.MEASURED, own),
        ("read-out chains", layout.bits, Status.MEASURED, f"{own}: one a bit of register"),
    ]
    if layout.obstacle_bits:
        flip_flops += [
            (
                "obstacle registers",
                layout.obstacle_bits,
                Status.ASSUMED,
                f"p^d is kept beside p^t; {PAPER} is silent",
            ),
            ("Z", 1, Status.PUBLISHED, f"{PAPER}, Safe Paths: a one-bit memory"),
        ]
        lut4.append(
            ("obstacle read-out chains", layout.obstacle_bits, Status.ASSUMED, "as of the first register")
        )
    if layout.extra:
        source = f"{PAPER}, Conclusion: additional flip-flops and a switchable entry point"
        flip_flops.append(
            ("longer delay lines", layout.extra + 1, Status.ASSUMED, f"{source}; one bit to choose")
        )
        lut4.append(("entry points", 1, Status.ASSUMED, source))
    if not layout.corner_cutting:
        lut4.append(("corner rule", CORNER_LUT4, Status.ASSUMED, hand))
    return Node(tuple(flip_flops), tuple(lut4))


def adder_node(layout: ArrayLayout) -> Node:
    """A node of Hassoun and Sanghvi: eight adders and eight comparators over R bits, and a register."""
    source = f"{RTL}: 8 adders, 8 comparators"
    flip_flops = [
        ("registers", layout.bits, Status.MEASURED, RTL),
        ("F and Z", published.ADDER_FLIP_FLOPS, Status.MEASURED, RTL),
    ]
    lut4 = [
        ("adders and comparators", published.ADDER_LUT4_A_BIT * layout.bits, Status.MEASURED, source),
        ("read-out chains", layout.bits, Status.MEASURED, f"{RTL}: one a bit of register"),
    ]
    if layout.obstacle_bits:
        flip_flops.append(
            ("obstacle registers", layout.obstacle_bits, Status.ASSUMED, "p^d is kept beside p^t")
        )
        lut4.append(
            ("obstacle read-out chains", layout.obstacle_bits, Status.ASSUMED, "as of the first register")
        )
    if not layout.corner_cutting:
        lut4.append(("corner rule", 4, Status.ASSUMED, "one for each diagonal adder, by hand"))
    if layout.extra:
        cost = f"{PAPER} has no such node: one more adder of R bits for the cell's own cost"
        lut4.append(("cell cost", layout.bits, Status.ASSUMED, cost))
        flip_flops.append(("cell cost", 1, Status.ASSUMED, "one bit to choose"))
    return Node(tuple(flip_flops), tuple(lut4))


def array_items(node: Node, layout: ArrayLayout) -> tuple[Line, ...]:
    """All nodes of an array, with the counter and the lines that select a node."""
    count, bits = layout.nodes, layout.bits
    select = sum(layout.shape)
    return (
        Line.item(
            "nodes",
            "slices",
            count * node.slices,
            Status.MEASURED,
            "two LUT and two flip-flops a slice, none shared",
        ),
        Line.item("counter", "slices", -(-bits // 2), Status.PUBLISHED, f"{PAPER}, Figure 2: Cntr."),
        Line.item(
            "select lines",
            "slices",
            -(-select // 2),
            Status.ASSUMED,
            "one LUT a row and a column, as of a RAM",
        ),
        *(
            Line.item(name, "flip_flops", count * amount, status, source)
            for name, amount, status, source in node.flip_flops
        ),
        Line.item("counter", "flip_flops", bits, Status.PUBLISHED, f"{PAPER}, Figure 2: Cntr."),
        *(
            Line.item(name, "lut4", count * amount, status, source)
            for name, amount, status, source in node.lut4
        ),
        Line.item("counter", "lut4", bits, Status.ASSUMED, "one a bit"),
        Line.item("select lines", "lut4", select, Status.ASSUMED, "one a row and a column"),
    )


def or_tree_items(nodes: int, what: str) -> tuple[Line, ...]:
    """An OR over a bit of every node: (N - 1) / 3 LUT."""
    # Three signals less for each LUT of four inputs, from N to 1.
    lut4 = -(-(nodes - 1) // 3)
    return (
        Line.item(what, "lut4", lut4, Status.ASSUMED, "(N - 1) / 3 LUT a tree"),
        Line.item(what, "slices", -(-lut4 // 2), Status.ASSUMED, "two LUT a slice"),
    )


def tile_items(layout: ArrayLayout, tiles: int, words: int, part: Part) -> tuple[Line, ...]:
    """The demand of a tiled array beside its nodes: cells around it that emit, memories of the columns, a scheduler."""
    rows, columns = layout.shape
    # The cells around a tile, corners included, since the wave enters diagonally as well:
    #
    #   + - - - +        a halo cell holds the potential that its own tile gave it, and
    #   |       |        emits when the counter comes to it
    #   + - - - +
    #
    # A LUT compares two bits of each word, and an AND of four such results takes one more.
    halo, bits = 2 * (rows + columns) + 4, layout.bits
    compare = -(-bits // 2) + -(-bits // 8)
    scheduler = 4 * bits + 64
    around = "a register, and a comparator with the counter, for each cell around the tile"
    earliest = "the earliest change of each tile, scanned one a cycle"
    rams = columns * -(-words // max(1, word_depth(part, bits + RAM_FLAG_BITS)))
    return (
        Line.item("halo", "flip_flops", halo * (bits + 1), Status.ASSUMED, around),
        Line.item("halo", "lut4", halo * compare, Status.ASSUMED, around),
        Line.item("halo", "slices", halo * -(-max(bits + 1, compare) // 2), Status.ASSUMED, around),
        Line.item("scheduler", "flip_flops", scheduler, Status.ASSUMED, earliest),
        Line.item("scheduler", "lut4", scheduler, Status.ASSUMED, earliest),
        Line.item("scheduler", "slices", -(-scheduler // 2), Status.ASSUMED, earliest),
        Line.item("scheduler", "block_rams", 1, Status.ASSUMED, f"{earliest}; {tiles} tiles"),
        Line.item(
            "column memories",
            "block_rams",
            rams,
            Status.ASSUMED,
            f"{words} words of {bits + 1} bits a column",
        ),
        *or_tree_items(layout.nodes, "silence detection"),
    )


def word_depth(part: Part, bits: int) -> int:
    """Words of the part's block RAM where a word holds ``bits``; 0: none so wide."""
    return max((depth for depth, width in part.block_ram_shapes if width >= bits), default=0)


def tiled_items(layout: ArrayLayout, map_shape: Shape, tile: Shape, part: Part) -> tuple[Line, ...]:
    """The demand of a tile's array with its memories, at the widths of ``layout``.

    p^d of safe paths goes to the memories too and needs no second register.
    """
    tiles = tile_count(map_shape, tile)
    shown = ArrayLayout(tile, layout.bits, 0, layout.line, layout.extra, layout.corner_cutting)
    words = tiles * tile[0] * (2 if layout.obstacle_bits else 1)
    return (*array_items(delay_line_node(shown), shown), *tile_items(shown, tiles, words, part))
