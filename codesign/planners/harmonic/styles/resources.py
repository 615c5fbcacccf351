"""The demand of the bit-serial circuit: items by resource, as functions of block shape and precision.

N nodes in a block of n rows × m columns. The laws are exact on Tables 1 and 3: the constants of the array
control are Table 3 less N times Table 1. Table 2 has 2 LUT and 1 slice more than 18 nodes and is held out.

Control, decision and border logic are published in slices only. Two LUT and two flip-flops a slice bound them from
above. No table has the two OR trees over the block (no bit changed, no local maximum): (N - 1) / 3 LUT each, by our own
synthesis. They take no slice of their own: a node leaves 4 of the 26 LUT of its 13 slices free, and the trees need less
than one.
"""

from __future__ import annotations

import math

from codesign.figures import Status
from codesign.part import Part
from codesign.planners.demand import Line, sum_by_resource
from codesign.planners.harmonic import published
from codesign.planners.harmonic.published import PAPER

NODE_FLIP_FLOPS = published.NODE.flip_flops
NODE_LUT4 = published.NODE.lut4
NODE_SLICES = published.NODE.slices

ARRAY_FLIP_FLOPS = published.BLOCK.flip_flops - NODE_FLIP_FLOPS * published.BLOCK.nodes
ARRAY_LUT4 = published.BLOCK.lut4 - NODE_LUT4 * published.BLOCK.nodes
ARRAY_SLICES = published.BLOCK.slices - NODE_SLICES * published.BLOCK.nodes

RAM_WIDTH = published.CLUSTER.nodes
"""Bits a word of the cluster and border RAMs: one bit of each of 18 nodes."""


