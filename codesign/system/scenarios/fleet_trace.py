"""What a fleet's run tells its listeners: positions, arrivals, contacts, and who was waited for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from codesign.architectures.velocity_obstacle.updates import Updates
from codesign.planners.velocity_obstacle.problem import RobotsProblem
from codesign.planners.velocity_obstacle.quality import arrival_updates, pair_gaps
from codesign.records import MapRecord, MissionRecord, PositionsRecord, TaskRecord, TrajectoryRecord

if TYPE_CHECKING:
    from codesign.components import Fpga
    from codesign.system.build import Machine

TASK_OF_EACH = 8
"""Up to so many robots each have a ``TaskRecord`` an update; of more, only the one that the others wait for."""
TRAJECTORIES = 64

_SOURCE = "fleet"


class FleetTrace:
    """Tells the listeners of a machine, where it has any; else nothing is made.

    ``PositionsRecord`` at the begin and after each update; ``TaskRecord`` for each robot and update, or the slowest's;
    ``MissionRecord`` for ``deadline_missed``, ``goal_reached`` (one robot each), ``contact`` (two robots touch,
    once until they have parted) and ``ended``; a ``TrajectoryRecord`` for each robot at the end.
    """

    def __init__(self, machine: Machine, work: Updates, problem: RobotsProblem) -> None:
        self._machine = machine
        self._work = work
        self._problem = problem
        self._touching: set[tuple[int, int]] = set()
        self._arrivals: dict[int, list[int]] = {}
        self._contact = False
        if machine.listening:
            self._contact = bool((pair_gaps(work.plan.cells) < 2.0 * problem.radius).any())
            for robot, update in enumerate(arrival_updates(work.plan)):
                if update is not None:
                    self._arrivals.setdefault(update, []).append(robot)

    def begin(self) -> None:
        """The arena with the targets, and the robots at their starts."""
        if not self._machine.listening:
            return
        problem = self._problem
        goals = np.array(problem.goals, np.int32).reshape(-1, 2)
        self._machine.tell(MapRecord(self._machine.now, "map", problem.free, goals, problem.resolution))
        self._positions(0)

    def decided(self, update: int, begin: int, fpgas: tuple[Fpga, ...], missed: bool) -> None:
        """Update number ``update``, which began at ``begin`` (ps), has been decided by all."""
        if not self._machine.listening:
            return
        slowest = int(self._work.slowest[update])
        clock = fpgas[0].clock
        first = clock.cycle_at_or_after(begin)
        for robot in range(len(fpgas)) if len(fpgas) <= TASK_OF_EACH else (slowest,):
            cycles = int(self._work.cycles[update, robot])
            times = clock.edge(first), clock.edge(first + cycles)
            self._machine.tell(TaskRecord(times[0], fpgas[robot].name, "avoid", times[1], cycles))
        if missed:
            text = f"update {update + 1} took longer than its time step; robot {slowest} was last"
            self._tell("deadline_missed", text)

    def ended_update(self, update: int) -> None:
        """Update number ``update`` is over: the robots are where it brought them."""
        if not self._machine.listening:
            return
        self._positions(update + 1)
        if self._contact:
            self._contacts(update)
        # A robot is seen to have arrived at the begin of the update after.
        for robot in self._arrivals.get(update + 1, ()):
            self._tell("goal_reached", f"robot {robot} has arrived")

    def ended(self, text: str, updates: int) -> None:
        """The run is over, after so many updates."""
        if not self._machine.listening:
            return
        self._tell("ended", text)
        cells = self._work.plan.cells[: updates + 1]
        arrivals = arrival_updates(self._work.plan)
        for robot in range(min(self._problem.count, TRAJECTORIES)):
            there = arrivals[robot]
            points = cells[:, robot, ::-1] - 0.5
            record = TrajectoryRecord(
                self._machine.now, f"robot_{robot}", points, there is not None and there <= updates
            )
            self._machine.tell(record)

    def _positions(self, done: int) -> None:
        cells = self._work.plan.cells[done, :, ::-1] - 0.5
        self._machine.tell(PositionsRecord(self._machine.now, _SOURCE, done, cells))

    def _contacts(self, update: int) -> None:
        gaps = pair_gaps(self._work.plan.cells[update : update + 2]) - 2.0 * self._problem.radius
        ones, others = np.triu_indices(self._problem.count, 1)
        touching = {(int(ones[pair]), int(others[pair])) for pair in np.flatnonzero(gaps < 0.0)}
        for one, other in sorted(touching - self._touching):
            self._tell("contact", f"robots {one} and {other} touch in update {update + 1}")
        self._touching = touching

    def _tell(self, event: str, text: str) -> None:
        self._machine.tell(MissionRecord(self._machine.now, _SOURCE, event, text))
