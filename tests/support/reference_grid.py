"""The searches of ``grid_search`` in plain lines: the reference of its kernels, bit for bit.

Maps are flat with a ring of obstacles around them, so that no neighbour needs a bounds check. ``free`` is such a list
of bools, and ``stride`` the length of its rows. Every search runs from the goals (``sources``) to the start
(``target``), so that all goals are served by one search with one estimate. Lengths are those of ``plan.search``.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codesign.planners.grid_search.plan.parameters import (
    ANY,
    DIAGONAL,
    NONE,
    OCTILE,
    STEPS,
    STRAIGHT,
    TIE_BITS,
    TIE_SHIFT,
)
from codesign.planners.grid_search.plan.planner import sides, successors


def estimate(rows: int, columns: int, heuristic: int) -> int:
    """The least length between cells that lie so many rows and columns apart; 0 without a heuristic."""
    if heuristic == NONE:
        return 0
    if heuristic == OCTILE:
        return STRAIGHT * abs(rows - columns) + DIAGONAL * min(rows, columns)
    return math.isqrt(STRAIGHT**2 * (rows**2 + columns**2))


def key_of(length: int, left: int) -> int:
    """The key of a cell with ``length`` behind it and an estimate of ``left``: of equal sums the nearer goes first."""
    return (length + left) << TIE_BITS | min(left >> TIE_SHIFT, (1 << TIE_BITS) - 1)


class Found(NamedTuple):
    """The outcome of a search.

    - ``end``: the target where it was reached, else -1. ``lengths``: by cell, from the goals. ``before``: by cell, the
      cell before it. ``closed``: the cells that were expanded, and the target.
    - ``expanded``: cells taken from the heap and looked around. ``entries``: entries of the heap. ``looked``: cells
      that jumps or lines of sight looked at.
    """

    end: int
    lengths: dict[int, float]
    before: dict[int, int]
    closed: set[int]
    expanded: int
    entries: int
    looked: int


class _Jumps:
    """Jumps to the next jump point of Harabor and Grastien (2011), with the masks of ``successors``."""

    def __init__(self, free: Sequence[bool], stride: int, target: int, table: NDArray[np.uint8]) -> None:
        self.free, self.offsets = free, [down * stride + right for down, right in STEPS]
        self.target, self.table, self.looked = target, table, 0

    def mask(self, cell: int) -> int:
        """The free neighbours of a cell."""
        return sum(1 << bit for bit, offset in enumerate(self.offsets) if self.free[cell + offset])

    def jump(self, cell: int, side: int) -> int | None:
        """The next jump point from ``cell``, from which a step to ``side`` is allowed; None where there is none."""
        down, right = STEPS[side]
        parts = [STEPS.index(step) for step in ((down, 0), (0, right))] if down and right else []
        straight = 1 << side | sum(1 << part for part in parts)
        while True:
            cell += self.offsets[side]
            self.looked += 1
            allowed = int(self.table[side, self.mask(cell)])
            if cell == self.target or allowed & ~straight:
                return cell
            if any(allowed >> part & 1 and self.jump(cell, part) is not None for part in parts):
                return cell
            if not allowed >> side & 1:
                return None


def astar(
    free: Sequence[bool],
    stride: int,
    sources: Sequence[int],
    target: int,
    heuristic: int = OCTILE,
    *,
    cutting: bool = False,
    jumping: bool = False,
) -> Found:
    """A* from ``sources`` until ``target`` is taken from the heap; without a target (-1) until the heap is empty.

    ``jumping``: the neighbours of a cell are its jump points.
    """
    jumps = _Jumps(free, stride, target, successors(cutting))
    row, column = divmod(target, stride)
    came, before, lengths = dict.fromkeys(sources, ANY), {cell: cell for cell in sources}, dict.fromkeys(sources, 0)
    closed: set[int] = set()

    def entry(cell: int) -> tuple[int, int]:
        left = 0 if target < 0 else estimate(abs(cell // stride - row), abs(cell % stride - column), heuristic)
        return key_of(lengths[cell], left), cell

    heap = sorted(entry(cell) for cell in lengths)
    expanded, entries = 0, len(heap)
    while heap:
        _, cell = heapq.heappop(heap)
        if cell in closed:
            continue
        closed.add(cell)
        if cell == target:
            break
        expanded += 1
        allowed = int(jumps.table[came[cell], jumps.mask(cell)])
        for side in range(8):
            if not allowed >> side & 1:
                continue
            near = jumps.jump(cell, side) if jumping else cell + jumps.offsets[side]
            if near is None or near in closed:
                continue
            steps = (near - cell) // jumps.offsets[side]
            length = lengths[cell] + steps * (STRAIGHT if side < 4 else DIAGONAL)
            if near not in lengths or length < lengths[near]:
                lengths[near], came[near], before[near] = length, side, cell
                heapq.heappush(heap, entry(near))
                entries += 1
    end = target if target in closed else -1
    return Found(end, {**lengths}, before, closed, expanded, entries, jumps.looked)


def in_sight(free: Sequence[bool], stride: int, begin: int, end: int) -> tuple[bool, int]:
    """Whether the line between the middles of two cells crosses free cells only, and how many it was asked of.

    The cells of Bresenham's line, and at each of its diagonal steps both cells beside (``losCheck`` of Nav2's theta*).
    """
    (row, column), (last_row, last_column) = divmod(begin, stride), divmod(end, stride)
    down, right = abs(last_row - row), abs(last_column - column)
    down_step, right_step = (stride if last_row > row else -stride), (1 if last_column > column else -1)
    cell, error, looked = begin, right - down, 0
    while cell != end:
        looked += 1
        if not free[cell]:
            return False, looked
        twice = 2 * error
        across, along = twice > -down, twice <= right
        if across and along:
            if not (free[cell + right_step] and free[cell + down_step]):
                return False, looked
            cell, error = cell + right_step + down_step, error + right - down
        elif across:
            cell, error = cell + right_step, error - down
        else:
            cell, error = cell + down_step, error + right
    return True, looked


def theta_star(free: Sequence[bool], stride: int, sources: Sequence[int], target: int) -> Found:
    """Lazy theta* as Nav2's ``ThetaStar``: a cell takes the parent of its parent when it leaves the heap, if in sight.

    The key is the length in cells (a double) plus the straight line to ``target``, then the cell.
    """
    offsets = [down * stride + right for down, right in STEPS]

    def apart(cell: int, other: int) -> float:
        (row, column), (other_row, other_column) = divmod(cell, stride), divmod(other, stride)
        return math.sqrt((row - other_row) ** 2 + (column - other_column) ** 2)

    lengths, before = dict.fromkeys(sources, 0.0), {cell: cell for cell in sources}
    through = {cell: apart(cell, target) for cell in sources}
    heap = sorted((key, cell) for cell, key in through.items())
    closed: set[int] = set()
    expanded, entries, looked = 0, len(heap), 0
    while heap:
        key, cell = heapq.heappop(heap)
        if key > through[cell]:
            continue
        closed.add(cell)
        if cell == target:
            break
        expanded += 1
        beyond = before[before[cell]]
        seen, count = in_sight(free, stride, cell, beyond)
        looked += count
        straight = lengths[beyond] + apart(cell, beyond)
        if seen and straight < lengths[cell]:
            lengths[cell], before[cell] = straight, beyond
            through[cell] = straight + apart(cell, target)
        for side, offset in enumerate(offsets):
            near = cell + offset
            beside = [cell + down * stride + right for down, right in sides(STEPS[side])]
            if not free[near] or not all(free[each] for each in beside):
                continue
            length = lengths[cell] + (1.0 if side < 4 else math.sqrt(2.0))
            total = length + apart(near, target)
            if near not in through or total < through[near]:
                lengths[near], before[near], through[near] = length, cell, total
                heapq.heappush(heap, (total, near))
                entries += 1
    end = target if target in closed else -1
    return Found(end, lengths, before, closed, expanded, entries, looked)
