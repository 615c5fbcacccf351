"""A mobile robot drives along a path and never enters a blocked cell.

It makes no events. Its state is a closed-form function of the time since the last command, and is advanced on demand:
at every control turn, and before every change of the world. Many small advances and one large give the same state.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import simpy
from numpy.typing import NDArray

from codesign.components import kernels
from codesign.components.component import Component
from codesign.components.path import NEAR, Cell, Point, Polyline, cell_of
from codesign.ground.errors import InputError, RunError
from codesign.ground.records import Listener
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
class _Accelerated:
    speed: float
    acceleration: float

    def scaled(self, factor: float) -> Self:
        """The same in another unit of length."""
        return replace(self, speed=self.speed * factor, acceleration=self.acceleration * factor)

    @property
    def braking(self) -> float:
        """The braking distance v² / 2a from ``speed``."""
        return float(braking(self.speed, self.acceleration))


@dataclass(frozen=True)
class OmnidirectionalDrive(_Accelerated):
    """It drives in any direction, at most ``speed`` (a second), with at most ``acceleration`` (a second²).

    At a corner of angle θ its velocity v changes by 2·v·sin(θ/2) at once. The sum of all such changes within one
    control period T, as in a bend of many small corners, is at most ``acceleration``·T.

    Raises:
        InputError: a limit that is not above 0.
    """

    def __post_init__(self) -> None:
        _positive(self.speed, "speed")
        _positive(self.acceleration, "acceleration")


@dataclass(frozen=True)
class DifferentialDrive(_Accelerated):
    """It drives in the direction of its heading, and turns by at most ``turn_rate``, rad/s.

    It takes a bend of up to ``smooth`` (radians) while driving, at most at the speed at which ``turn_rate`` completes
    the bend over the next segment. At a sharper bend, and before it starts, it stops and turns.

    Raises:
        InputError: a limit that is not above 0.
    """

    turn_rate: float
    smooth: float = SMOOTH

    def __post_init__(self) -> None:
        for name in ("speed", "acceleration", "turn_rate"):
            _positive(getattr(self, name), name)


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
        if isinstance(kinematics, PointDrive):
            if driven is None:
                return cls.halted(path, 0.0, heading)
            phases = np.array([[0.0, 0.0, kinematics.speed, 0.0], [end / kinematics.speed, end, 0.0, 0.0]])
            return cls(path, phases, None, heading)
        if driven is None:
            return cls.halted(path, 0.0, heading) if speed <= _SLACK else None
        arcs, headings = driven
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


PRESSING = 1e-3
"""Cells: a robot that moved less than this since a contact is still at the same cell."""


@dataclass(frozen=True)
class Contact:
    """A contact with an obstacle: ``time`` (ps), ``position`` (row, column), the ``cell`` that the robot did not enter,
    and the ``speed`` (cells/s) that it lost at once."""

    time: int
    position: Point
    cell: Cell
    speed: float


class MobileRobot(Component):
    """A robot on a map of cells.

    Args:
        environment, name, listeners: as for every component.
        kinematics: limits in metres and seconds.
        resolution: metres a cell.
        position: (row, column) in cells at time 0.
        radius: metres, of its body. Not used here: ``advance`` gets the cells that the robot's middle may not enter.
        heading: radians, from the direction of growing columns towards growing rows.
        control_period: ps; see ``OmnidirectionalDrive``.

    Attributes:
        contacts: its contacts with obstacles, in order.
        safety_stops: how often it was stopped while it moved; at most once between two commands.
        log: its track: (ps, row, column) at the begin of each motion and at each border that it crossed.

    Raises:
        InputError: a resolution that is not above 0, or a radius below 0.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        *,
        kinematics: Kinematics,
        resolution: float,
        position: Point,
        radius: float = 0.0,
        heading: float = 0.0,
        control_period: int = SECOND // 10,
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(environment, name, listeners)
        if not resolution > 0.0:
            raise InputError(f"a resolution of {resolution} m a cell", f"{name}.resolution", "above 0")
        if not radius >= 0.0:
            raise InputError(f"a radius of {radius} m", f"{name}.radius", "0 or more")
        self.kinematics = kinematics.scaled(1.0 / resolution)
        self.resolution = resolution
        self.radius_cells = radius / resolution
        self.control_period = control_period
        self.contacts: list[Contact] = []
        self.safety_stops = 0
        self.log: list[tuple[int, float, float]] = []
        self._stopping = False
        self._driven = 0.0
        self._moving = 0
        self._time = 0
        self._last_pose = 0.0, float(heading)
        self.stood_since = 0
        self._begin(Motion.stand((float(position[0]), float(position[1])), heading), 0.0, 0)

    def _begin(self, motion: Motion, arc: float, next_crossing: int) -> None:
        """Follow ``motion`` from now. It is at ``arc``, and its next crossing has index ``next_crossing``."""
        self._motion = motion
        self._since = self._time
        self._arc = arc
        self._next = next_crossing
        self.log.append((self._time, *self.position))

    # The state at the last advance.

    @property
    def time(self) -> int:
        """The time up to which the robot was advanced, ps."""
        return self._time

    @property
    def position(self) -> Point:
        """(row, column) in cells; whole numbers are middles."""
        return self._motion.path.point_at(self._arc)

    @property
    def cell(self) -> Cell:
        """The cell of its middle."""
        return cell_of(self.position)

    @property
    def speed(self) -> float:
        """Cells a second."""
        return self._motion.at(self._time - self._since)[1]

    @property
    def heading(self) -> float:
        """Radians, from the direction of growing columns towards growing rows, in -π..π or a little beyond."""
        return self._motion.heading_at(self._time - self._since)

    @property
    def path(self) -> Polyline:
        """The path that it drives or stands on."""
        return self._motion.path

    @property
    def arc(self) -> float:
        """Its arc length on ``path``, cells."""
        return self._arc

    @property
    def authority(self) -> float:
        """The arc length of ``path`` at which it will stop, cells."""
        return self._motion.end

    @property
    def standing_from(self) -> int:
        """The time at which it stops if nothing else happens, ps."""
        return self._since + self._motion.duration

    @property
    def distance(self) -> float:
        """Cells driven."""
        return self._driven

    @property
    def distance_metres(self) -> float:
        """Metres driven."""
        return self._driven * self.resolution

    @property
    def moving(self) -> int:
        """Picoseconds spent moving, turning on the spot included."""
        return self._moving

    @property
    def standing(self) -> int:
        """Picoseconds spent standing."""
        return self._time - self._moving

    @property
    def busy(self) -> int:
        """Picoseconds of motion up to now."""
        return self._moving + self._moved_by(self.now)

    def expected(self, time: int) -> tuple[Point, float]:
        """Its position and speed at ``time`` (ps), if nothing else happens before."""
        arc, speed = self._motion.at(max(time - self._since, 0))
        return self._motion.path.point_at(arc), speed

    # Changes of the state.

    def advance(self, now: int, blocked: NDArray[np.bool_]) -> Contact | None:
        """Move on to ``now`` in a world that was ``blocked`` since the last call.

        Call it before each change of the world, and before a command. Where the path enters a blocked cell, or passes
        a corner beside one, the robot halts before the border.

        Args:
            now: ps.
            blocked: bool, rows × columns: cells that the robot's middle may not enter. Cells outside are blocked.

        Returns:
            The contact, or None.

        Raises:
            RunError: ``now`` lies before the last call.
        """
        if now < self._time:
            raise RunError(f"{self.name} is at {self._time} ps and cannot go back to {now} ps", self.name)
        arc = self._motion.at(now - self._since)[0]
        index = self._obstacle_before(arc, blocked) if arc > self._arc else -1
        if index >= 0:
            return self._run_against(index, now, blocked)
        self._drive_to(arc)
        self._pass_time(now)
        return None

    def _obstacle_before(self, arc: float, blocked: NDArray[np.bool_]) -> int:
        """The crossing before which the robot halts on its path to ``arc``; -1 without an obstacle."""
        entry, _ = self.path.crossings
        last = int(entry.searchsorted(arc + NEAR, side="left"))
        return self.path.first_closed(blocked, self._next, last, is_open=False) if last > self._next else -1

    def _run_against(self, index: int, now: int, blocked: NDArray[np.bool_]) -> Contact:
        """Halt before crossing ``index``, at the time at which the robot arrives there."""
        entry, cells = self.path.crossings
        halt = max(float(entry[index]) - NEAR, self._arc)
        back = NEAR
        parts = [(int(row), int(column)) for row, column in cells[index].reshape(3, 2)]
        closed = [part for part in parts if _is_closed(blocked, part)]
        # Where a path grazes a border, rounding can put a point just before the crossing into the cell behind it.
        while halt > self._arc and cell_of(self.path.point_at(halt)) in closed:
            back *= 2.0
            halt = max(halt - back, self._arc)
        past = max(self._motion.time_at(halt, leaving=True), self._time - self._since)
        contact_time = min(self._since + past, now)
        contact = Contact(contact_time, self.path.point_at(halt), closed[0], self._motion.at(past)[1])
        heading = self._motion.heading_at(past)
        self._drive_to(halt)
        self._pass_time(contact_time)
        self._begin(Motion.halted(self.path, halt, heading), halt, self._next)
        self._pass_time(now)
        if not self._pressed_on(contact):
            self.contacts.append(contact)
        return contact

    def _pressed_on(self, contact: Contact) -> bool:
        """True if the robot was already at the same obstacle and a new command drove it on."""
        if not self.contacts or self.contacts[-1].cell != contact.cell:
            return False
        before = self.contacts[-1].position
        return math.dist(before, contact.position) <= PRESSING

    def _drive_to(self, arc: float) -> None:
        entry, _ = self.path.crossings
        # On a border it has not entered the next cell: towards smaller numbers the border belongs to the old cell.
        following = int(entry.searchsorted(arc, side="left"))
        for index in range(self._next, following):
            border = float(entry[index])
            self.log.append((self._since + self._motion.time_at(border), *self.path.point_at(border)))
        self._next = max(self._next, following)
        self._driven += arc - self._arc
        self._arc = arc

    def _moved_by(self, now: int) -> int:
        """Picoseconds of motion from the last advance to ``now``."""
        return max(min(now, self.standing_from) - self._time, 0)

    def _pass_time(self, now: int) -> None:
        self._moving += self._moved_by(now)
        ends = min(now, self.standing_from)
        self._time = now
        pose = self._driven, self.heading
        if any(abs(new - old) > PRESSING for new, old in zip(pose, self._last_pose, strict=True)):
            self._last_pose, self.stood_since = pose, ends

    def command(self, now: int, path: Polyline, authority: float) -> int | None:
        """Drive ``path`` from now, at most to arc length ``authority``.

        Args:
            now: ps; the time of the last advance.
            path: the path to drive. It begins at the position of the robot: see ``path.join``.
            authority: arc length of ``path``, cells, at which to stop if no newer command arrives.

        Returns:
            None where the robot drives the new path. The robot may be too fast for it: the bend at its begin is too
            sharp, or the authority is shorter than the braking distance. Then it brakes along the old path, and the
            time (ps) at which it will stand is returned. The caller commands again at that time or before.

        Raises:
            RunError: the robot was not advanced to ``now``. InputError: the path begins elsewhere.
        """
        self._check_time(now)
        self._stopping = False
        position = self.position
        if math.dist(position, path.points[0]) > NEAR:
            what = f"a path from {path.point_at(0.0)}, but {self.name} is at {position}"
            raise InputError(what, f"{self.name}.path", "begin it at the position of the robot: join(path, position)")
        if tuple(path.points[0]) != position:
            path = Polyline([position, *path.points[1:]])
        motion = Motion.drive(
            path, self.kinematics, authority, speed=self.speed, heading=self.heading, control_period=self.control_period
        )
        if motion is None:
            self._brake()
            return self.standing_from
        self._begin(motion, 0.0, 1)
        return None

    def stop(self, now: int) -> int:
        """Safety stop: brake along the path as hard as the kinematics allow. Returns when it will stand, ps.

        Where it already brakes for an earlier stop without a command in between, it goes on braking. That is no new
        stop.

        Raises:
            RunError: the robot was not advanced to ``now``.
        """
        self._check_time(now)
        if self.standing_from > now and not self._stopping:
            self._stopping = True
            self.safety_stops += 1
            self._brake()
        return self.standing_from

    def _brake(self) -> None:
        braking = Motion.brake(self.path, self._arc, self.speed, self.kinematics, self.heading)
        self._begin(braking, self._arc, self._next)

    def _check_time(self, now: int) -> None:
        if now != self._time:
            what = f"{self.name} was advanced to {self._time} ps and cannot be commanded at {now} ps"
            raise RunError(what, self.name, "advance it first")


def _is_closed(blocked: NDArray[np.bool_], cell: Cell) -> bool:
    inside = 0 <= cell[0] < blocked.shape[0] and 0 <= cell[1] < blocked.shape[1]
    return not inside or bool(blocked[cell])
