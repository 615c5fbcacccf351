"""Figures 3 to 6 of Girau et al. (2008) drawn again from generated maps.

The environments of the paper's Figure 2 are not published as data. An empty room, rooms with doors, a maze and a spiral
replace them. So the shape of a curve can be compared with the words of the paper, but its numbers cannot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from statistics import fmean, median, pstdev

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.planners.harmonic.plan import HarmonicPlan, relax
from codesign.planners.harmonic.plan.precision import required_precision
from codesign.planners.papers import curves
from codesign.planners.reproduction import Progress, Series

STABILISATION_PRECISION = 128
"""Bits at which Figure 4 counts iterations; the paper does not say."""

LABYRINTH_SIDE = 60
LABYRINTH_SEEDS = (1, 2, 3)
LABYRINTH_PRECISION = 48
BLOCKS_A_SIDE = (1, 2, 3, 4, 5, 6)
CONSECUTIVE = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 64, 128, 256)
WHOLE_MAP_ITERATIONS = 1 << 20
STILL_ITERATIONS = 12
"""I of Figure 6; the paper does not say."""
BINS = 40


@dataclass(frozen=True, eq=False)
class Environment:
    """One environment at one magnification, with its goal in the top left corner."""

    name: str
    free: NDArray[np.bool_]
    goal: tuple[int, int]

    @property
    def nodes(self) -> int:
        """Nodes of the grid, obstacles counted, as in the paper."""
        return self.free.size

    @property
    def farthest(self) -> int:
        """The paper's L: the largest distance to the goal, in steps."""
        return int(maps.distance_steps(self.free, [self.goal]).max())


def environments(magnification: int) -> tuple[Environment, ...]:
    """The four environments with every cell made ``magnification`` × ``magnification`` cells."""
    bases = {
        "empty": maps.empty(12, 12),
        "rooms": maps.rooms(17, 17, room=(5, 5), door=1, seed=3),
        "maze": maps.maze(13, 13, seed=5),
        "spiral": maps.spiral(9, 9),
    }
    cell = np.ones((magnification, magnification), np.bool_)
    return tuple(
        Environment(name, free, _corner(free))
        for name, free in ((name, np.kron(grid.free, cell)) for name, grid in bases.items())
    )


def _corner(free: NDArray[np.bool_]) -> tuple[int, int]:
    goal = maps.nearest_free(free, (0, 0))
    assert goal is not None, "every environment has free cells"
    return goal


@cache
def labyrinth(seed: int) -> Environment:
    """A labyrinth for Figures 5 and 6: 60 × 60 parts into 1 to 6 blocks a side without remainder."""
    free = maps.maze(LABYRINTH_SIDE, LABYRINTH_SIDE, corridor=4, wall=1, seed=seed).free
    return Environment("labyrinth", free, _corner(free))


