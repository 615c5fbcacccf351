"""Grid search as a ``Planner``.

The plan is one search that serves the first start of the problem. Its time is the time of an architecture style. A
robot at another cell plans anew, so quality and trajectories come from one search for each start. For task ``field``
A* runs without a start until its heap is empty.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.late import late
from codesign.ground.models import Task, TaskParameters
from codesign.maps.grid import as_free
from codesign.maps.reach import check_cells, reachable
from codesign.planners.grid_search.plan.parameters import (
    ANY,
    CLOSED,
    EUCLIDEAN,
    NONE,
    OCTILE,
    STEPS,
    STRAIGHT,
    Heuristic,
    Method,
    SearchParameters,
)
from codesign.planners.interface import (
    Cell,
    LoadParameters,
    Path,
    Planner,
    Problem,
    Quality,
    cell_of,
    corner_cut,
    from_position,
    judge_search,
)
from codesign.planners.job import Flow, Job

kernels = late("codesign.planners.grid_search.plan.kernels")
navfn = late("codesign.planners.grid_search.plan.navfn")

RULES = {Heuristic.OCTILE: OCTILE, Heuristic.EUCLIDEAN: EUCLIDEAN, Heuristic.NONE: NONE}


@cache
def successors(cutting: bool) -> NDArray[np.uint8]:
    """The neighbours that a search looks at: uint8, 9 × 256 masks by side of arrival and mask of free neighbours.

    Harabor and Grastien (2011): a neighbour is left out where a path from the cell before, around this one, is
    shorter, or as long with its diagonal step first. ``cutting``: a diagonal step needs only its end to be free,
    otherwise both cells beside it too.
    """
    table = np.zeros((9, 256), np.uint8)
    for side in range(9):
        for mask in range(256):
            free = {step for bit, step in enumerate(STEPS) if mask >> bit & 1}
            chosen = _natural(side, free, cutting) & {step for step in free if cutting or sides(step) <= free}
            table[side, mask] = sum(1 << bit for bit, step in enumerate(STEPS) if step in chosen)
    return table


def sides(step: tuple[int, int]) -> set[tuple[int, int]]:
    """The two cells beside a diagonal step; none of a straight one."""
    return {(step[0], 0), (0, step[1])} if step[0] and step[1] else set()


def _natural(side: int, free: set[tuple[int, int]], cutting: bool) -> set[tuple[int, int]]:
    """The steps on from an arrival by ``side``: straight on, and those that an obstacle forces."""
    if side == ANY:
        return set(STEPS)
    down, right = STEPS[side]
    if down and right:
        chosen = {(down, right), (down, 0), (0, right)}
        if cutting:
            chosen |= {(-down, right)} if (-down, 0) not in free else set()
            chosen |= {(down, -right)} if (0, -right) not in free else set()
        return chosen
    chosen = {(down, right)}
    for aside in ((right, down), (-right, -down)):
        beyond = down + aside[0], right + aside[1]
        if cutting:
            chosen |= {beyond} if aside not in free else set()
        elif (aside[0] - down, aside[1] - right) not in free:
            chosen |= {aside, beyond}
    return chosen


@dataclass(frozen=True, eq=False)
class GridPlan:
    """The outcome of a search.

    Attributes:
        parameters: the parameters of the search.
        start: the first cell; None where the search ran over the whole map.
        path: float64 n × 2, (row, column) from the start to a goal: cells next to each other, points of a line no
            farther apart than a cell (theta_star), or half a cell apart (navfn). 0 × 2 where there is no way.
        expanded: cells taken from the heap and looked around; of navfn updates of a cell.
        entries: entries of the heap.
        looked: cells that jumps and lines of sight looked at.
        lengths: of each cell of the map with its ring, flat: int64 in units of ``STRAIGHT``, float64 in
            cells (theta_star), or the potential in float32 (navfn). Valid where ``settled``.
        before: int32, of each such cell the next one on the way to a goal; empty of navfn.
        states: uint8, of each such cell, as ``kernels`` has it: closed where the search has its length. Of navfn
            the map alone.
        shape: rows and columns of the map.
        smooth: True if the path follows the gradient of navfn between cells.
    """

    parameters: SearchParameters
    start: Cell | None
    path: NDArray[np.float64]
    expanded: int
    entries: int
    looked: int
    lengths: NDArray[np.generic]
    before: NDArray[np.int32]
    states: NDArray[np.uint8]
    shape: Cell
    smooth: bool = False

    @property
    def reached(self) -> bool:
        """True if there is a path."""
        return len(self.path) > 0

    @property
    def stride(self) -> int:
        """Cells of a row of the map with its ring."""
        return self.shape[1] + 2

    @cached_property
    def settled(self) -> NDArray[np.bool_]:
        """Bool, of each cell of the map with its ring: the search has its length."""
        if self.parameters.method is Method.NAVFN:
            return np.asarray(self.lengths < navfn.HIGH)
        return np.asarray(self.states == CLOSED)

    @cached_property
    def length(self) -> float | None:
        """The length of the path, cells; None without one."""
        return float(np.hypot(*np.diff(self.path, axis=0).T).sum()) if self.reached else None

    @property
    def field(self) -> NDArray[np.float64]:
        """Float64, rows × columns: the length from each settled cell, cells; infinite elsewhere.

        Of navfn the potential, 50 a cell, from the start.
        """
        unit = STRAIGHT if self.parameters.exact else 1
        values = np.full(self.lengths.size, np.inf)
        np.divide(self.lengths, unit, out=values, where=self.settled)
        return values.reshape(-1, self.stride)[1:-1, 1:-1]

    @property
    def covered(self) -> NDArray[np.bool_]:
        """Bool, rows × columns: the cells from which the plan knows a way."""
        if self.parameters.method is not Method.NAVFN:
            return self.settled.reshape(-1, self.stride)[1:-1, 1:-1]
        cells = np.zeros(self.shape, np.bool_)
        cells[tuple(np.floor(self.path + 0.5).astype(np.int64).T)] = True
        return cells

    def path_of(self, cell: Cell) -> NDArray[np.float64]:
        """The path from a cell, as ``path``: 0 × 2 where the plan knows none.

        Of navfn only the path from the start is known, as its potential leads there.
        """
        if cell == self.start:
            return self.path
        return self.path[:0] if self.parameters.method is Method.NAVFN else self.chain(cell)

    def chain(self, cell: Cell) -> NDArray[np.float64]:
        """The path from a cell along ``before``, as ``path``: 0 × 2 where the cell is not settled."""
        at = (cell[0] + 1) * self.stride + cell[1] + 1
        if self.states[at] != CLOSED:
            return np.zeros((0, 2))
        points: NDArray[np.float64] = kernels.way(self.before, at, self.stride, self.parameters.exact)
        return points


def search(
    free: NDArray[np.bool_], start: Cell | None, goals: Sequence[Cell], parameters: SearchParameters | None = None
) -> GridPlan:
    """The path from ``start`` to the nearest of ``goals``.

    Args:
        free: bool, rows × columns; outside of the map is obstacle.
        start: (row, column) of a free cell; None for a search over the whole map, of method astar only.
        goals: (row, column) of free cells.
        parameters: by default A* with the octile heuristic that cuts no corner.

    A goal that cannot be reached is an answer: the path is empty.

    Raises:
        MapError: the map is unusable, or start or goal lies outside of it or on an obstacle.

    >>> free = np.array([[True, True, True], [True, False, True]])
    >>> plan = search(free, (1, 0), [(1, 2)])
    >>> plan.path.tolist(), plan.length
    ([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [1.0, 2.0]], 4.0)
    """
    free = as_free(free, "free")
    parameters = parameters or SearchParameters()
    ends = check_cells(free, goals, where="goal")
    stride = free.shape[1] + 2
    sources = (ends[:, 0] + 1) * stride + ends[:, 1] + 1
    target = -1
    if start is not None:
        ((row, column),) = check_cells(free, [start], name="start", where="start").tolist()
        start, target = (row, column), (row + 1) * stride + column + 1
    cells = kernels.padded(free)
    if parameters.method is Method.NAVFN:
        return _potential(parameters, free, cells, start, target, sources)
    if parameters.method is Method.THETA_STAR:
        end, lengths, before, expanded, entries, looked = kernels.theta_star(cells, stride, sources, target)
    else:
        end, lengths, before, expanded, entries, looked = kernels.astar(
            cells,
            stride,
            sources,
            target,
            RULES[parameters.heuristic],
            successors(parameters.corner_cutting),
            parameters.corner_cutting,
            parameters.method is Method.JUMP_POINT,
        )
    none = np.zeros((0, 2))
    plan = GridPlan(parameters, start, none, expanded, entries, looked, lengths, before, cells, free.shape)
    if end >= 0 and start is not None:
        object.__setattr__(plan, "path", plan.chain(start))
    return plan


def _potential(
    parameters: SearchParameters,
    free: NDArray[np.bool_],
    cells: NDArray[np.uint8],
    start: Cell | None,
    target: int,
    goals: NDArray[np.int64],
) -> GridPlan:
    """The potential of NavFn from ``start`` to the first goal, and the path from there, turned round.

    NavFn counts on inflated obstacles: without them a path between cells may leave the free ones. Such a path is
    replaced by one from cell to cell down the same potential.
    """
    stride = free.shape[1] + 2
    values, updates = navfn.potential(cells, stride, target, goals)
    nearest = int(goals[np.argmin(values[goals])])
    path, smooth = np.zeros((0, 2)), False
    if values[nearest] < navfn.HIGH:
        points = navfn.descend(values, stride, nearest, target, 4 * free.size + 4)
        path = points[::-1].astype(np.float64) - 1.0
        if not (smooth := _keeps_free(free, path)):
            steps = navfn.from_cell_to_cell(values, cells, stride, nearest, target)
            path = np.stack(np.divmod(steps[::-1], stride), axis=1).astype(np.float64) - 1.0
    none = np.zeros(0, np.int32)
    return GridPlan(parameters, start, path, updates, 0, 0, values, none, cells, free.shape, smooth)


def _keeps_free(free: NDArray[np.bool_], path: NDArray[np.float64]) -> bool:
    """True if there is a path, whose points lie a cell apart or less, and it keeps to free cells."""
    if not len(path):
        return False
    shares = np.linspace(0.0, 1.0, 11)[:, None, None]
    dense = (path[:-1] + shares * np.diff(path, axis=0)).reshape(-1, 2)
    cells = np.floor(dense + 0.5).astype(np.int64)
    inside = (cells >= 0).all(axis=1) & (cells < free.shape).all(axis=1)
    return bool(inside.all() and free[cells[:, 0], cells[:, 1]].all())


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
    tasks: Mapping[str, type[TaskParameters]] = {"load": LoadParameters, "search": SearchParameters}
    answers_no_way = True
    fields_a_stage = 0
    description = "A*, jump points, theta* and Nav2's NavFn, as robots run them on their processors"

    def check(self, job: Job[Problem, SearchParameters]) -> tuple[str, str] | None:
        """A search needs a start; only A* fills a field."""
        problem, method = job.problem, job.parameters.method
        if problem.task is Task.FIELD and method is not Method.ASTAR:
            return "method", f"method {method} plans for one start, and task field is for all: take astar, or task path"
        return None if problem.starts else ("starts", "no start is given")

    def check_drive(self, job: Job[Problem, SearchParameters]) -> tuple[str, str, str] | None:
        """A robot cannot drive along a path between two obstacles that touch at a corner."""
        return corner_cut(job.parameters.cuts)

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
        followed = ((start, self.trajectory(problem, plan, start)) for start in problem.starts)
        cells = reachable(problem.free, problem.goals, corner_cutting=plan.parameters.cuts)
        return judge_search(problem, cells, plan.covered, followed)

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

    def trajectory(self, problem: Problem, plan: GridPlan, start: Cell) -> Path:
        """The path from ``start``: of the plan, or of a search from there."""
        known = plan.start in {None, start}
        points = (plan if known else search(problem.free, start, problem.goals, plan.parameters)).path_of(start)
        return (points, True) if len(points) else (np.array([start], np.float64), False)

    def field_of(self, plan: GridPlan) -> tuple[str, str, NDArray[np.float64]]:
        """The length from each settled cell; of navfn its potential from the start, 50 a cell."""
        potential = plan.parameters.method is Method.NAVFN
        return ("potential", "1", plan.field) if potential else ("distance", "cells", plan.field)

    def path_from(self, problem: Problem, plan: GridPlan, start: tuple[float, float]) -> Path:
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
