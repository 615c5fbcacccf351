"""Reachable cells, distances to the goals at 4, 8 or any directions, and clearance of the walls.

``free`` is a bool H×W array, goals are (row, column) pairs, and all cells outside of the grid are obstacles. All
functions raise MapError for a grid or a goal that cannot be used. Except for ``least_distance``, the time is linear in
cells, and well under a second for 1024 × 1024.
"""

from __future__ import annotations

import operator
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError, outside_map
from codesign.ground.late import late
from codesign.maps.grid import Cell, as_free

ndimage = late("scipy.ndimage")
kernels = late("codesign.maps.kernels")

MOST_TESTS = 3_000_000
"""Tests of visibility: a second or two of work. With more, the result is a bound below the shortest path."""


def nearest_free(free: NDArray[np.bool_], cell: Cell) -> Cell | None:
    """The free cell with the least straight-line distance; the first in raster order among equals.

    A cell outside of the map is first moved to the border. None where the map has no free cell.

    >>> nearest_free(np.array([[True, False, False]]), (0, 2))
    (0, 0)
    """
    rows, columns = np.nonzero(as_free(free))
    if rows.size == 0:
        return None
    row = min(max(cell[0], 0), free.shape[0] - 1)
    column = min(max(cell[1], 0), free.shape[1] - 1)
    # Cells stand in raster order, and argmin gives the first of equals.
    nearest = int(np.argmin((rows - row) ** 2 + (columns - column) ** 2))
    return int(rows[nearest]), int(columns[nearest])


def check_cells(
    free: NDArray[np.bool_], cells: Iterable[Cell], *, name: str = "goal", where: str | None = None
) -> NDArray[np.int64]:
    """The cells as an int64 N×2 array of (row, column), N ≥ 1, each inside the map and free.

    Args:
        free: bool H×W.
        cells: (row, column) pairs.
        name: the role of the cells, for the message: goal, start, ...
        where: the place for the message: a file or an argument.

    Raises:
        MapError: no cell, not a pair of integers, outside of the map, or on an obstacle (with the nearest
            free cell as the hint).
    """
    free = as_free(free, where)
    pairs = [_pair(cell, name, where) for cell in cells]
    if not pairs:
        raise MapError(f"there is no {name}", where, f"give at least one {name} as (row, column)")
    rows, columns = free.shape
    for row, column in pairs:
        inside = 0 <= row < rows and 0 <= column < columns
        if inside and free[row, column]:
            continue
        near = nearest_free(free, (row, column))
        hint = f"nearest free cell {near}" if near else "the map has no free cell at all"
        if not inside:
            raise MapError(outside_map((row, column), free.shape, name)[0], where, hint)
        raise MapError(f"{name} ({row}, {column}) is on an obstacle", where, hint)
    return np.array(pairs, dtype=np.int64)


def _pair(cell: Cell, name: str, where: str | None) -> Cell:
    try:
        row, column = cell
        return operator.index(row), operator.index(column)
    except (TypeError, ValueError):
        raise MapError(
            f"{name} {cell!r:.80} is not a cell", where, "a cell is a pair of integers (row, column)"
        ) from None


def reachable(free: NDArray[np.bool_], goals: Iterable[Cell], *, corner_cutting: bool = False) -> NDArray[np.bool_]:
    """Bool H×W: the free cells with a path to a goal, goals included.

    A path takes steps across the sides of cells. Diagonal steps that cut no corner reach no more cells. With
    ``corner_cutting`` a path may also pass between two obstacles that touch at a corner.

    >>> cut = np.array([[True, False], [False, True]])
    >>> int(reachable(cut, [(0, 0)]).sum()), int(reachable(cut, [(0, 0)], corner_cutting=True).sum())
    (1, 2)
    """
    if not corner_cutting:
        return distance_steps(free, goals) >= 0
    cells = check_cells(free, goals)
    labels, _ = ndimage.label(free, np.ones((3, 3)))
    # A flag for each component, set where a goal lies in it, is looked up by the labels of all cells.
    wanted = np.zeros(int(labels.max()) + 1, dtype=np.bool_)
    wanted[labels[cells[:, 0], cells[:, 1]]] = True
    result: NDArray[np.bool_] = wanted[labels]
    return result


