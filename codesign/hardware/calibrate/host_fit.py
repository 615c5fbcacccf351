"""Costs, load and jitter of a host, fitted to the times of plans on several maps.

A cost is a time a unit of a kernel, and the time of a plan is a sum of units times costs. On another map the same units
take another time: caches, branches and prefetching differ. So the costs of a program are fitted on maps of several
kinds and sizes, and their interval is the one in which the time of a plan on one more map lies with 95 %.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from statistics import median
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.figures import Figure, Status
from codesign.ground.late import late
from codesign.ground.progress import Show, silent, tracked
from codesign.hardware.calibrate.calibration import student
from codesign.inputs import Platform, Workload, load_platform
from codesign.inputs.fields import MOST_LOAD
from codesign.maps import reachable
from codesign.planners.interface import Cell, Problem
from codesign.planners.job import Job
from codesign.planners.plug_in import Timed
from codesign.system import catalog
from codesign.system.bind import System
from codesign.system.scenarios.run import bind

optimize = late("scipy.optimize")

Floats = NDArray[np.float64]

HOLD = 0.02
"""The weight of the first costs beside that of a map: it decides between kernels that no map tells apart."""


@dataclass(frozen=True)
class Timing:
    """The times of a plan on a map, run after run.

    ``program``: of whose kernels it counts ``units``. ``wall``, ``processor``: seconds of each run, by the clock on the
    wall and of the processor.
    """

    program: str
    map: str
    units: Mapping[str, int]
    wall: tuple[float, ...]
    processor: tuple[float, ...]

    @property
    def seconds(self) -> float:
        """The median of the processor's time."""
        return median(self.processor)

    def predicted(self, costs: Mapping[str, float]) -> float:
        """Units times costs, s; a kernel without a cost counts as none."""
        return math.fsum(units * costs.get(kernel, 0.0) for kernel, units in self.units.items())


@dataclass(frozen=True)
class Residual:
    """A map of a fit: the measured median, s; what the fit predicts; and what one without this map does."""

    map: str
    measured: float
    predicted: float
    held_out: float


@dataclass(frozen=True)
class ProgramFit:
    """The costs of the kernels that a program is the first to count in, s, and what the fit leaves."""

    program: str
    costs: Mapping[str, Figure]
    residuals: tuple[Residual, ...]

    @property
    def error(self) -> float:
        """The greatest error on a map held out, as a share of its time."""
        return max(abs(each.held_out / each.measured - 1.0) for each in self.residuals)


def fit_programs(timings: Sequence[Timing], first: Mapping[str, float], where: str) -> tuple[ProgramFit, ...]:
    """The costs of all programs, in the order of their timings.

    Args:
        timings: of at least two maps a program.
        first: costs to begin with, s a unit of a kernel; their ratios decide where the maps do not.
        where: the machine, for the source.
    """
    known: dict[str, float] = {}
    fits = []
    for program, rows in map_reduce(timings, lambda each: each.program).items():
        fit = _fit(program, rows, first, known, where)
        known |= {kernel: cost.value for kernel, cost in fit.costs.items()}
        fits.append(fit)
    return tuple(fits)


def _fit(
    program: str, rows: Sequence[Timing], first: Mapping[str, float], known: dict[str, float], where: str
) -> ProgramFit:
    kernels = [*dict.fromkeys(kernel for row in rows for kernel in row.units if kernel not in known)]
    costs = _least_squares(rows, kernels, first, known)
    maps = map_reduce(rows, lambda row: row.map)
    without = {
        name: _least_squares([row for row in rows if row.map != name], kernels, first, known) | known for name in maps
    }
    residuals = tuple(
        Residual(row.map, row.seconds, row.predicted(costs | known), row.predicted(without[row.map])) for row in rows
    )
    errors = [math.log(each.measured / each.held_out) for each in residuals]
    width = student(len(maps) - 1) * math.sqrt(math.fsum(error**2 for error in errors) / len(errors))
    repeated = [np.array(row.processor) / row.seconds for row in rows]
    fast, slow = np.quantile(np.concatenate(repeated), (0.01, 0.99)).tolist()
    # Maps and runs vary apart from each other: the two widths add up as squares.
    low, high = (math.exp(sign * math.hypot(width, math.log(each))) for sign, each in ((-1, fast), (1, slow)))
    off = [each.measured / each.held_out - 1.0 for each in residuals]
    source = (
        f"{program}: fit to {sum(map(len, repeated)):,} runs on {len(maps)} maps, on each held out by turns"
        f" {min(off):+.0%} to {max(off):+.0%}; interval of a run on one more map with 95 %; {where}"
    )
    figures = {
        kernel: Figure(cost, "s", Status.MEASURED, source, cost * low, cost * high) for kernel, cost in costs.items()
    }
    return ProgramFit(program, figures, residuals)


