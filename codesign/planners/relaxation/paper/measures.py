"""The measures of rows.yaml, of Saudi and Sulaiman (2016): runs on an own floor plan, times by the law of cost."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codesign.planners.papers import Case, Paper, Runs, Words
from codesign.planners.relaxation import published
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, Boundary, Method, Search, Solution, solve
from codesign.planners.relaxation.published import RelaxationSettings
from codesign.planners.relaxation.styles.host import FITTED, Host, direct_units, mean_units, seconds_an_iteration, unit
from codesign.planners.reproduction import Progress, Series, Use, silent

# A floor plan of 330 × 270 cells, drawn for this purpose: the maps of Saudi and Sulaiman (2016) are not published.

ROWS, COLUMNS = 270, 330
WALL = 3
GOAL = (150, 60)
"""In the hall, as section V's "goal point": one goal for all starts."""

HALL_WIDTH = 200

_CORRIDORS = ((54, 72), (201, 219))
"""First and last + 1 row of the corridors along the plan."""

_DOORS = (
    ((54 - WALL, 54), (20, 60, 100, 150, 200, 250, 300)),
    ((72, 72 + WALL), (30, 130, 215, 290)),
    ((201 - WALL, 201), (60, 150, 230, 280)),
    ((219, 219 + WALL), (20, 75, 130, 190, 240, 300)),
)
"""Rows of a wall along a corridor, and the first columns of its doors."""

_DOOR = 12


def floor_plan(hall_width: int = HALL_WIDTH) -> NDArray[np.bool_]:
    """Bool 270 × 330, true where free; every free cell can be reached."""
    right = WALL + hall_width + WALL
    middle = (right + COLUMNS) // 2
    bands = (
        ((WALL, 54 - WALL), (WALL, 44, 84, 132, 180, 228, 276, COLUMNS)),
        ((72 + WALL, 201 - WALL), (WALL, right, middle, COLUMNS)),
        ((219 + WALL, ROWS - WALL), (WALL, 57, 112, 170, 222, 276, COLUMNS)),
    )
    free = np.zeros((ROWS, COLUMNS), np.bool_)
    for top, bottom in _CORRIDORS:
        free[top:bottom, WALL : COLUMNS - WALL] = True
    for (top, bottom), edges in bands:
        for left, end in pairwise(edges):
            free[top:bottom, left : end - WALL] = True
    for (top, bottom), doors in _DOORS:
        for left in doors:
            free[top:bottom, left : left + _DOOR] = True
    return free


SOR_OMEGAS = (1.90, 1.93, 1.95, 1.955, 1.96, 1.965, 1.97, 1.98)
HALF_OMEGAS = (1.90, 1.92, 1.94, 1.95, 1.96)
CHECK_EVERY = 10
"""Iterations between two checks for flat cells, in ``until_followed``."""


@dataclass(frozen=True, order=True)
class Key:
    """A run: a method with its parameters and a boundary."""

    method: Method
    omega: float | None = None
    r: float | None = None
    boundary: Boundary = Boundary.LOW_GOAL


@dataclass(frozen=True)
class MethodRun:
    """The outcome of a run. ``flat``: reachable cells without a next step. ``updates``: node values computed."""

    iterations: int
    stagnated: bool
    flat: int
    updates: int


MethodRuns = dict[Key, MethodRun]


def key_of(run: published.Run) -> Key:
    """The key of a published run."""
    if run.omega is None:
        return Key(Method.GS)
    return Key(Method.AM if run.r is None else Method.MAM, run.omega, run.r)


def tabulated(quick: bool) -> tuple[published.Run, ...]:
    """The rows of Tables I and II that are run; in ``quick`` a few of those with few iterations."""
    if quick:
        return (published.GS, *published.AM[8::3], published.MAM_COARSE[-1], *published.MAM_FINE[1::6])
    return (published.GS, *published.AM, *published.MAM_COARSE, *published.MAM_FINE)


def beyond(quick: bool, sor_omegas: tuple[float, ...] | None = None) -> tuple[Key, ...]:
    """Runs that the paper leaves out: plain SOR, red-black, half sweeps, a direct solver, and walls set high."""
    step = 2 if quick else 1
    omegas = sor_omegas or SOR_OMEGAS[::step]
    return (
        *(Key(Method.SOR, omega) for omega in omegas),
        *(Key(Method.RED_BLACK, omega) for omega in omegas),
        *(Key(Method.HALF_SWEEP_AM, omega) for omega in HALF_OMEGAS[1::step]),
        Key(Method.DIRECT),
        *(
            Key(method, omega, r, Boundary.HIGH_WALLS)
            for method, omega, r in ((Method.SOR, 1.95, None), (Method.AM, 1.97, None), (Method.MAM, 1.97, 1.92))
        ),
    )


