"""The numbers that the planner computes with: fixed point of a given width, or doubles.

Both have the same constants under the same names. They differ only in the rounding of a product to the format of
its result. So one text of the algorithm (``reference``) serves both.

Fixed point: two's complement of ``width`` bits. Each kind of quantity has the most fractional bits with which
its greatest value still fits; a product is rounded to nearest, halves up, once. Sums of products that are only
compared (the squares of equation 4) keep all their bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

from codesign.ground.errors import InputError
from codesign.planners.velocity_obstacle.plan.parameters import LEAST_WIDTH, MOST_WIDTH, AvoidParameters
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem

Number: TypeAlias = Any
"""An int in fixed point, a float in doubles: the algorithm is written for both."""

MOST_SHIFT = 60
HEADROOM = 1.0 + 2.0**-5
"""Speeds and accelerations pass their limits by rounding only; their formats leave this room."""


def fraction_bits(greatest: float, width: int) -> int:
    """The most fractional bits with which every |value| ≤ ``greatest`` fits ``width`` bits, sign included.

    >>> fraction_bits(300.0, 16), fraction_bits(6.0, 16), fraction_bits(0.1, 16)
    (6, 12, 18)
    """
    # sign   whole bits                        fractional bits
    # +---+--------------------------------+ . +---------------+
    # | s | floor(log2(greatest)) + 1 bits |   |     rest      |     ``width`` bits in all
    # +---+--------------------------------+ . +---------------+
    #
    # Where rounding lifts the greatest value to 2^(width - 1), one bit less is kept.
    bits = width - 1 - (math.floor(math.log2(greatest)) + 1)
    return bits - 1 if round(math.ldexp(greatest, bits)) >= 2 ** (width - 1) else bits


@dataclass(frozen=True)
class Formats:
    """Fractional bits of each kind of quantity; a negative number means units larger than 1."""

    width: int
    position: int
    velocity: int
    acceleration: int
    step: int
    half_square: int
    inverse_step: int
    gain: int
    direction: int


def formats_of(problem: RobotsProblem, parameters: AvoidParameters, width: int) -> Formats:
    """The formats at ``width`` bits. Positions may leave the arena to the next power of two."""
    step = parameters.step
    gains = parameters.gains
    greatest_gain = max(gains.proportional, gains.integral, gains.derivative, 0.5) / step
    return Formats(
        width=width,
        position=fraction_bits(max(problem.arena), width),
        velocity=fraction_bits(problem.speed * HEADROOM, width),
        acceleration=fraction_bits(problem.acceleration * HEADROOM, width),
        step=fraction_bits(step, width),
        half_square=fraction_bits(step * step / 2.0, width),
        inverse_step=fraction_bits(1.0 / step, width),
        gain=fraction_bits(greatest_gain, width),
        direction=fraction_bits(1.0, width),
    )


@dataclass(frozen=True)
class Shifts:
    """The shift of each product, to the right, to the format of its result; in the order of the kernel's array."""

    velocity_step: int
    acceleration_step: int
    acceleration_half_square: int
    change_inverse_step: int
    gain: int


def shifts_of(formats: Formats) -> Shifts:
    """Fractional bits of each product less the fractional bits of its result."""
    return Shifts(
        # A product has the fractional bits of both factors: v t → r, a t → v, a t²/2 → r (equations 2a, 2b), the
        # acceleration (v_c - v) / t → a, and a gain of the PID times an error, K e → a.
        velocity_step=formats.velocity + formats.step - formats.position,
        acceleration_step=formats.acceleration + formats.step - formats.velocity,
        acceleration_half_square=formats.acceleration + formats.half_square - formats.position,
        change_inverse_step=formats.velocity + formats.inverse_step - formats.acceleration,
        gain=formats.velocity + formats.gain - formats.acceleration,
    )


