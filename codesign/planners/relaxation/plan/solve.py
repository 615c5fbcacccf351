"""``solve``: the potential of a map, by sweeps until it settles, or directly.

With 0 < ω, r < 2 every method but half sweeps converges in exact arithmetic, from any start: the matrix is symmetric
and positive definite, a sweep of SOR in either direction is a contraction in its energy norm (Ostrowski and Reich), and
so is the mean of two.

With ω, r ≤ 1 a run from zero gives every cell a descent as soon as values reach it, long before it converges. By depth
(|u|, so that a goal is deepest): an iteration T without over-relaxation is monotone and T(0) ≥ 0, so depths only grow.
The values in an average are then no deeper than after the iteration. So after the iteration no cell is deeper than the
mean of its neighbours, and one of them is deeper unless all five are equal. Rounding to nearest is monotone, so doubles
keep this but for ties.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, choose_hint
from codesign.ground.late import late
from codesign.maps.reach import check_cells, reachable
from codesign.planners.relaxation.plan.parameters import (
    DEFAULT_BOUNDARY,
    DEFAULT_MAX_ITERATIONS,
    DEFAULT_METHOD,
    MOST_ITERATIONS,
    Boundary,
    Method,
    check_method,
    settle,
)
from codesign.planners.relaxation.plan.run import End, Run

sparse = late("scipy.sparse")
sparse_linalg = late("scipy.sparse.linalg")

# The potential from one sparse factorisation by SciPy.

MAX_DIRECT_CELLS = 1 << 20
"""Cells of the largest accepted map: the factors of a million unknowns hold about a gigabyte."""


def solve_direct(
    free: NDArray[np.bool_], goals: NDArray[np.int64], wall: float, goal: float
) -> tuple[NDArray[np.float64], int, int]:
    """The potential, float64 rows × columns, the number of unknowns, and of values in the factors.

    Unknowns are the free cells that a path joins to a goal. The other free cells are surrounded by obstacles, and take
    their value. The potential is ``wall`` + the solution of the case 0 and ``goal`` − ``wall``. In that case small
    values keep their leading digits, as the factorisation of such a matrix subtracts nothing.
    """
    cells = [(int(row), int(column)) for row, column in goals]
    unknown = np.pad(reachable(free, cells), 1)
    above = np.zeros(unknown.shape)
    for row, column in cells:
        unknown[row + 1, column + 1] = False
        above[row + 1, column + 1] = goal - wall
    count, values = int(unknown.sum()), 0
    if count:
        number = np.full(unknown.shape, -1, np.int32)
        number[unknown] = np.arange(count, dtype=np.int32)
        right = np.zeros(count)
        rows, columns = [np.arange(count, dtype=np.int32)], [np.arange(count, dtype=np.int32)]
        data = [np.full(count, 4.0)]
        for axis, by in ((0, 1), (0, -1), (1, 1), (1, -1)):
            beside = np.roll(number, by, axis)[unknown]
            right += np.roll(above, by, axis)[unknown]
            inner = beside >= 0
            rows.append(np.flatnonzero(inner).astype(np.int32))
            columns.append(beside[inner])
            data.append(np.full(int(inner.sum()), -1.0))
        matrix = sparse.csc_matrix(
            (np.concatenate(data), (np.concatenate(rows), np.concatenate(columns))), shape=(count, count)
        )
        factors = sparse_linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        above[unknown], values = factors.solve(right), int(factors.nnz)
    potential = wall + above[1:-1, 1:-1]
    return np.ascontiguousarray(potential), count, values


@dataclass(frozen=True, eq=False)
class Solution:
    """A potential and its run.

    Attributes:
        potential: float64, rows × columns; obstacles and goals at the values of ``boundary``.
        method, boundary: as given. omega, r: as used, None where the method has none.
        iterations: the paper's k, the last one included; 0 for the direct solver.
        change: largest change of a value in the last iteration, ‖u(k+1) − u(k)‖∞, as a share of the goal's value.
        ended: why the run ended. ``planner.quality`` says whether each cell leads to a goal.
        updates: node values computed: one an iteration and node, two for the arithmetic means; half the nodes for half
            sweeps, and the other half once at the end.
        checks: checks for cells without a descent; 0 in a run to a tolerance.
        factors: values in the sparse factors of the direct solver; 0 for sweeps.
    """

    potential: NDArray[np.float64]
    method: Method
    boundary: Boundary
    omega: float | None
    r: float | None
    iterations: int
    change: float
    ended: End
    updates: int
    checks: int = 0
    factors: int = 0

    @property
    def converged(self) -> bool:
        """True if the change is below the tolerance, or no bit changes any more."""
        return self.ended is End.CONVERGED

    @property
    def stagnated(self) -> bool:
        """True if rounding keeps the run from its end."""
        return self.ended is End.STAGNATED


def solve(
    free: NDArray[np.bool_],
    goals: Sequence[tuple[int, int]],
    *,
    method: Method | str = DEFAULT_METHOD,
    omega: float | None = None,
    r: float | None = None,
    tolerance: float | None = None,
    boundary: Boundary | str = DEFAULT_BOUNDARY,
    max_iterations: int = DEFAULT_MAX_ITERATIONS,
    start: NDArray[np.float64] | None = None,
) -> Solution:
    """Solve Laplace's equation on the free cells of a map (Saudi and Sulaiman 2016, equations 3 to 13).

    The sweeps start from the value of obstacles in all free cells, or from ``start``, and run in raster order (level 2
    of the arithmetic means: backwards).

    Args:
        free: bool, rows × columns, at most 2**24 cells. Obstacles surround the map.
        goals: (row, column) pairs on free cells.
        method: ``gs``, ``sor``, ``am``, ``mam``, ``red_black``, ``jacobi``, ``half_sweep_am``, ``direct``.
        omega: over-relaxation, 0 < ω < 2; None means 1.
        r: the relaxation factor of the second level of ``mam``.
        tolerance: the run ends once no value changes by this share of the goal's in one iteration (the paper: 1e-15).
            None ends it once each cell that can reach a goal has a lower one among its four neighbours, checked every
            ``run.CHECK_EVERY`` iterations.
        boundary: ``deep_goal`` (obstacles 0, goals −2^1000), ``low_goal`` (0, −1), ``high_walls`` (1, 0),
            ``high_goal`` (0, 1).
        max_iterations: the run ends there at the latest.
        start: float64, rows × columns, the first values of free cells, such as the potential of an earlier run with the
            same ``boundary``; the direct solver does not use it. A run by descents begins anew from obstacles' value
            where ``start`` keeps cells from their descent.

    Raises:
        MapError: the map or a goal cannot be used. InputError: another argument cannot be used, or the map does not
            suit the method (half sweeps: goals of both colours; direct: too many cells).
    """
    cells = check_cells(free, goals)
    # The inputs of Algorithm 1: ω and r (equations 12 and 13), boundary values (equation 2), ε.
    chosen = check_method(method)
    settled = settle(chosen, omega, r)
    edge = _boundary(boundary)
    least = None if tolerance is None else _tolerance(tolerance)
    most = _iterations(max_iterations)
    pairs = [(int(i), int(j)) for i, j in cells]
    if (reason := refusal(chosen, free.shape, pairs)) is not None:
        raise InputError(reason, "method", "choose another method")
    if chosen is Method.DIRECT:
        potential, unknowns, factors = solve_direct(free, cells, *edge.values)
        return Solution(potential, chosen, edge, None, None, 0, 0.0, End.CONVERGED, unknowns, factors=factors)
    # Obstacles separate some cells from every goal. The run does not check these cells for a descent.
    run = Run(free, reachable(free, pairs), cells, edge, settled, least, most)
    if start is not None:
        run.start_from(_start(start, free))
    return _relaxed(run, chosen, settled)


def _relaxed(run: Run, method: Method, settled: tuple[float | None, float | None]) -> Solution:
    """The solution that the sweeps of ``method`` end in; ``settled``: ω and r."""
    half = method is Method.HALF_SWEEP_AM
    padded, tally, updates = run.half_sweeps() if half else run.full_sweeps(method)
    return Solution(
        # Without the ring of obstacles around the map.
        potential=np.ascontiguousarray(padded[1:-1, 1:-1]),
        method=method,
        boundary=run.boundary,
        omega=settled[0],
        r=settled[1],
        iterations=tally.iterations,
        change=tally.change,
        ended=tally.ended,
        updates=updates,
        checks=tally.checks,
    )


def refusal(method: Method, shape: tuple[int, ...], goals: Sequence[tuple[int, int]]) -> str | None:
    """The reason why ``method`` cannot be used on such a map, or None."""
    if method is Method.DIRECT and math.prod(shape) > MAX_DIRECT_CELLS:
        size = " × ".join(str(side) for side in shape)
        return f"{size} cells are more than the {MAX_DIRECT_CELLS:,} that the direct solver takes"
    if method is Method.HALF_SWEEP_AM and len({sum(goal) % 2 for goal in goals}) > 1:
        return "half sweeps see goals of one colour only (row + column even, or odd), and both are given"
    return None


def _boundary(value: Boundary | str) -> Boundary:
    try:
        return Boundary(value)
    except ValueError:
        hint = choose_hint(str(value), list(Boundary))
        raise InputError(f"boundary {value!r:.80} is unknown", "boundary", hint) from None


def _start(value: NDArray[np.float64], free: NDArray[np.bool_]) -> NDArray[np.float64]:
    array = np.asarray(value)
    if array.shape != free.shape or array.dtype != np.float64 or not np.isfinite(array).all():
        what = f"a start of {array.dtype} {array.shape} for a map of {free.shape}"
        raise InputError(what, "start", "give finite doubles, such as the potential of an earlier run")
    return array


def _tolerance(value: float) -> float:
    number = not isinstance(value, bool) and isinstance(value, int | float)
    if not (number and math.isfinite(value) and 0.0 < value <= 1.0):
        raise InputError(
            f"a tolerance of {value!r:.80}", "tolerance", "give a number above 0, at most 1; 1e-15 is usual"
        )
    return float(value)


def _iterations(value: int) -> int:
    try:
        count = operator.index(value)
    except TypeError:
        count = 0
    if isinstance(value, bool) or not 1 <= count <= MOST_ITERATIONS:
        raise InputError(
            f"{value!r:.80} iterations", "max_iterations", f"give a whole number from 1 to {MOST_ITERATIONS:,}"
        )
    return count
