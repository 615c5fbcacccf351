"""The quality of the potentials for a robot: where paths lead, their lengths, and their clearances."""

from __future__ import annotations

import numpy as np

from codesign.planners.interface import Problem, Quality
from codesign.planners.paths import judge_arrival, judge_paths
from codesign.planners.wavefront.plan.plan import WavefrontPlan


def quality(problem: Problem, plan: WavefrontPlan) -> Quality:
    """The quality of ``plan`` on ``problem``.

    The plan covers the cells that the wave reached before it ended. Each of them has a path, as equation 2 always finds
    a neighbour. So ``local_maxima`` is 0, and ``share_reaching_goal`` is 1 where the plan covers a cell. Cells beyond
    the wave have no path.

    Paths are tracked from the starts by the rule of the plan. Lengths are octile. A path that cuts corners can be
    shorter than the shortest path that does not, so ratios below 1 occur. The mean clearance weighs every step by its
    length.
    """
    from codesign.maps.reach import reachable

    cells = reachable(problem.free, problem.goals, corner_cutting=plan.wave_map.neighbours.corner_cutting)
    cells[tuple(np.array(problem.goals).T)] = False
    planned = int((cells & (plan.potentials >= 0)).sum())
    paths = (
        (start, plan.tracker.follow(start) if plan.potentials[start] >= 0 else None)
        for start in problem.starts
    )
    return Quality(
        local_maxima=0,
        wrong_cells=0,
        **judge_arrival(planned, planned, int(cells.sum())),
        **judge_paths(problem, paths),
    )