def published_run(free: NDArray[np.bool_], key: Key, **limit: int) -> Solution:
    """A run by the paper's convention: its tolerance, and the boundary of ``key``. ``limit``: max_iterations."""
    return solve(
        free,
        [GOAL],
        method=key.method,
        omega=key.omega,
        r=key.r,
        tolerance=PUBLISHED_TOLERANCE,
        boundary=key.boundary,
        **limit,  # type: ignore[arg-type]
    )


def run_all(keys: Iterable[Key], progress: Progress = silent) -> MethodRuns:
    """Every run, on all cores; the outcomes do not depend on the number of cores."""
    free = floor_plan()
    wanted = tuple(dict.fromkeys(keys))

    def run(key: Key) -> MethodRun:
        solution = published_run(free, key)
        search = Search(solution.potential, free, [GOAL])
        return MethodRun(solution.iterations, solution.stagnated, int(search.flat().sum()), solution.updates)

    outcomes: MethodRuns = {}
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for key, outcome in zip(wanted, pool.map(run, wanted), strict=True):
            outcomes[key] = outcome
            if len(outcomes) % 10 == 1:
                progress(f"relaxation of the floor plan: run {len(outcomes)} of {len(wanted)}")
    return outcomes


def until_followed(key: Key, most: int) -> int | None:
    """Iterations, in steps of ``CHECK_EVERY``, after which no reachable cell is flat; None: more than ``most``.

    Over-relaxed runs may lose descents again, so no cell may be flat after twice and four times as many iterations
    either.
    """
    free = floor_plan()

    @cache
    def followed(iterations: int) -> bool:
        solution = published_run(free, key, max_iterations=iterations)
        return not Search(solution.potential, free, [GOAL]).flat().any()

    steps = range(CHECK_EVERY, most + 1, CHECK_EVERY)
    return next((k for k in steps if followed(k) and followed(2 * k) and followed(4 * k)), None)


def seconds(method: Method, iterations: int, *, cores: int = 1) -> float:
    """Seconds of ``iterations`` on the paper's machine, by the cost law."""
    style = Host("host", cores=cores)
    return iterations * sum(style.iteration(method, published.CELLS).values()) * unit().value


def direct_seconds(unknowns: int) -> float:
    """Seconds of the direct solution, by the cost law."""
    return direct_units(unknowns) * unit().value


def best(outcomes: MethodRuns, method: Method, *, followed: bool = False) -> tuple[Key, MethodRun]:
    """The run of ``method`` with the fewest iterations; with ``followed`` among those without flat cells."""
    runs = (
        (key, outcome)
        for key, outcome in outcomes.items()
        if key.method is method and key.boundary is Boundary.LOW_GOAL and not (followed and outcome.flat)
    )
    return min(runs, key=lambda run: run[1].iterations)


def reduction(lesser: float, greater: float) -> float:
    """By how many % ``lesser`` is below ``greater``."""
    return 100.0 * (1.0 - lesser / greater)


SMALL_OMEGA = 1.5
"""The least ω of Table I, for AM as a means to lead to the goal, not to meet a tolerance."""
MOST_FOLLOWED = 1000
FAR_OFF = 0.05
"""A finding names each published time that the cost law misses by more."""


class MethodsRuns(Runs[RelaxationSettings]):
    """The runs of Tables I and II, and of methods that the paper leaves out, on the own floor plan."""

    @cached_property
    def tabulated(self) -> tuple[published.Run, ...]:
        """The rows of Tables I and II that are run."""
        return tabulated(self.quick)

    @cached_property
    def outcomes(self) -> MethodRuns:
        """The outcome of each run."""
        keys = *map(key_of, self.tabulated), *beyond(self.quick, self.settings.sor_omegas)
        return run_all(keys, self.progress)

    def errors(self, table: str, word: str) -> list[float]:
        """Errors held out of any fit, in the rows of a table with ``word`` in their quantity, without the misprint."""
        return [
            abs(row.error)
            for row in self.rows
            if row.table == table
            and word in row.quantity
            and row.use is Use.HELD_OUT
            and row.error is not None
            and not row.note.startswith("misprinted")
        ]

    @property
    def mam(self) -> MethodRun:
        """The best run of MAM."""
        return best(self.outcomes, Method.MAM)[1]


