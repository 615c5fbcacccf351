"""The demand of the bit-serial circuit: items by resource, as functions of block shape and precision.

The design of the paper, without a pipeline on a Virtex-II or Virtex-4, has what the paper published of it. N nodes and
their array are exact on Tables 1 and 3: the constants of the array control are Table 3 less N times Table 1. Table 2
has 2 LUT and 1 slice more than 18 nodes and is held out. The slices of control, decision and border logic are from
section 5.4. All else is what synthesis counts of the RTL of this package: ``planners/harmonic/measured/laws.yaml``.
The OR trees take no slice of their own: a node leaves 4 of the 26 LUT of its 13 slices free, and the trees need less
than one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from codesign.ground.figures import Status, label
from codesign.ground.models import Part
from codesign.planners.counted import CountedLaws
from codesign.planners.harmonic import published
from codesign.planners.harmonic.plan.parameters import MAX_PRECISION
from codesign.planners.harmonic.published import PAPER
from codesign.planners.job import Lever, Line, largest, packed, part_lever, sum_by_resource

RAM_WIDTH = published.CLUSTER.nodes
"""Bits a word of the cluster and border RAMs: one bit of each of 18 nodes."""

TREE_GROUP = 288
"""Nodes to a register of the OR trees without a pipeline: 5 levels of 4 inputs."""

PIPELINE_TREE_GROUP = 16
"""Clusters to a register of the OR trees with a pipeline, after a register for each cluster."""

FIELD_MEMORIES = 5
"""Memories of the field of a decision module by itself: a cell and its neighbours are each in another one."""


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


def tree_widths(rows: int, columns: int, pipeline: int = 0) -> list[int]:
    """Registers of each stage of an OR tree over a block, without the registers of its last stage and of the clusters.

    >>> tree_widths(6, 12), tree_widths(48, 96), tree_widths(48, 96, 1)
    ([], [16], [16])
    """
    clusters = cluster_count(rows, columns)
    # Without a pipeline the last register is that of the control. With it each cluster has a register first.
    inputs, group = (clusters, PIPELINE_TREE_GROUP) if pipeline else (RAM_WIDTH * clusters, TREE_GROUP)
    widths = []
    while inputs > group:
        inputs = -(-inputs // group)
        widths.append(inputs)
    return widths


def digits(precision: int, digit_bits: int) -> int:
    """Digits of a value of ``precision`` bits, the lowest one perhaps in part.

    >>> digits(63, 1), digits(63, 2), digits(63, 8)
    (63, 32, 8)
    """
    return -(-precision // digit_bits)


def field_groups(columns: int) -> int:
    """Groups of five columns in a row of the field, the last one partly empty."""
    return -(-columns // FIELD_MEMORIES)


def field_plane(rows: int, columns: int) -> int:
    """Words of one bit that each memory of the field holds for a bit of all cells.

    >>> field_plane(10, 14)
    30
    """
    return rows * field_groups(columns)


def field_rams_a_memory(rows: int, columns: int, precision: int, shapes: Sequence[tuple[int, int]]) -> int:
    """Block RAMs of these shapes for each memory of the field, at ``precision`` bits.

    >>> field_rams_a_memory(60, 60, 127, [(16384, 1), (1024, 18)])
    6
    """
    words = field_plane(rows, columns) * (precision + 1)
    return -(-words // max((depth for depth, _ in shapes), default=1))


NODE_FLIP_FLOPS = published.NODE.flip_flops
NODE_LUT4 = published.NODE.lut4
NODE_SLICES = published.NODE.slices

ARRAY_FLIP_FLOPS = published.BLOCK.flip_flops - NODE_FLIP_FLOPS * published.BLOCK.nodes
ARRAY_LUT4 = published.BLOCK.lut4 - NODE_LUT4 * published.BLOCK.nodes
ARRAY_SLICES = published.BLOCK.slices - NODE_SLICES * published.BLOCK.nodes
PAPER_FAMILIES = "Virtex-II", "Virtex-4"

_GEOMETRY = {
    each.__name__: each for each in (border_rams, cluster_count, digits, field_plane, field_rams_a_memory, tree_widths)
}
ARRAY, DIGITS, ALONE = (CountedLaws("harmonic", name, _GEOMETRY) for name in ("array", "digits", "alone"))
"""The logic of the array with its control, bit-serial and with digits of several bits, and of a decision module by
itself."""


@dataclass(frozen=True)
class Machine:
    """The variables that the resources of the circuit depend on.

    A block of ``rows`` × ``columns`` nodes; ``down`` × ``across`` blocks, where the borders of one block alone have no
    memories; ``last``: the precision of the last of ``stages`` stages; whether it has its decision module;
    ``digit_bits``: bits of every value a cycle.
    """

    rows: int
    columns: int
    last: int
    decision: bool = True
    down: int = 2
    across: int = 2
    pipeline: int = 0
    stages: int = 1
    digit_bits: int = 1

    @property
    def block(self) -> tuple[int, int]:
        """Rows and columns of a block."""
        return self.rows, self.columns

    @property
    def variables(self) -> Mapping[str, int]:
        """The parameters of the top module."""
        return {
            "ROWS": self.rows,
            "COLUMNS": self.columns,
            "DOWN": self.down,
            "ACROSS": self.across,
            "LAST_PRECISION": self.last,
            "STAGES": self.stages,
            "DECISION": int(self.decision),
            "DIGIT_BITS": self.digit_bits,
            "PIPELINE": self.pipeline,
        }

    def of_paper(self, family: str) -> bool:
        """True if it is the published design, on a family of parts that it was published for."""
        return not self.pipeline and self.digit_bits == 1 and family in PAPER_FAMILIES


def decision_slices(precision: int) -> int:
    """Slices of the decision module, 3p + 682 (section 5.4)."""
    return published.DECISION_SLICES_A_BIT * precision + published.DECISION_SLICES


def _slices_a_border_node() -> float:
    """The rest of 99.4 % of an XC2V6000 for each of the 204 border nodes of the 36×66 block, all else by its own law.

    About 1.9. With clusters at the 235 slices of Table 2 in place of 13N + 10 it is 1.3.
    """
    # Section 5.4, solved for x: 0.994 · 33,792 = (13N + 10) + 844 + (3 · 255 + 682) + 10 + 204x with N = 36 · 66.
    rows, columns = published.WHOLE_DESIGN_ROWS, published.WHOLE_DESIGN_COLUMNS
    listed = (
        NODE_SLICES * rows * columns
        + ARRAY_SLICES
        + published.CONTROL_SLICES
        + decision_slices(published.WHOLE_DESIGN_PRECISION)
        + published.ADDRESS_SLICES
    )
    return (published.WHOLE_DESIGN_SHARE * published.SLICES_OF_XC2V6000 - listed) / border_nodes(rows, columns)


SLICES_A_BORDER_NODE = _slices_a_border_node()


def border_slices(rows: int, columns: int) -> int:
    """Slices of the border nodes, without their addresses; calibrated on one published row."""
    return math.floor(SLICES_A_BORDER_NODE * border_nodes(rows, columns))


@lru_cache(maxsize=4096)
def items(machine: Machine, family: str) -> tuple[Line, ...]:
    """The demand of a design on a family of parts."""
    rows, columns = machine.block
    lines = _of_paper(machine, family) if machine.of_paper(family) else _of_rows(machine, family)
    each = f"{PAPER}, section 5.4: one a cluster", Status.PUBLISHED
    sides = f"RTL of this package, hwsw verify: each side by itself; {PAPER}, section 5.4 has 12 for 36×66"
    bits = machine.digit_bits
    if bits > 1:
        each = (f"RTL of this package, hwsw verify: {bits} a cluster, one for each bit of a digit", Status.MEASURED)
        sides = f"RTL of this package, hwsw verify: each side by itself, {bits} for one of a bit-serial node"
    clusters, borders = cluster_count(rows, columns), border_rams(rows, columns, machine.down, machine.across)
    rams = (
        Line.item("clusters", "block_rams", bits * clusters, each[1], each[0]),
        Line.item("borders", "block_rams", bits * borders, Status.MEASURED, sides),
    )
    return tuple(line for line in (*lines, *rams) if machine.decision or line.name != "decision")


def _of_rows(machine: Machine, family: str) -> list[Line]:
    """Every line as synthesis counts it."""
    laws = ARRAY if machine.digit_bits == 1 else DIGITS
    pieces = laws.lines(machine.variables, laws.family(family))
    return [line for logic in pieces.values() for line in (packed(logic), *logic)]


def _of_paper(machine: Machine, family: str) -> list[Line]:
    """Slices, and nodes with their array, as published. Its clusters are in the nodes; Table 3 has no OR trees."""
    nodes = machine.rows * machine.columns
    table_1, table_3 = f"{PAPER}, Table 1, a node", f"{PAPER}, Table 3, less the nodes of Table 1"
    text = f"{PAPER}, section 5.4"
    border = f"{text}: what 99.4 % of an XC2V6000 leaves, {SLICES_A_BORDER_NODE:.2f} slices a border node"
    shown, calibrated = Status.PUBLISHED, Status.CALIBRATED
    laws = (
        ("nodes", "slices", NODE_SLICES * nodes, shown, table_1),
        ("array control", "slices", ARRAY_SLICES, calibrated, table_3),
        ("borders", "slices", border_slices(*machine.block), calibrated, border),
        ("border addresses", "slices", published.ADDRESS_SLICES, shown, f"{text}: around 10"),
        ("control", "slices", published.CONTROL_SLICES, shown, text),
        ("decision", "slices", decision_slices(machine.last), shown, f"{text}: 3p + 682"),
        ("nodes", "lut4", NODE_LUT4 * nodes, shown, table_1),
        ("array control", "lut4", ARRAY_LUT4, calibrated, table_3),
        ("nodes", "flip_flops", NODE_FLIP_FLOPS * nodes, shown, table_1),
        ("array control", "flip_flops", ARRAY_FLIP_FLOPS, calibrated, table_3),
    )
    beside = "OR trees", "borders", "border addresses", "control", "decision"
    logic = ARRAY.lines(machine.variables, ARRAY.family(family), *beside).values()
    return [*(Line.item(*line) for line in laws), *(line for piece in logic for line in piece)]


@lru_cache(maxsize=4096)
def totals(machine: Machine, family: str) -> Mapping[str, int]:
    """The demand by resource, without its items; see ``items``."""
    return sum_by_resource(items(machine, family))


def word_depth(part: Part) -> int:
    """Words of a block RAM of the part at 18 bits a word, for a cluster; 0: no block RAM is so wide."""
    return max((depth for depth, width in part.block_ram_shapes if width >= RAM_WIDTH), default=0)


def words(blocks: int, precision: int, digit_bits: int = 1) -> int:
    """Words in every cluster and border RAM: p bits and a flag for each block (section 5.2).

    With digits of d bits, a RAM for each bit of a digit has ⌈p/d⌉ + 1 words for each block.
    """
    # address  0 .. p            p + 1 .. 2p + 1     ..
    #          flag and p bits   flag and p bits     ..     of blocks 0, 1, ..; each word a bit of the 18 nodes
    return blocks * (digits(precision, digit_bits) + 1)


def largest_precision(blocks: int, depth: int, digit_bits: int = 1) -> int:
    """The highest p with blocks × (⌈p/d⌉ + 1) ≤ ``depth``, of those that a plan can have; below 1 where none fits.

    >>> largest_precision(16, 1024), largest_precision(4, 1024), largest_precision(4, 1024, 8)
    (63, 255, 1023)
    """
    return min(digit_bits * (depth // blocks - 1), MAX_PRECISION)


# The levers that make a design fit, each with a computed value.

Shape = tuple[int, int]
Precisions = tuple[int, ...]


def block_count(map_shape: Shape, block: Shape) -> int:
    """Blocks that cover a map, partial ones counted."""
    return -(-map_shape[0] // block[0]) * -(-map_shape[1] // block[1])


def fits(machine: Machine, part: Part) -> bool:
    """True if the part has the resources for such a block."""
    return not _short(machine, part)


def _short(machine: Machine, part: Part) -> list[str]:
    """The resources that the part has too few of."""
    budgets = part.resources
    needs = totals(machine, part.family).items()
    return [kind for kind, need in needs if kind in budgets and need > budgets[kind].value]


def largest_block(machine: Machine, part: Part) -> Shape | None:
    """The largest block of about the same proportions, up to the block of ``machine``, that fits the part with borders.

    None if not even one node fits. Demand never falls as a block grows.
    """
    blocks = [_scaled(machine.block, rows) for rows in range(1, machine.rows + 1)]
    return largest(blocks, lambda block: fits(_with_block(machine, block), part))


def _with_block(machine: Machine, block: Shape) -> Machine:
    """The machine with another block, one of several."""
    return replace(machine, rows=block[0], columns=block[1], down=2, across=2)


def resource_levers(
    map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int
) -> dict[str, tuple[Lever, ...]]:
    """Levers for each resource that the part lacks: block, precision, another place for ``decide``, part."""
    short = _short(machine, part)
    if not short:
        return {}
    need = totals(machine, part.family)
    shared = _block_lever(map_shape, machine, precisions, part, depth)
    without = totals(replace(machine, decision=False), part.family)
    by_kind: dict[str, tuple[Lever, ...]] = {}
    for kind in (kind for kind in part.resources if kind in short):
        levers, limit = [shared], part.resources[kind].value
        if kind == "slices" and machine.decision and machine.of_paper(part.family):
            last = _last_within(machine, part, limit)
            if last is not None:
                levers.append(
                    Lever(
                        "relax.schedule",
                        f"end at {last} bits or less (3 slices of the decision module a bit)",
                        {"schedule": _ending(precisions, last)},
                    )
                )
        if machine.decision and without[kind] <= limit:
            spared = f"{need[kind] - without[kind]:,} {label(kind)} of the decision module are spared"
            levers.append(Lever("decide.component", f"another component: {spared}"))
        levers.append(part_lever(kind, need[kind]))
        by_kind[kind] = tuple(levers)
    return by_kind


def _last_within(machine: Machine, part: Part, slices: float) -> int | None:
    """The last precision below the machine's that so many slices hold."""

    def fits(last: int) -> bool:
        return totals(replace(machine, last=last), part.family)["slices"] <= slices

    return largest(range(1, machine.last), fits)


