"""The number of bits with which the converged field of a map leads to a goal from everywhere (3.2.2, Figure 3).

More precision may do harm: on an empty 5 × 3 map with goals at (1, 0) and (3, 2), 3 bits suffice, 4 leave a local
maximum, and from 5 on none is left. This is rare: 2 of 51,525 random maps of up to 9 × 9 cells, none of 17,000
larger ones. So precisions are tried one by one. Two exact bounds frame the search, and only the precisions between
them are relaxed, from warm starts: at most 11 precisions on all those maps.

- Below ``first_candidate`` some cell and its neighbours are certainly all 0: L_p ≤ u·2^p < 1.
- From ``certified`` on there is no local maximum at any precision. If at p every cell c has a neighbour n
  with lower(n) > upper(c), then at any q = p + k: L_q(n) ≥ 2^k·L_p(n) ≥ 2^k·lower(n), as a finer floor is
  never lower, and L_q(c) ≤ u(c)·2^q < 2^k·(upper(c) + 1) ≤ 2^k·lower(n), as u(c)·2^p < upper(c) + 1.

A few maps have no such precision: the real solution itself may be level at a cell. On a 3 × 3 map with goals at
(0, 0) and (2, 2) and obstacles at (0, 2) and (2, 0), it is 1/3 at (1, 1) and at all its four neighbours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.maps.reach import reachable
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.parameters import MAX_PRECISION
from codesign.planners.harmonic.plan.relax import relax
from codesign.planners.harmonic.plan.trajectory import goal_mask
from codesign.planners.harmonic.plan.warm_start import FieldBounds

WHOLE_MAP_ITERATIONS = 1 << 16
TRIES = 64


@dataclass(frozen=True)
class RequiredPrecision:
    """The precision that a map requires.

    Attributes:
        least: least p with no local maximum of the converged field among the reachable cells; None where the search up
            to ``limit``, or within ``tries`` relaxations, has no such p.
        certified: a precision from which on every p suffices, proved by bounds; None where it is above ``limit``.
        first_candidate: below it no precision suffices, proved by bounds.
        local_maxima: count of local maxima at each precision that was relaxed.
        limit: greatest precision considered.
    """

    least: int | None
    certified: int | None
    first_candidate: int
    local_maxima: Mapping[int, int]
    limit: int

    @property
    def relapses(self) -> tuple[int, ...]:
        """Relaxed precisions above ``least`` that have local maxima again (complete after a survey)."""
        if self.least is None:
            return ()
        return tuple(p for p, count in self.local_maxima.items() if p > self.least and count)


def required_precision(
    free: NDArray[np.bool_],
    goals: Sequence[tuple[int, int]],
    *,
    limit: int = MAX_PRECISION,
    survey: bool = False,
    tries: int = TRIES,
) -> RequiredPrecision:
    """The least precision without local maxima, exactly; with ``survey``, all precisions up to ``certified``.

    Args:
        free: bool, rows × columns.
        goals: (row, column) pairs on free cells.
        limit: greatest precision considered, 1..1023.
        survey: go on after the least precision, to see where precision does harm.
        tries: most precisions relaxed.

    Raises:
        MapError: the map or a goal is unusable.
        InputError: ``limit`` or ``tries`` is unusable, or the map is too large to solve.
    """
    if not 1 <= limit <= MAX_PRECISION:
        raise InputError(f"limit {limit} is outside 1..{MAX_PRECISION} bits", "limit")
    if tries < 1:
        raise InputError(f"{tries} tries are fewer than 1", "tries")
    search = _Search(free, goals)
    first = search.first_candidate(limit)
    certified = search.certified(first, limit)
    least = None
    counts: dict[int, int] = {}
    for precision in range(first, limit + 1):
        if certified is not None and precision >= certified:
            least = certified if least is None else least
            break
        if len(counts) == tries:
            break
        counts[precision] = search.count_local_maxima(precision)
        if counts[precision] == 0:
            least = precision if least is None else least
            if not survey:
                break
    return RequiredPrecision(least, certified, first, counts, limit)


def converged_field(
    free: NDArray[np.bool_], goals: Sequence[tuple[int, int]], precision: int, *, bounds: FieldBounds | None = None
) -> Field:
    """The converged field L_p, computed fast on a host: relaxed from a warm start, the map as one block.

    Args:
        free: bool, rows × columns.
        goals: (row, column) pairs on free cells.
        precision: bits.
        bounds: of the same map and goals, for several precisions of one map; None means computed here.
    """
    start = (bounds or FieldBounds(free, goals)).lower(precision)
    rows, columns = free.shape
    return relax(
        free,
        goals,
        block=(rows, columns),
        iterations=WHOLE_MAP_ITERATIONS,
        schedule=[precision],
        start=start,
        record_visits=False,
    ).field


class _Search:
    def __init__(self, free: NDArray[np.bool_], goals: Sequence[tuple[int, int]]) -> None:
        self.free, self.goals = free, goals
        self.bounds = FieldBounds(free, goals)
        self.cells = reachable(free, goals) & ~goal_mask(free, goals)

    def first_candidate(self, limit: int) -> int:
        """Least precision at which no reachable cell has neighbours that are all certainly 0."""
        if not self.cells.any():
            return 1
        precision = min(64, limit)
        while True:
            highest = _highest_neighbour(self.bounds.upper(precision).to_ints())[self.cells]
            least = int(highest.min())
            if least > 0 or precision == limit:
                # Bits below the leading one of that neighbour are not needed for it to be above 0.
                return max(precision - least.bit_length() + 1, 1)
            precision = min(2 * precision, limit)

    def certified(self, first: int, limit: int) -> int | None:
        """The least precision that passes the test of the module's docstring, by doubling and bisection."""
        below, above = first - 1, first
        while not self._surely_rises(min(above, limit)):
            if above >= limit:
                return None
            below, above = above, above + 2 * (above - below)
        above = min(above, limit)
        while above - below > 1:
            middle = (below + above) // 2
            if self._surely_rises(middle):
                above = middle
            else:
                below = middle
        return above

    def _surely_rises(self, precision: int) -> bool:
        upper = self.bounds.upper(precision).to_ints()
        highest = _highest_neighbour(self.bounds.lower(precision).to_ints())
        return bool((highest > upper)[self.cells].all())

    def count_local_maxima(self, precision: int) -> int:
        values = converged_field(self.free, self.goals, precision, bounds=self.bounds).to_ints()
        return int((_highest_neighbour(values) <= values)[self.cells].sum())


def _highest_neighbour(values: NDArray[Any]) -> NDArray[Any]:
    # Not np.pad: it would put int64 zeros among the Python integers, and those overflow.
    padded = np.zeros((values.shape[0] + 2, values.shape[1] + 2), object)
    padded[1:-1, 1:-1] = values
    sides = (padded[:-2, 1:-1], padded[1:-1, 2:], padded[2:, 1:-1], padded[1:-1, :-2])
    return np.asarray(np.maximum.reduce(sides))
