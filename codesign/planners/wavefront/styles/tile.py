"""The demand of an array of one tile: its nodes and the cells around it, the memories of its columns, a scheduler.

Flip-flops and memories follow from the sizes exactly, register by register of the RTL of this package. LUT are fitted
to its syntheses by family, as the LUT of the other arrays are (``resources``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

from codesign.ground.figures import Status
from codesign.ground.models import Part
from codesign.planners.breadth_first.styles.resources import block_rams
from codesign.planners.counted import CountedLaws, index_bits
from codesign.planners.job import Line
from codesign.planners.wavefront.styles import resources
from codesign.planners.wavefront.styles.resources import CONTROL, NODES, READ_OUT, TRACKER, ArrayLayout, Shape

HALO, COLUMNS, SCHEDULER, CURSOR = "halo", "column memories", "scheduler", "cursor"
PIECES = NODES, HALO, COLUMNS, SCHEDULER, TRACKER, CURSOR, READ_OUT, CONTROL

HALO_BITS = 3
"""Flip-flops of a cell around the tile beside its potential: free, live, y."""
SCAN_BITS = 14
"""Of a scan: settling (4), walked, its stages (5), and which edges of the map the visited tile lies at (4)."""
SIDES = 8
"""Tiles around a tile, each with the earliest change that it sees."""
LEAST_SHIFT = 3
"""Flip-flops in a row that a Xilinx part has as a shift register of a LUT."""
STATES = 10
"""Of the machine, a flip-flop each. Only an array that tracks paths has the one of the tracking."""
MACHINE_BITS = 31
"""Of the machine beside its states and the words of ``TileLayout.control_flip_flops``.

Loader (4) and its counter (8), the sweeps of a visit (3), what an arriving word is for (11), the report (5).
"""


@dataclass(frozen=True)
class TileLayout:
    """The sizes of an array of one tile.

    ``array``: of its nodes, so its shape is the tile; ``waits``: the potential of a start ends the visits.
    """

    array: ArrayLayout
    map_shape: Shape

    @classmethod
    def of_row(cls, variables: Mapping[str, int]) -> TileLayout:
        """The layout of a circuit, by the parameters of its top module."""
        whole = ArrayLayout.of_row(variables)
        tile = variables["TILE_ROWS"], variables["TILE_COLUMNS"]
        return cls(replace(whole, shape=tile), whole.shape)

    @property
    def whole(self) -> ArrayLayout:
        """The layout of an array for the whole map with the same words: it has the same tracker."""
        return replace(self.array, shape=self.map_shape)

    @property
    def tiles(self) -> tuple[int, int]:
        """Tiles down and across."""
        rows, columns = self.array.shape
        return -(-self.map_shape[0] // rows), -(-self.map_shape[1] // columns)

    @property
    def words(self) -> int:
        """Words of the memory of a column."""
        down, across = self.tiles
        return down * across * self.array.shape[0]

    @property
    def address(self) -> int:
        """Bits of the address of such a word."""
        return index_bits(self.words)

    @property
    def place(self) -> int:
        """Bits of a column of the tile."""
        return index_bits(self.array.shape[1])

    @property
    def grid(self) -> int:
        """Bits of the number of a tile, of its row and of its column, which hold the numbers of tiles themselves."""
        down, across = self.tiles
        return index_bits(down * across) + down.bit_length() + across.bit_length()

    @property
    def minima(self) -> tuple[int, ...]:
        """Comparators of each level of the tree that finds the earliest change of a row."""
        columns = self.array.shape[1]
        return tuple(-(-columns // (1 << level)) for level in range(1, (columns - 1).bit_length() + 1))

    @property
    def halo(self) -> int:
        """Cells around the tile, corners included: the wave enters diagonally as well."""
        #   + - - - +        a cell around the tile holds the potential that its own tile gave it, and emits when the
        #   |       |        counter comes to it
        #   + - - - +
        rows, columns = self.array.shape
        return 2 * (rows + columns) + 4

    @property
    def memory_bits(self) -> int:
        """Bits of a word of a column's memory: potential, F, P."""
        return self.array.bits + 1 + bool(self.array.extra)

    @property
    def memories(self) -> Mapping[str, tuple[int, int, int]]:
        """The number of memories, and words and bits a word of each: columns, scheduler.

        Safe paths have p^d in memories of their own, and need a bit more of each tile.
        """
        columns, bits, safe = self.array.shape[1], self.array.bits, self.array.safe
        down, across = self.tiles
        words = max(2, self.words)
        shapes = {"potentials": (columns, words, self.memory_bits)}
        if safe:
            shapes["obstacle potentials"] = columns, words, bits + 1
        shapes[SCHEDULER] = 1, max(2, down * across), 2 * bits + 1 + safe
        return shapes

    def rams(self, part: Part) -> dict[str, int]:
        """Block RAMs of the columns and of the scheduler."""
        rams = {what: n * block_rams(words, bits, part) for what, (n, words, bits) in self.memories.items()}
        scheduler = rams.pop(SCHEDULER)
        return {COLUMNS: sum(rams.values()), SCHEDULER: scheduler}

    def flip_flops(self, family: str) -> dict[str, int]:
        """Flip-flops of every piece that has some, exact, in a family of rows.

        On Xilinx parts two lines of the tree become shift registers of LUT where they are long enough.
        """
        array, (rows, columns) = self.array, self.array.shape
        # A node keeps no p^d: it goes to the memories too.
        node = replace(array, obstacle_bits=0).node_flip_flops
        of_tile = sum(side.bit_length() for side in self.tiles)
        scan = 4 * (self.grid + self.address) + of_tile + SCAN_BITS + 4 * array.bits
        levels = len(self.minima)
        shifted = levels if family.startswith("xc") and levels >= LEAST_SHIFT else 0
        changes = (columns + sum(self.minima) + SIDES) * array.bits + 1 + 2 * (levels + 1 - shifted)
        return {
            NODES: rows * columns * node,
            HALO: self.halo * (array.bits + HALO_BITS),
            SCHEDULER: scan + changes,
            TRACKER: self.whole.tracker_flip_flops,
            CURSOR: sum(min(2, index_bits(side)) for side in self.map_shape) + self.address + self.place,
            CONTROL: self.control_flip_flops,
        }

    @property
    def control_flip_flops(self) -> int:
        """Flip-flops of the machine: start, loader, rows of a visit, counter, read-out, report."""
        array, across = self.array, self.tiles[1]
        step = (array.shape[0] + 1).bit_length()
        cell = self.whole.address
        # The rows of a tile are ``across`` words apart, so the lowest bits of the loader's address never change.
        still = (across & -across).bit_length() - 1
        states = STATES if array.tracked else STATES - 1
        visits = 2 * step + 4 * self.address - still + 2 * self.place + 2 * cell
        return states + MACHINE_BITS + visits + (2 if array.waits else 1) * array.bits + array.word


