"""Relaxation as a plug-in, the descent over its potential (section V), and the quality of both."""

from __future__ import annotations

import hashlib
import math
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, outside_map
from codesign.ground.models import TaskParameters
from codesign.maps.reach import check_cells, led_to, reachable
from codesign.planners.interface import (
    Cell,
    LoadParameters,
    Path,
    Planner,
    Policy,
    Problem,
    Quality,
    by_sides,
    cell_of,
    from_position,
    judge_arrival,
    judge_paths,
)
from codesign.planners.job import Flow, Job
from codesign.planners.relaxation.plan.parameters import (
    DEFAULT_METHOD,
    Boundary,
    Method,
    RelaxParameters,
    SearchParameters,
)
from codesign.planners.relaxation.plan.solve import End, Solution, refusal, solve

STEPS = ((-1, 0), (0, 1), (1, 0), (0, -1), (-1, 1), (1, 1), (1, -1), (-1, -1))
"""North, east, south, west, then the diagonals. The first of equal neighbours in this order is taken."""


class Ending(StrEnum):
    """The end of a descent: at a goal; where no neighbour is lower; or at its start, as no path joins it to a goal."""

    GOAL = "goal"
    FLAT = "flat"
    UNREACHABLE = "unreachable"


@dataclass(frozen=True, eq=False)
class Descent:
    """A path from a start.

    ``cells``: int64 n × 2, (row, column), start first. ``ending``: the reason of its end. ``length``: in cells, √2 for
    a diagonal step.
    """

    cells: NDArray[np.int64]
    ending: Ending

    @property
    def arrived(self) -> bool:
        """True if it ends at a goal."""
        return self.ending is Ending.GOAL

    @property
    def length(self) -> float:
        """Length in cells."""
        return float(np.sqrt((np.diff(self.cells, axis=0) ** 2).sum(axis=1)).sum())


class Search:
    """A potential prepared for descents: the lowest neighbour of every cell, computed once.

    A step never enters an obstacle, and never cuts a corner: a diagonal step needs both cells beside it free. Values
    fall strictly along a path, so it enters no cell twice and ends.

    Args:
        potential: float64, rows × columns. free: bool of that shape. goals: (row, column) pairs on free cells.
        neighbours: 8, or 4 for steps along rows and columns only. The paper does not say which it takes.
        upwards: look for the highest instead (``Boundary.HIGH_GOAL``).

    Raises:
        MapError: the map or a goal cannot be used. InputError: another argument cannot be used.
    """

    def __init__(
        self,
        potential: NDArray[np.float64],
        free: NDArray[np.bool_],
        goals: Sequence[tuple[int, int]],
        *,
        neighbours: int = 8,
        upwards: bool = False,
    ) -> None:
        cells = check_cells(free, goals)
        if potential.shape != free.shape or potential.dtype != np.float64:
            what = f"a potential of {potential.dtype} {potential.shape} for a map of {free.shape}"
            raise InputError(what, "potential", "give what solve returned for this map")
        if neighbours not in {4, 8}:
            raise InputError(f"{neighbours!r} neighbours", "neighbours", "give 4 or 8")
        self.free = free
        self.goal = np.zeros(free.shape, np.bool_)
        self.goal[cells[:, 0], cells[:, 1]] = True
        self.reachable = reachable(free, goals)
        self.best = _lowest(-potential if upwards else potential, free, neighbours)

    def follow(self, start: tuple[int, int]) -> Descent:
        """The path from ``start``. Raises InputError if ``start`` is no free cell of the map."""
        row, column = self._check_start(start)
        if not self.reachable[row, column]:
            return Descent(np.array([(row, column)], np.int64), Ending.UNREACHABLE)
        cells = [(row, column)]
        while not self.goal[row, column] and self.best[row, column] >= 0:
            down, right = STEPS[self.best[row, column]]
            row, column = row + down, column + right
            cells.append((row, column))
        ending = Ending.GOAL if self.goal[row, column] else Ending.FLAT
        return Descent(np.array(cells, np.int64), ending)

    def flat(self) -> NDArray[np.bool_]:
        """Bool rows × columns: reachable cells, goals left out, with no lower neighbour."""
        return np.asarray(self.reachable & ~self.goal & (self.best < 0))

    def arriving(self) -> NDArray[np.bool_]:
        """Bool rows × columns: reachable cells with a path that ends at a goal (goals included)."""
        return led_to(self.best, STEPS, self.goal) & self.reachable

    def _check_start(self, start: tuple[int, int]) -> tuple[int, int]:
        try:
            row, column = (operator.index(value) for value in start)
        except (TypeError, ValueError):
            raise InputError(f"start {start!r:.80} is not a cell", "start", "give (row, column)") from None
        rows, columns = self.free.shape
        if not (0 <= row < rows and 0 <= column < columns):
            what, hint = outside_map((row, column), self.free.shape, "start")
            raise InputError(what, "start", hint)
        if not self.free[row, column]:
            raise InputError(f"start ({row}, {column}) is on an obstacle", "start", "move it to a free cell")
        return row, column


