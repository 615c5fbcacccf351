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
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.late import late
from codesign.maps.reach import check_cells, reachable
from codesign.planners.relaxation.plan.parameters import (
    DEFAULT_BOUNDARY,
    DEFAULT_MAX_ITERATIONS,
    DEFAULT_METHOD,
    MOST_ITERATIONS,
    Boundary,
    Method,
    named,
    settle,
)

# The grid in the order of its anti-diagonals, with a ring of obstacles around it.
#
# A sweep in raster order needs the new values to the north and to the west, and the old values to the south and to the
# east. For the anti-diagonal i + j = d the new values lie on d - 1 and the old values on d + 1. So the nodes of a
# diagonal do not depend on each other. Side by side they are computed as vectors, with the arithmetic of the raster
# order. Red nodes are the even diagonals, black nodes the odd ones.


@dataclass(frozen=True, eq=False)
class Diagonals:
    """The places of nodes: node (i, j) of the padded grid lies at ``base[i + j] + i``.

    ``rows``, ``columns``: of the grid with its ring. ``base``: int64, one value a diagonal. ``position``: int64, rows ×
    columns, ``base[i + j] + i`` written out.
    """

    rows: int
    columns: int
    base: NDArray[np.int64]
    position: NDArray[np.int64]

    def pack(self, padded: NDArray[Any]) -> NDArray[Any]:
        """A padded array, rows × columns, in the order of the diagonals."""
        packed = np.empty(padded.size, padded.dtype)
        packed[self.position] = padded
        return packed


def diagonals(rows: int, columns: int) -> Diagonals:
    """The layout of a padded grid of ``rows`` × ``columns``.

    >>> diagonals(3, 3).position.tolist()
    [[0, 1, 3], [2, 4, 6], [5, 7, 8]]
    """
    number = np.arange(rows + columns - 1, dtype=np.int64)
    first_row = np.maximum(0, number - columns + 1)
    last_row = np.minimum(rows - 1, number)
    ends = np.cumsum(last_row - first_row + 1)
    base = np.concatenate([[0], ends[:-1]]).astype(np.int64) - first_row
    row, column = np.arange(rows, dtype=np.int64)[:, None], np.arange(columns, dtype=np.int64)[None, :]
    return Diagonals(rows, columns, base, base[row + column] + row)


kernels = late("codesign.planners.relaxation.plan.kernels")

PATIENCE = 1000
"""Sweeps without progress after which a run counts as stalled. Progress is a new least change near the rounding floor,
or, in a run that ends by descents, fewer cells without a descent."""

CONTINUED_PATIENCE = 100
"""The same for a run by descents that begins at the values of an earlier plan; then the run begins anew."""

FLOOR = 1e-9
"""A run can stall below this change only: far above the error of rounding (about 1e-16 / (2 − ω)), far below the first
changes of a run."""

CHECK_EVERY = 10
"""Iterations between two checks for cells without a descent."""

SETTLED = 5e-324
"""The least positive double: no change is below it but 0."""

_UPDATES_A_CALL = 1 << 26
"""Node updates of one call of a kernel: a fraction of a second, so that a run can be interrupted."""

Values = NDArray[np.float64]
Mask = NDArray[np.bool_]


class End(StrEnum):
    """The reason of the end of a run.

    ``CONVERGED``: the change is below the tolerance, or no bit changes any more; the direct solver always.
    ``DESCENDS``: every cell that can reach a goal has a lower neighbour. ``STAGNATED``: see ``PATIENCE``. ``LIMIT``:
    the bound on iterations was met.
    """

    CONVERGED = "converged"
    DESCENDS = "every cell descends"
    STAGNATED = "stagnated"
    LIMIT = "iteration limit"


@dataclass(frozen=True)
class Tally:
    """The effort of a run. ``checks``: for cells without a descent. ``change``: a share of the goal's value."""

    iterations: int
    change: float
    ended: End
    checks: int