LAWS = CountedLaws("wavefront", "tiled", layout=TileLayout.of_row)
"""The LUT of each piece but the tracker, which is the tracker of the array of the whole map."""


@lru_cache(maxsize=2**14)
def lut4(layout: TileLayout, family: tuple[str, bool]) -> Mapping[str, Line]:
    """The LUT of each piece in a family of rows. ``family`` says too if it is the part's own."""
    lines = {**LAWS.lines(layout, family), **resources.LAWS.lines(layout.whole, family, TRACKER)}
    return {piece: lines[piece][0] for piece in PIECES}


def tiled_items(array: ArrayLayout, map_shape: Shape, tile: Shape, part: Part) -> tuple[Line, ...]:
    """The demand of a tile's array with its memories, at the widths of ``array``."""
    layout = TileLayout(replace(array, shape=tile, element_cells=1, adders=False, chain=False), map_shape)
    family = LAWS.family(part.family)
    luts, flip_flops, rams = lut4(layout, family), layout.flip_flops(family[0]), layout.rams(part)
    # Nodes and cells around them share no slice.
    apart = {NODES: layout.array.nodes, HALO: layout.halo}
    lines = []
    for piece in PIECES:
        if piece == TRACKER and not array.tracked:
            continue
        line, registers, each = luts[piece], flip_flops.get(piece, 0), apart.get(piece, 1)
        slices, *least_and_most = (
            each * -(-max(round(count / each), registers // each) // 2)
            for count in (line.amount, *map(int, line.figure.interval))
        )
        packed = "two LUT and two flip-flops a slice, none shared by nodes"
        lines.append(Line.item(piece, "slices", slices, Status.ASSUMED, packed, (least_and_most[0], least_and_most[1])))
        lines.append(line)
        if registers:
            exact = "every register of the RTL of this package, as synthesis counts them"
            lines.append(Line.item(piece, "flip_flops", registers, Status.MEASURED, exact))
        if piece in rams:
            lines.append(Line.item(piece, "block_rams", rams[piece], Status.MEASURED, _words_of(piece, layout)))
    return tuple(lines)


def _words_of(piece: str, layout: TileLayout) -> str:
    shapes = [shape for what, shape in layout.memories.items() if (what == SCHEDULER) == (piece == SCHEDULER)]
    of = " and ".join(f"{count:,} × {words:,} words of {bits} bits" for count, words, bits in shapes)
    return f"{of}, as synthesis counts the RTL of this package"
