"""Relaxation as a plug-in: the members of ``codesign.planners.interface.Planner``."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from codesign.ground.models import TaskParameters
from codesign.planners.interface import (
    Cell,
    LoadParameters,
    Planner,
    Policy,
    Problem,
    Quality,
    by_sides,
    cell_of,
    from_position,
)
from codesign.planners.job import Flow, Job
from codesign.planners.relaxation.plan.parameters import DEFAULT_METHOD, Method, RelaxParameters, SearchParameters
from codesign.planners.relaxation.plan.quality import quality
from codesign.planners.relaxation.plan.search import Search
from codesign.planners.relaxation.plan.solve import Solution, refusal, solve

CELL_BITS = 2
"""A cell of the map on the link to the planner: free, obstacle or goal."""

VALUE_BITS = 64
"""A value of the potential: a double."""

FACTOR_BYTES, FACTOR_GROWTH = 750, 0.35
"""Sparse factors: bytes a cell at 2^18 cells, and the power of the cells by which they grow. Fitted to peaks measured
on empty maps of 2^16 to 2^20 cells; maps of rooms take half as much."""

STEP_BITS = POSE_BITS = 64
"""The next cell of the path: row and column, 32 bits each."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A potential, and the rule that follows it. ``neighbours``: cells that a step of the search chooses from."""

    solution: Solution
    neighbours: int


_searches: WeakKeyDictionary[Plan, tuple[str, Search]] = WeakKeyDictionary()


