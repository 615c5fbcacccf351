"""Styles ``sequential`` and ``two_core``: the relaxation on one core of a processor, or on two of them.

A processor has no clock law: a cycle of a step stands for one unit of the kernel ``relaxation_node_update``, or of
``relaxation_direct_cell`` in the direct solution. The platform gives these kernels costs (see ``costs``). On two cores
a cycle passes on both, so that cycles are time.

Two cores: levels 1 and 2 of the arithmetic means run side by side, and meet before and after level 3, which one core
computes. The colours of a red-black sweep and the nodes of Jacobi's are halved between the cores. A sweep in raster
order (Gauss-Seidel, SOR), the direct solution and the checks for cells without a descent stay on one core. The
platform's busy power counts once for one core or two: assumed, and too little where that power is a core's share.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from codesign.ground.figures import Figure
from codesign.ground.records import StageRecord
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.relaxation.plan import Method, Solution
from codesign.planners.relaxation.plan.parameters import RelaxParameters
from codesign.planners.relaxation.plan.planner import PLANNER, Plan, factor_bytes, search_of
from codesign.planners.relaxation.styles.costs import (
    BARRIER_UNITS,
    CHECK_KERNEL,
    DIAGONAL_KERNEL,
    DIRECT_KERNEL,
    MAP_KERNEL,
    MEANS,
    SEARCH_UNITS,
    diagonals,
    direct_units,
    level_3_units,
    sweep_units,
)
from codesign.planners.styles import Designs, Family, HostStyle, Step, assumed_bytes, map_read

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
        """The steps of the relaxation, in order."""
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
