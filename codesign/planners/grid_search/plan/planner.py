"""Grid search as a ``Planner``.

The plan is one search that serves the first start of the problem. Its time is the time of an architecture style. A
robot at another cell plans anew, so quality and trajectories come from one search for each start. For task ``field``
A* runs without a start until its heap is empty.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.models import Task, TaskParameters
from codesign.maps.reach import reachable
from codesign.planners.grid_search.plan.parameters import Method, SearchParameters
from codesign.planners.grid_search.plan.search import Cell, GridPlan, search
from codesign.planners.interface import (
    LoadParameters,
    Planner,
    Problem,
    Quality,
    cell_of,
    from_position,
    judge_arrival,
    judge_paths,
)
from codesign.planners.job import Flow, Job

CELL_BITS = 2
"""A cell of the map on its way to the planner: free, obstacle or goal."""

STEP_BITS, POINT_BITS = 3, 64
"""One of eight steps; a point of a path at any angle, row and column."""


def plan_search(problem: Problem, parameters: SearchParameters) -> GridPlan:
    """The search of a problem from its first start; for task ``field`` over the whole map.

    Raises:
        InputError: the problem has no start.
    """
    if problem.task is Task.FIELD:
        return search(problem.free, None, problem.goals, parameters)
    if not problem.starts:
        raise InputError("no start is given", "starts", "name the cell where the robot stands")
    return search(problem.free, problem.starts[0], problem.goals, parameters)


def searched(job: Job[Problem, SearchParameters]) -> GridPlan:
    """The search of a job, shared through its memo."""
    problem, parameters = job.problem, job.parameters
    rule = parameters.method, parameters.heuristic, parameters.corner_cutting
    key = ("grid search", problem.map_digest, problem.starts[:1], problem.task is Task.FIELD, rule)
    return job.shared(key, lambda: plan_search(problem, parameters))


class GridSearch(Planner):
    """Grid search: tasks ``load`` and ``search``, whose answer is the whole path."""

    name = "grid_search"
    planning_task = "search"
    answers_no_way = True
    fields_a_stage = 0
    description = "A*, jump points, theta* and Nav2's NavFn, as robots run them on their processors"

    @property
    def tasks(self) -> Mapping[str, type[TaskParameters]]:
        """The tasks of a mapping, with their parameter models."""
        return {"load": LoadParameters, "search": SearchParameters}

    def check(self, job: Job[Problem, SearchParameters]) -> tuple[str, str] | None:
        """A search needs a start; only A* fills a field."""
        problem, method = job.problem, job.parameters.method
        if problem.task is Task.FIELD and method is not Method.ASTAR:
            return "method", f"method {method} plans for one start, and task field is for all: take astar, or task path"
        return None if problem.starts else ("starts", "no start is given")

    def check_drive(self, job: Job[Problem, SearchParameters]) -> tuple[str, str, str] | None:
        """A robot cannot drive along a path between two obstacles that touch at a corner."""
        if not job.parameters.cuts:
            return None
        text = "a path that cuts corners may lead between two obstacles, where no robot can drive"
        return "corner_cutting", text, "set corner_cutting: false"

    def task_text(self, task: Task) -> str:
        """Each start is a search of its own; a field is a search from the goals."""
        if task is Task.FIELD:
            return "one search from the goals until the heap is empty leaves a way in every cell; method astar"
        after = " on the changed map" if task is Task.REPLAN else ""
        return f"each start is a search of its own{after}, between the start and the nearest goal"

    def plans_for_start(self, job: Job[Problem, SearchParameters]) -> bool:
        """A search serves one start, but for a field."""
        return job.problem.task is not Task.FIELD

    def reachable(self, job: Job[Problem, SearchParameters]) -> NDArray[np.bool_]:
        """A search that cuts corners passes between two obstacles that touch at a corner."""
        return reachable(job.problem.free, job.problem.goals, corner_cutting=job.parameters.cuts)

    def plan(self, job: Job[Problem, SearchParameters]) -> GridPlan:
        """Search without a clock. Raises InputError where the problem has no start."""
        return plan_search(job.problem, job.parameters)

    def flows(self, job: Job[Problem, SearchParameters]) -> tuple[Flow, ...]:
        """The map, two bits a cell; the path, three bits a step, or 64 a point of a path at any angle.

        Raises:
            InputError: the problem has no start.
        """
        points = len(searched(job).path)
        bits = STEP_BITS * (points - 1) if job.parameters.exact else POINT_BITS * points
        return (
            Flow("load", "search", "map", CELL_BITS * job.problem.free.size),
            Flow("search", "command", "path", max(STEP_BITS, bits)),
        )

    def memory(self, job: Job[Problem, SearchParameters]) -> int:
        """Measured: 63 to 86 bytes a cell on maps of 2^20 and 2^22 cells (arrays, distances, reach)."""
        return 86 * job.problem.free.size

    def quality(self, problem: Problem, plan: GridPlan) -> Quality:
        """The quality of the plan, and of a search from each start of the problem.

        The plan covers the cells from which it knows the way: those whose length is settled, and of navfn those of its
        path. Each of them leads to a goal, so ``local_maxima`` and ``wrong_cells`` are 0.
        """
        followed = ((start, *self.trajectory(problem, plan, start)) for start in problem.starts)
        paths = ((start, points if arrived else None) for start, points, arrived in followed)
        cells = reachable(problem.free, problem.goals, corner_cutting=plan.parameters.cuts)
        cells[tuple(np.array(problem.goals).T)] = False
        planned = int((cells & plan.covered).sum())
        return Quality(
            local_maxima=0,
            wrong_cells=0,
            **judge_arrival(planned, planned, int(cells.sum())),
            **judge_paths(problem, paths),
        )

    def identity(self, plan: GridPlan) -> str:
        """The digest of the search, its path, and the lengths that it settled, on its map."""
        parameters = plan.parameters
        text = f"{parameters.method}{parameters.heuristic}{parameters.corner_cutting}{plan.shape}{plan.start}"
        counts = f"{plan.expanded} {plan.entries} {plan.looked}"
        digest = hashlib.sha256(f"{text} {counts}".encode())
        for array in (plan.path, plan.states, plan.lengths[plan.settled]):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def figures(self, plan: GridPlan) -> dict[str, Any]:
        """Figures of the search."""
        method = plan.parameters.method
        details: dict[str, Any] = {
            "method": str(method),
            "answer": "lengths" if plan.start is None else "path" if plan.reached else "no solution",
            "updated_cells" if method is Method.NAVFN else "expanded_cells": plan.expanded,
        }
        if method is not Method.NAVFN:
            details["heap_entries"] = plan.entries
        if method in {Method.JUMP_POINT, Method.THETA_STAR}:
            details["looked_at_cells"] = plan.looked
        if method is Method.NAVFN:
            details["path_along"] = "gradient" if plan.smooth else "cells"
        if plan.start is not None:
            details["path_length_cells"] = "no way" if plan.length is None else plan.length
        return {"details": details}

    def trajectory(self, problem: Problem, plan: GridPlan, start: Cell) -> tuple[NDArray[np.float64], bool]:
        """The path from ``start``: of the plan, or of a search from there."""
        known = plan.start in {None, start}
        points = (plan if known else search(problem.free, start, problem.goals, plan.parameters)).path_of(start)
        return (points, True) if len(points) else (np.array([start], np.float64), False)

    def field_of(self, plan: GridPlan) -> tuple[str, str, NDArray[np.float64]]:
        """The length from each settled cell; of navfn its potential from the start, 50 a cell."""
        potential = plan.parameters.method is Method.NAVFN
        return ("potential", "1", plan.field) if potential else ("distance", "cells", plan.field)

    def path_from(
        self, problem: Problem, plan: GridPlan, start: tuple[float, float]
    ) -> tuple[NDArray[np.float64], bool]:
        """The path from a position in a settled cell, and of navfn from the cell of the start.

        Steps from cell to cell leave the middle of the first cell out; a path at any angle begins with it.
        """
        cell = cell_of(problem, start)
        points = np.zeros((0, 2)) if cell is None else plan.path_of(cell)
        if not len(points):
            return np.array([start], np.float64), False
        if plan.parameters.exact:
            return from_position(start, points.astype(np.int64), problem.free), True
        here = np.array([start], np.float64)
        return (points if np.array_equal(here[0], points[0]) else np.concatenate([here, points])), True


PLANNER = GridSearch()
