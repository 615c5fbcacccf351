"""Motion along a path in closed form: the position of a robot at any time, without events.

A motion has a path, an initial speed, and an authority (the arc length at which to stop). It is time-optimal under the
limits of the robot's kinematics. A forward and a backward pass over the corners give the greatest speed at each of
them. Each segment between is driven in at most three phases of constant acceleration.

All lengths are in one unit (cells, where a ``MobileRobot`` uses it). Times are seconds inside, and whole picoseconds
from the begin of the motion outside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codesign.components import kernels
from codesign.components.path import NEAR, Point, Polyline
from codesign.ground.errors import InputError
from codesign.laws.stopping import braking

SECOND = 10**12
"""Picoseconds."""

SMOOTH = math.radians(10.0)
"""Assumed: a differential drive follows a bend of up to 10° while driving. At a sharper one it stops and turns."""

_AIMED = 1e-9
"""Radians: the rounding error of a heading."""

_SLACK = 1e-5
"""Cells a second: a speed may exceed the limit of a new path by the rounding error of a braking distance."""


def _positive(value: float, name: str) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(f"a {name.replace('_', ' ')} of {value}", name, "give a finite number above 0")


@dataclass(frozen=True)
class PointDrive:
    """A point robot. It drives at ``speed`` (a second), starts and stops at once, and takes any corner.

    Raises:
        InputError: a speed that is not above 0.
    """

    speed: float

    def __post_init__(self) -> None:
        _positive(self.speed, "speed")

    def scaled(self, factor: float) -> PointDrive:
        """The same in another unit of length."""
        return replace(self, speed=self.speed * factor)

    @property
    def braking(self) -> float:
        """The braking distance from ``speed``: 0."""
        return 0.0


@dataclass(frozen=True)
class OmnidirectionalDrive:
    """It drives in any direction, at most ``speed`` (a second), with at most ``acceleration`` (a second²).

    At a corner of angle θ its velocity v changes by 2·v·sin(θ/2) at once. The sum of all such changes within one
    control period T, as in a bend of many small corners, is at most ``acceleration``·T.

    Raises:
        InputError: a limit that is not above 0.
    """

    speed: float
    acceleration: float

    def __post_init__(self) -> None:
        _positive(self.speed, "speed")
        _positive(self.acceleration, "acceleration")

    def scaled(self, factor: float) -> OmnidirectionalDrive:
        """The same in another unit of length."""
        return replace(self, speed=self.speed * factor, acceleration=self.acceleration * factor)

    @property
    def braking(self) -> float:
        """The braking distance v² / 2a from ``speed``."""
        return float(braking(self.speed, self.acceleration))


@dataclass(frozen=True)
class DifferentialDrive:
    """It drives in the direction of its heading, and turns by at most ``turn_rate``, rad/s.

    It takes a bend of up to ``smooth`` (radians) while driving, at most at the speed at which ``turn_rate`` completes
    the bend over the next segment. At a sharper bend, and before it starts, it stops and turns.

    Raises:
        InputError: a limit that is not above 0.
    """

    speed: float
    acceleration: float
    turn_rate: float
    smooth: float = SMOOTH

    def __post_init__(self) -> None:
        for name in ("speed", "acceleration", "turn_rate"):
            _positive(getattr(self, name), name)

    def scaled(self, factor: float) -> DifferentialDrive:
        """The same in another unit of length."""
        return replace(self, speed=self.speed * factor, acceleration=self.acceleration * factor)

    @property
    def braking(self) -> float:
        """The braking distance v² / 2a from ``speed``."""
        return float(braking(self.speed, self.acceleration))


Kinematics = PointDrive | OmnidirectionalDrive | DifferentialDrive


def angle_between(before: float, after: float) -> float:
    """The turn from heading ``before`` to ``after``, radians, in -π..π.

    >>> round(angle_between(3.0, -3.0), 6)
    0.283185
    """
    return math.remainder(after - before, 2.0 * math.pi)


class Motion:
    """A drive along a path, determined for all time by its initial state.

    Made by ``drive``, ``brake`` or ``stand``.

    Attributes:
        path: the polyline.
        end: arc length at which it stops.
        duration: picoseconds from its begin until it stops.
    """

    def __init__(
        self, path: Polyline, phases: NDArray[np.float64], headings: NDArray[np.float64] | None, heading: float
    ) -> None:
        self.path = path
        self._begins = phases[:, 0].copy()
        self._arcs = phases[:, 1].copy()
        self._phases = phases
        self._turned = headings  # heading before each turn on the spot, by phase; NaN where a phase is none
        self._heading = heading
        self._asked: tuple[int, tuple[float, float]] = -1, (0.0, 0.0)
        self._faced: tuple[int, float] = -1, 0.0
        self.end = float(phases[-1, 1])
        self.duration = math.ceil(float(phases[-1, 0]) * SECOND)

    @classmethod
    def stand(cls, position: Point, heading: float = 0.0) -> Motion:
        """Standing at ``position``."""
        return cls(Polyline([position]), np.zeros((1, 4)), None, heading)

    @classmethod
    def halted(cls, path: Polyline, arc: float, heading: float) -> Motion:
        """Standing on ``path`` at ``arc``."""
        return cls(path, np.array([[0.0, arc, 0.0, 0.0]]), None, heading)

    @classmethod
    def brake(cls, path: Polyline, arc: float, speed: float, kinematics: Kinematics, heading: float) -> Motion:
        """Brake along ``path`` from ``arc`` at ``speed``, as hard as the kinematics allow."""
        if isinstance(kinematics, PointDrive) or speed <= 0.0:
            return cls.halted(path, arc, heading)
        slowing = kinematics.acceleration
        end = min(arc + speed * speed / (2.0 * slowing), path.length)
        phases = np.array([[0.0, arc, speed, -slowing], [speed / slowing, end, 0.0, 0.0]])
        return cls(path, phases, None, heading)

    @classmethod
    def drive(
        cls,
        path: Polyline,
        kinematics: Kinematics,
        authority: float,
        *,
        speed: float = 0.0,
        heading: float = 0.0,
        control_period: int = SECOND // 10,
    ) -> Motion | None:
        """Drive ``path`` from its begin and stop at ``authority``, in the least time that the kinematics allow.

        Args:
            path: the path to drive; its first point is the position of the robot.
            kinematics: the limits, in the unit of the path.
            authority: arc length at which to stop, clipped to the path.
            speed: initial speed, a second.
            heading: initial heading, radians.
            control_period: ps.

        Returns:
            The motion, or None where ``speed`` is too fast for a corner, or for the authority.
        """
        end = min(max(authority, 0.0), path.length)
        driven = _until(path, end)
        if driven is None:
            halts_at_once = speed <= _SLACK or isinstance(kinematics, PointDrive)
            return cls.halted(path, 0.0, heading) if halts_at_once else None
        arcs, headings = driven
        if isinstance(kinematics, PointDrive):
            phases = np.array([[0.0, 0.0, kinematics.speed, 0.0], [end / kinematics.speed, end, 0.0, 0.0]])
            return cls(path, phases, None, heading)
        return _profile(cls, path, arcs, headings, kinematics, speed, heading, control_period)

    def at(self, time: int) -> tuple[float, float]:
        """Arc length and speed (a second) ``time`` picoseconds after the begin."""
        # A time is often asked for again: where the robot is now.
        if time != self._asked[0]:
            self._asked = time, self._at(time)
        return self._asked[1]

    def _at(self, time: int) -> tuple[float, float]:
        if time >= self.duration:
            return self.end, 0.0
        seconds = time / SECOND
        index = max(int(self._begins.searchsorted(seconds, side="right")) - 1, 0)
        begin, arc, speed, acceleration = self._phases[index].tolist()
        past = seconds - begin
        latest = float(self._arcs[index + 1]) if index + 1 < self._arcs.size else self.end
        reached = arc + past * (speed + 0.5 * acceleration * past)
        return min(max(reached, arc), latest), max(speed + acceleration * past, 0.0)

    def time_at(self, arc: float, *, leaving: bool = False) -> int:
        """The first whole picosecond at which the robot is at ``arc``, which must not lie beyond the end.

        Where it stops there to turn, ``leaving`` selects the time at which it drives on.
        """
        index = int(self._arcs.searchsorted(arc, side="right" if leaving else "left")) - 1
        if index < 0:
            return 0
        begin, at, speed, acceleration = self._phases[min(index, len(self._phases) - 1)].tolist()
        distance = arc - at
        root = math.sqrt(max(speed * speed + 2.0 * acceleration * distance, 0.0))
        # From distance = v t + a t² / 2: t = 2 distance / (v + root), root² = v² + 2 a distance. No term cancels.
        past = 2.0 * distance / (speed + root) if speed + root > 0.0 else 0.0
        time: int = math.ceil((begin + past) * SECOND)
        return min(time, self.duration)

    def heading_at(self, time: int) -> float:
        """Heading, radians: the direction of the current segment; during a turn on the spot, between two of them."""
        if time != self._faced[0]:
            self._faced = time, self._heading_at(time)
        return self._faced[1]

    def _heading_at(self, time: int) -> float:
        if self.path.arcs.size == 1 or (len(self._phases) == 1):
            return self._heading
        index = max(int(self._begins.searchsorted(time / SECOND, side="right")) - 1, 0)
        if index == len(self._phases) - 1:
            # It stopped, and keeps the heading of its last segment.
            return float(self.path.headings[self.path.segment_at(max(self.end - NEAR, 0.0))])
        after = float(self.path.headings[self.path.segment_at(self.at(time)[0])])
        if self._turned is not None and not math.isnan(self._turned[index]):
            before, begin = float(self._turned[index]), float(self._begins[index])
            share = (time / SECOND - begin) / (float(self._begins[index + 1]) - begin)
            return before + angle_between(before, after) * share
        return after


def _until(path: Polyline, end: float) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Arc lengths of the vertices up to ``end``, and headings of the segments; None for a path without length."""
    if path.arcs.size == 1 or end <= NEAR:
        return None
    count = int(path.arcs.searchsorted(end - 1e-12, side="left"))
    arcs = np.concatenate((path.arcs[:count], np.array([end])))
    return arcs, path.headings[:count]