def largest_component(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Bool H×W: the most free cells that paths across the sides of cells join; none where no cell is free.

    >>> largest_component(np.array([[True, False, True, True]])).tolist()
    [[False, False, True, True]]
    """
    labels, count = ndimage.label(as_free(free))
    # Label 0 is all cells that are not free.
    sizes = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    return np.asarray(labels == 1 + int(sizes.argmax()) if count else np.zeros_like(free))


def distance_steps(free: NDArray[np.bool_], goals: Iterable[Cell]) -> NDArray[np.int32]:
    """Int32 H×W: steps of the shortest 4-connected path to the nearest goal; -1 without one."""
    padded, indices = _flatten(free, goals)
    distance = kernels.steps_from(padded.ravel(), indices, padded.shape[1])
    result: NDArray[np.int32] = distance.reshape(padded.shape)[1:-1, 1:-1].copy()
    return result


def distance_octile(free: NDArray[np.bool_], goals: Iterable[Cell]) -> NDArray[np.float64]:
    """Float64 H×W, in cells: length of the shortest 8-connected path to the nearest goal; inf without one.

    A diagonal step costs √2, and is allowed where both cells beside it are free (no corner cutting). These are the
    lengths of MovingAI's scenario files.
    """
    padded, indices = _flatten(free, goals)
    distance = kernels.octile_from(padded.ravel(), indices, padded.shape[1])
    result: NDArray[np.float64] = distance.reshape(padded.shape)[1:-1, 1:-1].copy()
    return result


def least_distance(
    free: NDArray[np.bool_],
    sources: Sequence[Cell],
    targets: Sequence[Cell],
    *,
    point: bool = False,
    most: int = MOST_TESTS,
) -> float:
    """The length, in cells, of the shortest path at any angle from the sources to the targets; inf without a path.

    A path is a curve in the free cells. It passes from cell to cell over a side, or through a corner with both cells
    beside it free. It begins anywhere in a source cell (``point``: at the middle of the only one) and ends anywhere in
    a target cell. The search is an A* over the visibility graph of the corners of obstacles, with tests in whole
    numbers. On maps that take more than ``most`` tests, the result is the least estimate of the A* at that time, which
    is a lower bound.

    Args:
        free: bool H×W.
        sources: free cells; with ``point``, one.
        targets: free cells.
        point: True if a path begins at the middle of the source cell.
        most: tests of visibility at most.

    Raises:
        MapError: a cell is not on the map, or on an obstacle.

    >>> least_distance(np.ones((3, 4), np.bool_), [(0, 0)], [(0, 3)], point=True)
    2.5
    """
    begins, ends = (check_cells(free, cells) for cells in (sources, targets))
    if not reachable(free, targets)[begins[:, 0], begins[:, 1]].any():
        return float("inf")
    blocked = np.pad(~as_free(free), 1, constant_values=True)
    boxes = _boxes(begins, 0 if point else 1), _boxes(ends, 1)
    length = kernels.search(blocked, kernels.corners(blocked), *boxes, most)
    return float(length) / 2.0


def _boxes(cells: NDArray[np.int64], half: int) -> NDArray[np.int64]:
    """The cells as boxes of the padded map, in doubled coordinates, ``half`` to each side of their middles."""
    middles = 2 * (cells + 1)
    return np.ascontiguousarray(np.hstack((middles - half, middles + half)))


def clearance(free: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Float64 H×W, in cells: distance between the centres of a cell and of the nearest obstacle; 0 on an obstacle.

    Cells outside of the map are obstacles, so a cell of the border has a clearance of at most 1.
    """
    padded = np.pad(as_free(free), 1)
    result: NDArray[np.float64] = ndimage.distance_transform_edt(padded)[1:-1, 1:-1].copy()
    return result


def led_to(sides: NDArray[np.int8], steps: Sequence[Cell], goal: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Bool H×W: the cells from which the way from side to side ends at a goal, goals included.

    Every cell points at a neighbour, then at the target of its target, and so on: cells × log cells.

    Args:
        sides: int8 H×W, an index into ``steps``, -1 where a way ends.
        steps: (rows, columns) of a step to each side.
        goal: bool H×W.
    """
    offsets = np.array([down * sides.shape[1] + right for down, right in steps] + [0])
    ends_here = goal.ravel()
    target = np.arange(sides.size) + np.where(ends_here, 0, offsets[sides.ravel()])
    while not np.array_equal(further := target[target], target):
        target = further
    result: NDArray[np.bool_] = ends_here[target].reshape(sides.shape)
    return result


def _flatten(free: NDArray[np.bool_], goals: Iterable[Cell]) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    cells = check_cells(free, goals)
    padded = np.pad(free.astype(np.uint8), 1)
    return padded, (cells[:, 0] + 1) * padded.shape[1] + cells[:, 1] + 1
