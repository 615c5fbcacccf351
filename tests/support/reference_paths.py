"""The local rules of paths and the skeleton of a map in plain lines, cell by cell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.planners.wavefront.paper.measures import Cell, edges


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
