"""The work of all robots' circuits, update by update, for the clocks of a fleet's simulation."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from codesign.planners.styles import FleetUpdates, Step
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.kernels import first_touches
from codesign.planners.velocity_obstacle.plan.loop import Loop
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.plan.planner import arrival_updates, run_gaps
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.styles import timing


class Updates(FleetUpdates):
    """The closed ``loop`` of the robots, and the cycles that follow from the candidates and trials of each."""

    def __init__(self, problem: RobotsProblem, parameters: AvoidParameters, costs: timing.UpdateCosts) -> None:
        self.loop = Loop(problem, parameters)
        self.costs = costs
        self.step_ps = parameters.step_ps
        self._step = parameters.step
        self.cycles: NDArray[np.int64] = np.zeros(problem.count, np.int64)
        self._radius = problem.radius
        self._before = self._state()

    @property
    def over(self) -> bool:
        """True if no update follows."""
        return self.loop.over

    @property
    def departure(self) -> str | None:
        """The value that left its word, in a sentence; None where none did."""
        return None if self.loop.departure is None else str(self.loop.departure)

    @property
    def radius(self) -> float:
        """The radius of each robot's body, cells."""
        return self._radius

    @property
    def done(self) -> int:
        """The number of updates that are done."""
        return self.loop.updates

    @property
    def arrived(self) -> NDArray[np.bool_]:
        """Bool n: whether each robot was at its target when the latest decision began."""
        return self.loop.arrived

    @property
    def positions(self) -> NDArray[np.float64]:
        """Float64 n × 2 (row, column): (x, y) of a robot is (column + 0.5, row + 0.5)."""
        return self.loop.cells[:, ::-1] - 0.5

    def decide(self) -> None:
        """Let all robots decide the next update."""
        self.loop.decide()
        self.cycles = self.costs.of_robot(self.loop.checks, self.loop.trials)

    def hold(self, steps: int) -> None:
        """The robots drive on with their velocities for ``steps`` time steps."""
        self._before = self._state()
        self.loop.hold(steps)

    def act(self) -> None:
        """The robots take the velocities that they chose, in one time step."""
        self._before = self._state()
        self.loop.act()

    def touches(self) -> NDArray[np.float64]:
        """The times at which the bodies of each pair first touch in the latest ``hold`` or ``act``, as shares of it."""
        (cells, speeds, steps), now = self._before, self._state()
        seconds = (now[2] - steps) * self._step
        return first_touches(cells, now[0], speeds * seconds, 2.0 * self._radius)

    def steps(self, robot: int, *, visits: bool) -> Generator[Step, None, None]:
        """The phases of one robot's update.

        ``visits``: each trial is a unit of its own; else a phase is one. The cycles are the same.
        """
        checks, trials = int(self.loop.checks[robot]), int(self.loop.trials[robot])
        for phase, amount in self.costs.phases(checks, trials).items():
            if amount:
                split = visits and phase == timing.VERIFY
                units = np.full(trials, self.costs.trial, np.int64) if split else np.array([amount], np.int64)
                yield Step(phase, units, ram_addresses=timing.addresses(phase))

    def plan(self) -> Avoidance:
        """The run up to its last complete update."""
        return self.loop.plan()

    def arrivals(self, plan: Avoidance) -> list[int | None]:
        """For each robot the updates that were done when it had arrived, or None."""
        return arrival_updates(plan)

    def collisions(self, plan: Avoidance) -> int:
        """The number of pairs of robots that touched in the run, at an update or between two."""
        return int((run_gaps(plan) < 2.0 * self._radius).sum())

    def time_steps(self, plan: Avoidance) -> int:
        """The number of time steps that the run took."""
        return int(plan.times[-1])

    def _state(self) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
        return self.loop.cells, self.loop.speeds, self.loop.steps
