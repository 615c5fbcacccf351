"""Velocity obstacles as a plug-in: the members of ``Planner``, the quality of a run, and its remedies."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.ground.models import TaskParameters
from codesign.planners.interface import Planner, RobotsQuality
from codesign.planners.job import Flow, Job
from codesign.planners.velocity_obstacle.plan.avoid import avoid, fault_of, least_range
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.parameters import (
    MOST_UPDATES,
    AvoidParameters,
    Detection,
    Responsibility,
    RobotsWorkload,
)
from codesign.planners.velocity_obstacle.plan.problem import LARGEST_ARENA, RobotsProblem
from codesign.planners.velocity_obstacle.plan.reference import BRAKE, STAY

DESCRIBED = 3
"""The most robots that a sentence describes one by one."""
MOST_TRIED = 2**24
"""Robots² × updates of a run that is tried for a remedy: about a quarter of a second."""
_TURN = 135.0
_SIGHT = 1.4
"""A range to try, in multiples of the least: 20 cells with the robots that are taken by default."""


def shortfall_of(problem: RobotsProblem, plan: Avoidance, arrivals: list[int | None]) -> str | None:
    """The robots that did not arrive and their last states, or the value that left its word; None if all arrived."""
    left = [robot for robot, arrival in enumerate(arrivals) if arrival is None]
    if not left:
        return None
    causes = [] if plan.departure is None else [str(plan.departure)]
    there = f"after {plan.updates:,} updates {problem.count - len(left)} of {problem.count} robots have arrived"
    robots = [_state(problem, plan, robot) for robot in left[:DESCRIBED]]
    if len(left) > DESCRIBED:
        robots.append(f"and {len(left) - DESCRIBED} more")
    return "; ".join([*causes, f"{there}: {', '.join(robots)}"])


def _state(problem: RobotsProblem, plan: Avoidance, robot: int) -> str:
    """The place of a robot at the end of a run, and since when it has no safe velocity, if it has none."""
    x, y = plan.cells[-1, robot].tolist()
    far = math.dist((x, y), problem.targets[robot].tolist())
    moves = "drives" if plan.velocities[-1, robot].any() else "stands"
    own = plan.candidates[:, robot]
    safe = np.flatnonzero(own != BRAKE)
    since = int(safe[-1]) + 1 if len(safe) else 0
    waits = f", without a safe velocity since update {since + 1:,}" if since < len(own) else ""
    return f"robot {robot} {moves} at ({x:.0f}, {y:.0f}), {far:.3g} cells from its target{waits}"


def remedy_of(problem: RobotsProblem, plan: Avoidance) -> str | None:
    """The first of some changes with which all robots arrive, as tried in a run without a clock; None where none does.

    Runs that would take long to try are left out.
    """
    if not plan.in_step and _arrives(problem, plan.parameters):
        return "decisions within their time steps: with that all robots arrive, as tried without a clock"
    for changes in _changes(problem, plan.parameters):
        changed = plan.parameters.model_copy(update=changes)
        if fault_of(problem, changed) is None and _arrives(problem, changed):
            named = ", ".join(f"{name}: {_text(value)}" for name, value in changes.items())
            within = "" if plan.in_step else " and decisions within their time steps"
            return f"{named}{within}: with that all robots arrive, as tried without a clock"
    return None


def _arrives(problem: RobotsProblem, parameters: AvoidParameters) -> bool:
    if problem.count**2 * parameters.updates > MOST_TRIED:
        return False
    last = avoid(problem, parameters).candidates[-1:]
    return bool(last.size) and bool((last == STAY).all())


def _changes(problem: RobotsProblem, parameters: AvoidParameters) -> Iterator[dict[str, Any]]:
    """Changes to try, each once: of one rule, then of several, then a longer run."""
    far = float(math.ceil(_SIGHT * least_range(problem, parameters)))
    turn = {"turn": _TURN} if parameters.turn > _TURN else {}
    sight = {"range": far} if parameters.range is None and far <= LARGEST_ARENA else {}
    published = parameters.detection is Detection.PUBLISHED
    approaching = {"detection": Detection.APPROACHING} if published else {}
    half = {"responsibility": Responsibility.HALF} if parameters.responsibility is Responsibility.FULL else {}
    longer = {"updates": min(2 * parameters.updates, MOST_UPDATES)}
    rules: dict[str, Any] = approaching | half
    several = (turn | sight, rules, rules | turn, rules | turn | sight)
    tried: list[dict[str, Any]] = [{}]
    for changes in (turn, sight, approaching, half, *several, longer):
        if changes not in tried:
            tried.append(changes)
            yield changes


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else f"{value}"


gaps = late("codesign.planners.velocity_obstacle.plan.kernels")


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


STATE_BYTES = 120
"""Bytes of a robot at one update: 44 in words, 32 in cells, and the rest for the run's quality."""

