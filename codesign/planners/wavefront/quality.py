"""What the potentials are worth to a robot: where ways lead, how long they are, how close to the walls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.planners.interface import Problem, Quality
from codesign.planners.wavefront.plan import WavefrontPlan
from codesign.planners.wavefront.tracking import octile_length


def quality(problem: Problem, plan: WavefrontPlan) -> Quality:
    """The quality of ``plan`` on ``problem``.

    A cell that the wave reached has a way (equation 2 always finds a neighbour), so ``share_reaching_goal`` is the
    share of reachable cells that it reached before it was stopped, and ``local_maxima`` counts the others. Ways are
    tracked from the starts by the rule of the plan. Lengths are octile; a way that cuts corners can be shorter than the
    shortest one that does not, so ratios below 1 occur. The mean clearance weighs every step by its length.
    """
    from codesign.maps.reach import clearance, distance_octile, reachable

    cells = reachable(problem.free, problem.goals)
    cells[tuple(np.array(problem.goals).T)] = False
    count = int(cells.sum())
    left = int((cells & (plan.potentials < 0)).sum())
    reached = [start for start in problem.starts if plan.potentials[start] >= 0]
    ways = [plan.tracker.follow(start) for start in reached]
    shortest = distance_octile(problem.free, problem.goals)
    room = clearance(problem.free)
    ratios = [
        octile_length(way) / float(shortest[start])
        for start, way in zip(reached, ways, strict=True)
        if 0.0 < shortest[start] < np.inf
    ]
    spans = [_clearance(way, room) for way in ways]
    length = sum(span[1] for span in spans)
    return Quality(
        reachable_cells=count,
        local_maxima=left,
        share_reaching_goal=1.0 - left / count if count else 1.0,
        starts=len(problem.starts),
        starts_arrived=len(ways),
        path_length_ratio_mean=float(np.mean(ratios)) if ratios else None,
        path_length_ratio_worst=max(ratios, default=None),
        clearance_mean=sum(span[0] for span in spans) / length if length > 0.0 else None,
        clearance_least=min((span[2] for span in spans), default=None),
        wrong_cells=0,
    )


def _clearance(way: NDArray[np.int64], room: NDArray[np.float64]) -> tuple[float, float, float]:
    """Clearance summed along a way, the way's length, and the least clearance, all in cells."""
    at_cells = room[tuple(way.T)]
    pieces = np.sqrt((np.diff(way, axis=0) ** 2).sum(axis=1))
    along = float((pieces * (at_cells[:-1] + at_cells[1:]) / 2.0).sum())
    return along, float(pieces.sum()), float(at_cells.min())
