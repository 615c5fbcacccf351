"""The rules that make one figure of a design of its values in all conditions, and how sure that figure is.

Values are float64 arrays with the conditions as last axis. Where seeds were drawn, ``draws`` is the number of the drawn
seed of each condition, from 0; each seed then has equally many conditions. An interval is one of confidence, at
``CONFIDENCE``, of what the same rule would give over all seeds that might have been drawn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.inputs.aggregate import Quantile, Rule, Share

special = late("scipy.special")

CONFIDENCE = 0.95
FEWEST_SIGNS = 6
"""With as many seeds, one sign in all of them has a probability of 2 / 2^6 = 0.031 where there is no difference."""

_TAIL = (1 - CONFIDENCE) / 2
_RESAMPLES = 2000
_ROUNDING = 1e-9

Floats = NDArray[np.float64]
Draws = NDArray[np.intp]


@dataclass(frozen=True)
class Spread:
    """The values of one figure of one design in all conditions that have one.

    - ``least``, ``greatest``, ``deviation``: the extremes, and the standard deviation of the sample; 0 of one value.
    - ``interval``: of confidence of the aggregated figure; None where no seeds were drawn, or too few, and for the
      worst and the best: a sample does not bound them.
    """

    least: float
    greatest: float
    deviation: float
    interval: tuple[float, float] | None = None


def aggregated(rule: Rule, values: Floats, maximise: bool) -> Floats:
    """The figure that a rule makes of the values in all conditions. Of ``share`` these are 1 where the limit is met.

    >>> values = np.array([3.0, 1.0, 2.0, 10.0])
    >>> rules = ("worst", "best", "mean", "median", Quantile(quantile=0.75))
    >>> [float(aggregated(rule, values, False)) for rule in rules]
    [10.0, 1.0, 4.0, 2.5, 3.0]
    """
    if rule == "mean" or isinstance(rule, Share):
        return np.asarray(values.mean(axis=-1))
    if rule == "median":
        return np.asarray(np.median(values, axis=-1))
    count = values.shape[-1]
    share = {"worst": 1.0, "best": 0.0}[rule] if isinstance(rule, str) else rule.quantile
    place = max(math.ceil(share * count - _ROUNDING), 1) - 1
    ordered = np.sort(values, axis=-1)
    return np.asarray(ordered[..., count - 1 - place if maximise else place])


def spread(values: Floats) -> Spread:
    """The spread of at least one value, without an interval."""
    deviation = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return Spread(float(values.min()), float(values.max()), deviation)


def interval(rule: Rule, values: Floats, maximise: bool, draws: Draws) -> tuple[float, float] | None:
    """The interval of confidence of the figure that the rule makes of these values; None where the sample has none.

    - mean: Student's t over the means of the seeds.
    - share: Clopper and Pearson's over the seeds. A seed with several conditions counts by its share of them, which
      varies less than yes or no does, so the interval is wide enough.
    - median and quantile: percentiles of 2,000 resamples of the seeds, drawn with a fixed seed. There is none where
      even the extremes of the sample do not bound the quantile.
    """
    table = _by_seed(values, draws)
    count = len(table)
    if count < 2 or rule in ("worst", "best"):
        return None
    if isinstance(rule, Share):
        return _share_interval(float(table.mean(axis=1).sum()), count)
    if rule == "mean":
        return _mean_interval(table.mean(axis=1))
    share = rule.quantile if isinstance(rule, Quantile) else 0.5
    if max(share, 1 - share) ** count > _TAIL:
        return None
    chosen = np.random.default_rng(0).integers(count, size=(_RESAMPLES, count))
    resampled = aggregated(rule, table[chosen].reshape(_RESAMPLES, -1), maximise)
    low, high = np.percentile(resampled, [100 * _TAIL, 100 * (1 - _TAIL)])
    return float(low), float(high)


def told_apart(one: Floats, others: Floats, draws: Draws | None) -> NDArray[np.bool_]:
    """The others that differ from one design in a figure, compared condition by condition.

    Without seeds: one of the two is better in some condition and worse in none. With seeds: the interval of the mean
    difference does not hold 0, or at least ``FEWEST_SIGNS`` seeds all have a difference of one sign.

    Args:
        one: of each condition. others: designs × conditions.

    Returns:
        bool, one entry for each of the others.
    """
    differences = others - one
    if draws is None:
        above, below = (differences > 0).any(axis=1), (differences < 0).any(axis=1)
        return np.asarray(above != below)
    means = _by_seed(differences, draws).mean(axis=-1)
    count = means.shape[-1]
    if count < 2:
        return np.zeros(len(others), np.bool_)
    # The interval of the mean difference, mean ± t · s / √n over n seeds, holds 0 unless |mean| > t · s / √n.
    half = _student(count) * means.std(axis=-1, ddof=1) / math.sqrt(count)
    clear = np.abs(means.mean(axis=-1)) > half
    of_one_sign = (differences > 0).all(axis=1) | (differences < 0).all(axis=1)
    return np.asarray(clear | (of_one_sign & (count >= FEWEST_SIGNS)))


def _by_seed(values: Floats, draws: Draws) -> Floats:
    """The values, the conditions parted into seeds × conditions of a seed."""
    ordered = values[..., np.argsort(draws, kind="stable")]
    return ordered.reshape(*values.shape[:-1], int(draws.max()) + 1, -1)


def _mean_interval(means: Floats) -> tuple[float, float]:
    half = _student(len(means)) * float(means.std(ddof=1)) / math.sqrt(len(means))
    middle = float(means.mean())
    return middle - half, middle + half


def _student(count: int) -> float:
    return float(special.stdtrit(count - 1, 1 - _TAIL))


def _share_interval(met: float, count: int) -> tuple[float, float]:
    low = float(special.betaincinv(met, count - met + 1, _TAIL)) if met > 0 else 0.0
    high = float(special.betaincinv(met + 1, count - met, 1 - _TAIL)) if met < count else 1.0
    return low, high