def _least_squares(
    rows: Sequence[Timing], kernels: Sequence[str], first: Mapping[str, float], known: Mapping[str, float]
) -> dict[str, float]:
    """The costs of kernels, none below 0, with the least sum of squares of predicted / measured - 1."""
    if not kernels:
        return {}
    begun = {kernel: first.get(kernel, 1e-9) for kernel in kernels}
    left = [max(row.seconds - row.predicted(known), 1e-3 * row.seconds) for row in rows]
    scale = median(rest / max(row.predicted(begun), 1e-15) for rest, row in zip(left, rows, strict=True))
    # One row a map: Σ units · cost / measured = 1 - what is known; and one a kernel, that keeps the first ratios.
    shares = [[scale * row.units.get(each, 0) * begun[each] / row.seconds for each in kernels] for row in rows]
    aims = [rest / row.seconds for rest, row in zip(left, rows, strict=True)]
    hold = HOLD * math.sqrt(len(rows))
    system = np.vstack([np.array(shares), hold * np.eye(len(kernels))])
    times, _ = optimize.nnls(system, np.array([*aims, *([hold] * len(kernels))]))
    # A kernel that costs nothing at all is one that the maps cannot tell from another.
    return {each: scale * begun[each] * max(float(time), 0.01) for each, time in zip(kernels, times, strict=True)}


@dataclass(frozen=True)
class Disturbance:
    """What other programs and the system take: see the keys ``load`` and ``jitter`` of a processor."""

    load: Figure
    median: Figure
    p99: Figure


def disturbance_of(timings: Sequence[Timing], where: str) -> Disturbance:
    """The load and the jitter of a machine, by the time on the wall of each run over that of the processor.

    The load is the share that the runs together did not get; its interval reaches from the least disturbed runs to the
    most disturbed round over all maps. Jitter is what remains of a run's ratio.
    """
    wall, busy = (_rounds([getattr(each, name) for each in timings]) for name in ("wall", "processor"))
    # A processor's clock may be coarse: no run took more of it than of the time on the wall.
    late_by = np.maximum(1.0, np.concatenate([each for each in wall]) / np.concatenate([each for each in busy]))
    load = _within(1.0 - sum(map(np.sum, busy)) / sum(map(np.sum, wall)))
    worst = max(load, *(_within(1.0 - used.sum() / spent.sum()) for used, spent in zip(busy, wall, strict=True)))
    least = min(load, _within(1.0 - 1.0 / float(np.quantile(late_by, 0.01))))
    mid, late = np.quantile(late_by, (0.5, 0.99)).tolist()
    mid, late = max(1.0, mid * (1 - load)), max(1.0, late * (1 - worst))
    source = f"{late_by.size:,} runs timed on the wall and on the processor; {where}"
    return Disturbance(
        Figure(
            round(load, 4), "1", Status.MEASURED, source, math.floor(1e4 * least) / 1e4, math.ceil(1e4 * worst) / 1e4
        ),
        *(Figure(round(each, 4), "1", Status.MEASURED, source) for each in (mid, max(mid, late))),
    )


def _rounds(runs: Sequence[Sequence[float]]) -> list[Floats]:
    count = max(map(len, runs), default=0)
    return [np.array([*chain.from_iterable(each[turn : turn + 1] for each in runs)]) for turn in range(count)]


def _within(load: float) -> float:
    return float(min(max(load, 0.0), MOST_LOAD))


