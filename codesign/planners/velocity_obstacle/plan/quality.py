"""The quality of a run of robots: arrivals, collisions, and detours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.planners.interface import RobotsQuality
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.plan.reference import STAY
from codesign.planners.velocity_obstacle.plan.shortfall import remedy_of, shortfall_of

gaps = late("codesign.planners.velocity_obstacle.plan.gaps")


def quality(problem: RobotsProblem, plan: Avoidance) -> RobotsQuality:
    """The quality of a run; gaps are measured along the robots' motion, at updates and between them."""
    arrivals = arrival_updates(plan)
    steps = arrival_steps(plan)
    ratios = _length_ratios(plan, steps)
    there = [step for step in steps if step is not None]
    gaps = run_gaps(plan) - 2.0 * problem.radius
    changed = (np.diff(plan.candidates, axis=0) != 0) & (plan.candidates[1:] != STAY)
    shortfall = shortfall_of(problem, plan, arrivals)
    return RobotsQuality(
        robots=problem.count,
        robots_arrived=len(there),
        updates=plan.updates,
        collisions=int((gaps < 0.0).sum()),
        closest_approach=float(gaps.min()),
        time_to_targets_s=round(max(there) * plan.step, 12) if there else None,
        velocity_changes=int(changed.sum()),
        path_length_ratio_mean=float(np.mean(ratios)) if ratios else None,
        path_length_ratio_worst=max(ratios, default=None),
        shortfall=shortfall,
        remedy=None if shortfall is None else remedy_of(problem, plan),
    )


def arrival_updates(plan: Avoidance) -> list[int | None]:
    """For each robot the number of updates before its arrival, or None."""
    stays = plan.candidates == STAY
    return [int(np.argmax(column)) if column.any() else None for column in stays.T]


def arrival_steps(plan: Avoidance) -> list[int | None]:
    """For each robot the time steps before the update of its arrival; None if it did not arrive."""
    return [None if update is None else int(plan.begins[update]) for update in arrival_updates(plan)]


def run_gaps(plan: Avoidance) -> NDArray[np.float64]:
    """Least distance between the centres of each pair over a run, cells, one value a pair."""
    found: NDArray[np.float64] = gaps.pair_gaps(plan.cells, plan.speeds, np.diff(plan.times) * plan.step)
    return found


def _length_ratios(plan: Avoidance, arrivals: list[int | None]) -> list[float]:
    """Path length over the straight line between its ends, of the robots that drove and arrived."""
    ratios = []
    for robot, end in enumerate(arrivals):
        if not end:
            continue
        path = plan.cells[plan.times <= end, robot]
        straight = float(np.hypot(*(path[-1] - path[0])))
        if straight > 0.0:
            ratios.append(float(np.hypot(*np.diff(path, axis=0).T).sum()) / straight)
    return ratios