def word_depth_bound(map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int) -> Line:
    """blocks × (p + 1) ≤ words of a block RAM (section 5.4), with levers where the bound is broken."""
    demand = words(block_count(map_shape, machine.block), machine.last, machine.digit_bits)
    return Line.bound(
        name="words of a block RAM",
        demand=demand,
        limit=depth,
        unit="words",
        status=Status.PUBLISHED,
        source="Girau et al. 2008, section 5.4: p bits and a flag for each block, in RAMs of 1K × 18",
        levers=() if demand <= depth else _depth_levers(map_shape, machine, precisions, part, depth),
    )


def _depth_levers(
    map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int
) -> tuple[Lever, ...]:
    precision = machine.last
    blocks = block_count(map_shape, machine.block)
    levers = []
    last = largest_precision(blocks, depth, machine.digit_bits)
    if last >= 1:
        advice = f"end at {last} bits or less with {_counted(blocks)}"
        levers.append(Lever("relax.schedule", advice, {"schedule": _ending(precisions, last)}))
    levers += _larger_block(map_shape, machine, precisions, part, depth)
    levers.append(
        Lever(
            "part",
            f"take one with block RAMs of {words(blocks, precision, machine.digit_bits):,} words of {RAM_WIDTH} bits",
        )
    )
    return tuple(levers)