PAPER = Paper(Path(__file__).with_name("rows.yaml"), published.NUMBERS, MethodsRuns, RelaxationSettings)
measure = PAPER.measure


@measure
def tables(runs: MethodsRuns, _case: Case) -> Iterator[Words]:
    """The rows of Tables I and II that are run."""
    for run in runs.tabulated:
        name = "GS"
        if run.omega is not None:
            name = f"AM ω={run.omega:g}" if run.r is None else f"MAM ω={run.omega:g} r={run.r:g}"
        fitted = run is published.GS
        yield {
            "run": run,
            "table": "Table II" if run in published.MAM_FINE else "Table I",
            "name": name,
            "printed_iterations": run.iterations,
            "printed_seconds": run.seconds,
            "use": Use.FITTED if fitted else Use.HELD_OUT,
            "use_of_time": Use.FITTED if fitted or run in FITTED else Use.HELD_OUT,
            "remark": "the size of the hall is fitted to this row" if fitted else "",
            "misprint": "misprinted: the number of iterations once more" if run is published.MISPRINT else "",
        }


@measure
def own_run(runs: MethodsRuns, case: Case) -> Words:
    """Iterations on the own map, and the law's time of the published iterations."""
    key = key_of(case.run)
    return {"iterations": runs.outcomes[key].iterations, "seconds": seconds(key.method, case.run.iterations)}


@measure
def reductions(runs: MethodsRuns, case: Case) -> Words | None:
    """The least or greatest reduction over pairs of own runs; a run without the first pair has no least one."""
    if case.which == "least" and key_of(published.AM[0]) not in runs.outcomes:
        return None
    time = case.what == "time"
    values = [
        reduction(seconds(one.method, less), seconds(other.method, more)) if time else reduction(less, more)
        for one, other in _pairs(case.methods)
        if one in runs.outcomes
        for less, more in [(runs.outcomes[one].iterations, runs.outcomes[other].iterations)]
    ]
    law = "; iterations × cells × 16.8 ns, and 2.60 times that for AM and MAM" if time else ""
    return {"value": min(values) if case.which == "least" else max(values), "law": law}


def _pairs(methods: str) -> Iterator[tuple[Key, Key]]:
    """The runs that Table III compares: AM with GS up to its best ω, 1.97, and MAM with AM of the same ω."""
    if methods == "AM against GS":
        yield from ((key_of(run), Key(Method.GS)) for run in published.AM[:18])
    else:
        yield from ((key_of(run), Key(Method.AM, run.omega)) for run in published.MAM_COARSE)


@measure
def best_runs(runs: MethodsRuns, _case: Case) -> Words:
    """The best parameters."""
    (am, _), (key, mam) = best(runs.outcomes, Method.AM), best(runs.outcomes, Method.MAM)
    time = seconds(Method.MAM, mam.iterations)
    return {"am_omega": am.omega, "omega": key.omega, "r": key.r, "iterations": mam.iterations, "seconds": time}


@measure
def beyond_paper(runs: MethodsRuns, _case: Case) -> Iterator[Words]:
    """Methods that the paper leaves out, on the same map and at the same cost of an update."""
    for method in (Method.SOR, Method.RED_BLACK, Method.HALF_SWEEP_AM):
        key, outcome = best(runs.outcomes, method, followed=True)
        remark = "fewest iterations without flat cells"
        name = f"{method} ω={key.omega:g}"
        yield {"name": f"{name}, iterations", "value": outcome.iterations, "in_unit": "1", "remark": remark}
        yield _timed(f"{name}, time", seconds(method, outcome.iterations))
    for method in (Method.AM, Method.MAM):
        key, outcome = best(runs.outcomes, method)
        shown = f"{method} ω={key.omega:g}" + ("" if key.r is None else f" r={key.r:g}")
        yield _timed(f"{shown} on two cores, time", seconds(method, outcome.iterations, cores=2))
    unknowns = runs.outcomes[Key(Method.DIRECT)].updates
    yield _timed("sparse direct solution, time", direct_seconds(unknowns))


def _timed(name: str, value: float) -> Words:
    return {"name": name, "value": value, "in_unit": "s", "remark": ""}


@measure
def without_published(_runs: MethodsRuns, case: Case) -> float:
    """The figure of a method that the paper leaves out."""
    return case.value  # type: ignore[no-any-return]


