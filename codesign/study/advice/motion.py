"""From a speed to a rate, and back: the time that a plan may take where the robot has to stop for what it sees.

The law is ``Stopping``, and the worst reaction of the robot is the one of its ``Loop``. A speed that is asked for gives
the longest plan. The time of a plan on a board gives the speed that the robot may drive with it.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from codesign.ground.errors import InputError
from codesign.ground.units import PICOSECONDS_PER_SECOND, Dimension, format_quantity, parse_quantity
from codesign.laws.stopping import Loop, Stopping, braking
from codesign.system.results.model import ResultModel

SHARE = 0.9
"""Assumed: where the body allows less than a tenth more, nothing but the body binds. That share of the speed that
sensor and body allow is asked for where no speed is."""

LEAST = 1e-6
"""In SI units: a smaller speed, range, deceleration or rate of a sensor is refused."""


class Driven(ResultModel):
    """The speed that a robot may drive with a design."""

    speed_mps: float = Field(description="the greatest speed with which it stops in time, m/s")
    speed_low_mps: float | None = Field(description="the same with the longest plan inside all intervals, m/s")
    speed_high_mps: float | None = Field(description="the same with the shortest plan, m/s")
    reaction_s: float = Field(description="worst time from the appearance of an obstacle to the brakes, s")
    binds: Literal["body", "compute", "sensor", "delay"] = Field(
        description="what limits the speed: its range and brakes; or else the longest part of the reaction"
    )


class Motion(ResultModel):
    """The body and the sensor that the robot stops with, and the speed that is asked for."""

    speed_mps: float | None = Field(description="speed that is asked for, m/s")
    sight_m: float = Field(description="distance that the sensor sees, m")
    brake_mps2: float = Field(description="deceleration of the brakes, m/s²")
    sensor_hz: float | None = Field(description="scans a second; None where not asked: it counts as always seeing")
    delay_s: float | None = Field(
        description="latency of the sensor, the messages and the actuators together, s; None where not asked: 0"
    )

    @property
    def body(self) -> Stopping:
        """The law of its body."""
        return Stopping(self.sight_m, self.brake_mps2)

    @property
    def loop(self) -> Loop:
        """The loop around its planner."""
        return Loop(1 / self.sensor_hz if self.sensor_hz else 0.0, self.delay_s or 0.0)

    @property
    def most_mps(self) -> float:
        """The speed with a plan that takes no time, m/s."""
        return float(self.body.speed(self.loop.reaction(0.0)))

    @property
    def wanted_mps(self) -> float:
        """The speed that is asked for; without one, a share of the most that sensor and body allow."""
        return SHARE * self.most_mps if self.speed_mps is None else self.speed_mps

    @property
    def reaction_s(self) -> float:
        """The reaction time that the speed leaves, s."""
        return float(self.body.reaction(self.wanted_mps))

    @property
    def plan_s(self) -> float:
        """The longest plan at that speed, s."""
        return float(self.loop.plan(self.reaction_s))

    def driven(self, time_s: float, low_s: float | None, high_s: float | None) -> Driven:
        """The speed with plans of ``time_s``, from ``low_s`` to ``high_s``."""

        def speed(time: float | None) -> float | None:
            return None if time is None else float(self.body.speed(self.loop.reaction(time)))

        reaction = self.loop.reaction(time_s)
        parts: dict[Any, float] = {"sensor": self.loop.period, "delay": self.loop.delay}
        parts["compute"] = reaction - sum(parts.values())
        fast = self.body.speed(reaction)
        body_binds = fast >= SHARE * self.body.speed(0.0)
        return Driven(
            speed_mps=fast,
            speed_low_mps=speed(high_s),
            speed_high_mps=speed(low_s),
            reaction_s=reaction,
            binds="body" if body_binds else max(parts, key=parts.__getitem__),
        )


# The question as a user writes it.


def parse_motion(
    speed: str | None, sight: str | None, brake: str | None, sensor: str | None, delay: str | None
) -> Motion | None:
    """The motion that options ask for: ``1.5 m/s``, ``4 m``, ``2 m/s^2``, ``10 Hz`` and ``50 ms``; None without any.

    Raises:
        InputError: a quantity that is none; range or brakes are missing; a speed from which nothing stops in time.
    """
    given = {"--speed": speed, "--sensor": sensor, "--delay": delay, "--range": sight, "--brake": brake}
    asked = next((option for option, text in given.items() if text is not None), None)
    if asked is None:
        return None
    for option, what, example in _BODY:
        if given[option] is None:
            hint = f"add {option}, such as {option} {example}"
            raise InputError(f"the speed of a robot follows from {what} too, which {option} gives", asked, hint)
    motion = Motion(
        speed_mps=_above_zero(speed, Dimension.SPEED, "--speed"),
        sight_m=_above_zero(sight, Dimension.LENGTH, "--range"),
        brake_mps2=_above_zero(brake, Dimension.ACCELERATION, "--brake"),
        sensor_hz=_above_zero(sensor, Dimension.RATE, "--sensor"),
        delay_s=None if delay is None else option_quantity(delay, Dimension.TIME, "--delay") / PICOSECONDS_PER_SECOND,
    )
    _check_stops(motion)
    return motion


_BODY = (
    ("--range", "the distance that its sensor sees", "4m"),
    ("--brake", "the deceleration of its brakes", "2m/s^2"),
)


def option_quantity(text: str, dimension: Dimension, option: str) -> float:
    """A quantity of an option, in the base unit of its dimension.

    Raises:
        InputError: it is none; ``where`` is the option.
    """
    try:
        return float(parse_quantity(text, dimension))
    except InputError as wrong:
        raise InputError(wrong.what, option, wrong.hint) from None


def _above_zero(text: str | None, dimension: Dimension, option: str) -> Any:
    value = None if text is None else option_quantity(text, dimension, option)
    if value is not None and value < LEAST:
        what = "is zero" if value == 0 else "is too small"
        raise InputError(f"{text!r} {what}", option, f"the least {dimension} is {LEAST:g} in the SI unit")
    return value


def _check_stops(motion: Motion) -> None:
    """Refuse a speed from which no plan, however quick, stops the robot in time."""
    speed, body, loop = motion.speed_mps, motion.body, motion.loop
    if speed is None or motion.plan_s > 0:
        return
    fixed, rest = loop.reaction(0.0), motion.reaction_s
    option, part = ("--sensor", "sensor") if loop.period >= loop.delay else ("--delay", "delay")
    what = (
        f"the {part} binds, no board helps: at {_mps(speed)} the robot has {_seconds(rest)} to react, and the period of"
        f" the sensor and the delay take {_seconds(fixed)}"
    )
    if rest <= 0:
        way = _metres(braking(speed, body.brake))
        option = "--speed"
        what = (
            f"no reaction is quick enough: from {_mps(speed)} the robot brakes over {way}, and its sensor sees"
            f" {_metres(body.sight)}"
        )
    remedies = [f"a speed below {_mps(motion.most_mps)}", f"a range above {_metres(body.distance(speed, fixed))}"]
    if speed * fixed < body.sight:
        remedies.append(f"brakes above {body.needed_brake(speed, fixed):.3g} m/s^2")
    if rest > loop.delay and loop.period:
        remedies.append(f"a sensor above {format_quantity(1 / (rest - loop.delay), Dimension.RATE, 3)}")
    raise InputError(what, option, f"ask for {', or '.join(remedies)}")


# The same in words.


def _mps(speed: float) -> str:
    return f"{speed:.3g} m/s"


def _metres(length: float) -> str:
    return f"{length:.3g} m"


def _seconds(time: float) -> str:
    return format_quantity(round(float(f"{time:.3g}") * PICOSECONDS_PER_SECOND), Dimension.TIME)


def motion_text(motion: Motion, *, judged_by_rate: bool) -> str:
    """The reaction that is asked of the robot, and what was not asked. ``judged_by_rate``: the rate was asked for."""
    body, loop = motion.body, motion.loop
    seen = f"with {_metres(body.sight)} of sight and brakes of {body.brake:.3g} m/s²"
    if not judged_by_rate:
        share = (
            f", {100 * SHARE:g} % of the {_mps(motion.most_mps)} that sensor and body allow"
            if not motion.speed_mps
            else ""
        )
        wait = f"; a plan that was begun before has to end first, so a plan may take {_seconds(motion.plan_s)}"
        if motion.plan_s <= loop.period:
            wait = f", of which a plan may take {_seconds(motion.plan_s)}"
        seen = f"to drive {_mps(motion.wanted_mps)}{share}, {seen}: {_seconds(motion.reaction_s)} to react{wait}"
    missing = {"the period of the sensor (--sensor)": motion.sensor_hz, "other delays (--delay)": motion.delay_s}
    absent = " and ".join(name for name, value in missing.items() if value is None)
    given = [f"the sensor scans at {format_quantity(motion.sensor_hz, Dimension.RATE)}"] if motion.sensor_hz else []
    given += [f"other delays take {_seconds(motion.delay_s)}"] if motion.delay_s is not None else []
    return "; ".join([seen, *given, *([f"not asked, so counted as 0: {absent}"] if absent else [])])


_BINDS = {
    "body": "its range and brakes bind, not the board",
    "compute": "the board binds: its plans are the longest part of the reaction",
    "sensor": "the sensor binds: its period is the longest part of the reaction",
    "delay": "the delay binds: it is the longest part of the reaction",
}


def driven_text(motion: Motion, board: str, driven: Driven) -> str:
    """The speed with a board, in a sentence."""
    low, high = driven.speed_low_mps, driven.speed_high_mps
    both = [] if low is None or high is None else [f"{low:.3g}", f"{high:.3g}"]
    ends = f" ({' to '.join(both)})" if len(set(both)) > 1 else ""
    return (
        f"With {board} the robot may drive {_mps(driven.speed_mps)}{ends}, and {_mps(motion.most_mps)} if plans took no"
        f" time: {_BINDS[driven.binds]}"
    )
