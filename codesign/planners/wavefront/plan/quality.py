"""The quality of the potentials for a robot: where paths lead, their lengths, and their clearances."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from codesign.maps.reach import reachable
from codesign.planners.interface import Cell, Problem, Quality, judge_arrival, judge_paths
from codesign.planners.wavefront.plan.plan import WavefrontPlan
from codesign.planners.wavefront.plan.tracking import Tracker
from codesign.planners.wavefront.plan.wave import run_wave


def quality(problem: Problem, plan: WavefrontPlan) -> Quality:
    """The quality of ``plan`` on ``problem``.

    The plan covers the cells that the wave reached before it ended. Each of them has a path, as equation 2 always finds
    a neighbour. So ``local_maxima`` is 0, and ``share_reaching_goal`` is 1 where the plan covers a cell. Cells beyond
    the wave have no path.

    Paths are tracked from the starts by the rule of the plan. A start beyond the wave of this plan is judged by the
    wave of its own request: up to a start, that wave has the same potentials as a wave to its own end. Lengths are
    octile. A path that cuts corners can be shorter than the shortest path that does not, so ratios below 1 occur. The
    mean clearance weighs every step by its length.
    """
    cells = reachable(problem.free, problem.goals, corner_cutting=plan.wave_map.neighbours.corner_cutting)
    cells[tuple(np.array(problem.goals).T)] = False
    planned = int((cells & (plan.potentials >= 0)).sum())
    potentials, tracker = reaching(problem, plan, problem.starts)
    paths = ((start, tracker.follow(start) if potentials[start] >= 0 else None) for start in problem.starts)
    return Quality(
        local_maxima=0,
        wrong_cells=0,
        **judge_arrival(planned, planned, int(cells.sum())),
        **judge_paths(problem, paths),
    )


def reaching(problem: Problem, plan: WavefrontPlan, starts: Iterable[Cell]) -> tuple[NDArray[np.int32], Tracker]:
    """Potentials and tracker of the plan; where that wave stopped before some starts, of a wave to its own end."""
    if plan.stop_potential is None or all(plan.potentials[start] >= 0 for start in starts):
        return plan.potentials, plan.tracker
    sources = np.array(problem.goals, np.int64)
    potentials, _ = run_wave(plan.wave_map, sources, np.zeros((0, 2), np.int64))
    return potentials, Tracker(plan.wave_map, potentials, plan.obstacle_potentials)