@dataclass(frozen=True)
class Arithmetic:
    """The constants of the algorithm in one kind of number.

    ``formats`` and ``shifts``: of fixed point; None for doubles. Constants: ``step`` t; ``half_square`` t²/2;
    ``inverse_step`` 1/t; ``change_squared`` (a_max t)², the square of the greatest change of velocity; ``brake``, the
    change of one component while braking; ``acceleration`` and ``speed``, the most of one component; ``radius_squared``
    of both robots with the margin; ``range_squared``, None without; ``tolerance_squared``; ``gains`` of the PID, 1/s;
    ``velocities[speed][direction]`` = (vx, vy), fastest first; ``turns``, the directions that are tried at each speed;
    ``bounds[k]`` = (cos, sin) between direction k and k + 1 of the first octant.
    """

    formats: Formats | None
    shifts: Shifts | None
    step: Number
    half_square: Number
    inverse_step: Number
    change_squared: Number
    brake: Number
    acceleration: Number
    speed: Number
    radius_squared: Number
    range_squared: Number | None
    tolerance_squared: Number
    gains: tuple[Number, Number, Number]
    velocities: tuple[tuple[tuple[Number, Number], ...], ...]
    turns: int
    bounds: tuple[tuple[Number, Number], ...]

    @property
    def directions(self) -> int:
        """Directions of the array of velocities."""
        return len(self.velocities[0])

    @property
    def speeds(self) -> int:
        """Speeds of the array of velocities."""
        return len(self.velocities)

    def rescale(self, product: Number, shift: str) -> Number:
        """A product in the format of its result: rounded to nearest in fixed point, as it is in doubles."""
        if self.shifts is None:
            return product
        bits = getattr(self.shifts, shift)
        return (product + (1 << bits >> 1)) >> bits

    def position(self, value: float) -> Number:
        """A coordinate, cells."""
        return value if self.formats is None else quantise(value, self.formats.position)

    def to_cells(self, value: Number) -> float:
        """A coordinate as cells."""
        return float(value) if self.formats is None else math.ldexp(value, -self.formats.position)

    def to_speed(self, value: Number) -> float:
        """A component of a velocity as cells/s."""
        return float(value) if self.formats is None else math.ldexp(value, -self.formats.velocity)


def quantise(value: float, bits: int) -> int:
    """The integer nearest to value · 2^bits, halves up."""
    return math.floor(math.ldexp(value, bits) + 0.5)


def double(problem: RobotsProblem, parameters: AvoidParameters) -> Arithmetic:
    """The constants in doubles."""
    step = parameters.step
    change = problem.acceleration * step
    gains = parameters.gains
    return Arithmetic(
        formats=None,
        shifts=None,
        step=step,
        half_square=step * step / 2.0,
        inverse_step=1.0 / step,
        change_squared=change**2,
        # Each axis brakes by itself, so that |(b, b)| = a_max t at most.
        brake=change / math.sqrt(2.0),
        acceleration=problem.acceleration,
        speed=problem.speed,
        # R = R1 + R2 of equation 4, with the margin.
        radius_squared=(2.0 * problem.radius + parameters.margin) ** 2,
        range_squared=None if parameters.range is None else parameters.range**2,
        tolerance_squared=parameters.tolerance**2,
        gains=(gains.proportional / step, gains.integral / step, gains.derivative / step),
        velocities=tuple(
            _ring(problem.speed * level / parameters.speeds, parameters.directions)
            for level in range(parameters.speeds, 0, -1)
        ),
        turns=parameters.turns,
        bounds=_bounds(parameters.directions),
    )


