"""Gradient descent search (section V): from cell to cell, each time to the lowest neighbour, down to a goal."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, outside_map
from codesign.maps.reach import check_cells, reachable

STEPS = ((-1, 0), (0, 1), (1, 0), (0, -1), (-1, 1), (1, 1), (1, -1), (-1, -1))
"""North, east, south, west, then the diagonals. The first of equal neighbours in this order is taken."""


class Ending(StrEnum):
    """The end of a descent: at a goal; where no neighbour is lower; or at its start, as no path joins it to a goal."""

    GOAL = "goal"
    FLAT = "flat"
    UNREACHABLE = "unreachable"


@dataclass(frozen=True, eq=False)
class Descent:
    """A path from a start.

    ``cells``: int64 n × 2, (row, column), start first. ``ending``: the reason of its end. ``length``: in cells, √2 for
    a diagonal step.
    """

    cells: NDArray[np.int64]
    ending: Ending

    @property
    def arrived(self) -> bool:
        """True if it ends at a goal."""
        return self.ending is Ending.GOAL

    @property
    def length(self) -> float:
        """Length in cells."""
        return float(np.sqrt((np.diff(self.cells, axis=0) ** 2).sum(axis=1)).sum())


class Search:
    """A potential prepared for descents: the lowest neighbour of every cell, computed once.

    A step never enters an obstacle, and never cuts a corner: a diagonal step needs both cells beside it free. Values
    fall strictly along a path, so it enters no cell twice and ends.

    Args:
        potential: float64, rows × columns. free: bool of that shape. goals: (row, column) pairs on free cells.
        neighbours: 8, or 4 for steps along rows and columns only. The paper does not say which it takes.
        upwards: look for the highest instead (``Boundary.HIGH_GOAL``).

    Raises:
        MapError: the map or a goal cannot be used. InputError: another argument cannot be used.
    """

    def __init__(
        self,
        potential: NDArray[np.float64],
        free: NDArray[np.bool_],
        goals: Sequence[tuple[int, int]],
        *,
        neighbours: int = 8,
        upwards: bool = False,
    ) -> None:
        cells = check_cells(free, goals)
        if potential.shape != free.shape or potential.dtype != np.float64:
            what = f"a potential of {potential.dtype} {potential.shape} for a map of {free.shape}"
            raise InputError(what, "potential", "give what solve returned for this map")
        if neighbours not in {4, 8}:
            raise InputError(f"{neighbours!r} neighbours", "neighbours", "give 4 or 8")
        self.free = free
        self.goal = np.zeros(free.shape, np.bool_)
        self.goal[cells[:, 0], cells[:, 1]] = True
        self.reachable = reachable(free, goals)
        self.best = _lowest(-potential if upwards else potential, free, neighbours)

    def follow(self, start: tuple[int, int]) -> Descent:
        """The path from ``start``. Raises InputError if ``start`` is no free cell of the map."""
        row, column = self._check_start(start)
        if not self.reachable[row, column]:
            return Descent(np.array([(row, column)], np.int64), Ending.UNREACHABLE)
        cells = [(row, column)]
        while not self.goal[row, column] and self.best[row, column] >= 0:
            down, right = STEPS[self.best[row, column]]
            row, column = row + down, column + right
            cells.append((row, column))
        ending = Ending.GOAL if self.goal[row, column] else Ending.FLAT
        return Descent(np.array(cells, np.int64), ending)

    def flat(self) -> NDArray[np.bool_]:
        """Bool rows × columns: reachable cells, goals left out, with no lower neighbour."""
        return np.asarray(self.reachable & ~self.goal & (self.best < 0))

    def arriving(self) -> NDArray[np.bool_]:
        """Bool rows × columns: reachable cells with a path that ends at a goal (goals included).

        Every cell points at its lowest neighbour, then at the target of its target, and so on: cells × log cells.
        """
        offsets = np.array([down * self.free.shape[1] + right for down, right in STEPS] + [0])
        ends_here = self.goal.ravel()
        target = np.arange(self.best.size) + np.where(ends_here, 0, offsets[self.best.ravel()])
        while True:
            further = target[target]
            if np.array_equal(further, target):
                break
            target = further
        return np.asarray(ends_here[target].reshape(self.free.shape) & self.reachable)

    def _check_start(self, start: tuple[int, int]) -> tuple[int, int]:
        try:
            row, column = (operator.index(value) for value in start)
        except (TypeError, ValueError):
            raise InputError(f"start {start!r:.80} is not a cell", "start", "give (row, column)") from None
        rows, columns = self.free.shape
        if not (0 <= row < rows and 0 <= column < columns):
            what, hint = outside_map((row, column), self.free.shape, "start")
            raise InputError(what, "start", hint)
        if not self.free[row, column]:
            raise InputError(f"start ({row}, {column}) is on an obstacle", "start", "move it to a free cell")
        return row, column


def descend(
    potential: NDArray[np.float64],
    free: NDArray[np.bool_],
    goals: Sequence[tuple[int, int]],
    start: tuple[int, int],
    *,
    neighbours: int = 8,
    upwards: bool = False,
) -> Descent:
    """One path down a potential; ``Search`` serves for several."""
    return Search(potential, free, goals, neighbours=neighbours, upwards=upwards).follow(start)


def _lowest(potential: NDArray[np.float64], free: NDArray[np.bool_], neighbours: int) -> NDArray[np.int8]:
    """Int8 rows × columns: index into ``STEPS`` of the lowest strictly lower neighbour, -1 where there is none."""
    open_cells = np.pad(free, 1)
    values = np.full(open_cells.shape, math.inf)
    values[1:-1, 1:-1][free] = potential[free]
    lowest = np.where(free, potential, -math.inf)
    best = np.full(free.shape, -1, np.int8)
    for index, (down, right) in enumerate(STEPS[:neighbours]):
        there = _shifted(values, down, right)
        lower = there < lowest
        if down and right:
            lower &= _shifted(open_cells, down, 0) & _shifted(open_cells, 0, right)
        best[lower] = index
        lowest[lower] = there[lower]
    return best


def _shifted(padded: NDArray[Any], down: int, right: int) -> NDArray[Any]:
    rows, columns = padded.shape
    return padded[1 + down : rows - 1 + down, 1 + right : columns - 1 + right]
