"""The scene of a drive: the true map, the robot on it, and what the robot knows."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.components.command import Command
from codesign.components.path import Point, cell_of
from codesign.components.robot import PRESSING, MobileRobot
from codesign.components.sensor import NOTHING, RangeScan, Sensor
from codesign.ground.records import BeliefRecord, MissionRecord, ObstacleRecord, PoseRecord, RobotRecord, ScanRecord
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.components import RobotComponent
from codesign.system.assemble import kinematics_of, sensor_of
from codesign.system.build import Machine
from codesign.system.messages import Wrong
from codesign.system.scenarios.drive.faults import covered, kept_clear, moving_of
from codesign.system.scenarios.drive.tasks import MOVE, drive_on, resolution_of
from codesign.system.scenarios.drive.world.belief import Belief, Update
from codesign.system.scenarios.drive.world.clearance import Clearance
from codesign.system.scenarios.drive.world.obstacles import Appearing, Moving, random_appearing, rectangle
from codesign.system.scenarios.drive.world.true_map import World
from codesign.system.scenarios.scenario import tell_map

Cell = tuple[int, int]

SCAN_EACH, SCAN_GRAIN = 5 * PICOSECONDS_PER_SECOND, 64
"""Picoseconds between two recorded scans, and the parts of a cell that their ranges are rounded to."""


@dataclass(frozen=True, eq=False)
class Look:
    """A look around, as its message carries it: the ``scan``, and where the robot was.

    ``at``: when it was taken, ps. ``position`` (row, column) in cells, ``speed`` in cells a second: the robot's then.
    """

    at: int
    scan: RangeScan
    position: Point
    speed: float

    @property
    def cell(self) -> Cell:
        """The cell in which the robot's middle was."""
        return cell_of(self.position)


@dataclass(frozen=True, eq=False)
class SentLook:
    """A look in its message: ``look`` as it is read, the ``sensor``, and the true map when it was taken."""

    look: Look
    sensor: Sensor
    free: NDArray[np.bool_]
    wrong: frozenset[int] = frozenset()

    def misread(self, wrong: Wrong) -> SentLook | None:
        """The message with these bits wrong as well; None where that changes nothing."""
        bits = self.wrong ^ frozenset(wrong)
        scan = self.sensor.misread(self.free, self.look.position, sorted(bits))
        if scan.same_as(self.look.scan):
            return None
        return replace(self, look=replace(self.look, scan=scan), wrong=bits)


