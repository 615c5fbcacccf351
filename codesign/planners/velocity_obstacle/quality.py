"""What a run of robots is worth: who arrived, who touched whom, and how far round they went."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.planners.interface import RobotsQuality
from codesign.planners.velocity_obstacle.avoid import Avoidance
from codesign.planners.velocity_obstacle.problem import RobotsProblem
from codesign.planners.velocity_obstacle.reference import STAY


def quality(problem: RobotsProblem, plan: Avoidance) -> RobotsQuality:
    """The quality of a run; between two updates robots are taken to move straight."""
    arrivals = arrival_updates(plan)
    ratios = _length_ratios(plan.cells, arrivals)
    there = [update for update in arrivals if update is not None]
    gaps = pair_gaps(plan.cells) - 2.0 * problem.radius
    changed = (np.diff(plan.candidates, axis=0) != 0) & (plan.candidates[1:] != STAY)
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
    )


def arrival_updates(plan: Avoidance) -> list[int | None]:
    """For each robot the updates done when it had arrived, or None."""
    stays = plan.candidates == STAY
    return [int(np.argmax(column)) if column.any() else None for column in stays.T]


def pair_gaps(cells: NDArray[np.float64]) -> NDArray[np.float64]:
    """Least distance between the centres of each pair over a run, float64, one entry a pair.

    ``cells``: float64 (u + 1) × n × 2. The distance along each step, not only at its ends.
    """
    if len(cells) == 1:
        cells = np.concatenate([cells, cells])
    found = []
    for robot in range(cells.shape[1] - 1):
        offsets = cells[:, robot + 1 :] - cells[:, robot, None]
        begin, moves = offsets[:-1], np.diff(offsets, axis=0)
        square = (moves**2).sum(axis=2)
        along = -(begin * moves).sum(axis=2)
        share = np.clip(np.divide(along, square, out=np.zeros_like(square), where=square > 0.0), 0.0, 1.0)
        nearest = begin + share[..., None] * moves
        found.append(np.hypot(nearest[..., 0], nearest[..., 1]).min(axis=0))
    return np.concatenate(found)


def _length_ratios(cells: NDArray[np.float64], arrivals: list[int | None]) -> list[float]:
    """Way over the straight line between its ends, of the robots that arrived and had a way to go."""
    ratios = []
    for robot, end in enumerate(arrivals):
        if not end:
            continue
        way = cells[: end + 1, robot]
        straight = float(np.hypot(*(way[-1] - way[0])))
        if straight > 0.0:
            ratios.append(float(np.hypot(*np.diff(way, axis=0).T).sum()) / straight)
    return ratios
