"""n robots in the closed loop, without a clock: the planner's answer, and why parameters do not suit a problem."""

from __future__ import annotations

import math

from codesign.ground.errors import InputError
from codesign.ground.late import late
from codesign.planners.velocity_obstacle.plan.arithmetic import formats_of, least_width, width_fault
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.parameters import MOST_DIRECTIONS, MOST_SPEEDS, AvoidParameters
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem

MOST_STATES = 2**22
"""Robots × updates of one run: bounds its memory to some hundred megabytes."""


def fault_of(problem: RobotsProblem, parameters: AvoidParameters) -> tuple[str, str] | None:
    """The reason why these parameters do not suit this problem, as (parameter, sentence), or None."""
    return (
        _coarse_array(problem, parameters)
        or _long_run(problem, parameters)
        or _short_sight(problem, parameters)
        or _narrow_words(problem, parameters)
        or _wide_constants(problem, parameters)
    )


def least_range(problem: RobotsProblem, parameters: AvoidParameters) -> float:
    """Cells at which two robots must see each other: both drive on for an update and then brake."""
    brake = problem.speed**2 / problem.acceleration
    return 2.0 * problem.radius + parameters.margin + 2.0 * problem.speed * parameters.step + brake


def _coarse_array(problem: RobotsProblem, parameters: AvoidParameters) -> tuple[str, str] | None:
    """The array of velocities must be fine enough for the acceleration.

    From every velocity of the array the robot must reach two others in one step: with its acceleration the next
    speed and direction, and with √½ of it the next direction alone. Otherwise it may circle at a low speed for ever.
    Values are shares of the greatest speed: in these no limit is too small or too large for a double.
    """
    reach = problem.acceleration / problem.speed * parameters.step
    chord = 2.0 * math.sin(math.pi / parameters.directions)
    if chord > reach * math.sqrt(0.5):
        half_turn = math.asin(min(1.0, reach * math.sqrt(0.5) / 2.0))
        most = math.pi / MOST_DIRECTIONS
        least = 8 * math.ceil(math.pi / half_turn / 8.0) if half_turn >= most else MOST_DIRECTIONS + 1
        return "directions", _too_coarse(
            problem, "directions", parameters.directions, chord, reach, least, MOST_DIRECTIONS
        )
    level = 1.0 / parameters.speeds
    if math.hypot(level, chord) >= reach:
        least = math.floor(1.0 / math.sqrt(reach**2 - chord**2)) + 1
        return "speeds", _too_coarse(problem, "speeds", parameters.speeds, level, reach, least, MOST_SPEEDS)
    return None


def _too_coarse(
    problem: RobotsProblem, name: str, count: int, apart: float, reach: float, least: int, most: int
) -> str:
    mend = f"{least} {name} or more" if least <= most else "a longer time step"
    return (
        f"{count} {name} lie {apart * problem.speed:.3g} cells/s apart, and a step changes a velocity by"
        f" {reach * problem.speed:.3g} at most: {mend}"
    )


def _long_run(problem: RobotsProblem, parameters: AvoidParameters) -> tuple[str, str] | None:
    if problem.count * parameters.updates <= MOST_STATES:
        return None
    most = MOST_STATES // problem.count
    return "updates", f"{parameters.updates:,} updates of {problem.count} robots: at most {most:,}"


def _short_sight(problem: RobotsProblem, parameters: AvoidParameters) -> tuple[str, str] | None:
    sight = least_range(problem, parameters)
    if parameters.range is None or parameters.range >= sight:
        return None
    return ("range", f"two robots {parameters.range:g} cells apart can no longer brake: {sight:.4g} cells or more")


def _narrow_words(problem: RobotsProblem, parameters: AvoidParameters) -> tuple[str, str] | None:
    narrow = width_fault(problem, parameters, parameters.width)
    if narrow is None:
        return None
    wider = least_width(problem, parameters)
    mend = "no width of up to 24 mends that" if wider is None else f"{wider} bits or more"
    return "width", f"{narrow}: {mend}"


def _wide_constants(problem: RobotsProblem, parameters: AvoidParameters) -> tuple[str, str] | None:
    """Distances that are constants of the circuit must fit the words of a position, like all its constants."""
    formats = formats_of(problem, parameters, parameters.width)
    reach = math.ldexp(1.0, formats.width - 1 - formats.position)
    words = f"positions have words of {formats.width} bits, which reach to {reach:g} cells"
    apart = 2.0 * problem.radius + parameters.margin
    if apart >= reach:
        most = reach - 2.0 * problem.radius
        mend = f"a margin below {most:.4g} cells" if most > 0.0 else "smaller robots, or a larger arena"
        return "margin", f"robots that keep {apart:g} cells apart have no room, as {words}: {mend}"
    if parameters.tolerance >= reach:
        away = f"no robot is {parameters.tolerance:g} cells from its target"
        return "tolerance", f"{away}, as {words}: below {reach:g} cells"
    if parameters.range is not None and parameters.range >= 2.0 * math.sqrt(2.0) * reach:
        return ("range", f"no two robots are {parameters.range:g} cells apart, as {words}: less, or no range at all")
    return None


loop = late("codesign.planners.velocity_obstacle.plan.loop")


def avoid(problem: RobotsProblem, parameters: AvoidParameters) -> Avoidance:
    """Run all robots until they stand at their targets, or ``parameters.updates`` are done, or a value leaves its word.

    All decide at the same time from the same state, each on its own FPGA. Every decision takes effect within its time
    step. The run ends in the same bits as ``reference.run`` with ``arithmetic.fixed``.

    Raises:
        InputError: the parameters do not suit this problem (``fault_of``).
    """
    fault = fault_of(problem, parameters)
    if fault is not None:
        raise InputError(fault[1], fault[0])
    run = loop.Loop(problem, parameters)
    run.run()
    plan: Avoidance = run.plan()
    return plan