@dataclass(frozen=True, eq=False)
class Sweeper:
    """A kernel bound to its arrays.

    ``sweep(count, ending, watch)`` does at most ``count`` iterations. ``values``, ``movable``: its nodes in its own
    order. ``size``: nodes that one iteration passes. ``packed()``: all values in the order of the diagonals.
    """

    sweep: Callable[..., Any]
    values: Values
    movable: Mask
    size: int
    packed: Callable[[], Values]


class Run:
    """The padded grid of one run.

    Args:
        free: bool, rows × columns. reachable: the free cells that a path joins to a goal. goals: int64 n × 2.
        acceleration: ω and r. tolerance: the run ends below this change; None means by descents. most: iterations.
    """

    def __init__(
        self,
        free: Mask,
        reachable: Mask,
        goals: NDArray[np.int64],
        boundary: Boundary,
        acceleration: tuple[float | None, float | None],
        tolerance: float | None,
        most: int,
    ) -> None:
        self.boundary, self.tolerance, self.most = boundary, tolerance, most
        omega, r = acceleration
        self.omega = 1.0 if omega is None else omega
        self.pair = self.omega, self.omega if r is None else r
        self.wall, goal_value = boundary.values
        self.scale = boundary.scale
        self.continued = False
        # The ring moves both coordinates by one, so that a node keeps its colour.
        self.colour = int(goals[0].sum()) % 2
        self.open: Mask = np.pad(free, 1)
        self.movable = self.open.copy()
        self.values: Values = np.full(self.movable.shape, self.wall)
        for row, column in goals + 1:
            self.movable[row, column] = False
            self.values[row, column] = goal_value
        self.judged: Mask = np.pad(reachable, 1) & self.movable
        self.nodes = int(self.movable.sum())

    @cached_property
    def layout(self) -> Diagonals:
        """The places of the nodes in the order of the diagonals."""
        rows, columns = self.values.shape
        return diagonals(rows, columns)

    def start_from(self, potential: Values) -> None:
        """Let movable nodes begin at a potential's values."""
        inner, movable = self.values[1:-1, 1:-1], self.movable[1:-1, 1:-1]
        inner[movable] = potential[movable]
        self.continued = True

    def full_sweeps(self, method: Method) -> tuple[Values, Tally, int]:
        """The potential with its ring, the tally of the run, and the number of node values computed."""
        layout, shape = self.layout, self.values.shape
        values, movable = layout.pack(self.values), layout.pack(self.movable)
        levels = 2 if method in {Method.AM, Method.MAM} else 1
        kernel: Callable[..., Any]
        if method is Method.JACOBI:
            kernel = partial(kernels.jacobi_sweeps, values, values.copy(), movable, layout.base, shape)
        elif levels == 2:
            first = values.copy()
            kernel = partial(kernels.mean_sweeps, values, first, movable, layout.base, shape, self.wall, self.pair)
        else:
            colours = 2 if method is Method.RED_BLACK else 1
            kernel = partial(kernels.in_place_sweeps, values, movable, layout.base, shape, colours, self.omega)
        tally = self._tally(Sweeper(kernel, values, movable, levels * values.size, lambda: values))
        return values[layout.position], tally, levels * self.nodes * tally.iterations

    def half_sweeps(self) -> tuple[Values, Tally, int]:
        """The same as ``full_sweeps``, over the nodes of the goals' colour; the others are filled in."""
        rows, columns = self.movable.shape
        i = np.arange(rows)[:, None]
        j = 2 * np.arange((columns + 1) // 2 + 1)[None, :] + (self.colour + i) % 2
        inside, column = j < columns, np.minimum(j, columns - 1)
        values = np.where(inside, self.values[i, column], self.wall)
        movable = np.logical_and(inside, self.movable[i, column])
        others = self.movable & ((i + np.arange(columns)[None, :]) % 2 != self.colour)

        def filled() -> Values:
            whole = self.values.copy()
            whole[np.broadcast_to(i, j.shape)[inside], j[inside]] = values[inside]
            # The mean of the four neighbours, in the kernels' order of additions.
            mean = np.zeros_like(whole)
            mean[1:-1, 1:-1] = 0.25 * ((whole[:-2, 1:-1] + whole[1:-1, :-2]) + (whole[1:-1, 2:] + whole[2:, 1:-1]))
            whole[others] = mean[others]
            return whole

        kernel = partial(
            kernels.half_sweeps, values, values.copy(), movable, columns, self.colour, self.wall, self.pair
        )
        packed = lambda: self.layout.pack(filled())  # noqa: E731
        tally = self._tally(Sweeper(kernel, values, movable, 2 * values.size, packed))
        fills = int(others.sum())
        return filled(), tally, 2 * (self.nodes - fills) * tally.iterations + fills

    def _tally(self, sweeper: Sweeper) -> Tally:
        return self._to_tolerance(sweeper) if self.tolerance is not None else self._to_descents(sweeper)

    def _to_tolerance(self, sweeper: Sweeper) -> Tally:
        """The paper's test: iterate until no value changes by the tolerance."""
        assert self.tolerance is not None
        ending = (self.tolerance * self.scale, PATIENCE, FLOOR * self.scale)
        watch = np.array([math.inf, 0.0])
        done, change, state = 0, math.inf, kernels.RUNNING
        while state == kernels.RUNNING and done < self.most:
            count = min(max(1, _UPDATES_A_CALL // sweeper.size), self.most - done)
            swept, change, state = sweeper.sweep(count, ending, watch)
            done += int(swept)
        ended = {kernels.CONVERGED: End.CONVERGED, kernels.STAGNATED: End.STAGNATED}.get(int(state), End.LIMIT)
        return Tally(done, float(change) / self.scale, ended, 0)

    def _to_descents(self, sweeper: Sweeper) -> Tally:
        """Iterate until every reachable cell has a lower neighbour, or until no progress follows."""
        ending, watch = (SETTLED, PATIENCE, FLOOR * self.scale), np.array([math.inf, 0.0])
        count_flat, continued = self._flat_counter(), self.continued
        done, change, checks = 0, 0.0, 0
        least, seen = math.inf, 0
        if continued:
            checks = 1
            if not count_flat(sweeper.packed()):
                return Tally(0, 0.0, End.DESCENDS, checks)
        while done < self.most:
            swept, change, state = sweeper.sweep(min(CHECK_EVERY, self.most - done), ending, watch)
            done, checks = done + int(swept), checks + 1
            flat = count_flat(sweeper.packed())
            if not flat:
                return Tally(done, float(change) / self.scale, End.DESCENDS, checks)
            if flat < least:
                least, seen = flat, done
            stuck = state in {kernels.CONVERGED, kernels.STAGNATED} or done - seen >= PATIENCE
            if continued and (stuck or done - seen >= CONTINUED_PATIENCE):
                # Old values may lie too deep where a passage has been closed. From zero no cell ever does.
                sweeper.values[sweeper.movable] = self.wall
                watch[:] = math.inf, 0.0
                continued, least, seen = False, math.inf, done
            elif stuck:
                ended = End.CONVERGED if state == kernels.CONVERGED else End.STAGNATED
                return Tally(done, float(change) / self.scale, ended, checks)
        return Tally(done, float(change) / self.scale, End.LIMIT, checks)

    def _flat_counter(self) -> Callable[[Values], int]:
        """A function of packed values that counts the reachable cells without a lower neighbour among the four."""
        layout, shape = self.layout, self.values.shape
        passable, judged = layout.pack(self.open), layout.pack(self.judged)
        sign = -1.0 if self.boundary.upwards else 1.0
        return lambda values: int(kernels.count_flat(values, passable, judged, layout.base, shape, sign))


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
            ``CHECK_EVERY`` iterations.
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
    chosen = named(Method, method, "method")
    settled = settle(chosen, omega, r)
    edge = named(Boundary, boundary, "boundary")
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
