"""The parameters of the planner, and the robots of a workload, as YAML gives them."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from codesign.ground.errors import InputError
from codesign.ground.models import RefusalError, SpecModel, TaskParameters
from codesign.ground.units import PICOSECONDS_PER_SECOND, Dimension, parse_quantity
from codesign.planners.velocity_obstacle.plan.problem import (
    FEWEST_ROBOTS,
    LARGEST_ARENA,
    MOST_ROBOTS,
    RobotsProblem,
    generate,
)

LEAST_WIDTH, MOST_WIDTH = 8, 24
MOST_DIRECTIONS, MOST_SPEEDS = 512, 64
MOST_UPDATES = 100_000


class Detection(StrEnum):
    """The rule by which two robots are on a collision course."""

    PUBLISHED = "published"
    APPROACHING = "approaching"


class Responsibility(StrEnum):
    """The share of an avoidance that one robot takes."""

    FULL = "full"
    HALF = "half"


class Detector(StrEnum):
    """The products that the collision detector forms; the answer is the same."""

    PUBLISHED = "published"
    CROSS_PRODUCT = "cross_product"


class Unit(StrEnum):
    """The number of products that a unit forms at once."""

    SERIAL = "serial"
    PARALLEL = "parallel"


_MOST_DAMPED = 0.25
"""The proportional gain with which the derivative gain may be greatest."""


class Gains(SpecModel):
    """Gains P, I and D of the PID control, in multiples of 1 / time step; (1, 0, 0) reaches the velocity in one update.

    Gains are accepted if no robot exceeds its limits, whatever it chooses. In z the velocity follows the
    choices by H = ((P + D) z - D) / (z² - (1 - P - D) z - D) where I = 0. A velocity stays within the greatest speed
    for every sequence of choices if the impulse response of H has no negative value (they sum up to 1), which is
    D ≤ √P - P. A choice is within one step's acceleration of the velocity, so a step changes it by P + 2 D of that at
    most, and with D ≤ √P - P that is no more than 1. With I > 0 the velocity overshoots every choice that is kept: the
    sum of errors returns to 0 only beyond it.
    """

    proportional: float = Field(default=1.0, description="Of the error: from 0 to 1.")
    integral: float = Field(
        default=0.0, description="Of the sum of errors: 0, as any other overshoots the greatest speed."
    )
    derivative: float = Field(default=0.0, description="Of the error's change: from 0 to √proportional - proportional.")

    @field_validator("proportional", mode="after")
    @classmethod
    def _no_more_than_wanted(cls, value: float) -> float:
        if not 0.0 <= value <= 1.0:
            raise RefusalError(
                f"a proportional gain of {value:g} commands {value:g} times the change of velocity that is wanted,"
                " which is up to all that the acceleration allows",
                "from 0 to 1",
            )
        return value

    @field_validator("integral", mode="after")
    @classmethod
    def _no_overshoot(cls, value: float) -> float:
        if value != 0.0:
            raise RefusalError(
                f"an integral gain of {value:g} drives a robot beyond its greatest speed, as the sum of errors returns"
                " to 0 only beyond the velocity that is wanted",
                "0, or leave it out: the velocity follows the acceleration without a lasting error",
            )
        return value

    @field_validator("derivative", mode="after")
    @classmethod
    def _no_negative_response(cls, value: float, info: ValidationInfo) -> float:
        proportional = info.data.get("proportional", _MOST_DAMPED)
        if value < 0.0 or not _stays_within(proportional, value):
            most = round(math.sqrt(proportional) - proportional, 4)
            if not _stays_within(proportional, most):
                most = max(0.0, round(most - 1e-4, 4))
            what = f"with a derivative gain of {value:g} a robot can exceed its greatest speed or its acceleration"
            hint = f"from 0 to {most:g} (√proportional - proportional; 0.25 at most, with a proportional gain of 0.25)"
            raise RefusalError(what, hint)
        return value


def _stays_within(proportional: float, derivative: float) -> bool:
    """True if D ≤ √P - P, but for the rounding of doubles: (0.81, 0.09) is on the bound."""
    both = proportional + derivative
    # A product becomes infinite where a power of it is an error.
    return both * both <= proportional * (1.0 + 1e-12)


UnitCount = Annotated[int, Field(ge=1, le=MOST_ROBOTS)]


class AvoidParameters(TaskParameters):
    """The choice of a robot's velocity, and the units of its circuit."""

    width: Annotated[int, Field(ge=LEAST_WIDTH, le=MOST_WIDTH)] = Field(
        default=16, description="Bits of a position, a velocity, an acceleration and a constant, sign included."
    )
    time_step: Annotated[str, Field(max_length=40)] = Field(
        default="100 ms", description="Time between two updates, such as 100 ms."
    )
    updates: Annotated[int, Field(ge=1, le=MOST_UPDATES)] = Field(
        default=1500, description="Most updates of a run; the run ends earlier once all robots stand at their targets."
    )
    directions: Annotated[int, Field(ge=16, le=MOST_DIRECTIONS, multiple_of=8)] = Field(
        default=64, description="Directions of the array of velocities."
    )
    speeds: Annotated[int, Field(ge=1, le=MOST_SPEEDS)] = Field(
        default=10, description="Speeds of each direction, evenly spaced up to the greatest."
    )
    turn: Annotated[float, Field(ge=45.0, le=180.0)] = Field(
        default=180.0,
        description="Widest angle between a velocity and the target's direction, degrees; 180 is all, as published.",
    )
    detection: Detection = Field(
        default=Detection.APPROACHING,
        description="published: equation 4 alone; approaching: and only where the robots come closer.",
    )
    responsibility: Responsibility = Field(
        default=Responsibility.HALF,
        description="full: the others are passive, as published; half: each takes half (reciprocal obstacles).",
    )
    margin: Annotated[float, Field(ge=0.0, le=LARGEST_ARENA)] = Field(
        default=1.0, description="Cells added to the combined radius."
    )
    range: Annotated[float, Field(gt=0.0, le=LARGEST_ARENA)] | None = Field(
        default=None,
        description="Robots farther away than this are not avoided yet, cells; by default all are, as published.",
    )
    tolerance: Annotated[float, Field(gt=0.0, le=LARGEST_ARENA)] = Field(
        default=3.0, description="Distance from the target at which a robot has arrived, cells."
    )
    gains: Gains = Field(default=Gains(), description="Gains of the PID control.")
    detector: Detector = Field(
        default=Detector.PUBLISHED,
        description="published: the nine products of figure 6; cross_product: six, by Lagrange's identity.",
    )
    unit: Unit = Field(default=Unit.SERIAL, description="serial: one multiplier a unit; parallel: all at once.")
    update_units: UnitCount | None = Field(
        default=None,
        description="Units that update; by default the style's. The sequential one has one datapath: 1 at most.",
    )
    detect_units: UnitCount | None = Field(default=None, description="Units that detect; as above.")

    @field_validator("time_step", mode="after")
    @classmethod
    def _is_a_time(cls, value: str) -> str:
        try:
            picoseconds = parse_quantity(value, Dimension.TIME)
        except InputError as wrong:
            raise RefusalError(wrong.what, wrong.hint) from None
        if not 10**6 <= picoseconds <= 100 * PICOSECONDS_PER_SECOND:
            raise RefusalError(f"a time step of {value}", "from 1 us to 100 s")
        return value

    @property
    def turns(self) -> int:
        """Directions that are tried at each speed: the target's, and those on both sides up to ``turn``."""
        return min(self.directions, 2 * int(self.turn * self.directions / 360.0) + 1)

    @property
    def step(self) -> float:
        """Time between two updates, s."""
        return self.step_ps / PICOSECONDS_PER_SECOND

    @property
    def step_ps(self) -> int:
        """Time between two updates, ps."""
        return int(parse_quantity(self.time_step, Dimension.TIME))


