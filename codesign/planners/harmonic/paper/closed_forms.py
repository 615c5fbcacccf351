"""Closed forms of sections 3.2.2 and 4 of Girau, Boumaza, Scherrer and Torres-Huitzil (2008).

Pure functions of a few numbers. The corridor's values are exact, so they are an oracle for any planner at any
precision. The rest are the estimates of the paper, by its own formulas, for comparison with the counts of a run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from codesign.ground.errors import InputError

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


def corridor_value(i: int, length: int) -> Fraction:
    """x_i of the corridor of section 3.2.2, exactly: the solution of x_i = (x_(i−1) + x_(i+1)) / 4.

    >>> corridor_value(1, 4)
    Fraction(1, 56)

    Raises:
        InputError: length below 1, or i outside of 0..length.
    """
    values = corridor(length)
    _require(0 <= i <= length, f"{i} is outside of the corridor 0..{length}", "i")
    return Fraction(values[i], values[length])


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
