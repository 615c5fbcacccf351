"""Styles ``sequential`` and ``two_core``: the relaxation on one core of a processor, or on two of them.

A processor has no clock law: a cycle of a step stands for one unit of the kernel ``relaxation_node_update``, or of
``relaxation_direct_cell`` in the direct solution. The platform gives these kernels costs (see below). On two cores
a cycle passes on both, so that cycles are time.

Two cores: levels 1 and 2 of the arithmetic means run side by side, and meet before and after level 3, which one core
computes. The colours of a red-black sweep and the nodes of Jacobi's are halved between the cores. A sweep in raster
order (Gauss-Seidel, SOR), the direct solution and the checks for cells without a descent stay on one core. The
platform's busy power counts once for one core or two: assumed, and too little where that power is a core's share.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, replace
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.figures import Figure, Status
from codesign.ground.records import StageRecord
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.plug_in import Probe
from codesign.planners.relaxation import published
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, Solution, solve
from codesign.planners.relaxation.plan.parameters import Method, RelaxParameters
from codesign.planners.relaxation.plan.planner import PLANNER, Plan, factor_bytes, search_of
from codesign.planners.relaxation.plan.solve import CHECK_EVERY
from codesign.planners.styles import Designs, Family, HostStyle, HostTask, Step, assumed_bytes, map_read, one_step

# The cost of an iteration on a processor, in updates of a node.
#
# The unit, kernel ``relaxation_node_update``, is one cell of the map passed by one sweep, occupied cells included: four
# loads, three additions, a multiplication, a comparison. On the paper's machine it is 16.8 ns: 77.12 s for 51,454
# iterations of Gauss-Seidel over 330 × 270 cells (Table I). The number of free cells is not published.
#
# An iteration of AM took 2.6 times as long (the 9 rows of Table I up to ω = 1.90 agree within 2.3 %). Two sweeps are
# two units by their arithmetic. The remaining 0.60 are the mean of level 3, with the test for the end and the traffic
# of a third and a fourth array. That split is assumed.

MEANS = frozenset({Method.AM, Method.MAM, Method.HALF_SWEEP_AM})
"""Methods of two levels and their mean."""

FITTED = tuple(run for run in published.AM if run.omega is not None and run.omega <= 1.90)
"""Rows that the cost of AM is fitted to. Held out: the other 13 of AM and all 63 of MAM."""

BARRIER_UNITS = 60
"""Units that one meeting of two cores takes: about 1 µs on the paper's machine. Assumed."""

SEARCH_UNITS = 2
"""Units of a step of the search: eight neighbours compared, in place of four averaged. Assumed."""

DIRECT_KERNEL = "relaxation_direct_cell"
"""The unit of a direct solution: one cell passed by a sweep in raster order as a compiled loop, node after node.

On the paper's machine this is the unit of the sweeps. Where the sweeps are vectorised it is about seven of their units,
so platforms give it a cost of its own.
"""

MAP_KERNEL = "relaxation_map_cell"
"""One cell of the map: packed and unpacked for the sweeps, and the lowest of its neighbours found for the search."""

CHECK_KERNEL = "relaxation_check_cell"
"""One cell of a check for cells without a descent. Branches that are hard to predict make it slower than an update."""

DIAGONAL_KERNEL = "relaxation_diagonal"
"""One diagonal of a sweep, besides its cells: the sweeps run over whole diagonals, which are short on small maps."""

DIRECT_COEFFICIENT, DIRECT_EXPONENT = 22.0, 1.31
"""Units of ``DIRECT_KERNEL`` of a direct solution over n unknowns: 22 n^1.31.

Measured on our machine, for empty squares of 10,000 to 260,000 cells: SciPy's SuperLU against that loop. The floor plan
takes 20 % less. ``benchmarks/bench_relaxation`` repeats it. It serves where the factors are not known.
"""

FACTOR_COEFFICIENT, FACTOR_EXPONENT, FILL_EXPONENT = 5.1, 1.28, 0.55
"""Units of ``DIRECT_KERNEL`` of a solution over n unknowns with f values in its factors: 5.1 n^1.28 (f / n)^0.55.

Mazes fill the factors with 6 values an unknown, open maps with 65. Fitted to six real maps and to empty squares
(docs/laws.md).
"""


def seconds_an_iteration(run: published.Run) -> float:
    """Seconds of one iteration of a published run."""
    return run.seconds / run.iterations


