"""n robots in the closed loop: the planner's answer, and what it is made of."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import InputError, RunError
from codesign.planners.velocity_obstacle.arithmetic import Arithmetic, Formats, fixed
from codesign.planners.velocity_obstacle.parameters import (
    MOST_DIRECTIONS,
    MOST_SPEEDS,
    AvoidParameters,
    Detection,
    Responsibility,
)
from codesign.planners.velocity_obstacle.problem import RobotsProblem

MOST_STATES = 2**22
"""Robots × updates of one run: bounds its memory to some hundred megabytes."""


@dataclass(frozen=True, eq=False)
class Avoidance:
    """A run of n robots over u updates in fixed point.

    - ``positions``, ``velocities``: int64 (u + 1) × n × 2, (x, y) in units of ``formats``, the start first.
    - ``candidates``: int32 u × n, speed level × directions + direction, or BRAKE (-1) or STAY (-2).
    - ``checks``: int32 u × n, candidates held against the acceleration; ``trials``: those of them that were then
      held against all other robots.
    - ``step``: time between two updates, s.
    """

    formats: Formats
    positions: NDArray[np.int64]
    velocities: NDArray[np.int64]
    candidates: NDArray[np.int32]
    checks: NDArray[np.int32]
    trials: NDArray[np.int32]
    step: float

    @property
    def updates(self) -> int:
        """Updates done."""
        return len(self.candidates)

    @cached_property
    def cells(self) -> NDArray[np.float64]:
        """Positions in cells, float64 (u + 1) × n × 2, exact."""
        return np.ldexp(self.positions.astype(np.float64), -self.formats.position)

    @cached_property
    def digest(self) -> str:
        """SHA-256 over every state of the run."""
        text = f"{self.formats}{self.positions.shape}"
        content = self.positions.astype("<i8").tobytes() + self.velocities.astype("<i8").tobytes()
        return hashlib.sha256(text.encode() + content).hexdigest()


def avoid(problem: RobotsProblem, parameters: AvoidParameters) -> Avoidance:
    """Run all robots until they stand at their targets, or ``parameters.updates`` are done.

    All decide at the same time from the same state, each on its own FPGA. Ends in the same bits as
    ``reference.run`` with ``arithmetic.fixed``.

    Raises:
        InputError: parameters that this problem cannot be computed with (``fault_of``).
        RunError: a value left its word.
    """
    plan, overflow = avoid_up_to_overflow(problem, parameters)
    if overflow is not None:
        raise overflow
    return plan


def avoid_up_to_overflow(
    problem: RobotsProblem, parameters: AvoidParameters
) -> tuple[Avoidance, RunError | None]:
    """As ``avoid``; where a value leaves its word, the run up to the update before, and what ``avoid`` would raise.

    Raises:
        InputError: parameters that this problem cannot be computed with (``fault_of``).
    """
    fault = fault_of(problem, parameters)
    if fault is not None:
        raise InputError(fault[1], fault[0])
    from codesign.planners.velocity_obstacle import kernels

    numbers = fixed(problem, parameters)
    assert numbers.formats is not None
    places = [
        [[numbers.position(x), numbers.position(y)] for x, y in some.tolist()] for some in _ends(problem)
    ]
    start, targets = (np.array(some, np.int64) for some in places)
    done, positions, velocities, candidates, checks, trials, overflow, robot = kernels.run(
        start,
        targets,
        np.array(numbers.velocities, np.int64),
        np.array(numbers.bounds, np.int64),
        *_constants(numbers),
        parameters.updates,
        parameters.detection is Detection.APPROACHING,
        parameters.responsibility is Responsibility.HALF,
    )
    left = None
    if overflow:
        what = "position" if overflow == kernels.POSITION_OVERFLOW else "velocity"
        left = _overflow(numbers.formats, what, int(robot), int(done), positions[done, robot])
        done -= 1
    plan = Avoidance(
        numbers.formats,
        positions[: done + 1],
        velocities[: done + 1],
        candidates[:done],
        checks[:done],
        trials[:done],
        parameters.step,
    )
    return plan, left


def fault_of(problem: RobotsProblem, parameters: AvoidParameters) -> tuple[str, str] | None:
    """What keeps these parameters from this problem, as (parameter, sentence), or None.

    From every velocity of the array the robot has to reach that of the next speed and the next direction in one
    step of its acceleration, and with √½ of it that of the next direction alone: else it may circle at a low
    speed for ever.
    """
    from codesign.planners.velocity_obstacle.arithmetic import least_width, width_fault

    reach = problem.acceleration * parameters.step
    level = problem.speed / parameters.speeds
    chord = 2.0 * problem.speed * math.sin(math.pi / parameters.directions)
    if chord > reach * math.sqrt(0.5):
        half_turn = math.asin(min(1.0, reach * math.sqrt(0.5) / (2.0 * problem.speed)))
        least = 8 * math.ceil(math.pi / half_turn / 8.0)
        return "directions", _too_coarse(
            "directions", parameters.directions, chord, reach, least, MOST_DIRECTIONS
        )
    if math.hypot(level, chord) >= reach:
        least = math.floor(problem.speed / math.sqrt(reach**2 - chord**2)) + 1
        return "speeds", _too_coarse("speeds", parameters.speeds, level, reach, least, MOST_SPEEDS)
    if problem.count * parameters.updates > MOST_STATES:
        most = MOST_STATES // problem.count
        return "updates", f"{parameters.updates:,} updates of {problem.count} robots: at most {most:,}"
    sight = least_range(problem, parameters)
    if parameters.range is not None and parameters.range < sight:
        return (
            "range",
            f"two robots {parameters.range:g} cells apart can no longer brake: {sight:.4g} cells or more",
        )
    narrow = width_fault(problem, parameters, parameters.width)
    if narrow is not None:
        wider = least_width(problem, parameters)
        mend = "no width of up to 24 mends that" if wider is None else f"{wider} bits or more"
        return "width", f"{narrow}: {mend}"
    return None


def least_range(problem: RobotsProblem, parameters: AvoidParameters) -> float:
    """Cells at which two robots must see each other: both drive on for an update and then brake."""
    brake = problem.speed**2 / problem.acceleration
    return 2.0 * problem.radius + parameters.margin + 2.0 * problem.speed * parameters.step + brake


def _too_coarse(name: str, count: int, apart: float, reach: float, least: int, most: int) -> str:
    mend = f"{least} {name} or more" if least <= most else "a longer time step"
    return f"{count} {name} lie {apart:.3g} cells/s apart, and a step changes a velocity by {reach:.3g} at most: {mend}"


def _ends(problem: RobotsProblem) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return problem.positions, problem.targets


def _constants(numbers: Arithmetic) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Constants and shifts as the kernel takes them."""
    from codesign.planners.velocity_obstacle import kernels

    formats, shifts = numbers.formats, numbers.shifts
    assert formats is not None
    assert shifts is not None
    constants = [
        numbers.step,
        numbers.half_square,
        numbers.inverse_step,
        numbers.change_squared,
        numbers.brake,
        numbers.acceleration,
        numbers.speed,
        numbers.radius_squared,
        numbers.tolerance_squared,
        *numbers.gains,
        1 << (formats.width - 1),
        kernels.NO_RANGE if numbers.range_squared is None else numbers.range_squared,
        numbers.turns,
    ]
    moves = [
        shifts.velocity_step,
        shifts.acceleration_step,
        shifts.acceleration_half_square,
        shifts.change_inverse_step,
        shifts.gain,
    ]
    return np.array(constants, np.int64), np.array(moves, np.int64)


def _overflow(formats: Formats, what: str, robot: int, update: int, position: Any) -> RunError:
    bits = formats.position if what == "position" else formats.velocity
    limit = math.ldexp(1.0, formats.width - 1 - bits)
    unit = "cells" if what == "position" else "cells/s"
    x, y = (math.ldexp(int(value), -formats.position) for value in position)
    return RunError(
        f"the {what} of robot {robot} left its words of {formats.width} bits, which reach to {limit:g} {unit},"
        f" in update {update} near ({x:.0f}, {y:.0f})",
        "width",
        "another seed or detection, smaller gains of the PID control, or fewer updates",
    )
