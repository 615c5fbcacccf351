"""The circuits of the three styles in Verilog-2005: one robot's, from the states of all to its acceleration.

Values follow from the plan: the states of all robots before each update are the load stream, the choices and the PID
control are as in ``plan.reference``. Cycles follow from ``styles.timing``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np

from codesign.ground.errors import Fault, InputError, UnsuitedError
from codesign.planners.circuits import SHARED, Circuit, CircuitStyle, Events, Expected, Image
from codesign.planners.job import Job
from codesign.planners.velocity_obstacle.plan import reference
from codesign.planners.velocity_obstacle.plan.arithmetic import Arithmetic, fixed
from codesign.planners.velocity_obstacle.plan.avoid import avoid, fault_of, least_range
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
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
from codesign.planners.velocity_obstacle.plan.reference import BRAKE, RobotState
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles import timing
from codesign.planners.velocity_obstacle.styles.resources import (
    ARRAY,
    DETECTIONS,
    LAWS,
    REST,
    STATES,
    UPDATES,
    structure,
)

__all__ = ["CIRCUITS", "RobotCircuit"]


# Random design points: crowded robots, so that candidates are refused for every reason.

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


TOO_FAR, COLLIDES, TAKEN, VELOCITY, ACCELERATION = range(5)
KINDS = ("too far", "collides", "taken", "velocity", "acceleration")
"""Events: the verdict on a candidate, with its place in the array; the velocity to reach; the acceleration."""

HERE = Path(__file__).parent
MODULES = (
    "velocity_obstacle",
    "target_check",
    "velocity_selector",
    "direction_bounds",
    "acceleration_check",
    "pid_control",
    "trial",
    "state_bank",
    "pos_vel_update",
    "pos_vel_update_serial",
    "pos_vel_update_parallel",
    "coll_detect",
    "coll_detect_serial",
    "coll_detect_cross",
    "coll_detect_parallel",
    "rescale",
)
PIECES = {
    UPDATES: ("pos_vel_update",),
    DETECTIONS: ("coll_detect",),
    STATES: ("state_bank",),
    ARRAY: ("ram_1w1r",),
    REST: ("velocity_obstacle",),
}


@dataclass(frozen=True, eq=False)
class States(Sequence[int]):
    """The load stream of a run: computed when it is first read, as it takes the whole plan."""

    job: AvoidJob

    @cached_property
    def _words(self) -> list[int]:
        return list(_stream(self.job, avoid(self.job.problem, self.job.parameters)))

    @overload
    def __getitem__(self, index: int) -> int: ...

    @overload
    def __getitem__(self, index: slice) -> list[int]: ...

    def __getitem__(self, index: int | slice) -> int | list[int]:
        return self._words[index]

    def __len__(self) -> int:
        return len(self._words)


class RobotCircuit(CircuitStyle):
    """One robot's circuit, with the units of a style."""

    planner = "velocity_obstacle"
    laws = LAWS

    def __init__(self, style: Style) -> None:
        self.style = style.value
        self._style = style

    def circuit(self, job: AvoidJob) -> Circuit:
        """The circuit of the first robot of the workload.

        Raises:
            UnsuitedError: more units than the sequential style has.
        """
        _refuse(self._style, job)
        parameters = job.parameters
        numbers = fixed(job.problem, parameters)
        width = parameters.width
        layout = structure(self._style, job.problem.count, parameters)
        return Circuit(
            top="velocity_obstacle",
            sources=(*(HERE / f"{name}.v" for name in MODULES), SHARED / "ram_1w1r.v"),
            parameters={
                **layout,
                **_constants(numbers),
                "VELOCITIES_X": "velocities_x.hex",
                "VELOCITIES_Y": "velocities_y.hex",
                "BOUNDS": "bounds.hex",
            },
            stream=Image(2 * width + 1, States(job)),
            phases=timing.PHASES,
            kinds=KINDS,
            event_bits=2 * width,
            images={
                **{
                    f"velocities_{name}.hex": Image(
                        width, [_word(velocity[axis], width) for level in numbers.velocities for velocity in level]
                    )
                    for axis, name in enumerate("xy")
                },
                "bounds.hex": Image(2 * width, _bounds(numbers, width, 1 << layout["HALVINGS"])),
            },
            pieces=PIECES,
            notes=(
                "The stream has the states of all robots before each update, the first robot of the workload first.",
            ),
        )

    def expected(self, job: AvoidJob) -> Expected:
        """The verdict on every candidate, the velocity and the acceleration of each update."""
        _refuse(self._style, job)
        plan = avoid(job.problem, job.parameters)
        costs = timing.update_costs(self._style, job.problem.count, job.parameters)
        cycles = dict.fromkeys(timing.PHASES, 0)
        events: list[tuple[int, int, int]] = []
        for update, reported in enumerate(_decisions(job, plan)):
            begin = sum(cycles.values())
            events += _events(costs, begin, reported, job.parameters.width)
            for phase, amount in costs.phases(int(plan.checks[update, 0]), int(plan.trials[update, 0])).items():
                cycles[phase] += amount
        cycle, kind, value = zip(*events, strict=True) if events else ((), (), ())
        return Expected(Events(np.array(cycle, np.int64), np.array(kind, np.uint8), np.array(value, np.uint64)), cycles)

    def sample(self, seed: int) -> AvoidJob:
        """Random robots, options and units: see ``random_job``."""
        return random_job(self._style, seed)