def fixed(problem: RobotsProblem, parameters: AvoidParameters, width: int | None = None) -> Arithmetic:
    """The constants in fixed point of ``width`` bits (by default the parameters' width).

    Limits are rounded to the safe side: the radius and the range up, changes of velocity down.

    Raises:
        InputError: the words are too narrow, or scales so far apart that a product would not fit 64 bits.
    """
    width = parameters.width if width is None else width
    fault = width_fault(problem, parameters, width)
    if fault is not None:
        raise InputError(fault, "width", _width_hint(problem, parameters))
    formats = formats_of(problem, parameters, width)
    exact = double(problem, parameters)
    # No two velocities are farther apart than two words: a greater change allows no more.
    change = min(math.floor(math.ldexp(problem.acceleration * parameters.step, formats.velocity)), 2 << width)
    radius = math.ceil(math.ldexp(2.0 * problem.radius + parameters.margin, formats.position))
    return Arithmetic(
        formats=formats,
        shifts=shifts_of(formats),
        step=quantise(exact.step, formats.step),
        half_square=quantise(exact.half_square, formats.half_square),
        inverse_step=quantise(exact.inverse_step, formats.inverse_step),
        change_squared=change**2,
        brake=math.floor(change / math.sqrt(2.0)),
        acceleration=math.floor(math.ldexp(problem.acceleration, formats.acceleration)),
        speed=math.floor(math.ldexp(problem.speed, formats.velocity)),
        radius_squared=radius**2,
        range_squared=None
        if parameters.range is None
        else math.ceil(math.ldexp(parameters.range, formats.position)) ** 2,
        tolerance_squared=quantise(parameters.tolerance, formats.position) ** 2,
        gains=tuple(quantise(gain, formats.gain) for gain in exact.gains),  # type: ignore[arg-type]
        velocities=tuple(
            tuple((quantise(x, formats.velocity), quantise(y, formats.velocity)) for x, y in level)
            for level in exact.velocities
        ),
        turns=parameters.turns,
        bounds=tuple((quantise(x, formats.direction), quantise(y, formats.direction)) for x, y in exact.bounds),
    )


def width_fault(problem: RobotsProblem, parameters: AvoidParameters, width: int) -> str | None:
    """The reason why words of ``width`` bits do not suit this problem, or None.

    The slowest velocity of the array must move a robot by a unit of position in one step, and the radius and the
    greatest change of velocity must be some units. With fewer units rounding would decide.
    """
    formats = formats_of(problem, parameters, width)
    shifts = shifts_of(formats)
    worst = [value for value in vars(shifts).values() if not 0 <= value <= MOST_SHIFT]
    if worst:
        return f"arena, speed, acceleration and time step are too far apart in scale: a shift by {worst[0]} bits"
    slowest = problem.speed / parameters.speeds
    # v t in units of a position: below 1 the slowest velocity may round to no motion at all.
    travel = math.ldexp(slowest * parameters.step, formats.position)
    if travel < 1.0:
        return (
            f"at {width} bits a position has steps of {math.ldexp(1.0, -formats.position):g} cells: the slowest"
            f" velocity, {slowest:g} cells/s, moves a robot by {travel:.2g} of one in {parameters.time_step}"
        )
    if math.ldexp(problem.acceleration * parameters.step, formats.velocity) < 4.0:
        return f"at {width} bits the greatest change of velocity in one step is less than 4 steps of a velocity"
    return None


def least_width(problem: RobotsProblem, parameters: AvoidParameters) -> int | None:
    """The narrowest words that suit this problem, or None if no words of up to 24 bits do."""
    widths = range(LEAST_WIDTH, MOST_WIDTH + 1)
    return next((width for width in widths if width_fault(problem, parameters, width) is None), None)


def _width_hint(problem: RobotsProblem, parameters: AvoidParameters) -> str:
    least = least_width(problem, parameters)
    if least is None:
        return "another time step, fewer speeds, or another scale of the arena"
    return f"{least} bits or more, fewer speeds, or a longer time step"


def _ring(speed: float, directions: int) -> tuple[tuple[float, float], ...]:
    angles = [2.0 * math.pi * k / directions for k in range(directions)]
    # Direction k at the angle 2πk / directions, counted from the x axis.
    return tuple((speed * math.cos(angle), speed * math.sin(angle)) for angle in angles)


def _bounds(directions: int) -> tuple[tuple[float, float], ...]:
    # Halfway between two directions, up to 45°: the other octants are mirrored (``kernels._to_goal``).
    angles = [(k + 0.5) * 2.0 * math.pi / directions for k in range(directions // 8)]
    return tuple((math.cos(angle), math.sin(angle)) for angle in angles)
