"""The demand of the arrays: nodes, memories, read-out, tracker and control.

Flip-flops and memories follow from the sizes exactly. LUT are what synthesis counts of the RTL of this
package, by family: sums of terms of the sizes, fitted to some arrays and held against others
(``planners/wavefront/measured/laws.yaml``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from codesign.ground.figures import Status
from codesign.ground.models import Part
from codesign.planners.breadth_first.styles.resources import block_rams
from codesign.planners.counted import CountedLaws, index_bits
from codesign.planners.job import Line
from codesign.planners.wavefront import published
from codesign.planners.wavefront.published import PAPER

# The sizes that decide what an array takes, and what follows from them exactly: flip-flops and memories.
#
# Both are counted in the Verilog of this package register by register. Synthesis finds the same in every row of
# ``planners/wavefront/measured/resources.json``.

Shape = tuple[int, int]

DRIVEN_BITS = 16
"""Of the counters of load words and of tracked steps."""
TRACKER_BITS = 11
"""Of a tracker: the slot (4), the side of the best neighbour (3), whether there is one, on the map (2), the start."""
STATE_BITS = 3


@dataclass(frozen=True)
class ArrayLayout:
    """The sizes that decide the demand of an array.

    - ``shape``: rows and columns of cells. ``bits``: of a register. ``obstacle_bits``: of a second register for p^d, 0:
      none. ``line``: flip-flops of the delay line. ``extra``: flip-flops of the longer line of penalised nodes.
    - ``adders``: nodes of adders and comparators. ``element_cells``: cells that share one node.
    - ``safe``: a wave from the obstacles comes first. ``chain``: registers are read out by a chain.
    - ``waits``: the wave ends at a start. ``tracked``: the path is tracked beside the array; ``local``: some steps of
      it.
    """

    shape: Shape
    bits: int
    obstacle_bits: int = 0
    line: int = published.DELAY_ELEMENTS
    extra: int = 0
    corner_cutting: bool = True
    adders: bool = False
    element_cells: int = 1
    safe: bool = False
    chain: bool = False
    waits: bool = True
    tracked: bool = True
    local: bool = True

    @classmethod
    def of_row(cls, variables: Mapping[str, int]) -> ArrayLayout:
        """The layout of a circuit, by the parameters of its top module; of an array of one tile, of the map."""
        return cls(
            shape=(variables["ROWS"], variables["COLUMNS"]),
            bits=variables["BITS"],
            obstacle_bits=variables["OBSTACLE_BITS"],
            line=variables["DIAGONAL"],
            extra=variables["EXTRA"],
            corner_cutting=bool(variables["CORNER_CUTTING"]),
            adders=variables.get("STYLE") == 1,
            element_cells=variables.get("ELEMENT_CELLS", 1),
            safe=bool(variables["SAFE"]),
            chain=bool(variables.get("CHAIN")),
            waits=bool(variables["WAITS"]),
            tracked=bool(variables["TRACK"]),
            local=variables["MOST_STEPS"] > 0,
        )

    @property
    def shared(self) -> bool:
        """True if an element serves several cells."""
        return self.element_cells > 1

    @property
    def down(self) -> int:
        """Rows of nodes or of elements."""
        return -(-self.shape[0] // self.element_cells)

    @property
    def nodes(self) -> int:
        """Nodes of the array, or elements."""
        return self.down * self.shape[1]

    @property
    def flags(self) -> int:
        """F and Z, and P where nodes may be penalised."""
        return 3 if self.extra else 2

    @property
    def word(self) -> int:
        """Bits of a word of the read-out: the registers, F where a path needs it, P."""
        return self.bits + self.obstacle_bits + (not self.corner_cutting) + bool(self.extra)

    @property
    def address(self) -> int:
        """Bits of a row and of a column."""
        return index_bits(self.shape[0]) + index_bits(self.shape[1])

    @property
    def counter(self) -> int:
        """Bits of the counter of the wave; adders have none."""
        return 0 if self.adders else max(self.bits, self.obstacle_bits)

    @property
    def distance_bits(self) -> int:
        """Bits of p^d that the tracker compares."""
        return 0 if not self.safe else self.bits if self.chain else self.obstacle_bits

    @property
    def memories(self) -> tuple[int, tuple[tuple[int, int], ...]]:
        """The number of equal sets of memories, and (words, bits a word) of each memory of a set.

        An element keeps line, registers and flags of its cells in a memory. A chain fills a memory for the tracker, and
        one more with p^d.
        """
        if self.shared:
            state = self.bits + self.obstacle_bits + self.flags + self.line + self.extra
            return self.nodes, ((self.element_cells, state),)
        if not (self.chain and self.tracked):
            return 0, ()
        words = max(2, self.shape[0]) << index_bits(self.shape[1])
        return 1, ((words, self.word), *(((words, self.bits),) if self.safe else ()))

    @property
    def node_flip_flops(self) -> int:
        """Flip-flops of a node, or of an element.

        A node has its line, the longer line, F, Z, P and the registers. An element has the flags that are loaded and
        rings of y and of F over its cells: the rest is in its memory.

        >>> ArrayLayout((256, 256), 11).node_flip_flops, ArrayLayout((256, 256), 11, adders=True).node_flip_flops
        (16, 13)
        """
        if self.shared:
            rings = 1 if self.corner_cutting else 2
            return self.flags + rings * self.element_cells + 2
        line = 0 if self.adders else self.line + self.extra
        return line + self.flags + self.bits + self.obstacle_bits

    @property
    def tracker_flip_flops(self) -> int:
        """Flip-flops of the tracker: two potentials, a cell, the state; p^d, F of four neighbours, P of two cells.

        A safe path does not ask for P.
        """
        if not self.tracked:
            return 0
        return (
            2 * self.bits
            + self.distance_bits
            + self.address
            + TRACKER_BITS
            + (DRIVEN_BITS if self.local else 0)
            + (0 if self.corner_cutting else 4)
            + (2 if self.extra and not self.safe else 0)
        )

    @property
    def control_flip_flops(self) -> int:
        """Flip-flops of all else: states, counter, loader, the cells of start and scan, read-out and report."""
        states = STATE_BITS + (self.adders or (self.safe and self.chain))
        # The cells of start and scan, and the selected one but of elements.
        loader = 1 + DRIVEN_BITS + (2 if self.shared else 3) * self.address
        report = 0 if self.chain else self.word + 5
        elements = 0
        if self.shared:
            turn = index_bits(self.element_cells)
            down = max(0, index_bits(self.shape[0]) - turn)
            # The loader's words and its two edges more, the turn, the address of the read-out, the end of a step.
            elements = 1 + DRIVEN_BITS + 1 + turn + down + index_bits(self.shape[1]) + 1
        return states + self.counter + loader + report + elements


NODES, MEMORIES, READ_OUT, TRACKER, CONTROL = "nodes", "memories", "read-out", "tracker", "control"


LAWS = CountedLaws("wavefront", "array", {"side_bits": index_bits}, ArrayLayout.of_row)
"""The LUT of each piece, of an ``ArrayLayout``."""


def lut4(piece: str, layout: ArrayLayout, family: str) -> int:
    """LUT of a piece in a family of rows.

    >>> layout = ArrayLayout((256, 256), 11)
    >>> lut4("nodes", layout, "ecp5") / layout.nodes
    5.0
    """
    return round(LAWS.value(piece, "lut4", layout, family))


def flip_flops(piece: str, layout: ArrayLayout) -> int:
    """Flip-flops of a piece, exact."""
    counts = {
        NODES: layout.nodes * layout.node_flip_flops,
        TRACKER: layout.tracker_flip_flops,
        CONTROL: layout.control_flip_flops,
    }
    return counts.get(piece, 0)


def node_slices(layout: ArrayLayout, part: Part) -> int:
    """Slices of a node of two LUT and two flip-flops each, not shared with other nodes."""
    family, _ = LAWS.family(part.family)
    return -(-max(round(lut4(NODES, layout, family) / layout.nodes), layout.node_flip_flops) // 2)


def array_items(layout: ArrayLayout, part: Part) -> tuple[Line, ...]:
    """The demand of an array for a map: nodes, memories, read-out, tracker, control.

    A slice has two LUT and two flip-flops. Nodes share none; the read-out also takes the LUT that they leave.
    """
    pieces = [piece for piece in (NODES, READ_OUT, TRACKER, CONTROL) if piece != TRACKER or layout.tracked]
    luts = {piece: line for piece, (line,) in LAWS.lines(layout, LAWS.family(part.family), *pieces).items()}
    slices, *least_and_most = (
        _slices(layout, counts)
        for counts in (
            {piece: line.amount for piece, line in luts.items()},
            *({piece: int(line.figure.interval[end]) for piece, line in luts.items()} for end in (0, 1)),
        )
    )
    lines = []
    for piece in pieces:
        packed = "two LUT and two flip-flops a slice, none shared by nodes"
        of_slices = min(each[piece] for each in least_and_most), max(each[piece] for each in least_and_most)
        lines.append(Line.item(piece, "slices", slices[piece], Status.ASSUMED, packed, of_slices))
        lines.append(luts[piece])
        if registers := flip_flops(piece, layout):
            exact = "every register of the RTL of this package, as synthesis counts them"
            exact += f"; {PAPER}, Figure 2 has one less a node: Z" * (piece == NODES and not layout.adders)
            lines.append(Line.item(piece, "flip_flops", registers, Status.MEASURED, exact))
    return (*lines, *_memory_items(layout, part))


def _slices(layout: ArrayLayout, luts: Mapping[str, int]) -> dict[str, int]:
    slices = {piece: -(-max(count, flip_flops(piece, layout)) // 2) for piece, count in luts.items()}
    each = max(round(luts[NODES] / layout.nodes), layout.node_flip_flops)
    slices[NODES] = layout.nodes * -(-each // 2)
    slices[READ_OUT] = max(0, -(-(luts[NODES] + luts[READ_OUT]) // 2) - slices[NODES])
    return slices


def _memory_items(layout: ArrayLayout, part: Part) -> tuple[Line, ...]:
    sets, shapes = layout.memories
    if not sets:
        return ()
    rams = sets * sum(block_rams(words, width, part) for words, width in shapes)
    of = " and ".join(f"{words:,} words of {width} bits" for words, width in shapes)
    law = f"{sets:,} × {of}, as synthesis counts the RTL of this package"
    return (Line.item(MEMORIES, "block_rams", rams, Status.MEASURED, law),)
