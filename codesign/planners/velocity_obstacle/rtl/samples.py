"""Random design points: crowded robots, so that candidates are refused for every reason."""

from __future__ import annotations

import math

import numpy as np

from codesign.ground.errors import InputError
from codesign.planners.job import Job
from codesign.planners.velocity_obstacle.plan.faults import fault_of, least_range
from codesign.planners.velocity_obstacle.plan.parameters import (
    LEAST_WIDTH,
    MOST_WIDTH,
    AvoidParameters,
    Detection,
    Detector,
    Gains,
    Responsibility,
    Unit,
)
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem, generate
from codesign.planners.velocity_obstacle.published import Style

MOST_SAMPLE_ROBOTS = 9
MOST_SAMPLE_UPDATES = 24

AvoidJob = Job[RobotsProblem, AvoidParameters]


def random_job(style: Style, seed: int) -> AvoidJob:
    """Two to nine robots in any arrangement, and every option at random, of the least width or more.

    A drawing that the planner refuses (``fault_of``) is drawn again.
    """
    random = np.random.default_rng([seed, list(Style).index(style), 2013])
    while True:
        try:
            problem = _problem(random)
        except InputError:
            continue
        parameters = _parameters(random, problem, style)
        if fault_of(problem, parameters) is None:
            return Job(problem, parameters)


def _problem(random: np.random.Generator) -> RobotsProblem:
    side = float(random.choice([20.0, 40.0, 60.0, 100.0]))
    speed = float(random.uniform(0.5, 12.0))
    return generate(
        str(random.choice(["circle", "crossing", "random"])),
        int(random.integers(2, MOST_SAMPLE_ROBOTS + 1)),
        radius=float(random.uniform(0.5, 2.0)),
        speed=speed,
        acceleration=speed * float(random.uniform(2.0, 10.0)),
        arena=(side, side),
        seed=int(random.integers(2**32)),
    )


def _parameters(random: np.random.Generator, problem: RobotsProblem, style: Style) -> AvoidParameters:
    proportional = float(random.uniform(0.1, 1.0))
    most_damped = math.sqrt(proportional) - proportional
    gains = Gains(proportional=proportional, derivative=float(random.uniform(0.0, 0.99)) * most_damped)
    parameters = AvoidParameters(
        width=int(random.integers(LEAST_WIDTH, MOST_WIDTH + 1)),
        time_step=f"{int(random.integers(100, 501))} ms",
        updates=int(random.integers(1, MOST_SAMPLE_UPDATES + 1)),
        directions=8 * int(random.integers(2, 9)),
        speeds=int(random.integers(1, 7)),
        turn=float(random.choice([60.0, 135.0, 180.0])),
        detection=random.choice(list(Detection)),
        responsibility=random.choice(list(Responsibility)),
        margin=float(random.uniform(0.0, 1.0)),
        tolerance=float(random.uniform(0.5, 4.0)),
        gains=Gains() if random.random() < 1 / 2 else gains,
        detector=random.choice(list(Detector)),
        unit=random.choice(list(Unit)),
    )
    if random.random() < 1 / 2:
        sight = least_range(problem, parameters) * float(random.uniform(1.0, 1.5))
        parameters = parameters.model_copy(update={"range": sight})
    if style is not Style.SEQUENTIAL and random.random() < 2 / 3:
        units = {
            "update_units": int(random.integers(1, problem.count + 1)),
            "detect_units": int(random.integers(1, problem.count)),
        }
        parameters = parameters.model_copy(update=units)
    return parameters
