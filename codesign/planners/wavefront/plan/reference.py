"""The same answers in a few plain lines each: Dijkstra, the two circuits cycle by cycle, the local rules.

Slow on purpose. The circuits are the oracle for the cycle laws of ``codesign.planners.wavefront.styles``.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from codesign.planners.wavefront.plan.grid import CLOCKWISE, DELAYS, UNREACHED

Cell = tuple[int, int]


def edges(free: NDArray[np.bool_], cell: Cell, corner_cutting: bool = True) -> Iterator[tuple[Cell, int]]:
    """The free neighbours of a cell of a flat map, each with its delay."""
    rows, columns = free.shape
    for down, right in CLOCKWISE:
        row, column = cell[0] + down, cell[1] + right
        if not (0 <= row < rows and 0 <= column < columns and free[row, column]):
            continue
        diagonal = bool(down and right)
        if diagonal and not corner_cutting and not (free[cell[0], column] and free[row, cell[1]]):
            continue
        yield (row, column), DELAYS[diagonal]


def dijkstra(
    free: NDArray[np.bool_],
    sources: Sequence[Cell],
    *,
    stop: Cell | None = None,
    corner_cutting: bool = True,
    extra_delay: NDArray[np.integer] | None = None,
) -> NDArray[np.int32]:
    """``propagate`` by equation 1 and a heap."""
    potentials = np.full(free.shape, UNREACHED, np.int32)
    waiting = [(0, source) for source in sources]
    last = None
    while waiting:
        potential, cell = heapq.heappop(waiting)
        if last is not None and potential > last:
            break
        if potentials[cell] != UNREACHED:
            continue
        potentials[cell] = potential
        if cell == stop:
            last = potential
        for other, delay in edges(free, cell, corner_cutting):
            extra = 0 if extra_delay is None or other in sources else int(extra_delay[other])
            heapq.heappush(waiting, (potential + delay + extra, other))
    return potentials


def delay_line_circuit(
    free: NDArray[np.bool_], sources: Sequence[Cell], stop: Cell | None = None
) -> tuple[NDArray[np.int64], int]:
    """Figure 2, clocked: the final registers (the counter's value: infinity), and the cycles taken.

    Three flip-flops a node: the first takes the OR of the diagonal neighbours, the second the first or the OR of the
    straight ones, the third the second. Y = third and F, or Z. Without ``stop`` it runs three cycles past the last
    change.
    """
    line = np.zeros((3, *free.shape), np.bool_)
    source = np.zeros(free.shape, np.bool_)
    source[tuple(np.array(sources).T)] = True
    locked = np.zeros(free.shape, np.bool_)
    registers = np.zeros(free.shape, np.int64)
    counter, quiet = 0, 0
    while True:
        output = (line[2] & free) | source
        registers[~locked] = counter
        quiet = quiet + 1 if (output == locked).all() else 0
        if (quiet > len(line)) if stop is None else locked[stop]:
            return registers, counter
        locked |= output
        straight, diagonal = _around(output)
        line = np.stack([diagonal, line[0] | straight, line[1]])
        counter += 1


def _around(output: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    padded = np.pad(output, 1)
    rows, columns = output.shape
    seen = [padded[1 + down : 1 + down + rows, 1 + right : 1 + right + columns] for down, right in CLOCKWISE]
    return np.logical_or.reduce(seen[:4]), np.logical_or.reduce(seen[4:])


def adder_circuit(free: NDArray[np.bool_], sources: Sequence[Cell]) -> tuple[NDArray[np.int64], int, NDArray[np.int64]]:
    """Equation 3 in all nodes at once: potentials, cycles to the first without a change, and updates of each node."""
    infinity = 2**40
    potentials = np.full(free.shape, infinity, np.int64)
    potentials[tuple(np.array(sources).T)] = 0
    updates = np.zeros(free.shape, np.int64)
    rows, columns = free.shape
    cycles = 0
    while True:
        padded = np.pad(potentials, 1, constant_values=infinity)
        best = potentials
        for (down, right), delay in zip(CLOCKWISE, [DELAYS[0]] * 4 + [DELAYS[1]] * 4, strict=True):
            best = np.minimum(best, padded[1 + down : 1 + down + rows, 1 + right : 1 + right + columns] + delay)
        best = np.where(free & (best < infinity), best, infinity)
        cycles += 1
        changed = best < potentials
        if not changed.any():
            return np.where(potentials < infinity, potentials, UNREACHED), cycles, updates
        updates += changed
        potentials = best


def track(
    free: NDArray[np.bool_], potentials: NDArray[np.int32], start: Cell, distances: NDArray[np.int32] | None = None
) -> list[Cell]:
    """``tracking.track`` by equations 2, or 4 and 5, as they stand."""
    path = [start]
    while potentials[path[-1]] > 0:
        cell = path[-1]
        around = [(other, delay) for other, delay in edges(free, cell) if potentials[other] >= 0]
        if distances is None:
            path.append(next(j for j, delay in around if potentials[cell] == potentials[j] + delay))
            continue
        nearer = [other for other, _ in around if potentials[other] < potentials[cell]]
        farthest = max(distances[other] for other in nearer)
        path.append(min((j for j in nearer if distances[j] == farthest), key=lambda j: potentials[j]))
    return path


def skeleton(distances: NDArray[np.int32]) -> NDArray[np.bool_]:
    """``skeleton.skeleton``, cell by cell."""
    rows, columns = distances.shape

    def at(row: int, column: int) -> int:
        return int(distances[min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)])

    def crest(row: int, column: int, down: int, right: int) -> bool:
        own = at(row, column)
        first = max(at(row + down, column + right), at(row - down, column - right))
        second = max(at(row + 2 * down, column + 2 * right), at(row - 2 * down, column - 2 * right))
        return own > 0 and own >= first and own > second

    axes = ((0, 1), (1, 0), (1, 1), (1, -1))
    return np.array(
        [[any(crest(row, column, *axis) for axis in axes) for column in range(columns)] for row in range(rows)]
    )
