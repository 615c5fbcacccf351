"""Breadth-first search as a plug-in: what ``codesign.planners.interface.Planner`` asks for.

The plan is one search, from the first start of the problem to the nearest goal: that is what an architecture style is
timed on. A robot elsewhere plans anew, so quality and trajectories are those of one search a start.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import InputError
from codesign.models import TaskParameters
from codesign.planners.breadth_first.plan.parameters import SearchParameters, TrackParameters
from codesign.planners.breadth_first.plan.reference import NEIGHBOURS, UNKNOWN, Cell
from codesign.planners.breadth_first.plan.search import BreadthFirstPlan, search_nearest
from codesign.planners.interface import LoadParameters, Planner, Problem, Quality
from codesign.planners.job import Job
from codesign.planners.paths import by_sides, cell_of, from_position, judge_arrival, judge_paths
from codesign.planners.task_graph import Flow

NO_START = "no start is given"

CELL_BITS = 2
"""A cell of the map on its way to the planner: free, obstacle, start or goal."""

DIRECTION_BITS = STEP_BITS = 2
"""A side of a cell: on which the one that discovered it lies, or to which a step goes."""


def plan_search(problem: Problem) -> BreadthFirstPlan:
    """The search that a problem asks for: from its first start.

    Raises:
        InputError: the problem has no start.
    """
    if not problem.starts:
        raise InputError(NO_START, "starts", "name the cell where the robot stands")
    return search_nearest(problem.free, problem.starts[0], problem.goals)


class BreadthFirst(Planner):
    """Breadth-first search: tasks ``load``, ``search`` and ``track``, which marks the path (state Path)."""

    name = "breadth_first"
    planning_task = "search"
    answers_no_way = True
    fields_a_stage = 0
    description = "the shortest 4-connected path by breadth-first search (Vacariu et al. 2008)"

    @property
    def tasks(self) -> Mapping[str, type[TaskParameters]]:
        """The tasks of a mapping, with their parameter models."""
        return {"load": LoadParameters, "search": SearchParameters, "track": TrackParameters}

    def check(self, job: Job[Problem, SearchParameters]) -> tuple[str, str] | None:
        """A search begins at a start: there has to be one."""
        return None if job.problem.starts else ("starts", NO_START)

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
        cells, steps = problem.free.size, plan_search(problem).path_steps or 0
        return (
            Flow("load", "search", "map", CELL_BITS * cells),
            Flow("search", "track", "directions", DIRECTION_BITS * cells),
            Flow("track", "command", "path", max(STEP_BITS, STEP_BITS * steps)),
        )

    def memory(self, job: Job[Problem, SearchParameters]) -> int:
        """Measured: 52 bytes a cell on maps of 2^20 to 2^24 cells (map, directions, what was pushed, distances)."""
        return 52 * job.problem.free.size

    def quality(self, problem: Problem, plan: BreadthFirstPlan) -> Quality:
        """What the plan is worth, and a search from each start of the problem.

        The plan covers the cells that its search came to before it ended: each of them has its way back to the path. So
        ``local_maxima`` and ``wrong_cells`` are 0. A search that finds no goal covers none. Starts are judged by a
        search each.
        """
        found = (search_nearest(problem.free, start, problem.goals) for start in problem.starts)
        paths = ((way.start, way.path if way.reached else None) for way in found)
        reachable = by_sides(problem)
        reachable[tuple(np.array(problem.goals).T)] = False
        planned = int(reachable.ravel()[plan.pushed].sum())
        return Quality(
            local_maxima=0,
            wrong_cells=0,
            **judge_arrival(planned, planned, int(reachable.sum())),
            **judge_paths(problem, paths),
        )

    def identity(self, plan: BreadthFirstPlan) -> str:
        """The digest of where the search came, how it came there, and the path."""
        digest = hashlib.sha256(f"{plan.directions.shape}{plan.start}{plan.goal}".encode())
        for array in (plan.directions, plan.pushed, plan.path):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def figures(self, plan: BreadthFirstPlan) -> dict[str, Any]:
        """What a reader wants to know of the search."""
        return {
            "details": {
                "answer": "path" if plan.reached else "no solution",
                "popped_cells": plan.popped_cells,
                "pushed_cells": plan.pushed_cells,
                "spreading_cells": plan.spreading,
                "path_steps": "no way" if plan.path_steps is None else plan.path_steps,
                "queue_depth_cells": plan.queue_depth,
            }
        }

    def trajectory(
        self, problem: Problem, plan: BreadthFirstPlan, start: Cell
    ) -> tuple[NDArray[np.float64], bool]:
        """The path from ``start``, cell by cell: that of the plan, or of a search from there."""
        way = plan if start == plan.start else search_nearest(problem.free, start, problem.goals)
        points = way.path if way.reached else np.array([start])
        return points.astype(np.float64), way.reached

    def field_of(self, plan: BreadthFirstPlan) -> tuple[str, str, NDArray[np.float64]]:
        """Steps from the start to each cell that the search came to; infinite elsewhere."""
        return "distance", "steps", distances(plan)

    def path_from(
        self, problem: Problem, plan: BreadthFirstPlan, start: tuple[float, float]
    ) -> tuple[NDArray[np.float64], bool]:
        """The rest of the path from a position on one of its cells.

        From beside the path, back along the directions of discovery to where they meet it: at its start, at the latest.
        Where the search did not come, no path is known.
        """
        cell = cell_of(problem, start)
        back = None if cell is None or not plan.reached else _back_to_path(plan, cell)
        if back is None:
            return np.array([start], np.float64), False
        return from_position(start, back, problem.free), True


def distances(plan: BreadthFirstPlan) -> NDArray[np.float64]:
    """Float64, rows × columns: steps from the start back along the directions of discovery; infinite for others."""
    steps = np.full(plan.directions.shape, np.inf)
    columns = plan.directions.shape[1]
    offsets = np.array([down * columns + right for down, right in NEIGHBOURS], np.int64)
    found = plan.pushed.astype(np.int64)
    rank = np.zeros(steps.size, np.int64)
    rank[found] = np.arange(len(found))
    # Every cell points at the one that found it, the start at itself; then at that one's target, and so on.
    target = np.zeros(len(found), np.int64)
    target[1:] = rank[found[1:] + offsets[plan.directions.ravel()[found[1:]]]]
    count = (np.arange(len(found)) > 0).astype(np.int64)
    while target.any():
        count, target = count + count[target], target[target]
    steps.ravel()[found] = count
    return steps


def _back_to_path(plan: BreadthFirstPlan, cell: Cell) -> NDArray[np.int32] | None:
    """The cells from ``cell`` to the path, and those of the path from there on; None where the search did not come."""
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