class Scene:
    """The true map over time, the robot, and its belief.

    ``latest_look``: the latest look that reached the map on board. The tasks that keep the map, plan
    and command know the robot's place by it alone. Only the robot itself and the figures know where it is now.

    ``clearance``: how near the robot came to obstacles of the true map.
    ``changed``: times that the world changed, or was to change.
    """

    def __init__(self, machine: Machine) -> None:
        system = machine.system
        scenario = drive_on(system.workload, system.problem)
        name = system.placement.places[MOVE]
        spec = system.platform.of(RobotComponent)[name]
        problem = system.problem
        self.machine, self.scenario, self._scan_due = machine, scenario, 0
        self.resolution = resolution_of(system.workload, problem)
        radius = float(spec.radius.value) / self.resolution
        self.true_free = problem.free & ~covered(problem.free.shape, scenario.hidden)
        self.world = World(self.true_free, appearing=self._appearing(), moving=self._moving(), radius_cells=radius)
        row, column = problem.starts[0]
        # Obstacles of time 0 stand before the first look.
        self.world.advance(0, (float(row), float(column)))
        self.belief = Belief(
            problem.rows, problem.columns, known=problem.free if scenario.known == "all" else None, radius_cells=radius
        )
        self.robot = MobileRobot(
            machine.environment,
            name,
            kinematics=kinematics_of(spec),
            resolution=self.resolution,
            position=(float(row), float(column)),
            radius=float(spec.radius.value),
            control_period=scenario.control_period,
            listeners=machine.listeners,
        )
        self.sensor: Sensor = sensor_of(spec.sensor, self.resolution)
        self.latest_look = Look(0, NOTHING, self.robot.position, 0.0)
        self.changed = 0
        self.clearance = Clearance()
        self.clearance.stand(self.world.free_now, self.robot.position)
        machine.by_name[name] = self.robot
        tell_map(machine, self.world.free_now.copy(), self.resolution, self.robot.radius_cells)
        self._tell_robot(spec)
        self._tell_waiting(0)

    def _tell_robot(self, spec: RobotComponent) -> None:
        """Tell listeners what the robot is, and which obstacles its map does not show."""
        if self.machine.listening:
            hidden = np.argwhere(self.machine.system.problem.free & ~self.world.free_now).astype(np.int32)
            figures = (spec.radius, spec.kinematics.speed, spec.sensor.range)
            radius, speed, reach = (float(figure.value) for figure in figures)
            knows = self.scenario.known == "all"
            self.machine.tell(RobotRecord(0, self.robot.name, radius, speed, reach, spec.sensor.beams, hidden, knows))

    def advance(self) -> None:
        """Bring the robot up to now, and report what it ran against."""
        robot, machine = self.robot, self.machine
        before, path, arc = len(robot.contacts), robot.path, robot.arc
        robot.advance(machine.now, self.world.blocked_for_robot)
        if robot.arc > arc:
            self.clearance.drive(self.world.free_now, path.between(arc, robot.arc))
        if machine.listening:
            corner = machine.system.problem.corner
            for contact in robot.contacts[before:]:
                row, column = contact.position[0] + corner[0], contact.position[1] + corner[1]
                text = (
                    f"ran against {self.named(contact.cell)} at ({row:.3f}, {column:.3f}),"
                    f" {contact.speed * self.resolution:.3g} m/s"
                )
                machine.tell(MissionRecord(contact.time, robot.name, "contact", text))

    def named(self, cell: Cell) -> Cell:
        """A cell as users count it."""
        return self.machine.system.problem.named(cell)

    def moved_since(self, time: int) -> bool:
        """True if the robot came away from where it was after ``time`` (ps)."""
        self.advance()
        return self.robot.stood_since > time

    @property
    def pressed(self) -> Cell | None:
        """The cell that the robot stands against, None where it stands free: its last contact was elsewhere."""
        contacts = self.robot.contacts
        if not contacts or math.dist(contacts[-1].position, self.robot.position) > PRESSING:
            return None
        return contacts[-1].cell

    def look(self) -> Look:
        """The scan of the robot from its place now, with the time, the place and the speed."""
        self.advance()
        self.tell_pose()
        position = self.robot.position
        scan = self.sensor.scan(self.world.free_now, position)
        self._tell_scan(position)
        return Look(self.machine.now, scan, position, self.robot.speed)

    def _tell_scan(self, position: Point) -> None:
        """Tell listeners what the rays of a sensor meet, where the last scan that was told is old enough.

        All scans would take most of a trace. They follow from the true map, the pose and the sensor.
        """
        machine = self.machine
        if machine.now >= self._scan_due and machine.wants(ScanRecord):
            ranges = self.sensor.ranges(self.world.free_now, position)
            if ranges is not None:
                self._scan_due = machine.now + SCAN_EACH
                grained = (np.rint(ranges * SCAN_GRAIN) / SCAN_GRAIN).astype(np.float32)
                machine.tell(ScanRecord(machine.now, self.robot.name, *position, self.sensor.range_cells, grained))

    def tell_pose(self) -> None:
        """Tell listeners where the robot is now."""
        if self.machine.listening:
            robot = self.robot
            speed = robot.speed * self.resolution
            self.machine.tell(PoseRecord(self.machine.now, robot.name, *robot.position, robot.heading, speed))

    def sent(self, look: Look) -> SentLook:
        """A look as the content of its message, in which bits may go wrong."""
        return SentLook(look, self.sensor, self.world.free_now.copy())

    def learn(self, look: Look) -> Update:
        """Believe what was seen; what that changed."""
        self.latest_look = look
        update = self.belief.update(look.scan)
        if update and self.machine.listening:
            blocked = np.arange(len(update.changed)) < len(update.newly_blocked)
            cells = update.changed.astype(np.int32)
            self.machine.tell(BeliefRecord(self.machine.now, self.robot.name, cells, blocked, look.at))
        return update

    def obey(self, command: Command) -> None:
        """The robot takes up a command that has arrived, from where it is now."""
        self.advance()
        robot = self.robot
        path = command.taken_up(robot.position, self.true_free.shape)
        robot.command(self.machine.now, path, path.length)

    def changes(self) -> Generator[Any, Any, None]:
        """Process generator: the world changes at its own times."""
        machine = self.machine
        while (due := self.world.next_change(machine.now)) is not None:
            yield machine.environment.timeout(due - machine.now)
            self.advance()
            self.changed += 1
            before = len(self.world.deferrals)
            cells = self.world.advance(machine.now, self.robot.position)
            if len(cells):
                self.clearance.stand(self.world.free_now, self.robot.position)
            self._tell_waiting(before)
            if len(cells) and machine.listening:
                free = self.world.free_now[cells[:, 0], cells[:, 1]]
                for appeared in (True, False):
                    some = cells[free != appeared].astype(np.int32)
                    if len(some):
                        machine.tell(ObstacleRecord(machine.now, "map", some, appeared))

    def _tell_waiting(self, before: int) -> None:
        """Tell listeners of the obstacles that wait for the robot, but for the first ``before`` of them."""
        if self.machine.listening:
            for waiting in self.world.deferrals[before:]:
                text = f"obstacles.{waiting.kind}[{waiting.index}] waits until the robot has left its place"
                self.machine.tell(MissionRecord(waiting.time, self.robot.name, "obstacle_waits", text))

    def _appearing(self) -> list[Appearing]:
        obstacles = self.scenario.obstacles
        appearing = [
            Appearing(each.at, rectangle(each.row, each.column, each.rows, each.columns), each.until)
            for each in obstacles.appearing
        ]
        random = obstacles.random
        if random is not None:
            appearing += random_appearing(
                self.true_free,
                random.count,
                random.size,
                random.begin,
                random.end,
                random.seed,
                kept_clear(self.machine.system.problem, self.scenario),
                lasting=random.stay,
            )
        return appearing

    def _moving(self) -> list[Moving]:
        count = len(self.scenario.obstacles.moving)
        return [moving_of(self.scenario, index, self.resolution) for index in range(count)]
