"""What a potential is worth to a robot that follows it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.planners.interface import Problem, Quality
from codesign.planners.relaxation.search import Descent, Search


def quality(problem: Problem, search: Search) -> Quality:
    """The quality of following ``search`` on ``problem``.

    ``local_maxima`` counts the cells from which no step leads on: flat areas, where neighbouring doubles are equal, or
    cells that the run ended too early for. ``wrong_cells`` does not apply: doubles settle at no exact value.

    Raises:
        InputError: a start is not in a free cell.
    """
    from codesign.maps.reach import clearance, distance_octile

    cells = search.reachable & ~search.goal
    count = int(cells.sum())
    ways = [(start, search.follow(start)) for start in problem.starts]
    arrived = [(start, way) for start, way in ways if way.arrived]
    ratios: list[float] = []
    spans: list[tuple[float, float, float]] = []
    if arrived:
        shortest = distance_octile(problem.free, problem.goals)
        room = clearance(problem.free)
        ratios = [way.length / float(shortest[start]) for start, way in arrived if shortest[start] > 0.0]
        spans = [_clearance(way, room) for _, way in arrived]
    length = sum(span[1] for span in spans)
    return Quality(
        reachable_cells=count,
        local_maxima=int(search.flat().sum()),
        share_reaching_goal=float((search.arriving() & cells).sum() / count) if count else 1.0,
        starts=len(ways),
        starts_arrived=len(arrived),
        path_length_ratio_mean=float(np.mean(ratios)) if ratios else None,
        path_length_ratio_worst=max(ratios, default=None),
        clearance_mean=sum(span[0] for span in spans) / length if length > 0.0 else None,
        clearance_least=min((span[2] for span in spans), default=None),
        wrong_cells=None,
    )


def _clearance(way: Descent, room: NDArray[np.float64]) -> tuple[float, float, float]:
    """Clearance summed along a way, the way's length, and the least clearance, all in cells."""
    at_cells = room[way.cells[:, 0], way.cells[:, 1]]
    pieces = np.sqrt((np.diff(way.cells, axis=0) ** 2).sum(axis=1))
    along = float((pieces * (at_cells[:-1] + at_cells[1:]) / 2.0).sum())
    return along, float(pieces.sum()), float(at_cells.min())
