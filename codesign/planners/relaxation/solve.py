"""``solve``: the potential of a map, by sweeps until it settles, or directly."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import InputError, choose_hint
from codesign.planners.relaxation.parameters import (
    DEFAULT_MAX_ITERATIONS,
    DEFAULT_TOLERANCE,
    MOST_ITERATIONS,
    Boundary,
    Method,
    check_method,
    settle,
)

PATIENCE = 1000
"""Sweeps without a new least change after which a run near the rounding floor counts as stalled."""

FLOOR = 1e-9
"""A stall is looked for below this change only: far above what rounding leaves (1e-16 / (2 − ω) or so), far below what
a run begins with."""

_UPDATES_A_CALL = 1 << 26
"""Node updates of one call of a kernel: a fraction of a second, so that a run can be interrupted."""


@dataclass(frozen=True, eq=False)
class Solution:
    """A potential and how it came about.

    Attributes:
        potential: float64, rows × columns; obstacles and goals at the values of ``boundary``.
        method, boundary: as asked for. omega, r: as taken, None where the method has none.
        iterations: the paper's k, the last one included; 0 for the direct solver.
        change: largest change of a value in the last iteration, ‖u(k+1) − u(k)‖∞.
        converged: that change is below the tolerance (the direct solver: always).
        stagnated: rounding keeps the change above the tolerance: no new least change in ``PATIENCE`` iterations.
            Where neither holds, the bound on iterations was met.
        updates: node values computed: one an iteration and node, two for the arithmetic means; half the nodes for half
            sweeps, whose other half is filled in once at the end.
    """

    potential: NDArray[np.float64]
    method: Method
    boundary: Boundary
    omega: float | None
    r: float | None
    iterations: int
    change: float
    converged: bool
    stagnated: bool
    updates: int


def solve(
    free: NDArray[np.bool_],
    goals: Sequence[tuple[int, int]],
    *,
    method: Method | str = Method.SOR,
    omega: float | None = None,
    r: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    boundary: Boundary | str = Boundary.LOW_GOAL,
    max_iterations: int = DEFAULT_MAX_ITERATIONS,
    start: NDArray[np.float64] | None = None,
) -> Solution:
    """Solve Laplace's equation on the free cells of a map (Saudi and Sulaiman 2016, equations 3 to 13).

    The sweeps start from the value of obstacles in all free cells, or from ``start``, and go in raster order (level 2
    of the arithmetic means: backwards). With 0 < ω, r < 2 every method but half sweeps converges in exact arithmetic,
    from any start: the matrix is symmetric and positive definite, a sweep of SOR either way is a contraction in its
    energy norm (Ostrowski and Reich), and so is the mean of two. In doubles an over-relaxed run may stall above the
    tolerance: see ``stagnated``.

    Args:
        free: bool, rows × columns, at most 2**24 cells; outside of the map is obstacle.
        goals: (row, column) pairs on free cells.
        method: ``gs``, ``sor``, ``am``, ``mam``, ``red_black``, ``jacobi``, ``half_sweep_am``, ``direct``.
        omega: over-relaxation, 0 < ω < 2; None takes the method's own (``parameters.ACCELERATION``).
        r: that of the second level of ``mam``.
        tolerance: the run ends once no value changes by as much in one iteration.
        boundary: ``low_goal`` (obstacles 0, goals −1), ``high_walls`` (1, 0), ``high_goal`` (0, 1).
        max_iterations: the run ends there at the latest.
        start: float64, rows × columns, what free cells start from, such as the potential of an earlier run with the
            same ``boundary``; the direct solver has no use for it.

    Raises:
        MapError: the map or a goal cannot be used. InputError: another argument cannot be used, or the map does not
            suit the method (half sweeps: goals of both colours; direct: too many cells).
    """
    from codesign.maps.reach import check_cells

    cells = check_cells(free, goals)
    chosen = check_method(method)
    settled = settle(chosen, omega, r)
    edge = _boundary(boundary)
    least = _tolerance(tolerance)
    most = _iterations(max_iterations)
    if (reason := refusal(chosen, free.shape, [(int(i), int(j)) for i, j in cells])) is not None:
        raise InputError(reason, "method", "choose another method")
    if chosen is Method.DIRECT:
        from codesign.planners.relaxation.direct import solve_direct

        potential, unknowns = solve_direct(free, cells, *edge.values)
        return Solution(potential, chosen, edge, None, None, 0, 0.0, True, False, unknowns)
    run = _Run(free, cells, edge, settled, least, most)
    if start is not None:
        run.start_from(_start(start, free))
    return run.half_sweeps() if chosen is Method.HALF_SWEEP_AM else run.full_sweeps(chosen)


def refusal(method: Method, shape: tuple[int, ...], goals: Sequence[tuple[int, int]]) -> str | None:
    """Why ``method`` cannot be used on such a map, or None."""
    from codesign.planners.relaxation.direct import MAX_DIRECT_CELLS

    if method is Method.DIRECT and math.prod(shape) > MAX_DIRECT_CELLS:
        size = " × ".join(str(side) for side in shape)
        return f"{size} cells are more than the {MAX_DIRECT_CELLS:,} that the direct solver takes"
    if method is Method.HALF_SWEEP_AM and len({sum(goal) % 2 for goal in goals}) > 1:
        return "half sweeps see goals of one colour only (row + column even, or odd), and both are given"
    return None


class _Run:
    """The padded grid of one run, and the loop over calls of a kernel."""

    def __init__(
        self,
        free: NDArray[np.bool_],
        goals: NDArray[np.int64],
        boundary: Boundary,
        acceleration: tuple[float | None, float | None],
        tolerance: float,
        most: int,
    ) -> None:
        self.boundary, self.acceleration = boundary, acceleration
        self.tolerance, self.most = tolerance, most
        omega, r = acceleration
        self.omega = 1.0 if omega is None else omega
        self.pair = self.omega, self.omega if r is None else r
        self.wall, goal_value = boundary.values
        # The ring moves both coordinates by one, so that a node keeps its colour.
        self.colour = int(goals[0].sum()) % 2
        self.movable: NDArray[np.bool_] = np.pad(free, 1)
        self.values = np.full(self.movable.shape, self.wall)
        for row, column in goals + 1:
            self.movable[row, column] = False
            self.values[row, column] = goal_value
        self.nodes = int(self.movable.sum())

    def start_from(self, potential: NDArray[np.float64]) -> None:
        """Let movable nodes begin at a potential's values."""
        inner, movable = self.values[1:-1, 1:-1], self.movable[1:-1, 1:-1]
        inner[movable] = potential[movable]

    def full_sweeps(self, method: Method) -> Solution:
        from codesign.planners.relaxation import kernels
        from codesign.planners.relaxation.layout import diagonals

        shape: Any = self.values.shape
        layout = diagonals(*shape)
        values, movable = layout.pack(self.values), layout.pack(self.movable)
        levels = 2 if method in {Method.AM, Method.MAM} else 1
        kernel: Callable[..., Any]
        if method is Method.JACOBI:
            kernel = partial(kernels.jacobi_sweeps, values, values.copy(), movable, layout.base, shape)
        elif levels == 2:
            first = values.copy()
            kernel = partial(
                kernels.mean_sweeps, values, first, movable, layout.base, shape, self.wall, self.pair
            )
        else:
            colours = 2 if method is Method.RED_BLACK else 1
            kernel = partial(
                kernels.in_place_sweeps, values, movable, layout.base, shape, colours, self.omega
            )
        state = self._loop(kernel, levels * values.size)
        return self._solution(method, values[layout.position], state, levels * self.nodes * state[0])

    def half_sweeps(self) -> Solution:
        from codesign.planners.relaxation import kernels

        rows, columns = self.movable.shape
        i = np.arange(rows)[:, None]
        j = 2 * np.arange((columns + 1) // 2 + 1)[None, :] + (self.colour + i) % 2
        inside, column = j < columns, np.minimum(j, columns - 1)
        values = np.where(inside, self.values[i, column], self.wall)
        movable = np.logical_and(inside, self.movable[i, column])
        kernel = partial(
            kernels.half_sweeps, values, values.copy(), movable, columns, self.colour, self.wall, self.pair
        )
        state = self._loop(kernel, 2 * values.size)
        whole = self.values.copy()
        whole[np.broadcast_to(i, j.shape)[inside], j[inside]] = values[inside]
        others = self.movable & ((i + np.arange(columns)[None, :]) % 2 != self.colour)
        mean = np.zeros_like(whole)
        mean[1:-1, 1:-1] = 0.25 * (
            (whole[:-2, 1:-1] + whole[1:-1, :-2]) + (whole[1:-1, 2:] + whole[2:, 1:-1])
        )
        whole[others] = mean[others]
        filled = int(others.sum())
        updates = 2 * (self.nodes - filled) * state[0] + filled
        return self._solution(Method.HALF_SWEEP_AM, whole, state, updates)

    def _loop(self, kernel: Callable[..., Any], size: int) -> tuple[int, float, int]:
        """Call ``kernel`` until it is over; returns iterations, last change, and how it stands."""
        from codesign.planners.relaxation.kernels import RUNNING

        watch = np.array([math.inf, 0.0])
        ending = (self.tolerance, PATIENCE, FLOOR)
        done, change, state = 0, math.inf, RUNNING
        while state == RUNNING and done < self.most:
            count = min(max(1, _UPDATES_A_CALL // size), self.most - done)
            swept, change, state = kernel(count, ending, watch)
            done += int(swept)
        return done, float(change), int(state)

    def _solution(
        self, method: Method, padded: NDArray[np.float64], state: tuple[int, float, int], updates: int
    ) -> Solution:
        from codesign.planners.relaxation.kernels import CONVERGED, STAGNATED

        omega, r = self.acceleration
        return Solution(
            potential=np.ascontiguousarray(padded[1:-1, 1:-1]),
            method=method,
            boundary=self.boundary,
            omega=omega,
            r=r,
            iterations=state[0],
            change=state[1],
            converged=state[2] == CONVERGED,
            stagnated=state[2] == STAGNATED,
            updates=updates,
        )


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
            f"{value!r:.80} iterations",
            "max_iterations",
            f"give a whole number from 1 to {MOST_ITERATIONS:,}",
        )
    return count