COORDINATE_BITS = 16
"""A coordinate on a link, whatever the width of the words inside: assumed, two bytes on a serial line."""


class VelocityObstacle(Planner):
    """Collision avoidance of n robots with acceleration limits: one task, ``avoid``, on a ``RobotsProblem``."""

    name = "velocity_obstacle"
    planning_task = "avoid"
    tasks: Mapping[str, type[TaskParameters]] = {"avoid": AvoidParameters}
    problem_model = RobotsWorkload
    fields_a_stage = 0
    description = "several robots that avoid each other, in fixed point (Dubey et al. 2013)"

    def check(self, job: Job[RobotsProblem, AvoidParameters]) -> tuple[str, str] | None:
        """The array of velocities must be fine enough for the acceleration, and the words wide enough."""
        return fault_of(job.problem, job.parameters)

    def reachable(self, job: Job[RobotsProblem, AvoidParameters]) -> NDArray[np.bool_]:
        """Every cell of the arena, which has no obstacles: bool rows × columns."""
        width, height = job.problem.arena
        return np.ones((math.ceil(height), math.ceil(width)), np.bool_)

    def plan(self, job: Job[RobotsProblem, AvoidParameters]) -> Avoidance:
        """Run all robots in the closed loop, without a clock."""
        return avoid(job.problem, job.parameters)

    def flows(self, job: Job[RobotsProblem, AvoidParameters]) -> tuple[Flow, ...]:
        """Start and target of each robot, and the robots' coordinates once, for the display (section VI)."""
        coordinates = 2 * COORDINATE_BITS * job.problem.count
        return (Flow("load", "avoid", "robots", 2 * coordinates), Flow("avoid", "command", "coordinates", coordinates))

    def memory(self, job: Job[RobotsProblem, AvoidParameters]) -> int:
        """For each robot and update positions, velocities and counts, in words and once more in cells."""
        return STATE_BYTES * job.problem.count * (job.parameters.updates + 1)

    def quality(self, problem: RobotsProblem, plan: Avoidance) -> RobotsQuality:
        """Collisions, arrivals and detours of the run."""
        return quality(problem, plan)

    def identity(self, plan: Avoidance) -> str:
        """The digest of all states of the run, and its parameters, on which its remedy depends."""
        return f"{plan.digest} {plan.parameters.model_dump_json()}"

    def figures(self, plan: Avoidance) -> dict[str, Any]:
        """The decisions of the run, their candidates, and the resolution of its words."""
        decisions = int((plan.checks > 0).sum())
        return {
            "details": {
                "updates": plan.updates,
                "decisions": decisions,
                "trials": int(plan.trials.sum()),
                "trials_a_decision_mean": float(plan.trials.sum() / decisions) if decisions else 0.0,
                "trials_a_decision_most": int(plan.trials.max(initial=0)),
                "acceleration_checks": int(plan.checks.sum()),
                "decisions_without_safe_velocity": int((plan.candidates == BRAKE).sum()),
                "position_resolution_cells": 2.0**-plan.formats.position,
                "velocity_resolution_cells_a_second": 2.0**-plan.formats.velocity,
            }
        }

    def trajectory(self, problem: RobotsProblem, plan: Avoidance, start: int) -> tuple[NDArray[np.float64], bool]:
        """The path of robot number ``start``: float64 (updates + 1) × 2 (row, column), and whether it arrives.

        Cells are counted from their middle as everywhere: (x, y) of a robot is (column + 0.5, row + 0.5).
        """
        assert 0 <= start < problem.count
        return plan.cells[:, start, ::-1] - 0.5, arrival_updates(plan)[start] is not None


PLANNER = VelocityObstacle()
