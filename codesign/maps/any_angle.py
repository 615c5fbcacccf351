"""The shortest path at any angle between cells: no path of a robot in the free cells is shorter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from codesign.maps.grid import Cell, as_free
from codesign.maps.reach import check_cells, reachable

MOST_TESTS = 3_000_000
"""Tests of visibility, a second or two of work. Beyond, the bound is lower than the shortest path."""


def least_distance(
    free: NDArray[np.bool_],
    sources: Sequence[Cell],
    targets: Sequence[Cell],
    *,
    point: bool = False,
    most: int = MOST_TESTS,
) -> float:
    """Length, in cells, that no path from the sources to the targets falls below; inf where there is no path.

    A path is a curve in the free cells that passes from cell to cell over a side, or through a corner with both cells
    beside it free. It begins anywhere in a source cell (``point``: at the middle of the only one) and ends anywhere in
    a target cell. The result is the length of the shortest such path, from an A* over the visibility graph of the
    corners of obstacles, with tests in whole numbers; on maps that take more than ``most`` tests, it is the least that
    is left to be driven by then, which is a lower bound still.

    Args:
        free: bool H×W.
        sources: free cells; with ``point``, one.
        targets: free cells.
        point: whether a path begins at the middle of the source cell.
        most: tests of visibility at most.

    Raises:
        MapError: a cell is not on the map, or on an obstacle.

    >>> least_distance(np.ones((3, 4), np.bool_), [(0, 0)], [(0, 3)], point=True)
    2.5
    """
    from codesign.maps import _any_angle

    begins, ends = (check_cells(free, cells) for cells in (sources, targets))
    if not reachable(free, targets)[begins[:, 0], begins[:, 1]].any():
        return float("inf")
    blocked = np.pad(~as_free(free), 1, constant_values=True)
    boxes = _boxes(begins, 0 if point else 1), _boxes(ends, 1)
    length = _any_angle.search(blocked, _any_angle.corners(blocked), *boxes, most)
    return float(length) / 2.0


def _boxes(cells: NDArray[np.int64], half: int) -> NDArray[np.int64]:
    """The cells as boxes of the padded map, in doubled coordinates, ``half`` to each side of their middles."""
    middles = 2 * (cells + 1)
    return np.ascontiguousarray(np.hstack((middles - half, middles + half)))
