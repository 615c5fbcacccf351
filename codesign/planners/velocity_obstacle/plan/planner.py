"""Velocity obstacles as a plug-in: the members of ``codesign.planners.interface.Planner``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.models import TaskParameters
from codesign.planners.interface import Planner, RobotsQuality
from codesign.planners.job import Flow, Job
from codesign.planners.velocity_obstacle.plan.avoid import avoid
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.faults import fault_of
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, RobotsWorkload
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.plan.quality import arrival_updates, quality
from codesign.planners.velocity_obstacle.plan.reference import BRAKE

STATE_BYTES = 120
"""Bytes of a robot at one update: 44 in words, 32 in cells, and the rest for the run's quality."""

COORDINATE_BITS = 16
"""A coordinate on a link, whatever the width of the words inside: assumed, two bytes on a serial line."""


class VelocityObstacle(Planner):
    """Collision avoidance of n robots with acceleration limits: one task, ``avoid``, on a ``RobotsProblem``."""

    name = "velocity_obstacle"
    planning_task = "avoid"
    problem_model = RobotsWorkload
    fields_a_stage = 0
    description = "several robots that avoid each other, in fixed point (Dubey et al. 2013)"

    @property
    def tasks(self) -> Mapping[str, type[TaskParameters]]:
        """The tasks of a mapping, with their parameter models."""
        return {"avoid": AvoidParameters}

    def check(self, job: Job[RobotsProblem, AvoidParameters]) -> tuple[str, str] | None:
        """The array of velocities must be fine enough for the acceleration, and the words wide enough."""
        return fault_of(job.problem, job.parameters)

    def reachable(self, job: Job[RobotsProblem, AvoidParameters]) -> NDArray[np.bool_]:
        """Every cell of the arena, which has no obstacles: bool rows × columns."""
        width, height = job.problem.arena
        return np.ones((math.ceil(height), math.ceil(width)), np.bool_)

    def plan(self, job: Job[RobotsProblem, AvoidParameters]) -> Avoidance:
        """Run all robots in the closed loop, without a clock."""
        return avoid(job.problem, job.parameters)

    def flows(self, job: Job[RobotsProblem, AvoidParameters]) -> tuple[Flow, ...]:
        """Start and target of each robot, and the robots' coordinates once, for the display (section VI)."""
        coordinates = 2 * COORDINATE_BITS * job.problem.count
        return (Flow("load", "avoid", "robots", 2 * coordinates), Flow("avoid", "command", "coordinates", coordinates))

    def memory(self, job: Job[RobotsProblem, AvoidParameters]) -> int:
        """For each robot and update positions, velocities and counts, in words and once more in cells."""
        return STATE_BYTES * job.problem.count * (job.parameters.updates + 1)

    def quality(self, problem: RobotsProblem, plan: Avoidance) -> RobotsQuality:
        """Collisions, arrivals and detours of the run."""
        return quality(problem, plan)

    def identity(self, plan: Avoidance) -> str:
        """The digest of all states of the run, and its parameters, on which its remedy depends."""
        return f"{plan.digest} {plan.parameters.model_dump_json()}"

    def figures(self, plan: Avoidance) -> dict[str, Any]:
        """The decisions of the run, their candidates, and the resolution of its words."""
        decisions = int((plan.checks > 0).sum())
        return {
            "details": {
                "updates": plan.updates,
                "decisions": decisions,
                "trials": int(plan.trials.sum()),
                "trials_a_decision_mean": float(plan.trials.sum() / decisions) if decisions else 0.0,
                "trials_a_decision_most": int(plan.trials.max(initial=0)),
                "acceleration_checks": int(plan.checks.sum()),
                "decisions_without_safe_velocity": int((plan.candidates == BRAKE).sum()),
                "position_resolution_cells": 2.0**-plan.formats.position,
                "velocity_resolution_cells_a_second": 2.0**-plan.formats.velocity,
            }
        }

    def trajectory(self, problem: RobotsProblem, plan: Avoidance, start: int) -> tuple[NDArray[np.float64], bool]:
        """The path of robot number ``start``: float64 (updates + 1) × 2 (row, column), and whether it arrives.

        Cells are counted from their middle as everywhere: (x, y) of a robot is (column + 0.5, row + 0.5).
        """
        assert 0 <= start < problem.count
        return plan.cells[:, start, ::-1] - 0.5, arrival_updates(plan)[start] is not None


PLANNER = VelocityObstacle()
