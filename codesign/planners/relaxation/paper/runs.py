"""The runs to compare with Saudi and Sulaiman (2016), on the floor plan of ``map``."""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from codesign.planners.relaxation import published
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, Boundary, Method, Search, Solution, solve
from codesign.planners.relaxation.styles.costs import direct_units, unit
from codesign.planners.relaxation.styles.host import Host
from codesign.planners.reproduction import Progress, silent

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
