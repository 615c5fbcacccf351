"""Relaxation as a plug-in: what ``codesign.planners.interface.Planner`` asks for."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from codesign.planners.interface import Messages, Problem, Quality
from codesign.planners.relaxation.parameters import RelaxParameters
from codesign.planners.relaxation.search import Search
from codesign.planners.relaxation.solve import Solution, refusal, solve

CELL_BITS = 2
"""A cell of the map on its way to the planner: free, obstacle or goal."""

STEP_BITS = 64
"""The next cell of the way: row and column, 32 bits each."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A potential, and how it is followed. ``neighbours``: cells that a step of the search chooses from."""

    solution: Solution
    neighbours: int


class Relaxation:
    """Laplace's equation by relaxation in doubles: task ``relax``."""

    name = "relaxation"
    planning_task = "relax"
    problem_model = None
    description = "Laplace's equation relaxed in doubles on a host (Saudi and Sulaiman 2016)"

    @property
    def tasks(self) -> Mapping[str, type[BaseModel]]:
        """The tasks of a mapping, with their parameter models."""
        return {"relax": RelaxParameters}

    def check(self, problem: Problem, parameters: RelaxParameters) -> tuple[str, str] | None:
        """The method must suit the map."""
        reason = refusal(parameters.method, problem.free.shape, problem.goals)
        return None if reason is None else ("method", reason)

    def plan(self, problem: Problem, parameters: RelaxParameters) -> Plan:
        """Compute the potential."""
        solution = solve(
            problem.free,
            problem.goals,
            method=parameters.method,
            omega=parameters.omega,
            r=parameters.r,
            tolerance=parameters.tolerance,
            boundary=parameters.boundary,
            max_iterations=parameters.max_iterations,
        )
        return Plan(solution, parameters.neighbours)

    def messages(self, problem: Problem) -> Messages:
        """The map goes to the planner, the first step of the search comes back."""
        return Messages("map", CELL_BITS * problem.free.size, "step", STEP_BITS)

    def quality(self, problem: Problem, plan: Plan) -> Quality:
        """What following the potential is worth."""
        from codesign.planners.relaxation.quality import quality

        return quality(problem, search_of(problem, plan))

    def identity(self, plan: Plan) -> str:
        """The digest of the potential and of the rule that follows it."""
        solution = plan.solution
        text = f"{solution.boundary}{plan.neighbours}{solution.potential.shape}"
        return hashlib.sha256(text.encode() + solution.potential.tobytes()).hexdigest()

    def figures(self, plan: Plan) -> dict[str, Any]:
        """How the potential came about."""
        solution = plan.solution
        state = (
            "converged" if solution.converged else "stagnated" if solution.stagnated else "iteration limit"
        )
        details: dict[str, int | float | str] = {
            "method": str(solution.method),
            "iterations": solution.iterations,
            "node_updates": solution.updates,
            "largest_last_change": solution.change,
            "ended": state,
        }
        details |= {
            name: value for name, value in (("omega", solution.omega), ("r", solution.r)) if value is not None
        }
        return {"details": details}

    def trajectory(
        self, problem: Problem, plan: Plan, start: tuple[int, int]
    ) -> tuple[NDArray[np.float64], bool]:
        """The way of the gradient descent search from ``start``."""
        way = search_of(problem, plan).follow(start)
        return way.cells.astype(np.float64), way.arrived


def search_of(problem: Problem, plan: Plan) -> Search:
    """The search over a plan's potential."""
    return Search(
        plan.solution.potential,
        problem.free,
        problem.goals,
        neighbours=plan.neighbours,
        upwards=plan.solution.boundary.upwards,
    )


PLANNER = Relaxation()
