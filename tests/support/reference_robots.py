"""The closed loop of robots in plain lines, in either arithmetic: the reference of the kernel, bit for bit.

The choice of one robot stands in ``plan.reference``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from codesign.planners.velocity_obstacle.plan.arithmetic import Arithmetic, Number
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.plan.reference import Choice, RobotState, choose, fits, pid, pos_vel_update


@dataclass
class History:
    """The states of a run, beginning with the start, their times in time steps, and the choices."""

    positions: list[list[tuple[Number, Number]]] = field(default_factory=list)
    velocities: list[list[tuple[Number, Number]]] = field(default_factory=list)
    times: list[int] = field(default_factory=list)
    choices: list[list[Choice]] = field(default_factory=list)
    overflow: bool = False

    def note(self, robots: Sequence[RobotState], steps: int) -> None:
        """Add the state of the robots, ``steps`` time steps after the state before."""
        self.positions.append([robot.position for robot in robots])
        self.velocities.append([robot.velocity for robot in robots])
        self.times.append(steps + (self.times[-1] if self.times else 0))


def target_check(numbers: Arithmetic, robot: RobotState) -> bool:
    """True if the robot's centre is within the tolerance of its target."""
    x, y = robot.target[0] - robot.position[0], robot.target[1] - robot.position[1]
    return bool(x * x + y * y <= numbers.tolerance_squared)


def decide(numbers: Arithmetic, robots: Sequence[RobotState], parameters: AvoidParameters) -> tuple[list[Choice], bool]:
    """The choices of all robots, at the same time and from the same state, and whether a value overflows.

    A robot that one step at its present velocity takes out of its words is an overflow. Only ``arrived`` changes.
    """
    for robot in robots:
        robot.arrived = robot.arrived or target_check(numbers, robot)
    choices = [choose(numbers, robots, index, parameters) for index in range(len(robots))]
    return choices, not all(
        fits(numbers, *pos_vel_update(numbers, robot.position, robot.velocity, (0, 0))[0]) for robot in robots
    )


def hold(numbers: Arithmetic, robots: Sequence[RobotState], steps: int) -> bool:
    """Drive on for ``steps`` time steps with the present velocities; returns whether a robot left its words."""
    for _ in range(steps):
        for robot in robots:
            robot.position, _ = pos_vel_update(numbers, robot.position, robot.velocity, (0, 0))
        if not all(fits(numbers, *robot.position) for robot in robots):
            return True
    return False


def act(numbers: Arithmetic, robots: Sequence[RobotState], choices: Sequence[Choice]) -> bool:
    """One time step in which PID control drives each robot to its chosen velocity; returns whether a value left its
    word."""
    overflow = False
    for robot, choice in zip(robots, choices, strict=True):
        acceleration, robot.error_sum, robot.last_error = pid(numbers, robot, choice.velocity)
        robot.position, robot.velocity = pos_vel_update(numbers, robot.position, robot.velocity, acceleration)
        overflow |= not fits(numbers, *robot.position, *robot.velocity, *robot.last_error, *choice.velocity)
    return overflow


def update(numbers: Arithmetic, robots: Sequence[RobotState], parameters: AvoidParameters) -> tuple[list[Choice], bool]:
    """One update that is decided within its time step: the choices, and whether a value overflows.

    ``robots`` are left in the new state.
    """
    choices, overflow = decide(numbers, robots, parameters)
    return choices, act(numbers, robots, choices) or overflow


def start(numbers: Arithmetic, problem: RobotsProblem) -> list[RobotState]:
    """All robots at rest at their starts."""
    return [
        RobotState(
            (numbers.position(place[0]), numbers.position(place[1])),
            (numbers.position(target[0]), numbers.position(target[1])),
        )
        for place, target in zip(problem.positions.tolist(), problem.targets.tolist(), strict=True)
    ]


def run(
    numbers: Arithmetic,
    problem: RobotsProblem,
    parameters: AvoidParameters,
    held: Callable[[Sequence[Choice]], int] = lambda _: 0,
) -> History:
    """The closed loop: updates until all robots stand at their targets, or ``parameters.updates`` are done.

    ``held``: from the choices, the number of time steps for which the robots drive on before they act; by default 0.
    The history also has the states at the end of these steps.
    """
    robots = start(numbers, problem)
    history = History()
    history.note(robots, 0)
    for _ in range(parameters.updates):
        choices, history.overflow = decide(numbers, robots, parameters)
        steps = held(choices)
        if not history.overflow and steps:
            history.overflow = hold(numbers, robots, steps)
            history.note(robots, steps)
        if not history.overflow:
            history.overflow = act(numbers, robots, choices)
            history.note(robots, 1)
        if not history.overflow:
            history.choices.append(choices)
        at_rest = all(robot.arrived and not any(robot.velocity) for robot in robots)
        if history.overflow or at_rest:
            break
    return history
