"""Sweeps of the relaxation against the limit they could reach, and against what a user would take instead."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from codesign import maps
from codesign.planners.relaxation.paper.measures import GOAL, floor_plan
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, solve
from codesign.planners.relaxation.styles.host import direct_units

ITERATIONS = 200
REPEATS = 25


@njit(error_model="numpy")
def stencil_pass(values, target, movable, columns, repeats):
    """The same stencil over the same number of nodes as one long loop, which waits for nothing: the limit."""
    n = values.size - 2 * columns
    top = np.int64(0)
    for _ in range(repeats):
        here, out, mask = (values[columns : columns + n], target[columns : columns + n], movable[columns : columns + n])
        north, west = values[:n], values[columns - 1 : columns - 1 + n]
        east, south = values[columns + 1 : columns + 1 + n], values[2 * columns : 2 * columns + n]
        for k in range(n):
            old = here[k]
            new = 0.4875 * ((north[k] + west[k]) + (east[k] + south[k])) - 0.95 * old
            new = new if mask[k] else old
            out[k] = new
            top = max(top, np.float64(abs(new - old)).view(np.int64))
    return top


@njit(error_model="numpy")
def mean_pass(values, first, second, target, movable, columns, repeats):
    """The three levels of the arithmetic mean without an order: a stencil, and a stencil with the mean behind it."""
    n = values.size - 2 * columns
    top = np.int64(0)
    for _ in range(repeats):
        stencil_pass(values, first, movable, columns, 1)
        here, mask, level_1 = (
            values[columns : columns + n],
            movable[columns : columns + n],
            first[columns : columns + n],
        )
        north, west = values[:n], values[columns - 1 : columns - 1 + n]
        east, south = values[columns + 1 : columns + 1 + n], values[2 * columns : 2 * columns + n]
        level_2, out = second[columns : columns + n], target[columns : columns + n]
        for k in range(n):
            old = here[k]
            new = 0.48 * ((north[k] + west[k]) + (east[k] + south[k])) - 0.92 * old
            new = new if mask[k] else old
            level_2[k] = new
            mean = 0.5 * (level_1[k] + new)
            out[k] = mean
            top = max(top, np.float64(abs(mean - old)).view(np.int64))
    return top


@njit(error_model="numpy")
def raster_pass(values, movable, repeats):
    """SOR as written: one node after the other in raster order."""
    change = 0.0
    for _ in range(repeats):
        for i in range(1, values.shape[0] - 1):
            for j in range(1, values.shape[1] - 1):
                if movable[i, j]:
                    old = values[i, j]
                    around = (values[i - 1, j] + values[i, j - 1]) + (values[i, j + 1] + values[i + 1, j])
                    new = 0.4875 * around - 0.95 * old
                    values[i, j] = new
                    change = max(change, abs(new - old))
    return change


def best_seconds(run: Callable[[], Any], repeats: int = REPEATS) -> float:
    """The least time of several runs: what the machine does when nobody disturbs it."""
    run()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return min(times)


def run() -> list[dict[str, object]]:
    """Nanoseconds a node and iteration on the floor plan, as multiples of the limit, and the direct solver."""
    free = floor_plan()
    padded = np.pad(free, 1)
    rng = np.random.default_rng(0)
    flat, mask, columns = rng.random(padded.size), padded.ravel(), padded.shape[1]
    spare = [np.zeros(padded.size) for _ in range(3)]
    passes = 20
    one = best_seconds(lambda: stencil_pass(flat, spare[0], mask, columns, passes)) / passes
    two = best_seconds(lambda: mean_pass(flat, *spare, mask, columns, passes)) / passes
    raster = rng.random(padded.shape)
    plain = best_seconds(lambda: raster_pass(raster, padded, 1))
    rows = [
        _row("limit of a sweep: the stencil without an order", one, one, free.size),
        _row("limit of AM and MAM: two of them and the mean", two, two, free.size),
        _row("SOR in raster order, node after node", plain, one, free.size),
    ]
    for method in ("gs", "sor", "red_black", "jacobi", "am", "mam"):

        def iterate(count: int, method: str = method) -> None:
            solve(free, [GOAL], method=method, tolerance=PUBLISHED_TOLERANCE, max_iterations=count)

        # The difference of two runs leaves out what is done once: checks and layout.
        short, long = best_seconds(partial(iterate, 1)), best_seconds(partial(iterate, ITERATIONS))
        limit = two if method in {"am", "mam"} else one
        rows.append(_row(method, (long - short) / (ITERATIONS - 1), limit, free.size))
    return rows + [_direct_row(name, cells, goal, plain / free.size) for name, cells, goal in direct_cases(free)]


def _row(what: str, seconds: float, limit: float, nodes: int) -> dict[str, object]:
    nanoseconds = f"{seconds / nodes * 1e9:.2f}"
    return {"what": what, "ns a node": nanoseconds, "times the limit": f"{seconds / limit:.2f}", "note": ""}


def direct_cases(free: NDArray[np.bool_]) -> list[tuple[str, NDArray[np.bool_], tuple[int, int]]]:
    """Maps that the cost law of the direct solver is fitted to."""
    squares = [(f"empty {side} × {side}", maps.empty(side, side).free, (10, 10)) for side in (100, 300, 512)]
    return [("floor plan", free, GOAL), *squares]


def _direct_row(name: str, free: NDArray[np.bool_], goal: tuple[int, int], update: float) -> dict[str, object]:
    unknowns = int(free.sum()) - 1
    spent = best_seconds(partial(solve, free, [goal], method="direct"), 3)
    updates = spent / update
    note = f"{updates / unknowns:,.0f} plain updates an unknown; the law has {direct_units(unknowns) / unknowns:,.0f}"
    return {
        "what": f"direct, {name}",
        "ns a node": f"{spent / unknowns * 1e9:,.0f}",
        "times the limit": "",
        "note": note,
    }
