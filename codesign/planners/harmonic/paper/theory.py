"""Sections 3.2.2 and 4 of Girau et al. (2008): the closed forms of the paper beside the counts of runs.

The paper estimates bits and iterations by closed forms in the size of the map alone. Here they are evaluated for the
rectangle around a map (N and M count intervals: sides plus one). The same quantities are counted on two maps: a room
without obstacles, for which the estimates are made, and a labyrinth. The corridor's values are exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from statistics import fmean, median, pstdev

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import eigsh

from codesign import maps
from codesign.ground.errors import InputError
from codesign.planners.harmonic.plan import HarmonicPlan, relax
from codesign.planners.harmonic.plan.best_schedule import optimise_schedule
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
from codesign.planners.harmonic.plan.precision import converged_field, required_precision
from codesign.planners.harmonic.plan.warm_start import FieldBounds
from codesign.planners.interface import Problem
from codesign.planners.papers import curves
from codesign.planners.reproduction import Progress, Series

# Figures 3 to 6 of Girau et al. (2008) drawn again from generated maps.
#
# The environments of the paper's Figure 2 are not published as data. An empty room, rooms with doors, a maze and a
# spiral replace them. So the shape of a curve can be compared with the words of the paper, but its numbers cannot.

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


def _synchronous(place: Environment, *schedule: int) -> HarmonicPlan:
    """An environment as one block, through the precisions of a schedule."""
    return _relaxed(place, schedule, 1, WHOLE_MAP_ITERATIONS)


def _relaxed(
    place: Environment, schedule: Sequence[int], side: int, iterations: int, termination: str = "sound"
) -> HarmonicPlan:
    """The labyrinth or an environment in ``side`` × ``side`` blocks, from zero."""
    rows, columns = (-(-length // side) for length in place.free.shape)
    return relax(
        place.free,
        [place.goal],
        block=(rows, columns),
        iterations=iterations,
        schedule=schedule,
        termination=termination,
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
            result = _synchronous(place, STABILISATION_PRECISION)
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
    references = [_synchronous(place, LABYRINTH_PRECISION) for place in places]
    series = []
    runs = wrong = 0
    for side in sides:
        progress(f"Figure 5: {side} × {side} blocks")
        ratios = []
        for iterations in consecutive:
            gains = []
            for place, reference in zip(places, references, strict=True):
                sound = _relaxed(place, [LABYRINTH_PRECISION], side, iterations)
                gains.append(reference.total_iterations * side**2 / sound.total_iterations)
                published = _relaxed(place, [LABYRINTH_PRECISION], side, iterations, "published")
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
        result = _relaxed(place, [LABYRINTH_PRECISION], side, STILL_ITERATIONS, "published")
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


LN2 = math.log(2.0)


def _require(holds: bool, what: str, where: str) -> None:
    if not holds:
        raise InputError(what, where)


def corridor(length: int) -> tuple[int, ...]:
    """Integers y_0 .. y_L with y_(i+1) = 4·y_i − y_(i−1), y_0 = 0, y_1 = 1, so that x_i = y_i / y_L (3.2.2).

    The corridor is one cell wide with walls along it, an obstacle at i = 0 and the goal at i = length.

    >>> corridor(4)
    (0, 1, 4, 15, 56)

    Raises:
        InputError: length below 1.
    """
    _require(length >= 1, f"a corridor has a length of at least 1, not {length}", "length")
    values = [0, 1]
    while len(values) <= length:
        values.append(4 * values[-1] - values[-2])
    return tuple(values)


def corridor_estimate(i: int, length: int) -> float:
    """x_i by the paper's closed form (r₊^i − r₋^i) / (r₊^L − r₋^L), r± = 2 ± √3 (3.2.2); never overflows.

    Raises:
        InputError: length below 1, or i outside of 0..length.
    """
    _require(length >= 1, f"a corridor has a length of at least 1, not {length}", "length")
    _require(0 <= i <= length, f"{i} is outside of the corridor 0..{length}", "i")
    # Both roots multiply to 1, so r₋^i / r₊^i = r₊^(−2i): powers of the small root alone stay finite.
    small = 2.0 - math.sqrt(3.0)
    return small ** (length - i) * (1.0 - small ** (2 * i)) / (1.0 - small ** (2 * length))


def corridor_bits(length: int) -> int:
    """Least p with x_1 ≥ 2^−p: below it x_1 equals the value of the obstacle (3.2.2). About 1.9 bits a cell.

    A field without local maxima takes one or two bits less (``precision.required_precision``, measured on lengths up to
    500): x_1 may be 0, as long as x_2 is not.

    >>> corridor_bits(4)
    6
    """
    return (corridor(length)[length] - 1).bit_length()


def gamma(rows: int, columns: int) -> float:
    """Contraction factor γ = (cos(π/N) + cos(π/M)) / 2 of an N × M domain without obstacles (4.2).

    N and M count intervals: with N nodes inside and obstacles around, as on our maps, the factor has N + 1.

    Raises:
        InputError: a side below 1.
    """
    _require(rows >= 1 and columns >= 1, f"a domain of {rows} × {columns} has no node", "rows, columns")
    return (math.cos(math.pi / rows) + math.cos(math.pi / columns)) / 2


def noise_gain(rows: int, columns: int) -> float:
    """K = 1 / (1 − γ): the largest growth of a rounding error of one step (4.3.2, equation (5)); γ exact."""
    # 1 − cos(a) written as 2·sin²(a/2): no digits are lost on large maps, where γ is close to 1.
    _require(rows >= 1 and columns >= 1, f"a domain of {rows} × {columns} has no node", "rows, columns")
    return 1.0 / (math.sin(math.pi / (2 * rows)) ** 2 + math.sin(math.pi / (2 * columns)) ** 2)


def _require_margin(gain: float, margin: float) -> None:
    _require(gain > 0.0 and math.isfinite(gain), f"K must be finite and above 0, not {gain}", "gain")
    _require(margin > 0.0 and math.isfinite(margin), f"λ must be finite and above 0, not {margin}", "margin")


def first_precision(gain: float, margin: float) -> float:
    """p_min = (log K + log(1 + λ)) / log 2: the least sensible first precision, in bits (4.4.1).

    Args:
        gain: K, of ``noise_gain``.
        margin: λ > 0, the relative excess of the last error over its asymptote (4.3.2).
    """
    _require_margin(gain, margin)
    return math.log2(gain) + math.log2(1.0 + margin)


def last_precision(error: float, gain: float, margin: float) -> float:
    """p_max(ε) = (log(1/ε) + log K + log(1 + λ)) / log 2: bits for an error below ε (4.4.1)."""
    _require(0.0 < error < 1.0, f"ε must lie between 0 and 1, not {error}", "error")
    return first_precision(gain, margin) - math.log2(error)


def first_iterations(precision: float, gain: float, margin: float, distance: float = 1.0) -> float:
    """k_1 ≈ K·(p_1·log 2 + log(1/λ) + log(1/K) + log‖H⁰ − H*‖): iterations of the first stage (4.4.2).

    Args:
        precision: p_1, bits.
        gain: K.
        margin: λ.
        distance: ‖H⁰ − H*‖, at most 1 from an all-zero start.
    """
    _require_margin(gain, margin)
    _require(distance > 0.0, f"the distance must be above 0, not {distance}", "distance")
    return gain * (precision * LN2 - math.log(margin) - math.log(gain) + math.log(distance))


def next_iterations(more_bits: float, gain: float, margin: float) -> float:
    """k_i ≤ K·((p_i − p_(i−1) + 1)·log 2 + log(1/λ)): iterations of a later stage (4.4.2).

    The paper takes ‖H^(i−1) − H*‖ ≤ e_(i−1) on the way and leaves out the factor (1 + λ)·K of its own bound:
    read the result as growth with added bits, not as a bound.
    """
    _require_margin(gain, margin)
    return gain * ((more_bits + 1.0) * LN2 - math.log(margin))


def stages_time(schedule: Sequence[float], a: float, b: float, alpha: float, beta: float) -> float:
    """Equation (6): (a + b·p_1)(α + β·p_1) + Σ_(i≥2) (a + b·(p_i − p_(i−1)))(α + β·p_i).

    Args:
        schedule: p_1 < p_2 < ... < p_T, bits; one entry gives the time without increasing precision.
        a, b: iterations of a stage are a + b·(bits added).
        alpha, beta: time of one iteration at p bits is α + β·p (2 and 1 in cycles of the hardware, 5.4).
    """
    _require(len(schedule) > 0, "the schedule is empty", "schedule")
    steps = [later - earlier for earlier, later in zip((0.0, *schedule), schedule, strict=False)]
    _require(min(steps) > 0.0, f"the schedule {list(schedule)} does not rise", "schedule")
    return sum((a + b * step) * (alpha + beta * p) for step, p in zip(steps, schedule, strict=True))


def increasing_precision_ratio(stages: int) -> float:
    """(1 + 1/T) / 2: time with T equal steps of precision over time without, for large p_max (4.4.2).

    >>> increasing_precision_ratio(1), increasing_precision_ratio(4)
    (1.0, 0.625)
    """
    _require(stages >= 1, f"at least one stage is needed, not {stages}", "stages")
    return (1.0 + 1.0 / stages) / 2.0


MARGIN = 1.0
"""λ, which the paper leaves open. With 1 the error of the field may be twice its asymptote."""
LAST = 255
ADDED = 8
ERROR = 2.0**-16
SIDE = 40
QUICK_SIDE = 12
STAGES = (2, 4, 8, 16)
CANDIDATES = (4, 8, 12, *range(16, LAST, 16))
"""Precisions that the best schedule may have before the last."""


@dataclass(frozen=True, eq=False)
class Counts:
    """The counts on one map of ``rows`` × ``columns`` cells, computed as one block.

    Attributes:
        gain: K = 1 / (1 − γ) with the largest eigenvalue γ of the map's own matrix (4.2).
        error_bits: least precision with a converged field within ``ERROR`` of the exact one.
        first: iterations from zero until no bit of ``LAST`` changes.
        later: iterations of a stage that adds the last ``ADDED`` bits.
        ratios: number of equal stages to ``LAST`` bits, and time with them over time with one stage.
        best: the precisions of the fastest schedule of all through ``CANDIDATES``.
        best_ratio: its time over time with one stage.
    """

    name: str
    rows: int
    columns: int
    gain: float
    error_bits: int
    first: int
    later: int
    ratios: dict[int, float]
    best: tuple[int, ...]
    best_ratio: float

    @property
    def estimated_gain(self) -> float:
        """K of the rectangle around the map (4.2)."""
        return noise_gain(self.rows + 1, self.columns + 1)


def count_maps(quick: bool, progress: Progress) -> tuple[Counts, ...]:
    """The counts of the room and the labyrinth; ``quick``: of a smaller room."""
    side = QUICK_SIDE if quick else SIDE
    places = (Environment("room", maps.empty(side, side).free, (0, 0)), labyrinth(1))
    counts = []
    for place in places:
        progress(f"section 4: estimates for the {place.name}")
        counts.append(_count(place))
    return tuple(counts)


def _count(place: Environment) -> Counts:
    one_stage = _synchronous(place, LAST)
    # The fastest schedule of synchronous stages.
    parameters = RelaxParameters(blocks=(1, 1), iterations=1_000_000, schedule=(LAST,), stop=Stop.SCHEDULE_END)
    best = optimise_schedule(Problem(place.free, (place.goal,), ()), parameters, CANDIDATES)
    return Counts(
        name=place.name,
        rows=place.free.shape[0],
        columns=place.free.shape[1],
        gain=1.0 / (1.0 - largest_eigenvalue(place.free, place.goal)),
        error_bits=_bits_for(place, ERROR),
        first=one_stage.total_iterations,
        later=_synchronous(place, LAST - ADDED, LAST).stages[1].iterations,
        ratios={
            stages: _synchronous(place, *_equal_steps(stages)).total_cycles / one_stage.total_cycles
            for stages in STAGES
        },
        best=best.precisions,
        best_ratio=best.cost / one_stage.total_cycles,
    )


def _equal_steps(stages: int) -> list[int]:
    return [LAST * stage // stages for stage in range(1, stages + 1)]


def _bits_for(place: Environment, error: float) -> int:
    """Least precision with a converged field nowhere farther than ``error`` from the exact one."""
    goals = [place.goal]
    bounds = FieldBounds(place.free, goals)
    # At 60 bits what is left to the exact field is far below any error asked for here.
    exact = converged_field(place.free, goals, 60, bounds=bounds).to_float()
    precision = 1
    while (exact - converged_field(place.free, goals, precision, bounds=bounds).to_float()).max() > error:
        precision += 1
    return precision


def largest_eigenvalue(free: NDArray[np.bool_], goal: tuple[int, int]) -> float:
    """γ of the map itself: the factor by which an iteration of the free cells finally shrinks an error (4.2)."""
    movable = free.copy()
    movable[goal] = False
    number = np.cumsum(movable).reshape(free.shape) - 1
    across, down = movable[:, :-1] & movable[:, 1:], movable[:-1] & movable[1:]
    cell = np.concatenate([number[:, :-1][across], number[:-1][down]])
    neighbour = np.concatenate([number[:, 1:][across], number[1:][down]])
    ends = np.concatenate([cell, neighbour]), np.concatenate([neighbour, cell])
    count = int(movable.sum())
    matrix = coo_array((np.full(2 * len(cell), 0.25), ends), shape=(count, count)).tocsr()
    # A start of its own makes the same digits at every run.
    return float(eigsh(matrix, k=1, which="LA", v0=np.ones(count), return_eigenvectors=False)[0])


def equation_6(stages: int, gain: float) -> float:
    """Time with equal stages over time with one by equation (6): a = k_i for no bits, b = K log 2, p + 2 cycles."""
    a, b = next_iterations(0, gain, MARGIN), gain * LN2
    steps = [float(precision) for precision in _equal_steps(stages)]
    return stages_time(steps, a, b, 2, 1) / stages_time([LAST], a, b, 2, 1)