def descend(
    potential: NDArray[np.float64],
    free: NDArray[np.bool_],
    goals: Sequence[tuple[int, int]],
    start: tuple[int, int],
    *,
    neighbours: int = 8,
    upwards: bool = False,
) -> Descent:
    """One path down a potential; ``Search`` serves for several."""
    return Search(potential, free, goals, neighbours=neighbours, upwards=upwards).follow(start)


def _lowest(potential: NDArray[np.float64], free: NDArray[np.bool_], neighbours: int) -> NDArray[np.int8]:
    """Int8 rows × columns: index into ``STEPS`` of the lowest strictly lower neighbour, -1 where there is none."""
    open_cells = np.pad(free, 1)
    values = np.full(open_cells.shape, math.inf)
    values[1:-1, 1:-1][free] = potential[free]
    lowest = np.where(free, potential, -math.inf)
    best = np.full(free.shape, -1, np.int8)
    for index, (down, right) in enumerate(STEPS[:neighbours]):
        there = _shifted(values, down, right)
        lower = there < lowest
        if down and right:
            lower &= _shifted(open_cells, down, 0) & _shifted(open_cells, 0, right)
        best[lower] = index
        lowest[lower] = there[lower]
    return best


def _shifted(padded: NDArray[Any], down: int, right: int) -> NDArray[Any]:
    rows, columns = padded.shape
    return padded[1 + down : rows - 1 + down, 1 + right : columns - 1 + right]


MOST_TRIED = 1 << 17
"""Cells of the largest map on which a warning tries its proposals: a fraction of a second."""

LEAST_NORMAL = float(np.finfo(np.float64).tiny)
"""Below it doubles lose digits, 1e-308, and below 5e-324 they are 0."""

ANOTHER_PLANNER = "take planner harmonic with more bits, or wavefront"


def quality(problem: Problem, search: Search, solution: Solution) -> Quality:
    """The quality of following ``search`` over the potential of ``solution`` on ``problem``.

    ``local_maxima`` counts the cells from which no step leads on: flat areas, where neighbouring doubles are equal;
    cells that the run did not reach before its end; and cells where its errors are larger than the slope. ``warnings``
    has a sentence where cells lead nowhere, whether or not the run converged. ``wrong_cells`` does not apply: doubles
    settle at no exact value.

    Raises:
        InputError: a start is not in a free cell.
    """
    cells = search.reachable & ~search.goal
    lost = cells & ~search.arriving()
    count = int(cells.sum())
    descents = ((start, search.follow(start)) for start in problem.starts)
    paths = ((start, descent.cells if descent.arrived else None) for start, descent in descents)
    return Quality(
        local_maxima=int(search.flat().sum()),
        wrong_cells=None,
        warnings=(_warning(problem, solution, lost, count),) if lost.any() else (),
        **judge_arrival(count - int(lost.sum()), count),
        **judge_paths(problem, paths),
    )


