"""Exact bounds on a converged field at any precision, from a sparse direct solve in doubles.

Write L for the least fixed point of the integer update h = floor((N + E + S + W) / 4) at precision p, with
goals 2^p, and u for the solution in real numbers, with goals 1. Work at precision P = p + g, with g guard
bits.

**Lower certificate.** Let x ≥ 0 be integers with, at every free cell that is no goal, x = 0 or
4·x ≤ Σx' − 3·2^g, where Σ runs over the four neighbours, goals are 2^P and obstacles 0. Then x ≤ L·2^g.
Proof: floor loses at most 3/4, so 4·L ≥ ΣL' − 3. Let y = L·2^g − x. Where x = 0, y ≥ 0. On the rest 4·y ≥
Σy': y is superharmonic there and not negative around it, so by the minimum principle y ≥ 0 (each finite
set of cells has a boundary, as outside of the map is obstacle). L is whole, so ceil(x / 2^g) ≤ L.

**Upper certificate.** If 4·x ≥ Σx' at every such cell then x ≥ u·2^P by the same principle, and u·2^p ≥ L as
4·L ≤ ΣL', so L ≤ floor(x / 2^g).

Both are checked in exact integers, cell by cell, so nothing depends on the rounding of the solver. The
candidates come from iterative refinement: exact integer residual, correction by the LU factors in doubles,
some 40 bits a round. With w the solution of w = avg(w) + 1, they are u·2^P − ¾·2^g·w and u·2^P, each moved
by a small multiple of w to the safe side; the guard bits keep that, and the rounding of x, far below one
unit of L.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.maps.reach import reachable
from codesign.planners.harmonic.plan.fixed_point import Field, LowerBound
from codesign.planners.harmonic.plan.parameters import MAX_PRECISION
from codesign.planners.harmonic.plan.trajectory import goal_mask

GUARD_BITS = 16
RESIDUAL_AT_MOST = 1 << (GUARD_BITS - 7)
"""Refinement stops here, in units of 2^-P; rounding alone leaves a residual of up to 4."""
SLACKS = tuple(RESIDUAL_AT_MOST << bits for bits in range(2, 34, 4))
"""A candidate is moved by these multiples of w/4 in turn, until its certificate holds. The first one suffices unless
the solver is far off. After the last the bound is 0 or 2^p, which need no certificate."""
MAX_UNKNOWNS = 1 << 20
"""Larger systems are refused: an empty map of that many cells took 9 s and 1.8 GB to factorise (measured)."""

_to_integers = np.frompyfunc(int, 1, 1)


class FieldBounds:
    """Bounds on the converged field of one map. The factors are kept, so a further precision is cheap.

    Args:
        free: bool, rows × columns.
        goals: (row, column) pairs on free cells.

    Raises:
        MapError: the map or a goal is unusable. InputError: more than ``MAX_UNKNOWNS`` reachable cells.
    """

    def __init__(self, free: NDArray[np.bool_], goals: Sequence[tuple[int, int]]) -> None:
        self._goal = goal_mask(free, goals)
        self._cells = np.flatnonzero(reachable(free, goals) & ~self._goal)
        self._shape = free.shape
        count = self._cells.size
        if count > MAX_UNKNOWNS:
            what = f"{count} reachable cells are too many for a direct solve (at most {MAX_UNKNOWNS})"
            raise InputError(what, "free", "start from zero instead")
        self._neighbours = _neighbour_indices(self._goal, self._cells)
        self._precision = GUARD_BITS
        self._values: NDArray[Any] = np.zeros(count, object)
        self._solve: Any = _factorise(self._neighbours) if count else np.copy
        self._noise: NDArray[np.float64] = self._solve(np.full(count, 4.0))

    @property
    def cells(self) -> NDArray[np.int64]:
        """The computed cells that a path leads from to a goal: their indices in the flat map."""
        return self._cells

    @property
    def average(self) -> Any:
        """The average over the four neighbours as a sparse matrix over ``cells``; goals and obstacles are 0."""
        from scipy.sparse import coo_array

        count = len(self._cells)
        side, cell = np.nonzero(self._neighbours < count)
        entries = np.full(cell.size, 0.25), (cell, self._neighbours[side, cell])
        return coo_array(entries, shape=(count, count)).tocsr()

    @property
    def noise(self) -> NDArray[np.float64]:
        """w of the module's docstring, in doubles."""
        return self._noise

    def solve(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """x with 4·x - Σx' = ``values``, in doubles."""
        solution: NDArray[np.float64] = self._solve(values)
        return solution

    def lower(self, precision: int) -> LowerBound:
        """A field nowhere above the converged one, most often within ¾·w + 1 units of it.

        Raises:
            InputError: precision outside of 1..1023.
        """
        values = self._refined(precision)
        loss = 3 << GUARD_BITS
        for slack in SLACKS:
            candidate = np.maximum(values - self._multiple_of_noise(loss + slack), 0)
            rises = self._residual(candidate, precision + GUARD_BITS) >= loss
            if (rises | (candidate == 0)).all():
                return LowerBound.from_ints(self._whole(-((-candidate) >> GUARD_BITS), precision), precision)
        return LowerBound.from_ints(self._whole(0, precision), precision)

    def upper(self, precision: int) -> Field:
        """A field nowhere below the converged one: the real solution rounded down, most often.

        Raises:
            InputError: precision outside of 1..1023.
        """
        values = self._refined(precision)
        for slack in SLACKS:
            candidate = np.maximum(values + self._multiple_of_noise(slack), 0)
            if (self._residual(candidate, precision + GUARD_BITS) <= 0).all():
                values = np.minimum(candidate >> GUARD_BITS, 1 << precision)
                return Field.from_ints(self._whole(values, precision), precision)
        return Field.from_ints(self._whole(1 << precision, precision), precision)

    def _refined(self, precision: int) -> NDArray[Any]:
        """Values at ``precision`` + guard bits, refined until the exact residual stays at rounding level."""
        if not 1 <= precision <= MAX_PRECISION:
            raise InputError(f"precision {precision} is outside 1..{MAX_PRECISION} bits", "precision")
        wanted = precision + GUARD_BITS
        if wanted < self._precision:
            return np.asarray(self._values >> (self._precision - wanted))
        self._values = self._values << (wanted - self._precision)
        self._precision = wanted
        worst = None
        while self._cells.size:
            residual = self._residual(self._values, wanted)
            size = max(abs(residual.max()), abs(residual.min()))
            if size <= RESIDUAL_AT_MOST or (worst is not None and size >= worst):
                break
            worst = size
            # Doubles end at 2^1024: larger residuals are solved for in coarser units.
            shift = max(size.bit_length() - 900, 0)
            correction = self._solve((residual >> shift).astype(np.float64))
            self._values = self._values + (_to_integers(np.rint(correction)) << shift)
        return self._values

    def _residual(self, values: NDArray[Any], precision: int) -> NDArray[Any]:
        around = np.append(values, np.array([0, 1 << precision], object))[self._neighbours]
        return np.asarray(around[0] + around[1] + around[2] + around[3] - 4 * values)

    def _multiple_of_noise(self, quarters: int) -> NDArray[Any]:
        return np.asarray(_to_integers(np.ceil(self._noise * (quarters / 4.0))))

    def _whole(self, values: NDArray[Any] | int, precision: int) -> NDArray[Any]:
        whole = np.zeros(self._shape, object)
        whole[self._goal] = 1 << precision
        whole.ravel()[self._cells] = values
        return whole


def warm_start(free: NDArray[np.bool_], goals: Sequence[tuple[int, int]], precision: int) -> LowerBound:
    """A start nowhere above the converged field: relaxing from it gives the same bits as from zero, sooner.

    Raises:
        MapError: the map or a goal is unusable.
        InputError: precision outside of 1..1023, or a map too large.
    """
    return FieldBounds(free, goals).lower(precision)


def _neighbour_indices(goal: NDArray[np.bool_], cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Int64 4 × unknowns: index of each neighbour among the unknowns; the next index is for 0, the last for a goal."""
    index = np.full(goal.shape, cells.size, np.int64)
    index.ravel()[cells] = np.arange(cells.size)
    index[goal] = cells.size + 1
    padded = np.pad(index, 1, constant_values=cells.size)
    sides = (padded[:-2, 1:-1], padded[1:-1, 2:], padded[2:, 1:-1], padded[1:-1, :-2])
    return np.stack([side.ravel()[cells] for side in sides])


def _factorise(neighbours: NDArray[np.int64]) -> Any:
    """The solver of 4·x − Σx' = right-hand side over the unknowns, by sparse LU in doubles."""
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import splu

    count = neighbours.shape[1]
    side, cell = np.nonzero(neighbours < count)
    rows = np.concatenate([np.arange(count), cell])
    columns = np.concatenate([np.arange(count), neighbours[side, cell]])
    entries = np.concatenate([np.full(count, 4.0), np.full(cell.size, -1.0)])
    matrix = coo_array((entries, (rows, columns)), shape=(count, count)).tocsc()
    # Symmetric and diagonally dominant: no pivoting is needed, and this ordering keeps the factors sparse.
    options = {"SymmetricMode": True}
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).solve
