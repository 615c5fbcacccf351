"""What the circuit of a tiled array is built for: the sizes of its counters and memories, and the load stream."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from codesign.planners.circuits import Image
from codesign.planners.interface import Problem
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.rtl.layout import OUTSIDE, Words, cell_flags, packed_flags
from codesign.planners.wavefront.styles import timing


@dataclass(frozen=True)
class TileWords:
    """The words of the circuit. ``tile``: rows and columns of a tile; ``tiles``: down and across.

    ``start_bits``: of the word that names the start.
    """

    tile: tuple[int, int]
    tiles: tuple[int, int]
    start_bits: int

    @classmethod
    def of(cls, problem: Problem, parameters: PropagateParameters, words: Words) -> TileWords:
        """The words of a design point."""
        tile = parameters.tile_shape(*problem.shape)
        tiles = -(-problem.rows // tile[0]), -(-problem.columns // tile[1])
        bits = words.row_bits + words.column_bits
        return cls(tile, tiles, bits + _bits(tiles[0] * tiles[1] * tile[0]) + _bits(tile[1]))

    @property
    def tile_bits(self) -> int:
        """Bits of the number of a tile."""
        return _bits(self.tiles[0] * self.tiles[1])

    @property
    def words(self) -> int:
        """Words of the memory of a column."""
        return self.tiles[0] * self.tiles[1] * self.tile[0]

    @property
    def load_cells(self) -> int:
        """Cells of a word of the load stream."""
        return min(timing.LOAD_CELLS, self.tile[1])

    def parameters(self) -> dict[str, int]:
        """The Verilog parameters."""
        return {
            "TILE_ROWS": self.tile[0],
            "TILE_COLUMNS": self.tile[1],
            "DOWN": self.tiles[0],
            "ACROSS": self.tiles[1],
            "DOWN_BITS": self.tiles[0].bit_length(),
            "ACROSS_BITS": self.tiles[1].bit_length(),
            "TILE_BITS": self.tile_bits,
            "ADDRESS_BITS": _bits(self.words),
            "PLACE_BITS": _bits(self.tile[1]),
            "STEP_BITS": (self.tile[0] + 1).bit_length(),
            "LEVELS": (self.tile[1] - 1).bit_length(),
        }

    def start_word(self, start: tuple[int, int], words: Words) -> int:
        """The start: its row, its column, its address in the memory of its column, and that column of the tile."""
        row, column = start
        number, place = divmod(column, self.tile[1])
        at = words.row_bits + words.column_bits
        address = row * self.tiles[1] + number
        return row | column << words.row_bits | address << at | place << at + _bits(self.words)


def tile_stream(problem: Problem, parameters: PropagateParameters, words: Words, tile_words: TileWords) -> Image:
    """The start, then the tiles in raster order, each row by row, the leftmost cells of a row first."""
    (rows, columns), (down, across) = tile_words.tile, tile_words.tiles
    flags = np.full((down * rows, across * columns), OUTSIDE, np.uint8)
    flags[: problem.rows, : problem.columns] = cell_flags(problem, parameters)
    stream = [tile_words.start_word(problem.starts[0] if problem.starts else (0, 0), words)]
    chunk = tile_words.load_cells
    in_tiles = flags.reshape(down, rows, across, columns).transpose(0, 2, 1, 3).reshape(-1, columns)
    for row in in_tiles:
        padded = np.concatenate([row, np.full(-columns % chunk, OUTSIDE, np.uint8)])
        stream += [packed_flags(padded[place : place + chunk], words.flags) for place in range(0, columns, chunk)]
    return Image(max(chunk * words.flags, tile_words.start_bits), stream)


def _bits(count: int) -> int:
    """Bits of a number below ``count``, at least one."""
    return max(1, (count - 1).bit_length())