# Plans timed on maps of several kinds and sizes: what the costs of a host are fitted to, and tried on.
#
# A plan is timed as the planner computes it here, compiled, less what Python takes around it: the same plan on a map of
# two cells. Its units are those that its style on a processor counts. The plans take turns: a processor that repeats
# one plan on a small map learns its branches by heart.

FITTED: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("rooms", {"rows": 44, "columns": 52, "room": (12, 15), "door": 3, "seed": 9}),
    ("random", {"rows": 56, "columns": 48, "density": 0.2, "size": 2, "seed": 10}),
    ("empty", {"rows": 90, "columns": 110}),
    ("empty", {"rows": 700, "columns": 640}),
    ("random", {"rows": 160, "columns": 150, "density": 0.2, "seed": 1}),
    ("random", {"rows": 480, "columns": 500, "density": 0.3, "seed": 2}),
    ("random", {"rows": 300, "columns": 320, "density": 0.15, "size": 5, "seed": 3}),
    ("rooms", {"rows": 110, "columns": 140, "room": (15, 15), "door": 2, "seed": 4}),
    ("rooms", {"rows": 420, "columns": 400, "room": (40, 32), "door": 6, "seed": 5}),
    ("rooms", {"rows": 900, "columns": 800, "room": (64, 80), "door": 12, "wall": 3, "seed": 6}),
    ("maze", {"rows": 181, "columns": 181, "corridor": 1, "seed": 7}),
    ("maze", {"rows": 500, "columns": 450, "corridor": 7, "seed": 8}),
)
"""The maps of the fit: kinds and sizes, from the inner caches to beyond them."""

LEAST_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class TimedPlan:
    """A plan from a start to a goal on a map, its units by kernel, and how it is computed.

    ``kernel``: the one of the style. ``call``: the same on a map of two cells.
    """

    program: str
    map: str
    job: Job[Any, Any]
    units: Mapping[str, int]
    run: Callable[[], object]
    call: Callable[[], object]
    kernel: str = ""


Question = tuple[str, NDArray[np.bool_], Cell, Cell]
"""A map's name, its free cells, a goal and a start."""


def questions(kinds: Sequence[tuple[str, Mapping[str, Any]]] = FITTED, each: int = 2) -> Iterator[Question]:
    """Goals and starts on maps of the generators, drawn, each start with a path to its goal."""
    for number, (kind, keys) in enumerate(kinds):
        name = f"{kind} {keys['rows']}x{keys['columns']}"
        yield from asked_on(name, maps.generate(kind, **keys).free, number, each)


def asked_on(name: str, free: NDArray[np.bool_], seed: int, each: int) -> Iterator[Question]:
    """Goals and starts on one map, in parts of it that have at least half of its free cells.

    A start is at least a quarter of rows and columns away, where there is such a cell: a robot asks for no shorter way.
    """
    random, cells = np.random.default_rng(seed), np.argwhere(free)
    for _ in range(each):
        goal = random.choice(cells)
        while 2 * (there := reachable(free, [goal.tolist()])).sum() < free.sum():
            goal = random.choice(cells)
        ends = np.argwhere(there)
        far = ends[4 * np.abs(ends - goal).sum(axis=1) >= sum(free.shape)]
        start = random.choice(far if len(far) else ends)
        yield name, free, (int(goal[0]), int(goal[1])), (int(start[0]), int(start[1]))


def all_timed() -> dict[str, tuple[str, Timed]]:
    """What each plug-in wants timed, with its planner, by a name for people."""
    return {
        " ".join((plug_in.planner.name, *(str(value) for value in timed.parameters.values()))): (
            plug_in.planner.name,
            timed,
        )
        for plug_in in catalog.plug_ins()
        if plug_in.planner is not None
        for timed in plug_in.timed
    }


def plans_on(asked: Sequence[Question], kernels: Sequence[str], *, on_board: bool = False) -> Iterator[TimedPlan]:
    """Every plan that is timed, on every map that is not too large for it.

    ``kernels``: all that have a cost. ``on_board``: the plans that have a program for a board, and no others.
    """
    platform, seen = _platform(kernels), set[str]()
    for program, (planner, timed) in all_timed().items():
        if on_board and timed.program is None:
            continue
        before = frozenset(seen)
        for name, free, goal, start in asked:
            if free.size > timed.most_cells:
                continue
            system = bind(platform, _workload(planner, timed, (free, goal, start)), grid=maps.OccupancyGrid(free))
            plan = _plan(program, planner, system, name)
            if not on_board and plan.units.keys() <= before:
                break
            seen |= plan.units.keys()
            yield plan


