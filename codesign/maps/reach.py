"""What can be reached from the goals, how far it is, and how close the walls are.

``free`` is a bool H×W array, goals are (row, column) pairs, and outside of the grid is obstacle. All
functions raise MapError for a grid or a goal that cannot be used. The time is linear in cells, and well under
a second for 1024 × 1024.
"""

from __future__ import annotations

import operator
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from codesign.errors import MapError, outside_map
from codesign.maps.grid import Cell, as_free


def nearest_free(free: NDArray[np.bool_], cell: Cell) -> Cell | None:
    """The free cell with the least straight-line distance (the first in raster order among equals).

    A cell outside of the map is first moved to the border. None where the map has no free cell.

    >>> nearest_free(np.array([[True, False, False]]), (0, 2))
    (0, 0)
    """
    rows, columns = np.nonzero(as_free(free))
    if rows.size == 0:
        return None
    row = min(max(cell[0], 0), free.shape[0] - 1)
    column = min(max(cell[1], 0), free.shape[1] - 1)
    nearest = int(np.argmin((rows - row) ** 2 + (columns - column) ** 2))
    return int(rows[nearest]), int(columns[nearest])


def check_cells(
    free: NDArray[np.bool_], cells: Iterable[Cell], *, name: str = "goal", where: str | None = None
) -> NDArray[np.int64]:
    """The cells as an int64 N×2 array of (row, column), N ≥ 1, every one inside the map and free.

    Args:
        free: bool H×W.
        cells: (row, column) pairs.
        name: what the cells are, for the message: goal, start, ...
        where: place to name in the message (a file, an argument).

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


def reachable(
    free: NDArray[np.bool_], goals: Iterable[Cell], *, corner_cutting: bool = False
) -> NDArray[np.bool_]:
    """Bool H×W: free cells with a path to a goal; goals included.

    A path takes steps across the sides of cells. Diagonal steps that cut no corner lead to no further cell. With
    ``corner_cutting`` a path may pass between two obstacles that touch at a corner as well.

    >>> cut = np.array([[True, False], [False, True]])
    >>> int(reachable(cut, [(0, 0)]).sum()), int(reachable(cut, [(0, 0)], corner_cutting=True).sum())
    (1, 2)
    """
    from scipy import ndimage

    cells = check_cells(free, goals)
    labels, _ = ndimage.label(free, np.ones((3, 3)) if corner_cutting else None)
    wanted = np.zeros(int(labels.max()) + 1, dtype=np.bool_)
    wanted[labels[cells[:, 0], cells[:, 1]]] = True
    result: NDArray[np.bool_] = wanted[labels]
    return result


def distance_steps(free: NDArray[np.bool_], goals: Iterable[Cell]) -> NDArray[np.int32]:
    """Int32 H×W: steps of the shortest 4-connected way to the nearest goal; -1 where there is none."""
    from codesign.maps._kernels import steps_from

    padded, indices = _flatten(free, goals)
    distance = steps_from(padded.ravel(), indices, padded.shape[1])
    result: NDArray[np.int32] = distance.reshape(padded.shape)[1:-1, 1:-1].copy()
    return result


def distance_octile(free: NDArray[np.bool_], goals: Iterable[Cell]) -> NDArray[np.float64]:
    """Float64 H×W, in cells: length of the shortest 8-connected way to the nearest goal; inf where none.

    A diagonal step costs √2 and is allowed only where both cells beside it are free (no corner cutting): the
    lengths of MovingAI's scenario files.
    """
    from codesign.maps._kernels import octile_from

    padded, indices = _flatten(free, goals)
    distance = octile_from(padded.ravel(), indices, padded.shape[1])
    result: NDArray[np.float64] = distance.reshape(padded.shape)[1:-1, 1:-1].copy()
    return result


def clearance(free: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Float64 H×W, in cells: from the centre of a cell to that of the nearest obstacle; 0 on an obstacle.

    Outside of the map counts as obstacle, so a cell of the border has a clearance of at most 1.
    """
    from scipy import ndimage

    padded = np.pad(as_free(free), 1)
    result: NDArray[np.float64] = ndimage.distance_transform_edt(padded)[1:-1, 1:-1].copy()
    return result


def _flatten(free: NDArray[np.bool_], goals: Iterable[Cell]) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    cells = check_cells(free, goals)
    padded = np.pad(free.astype(np.uint8), 1)
    return padded, (cells[:, 0] + 1) * padded.shape[1] + cells[:, 1] + 1