def _profile(
    cls: type[Motion],
    path: Polyline,
    arcs: NDArray[np.float64],
    headings: NDArray[np.float64],
    kinematics: OmnidirectionalDrive | DifferentialDrive,
    speed: float,
    heading: float,
    control_period: int,
) -> Motion | None:
    lengths = np.diff(arcs)
    before = np.concatenate((np.array([heading]), headings))[:-1]
    angles = np.abs(np.remainder(headings - before + math.pi, 2.0 * math.pi) - math.pi)
    turns = np.zeros(arcs.size)
    if isinstance(kinematics, DifferentialDrive):
        with np.errstate(divide="ignore"):
            bends = kinematics.turn_rate * lengths / angles
        sharp = angles > kinematics.smooth
        # A standing robot completes its turn before it drives. Otherwise a repeated command would end the turn early.
        sharp[0] = sharp[0] or (speed <= 0.0 and angles[0] > _AIMED)
        limits = np.where(sharp, 0.0, bends)
        turns[:-1] = np.where(sharp, angles / kinematics.turn_rate, 0.0)
    else:
        if speed <= 0.0:
            angles[0] = 0.0  # from standing it starts in any direction
        limits = kernels.bend_limits(
            arcs[:-1], 2.0 * np.sin(angles / 2.0), kinematics.acceleration, control_period / SECOND, kinematics.speed
        )
    limits = np.concatenate((np.minimum(limits, kinematics.speed), np.zeros(1)))
    speeds, most = kernels.speeds_at(lengths, limits, kinematics.acceleration, speed)
    if speed > most + _SLACK:
        return None
    phases = kernels.phases_of(lengths, arcs, speeds, turns, kinematics.speed, kinematics.acceleration)
    turned = None
    if turns.any():
        # A phase without speed and acceleration, except the last, is a turn. Turns are in the order of the vertices.
        turning = (phases[:-1, 2] == 0.0) & (phases[:-1, 3] == 0.0)
        turned = np.full(len(phases), np.nan)
        turned[:-1][turning] = before[turns[:-1] > 0.0]
    return cls(path, phases, turned, heading)
