"""Velocity obstacles as a plug-in: what ``codesign.planners.interface.Planner`` asks for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from codesign.planners.velocity_obstacle.avoid import Avoidance, avoid, fault_of
from codesign.planners.velocity_obstacle.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.problem import RobotsProblem
from codesign.planners.velocity_obstacle.quality import RobotsQuality, quality


class VelocityObstacle:
    """Collision avoidance of n robots with acceleration limits: one task, ``avoid``, on a ``RobotsProblem``."""

    name = "velocity_obstacle"
    planning_task = "avoid"

    @property
    def tasks(self) -> Mapping[str, type[BaseModel]]:
        """The tasks of a mapping, with their parameter models."""
        return {"avoid": AvoidParameters}

    def check(self, problem: RobotsProblem, parameters: AvoidParameters) -> tuple[str, str] | None:
        """The array of velocities must be fine enough for the acceleration, and the words wide enough."""
        return fault_of(problem, parameters)

    def plan(self, problem: RobotsProblem, parameters: AvoidParameters) -> Avoidance:
        """Run all robots in the closed loop, without a clock."""
        return avoid(problem, parameters)

    def quality(self, problem: RobotsProblem, plan: Avoidance) -> RobotsQuality:
        """Collisions, arrivals and detours of the run."""
        return quality(problem, plan)

    def identity(self, plan: Avoidance) -> str:
        """The digest of all states of the run."""
        return plan.digest

    def figures(self, plan: Avoidance) -> dict[str, Any]:
        """Updates of the run, and how many candidates and trials they took."""
        decided = plan.checks > 0
        decisions = int(decided.sum())
        return {
            "details": {
                "updates": plan.updates,
                "decisions": decisions,
                "trials": int(plan.trials.sum()),
                "trials_a_decision_mean": float(plan.trials.sum() / decisions) if decisions else 0.0,
                "trials_a_decision_most": int(plan.trials.max(initial=0)),
                "acceleration_checks": int(plan.checks.sum()),
                "position_resolution_cells": 2.0**-plan.formats.position,
                "velocity_resolution_cells_a_second": 2.0**-plan.formats.velocity,
            }
        }

    def trajectory(
        self, problem: RobotsProblem, plan: Avoidance, start: int
    ) -> tuple[NDArray[np.float64], bool]:
        """The way of robot number ``start``: float64 (updates + 1) × 2 (row, column), and whether it arrived.

        Cells are counted from their middle as everywhere: (x, y) of a robot is (column + 0.5, row + 0.5).
        """
        from codesign.planners.velocity_obstacle.quality import arrival_updates

        assert 0 <= start < problem.count
        return plan.cells[:, start, ::-1] - 0.5, arrival_updates(plan)[start] is not None


PLANNER = VelocityObstacle()