def _warning(problem: Problem, solution: Solution, lost: NDArray[np.bool_], count: int) -> str:
    """The number of cells that lead nowhere, the cause, and the remedy."""
    nowhere = int(lost.sum())
    tenths = 1000 * nowhere // count
    share = f"{tenths / 10:g} %" if tenths else "under 0.1 %"
    cause, advice = _cause(solution, lost)
    begun = {End.CONVERGED: "converged, but ", End.STAGNATED: "stagnated: "}.get(solution.ended, "")
    return f"{begun}{nowhere:,} of {count:,} cells ({share}) lead nowhere: {cause}; {advice or _mend(problem)}"


def _cause(solution: Solution, lost: NDArray[np.bool_]) -> tuple[str, str]:
    """The cause why cells lead nowhere, and the remedy; "" where the defaults may be the remedy."""
    if solution.ended is End.LIMIT:
        return "the run met its bound on iterations", "raise max_iterations"
    if solution.method is Method.HALF_SWEEP_AM:
        return "half sweeps see a passage one cell wide as closed, and errors may exceed the slope", ""
    if solution.boundary is Boundary.HIGH_WALLS:
        return "next to 1 doubles lie 1e-16 apart, and far cells differ by less", ""
    if max(solution.omega or 1.0, solution.r or 1.0) > 1.0:
        shown = "" if solution.r is None else f", r = {solution.r:g}"
        cause = f"over-relaxation (ω = {solution.omega:g}{shown}) leaves errors larger than the potential of far rooms"
        return cause, ""
    return _cause_without_over_relaxation(solution, lost)


def _cause_without_over_relaxation(solution: Solution, lost: NDArray[np.bool_]) -> tuple[str, str]:
    wall, _ = solution.boundary.values
    depth = float(np.abs(solution.potential[lost] - wall).min())
    by_tolerance = solution.method is not Method.DIRECT and solution.checks == 0
    if by_tolerance and depth == 0.0:
        return "the run ended before values came to far cells", ""
    if depth < LEAST_NORMAL:
        return "far potentials are below the least double of full precision", ""
    return "neighbouring doubles are equal, or differ by less than the error", ""


def _mend(problem: Problem) -> str:
    """The remedy: the defaults, else the direct solver, else another planner; tried on this map if it is small."""
    defaults = "leave method, omega, r, tolerance and boundary out"
    if problem.free.size > MOST_TRIED:
        return f"{defaults}, or {ANOTHER_PLANNER}"
    for method, advice in (
        (DEFAULT_METHOD, defaults),
        (Method.DIRECT, "take method direct, and leave omega, r, tolerance and boundary out"),
    ):
        tried = solve(problem.free, problem.goals, method=method)
        search = Search(tried.potential, problem.free, problem.goals)
        if not (search.reachable & ~search.arriving()).any():
            return f"{advice}: then every cell of this map leads to a goal"
    return f"{ANOTHER_PLANNER}: on this map neither the defaults nor method direct lead from every cell"


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
    tasks: Mapping[str, type[TaskParameters]] = {
        "load": LoadParameters,
        "relax": RelaxParameters,
        "search": SearchParameters,
    }
    policies: tuple[Policy, ...] = ("restart", "continue")
    description = "Laplace's equation relaxed in doubles on a host (Saudi and Sulaiman 2016)"

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

    def trajectory(self, problem: Problem, plan: Plan, start: Cell) -> Path:
        """The path of the gradient descent search from ``start``."""
        descent = search_of(problem, plan).follow(start)
        return descent.cells.astype(np.float64), descent.arrived

    def start_of(self, plan: Plan) -> NDArray[np.float64]:
        """The potential, rows × columns."""
        return plan.solution.potential

    def path_from(self, problem: Problem, plan: Plan, start: tuple[float, float]) -> Path:
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
