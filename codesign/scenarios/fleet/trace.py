"""The records of a fleet's run: positions, arrivals, contacts, and the robot that the others wait for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.gaps import pair_gaps
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.plan.quality import arrival_updates
from codesign.planners.velocity_obstacle.styles.updates import Updates
from codesign.records import MapRecord, MissionRecord, PositionsRecord, TaskRecord, TrajectoryRecord

if TYPE_CHECKING:
    from codesign.components import Fpga
    from codesign.system.build import Machine

TASK_OF_EACH = 8
"""Up to so many robots each have a ``TaskRecord`` an update; of more, only the one that the others wait for."""
TRAJECTORIES = 64

_SOURCE = "fleet"


class FleetTrace:
    """Makes records for the listeners of a machine; none where it has no listeners.

    ``PositionsRecord`` at the begin, after each update, and where robots that decided late begin to take their new
    velocities; ``TaskRecord`` for each robot and update, or the slowest's; ``MissionRecord`` for ``deadline_missed``,
    ``goal_reached`` (one robot each), ``contact`` (two robots touch, once until they have parted) and ``ended``; a
    ``TrajectoryRecord`` for each robot at the end.
    """

    def __init__(self, machine: Machine, work: Updates, problem: RobotsProblem) -> None:
        self._machine = machine
        self._work = work
        self._problem = problem
        self._touching: set[tuple[int, int]] = set()
        self._arrived = np.zeros(problem.count, np.bool_)
        # The state that was recorded last, and its time in time steps.
        self._cells, self._speeds, self._steps = work.loop.cells, work.loop.speeds, 0

    def begin(self) -> None:
        """The arena with the targets, and the robots at their starts."""
        if not self._machine.listening:
            return
        problem = self._problem
        goals = np.array(problem.goals, np.int32).reshape(-1, 2)
        self._machine.tell(MapRecord(self._machine.now, "map", problem.free, goals, problem.resolution))
        self._positions()

    def began(self) -> None:
        """An update has begun: robots see whether they have arrived."""
        if not self._machine.listening:
            return
        arrived = self._work.loop.arrived
        for robot in np.flatnonzero(arrived & ~self._arrived).tolist():
            self._tell("goal_reached", f"robot {robot} has arrived")
        self._arrived = arrived.copy()

    def decided(self, begin: int, fpgas: tuple[Fpga, ...], missed: bool) -> None:
        """The update that began at ``begin`` (ps) has been decided by all."""
        if not self._machine.listening:
            return
        slowest = self._work.slowest
        clock = fpgas[0].clock
        first = clock.cycle_at_or_after(begin)
        for robot in range(len(fpgas)) if len(fpgas) <= TASK_OF_EACH else (slowest,):
            cycles = int(self._work.cycles[robot])
            times = clock.edge(first), clock.edge(first + cycles)
            self._machine.tell(TaskRecord(times[0], fpgas[robot].name, "avoid", times[1], cycles))
        if missed:
            update = self._work.loop.updates + 1
            text = f"update {update} took longer than its time step; robot {slowest} was last"
            self._tell("deadline_missed", text)

    def moved(self, update: int) -> None:
        """The robots have moved on to the state that they are in now, in this update, counted from 1."""
        if not self._machine.listening:
            return
        loop = self._work.loop
        before = self._cells, self._speeds, self._steps
        self._cells, self._speeds, self._steps = loop.cells, loop.speeds, loop.steps
        self._positions()
        legs = np.stack([before[0], self._cells]), np.stack([before[1], self._speeds])
        seconds = np.array([(self._steps - before[2]) * loop.parameters.step])
        gaps = pair_gaps(*legs, seconds) - 2.0 * self._problem.radius
        firsts, seconds_of_pairs = np.triu_indices(self._problem.count, 1)
        touching = {(int(firsts[pair]), int(seconds_of_pairs[pair])) for pair in np.flatnonzero(gaps < 0.0)}
        for first, second in sorted(touching - self._touching):
            self._tell("contact", f"robots {first} and {second} touch in update {update}")
        self._touching = touching

    def ended(self, text: str, plan: Avoidance) -> None:
        """The run is over."""
        if not self._machine.listening:
            return
        self._tell("ended", text)
        arrivals = arrival_updates(plan)
        for robot in range(min(self._problem.count, TRAJECTORIES)):
            points = plan.cells[:, robot, ::-1] - 0.5
            record = TrajectoryRecord(
                self._machine.now, f"robot_{robot}", points, arrivals[robot] is not None
            )
            self._machine.tell(record)

    def _positions(self) -> None:
        cells = self._cells[:, ::-1] - 0.5
        self._machine.tell(PositionsRecord(self._machine.now, _SOURCE, self._work.loop.updates, cells))

    def _tell(self, event: str, text: str) -> None:
        self._machine.tell(MissionRecord(self._machine.now, _SOURCE, event, text))
