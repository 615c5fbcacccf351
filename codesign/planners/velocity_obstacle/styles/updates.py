"""The work of all robots' circuits, update by update, for the clocks of a fleet's simulation."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from codesign.planners.styles import Step
from codesign.planners.velocity_obstacle.plan.loop import Loop
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.styles import timing


class Updates:
    """The closed loop of n robots, and the cycles that each robot's circuit takes for the present update.

    The caller drives the updates of ``loop`` by its ``hold`` and ``act``, and decides each by ``decide`` here.
    ``cycles``: int64 n, of the last decision.
    """

    def __init__(
        self, problem: RobotsProblem, parameters: AvoidParameters, costs: timing.UpdateCosts
    ) -> None:
        self.loop = Loop(problem, parameters)
        self.costs = costs
        self.cycles: NDArray[np.int64] = np.zeros(problem.count, np.int64)

    def decide(self) -> None:
        """Let all robots decide the next update."""
        self.loop.decide()
        self.cycles = self.costs.of_robot(self.loop.checks, self.loop.trials)

    @property
    def slowest(self) -> int:
        """The robot that the others wait for: the first among equals."""
        return int(np.argmax(self.cycles))

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

    def whole(self, robot: int) -> Generator[Step, None, None]:
        """One robot's update as a step of one unit, where nobody listens to its phases."""
        yield Step("update", self.cycles[robot : robot + 1])