@measure
def iterations_by_omega(runs: MethodsRuns, _case: Case) -> Iterator[Series]:
    """Iterations against ω, published and own."""
    for name, table in (("AM", published.AM), ("MAM, r = ω + 0.05", published.MAM_COARSE)):
        chosen = [run for run in runs.tabulated if run in table]
        yield from _published_and_own(runs, name, [run.omega or 0.0 for run in chosen], chosen)
    sor = sorted(
        (key.omega or 0.0, float(outcome.iterations))
        for key, outcome in runs.outcomes.items()
        if key.method is Method.SOR and key.boundary is Boundary.LOW_GOAL
    )
    yield Series("SOR, own map", tuple(point[0] for point in sor), tuple(point[1] for point in sor))


@measure
def iterations_by_r(runs: MethodsRuns, _case: Case) -> Iterator[Series]:
    """Iterations of MAM against r for the widest ω of Table II, published and own."""
    for omega in (1.95, 1.97):
        chosen = [run for run in runs.tabulated if run in published.MAM_FINE and run.omega == omega]
        yield from _published_and_own(runs, f"ω = {omega:g}", [run.r or 0.0 for run in chosen], chosen)


def _published_and_own(runs: MethodsRuns, name: str, x: list[float], chosen: list[published.Run]) -> Iterator[Series]:
    at = tuple(map(float, x))
    yield Series(f"{name}, published", at, tuple(float(run.iterations) for run in chosen))
    yield Series(f"{name}, own map", at, tuple(float(runs.outcomes[key_of(run)].iterations) for run in chosen))


# The errors of the map and the cost law on rows that they were not fitted to.


@measure
def iterations_met(runs: MethodsRuns, _case: Case) -> Words:
    """The errors of the iterations on the own map."""
    first, second = (runs.errors(table, ", iterations") for table in ("Table I", "Table II"))
    gs = next(row for row in runs.rows if row.quantity == "GS, iterations")
    assert gs.error is not None
    figures = {
        "fitted row": f"{gs.error:+.1%}",
        "Table I, mean": f"{sum(first) / len(first):.1%}",
        "Table I, worst": f"{max(first):.0%}",
        "Table II, mean": f"{sum(second) / len(second):.1%}",
        "Table II, worst": f"{max(second):.0%}",
    }
    return {"figures": figures, "holds": max(sum(first) / len(first), sum(second) / len(second)) < 0.1}


@measure
def times_met(runs: MethodsRuns, _case: Case) -> Words:
    """The errors of the law of cost."""
    times = runs.errors("Table I", ", time") + runs.errors("Table II", ", time")
    figures = {
        "rows of AM that were fitted": str(len(FITTED)),
        "iteration of AM over Gauss-Seidel": f"{mean_units().value:.2f}",
        "rows held out": str(len(times)),
        "mean": f"{sum(times) / len(times):.1%}",
        "worst": f"{max(times):.0%}",
    }
    return {"figures": figures, "holds": sum(times) / len(times) < 0.05}


# MAM against methods that the paper leaves out, all on the own floor plan.


@measure
def sor_and_mam(runs: MethodsRuns, _case: Case) -> Words:
    """The best SOR and the best MAM."""
    key, sor = best(runs.outcomes, Method.SOR, followed=True)
    time, mam_time = seconds(Method.SOR, sor.iterations), seconds(Method.MAM, runs.mam.iterations)
    return {
        "omega": key.omega,
        "iterations": sor.iterations,
        "seconds": time,
        "mam_iterations": runs.mam.iterations,
        "mam_seconds": mam_time,
        "holds": time < mam_time,
    }


@measure
def two_cores(runs: MethodsRuns, case: Case) -> Words:
    """MAM on two cores."""
    two = seconds(Method.MAM, runs.mam.iterations, cores=2)
    return {"two": two, "holds": two > sor_and_mam(runs, case)["seconds"]}


@measure
def half_sweeps(runs: MethodsRuns, _case: Case) -> Words:
    """AM by half sweeps."""
    key, half = best(runs.outcomes, Method.HALF_SWEEP_AM, followed=True)
    time = seconds(Method.HALF_SWEEP_AM, half.iterations)
    holds = time < seconds(Method.MAM, runs.mam.iterations)
    return {"omega": key.omega, "iterations": half.iterations, "seconds": time, "holds": holds}


@measure
def direct(runs: MethodsRuns, case: Case) -> Words:
    """The sparse direct solver."""
    time, iterative = direct_seconds(runs.outcomes[Key(Method.DIRECT)].updates), sor_and_mam(runs, case)
    fastest = min(iterative["seconds"], iterative["mam_seconds"], half_sweeps(runs, case)["seconds"])
    return {"seconds": time, "holds": time < fastest}


