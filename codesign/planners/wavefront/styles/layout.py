"""The sizes that decide what an array takes, and what follows from them exactly: flip-flops and memories.

Both are counted in the Verilog of this package register by register. Synthesis finds the same in every row of
``planners/wavefront/measured/resources.json``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from codesign.planners.wavefront import published

Shape = tuple[int, int]

DRIVEN_BITS = 16
"""Of the counters of load words and of tracked steps."""
TRACKER_BITS = 11
"""Of a tracker: the slot (4), the side of the best neighbour (3), whether there is one, on the map (2), the start."""
STATE_BITS = 3


def side_bits(cells: int) -> int:
    """Bits of a row or of a column."""
    return max(1, (cells - 1).bit_length())


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
        return side_bits(self.shape[0]) + side_bits(self.shape[1])

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
        words = max(2, self.shape[0]) << side_bits(self.shape[1])
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
            turn = side_bits(self.element_cells)
            down = max(0, side_bits(self.shape[0]) - turn)
            # The loader's words and its two edges more, the turn, the address of the read-out, the end of a step.
            elements = 1 + DRIVEN_BITS + 1 + turn + down + side_bits(self.shape[1]) + 1
        return states + self.counter + loader + report + elements
