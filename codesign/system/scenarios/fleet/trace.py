"""The records of a fleet's run: positions, arrivals, contacts, and the robot that the others wait for."""

from __future__ import annotations

from typing import Any

import numpy as np

from codesign import components
from codesign.ground.records import MissionRecord, PositionsRecord, TaskRecord, TrajectoryRecord
from codesign.ground.units import format_time
from codesign.planners.styles import FleetUpdates
from codesign.system.build import Machine
from codesign.system.scenarios.records import tell_map

TASK_OF_EACH = 8
"""Up to so many robots each have a ``TaskRecord`` an update; of more, only the one that the others wait for."""
TRAJECTORIES = 64

_SOURCE = "fleet"


class FleetTrace:
    """Makes records for the listeners of a machine; none where it has no listeners.

    ``PositionsRecord`` at the begin, after each update, and where robots that decided late begin to take their new
    velocities; ``TaskRecord`` for each robot and update, or the slowest's; ``MissionRecord`` for ``deadline_missed``,
    ``goal_reached`` (one robot each), ``contact`` (two robots begin to touch) and ``ended``; a ``TrajectoryRecord`` for
    each robot at the end.

    A contact has the moment at which the bodies first touch, between two updates as at one. Robots of a free-running
    fleet take their time step at once, so there the text alone says when in the step.
    """

    def __init__(self, machine: Machine, work: FleetUpdates) -> None:
        self._machine = machine
        self._work = work
        self._robots = len(work.cycles)
        self._arrived = np.zeros(self._robots, np.bool_)

    def begin(self) -> None:
        """The arena with the targets, and the robots at their starts."""
        if not self._machine.listening:
            return
        problem = self._machine.system.problem
        tell_map(self._machine, problem.free, problem.resolution, self._work.radius)
        self._positions()

    def began(self) -> None:
        """An update has begun: robots see whether they have arrived."""
        if not self._machine.listening:
            return
        arrived = self._work.arrived
        for robot in np.flatnonzero(arrived & ~self._arrived).tolist():
            self._tell("goal_reached", f"robot {robot} has arrived")
        self._arrived = arrived.copy()

    def decided(self, begin: int, fpgas: tuple[components.Fpga, ...], missed: bool) -> None:
        """The update that began at ``begin`` (ps) has been decided by all."""
        if not self._machine.listening:
            return
        slowest, task = self._work.slowest, self._machine.system.planner.planning_task
        clock = fpgas[0].clock
        first = clock.cycle_at_or_after(begin)
        several = range(len(fpgas)) if len(fpgas) <= TASK_OF_EACH else (slowest,)
        for robot in several if self._machine.wants(TaskRecord) else ():
            cycles = int(self._work.cycles[robot])
            times = clock.edge(first), clock.edge(first + cycles)
            self._machine.tell(TaskRecord(times[0], fpgas[robot].name, task, times[1], cycles))
        if missed:
            update = self._work.done + 1
            text = f"update {update} took longer than its time step; robot {slowest} was last"
            self._tell("deadline_missed", text)

    def moved(self, update: int, steps: int, taken: int) -> None:
        """The robots have moved on for ``steps`` time steps, in this update, counted from 1.

        ``taken``: the time that this took here, ps; 0 for robots that are simulated by the boards themselves.
        """
        if not self._machine.listening:
            return
        first = self._work.touches()
        # A pair that touches at the begin of a motion was told of at the end of the one before.
        new = np.flatnonzero((first > 0.0) & (first <= 1.0))
        if len(new):
            pairs = np.column_stack(np.triu_indices(self._robots, 1))[new]
            for share, (one, other) in sorted(zip(first[new].tolist(), pairs.tolist(), strict=True)):
                after = format_time(round(share * steps * self._work.step_ps, -6))
                text = f"robots {one} and {other} touch {after} after they began the motion of update {update}"
                self._tell("contact", text, self._machine.now - taken + round(share * taken))
        self._positions()

    def ended(self, text: str, plan: Any) -> None:
        """The run is over."""
        if not self._machine.listening:
            return
        self._tell("ended", text)
        system = self._machine.system
        for robot in range(min(self._robots, TRAJECTORIES)):
            points, arrived = system.planner.trajectory(system.problem, plan, robot)
            self._machine.tell(TrajectoryRecord(self._machine.now, f"robot_{robot}", points, arrived))

    def _positions(self) -> None:
        work = self._work
        self._machine.tell(PositionsRecord(self._machine.now, _SOURCE, work.done, work.positions))

    def _tell(self, event: str, text: str, time: int | None = None) -> None:
        self._machine.tell(MissionRecord(self._machine.now if time is None else time, _SOURCE, event, text))