@measure
def until_every_cell_leads(runs: MethodsRuns, _case: Case) -> Words:
    """The iterations until each cell leads to the goal, against those until the tolerance is met."""
    followed = {
        "Gauss-Seidel": Key(Method.GS),
        "SOR": best(runs.outcomes, Method.SOR, followed=True)[0],
        "AM": Key(Method.AM, SMALL_OMEGA),
        "MAM": best(runs.outcomes, Method.MAM)[0],
    }
    spent: dict[str, float] = {}
    figures: dict[str, str] = {}
    for name, key in followed.items():
        shown = name if key.omega is None else f"{name} at ω = {key.omega:g}"
        runs.progress(f"relaxation of the floor plan: {shown} until every cell leads to the goal")
        iterations = until_followed(key, MOST_FOLLOWED)
        if iterations is not None:
            spent[name] = seconds(key.method, iterations)
            figures[shown] = f"{iterations:,}"
            figures[f"{shown}, time"] = f"{spent[name]:.2f} s"
    figures["Gauss-Seidel to the tolerance"] = f"{runs.outcomes[Key(Method.GS)].iterations:,}"
    return {"figures": figures, "holds": min(spent, key=spent.__getitem__) == "AM"}


# The effect of the tolerance and the boundary on the search.


@measure
def stalled(runs: MethodsRuns, _case: Case) -> Words:
    """Runs with the walls set high."""
    high = [outcome for key, outcome in runs.outcomes.items() if key.boundary is Boundary.HIGH_WALLS]
    count = sum(outcome.stagnated for outcome in high)
    flat = max(outcome.flat for outcome in high)
    return {"stalled": count, "runs": len(high), "flat": flat, "holds": count == len(high)}


@measure
def flat_by_sor(runs: MethodsRuns, _case: Case) -> Words:
    """Flat cells that runs by SOR leave."""
    flat = {
        f"SOR at ω = {key.omega:g}": str(outcome.flat)
        for key, outcome in sorted(runs.outcomes.items())
        if key.method is Method.SOR and key.boundary is Boundary.LOW_GOAL and outcome.flat
    }
    return {"figures": flat, "holds": flat}


@measure
def none_flat_by_means(runs: MethodsRuns, _case: Case) -> bool:
    """True if no run of GS, AM or MAM with the paper's boundary left flat cells."""
    return not any(
        outcome.flat
        for key, outcome in runs.outcomes.items()
        if key.method in {Method.GS, Method.AM, Method.MAM} and key.boundary is Boundary.LOW_GOAL
    )


# Contradictions within the paper.


@measure
def larger_parameter(_runs: MethodsRuns, _case: Case) -> Words:
    """MAM with ω and r against AM with r."""
    am = {run.omega: run.iterations for run in published.AM}
    losing, pairs = sum(run.iterations > am[run.r] for run in published.MAM_COARSE), len(published.MAM_COARSE)
    best_am, best_mam = min(am.values()), min(run.iterations for run in published.MAM_FINE)
    return {
        "losing": losing,
        "pairs": pairs,
        "best_am": best_am,
        "best_mam": best_mam,
        "gain": 1.0 - best_mam / best_am,
        "holds": losing == pairs,
    }


@measure
def times_unlike_iterations(runs: MethodsRuns, _case: Case) -> Words:
    """Times of Table II that the cost law misses."""
    gs = seconds_an_iteration(published.GS) * mean_units().value
    figures: dict[str, str] = {}
    for run in published.MAM_FINE:
        if run is published.MISPRINT or abs(run.iterations * gs / run.seconds - 1.0) <= FAR_OFF:
            continue
        name = f"ω = {run.omega:g}, r = {run.r:g}"
        figures[f"{name}: iterations"] = f"{run.iterations:,}"
        figures[f"{name}: time"] = f"{run.seconds:.2f} s"
        figures[f"{name}: iterations for which this is time"] = f"{run.seconds / gs:,.0f}"
        if key_of(run) in runs.outcomes:
            figures[f"{name}: iterations on our map"] = f"{runs.outcomes[key_of(run)].iterations:,}"
    return {"figures": figures, "holds": figures}


@measure
def slip(_runs: MethodsRuns, _case: Case) -> Words:
    """The first reduction of Table III, from Table I."""
    value = reduction(published.AM[0].iterations, published.GS.iterations)
    return {"reduction": value, "holds": round(value, 2) != 64.99}