def cluster_count(rows: int, columns: int) -> int:
    """3×6 clusters that cover a block, the last ones partly empty: one block RAM each.

    >>> cluster_count(36, 66), cluster_count(48, 96), cluster_count(4, 7)
    (132, 256, 4)
    """
    return -(-rows // published.CLUSTER_ROWS) * -(-columns // published.CLUSTER_COLUMNS)


def border_nodes(rows: int, columns: int) -> int:
    """Border nodes around a block, corners left out.

    >>> border_nodes(36, 66)
    204
    """
    return 2 * (rows + columns)


def border_rams(rows: int, columns: int, down: int = 2, across: int = 2) -> int:
    """Block RAMs of the borders, 18 nodes of one side each: each side is read at the address of another block.

    Of the ``down`` × ``across`` blocks of a map, one row has no sides to the north and south that another block reads,
    and one column none to the west and east.

    >>> border_rams(36, 66), border_rams(6, 12), border_rams(48, 96), border_rams(6, 12, 1, 1)
    (12, 4, 18, 0)
    """
    vertical = 2 * -(-columns // RAM_WIDTH) if down > 1 else 0
    return vertical + (2 * -(-rows // RAM_WIDTH) if across > 1 else 0)


def memories(rows: int, columns: int, down: int, across: int) -> int:
    """Block RAMs of clusters and borders of a map of ``down`` × ``across`` blocks."""
    return cluster_count(rows, columns) + border_rams(rows, columns, down, across)


def decision_slices(precision: int) -> int:
    """Slices of the decision module, 3p + 682 (section 5.4)."""
    return published.DECISION_SLICES_A_BIT * precision + published.DECISION_SLICES


def array_slices(nodes: int) -> int:
    """Slices of a block's nodes with their control: 13N + 10, exact on Table 3."""
    return NODE_SLICES * nodes + ARRAY_SLICES


def _slices_a_border_node() -> float:
    """The rest of 99.4 % of an XC2V6000 for each of the 204 border nodes of the 36×66 block, all else by its own law.

    About 1.9. With clusters at the 235 slices of Table 2 in place of 13N + 10 it is 1.3.
    """
    # Section 5.4, solved for x: 0.994 · 33,792 = (13N + 10) + 844 + (3 · 255 + 682) + 10 + 204x with N = 36 · 66.
    rows, columns = published.WHOLE_DESIGN_ROWS, published.WHOLE_DESIGN_COLUMNS
    listed = (
        array_slices(rows * columns)
        + published.CONTROL_SLICES
        + decision_slices(published.WHOLE_DESIGN_PRECISION)
        + published.ADDRESS_SLICES
    )
    return (published.WHOLE_DESIGN_SHARE * published.SLICES_OF_XC2V6000 - listed) / border_nodes(
        rows, columns
    )


SLICES_A_BORDER_NODE = _slices_a_border_node()


def border_slices(rows: int, columns: int) -> int:
    """Slices of the border nodes, without their addresses; calibrated on one published row."""
    return math.floor(SLICES_A_BORDER_NODE * border_nodes(rows, columns))


def or_tree_lut4(nodes: int) -> int:
    """4-input LUT of one OR over ``nodes`` bits.

    >>> or_tree_lut4(4608)
    1536
    """
    # A LUT of 4 inputs makes one signal of four, three less; N signals have to become one: (N - 1) / 3 LUT.
    return -(-(nodes - 1) // 3)


def items(
    rows: int, columns: int, precision: int, decision: bool = True, grid: tuple[int, int] = (2, 2)
) -> tuple[Line, ...]:
    """The demand of a design with blocks of ``rows`` × ``columns`` and the last precision ``precision``.

    ``decision``: whether it has its decision module. ``grid``: blocks down and across; the borders of one block alone
    have no memories.
    """
    nodes = rows * columns
    logic = {
        "borders": border_slices(rows, columns),
        "border addresses": published.ADDRESS_SLICES,
        "control": published.CONTROL_SLICES,
        "decision": decision_slices(precision),
    }
    table_1, table_3 = f"{PAPER}, Table 1, a node", f"{PAPER}, Table 3, less the nodes of Table 1"
    text = f"{PAPER}, section 5.4"
    border = f"{text}: what 99.4 % of an XC2V6000 leaves, {SLICES_A_BORDER_NODE:.2f} slices a border node"
    sides = f"RTL of this package, hwsw verify: each side by itself; {text} has 12 for 36×66"
    shown, calibrated = Status.PUBLISHED, Status.CALIBRATED
    laws = (
        ("nodes", "slices", NODE_SLICES * nodes, shown, table_1),
        ("array control", "slices", ARRAY_SLICES, calibrated, table_3),
        ("borders", "slices", logic["borders"], calibrated, border),
        ("border addresses", "slices", logic["border addresses"], shown, f"{text}: around 10"),
        ("control", "slices", logic["control"], shown, text),
        ("decision", "slices", logic["decision"], shown, f"{text}: 3p + 682"),
        ("nodes", "lut4", NODE_LUT4 * nodes, shown, table_1),
        ("array control", "lut4", ARRAY_LUT4, calibrated, table_3),
        (
            "OR trees",
            "lut4",
            2 * or_tree_lut4(nodes),
            Status.MEASURED,
            "our RTL, Yosys: (N - 1) / 3 LUT a tree",
        ),
        ("nodes", "flip_flops", NODE_FLIP_FLOPS * nodes, shown, table_1),
        ("array control", "flip_flops", ARRAY_FLIP_FLOPS, calibrated, table_3),
        ("clusters", "block_rams", cluster_count(rows, columns), shown, f"{text}: one a cluster"),
        ("borders", "block_rams", border_rams(rows, columns, *grid), Status.MEASURED, sides),
    )
    lines = [Line.item(*line) for line in laws]
    bound = "upper bound: two a slice; published in slices only"
    for kind in ("lut4", "flip_flops"):
        lines += [Line.item(name, kind, 2 * slices, Status.ASSUMED, bound) for name, slices in logic.items()]
    return tuple(item for item in lines if decision or item.name != "decision")


def totals(
    rows: int, columns: int, precision: int, decision: bool = True, grid: tuple[int, int] = (2, 2)
) -> dict[str, int]:
    """The demand by resource, without its items; see ``items``."""
    return sum_by_resource(items(rows, columns, precision, decision, grid))


def word_depth(part: Part) -> int:
    """Words of a block RAM of the part at 18 bits a word, for a cluster; 0: no block RAM is so wide."""
    return max((depth for depth, width in part.block_ram_shapes if width >= RAM_WIDTH), default=0)


def digits(precision: int, digit_bits: int) -> int:
    """Digits of a value of ``precision`` bits, the lowest one perhaps in part.

    >>> digits(63, 1), digits(63, 2), digits(63, 8)
    (63, 32, 8)
    """
    return -(-precision // digit_bits)


def words(blocks: int, precision: int, digit_bits: int = 1) -> int:
    """Words in every cluster and border RAM: p bits and a flag for each block (section 5.2).

    With digits of d bits, a RAM for each bit of a digit has ⌈p/d⌉ + 1 words for each block.
    """
    # address  0 .. p            p + 1 .. 2p + 1     ..
    #          flag and p bits   flag and p bits     ..     of blocks 0, 1, ..; each word a bit of the 18 nodes
    return blocks * (digits(precision, digit_bits) + 1)


def largest_precision(blocks: int, depth: int, digit_bits: int = 1) -> int:
    """The highest p with blocks × (⌈p/d⌉ + 1) ≤ ``depth``; below 1 where no precision fits.

    >>> largest_precision(16, 1024), largest_precision(4, 1024), largest_precision(1, 1024)
    (63, 255, 1023)
    """
    return digit_bits * (depth // blocks - 1)