def _relaxed(
    place: Environment, precision: int, side: int, iterations: int, termination: str, visits: bool = False
) -> HarmonicPlan:
    """The labyrinth or an environment in ``side`` × ``side`` blocks, at one precision from zero."""
    rows, columns = (-(-length // side) for length in place.free.shape)
    return relax(
        place.free,
        [place.goal],
        block=(rows, columns),
        iterations=iterations,
        schedule=[precision],
        termination=termination,
        record_visits=visits,
    )


def slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Slope of the least-squares line."""
    mean_x, mean_y = fmean(x), fmean(y)
    above = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True))
    return above / sum((a - mean_x) ** 2 for a in x)


def required_bits(magnifications: Sequence[int], progress: Progress) -> list[Series]:
    """Figure 3: bits required against the largest distance to the goal, each environment magnified."""
    points = []
    for magnification in magnifications:
        progress(f"Figure 3: required precision at magnification {magnification}")
        for place in environments(magnification):
            bits = required_precision(place.free, [place.goal]).least
            if bits is not None:
                points.append((place.name, (place.farthest, bits)))
    return curves(points)


def iterations_to_stability(magnifications: Sequence[int], progress: Progress) -> list[Series]:
    """Figure 4: synchronous iterations until no bit changes against nodes, each environment magnified."""
    points = []
    for magnification in magnifications:
        progress(f"Figure 4: iterations to stabilise at magnification {magnification}")
        for place in environments(magnification):
            result = _relaxed(place, STABILISATION_PRECISION, 1, WHOLE_MAP_ITERATIONS, "sound")
            points.append((place.name, (place.nodes, result.total_iterations)))
    return curves(points)


@dataclass(frozen=True)
class StillBlocks:
    """Figure 5, from runs that end when no bit changes, and the same runs under the published termination.

    ``runs``: their number. ``wrong``: the number of runs that end with wrong bits under the published termination.
    """

    curves: tuple[Series, ...]
    runs: int
    wrong: int


def still_blocks(
    sides: Sequence[int], consecutive: Sequence[int], seeds: Sequence[int], progress: Progress
) -> StillBlocks:
    """Figure 5: iterations of the synchronous run over block-synchronous iterations, mean over labyrinths."""
    places = [labyrinth(seed) for seed in seeds]
    references = [_relaxed(place, LABYRINTH_PRECISION, 1, WHOLE_MAP_ITERATIONS, "sound") for place in places]
    series = []
    runs = wrong = 0
    for side in sides:
        progress(f"Figure 5: {side} × {side} blocks")
        ratios = []
        for iterations in consecutive:
            gains = []
            for place, reference in zip(places, references, strict=True):
                sound = _relaxed(place, LABYRINTH_PRECISION, side, iterations, "sound")
                gains.append(reference.total_iterations * side**2 / sound.total_iterations)
                published = _relaxed(place, LABYRINTH_PRECISION, side, iterations, "published")
                runs += 1
                wrong += published.field != reference.field
            ratios.append(fmean(gains))
        series.append(Series(f"k={side}", tuple(float(i) for i in consecutive), tuple(ratios)))
    return StillBlocks(tuple(series), runs, wrong)


def shares_by_sweep(sides: Sequence[int], progress: Progress) -> list[Series]:
    """Figure 6: mean iterations of a visit over I, sweep by sweep until convergence."""
    place = labyrinth(LABYRINTH_SEEDS[0])
    series = []
    for side in sides:
        progress(f"Figure 6: {side} × {side} blocks")
        result = _relaxed(place, LABYRINTH_PRECISION, side, STILL_ITERATIONS, "published", visits=True)
        assert result.visits is not None
        shares = result.visits.iterations.reshape(-1, side**2).mean(axis=1) / STILL_ITERATIONS
        bins = [float(part.mean()) for part in np.array_split(shares, min(BINS, shares.size))]
        x = tuple((index + 0.5) / len(bins) for index in range(len(bins)))
        series.append(Series(f"k={side}", x, tuple(bins)))
    return series


def bits_a_doubling(curve: Series) -> tuple[float, float]:
    """Bits that a doubling of L adds, over the first half of the curve and over the last.

    Both are equal for growth with log L. The last is smaller for slower growth.
    """
    middle = len(curve.x) // 2
    logs = [math.log2(x) for x in curve.x]
    return slope(logs[: middle + 1], curve.y[: middle + 1]), slope(logs[middle:], curve.y[middle:])


def node_power(curve: Series) -> float:
    """Exponent of iterations against nodes over the last half of the curve: 1 is linear."""
    middle = len(curve.x) // 2
    return slope([math.log(x) for x in curve.x[middle:]], [math.log(y) for y in curve.y[middle:]])


def settled_spread(series: Series) -> float:
    """Spread of the curve over its middle (a tenth to nine tenths), relative to its mean there."""
    middle = series.y[len(series.y) // 10 : -(len(series.y) // 10) or None]
    return pstdev(middle) / fmean(middle)


def plateau(series: Series) -> tuple[float, float]:
    """The begin and the end, in shares of the run, of the part of the curve within a tenth of its median."""
    middle = median(series.y)
    within = [index for index, y in enumerate(series.y) if abs(y - middle) <= middle / 10]
    return within[0] / len(series.y), (within[-1] + 1) / len(series.y)