class Relaxation(Planner):
    """Laplace's equation by relaxation in doubles: tasks ``load``, ``relax`` and ``search``."""

    name = "relaxation"
    planning_task = "relax"
    policies: tuple[Policy, ...] = ("restart", "continue")
    description = "Laplace's equation relaxed in doubles on a host (Saudi and Sulaiman 2016)"

    @property
    def tasks(self) -> Mapping[str, type[TaskParameters]]:
        """The tasks of a mapping, with their parameter models."""
        return {"load": LoadParameters, "relax": RelaxParameters, "search": SearchParameters}

    def check(self, job: Job[Problem, RelaxParameters]) -> tuple[str, str] | None:
        """The method must suit the map."""
        problem = job.problem
        reason = refusal(job.parameters.method, problem.free.shape, problem.goals)
        return None if reason is None else ("method", reason)

    def plans_for_start(self, _job: Job[Problem, RelaxParameters], /) -> bool:
        """The potential leads from every cell."""
        return False

    def answer_class(self, job: Job[Problem, RelaxParameters], start: Cell) -> int:
        """The cells of the path that the search enters."""
        return len(search_of(job.problem, job.plan).follow(start).cells)

    def arrival_changes(self, job: Job[Problem, RelaxParameters]) -> dict[str, dict[str, dict[str, Any]]]:
        """The default method and run, and the direct solution."""
        names = ("omega", "r", "tolerance", "boundary", "max_iterations")
        plain = {name: type(job.parameters).model_fields[name].default for name in names}
        return {
            "method": {str(method): {**plain, "method": method.value} for method in (DEFAULT_METHOD, Method.DIRECT)}
        }

    def reachable(self, job: Job[Problem, RelaxParameters]) -> NDArray[np.bool_]:
        """A step of the search never cuts a corner, with four neighbours or with eight."""
        return by_sides(job.problem)

    def plan(self, job: Job[Problem, RelaxParameters]) -> Plan:
        """Compute the potential, from nothing or from the potential of an earlier plan."""
        problem, parameters = job.problem, job.parameters
        solution = solve(
            problem.free,
            problem.goals,
            method=parameters.method,
            omega=parameters.omega,
            r=parameters.r,
            tolerance=parameters.tolerance,
            boundary=parameters.boundary,
            max_iterations=parameters.max_iterations,
            start=job.start,
        )
        return Plan(solution, parameters.neighbours)

    def flows(self, job: Job[Problem, RelaxParameters]) -> tuple[Flow, ...]:
        """The map, two bits a cell; the potential, a double a cell; the next cell, row and column."""
        cells = job.problem.free.size
        return (
            Flow("load", "relax", "map", CELL_BITS * cells),
            Flow("relax", "search", "potential", VALUE_BITS * cells),
            Flow("load", "search", "pose", POSE_BITS),
            Flow("search", "command", "step", STEP_BITS),
        )

    def memory(self, job: Job[Problem, RelaxParameters]) -> int:
        """Measured: 43 bytes a cell by sweeps; the factors of the direct solver, 0.8 KB a cell of 2^18, and growing."""
        cells = job.problem.free.size
        return round(cells * (43 + factor_bytes(job)))

    def memory_levers(self, job: Job[Problem, RelaxParameters]) -> list[str]:
        """Sweeps instead of factors."""
        return ["a method of sweeps such as sor"] if job.parameters.method is Method.DIRECT else []

    def quality(self, problem: Problem, plan: Plan) -> Quality:
        """The quality of the paths down the potential."""
        return quality(problem, search_of(problem, plan), plan.solution)

    def identity(self, plan: Plan) -> str:
        """The digest of the potential, of its run, and of the rule that follows it."""
        solution = plan.solution
        run = f"{solution.method} {solution.omega} {solution.r} {solution.ended}"
        text = f"{run}{solution.boundary}{plan.neighbours}{solution.potential.shape}"
        return hashlib.sha256(text.encode() + solution.potential.tobytes()).hexdigest()

    def figures(self, plan: Plan) -> dict[str, Any]:
        """The run that computed the potential."""
        solution = plan.solution
        details: dict[str, int | float | str] = {
            "method": str(solution.method),
            "iterations": solution.iterations,
            "node_updates": solution.updates,
            "checks": solution.checks,
            "largest_last_change": solution.change,
            "ended": str(solution.ended),
        }
        if solution.factors:
            details["factor_values"] = solution.factors
        details |= {name: value for name, value in (("omega", solution.omega), ("r", solution.r)) if value is not None}
        return {"details": details}

    def trajectory(self, problem: Problem, plan: Plan, start: tuple[int, int]) -> tuple[NDArray[np.float64], bool]:
        """The path of the gradient descent search from ``start``."""
        descent = search_of(problem, plan).follow(start)
        return descent.cells.astype(np.float64), descent.arrived

    def start_of(self, plan: Plan) -> NDArray[np.float64]:
        """The potential, rows × columns."""
        return plan.solution.potential

    def path_from(self, problem: Problem, plan: Plan, start: tuple[float, float]) -> tuple[NDArray[np.float64], bool]:
        """The path of the gradient descent search from a position: the path of its cell without the cell's middle."""
        cell = cell_of(problem, start)
        if cell is None:
            return np.array([start], np.float64), False
        descent = search_of(problem, plan).follow(cell)
        if len(descent.cells) == 1 and not descent.arrived:
            return np.array([start], np.float64), False
        return from_position(start, descent.cells, problem.free), descent.arrived


def factor_bytes(job: Job[Problem, RelaxParameters]) -> float:
    """Bytes a cell of the factors of the direct solution; 0 for sweeps."""
    if job.parameters.method is not Method.DIRECT:
        return 0.0
    return float(FACTOR_BYTES * (job.problem.free.size / 2**18) ** FACTOR_GROWTH)


def search_of(problem: Problem, plan: Plan) -> Search:
    """The search over a plan's potential, prepared once for all positions."""
    kept = _searches.get(plan)
    if kept is None or kept[0] != problem.map_digest:
        search = Search(
            plan.solution.potential,
            problem.free,
            problem.goals,
            neighbours=plan.neighbours,
            upwards=plan.solution.boundary.upwards,
        )
        kept = _searches[plan] = problem.map_digest, search
    return kept[1]


PLANNER = Relaxation()