Place = tuple[Annotated[float, Field(ge=0.0, le=LARGEST_ARENA)], Annotated[float, Field(ge=0.0, le=LARGEST_ARENA)]]
Places = Annotated[tuple[Place, ...], Field(min_length=FEWEST_ROBOTS, max_length=MOST_ROBOTS)]
Size = Annotated[float, Field(gt=0.0, le=LARGEST_ARENA)]


class ArrangementName(StrEnum):
    """Generators of starts and targets."""

    CIRCLE = "circle"
    CROSSING = "crossing"
    RANDOM = "random"


class RobotsSpec(SpecModel):
    """The robots of a workload: ``count`` of them in an ``arrangement``, or ``positions`` and ``targets``."""

    count: Annotated[int, Field(ge=FEWEST_ROBOTS, le=MOST_ROBOTS)] | None = Field(
        default=None, description="Number of robots."
    )
    arrangement: ArrangementName | None = Field(
        default=None,
        description="circle: to the opposite point; crossing: two groups at right angles; random: anywhere.",
    )
    seed: Annotated[int, Field(ge=0, le=2**64 - 1)] = Field(
        default=0, description="Chooses one of the possible arrangements."
    )
    positions: Places | None = Field(default=None, description="Starts of the robots: [x, y] in cells.")
    targets: Places | None = Field(default=None, description="Targets of the robots: [x, y] in cells.")
    radius: Size = Field(default=5.0, description="Radius of a robot, cells.")
    speed: Size = Field(default=6.0, description="Greatest speed, cells/s.")
    acceleration: Size = Field(default=24.0, description="Greatest acceleration, cells/s^2.")
    arena: tuple[Size, Size] = Field(default=(300.0, 300.0), description="Width and height, cells.")

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        drawn = self.count is not None and self.arrangement is not None
        named = self.positions is not None and self.targets is not None
        some = (self.count, self.arrangement), (self.positions, self.targets)
        if drawn == named or any(value is not None for value in some[drawn]):
            what = "the robots are given neither in one form nor in the other"
            raise RefusalError(what, "give count: and arrangement:, or positions: and targets:")
        try:
            self.problem()
        except InputError as wrong:
            place = (wrong.where,) if wrong.where in type(self).model_fields else ()
            raise RefusalError(wrong.what, wrong.hint, place) from None
        return self

    def problem(self) -> RobotsProblem:
        """The planning problem.

        Raises:
            InputError: robots that start in collision, outside, or find no place.
        """
        if self.positions is not None and self.targets is not None:
            places = np.array(self.positions), np.array(self.targets)
            return RobotsProblem(*places, self.radius, self.speed, self.acceleration, self.arena)
        assert self.count is not None
        assert self.arrangement is not None
        return generate(
            self.arrangement.value,
            self.count,
            radius=self.radius,
            speed=self.speed,
            acceleration=self.acceleration,
            arena=self.arena,
            seed=self.seed,
        )


class RobotsWorkload(SpecModel):
    """The problem of a workload: robots that share an arena without obstacles."""

    robots: RobotsSpec = Field(description="The robots: their number, places and limits.")

    def problem(self) -> RobotsProblem:
        """The planning problem."""
        return self.robots.problem()