def _refuse(style: Style, job: AvoidJob) -> None:
    faults = [
        Fault("circuit", 0, 0, f"avoid.{name}", f"the sequential circuit has one datapath, not {count}", "take 1")
        for name, count in (
            ("update_units", job.parameters.update_units),
            ("detect_units", job.parameters.detect_units),
        )
        if style is Style.SEQUENTIAL and count is not None and count > 1
    ]
    if faults:
        raise UnsuitedError(faults)


def _constants(numbers: Arithmetic) -> dict[str, int]:
    """The constants of the arithmetic; of those that are squares their roots, which fit 32 bits."""
    assert numbers.shifts is not None
    assert numbers.formats is not None
    shifts = {f"{name.upper()}_SHIFT": bits for name, bits in vars(numbers.shifts).items()}
    return {
        "RADIUS": math.isqrt(numbers.radius_squared),
        "RANGE": math.isqrt(numbers.range_squared or 0),
        "TOLERANCE": math.isqrt(numbers.tolerance_squared),
        "CHANGE": math.isqrt(numbers.change_squared),
        # No component of a velocity is greater than its word.
        "BRAKE": min(numbers.brake, (1 << numbers.formats.width) - 1),
        "STEP": numbers.step,
        "HALF_SQUARE": numbers.half_square,
        "INVERSE_STEP": numbers.inverse_step,
        **dict(zip(("PROPORTIONAL", "INTEGRAL", "DERIVATIVE"), numbers.gains, strict=True)),
        "SPEED": numbers.speed,
        "ACCELERATION": numbers.acceleration,
        **shifts,
    }


def _word(value: int, width: int) -> int:
    return value & ((1 << width) - 1)


def _pair(values: Sequence[int], width: int) -> int:
    """(x, y) as a word: x in the low half."""
    x, y = values
    return _word(y, width) << width | _word(x, width)


def _bounds(numbers: Arithmetic, width: int, count: int) -> list[int]:
    """The bounds between directions; beyond them one that no direction passes."""
    words = [_pair(bound, width) for bound in numbers.bounds]
    return words + [_pair((0, (1 << (width - 1)) - 1), width)] * (count - len(words))


def _stream(job: AvoidJob, plan: Avoidance) -> Iterator[int]:
    """For each update the target, marked in the last one, and then each robot's position and velocity."""
    numbers, width = fixed(job.problem, job.parameters), job.parameters.width
    target = _pair([numbers.position(each) for each in job.problem.targets[0].tolist()], width)
    for update in range(plan.updates):
        yield target | int(update == plan.updates - 1) << 2 * width
        for position, velocity in zip(plan.positions[update].tolist(), plan.velocities[update].tolist(), strict=True):
            yield _pair(position, width)
            yield _pair(velocity, width)


@dataclass(frozen=True)
class Decision:
    """The report of robot 0 on an update: its ``verdicts`` on candidates, (kind, candidate) each, and two vectors."""

    verdicts: list[tuple[int, int]]
    velocity: tuple[int, int]
    acceleration: tuple[int, int]


def _decisions(job: AvoidJob, plan: Avoidance) -> Iterator[Decision]:
    numbers = fixed(job.problem, job.parameters)
    x, y = (numbers.position(each) for each in job.problem.targets[0].tolist())
    robot = RobotState((0, 0), (x, y))
    for update in range(plan.updates):
        robot.position = _components(plan.positions[update, 0])
        robot.velocity = _components(plan.velocities[update, 0])
        candidate = int(plan.candidates[update, 0])
        verdicts = []
        tried = reference.candidates(numbers, reference.to_goal(numbers, robot))
        for _ in range(int(plan.checks[update, 0])):
            place = next(tried)
            reached = reference.change_to(numbers, robot, place) is not None
            verdicts.append((TOO_FAR if not reached else TAKEN if place == candidate else COLLIDES, place))
        velocity = reference.brake(numbers, robot.velocity)
        if candidate > BRAKE:
            change = reference.change_to(numbers, robot, candidate)
            assert change is not None
            _, velocity = reference.take(numbers, robot, change)
        acceleration, robot.error_sum, robot.last_error = reference.pid(numbers, robot, velocity)
        yield Decision(verdicts, velocity, acceleration)


def _components(values: Any) -> tuple[int, int]:
    return int(values[0]), int(values[1])


def _events(costs: timing.UpdateCosts, begin: int, decision: Decision, width: int) -> Iterator[tuple[int, int, int]]:
    """(cycle, kind, value) of an update that begins at cycle ``begin``."""
    # A verdict is reported in the last cycle of the check or of the trial, a velocity in the first and an acceleration
    # in the last cycle of PID control.
    now = begin + costs.load + costs.target_check + (costs.select_once if decision.verdicts else 0)
    for kind, candidate in decision.verdicts:
        now += costs.select_candidate + costs.check_candidate
        now += 0 if kind == TOO_FAR else costs.check_trial + costs.trial
        yield now - 1, kind, candidate
    yield now, VELOCITY, _pair(decision.velocity, width)
    yield now + costs.pid - 1, ACCELERATION, _pair(decision.acceleration, width)


CIRCUITS = tuple(RobotCircuit(style) for style in Style)
