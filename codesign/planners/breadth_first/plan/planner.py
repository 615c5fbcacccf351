"""Breadth-first search as a ``Planner``.

The plan is one search, from the first start of the problem to the nearest goal. The time of an architecture style is
the time of this search. A robot at another cell plans anew, so quality and trajectories come from one search for each
start. For task ``field`` the plan is the search from the goal until the queue is empty.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.late import late
from codesign.ground.models import Task, TaskParameters
from codesign.planners.breadth_first.plan.parameters import SearchParameters, TrackParameters
from codesign.planners.breadth_first.plan.search import (
    NEIGHBOURS,
    UNKNOWN,
    BreadthFirstPlan,
    Cell,
    search_everywhere,
    search_nearest,
)
from codesign.planners.interface import (
    LoadParameters,
    Path,
    Planner,
    Problem,
    Quality,
    by_sides,
    cell_of,
    from_position,
    judge_search,
)
from codesign.planners.job import Flow, Job

kernels = late("codesign.planners.breadth_first.plan.kernels")

NO_START = "no start is given"

CELL_BITS = 2
"""A cell of the map on its way to the planner: free, obstacle, start or goal."""

DIRECTION_BITS = STEP_BITS = 2
"""A side of a cell: the side of its discoverer, or the side of the next step."""


def plan_search(problem: Problem) -> BreadthFirstPlan:
    """The search from the first start of a problem; for task ``field`` that from its goal to every cell.

    Raises:
        InputError: the problem has no start.
    """
    if problem.task is Task.FIELD:
        return search_everywhere(problem.free, problem.goals[0])
    if not problem.starts:
        raise InputError(NO_START, "starts", "name the cell where the robot stands")
    return search_nearest(problem.free, problem.starts[0], problem.goals)


def searched(job: Job[Problem, SearchParameters]) -> BreadthFirstPlan:
    """The search of a problem, shared through the memo of the job."""
    problem = job.problem
    key = ("breadth-first search", problem.map_digest, problem.starts[:1], problem.task is Task.FIELD)
    return job.shared(key, lambda: plan_search(problem))


class BreadthFirst(Planner):
    """Breadth-first search: tasks ``load``, ``search`` and ``track``, which marks the path (state Path)."""

    name = "breadth_first"
    planning_task = "search"
    tasks: Mapping[str, type[TaskParameters]] = {
        "load": LoadParameters,
        "search": SearchParameters,
        "track": TrackParameters,
    }
    answers_no_way = True
    fields_a_stage = 0
    description = "the shortest 4-connected path by breadth-first search (Vacariu et al. 2008)"

    def check(self, job: Job[Problem, SearchParameters]) -> tuple[str, str] | None:
        """A search begins at a start, so one is required; the search of a field begins at its only goal."""
        problem = job.problem
        if problem.task is Task.FIELD and len(problem.goals) > 1:
            text = f"task field is one search that begins at the goal, and there are {len(problem.goals)} goals"
            return "goals", f"{text}: name one, or take task path"
        return None if problem.starts else ("starts", NO_START)

    def task_text(self, task: Task) -> str:
        """Each start is a search of its own; a field is the search from the goal."""
        if task is Task.FIELD:
            return "one search from the goal until the queue is empty leaves a direction in every cell"
        after = " on the changed map" if task is Task.REPLAN else ""
        return f"each start is a search of its own{after}, from the start to the nearest goal"

    def plans_for_start(self, job: Job[Problem, SearchParameters]) -> bool:
        """A search begins at the start, but for a field."""
        return job.problem.task is not Task.FIELD

    def reachable(self, job: Job[Problem, SearchParameters]) -> NDArray[np.bool_]:
        """The search looks at the four neighbours of a cell."""
        return by_sides(job.problem)

    def plan(self, job: Job[Problem, SearchParameters]) -> BreadthFirstPlan:
        """Search without a clock. Raises InputError where the problem has no start."""
        return plan_search(job.problem)

    def flows(self, job: Job[Problem, SearchParameters]) -> tuple[Flow, ...]:
        """The map and the directions of discovery, two bits a cell; the path, two bits a step.

        Raises:
            InputError: the problem has no start.
        """
        problem = job.problem
        cells, steps = problem.free.size, searched(job).path_steps or 0
        return (
            Flow("load", "search", "map", CELL_BITS * cells),
            Flow("search", "track", "directions", DIRECTION_BITS * cells),
            Flow("track", "command", "path", max(STEP_BITS, STEP_BITS * steps)),
        )

    def memory(self, job: Job[Problem, SearchParameters]) -> int:
        """Measured: 52 bytes a cell on maps of 2^20 to 2^24 cells (map, directions, pushed cells, distances)."""
        return 52 * job.problem.free.size

    def quality(self, problem: Problem, plan: BreadthFirstPlan) -> Quality:
        """The quality of the plan, and of a search from each start of the problem.

        The plan covers the cells that its search reached before it ended. From each of them the directions lead back
        to the path, so ``local_maxima`` and ``wrong_cells`` are 0. A search that finds no goal covers no cell. Each
        start is judged by a search of its own, or by the directions of a search everywhere.
        """
        followed = ((start, self.trajectory(problem, plan, start)) for start in problem.starts)
        return judge_search(problem, by_sides(problem), np.unravel_index(plan.pushed, problem.shape), followed)

    def identity(self, plan: BreadthFirstPlan) -> str:
        """The digest of the reached cells, their directions, and the path."""
        digest = hashlib.sha256(f"{plan.directions.shape}{plan.start}{plan.goal}".encode())
        for array in (plan.directions, plan.pushed, plan.path):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def figures(self, plan: BreadthFirstPlan) -> dict[str, Any]:
        """Figures of the search."""
        return {
            "details": {
                "answer": "directions" if plan.everywhere else "path" if plan.reached else "no solution",
                "popped_cells": plan.popped_cells,
                "pushed_cells": plan.pushed_cells,
                "spreading_cells": plan.spreading,
                "path_steps": "no way" if plan.path_steps is None else plan.path_steps,
                "queue_depth_cells": plan.queue_depth,
            }
        }

    def trajectory(self, problem: Problem, plan: BreadthFirstPlan, start: Cell) -> Path:
        """The path from ``start``, cell by cell: of the plan, of a search from there, or along the directions."""
        if plan.everywhere:
            back = _back_to_path(plan, start)
            points = np.array([start]) if back is None else back
            return points.astype(np.float64), back is not None
        search_plan = plan if start == plan.start else search_nearest(problem.free, start, problem.goals)
        points = search_plan.path if search_plan.reached else np.array([start])
        return points.astype(np.float64), search_plan.reached

    def field_of(self, plan: BreadthFirstPlan) -> tuple[str, str, NDArray[np.float64]]:
        """Steps from the begin of the search to each cell that it reached; infinite elsewhere."""
        return "distance", "steps", distances(plan)

    def path_from(self, problem: Problem, plan: BreadthFirstPlan, start: tuple[float, float]) -> Path:
        """The rest of the path from a position on one of its cells.

        From another cell, the path goes back along the directions of discovery until they meet the path of the plan, at
        its start at the latest. There is no path from a cell that the search did not reach.
        """
        cell = cell_of(problem, start)
        back = None if cell is None or not plan.reached else _back_to_path(plan, cell)
        if back is None:
            return np.array([start], np.float64), False
        return from_position(start, back, problem.free), True


def distances(plan: BreadthFirstPlan) -> NDArray[np.float64]:
    """Float64, rows × columns: steps from the start, along the directions of discovery; infinite for others."""
    steps: NDArray[np.float64] = kernels.steps(plan.pushed, plan.directions)
    return steps


def _back_to_path(plan: BreadthFirstPlan, cell: Cell) -> NDArray[np.int32] | None:
    """The cells from ``cell`` to the path, then the rest of the path; None where the search did not reach ``cell``."""
    place = {(int(row), int(column)): index for index, (row, column) in enumerate(plan.path)}
    cells = []
    while cell not in place:
        side = int(plan.directions[cell])
        if side == UNKNOWN:
            return None
        cells.append(cell)
        down, right = NEIGHBOURS[side]
        cell = cell[0] + down, cell[1] + right
    return np.concatenate([np.array(cells, np.int32).reshape(-1, 2), plan.path[place[cell] :]])


PLANNER = BreadthFirst()
