"""The work of all robots' circuits, update by update: what a fleet's simulation puts on its clocks."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.architectures.interface import Step
from codesign.architectures.velocity_obstacle import timing
from codesign.planners.velocity_obstacle.avoid import Avoidance


@dataclass(frozen=True, eq=False)
class Updates:
    """A run of n robots over u updates, and the cycles that each robot's circuit takes for each of them.

    ``overflow``: what left its word in the update after the last one, and ended the run; None where nothing did.
    """

    plan: Avoidance
    costs: timing.UpdateCosts
    overflow: str | None = None

    @cached_property
    def cycles(self) -> NDArray[np.int64]:
        """Cycles of each update and robot, int64 u × n."""
        return self.costs.of_robot(self.plan.checks, self.plan.trials)

    @cached_property
    def slowest(self) -> NDArray[np.int64]:
        """The robot that the others wait for in each update, int64 u: of equals the first."""
        return np.asarray(np.argmax(self.cycles, axis=1))

    def steps(self, update: int, robot: int, *, visits: bool) -> Generator[Step, None, None]:
        """The phases of one robot's update.

        ``visits``: each trial is a unit of its own; else a phase is one. The cycles are the same.
        """
        checks, trials = int(self.plan.checks[update, robot]), int(self.plan.trials[update, robot])
        for phase, amount in self.costs.phases(checks, trials).items():
            if amount:
                split = visits and phase == timing.VERIFY
                units = np.full(trials, self.costs.trial, np.int64) if split else np.array([amount], np.int64)
                yield Step(phase, units, ram_addresses=timing.addresses(phase))

    def whole(self, update: int, robot: int) -> Generator[Step, None, None]:
        """One robot's update as a step of one unit: for a circuit whose phases nobody asks for."""
        yield Step("update", self.cycles[update, robot : robot + 1])
