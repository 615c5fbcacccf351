"""The sizes that a circuit is built for: its words, and the load stream."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.planners.circuits import Image
from codesign.planners.interface import Problem
from codesign.planners.wavefront.plan.parameters import Paths, PropagateParameters, ReadOut
from codesign.planners.wavefront.plan.plan import problem_map
from codesign.planners.wavefront.plan.wave import longest_distance, register_bits
from codesign.planners.wavefront.styles import timing

OUTSIDE = 0b10
"""F = 0 and Z = 1: a cell of an element that is no cell of the map."""


@dataclass(frozen=True)
class Words:
    """The words of a circuit.

    - ``bits``: of the register. ``obstacle_bits``: of p^d beside it; 0: none. ``longest``: the last p^d.
    - ``extra``: cycles more to enter a penalised cell; 0: none is penalised.
    - ``shows_free``: whether a word of the read-out has F. ``flags``: bits of a cell in the load stream.
    """

    shape: tuple[int, int]
    bits: int
    obstacle_bits: int
    longest: int
    extra: int
    shows_free: bool
    safe: bool
    chain: bool
    element_cells: int

    @classmethod
    def of(cls, problem: Problem, parameters: PropagateParameters, bits: int) -> Words:
        """The words of a design point with registers of ``bits``."""
        longest = longest_distance(problem.shape, parameters.delays)
        safe, chain = parameters.paths is Paths.SAFE, parameters.read_out is ReadOut.CHAIN
        return cls(
            shape=problem.shape,
            bits=bits,
            obstacle_bits=register_bits(longest) if safe and not chain else 0,
            longest=longest,
            extra=0 if parameters.penalty is None else parameters.penalty.delay,
            shows_free=not parameters.corner_cutting,
            safe=safe,
            chain=chain,
            element_cells=parameters.element_cells,
        )

    @property
    def flags(self) -> int:
        """Bits of a cell in the load stream: F, Z, and P where cells may be penalised."""
        return 3 if self.extra else 2

    @property
    def row_bits(self) -> int:
        """Bits of a row."""
        return max(1, (self.shape[0] - 1).bit_length())

    @property
    def column_bits(self) -> int:
        """Bits of a column."""
        return max(1, (self.shape[1] - 1).bit_length())

    @property
    def word(self) -> int:
        """Bits of a word of the read-out: potential, p^d, F, P."""
        return self.bits + self.obstacle_bits + self.shows_free + bool(self.extra)

    @property
    def elements(self) -> tuple[int, int]:
        """Rows and columns of the processing elements."""
        return -(-self.shape[0] // self.element_cells), self.shape[1]

    @property
    def load_cells(self) -> int:
        """Cells of a word of the load stream; on a small map as many as there are, but enough bits for the start."""
        start = -(-(self.row_bits + self.column_bits) // self.flags)
        return min(timing.LOAD_CELLS, max(start, self.elements[0] * self.elements[1]))

    def packed(
        self, potentials: NDArray[np.int64], distances: NDArray[np.int64] | None, problem_flags: NDArray[np.uint8]
    ) -> NDArray[np.uint64]:
        """The words of all cells as they are read out, in raster order."""
        words = potentials.astype(np.uint64).ravel()
        at = np.uint64(self.bits)
        if distances is not None and self.obstacle_bits:
            words |= distances.astype(np.uint64).ravel() << at
            at += np.uint64(self.obstacle_bits)
        flags = problem_flags.astype(np.uint64).ravel()
        if self.shows_free:
            words |= (flags & np.uint64(1)) << at
            at += np.uint64(1)
        if self.extra:
            words |= (flags >> np.uint64(2)) << at
        return words


def cell_flags(problem: Problem, parameters: PropagateParameters) -> NDArray[np.uint8]:
    """F, Z and P of every cell: bits 0, 1 and 2."""
    flags = problem.free.astype(np.uint8)
    flags[tuple(np.array(problem.goals).T)] |= 2
    extra = problem_map(problem, parameters).extra
    if extra is not None:
        flags |= (extra > 0).astype(np.uint8) << np.uint8(2)
    return flags


def load_stream(problem: Problem, parameters: PropagateParameters, words: Words) -> Image:
    """The start, then the map: the words of each row of cells of the elements, the last word first."""
    row, column = problem.starts[0] if problem.starts else (0, 0)
    flags = np.full((words.elements[0] * words.element_cells, words.shape[1]), OUTSIDE, np.uint8)
    flags[: words.shape[0]] = cell_flags(problem, parameters)
    stream = [row | column << words.row_bits]
    for cell in range(words.element_cells):
        stream += _packed_words(flags[cell :: words.element_cells].ravel(), words)
    return Image(words.load_cells * words.flags, stream)


def _packed_words(flags: NDArray[np.uint8], words: Words) -> list[int]:
    """The flags of all elements in words, the last word first."""
    begins = range(0, len(flags), words.load_cells)
    return [packed_flags(flags[begin : begin + words.load_cells], words.flags) for begin in reversed(begins)]


def packed_flags(flags: NDArray[np.uint8], bits: int) -> int:
    """A word of the load stream: ``bits`` a cell, the bits of the first cell lowest."""
    return sum(int(flag) << bits * place for place, flag in enumerate(flags))
