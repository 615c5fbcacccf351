"""One run of sweeps over a map: its grid, its loop over a kernel, and the tests that end it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.planners.relaxation.plan.layout import Diagonals, diagonals
from codesign.planners.relaxation.plan.parameters import Boundary, Method

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
