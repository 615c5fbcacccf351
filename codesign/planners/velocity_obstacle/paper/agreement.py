"""The bound on the difference between fixed point and doubles in one choice, and a check of it.

From the same state both take the same candidate, unless a candidate's change of velocity, its distance of
closest approach to another robot, or the direction of the target lies so near its threshold that rounding
decides. The formats alone bound this distance from a threshold. An ulp is the unit of a format:

- change of velocity: (1 + √½) ulp of a velocity: each component of the array is rounded, the limit cut;
- relative velocity: the rounding of the candidate, of its acceleration and of the constants; twice that for
  reciprocal obstacles;
- relative position: three rounded products, and the rounded constants;
- range: the error of the position, and one ulp of rounding;
- closest approach d = |r × V| / |V|: the error of the position, |r| times the angle by which V may be turned,
  and one ulp of the radius.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from codesign.planners.velocity_obstacle.plan import reference
from codesign.planners.velocity_obstacle.plan.arithmetic import Arithmetic, Formats, double, fixed
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, Detection, Responsibility
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.plan.reference import BRAKE, Choice, RobotState


class Verdict(StrEnum):
    """The comparison of a choice in fixed point with that in doubles."""

    SAME = "same"
    NEAR_THRESHOLD = "near_threshold"
    BEYOND_BOUND = "beyond_bound"


@dataclass(frozen=True)
class Bounds:
    """The most that rounding moves a quantity in one choice.

    ``direction``: rad. ``change``, ``velocity``: cells/s, lengths of vectors. ``position``, ``radius``: cells.
    """

    direction: float
    change: float
    velocity: float
    position: float
    radius: float


def bounds(problem: RobotsProblem, parameters: AvoidParameters, formats: Formats) -> Bounds:
    """The bounds of a problem in these formats."""
    position, velocity, acceleration = (
        math.ldexp(1.0, -bits) for bits in (formats.position, formats.velocity, formats.acceleration)
    )
    step, half_square, inverse = (
        math.ldexp(0.5, -bits) for bits in (formats.step, formats.half_square, formats.inverse_step)
    )
    time, greatest = parameters.step, problem.acceleration
    drive = velocity / 2.0 / time + problem.acceleration * time * inverse + acceleration / 2.0
    changed = drive * time + greatest * step + velocity / 2.0
    # A reciprocal obstacle is tested at 2v' - v - v2: the error of v' counts twice.
    factor = 2.0 if parameters.responsibility is Responsibility.HALF else 1.0
    moved = 1.5 * position + 2.0 * problem.speed * step + greatest * half_square + drive * time**2 / 2.0
    return Bounds(
        direction=math.sqrt(2.0) * math.ldexp(1.0, -formats.direction),
        change=(1.0 + math.sqrt(0.5)) * velocity,
        velocity=math.sqrt(2.0) * factor * changed,
        position=math.sqrt(2.0) * moved,
        radius=position,
    )


def compare(
    problem: RobotsProblem, parameters: AvoidParameters, robots: Sequence[RobotState], index: int
) -> tuple[Verdict, Choice, Choice]:
    """The choice of one robot in fixed point and in doubles, from a state given in fixed point.

    ``BEYOND_BOUND`` would be a fault of the arithmetic. A test checks that it does not occur.
    """
    exact, rounded = double(problem, parameters), fixed(problem, parameters)
    real = [in_doubles(rounded, robot) for robot in robots]
    choices = (reference.choose(rounded, robots, index, parameters), reference.choose(exact, real, index, parameters))
    if choices[0].candidate == choices[1].candidate:
        return Verdict.SAME, *choices
    assert rounded.formats is not None
    limits = bounds(problem, parameters, rounded.formats)
    explained = _heading_is_near(exact, real[index], limits) or _candidate_is_near(
        exact, real, index, parameters, choices, limits
    )
    return (Verdict.NEAR_THRESHOLD if explained else Verdict.BEYOND_BOUND), *choices


def in_doubles(numbers: Arithmetic, robot: RobotState) -> RobotState:
    """The same state in cells and cells/s."""
    return RobotState(
        (numbers.to_cells(robot.position[0]), numbers.to_cells(robot.position[1])),
        (numbers.to_cells(robot.target[0]), numbers.to_cells(robot.target[1])),
        (numbers.to_speed(robot.velocity[0]), numbers.to_speed(robot.velocity[1])),
        arrived=robot.arrived,
    )


def _heading_is_near(exact: Arithmetic, robot: RobotState, limits: Bounds) -> bool:
    """True if the target's direction lies on the border of two directions of the array, within the bound."""
    x, y = robot.target[0] - robot.position[0], robot.target[1] - robot.position[1]
    sector = 2.0 * math.pi / exact.directions
    away = (math.atan2(y, x) / sector - 0.5) % 1.0
    return min(away, 1.0 - away) * sector <= limits.direction


def _candidate_is_near(
    exact: Arithmetic,
    robots: Sequence[RobotState],
    index: int,
    parameters: AvoidParameters,
    choices: tuple[Choice, Choice],
    limits: Bounds,
) -> bool:
    """True if the first candidate that one choice takes and the other refuses is near a threshold."""
    robot = robots[index]
    candidate = next(
        offered
        for offered in reference.candidates(exact, reference.to_goal(exact, robot))
        if offered in {choice.candidate for choice in choices if choice.candidate != BRAKE}
    )
    wanted = exact.velocities[candidate // exact.directions][candidate % exact.directions]
    change = wanted[0] - robot.velocity[0], wanted[1] - robot.velocity[1]
    if abs(math.hypot(*change) - math.sqrt(exact.change_squared)) <= limits.change:
        return True
    acceleration = change[0] * exact.inverse_step, change[1] * exact.inverse_step
    there = reference.pos_vel_update(exact, robot.position, robot.velocity, acceleration)
    for number, other in enumerate(robots):
        if number != index:
            step = reference.pos_vel_update(exact, other.position, other.velocity, (0.0, 0.0))
            if _test_is_near(exact, robot.velocity, there, step, parameters, limits):
                return True
    return False


def _test_is_near(
    exact: Arithmetic,
    now: tuple[float, float],
    there: tuple[tuple[float, float], tuple[float, float]],
    other: tuple[tuple[float, float], tuple[float, float]],
    parameters: AvoidParameters,
    limits: Bounds,
) -> bool:
    x, y = (a - b for a, b in zip(there[0], other[0], strict=True))
    own = there[1]
    if parameters.responsibility is Responsibility.HALF:
        own = 2.0 * own[0] - now[0], 2.0 * own[1] - now[1]
    vx, vy = (a - b for a, b in zip(own, other[1], strict=True))
    distance, speed = math.hypot(x, y), math.hypot(vx, vy)
    if exact.range_squared is not None:
        beyond = distance - math.sqrt(exact.range_squared)
        if abs(beyond) <= limits.position + limits.radius:
            return True
        if beyond > 0.0:
            return False
    if speed <= limits.velocity:
        return True
    closest = abs(x * vy - y * vx) / speed
    turned = distance * math.asin(limits.velocity / speed)
    if abs(closest - math.sqrt(exact.radius_squared)) <= limits.position + turned + limits.radius:
        return True
    spread = limits.position * speed + (distance + limits.position) * limits.velocity
    return parameters.detection is Detection.APPROACHING and abs(x * vx + y * vy) <= spread