def _block_lever(map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int) -> Lever:
    smaller = largest_block(_with_block(machine, _clipped(machine.block, map_shape)), part)
    if smaller is None:
        return Lever("relax.block", f"no block fits {part.name}: what stands beside it is too large")
    blocks = block_count(map_shape, smaller)
    last = largest_precision(blocks, depth, machine.digit_bits)
    allowed = f"precision up to {last}" if last >= 1 else "too many for any precision"
    advice = f"at most {smaller[0]} × {smaller[1]} in these proportions fits {part.name}"
    changes = _block_changes(smaller, precisions, last) if last >= 1 else {}
    return Lever("relax.block", f"{advice}: {_counted(blocks)}, {allowed}", changes)


def _larger_block(
    map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int
) -> tuple[Lever, ...]:
    """The smallest larger block with words that fit, or else the precision of the largest block of the part."""
    block, precision = machine.block, machine.last
    covering = max(map_shape[0], -(-map_shape[1] * block[0] // block[1]))
    widest = largest_block(_with_block(machine, _scaled(block, covering)), part)
    if widest is None:
        return ()
    for rows in range(block[0] + 1, widest[0] + 1):
        shape = _clipped(_scaled(block, rows), map_shape)
        blocks = block_count(map_shape, shape)
        if words(blocks, precision, machine.digit_bits) <= depth:
            advice = f"{shape[0]} × {shape[1]} makes {_counted(blocks)}, and fits {part.name}"
            return (Lever("relax.block", advice, _block_changes(shape, precisions, precision)),)
    widest = _clipped(widest, map_shape)
    blocks = block_count(map_shape, widest)
    last = largest_precision(blocks, depth, machine.digit_bits)
    if last < 1 or blocks >= block_count(map_shape, block):
        return ()
    advice = (
        f"{widest[0]} × {widest[1]}, the largest in these proportions that fits {part.name},"
        f" makes {_counted(blocks)}: precision up to {last}"
    )
    return (Lever("relax.block", advice, _block_changes(widest, precisions, last)),)


def _ending(precisions: Precisions, last: int) -> list[int]:
    """A schedule that ends at ``last`` bits, or where it ended before."""
    return list(precisions) if last >= precisions[-1] else [*(each for each in precisions if each < last), last]


def _block_changes(block: Shape, precisions: Precisions, last: int) -> dict[str, Any]:
    """The parameters of a block with the precisions that its words allow."""
    return {"block": list(block), "blocks": None, "schedule": _ending(precisions, last)}


def _clipped(block: Shape, map_shape: Shape) -> Shape:
    return min(block[0], map_shape[0]), min(block[1], map_shape[1])


def _counted(blocks: int) -> str:
    return "1 block" if blocks == 1 else f"{blocks} blocks"


def _scaled(block: Shape, rows: int) -> Shape:
    """The block with ``rows`` rows and columns in proportion, at least one."""
    return rows, max(1, rows * block[1] // block[0])
