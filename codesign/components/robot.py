"""A robot: it drives along a way, is nowhere but where its motion says, and never enters a cell that is blocked.

Lazy: it makes no event of the simulation. Its state is a closed-form function of the time since the last command, so
it is brought up to date when somebody needs to know: at every control turn and, before the world changes, at every
change of the world. Advancing in many small steps or in one large gives the same state.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import simpy
from numpy.typing import NDArray

from codesign.components.component import Component
from codesign.components.motion import SECOND, Kinematics, Motion
from codesign.components.way import NEAR, Cell, Point, Way, cell_of
from codesign.errors import InputError, RunError
from codesign.records import Listener

PRESSING = 1e-3
"""Cells: a robot that moved less since it ran against a cell is still at it."""


@dataclass(frozen=True)
class Contact:
    """The robot ran against something: ``time`` (ps), ``position`` (row, column), the ``cell`` that it did not enter,
    and the ``speed`` (cells/s) that it lost at once."""

    time: int
    position: Point
    cell: Cell
    speed: float


class Robot(Component):
    """One robot.

    Args:
        environment, name, listeners: as for every component.
        kinematics: limits in metres and seconds.
        resolution: metres a cell.
        position: (row, column) in cells where it stands at time 0.
        radius: metres, of its body. It is not used here: ``advance`` is given the cells that its middle may not enter.
        heading: radians, from the direction of growing columns towards that of growing rows.
        control_period: ps; see ``OmnidirectionalDrive``.

    Attributes:
        contacts: where it ran against something, in order.
        safety_stops: how often it was stopped while it moved; once between two commands.
        log: (ps, row, column) where it began each motion and where it came from one cell into the next: its track.

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
        """From now on follow ``motion``, which is at ``arc`` and enters crossing ``next_crossing`` of its way next."""
        self._motion = motion
        self._since = self._time
        self._arc = arc
        self._next = next_crossing
        self.log.append((self._time, *self.position))

    # What it is now, or was when it was last advanced.

    @property
    def time(self) -> int:
        """The time up to which the robot was advanced, ps."""
        return self._time

    @property
    def position(self) -> Point:
        """(row, column) in cells; whole numbers are middles."""
        return self._motion.way.point_at(self._arc)

    @property
    def cell(self) -> Cell:
        """The cell in which its middle is."""
        return cell_of(self.position)

    @property
    def speed(self) -> float:
        """Cells a second."""
        return self._motion.at(self._time - self._since)[1]

    @property
    def heading(self) -> float:
        """Radians, from the direction of growing columns towards that of growing rows, in -π..π or a little beyond."""
        return self._motion.heading_at(self._time - self._since)

    @property
    def way(self) -> Way:
        """The way that it follows, or stands on."""
        return self._motion.way

    @property
    def arc(self) -> float:
        """How far along ``way`` it is, cells."""
        return self._arc

    @property
    def authority(self) -> float:
        """The arc length of ``way`` at which it will stand, cells."""
        return self._motion.end

    @property
    def standing_from(self) -> int:
        """The time from which it stands if nothing happens to it, ps."""
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
        """Where it will be at ``time`` (ps), and how fast, if nothing happens to it before."""
        arc, speed = self._motion.at(max(time - self._since, 0))
        return self._motion.way.point_at(arc), speed

    # What happens to it.

    def advance(self, now: int, blocked: NDArray[np.bool_]) -> Contact | None:
        """Move on to ``now`` in a world that has been as ``blocked`` says since the last call.

        To be called before the world changes, and before a command. Where the way leads into a blocked cell, or
        through a corner beside one, the robot halts before its border: it never enters.

        Args:
            now: ps.
            blocked: bool, rows × columns: cells that the robot's middle may not enter. Outside of it is blocked.

        Returns:
            The contact, where there was one.

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
        """The crossing before which the robot halts on its way to ``arc``; -1 where nothing is in the way."""
        entry, _ = self.way.crossings
        last = int(entry.searchsorted(arc + NEAR, side="left"))
        return self.way.first_closed(blocked, self._next, last, is_open=False) if last > self._next else -1

    def _run_against(self, index: int, now: int, blocked: NDArray[np.bool_]) -> Contact:
        """Halt before crossing ``index``, at the time at which the robot comes there."""
        entry, cells = self.way.crossings
        halt = max(float(entry[index]) - NEAR, self._arc)
        back = NEAR
        parts = [(int(row), int(column)) for row, column in cells[index].reshape(3, 2)]
        closed = [part for part in parts if _is_closed(blocked, part)]
        # A way that grazes a border can round into the cell behind it even a little before the crossing.
        while halt > self._arc and cell_of(self.way.point_at(halt)) in closed:
            back *= 2.0
            halt = max(halt - back, self._arc)
        past = max(self._motion.time_at(halt, leaving=True), self._time - self._since)
        contact_time = min(self._since + past, now)
        contact = Contact(contact_time, self.way.point_at(halt), closed[0], self._motion.at(past)[1])
        heading = self._motion.heading_at(past)
        self._drive_to(halt)
        self._pass_time(contact_time)
        self._begin(Motion.halted(self.way, halt, heading), halt, self._next)
        self._pass_time(now)
        if not self._pressed_on(contact):
            self.contacts.append(contact)
        return contact

    def _pressed_on(self, contact: Contact) -> bool:
        """Whether the robot stood at the same obstacle already and was only told to drive on."""
        if not self.contacts or self.contacts[-1].cell != contact.cell:
            return False
        before = self.contacts[-1].position
        return math.dist(before, contact.position) <= PRESSING

    def _drive_to(self, arc: float) -> None:
        entry, _ = self.way.crossings
        # On a border it has not entered: where it drives towards smaller numbers, the border is still the old cell's.
        following = int(entry.searchsorted(arc, side="left"))
        for index in range(self._next, following):
            at = float(entry[index])
            self.log.append((self._since + self._motion.time_at(at), *self.way.point_at(at)))
        self._next = max(self._next, following)
        self._driven += arc - self._arc
        self._arc = arc

    def _moved_by(self, now: int) -> int:
        """Picoseconds of motion from the last time to ``now``."""
        return max(min(now, self.standing_from) - self._time, 0)

    def _pass_time(self, now: int) -> None:
        self._moving += self._moved_by(now)
        ends = min(now, self.standing_from)
        self._time = now
        pose = self._driven, self.heading
        if any(abs(new - old) > PRESSING for new, old in zip(pose, self._last_pose, strict=True)):
            self._last_pose, self.stood_since = pose, ends

    def command(self, now: int, way: Way, authority: float) -> int | None:
        """Drive ``way``, at most up to arc length ``authority``, from now on.

        Args:
            now: ps; the robot must have been advanced to it.
            way: where to drive. It begins where the robot is: see ``way.join``.
            authority: arc length of ``way``, cells, at which to stand if no newer command comes.

        Returns:
            None where the robot drives the new way. Where it is too fast for it (too sharp a bend at its begin, or
            less room than it needs to brake) it brakes along the old way instead, and the time (ps) at which it will
            stand is returned: the caller commands again, then or before.

        Raises:
            RunError: the robot was not advanced to ``now``. InputError: the way begins elsewhere.
        """
        self._check_time(now)
        self._stopping = False
        position = self.position
        if math.dist(position, way.points[0]) > NEAR:
            raise InputError(
                f"a way from {way.point_at(0.0)}, but {self.name} is at {position}",
                f"{self.name}.way",
                "begin it where the robot is: join(way, position)",
            )
        if tuple(way.points[0]) != position:
            way = Way([position, *way.points[1:]])
        motion = Motion.drive(
            way,
            self.kinematics,
            authority,
            speed=self.speed,
            heading=self.heading,
            control_period=self.control_period,
        )
        if motion is None:
            self._brake()
            return self.standing_from
        self._begin(motion, 0.0, 1)
        return None

    def stop(self, now: int) -> int:
        """Safety stop: brake as hard as the kinematics allow, along the way; returns when it will stand, ps.

        One that brakes already, for a stop since which no command came, goes on braking: that is no new stop.

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
        braking = Motion.brake(self.way, self._arc, self.speed, self.kinematics, self.heading)
        self._begin(braking, self._arc, self._next)

    def _check_time(self, now: int) -> None:
        if now != self._time:
            raise RunError(
                f"{self.name} was advanced to {self._time} ps and cannot be commanded at {now} ps",
                self.name,
                "advance it first",
            )


def _is_closed(blocked: NDArray[np.bool_], cell: Cell) -> bool:
    inside = 0 <= cell[0] < blocked.shape[0] and 0 <= cell[1] < blocked.shape[1]
    return not inside or bool(blocked[cell])
