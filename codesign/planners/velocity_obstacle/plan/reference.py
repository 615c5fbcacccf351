"""The choice of a robot in plain lines, in either arithmetic. The compiled kernel equals it bit for bit.

The modules and the equations come from Dubey et al. 2013, sections III and IV.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from codesign.planners.velocity_obstacle.plan.arithmetic import Arithmetic, Number
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, Detection, Responsibility

BRAKE = -1
"""In place of a candidate: none is safe, so the robot brakes."""
STAY = -2
"""In place of a candidate: the robot has arrived and comes to rest."""


@dataclass
class RobotState:
    """State of one robot: position, velocity, and the PID's sum of errors and last error, as (x, y)."""

    position: tuple[Number, Number]
    target: tuple[Number, Number]
    velocity: tuple[Number, Number] = (0, 0)
    error_sum: tuple[Number, Number] = (0, 0)
    last_error: tuple[Number, Number] = (0, 0)
    arrived: bool = False


@dataclass(frozen=True)
class Choice:
    """The decision of one robot in one update.

    ``candidate``: speed level × directions + direction of the array of velocities, or ``BRAKE`` or ``STAY``.
    ``velocity``: the velocity to reach. ``checks``: candidates looked at; ``trials``: those that the acceleration
    allows, which are then tested against all other robots.
    """

    candidate: int
    velocity: tuple[Number, Number]
    checks: int
    trials: int


def pos_vel_update(
    numbers: Arithmetic,
    position: tuple[Number, Number],
    velocity: tuple[Number, Number],
    acceleration: tuple[Number, Number],
) -> tuple[tuple[Number, Number], tuple[Number, Number]]:
    """Equations 2a and 2b, resolved in x and y: six products."""
    moved, changed = [], []
    for r, v, a in zip(position, velocity, acceleration, strict=True):
        changed.append(v + numbers.rescale(a * numbers.step, "acceleration_step"))
        moved.append(
            r
            + numbers.rescale(v * numbers.step, "velocity_step")
            + numbers.rescale(a * numbers.half_square, "acceleration_half_square")
        )
    return (moved[0], moved[1]), (changed[0], changed[1])


def coll_detect(
    numbers: Arithmetic, position: tuple[Number, Number], velocity: tuple[Number, Number], detection: Detection
) -> bool:
    """Equation 4 for a relative position and velocity: nine products; True: on a collision course.

    Robots beyond the range, if there is one, are not on a collision course yet.
    """
    (x, y), (vx, vy) = position, velocity
    r_sq, vab_sq, dotp = x * x + y * y, vx * vx + vy * vy, x * vx + y * vy
    if numbers.range_squared is not None and r_sq > numbers.range_squared:
        return False
    safe = r_sq * vab_sq - dotp * dotp >= numbers.radius_squared * vab_sq
    if detection is Detection.APPROACHING:
        return bool(not safe and dotp < 0)
    return not safe


def to_goal(numbers: Arithmetic, robot: RobotState) -> int:
    """The direction of the array of velocities that is nearest to the direction of the target."""
    x, y = robot.target[0] - robot.position[0], robot.target[1] - robot.position[1]
    along, across = max(abs(x), abs(y)), min(abs(x), abs(y))
    direction = sum(1 for cosine, sine in numbers.bounds if across * cosine > along * sine)
    count = numbers.directions
    if abs(y) > abs(x):
        direction = count // 4 - direction
    if x < 0:
        direction = count // 2 - direction
    return (-direction if y < 0 else direction) % count


def candidates(numbers: Arithmetic, heading: int) -> Iterator[int]:
    """The velocity selector: the target's direction first, then rotating in both directions; then the same, slower."""
    count = numbers.directions
    for speed in range(numbers.speeds):
        for turn in range(numbers.turns):
            rotation = (turn + 1) // 2 if turn % 2 else -(turn // 2)
            yield speed * count + (heading + rotation) % count


def brake(numbers: Arithmetic, velocity: tuple[Number, Number]) -> tuple[Number, Number]:
    """The velocity nearest to rest that one step of braking reaches, each component by itself."""
    x, y = (v - max(-numbers.brake, min(numbers.brake, v)) for v in velocity)
    return x, y


