"""Obstacles that appear, vanish or move: what they are, and random ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError

Cell = tuple[int, int]

SECOND = 10**12
"""Picoseconds."""

SLOWEST, FASTEST = 1 / 3.6e6, SECOND / 2
"""Cells a second that an obstacle may move: one cell in 1000 h, the longest time of a spec, to one in 2 ps."""


def rectangle(top: int, left: int, rows: int, columns: int) -> NDArray[np.int64]:
    """The cells of a rectangle, int64 n × 2, in raster order.

    Raises:
        InputError: no cell.

    >>> rectangle(3, 5, 1, 2).tolist()
    [[3, 5], [3, 6]]
    """
    if rows < 1 or columns < 1:
        raise InputError(f"a rectangle of {rows} × {columns} cells", "rectangle", "give at least 1 × 1")
    offsets = np.argwhere(np.ones((rows, columns), np.bool_))
    cells: NDArray[np.int64] = offsets + np.array((top, left))
    return cells


@dataclass(frozen=True, eq=False)
class Appearing:
    """Cells (int64 n × 2) that become an obstacle at ``at`` (ps) and are free again from ``until`` (ps; None: never).

    Raises:
        InputError: no cell, or ``until`` not after ``at``.
    """

    at: int
    cells: NDArray[np.int64]
    until: int | None = None

    def __post_init__(self) -> None:
        if len(self.cells) == 0 or self.at < 0:
            raise InputError(f"{len(self.cells)} cells that appear at {self.at} ps", "appearing", "1 or more, from 0")
        if self.until is not None and self.until <= self.at:
            raise InputError(
                f"an obstacle from {self.at} ps until {self.until} ps", "appearing.until", "give a later time"
            )
        object.__setattr__(self, "cells", np.unique(np.asarray(self.cells, np.int64), axis=0))


@dataclass(frozen=True)
class Moving:
    """A rectangle that moves cell by cell along its route, to and fro, or around where the route ends as it began.

    A straight step takes ``round(10¹² / speed)`` ps, a diagonal one √2 times as long.

    Attributes:
        size: rows and columns.
        route: cells that its top left cell visits, one or more; between them it keeps to the straight line.
        speed: cells a second.
        begin: ps at which it is there for the first time.

    Raises:
        InputError: a size, a speed or a route that cannot be.
    """

    size: tuple[int, int]
    route: tuple[Cell, ...]
    speed: float
    begin: int = 0

    def __post_init__(self) -> None:
        if min(self.size) < 1 or not self.route or self.begin < 0:
            raise InputError(
                f"an obstacle of {self.size[0]} × {self.size[1]} cells on a route of {len(self.route)} cells from "
                f"{self.begin} ps",
                "moving",
                "give a size of 1 × 1 or more, one cell or more, and a time from 0",
            )
        if not SLOWEST <= self.speed <= FASTEST:
            hint = f"from {SLOWEST:.3g} to {FASTEST:.3g} cells/s: a cell in 1000 h to a cell in 2 ps"
            raise InputError(f"a speed of {self.speed:g} cells/s is out of bounds", "moving.speed", hint)

    @property
    def closed(self) -> bool:
        """True if it goes around."""
        return len(self.route) > 2 and self.route[0] == self.route[-1]

    def path(self) -> list[Cell]:
        """The cells of its top left cell once along the route, both ends included, each next to the one before."""
        cells = [self.route[0]]
        for begin, end in pairwise(self.route):
            cells.extend(_line(begin, end))
        return cells

    def steps(self) -> Iterator[tuple[Cell, int]]:
        """Endless: the next top left cell, and how long (ps) the step to it takes; nothing where it never moves."""
        path = self.path()
        if len(path) < 2:
            return
        straight, diagonal = round(SECOND / self.speed), round(math.sqrt(2.0) * SECOND / self.speed)
        while True:
            for (row, column), (next_row, next_column) in pairwise(path):
                yield ((next_row, next_column), (diagonal if row != next_row and column != next_column else straight))
            if not self.closed:
                path.reverse()


def _line(begin: Cell, end: Cell) -> list[Cell]:
    """Cells after ``begin`` to ``end`` along the straight line, as a king steps (in integers: the same everywhere)."""
    down, along = end[0] - begin[0], end[1] - begin[1]
    count = max(abs(down), abs(along))
    # Rounding halves up, in integers.
    return [
        (begin[0] + (2 * down * step + count) // (2 * count), begin[1] + (2 * along * step + count) // (2 * count))
        for step in range(1, count + 1)
    ]


def random_appearing(
    free: NDArray[np.bool_],
    count: int,
    size: int,
    begin: int,
    end: int,
    seed: int,
    keep_clear: NDArray[np.bool_] | Sequence[Cell] = (),
    *,
    lasting: int | None = None,
) -> list[Appearing]:
    """``count`` squares of ``size`` cells on free cells, each appearing at a random whole picosecond.

    Args:
        free: bool, rows × columns.
        count: how many, 0 or more.
        size: side of each, cells.
        begin, end: ps, the first and the last time possible.
        seed: of ``PCG64([seed])``. Only its raw stream is used, which numpy keeps from version to version.
        keep_clear: cells that none of them covers: (row, column) pairs, or a mask.
        lasting: ps after which each is gone; None: it stays.

    Returns:
        In the order of their times. They may overlap each other.

    Raises:
        InputError: a number out of bounds, or no place for one.
    """
    if count < 0 or size < 1 or not 0 <= begin <= end:
        raise InputError(
            f"{count} obstacles of {size} cells from {begin} ps to {end} ps", "random", "count ≥ 0, size ≥ 1, from ≤ to"
        )
    places = places_of(free, size, keep_clear)
    if count and not len(places):
        raise InputError(
            f"no place for an obstacle of {size} × {size} cells on this map", "random.size", "make it smaller"
        )
    random = np.random.PCG64([seed])
    obstacles = []
    for _ in range(count):
        time = begin + _below(random, end - begin + 1)
        top, left = places[_below(random, len(places))].tolist()
        until = None if lasting is None else time + lasting
        obstacles.append(Appearing(time, rectangle(top, left, size, size), until))
    return sorted(obstacles, key=lambda obstacle: obstacle.at)


def _below(random: np.random.PCG64, bound: int) -> int:
    """A whole number from 0 to below ``bound``, all but equally likely (to 2⁻⁶⁴ × ``bound``)."""
    return int(random.random_raw()) * bound >> 64


def places_of(
    free: NDArray[np.bool_], size: int, keep_clear: NDArray[np.bool_] | Sequence[Cell] = ()
) -> NDArray[np.int64]:
    """Top left cells, int64 n × 2 in raster order, of the squares of ``size`` × ``size`` cells of ``free`` (bool).

    ``keep_clear``: cells that none of them covers: (row, column) pairs, or a mask.
    """
    usable = free.copy()
    if isinstance(keep_clear, np.ndarray):
        usable &= ~keep_clear
    else:
        for row, column in keep_clear:
            usable[row, column] = False
    rows, columns = usable.shape
    if size > min(rows, columns):
        return np.zeros((0, 2), np.int64)
    sums = np.zeros((rows + 1, columns + 1), np.int64)
    sums[1:, 1:] = usable.cumsum(axis=0).cumsum(axis=1)
    inside = sums[size:, size:] - sums[:-size, size:] - sums[size:, :-size] + sums[:-size, :-size]
    return np.argwhere(inside == size * size)