def _plan(program: str, planner: str, system: System, name: str) -> TimedPlan:
    job = system.job
    units: dict[str, int] = {}
    for step in system.architecture.work(job):
        kernel = step.kernel or system.architecture.kernel
        units[kernel] = units.get(kernel, 0) + int(step.cycles.sum())
    tiny = replace(job.problem, free=np.ones((1, 2), np.bool_), goals=((0, 0),), starts=((0, 1),))
    run, call = (partial(_answer, planner, replace(job, problem=each)) for each in (job.problem, tiny))
    return TimedPlan(program, name, job, units, run, call, system.architecture.kernel)


def _answer(planner: str, job: Job[Problem, Any]) -> object:
    of = catalog.planner(planner)
    return of.trajectory(job.problem, of.plan(job), job.problem.starts[0])


def _platform(kernels: Sequence[str]) -> Platform:
    """A processor, so that a style on it can be asked for its units."""
    costs = dict.fromkeys(kernels, "1 ns")
    host = {"type": "processor", "clock": "1 GHz", "costs": costs, "power": {"busy": "1 W", "idle": "1 W"}}
    return load_platform({"kind": "platform", "name": "here", "components": {"host": host}})


def _workload(planner: str, timed: Timed, asked: tuple[NDArray[np.bool_], Cell, Cell]) -> Workload:
    """The plan of a question; its map is given to ``bind``."""
    free, goal, start = asked
    rows, columns = free.shape
    area = {"generate": "empty", "rows": rows, "columns": columns}
    problem = {"map": area, "goals": [goal], "starts": [start], "arrive": 0, "reach": 0}
    mapping = {catalog.planner(planner).planning_task: {"component": "host", **timed.parameters}}
    workload = {"kind": "workload", "name": "here", "planner": planner, "problem": problem, "mapping": mapping}
    return catalog.load_workload(workload)


def time_plans(
    plans: Sequence[TimedPlan],
    seconds: float,
    show: Show = silent,
    clocks: tuple[Callable[[], float], Callable[[], float]] = (time.perf_counter, time.thread_time),
    rounds: int = LEAST_ROUNDS,
) -> tuple[Timing, ...]:
    """The times of plans that take turns, for about so many seconds, at least ``rounds`` times each.

    ``clocks``: on the wall, and of the processor in this thread, s.
    """
    for plan in tracked(plans, show, "plans prepared", len(plans)):
        plan.run()
    runs: list[list[tuple[float, float]]] = [[] for _ in plans]
    calls: dict[str, list[float]] = {plan.program: [] for plan in plans}
    end = clocks[0]() + seconds
    while len(runs[0]) < rounds or clocks[0]() < end:
        for plan, each in zip(plans, runs, strict=True):
            # The first of two brings back code and memory that other plans have pushed out: a robot has them at hand.
            plan.run()
            each.append(_timed(plan.run, clocks))
            plan.call()
            calls[plan.program].append(_timed(plan.call, clocks)[1])
    of_call = {program: median(each) for program, each in calls.items()}
    return tuple(
        Timing(plan.program, plan.map, plan.units, *less(of_call[plan.program], each))
        for plan, each in zip(plans, runs, strict=True)
    )


def less(call: float, runs: Sequence[tuple[float, float]]) -> Iterator[tuple[float, ...]]:
    """The times of runs on the wall and on the processor, less what Python takes."""
    for side in zip(*runs, strict=True):
        yield tuple(max(spent - call, 0.1 * spent) for spent in side)


def _timed(run: Callable[[], object], clocks: Sequence[Callable[[], float]]) -> tuple[float, float]:
    begins = [clock() for clock in clocks]
    run()
    wall, processor = (clock() - begin for clock, begin in zip(clocks, begins, strict=True))
    return wall, processor
