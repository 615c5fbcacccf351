"""The quality of paths through a map: the figures that all grid planners share."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from codesign.ground.memo import Memo
from codesign.maps.reach import clearance, distance_octile, reachable
from codesign.planners.interface import Cell, Problem

_of_maps = Memo(max_bytes=64 * 2**20)
"""The data that all plans on one map share. Larger maps are computed each time."""


class PathsQuality(TypedDict):
    """The fields of ``Quality`` that depend on paths alone."""

    starts: int
    starts_arrived: int
    path_length_ratio_mean: float | None
    path_length_ratio_worst: float | None
    clearance_mean: float | None
    clearance_least: float | None


def judge_paths(problem: Problem, paths: Iterable[tuple[Cell, NDArray[Any] | None]]) -> PathsQuality:
    """Lengths and clearances of the paths from some starts.

    Args:
        problem: the map and its goals.
        paths: each start with the points of its path, n × 2 (row, column) in cells; None where it does not arrive.

    A length is compared with the shortest 8-connected path without corner cutting. A start on a goal has no ratio. The
    mean clearance weights every piece of a path by its length.
    """
    tried = list(paths)
    arrived = [(start, points) for start, points in tried if points is not None]
    ratios: list[float] = []
    along = length = 0.0
    least: list[float] = []
    if arrived:
        shortest, room = _of_maps.get(("paths", problem.map_digest), lambda: _lengths_and_room(problem))
        for start, points in arrived:
            pieces = np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1))
            cells = np.floor(points + 0.5).astype(np.int64)
            at_points = room[cells[:, 0], cells[:, 1]]
            along += float((pieces * (at_points[:-1] + at_points[1:]) / 2.0).sum())
            length += float(pieces.sum())
            least.append(float(at_points.min()))
            if 0.0 < shortest[start] < np.inf:
                ratios.append(float(pieces.sum()) / float(shortest[start]))
    return PathsQuality(
        starts=len(tried),
        starts_arrived=len(arrived),
        path_length_ratio_mean=float(np.mean(ratios)) if ratios else None,
        path_length_ratio_worst=max(ratios, default=None),
        clearance_mean=along / length if length > 0.0 else None,
        clearance_least=min(least, default=None),
    )


def _lengths_and_room(problem: Problem) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of each cell, the length of the shortest path to a goal, and the distance to the nearest obstacle."""
    return distance_octile(problem.free, problem.goals), clearance(problem.free)


def by_sides(problem: Problem) -> NDArray[np.bool_]:
    """``Planner.reachable`` of planners that move across the sides of cells, or diagonally without cutting a corner."""
    key = "by sides", problem.map_digest
    return _of_maps.get(key, lambda: reachable(problem.free, problem.goals)).copy()


class ArrivalQuality(TypedDict):
    """The fields of ``Quality`` that depend on the number of arriving cells."""

    reachable_cells: int
    planned_cells: int
    cells_leading_nowhere: int
    share_reaching_goal: float | None


def judge_arrival(arriving: int, planned: int, reachable: int | None = None) -> ArrivalQuality:
    """Figures of a plan that covers ``planned`` of the ``reachable`` cells: ``arriving`` of them lead to a goal.

    By default the plan covers all reachable cells. The share is None where the plan covers no cell.

    >>> judge_arrival(3, 4, 8)
    {'reachable_cells': 8, 'planned_cells': 4, 'cells_leading_nowhere': 1, 'share_reaching_goal': 0.75}
    """
    return ArrivalQuality(
        reachable_cells=planned if reachable is None else reachable,
        planned_cells=planned,
        cells_leading_nowhere=planned - arriving,
        share_reaching_goal=arriving / planned if planned else None,
    )


def cell_of(problem: Problem, position: tuple[float, float]) -> Cell | None:
    """The free cell that a position, (row, column) in cells, lies in; None outside of the map or in an obstacle."""
    row, column = (math.floor(value + 0.5) for value in position)
    inside = 0 <= row < problem.rows and 0 <= column < problem.columns
    return (row, column) if inside and bool(problem.free[row, column]) else None


def from_position(
    position: tuple[float, float], cells: NDArray[np.integer], free: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """The path along the middles of ``cells``, n × 2, n ≥ 1, from a position in the first of them: float64 m × 2.

    It goes straight to the middle of the second cell, so that a robot that gets a new path at every position does not
    turn back. Where that would cut the corner of an obstacle, it goes through the middle of the first cell.
    """
    here = np.array([position], np.float64)
    middles = cells.astype(np.float64)
    if len(cells) == 1:
        return here if np.array_equal(here[0], middles[0]) else np.concatenate([here, middles])
    (row, column), (down, right) = cells[0], cells[1] - cells[0]
    clear = bool(free[row + down, column] and free[row, column + right])
    return np.concatenate([here, middles[1:] if clear or np.array_equal(here[0], middles[0]) else middles])
