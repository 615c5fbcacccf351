"""The cost of an iteration on a processor, in updates of a node.

The unit, kernel ``relaxation_node_update``, is one cell of the map passed by one sweep, occupied cells included: four
loads, three additions, a multiplication, a comparison. On the paper's machine it is 16.8 ns: 77.12 s for 51,454
iterations of Gauss-Seidel over 330 × 270 cells (Table I). The number of free cells is not published.

An iteration of AM took 2.6 times as long (the 9 rows of Table I up to ω = 1.90 agree within 2.3 %). Two sweeps are two
units by their arithmetic. The remaining 0.60 are the mean of level 3, with the test for the end and the traffic of a
third and a fourth array. That split is assumed.
"""

from __future__ import annotations

import math
from statistics import fmean

from codesign.ground.figures import Figure, Status
from codesign.planners.relaxation import published
from codesign.planners.relaxation.plan import Method

MEANS = frozenset({Method.AM, Method.MAM, Method.HALF_SWEEP_AM})
"""Methods of two levels and their mean."""

FITTED = tuple(run for run in published.AM if run.omega is not None and run.omega <= 1.90)
"""Rows that the cost of AM is fitted to. Held out: the other 13 of AM and all 63 of MAM."""

BARRIER_UNITS = 60
"""Units that one meeting of two cores takes: about 1 µs on the paper's machine. Assumed."""

SEARCH_UNITS = 2
"""Units of a step of the search: eight neighbours compared, in place of four averaged. Assumed."""

DIRECT_KERNEL = "relaxation_direct_cell"
"""The unit of a direct solution: one cell passed by a sweep in raster order as a compiled loop, node after node.

On the paper's machine this is the unit of the sweeps. Where the sweeps are vectorised it is about seven of their units,
so platforms give it a cost of its own.
"""

MAP_KERNEL = "relaxation_map_cell"
"""One cell of the map: packed and unpacked for the sweeps, and the lowest of its neighbours found for the search."""

CHECK_KERNEL = "relaxation_check_cell"
"""One cell of a check for cells without a descent. Branches that are hard to predict make it slower than an update."""

DIAGONAL_KERNEL = "relaxation_diagonal"
"""One diagonal of a sweep, besides its cells: the sweeps run over whole diagonals, which are short on small maps."""

DIRECT_COEFFICIENT, DIRECT_EXPONENT = 22.0, 1.31
"""Units of ``DIRECT_KERNEL`` of a direct solution over n unknowns: 22 n^1.31.

Measured on our machine, for empty squares of 10,000 to 260,000 cells: SciPy's SuperLU against that loop. The floor plan
takes 20 % less. ``benchmarks/bench_relaxation`` repeats it. It serves where the factors are not known.
"""

FACTOR_COEFFICIENT, FACTOR_EXPONENT, FILL_EXPONENT = 5.1, 1.28, 0.55
"""Units of ``DIRECT_KERNEL`` of a solution over n unknowns with f values in its factors: 5.1 n^1.28 (f / n)^0.55.

Mazes fill the factors with 6 values an unknown, open maps with 65. Fitted to six real maps and to empty squares
(docs/laws.md).
"""


def seconds_an_iteration(run: published.Run) -> float:
    """Seconds of one iteration of a published run."""
    return run.seconds / run.iterations


def unit() -> Figure:
    """Seconds of one unit on the paper's 3.4 GHz machine."""
    value = seconds_an_iteration(published.GS) / published.CELLS
    source = f"{published.PAPER}, Table I: 77.12 s for 51454 Gauss-Seidel iterations of 330 × 270 cells"
    return Figure(value, "s", Status.CALIBRATED, source)


def mean_units() -> Figure:
    """Units a cell and iteration of the two-level arithmetic mean, with the range of the rows it is fitted to."""
    ratios = [seconds_an_iteration(run) / seconds_an_iteration(published.GS) for run in FITTED]
    source = f"{published.PAPER}, Table I: mean of the {len(ratios)} rows of AM with ω ≤ 1.90 over the row of GS"
    return Figure(fmean(ratios), "updates", Status.CALIBRATED, source, min(ratios), max(ratios))


def sweep_units(method: Method, cells: int) -> int:
    """Units of one sweep over a map of ``cells`` cells: half of them for half sweeps.

    >>> sweep_units(Method.AM, 100), sweep_units(Method.HALF_SWEEP_AM, 101)
    (100, 51)
    """
    return -(-cells // 2) if method is Method.HALF_SWEEP_AM else cells


def level_3_units(method: Method, cells: int) -> int:
    """Units of the mean of the two levels."""
    return max(1, round((mean_units().value - 2.0) * sweep_units(method, cells)))


def diagonals(method: Method, shape: tuple[int, int], cores: int = 1) -> int:
    """Diagonals that an iteration passes over a map. Levels 2 and 3 together count as two of level 1 (measured).

    >>> diagonals(Method.GS, (10, 20)), diagonals(Method.AM, (10, 20)), diagonals(Method.AM, (10, 20), 2)
    (29, 87, 58)
    """
    if method not in MEANS:
        return sum(shape) - 1
    return (sum(shape) - 1) * (3 if cores == 1 else 2)


def direct_units(unknowns: int, factors: int = 0) -> int:
    """Units of one direct solution; ``factors``: values in its factors, 0 where they are not known."""
    if not factors:
        return max(1, math.ceil(DIRECT_COEFFICIENT * math.pow(unknowns, DIRECT_EXPONENT)))
    fill = math.pow(factors / unknowns, FILL_EXPONENT)
    return max(1, math.ceil(FACTOR_COEFFICIENT * math.pow(unknowns, FACTOR_EXPONENT) * fill))
