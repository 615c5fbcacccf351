"""The reason that robots of a run did not arrive, and a remedy: other parameters with which all arrive, as tried."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from codesign.planners.velocity_obstacle.plan.avoid import avoid
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.faults import fault_of, least_range
from codesign.planners.velocity_obstacle.plan.parameters import MOST_UPDATES, AvoidParameters, Detection, Responsibility
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