def change_to(numbers: Arithmetic, robot: RobotState, candidate: int) -> tuple[Number, Number] | None:
    """The change of velocity to a candidate, or None where the acceleration does not allow it in one step."""
    speed, direction = divmod(candidate, numbers.directions)
    wanted = numbers.velocities[speed][direction]
    x, y = wanted[0] - robot.velocity[0], wanted[1] - robot.velocity[1]
    return None if x * x + y * y > numbers.change_squared else (x, y)


def take(
    numbers: Arithmetic, robot: RobotState, change: tuple[Number, Number]
) -> tuple[tuple[Number, Number], tuple[Number, Number]]:
    """Position and velocity of a robot after a step with the acceleration of a ``change`` of velocity."""
    x, y = (numbers.rescale(component * numbers.inverse_step, "change_inverse_step") for component in change)
    return pos_vel_update(numbers, robot.position, robot.velocity, (x, y))


def choose(numbers: Arithmetic, robots: Sequence[RobotState], index: int, parameters: AvoidParameters) -> Choice:
    """The velocity that robot ``index`` takes: the first achievable one with which all equations hold.

    All robots are updated by one step first, the others with their present velocities. The equations are tested there.
    A trial with a position that leaves its word is refused, as by the overflow bit of the unit.
    """
    robot = robots[index]
    if robot.arrived:
        return Choice(STAY, brake(numbers, robot.velocity), 0, 0)
    others = [
        pos_vel_update(numbers, other.position, other.velocity, (0, 0))
        for number, other in enumerate(robots)
        if number != index
    ]
    checks = trials = 0
    for candidate in candidates(numbers, to_goal(numbers, robot)):
        checks += 1
        change = change_to(numbers, robot, candidate)
        if change is None:
            continue
        trials += 1
        position, velocity = take(numbers, robot, change)
        if fits(numbers, *position) and not any(
            _on_course(numbers, robot.velocity, position, velocity, other, parameters) for other in others
        ):
            return Choice(candidate, velocity, checks, trials)
    return Choice(BRAKE, brake(numbers, robot.velocity), checks, trials)


def _on_course(
    numbers: Arithmetic,
    now: tuple[Number, Number],
    position: tuple[Number, Number],
    velocity: tuple[Number, Number],
    other: tuple[tuple[Number, Number], tuple[Number, Number]],
    parameters: AvoidParameters,
) -> bool:
    (px, py), (qx, qy) = position, other[0]
    vx, vy = velocity
    if parameters.responsibility is Responsibility.HALF:
        vx, vy = 2 * vx - now[0], 2 * vy - now[1]
    relative = vx - other[1][0], vy - other[1][1]
    return coll_detect(numbers, (px - qx, py - qy), relative, parameters.detection)


def pid(
    numbers: Arithmetic, robot: RobotState, wanted: tuple[Number, Number]
) -> tuple[tuple[Number, Number], tuple[Number, Number], tuple[Number, Number]]:
    """The acceleration that the PID control gives towards ``wanted``, its sum of errors and its error.

    The sum is clipped to the greatest speed, and the result to the greatest acceleration of one axis.
    """
    accelerations, sums, errors = [], [], []
    for axis in range(2):
        error = wanted[axis] - robot.velocity[axis]
        total = max(-numbers.speed, min(numbers.speed, robot.error_sum[axis] + error))
        terms = error, total, error - robot.last_error[axis]
        drive = sum(numbers.rescale(gain * term, "gain") for gain, term in zip(numbers.gains, terms, strict=True))
        accelerations.append(max(-numbers.acceleration, min(numbers.acceleration, drive)))
        sums.append(total)
        errors.append(error)
    return (accelerations[0], accelerations[1]), (sums[0], sums[1]), (errors[0], errors[1])


def fits(numbers: Arithmetic, *values: Number) -> bool:
    """True if every value fits the words; doubles always do."""
    if numbers.formats is None:
        return True
    limit = 1 << (numbers.formats.width - 1)
    return all(-limit <= value < limit for value in values)