def unit() -> Figure:
    """Seconds of one unit on the paper's 3.4 GHz machine."""
    value = seconds_an_iteration(published.GS) / published.CELLS
    source = f"{published.PAPER}, Table I: 77.12 s for 51454 Gauss-Seidel iterations of 330 × 270 cells"
    return Figure(value, "s", Status.CALIBRATED, source)


def mean_units() -> Figure:
    """Units a cell and iteration of the two-level arithmetic mean, with the range of the rows it is fitted to."""
    ratios = [seconds_an_iteration(run) / seconds_an_iteration(published.GS) for run in FITTED]
    source = f"{published.PAPER}, Table I: mean of the {len(ratios)} rows of AM with ω ≤ 1.90 over the row of GS"
    return Figure(fmean(ratios), "updates", Status.CALIBRATED, source, min(ratios), max(ratios))


def sweep_units(method: Method, cells: int) -> int:
    """Units of one sweep over a map of ``cells`` cells: half of them for half sweeps.

    >>> sweep_units(Method.AM, 100), sweep_units(Method.HALF_SWEEP_AM, 101)
    (100, 51)
    """
    return -(-cells // 2) if method is Method.HALF_SWEEP_AM else cells


def level_3_units(method: Method, cells: int) -> int:
    """Units of the mean of the two levels."""
    return max(1, round((mean_units().value - 2.0) * sweep_units(method, cells)))


def diagonals(method: Method, shape: tuple[int, int], cores: int = 1) -> int:
    """Diagonals that an iteration passes over a map. Levels 2 and 3 together count as two of level 1 (measured).

    >>> diagonals(Method.GS, (10, 20)), diagonals(Method.AM, (10, 20)), diagonals(Method.AM, (10, 20), 2)
    (29, 87, 58)
    """
    if method not in MEANS:
        return sum(shape) - 1
    return (sum(shape) - 1) * (3 if cores == 1 else 2)


def direct_units(unknowns: int, factors: int = 0) -> int:
    """Units of one direct solution; ``factors``: values in its factors, 0 where they are not known."""
    if not factors:
        return max(1, math.ceil(DIRECT_COEFFICIENT * math.pow(unknowns, DIRECT_EXPONENT)))
    fill = math.pow(factors / unknowns, FILL_EXPONENT)
    return max(1, math.ceil(FACTOR_COEFFICIENT * math.pow(unknowns, FACTOR_EXPONENT) * fill))


SEARCH = "search"

BATCHES = 16
"""The most batches of iterations that a run reports to listeners."""

DOUBLE_BITS = 52
"""Fractional bits of a double."""


class Host(HostStyle):
    """Every cell of the map is passed by every sweep, at one unit of the kernel."""

    planner = "relaxation"
    description = "sweeps in raster order, in doubles; levels 1 and 2 side by side where there are two cores"
    kernel = "relaxation_node_update"
    beyond = "other methods, values of omega and r, tolerances and boundaries"

    def __init__(self, style: str, *, cores: int = 1) -> None:
        self.style = style
        self.cores = cores

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """The default method, the direct solution, and two methods with a strong over-relaxation."""
        strong: tuple[dict[str, Any], ...] = tuple(
            {"method": str(method), "omega": 1.9} for method in (Method.RED_BLACK, Method.SOR)
        )
        return (({},), ({"method": str(Method.DIRECT)},), *((design,) for design in strong))

    def families(self, job: Job[Problem, Any]) -> Iterator[Family]:
        """Each design by itself: every one reads the map. Other values of omega are not among them."""
        for chain in self.designs(job):
            yield Family(chain, {MAP_KERNEL: job.problem.free.size})

    def bytes_a_cell(self, job: Job[Problem, RelaxParameters]) -> Figure:
        """The map in a byte and the potential in a double; the direct solution takes its factors besides."""
        factors = factor_bytes(job)
        source = "the map in a byte, and a potential in a double" + (
            f"; {factors:.0f} bytes of factors, as the solver here takes" if factors else ""
        )
        return assumed_bytes(9 + factors, source, low=8 + factors / 2, high=17 + 2 * factors)

    def iteration(self, method: Method, cells: int) -> dict[str, int]:
        """Units of one iteration over a map of ``cells`` cells, by phase; none for the direct solution."""
        sweep, shared = sweep_units(method, cells), self.cores > 1
        if method in MEANS:
            mean = {"level_3": level_3_units(method, cells)}
            if shared:
                return {"levels_1_and_2": sweep} | mean | {"barriers": 2 * BARRIER_UNITS}
            return {"level_1": sweep, "level_2": sweep} | mean
        if shared and method in {Method.RED_BLACK, Method.JACOBI}:
            meetings = 2 if method is Method.RED_BLACK else 1
            return {"sweep": -(-sweep // self.cores), "barriers": meetings * BARRIER_UNITS}
        return {} if method is Method.DIRECT else {"sweep": sweep}

    def kernels(self, job: Job[Problem, RelaxParameters]) -> tuple[str, ...]:
        """The kernel of the sweeps and the search; the kernels beside the sweeps, or of the direct solution."""
        direct = job.parameters.method is Method.DIRECT
        return self.kernel, MAP_KERNEL, *((DIRECT_KERNEL,) if direct else (DIAGONAL_KERNEL, CHECK_KERNEL))

    def work(self, job: Job[Problem, RelaxParameters]) -> Generator[Step, None, Plan]:
        """Phases: the paper's levels (or ``sweep``, ``factorise``), ``fill`` of half sweeps, ``check``, ``search``.

        Iterations have ``prepare`` and ``diagonals`` besides, and runs that end by descents ``check``.

        With ``detail`` the iterations come in batches. The last batch reports the potential, scaled to 0 on obstacles
        and 1 on goals. ``start``: the potential of an earlier plan, from which the sweeps continue.
        """
        problem, parameters, start = job.problem, job.parameters, job.start
        began = None if start is None else hashlib.sha256(start.tobytes()).hexdigest()
        key = ("relaxation", problem.map_digest, parameters.model_dump_json(), began)
        plan = job.shared(key, lambda: PLANNER.plan(job))
        search = search_of(problem, plan)
        *earlier, last = self._relaxation(plan.solution, problem, BATCHES if job.detail else 1)
        if job.detail:
            clock = _StageClock()
            earlier = [replace(step, record=clock.note, makes=StageRecord) for step in earlier]
            record = _stage_record(plan.solution, int(search.flat().sum()), clock)
            last = replace(last, record=record, makes=StageRecord)
        yield from (*earlier, last)
        if job.does(SEARCH):
            # Without a start the answer is a single step.
            entered = len(search.follow(problem.starts[0]).cells) - 1 if problem.starts else 1
            yield _step(SEARCH, SEARCH_UNITS * max(1, entered))
        return plan

    def _relaxation(self, solution: Solution, problem: Problem, batches: int) -> list[Step]:
        cells, method = problem.free.size, solution.method
        steps = [replace(map_read("prepare", problem, MAP_KERNEL), record=None)]
        if method is Method.DIRECT:
            units = direct_units(solution.updates, solution.factors)
            return [*steps, _step("factorise", units, DIRECT_KERNEL)]
        if solution.iterations:
            passed = solution.iterations * diagonals(method, problem.shape, self.cores)
            steps.append(_step("diagonals", passed, DIAGONAL_KERNEL))
        iteration = self.iteration(method, cells)
        steps += [
            _step(phase, count * units)
            for count in _batches(solution.iterations, batches)
            for phase, units in iteration.items()
        ]
        if method is Method.HALF_SWEEP_AM:
            steps.append(_step("fill", -(-cells // 2)))
        if solution.checks:
            steps.append(_step("check", cells * (1 + solution.checks), CHECK_KERNEL))
        return steps


def _batches(iterations: int, most: int) -> list[int]:
    """Iterations shared out over at most ``most`` batches, none of them empty.

    >>> _batches(10, 4), _batches(2, 4), _batches(0, 4)
    ([3, 3, 2, 2], [1, 1], [])
    """
    number = min(most, iterations)
    return [iterations // number + (index < iterations % number) for index in range(number)]


def _step(phase: str, units: int, kernel: str = "") -> Step:
    return Step(phase, np.array([units], np.int64), kernel=kernel)


@dataclass
class _StageClock:
    """The begin of the relaxation, ps, which is the begin of its first step; None until then."""

    begin: int | None = None

    def note(self, begin: int, _end: int, _source: str) -> None:
        """Keep the begin of the first step. No record is made."""
        self.begin = begin if self.begin is None else self.begin


def _stage_record(solution: Solution, flat: int, clock: _StageClock) -> Callable[[int, int, str], StageRecord]:
    """The record of the relaxation, reported with its last step."""
    wall, goal = solution.boundary.values

    def record_stage(begin: int, end: int, source: str) -> StageRecord:
        return StageRecord(
            time=end,
            source=source,
            begin=begin if clock.begin is None else clock.begin,
            stage=0,
            precision=DOUBLE_BITS,
            # A stage on a processor has iterations, and units of a kernel in place of cycles.
            sweeps=0,
            visits=0,
            iterations=solution.iterations,
            cycles=0,
            local_maxima=flat,
            potential=(solution.potential - wall) / (goal - wall),
        )

    return record_stage


class HostSearch(HostTask):
    """Two units for each step of the path, as in the styles of the whole planner. Assumed."""

    planner = "relaxation"
    task = SEARCH
    description = "from cell to cell, each time to the lowest neighbour"
    kernel = "relaxation_node_update"

    def outcome(self, job: Job[Problem, RelaxParameters]) -> tuple[int, tuple[NDArray[np.float64], bool]]:
        """The path from the position."""
        points, arrived = PLANNER.path_from(job.problem, job.plan, job.position)
        return SEARCH_UNITS * max(1, len(points) - 1), (points, arrived)

    def again(self, _job: Job[Problem, RelaxParameters], /) -> Generator[Step, None, None]:
        """The next cell alone, as only that cell is sent."""
        yield one_step(self.task, SEARCH_UNITS)


TASK_STYLES = (HostSearch(),)


_SHORT, _LONG = 10, 300
"""Iterations of two relaxations; the difference of their times is measured."""


_ROWS, _COLUMNS = 270, 330
"""The size of Saudi and Sulaiman's area."""


def _rooms() -> Any:
    return maps.rooms(_ROWS, _COLUMNS, room=(64, 80), door=12, wall=3, seed=1).free


def _thin() -> Any:
    return np.ones((2, _ROWS + _COLUMNS - 2), np.bool_)


def _sweeps(free: Any, count: int) -> Callable[[], object]:
    """Sweeps of SOR, to a tolerance, so that no check for cells without a descent is timed."""
    return lambda: solve(
        free,
        [(1, 1)],
        method="sor",
        omega=1.95,
        tolerance=PUBLISHED_TOLERANCE,
        boundary="low_goal",
        max_iterations=count,
    )


def _relaxation() -> Probe:
    rooms, long = _rooms(), _sweeps(_rooms(), _LONG)
    short, diagonals = _sweeps(rooms, _SHORT), _sweeps(_thin(), _LONG - _SHORT)
    return Probe((_LONG - _SHORT) * rooms.size, long, lambda: (short(), diagonals()))


def _diagonal() -> Probe:
    """Diagonals of two cells at most."""
    thin = _thin()
    number = (_LONG - _SHORT) * (sum(thin.shape) - 1)
    return Probe(number, _sweeps(thin, _LONG), _sweeps(thin, _SHORT))


def _check() -> Probe:
    """Checks after every tenth iteration, over rooms that take more iterations than these."""
    rooms = _rooms()

    def run(tolerance: float | None) -> Callable[[], object]:
        return lambda: solve(rooms, [(10, 10)], method="gs", tolerance=tolerance, max_iterations=_LONG)

    # The flood fill counts as one check more, as in the law.
    return Probe((1 + _LONG // CHECK_EVERY) * rooms.size, run(None), run(PUBLISHED_TOLERANCE))


def _map() -> Probe:
    """An iteration over rooms, and the search prepared."""
    problem = Problem(_rooms(), ((10, 10),), ())
    parameters = RelaxParameters(method=Method.GS, tolerance=1e-15, max_iterations=1)
    job = Job(problem, parameters)
    return Probe(problem.free.size, lambda: search_of(problem, PLANNER.plan(job)))


def _relaxation_direct() -> Probe:
    """A direct solution over rooms of a quarter of that area, shared out over the units of its law."""
    free = maps.rooms(135, 165, room=(32, 40), door=6, wall=2, seed=1).free

    def run() -> Solution:
        return solve(free, [(10, 10)], method="direct")

    return Probe(direct_units((first := run()).updates, first.factors), run)


PROBES: Mapping[str, Callable[[], Probe]] = {
    "relaxation_node_update": _relaxation,
    DIRECT_KERNEL: _relaxation_direct,
    DIAGONAL_KERNEL: _diagonal,
    CHECK_KERNEL: _check,
    MAP_KERNEL: _map,
}
"""The probe of each kernel, by the name of its cost in platforms."""
