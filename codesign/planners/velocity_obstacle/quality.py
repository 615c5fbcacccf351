"""What a run of robots is worth: who arrived, who touched whom, and how far round they went."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.planners.velocity_obstacle.avoid import Avoidance
from codesign.planners.velocity_obstacle.problem import RobotsProblem
from codesign.planners.velocity_obstacle.reference import BRAKE, STAY


@dataclass(frozen=True)
class RobotsQuality:
    """The figures of one run.

    - ``robots``, ``robots_arrived``: how many there were, how many came within the tolerance of their targets.
    - ``collisions``: how often two robots that were apart came to touch.
    - ``closest_approach``: the least gap between two robots' edges, cells; negative where they overlapped.
    - ``updates_to_goal_mean``, ``updates_to_goal_last``: updates until arrival, of those that arrived; None: none.
    - ``velocity_changes``: how often a robot chose another velocity than in the update before.
    - ``updates_braked``: how often a robot found no safe velocity.
    - ``path_length_ratio_mean``, ``path_length_ratio_worst``: way over the straight line between its ends, of those
      that arrived; None where none did.
    - ``robots_outside``: robots whose centre left the arena at some time.
    """

    robots: int
    robots_arrived: int
    collisions: int
    closest_approach: float
    updates_to_goal_mean: float | None
    updates_to_goal_last: int | None
    velocity_changes: int
    updates_braked: int
    path_length_ratio_mean: float | None
    path_length_ratio_worst: float | None
    robots_outside: int


def quality(problem: RobotsProblem, plan: Avoidance) -> RobotsQuality:
    """The quality of a run; between two updates robots are taken to move straight."""
    arrivals = arrival_updates(plan)
    ratios = _length_ratios(plan.cells, arrivals)
    there = [update for update in arrivals if update is not None]
    contacts, closest = _contacts(plan.cells, 2.0 * problem.radius)
    outside = ((plan.cells < 0.0) | (plan.cells > problem.arena)).any(axis=(0, 2))
    moving = plan.candidates[1:] != STAY
    return RobotsQuality(
        robots=problem.count,
        robots_arrived=len(there),
        collisions=contacts,
        closest_approach=closest - 2.0 * problem.radius,
        updates_to_goal_mean=float(np.mean(there)) if there else None,
        updates_to_goal_last=max(there, default=None),
        velocity_changes=int(((np.diff(plan.candidates, axis=0) != 0) & moving).sum()),
        updates_braked=int((plan.candidates == BRAKE).sum()),
        path_length_ratio_mean=float(np.mean(ratios)) if ratios else None,
        path_length_ratio_worst=max(ratios, default=None),
        robots_outside=int(outside.sum()),
    )


def arrival_updates(plan: Avoidance) -> list[int | None]:
    """For each robot the updates done when it had arrived, or None."""
    stays = plan.candidates == STAY
    return [int(np.argmax(column)) if column.any() else None for column in stays.T]


def _length_ratios(cells: NDArray[np.float64], arrivals: list[int | None]) -> list[float]:
    ratios = []
    for robot, end in enumerate(arrivals):
        if not end:
            continue
        way = cells[: end + 1, robot]
        straight = float(np.hypot(*(way[-1] - way[0])))
        if straight > 0.0:
            ratios.append(float(np.hypot(*np.diff(way, axis=0).T).sum()) / straight)
    return ratios


def _contacts(cells: NDArray[np.float64], radius: float) -> tuple[int, float]:
    """How often a pair came closer than ``radius``, and the least distance between two centres."""
    count, closest = 0, np.inf
    for robot in range(cells.shape[1] - 1):
        offsets = cells[:, robot + 1 :] - cells[:, robot, None]
        begin, moves = offsets[:-1], np.diff(offsets, axis=0)
        square = (moves**2).sum(axis=2)
        along = -(begin * moves).sum(axis=2)
        share = np.clip(np.divide(along, square, out=np.zeros_like(square), where=square > 0.0), 0.0, 1.0)
        nearest = begin + share[..., None] * moves
        gaps = np.hypot(nearest[..., 0], nearest[..., 1])
        touching = gaps < radius
        count += int(touching[0].sum() + (touching[1:] & ~touching[:-1]).sum())
        closest = min(closest, float(gaps.min()))
    return count, closest
