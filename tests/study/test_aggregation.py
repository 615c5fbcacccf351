"""Rules, intervals of confidence and paired comparisons: by definition, and how often an interval holds the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.ground.figures import FIGURES
from codesign.inputs import Constraint
from codesign.inputs.aggregate import Quantile, Rule, Share
from codesign.study.aggregation import aggregated, interval, told_apart

VALUES = st.lists(st.integers(-5, 5).map(float), min_size=1, max_size=12)
SHARE = Share(share=Constraint(figure=FIGURES["first_plan_s"], at_most=1.0))
TRIALS = 400


@given(VALUES, st.integers(1, 99), st.booleans())
def test_a_quantile_is_what_its_share_of_the_conditions_reaches(
    values: list[float], percent: int, maximise: bool
) -> None:
    """Of the values that at least the share of the conditions is at least as good as, the best."""
    share = percent / 100
    sign = -1 if maximise else 1
    losses = [sign * value for value in values]
    reached = [loss for loss in losses if sum(other <= loss for other in losses) * 100 >= percent * len(losses)]
    told = float(aggregated(Quantile(quantile=share), np.array(values), maximise))
    assert told == sign * min(reached)


@given(VALUES, st.booleans())
def test_worst_best_mean_and_median_by_definition(values: list[float], maximise: bool) -> None:
    ends = (min(values), max(values)) if maximise else (max(values), min(values))
    array = np.array(values)
    assert (aggregated("worst", array, maximise), aggregated("best", array, maximise)) == ends
    assert aggregated("mean", array, maximise) == pytest.approx(sum(values) / len(values))
    assert aggregated("median", array, maximise) == np.median(values)


def test_no_rounding_moves_a_quantile() -> None:
    values = np.arange(1.0, 11.0)
    assert [float(aggregated(Quantile(quantile=q / 10), values, False)) for q in range(1, 10)] == list(range(1, 10))


@pytest.mark.parametrize(
    ("rule", "seeds", "truth"),
    [
        ("mean", 5, 1.0),
        ("mean", 20, 1.0),
        ("median", 12, 1.0),
        (Quantile(quantile=0.75), 30, 1.0 + 0.674489750196),
        (SHARE, 8, 0.5),
    ],
)
def test_an_interval_holds_the_truth_about_as_often_as_it_says(rule: Rule, seeds: int, truth: float) -> None:
    """Normal values around 1. The binomial spread of 400 trials is 1.1 %, resampling a little too narrow."""
    random = np.random.default_rng(4)
    held = 0
    for _ in range(TRIALS):
        values = random.normal(1.0, 1.0, seeds)
        if isinstance(rule, Share):
            values = (values <= 1.0).astype(float)
        bounds = interval(rule, values, False, np.arange(seeds))
        assert bounds is not None
        held += bounds[0] <= truth <= bounds[1]
    # Clopper and Pearson's holds at least as often as it says; for a share of few seeds more often.
    assert 0.91 <= held / TRIALS <= (1.0 if isinstance(rule, Share) else 0.985)


def test_seeds_are_drawn_and_sizes_are_not() -> None:
    """Three sizes that differ by far: the interval is that of the seeds' means, however far the sizes are apart."""
    random = np.random.default_rng(1)
    seeds = random.normal(0.0, 1.0, 10)
    values = (seeds[:, None] + np.array([0.0, 100.0, 1000.0])).ravel()
    draws = np.repeat(np.arange(10), 3)
    bounds = interval("mean", values, False, draws)
    alone = interval("mean", seeds, False, np.arange(10))
    assert bounds is not None
    assert alone is not None
    assert np.array(bounds) - 1100 / 3 == pytest.approx(np.array(alone))
    # Whatever the order of the conditions.
    order = random.permutation(30)
    assert interval("mean", values[order], False, draws[order]) == pytest.approx(bounds)


def test_what_a_sample_does_not_bound_has_no_interval() -> None:
    draws = np.arange(5)
    values = np.array([3.0, 1.0, 4.0, 1.0, 5.0])
    assert interval("worst", values, False, draws) is None
    assert interval("best", values, False, draws) is None
    assert interval("median", values, False, draws) is None, "five values hold a median at 93.75 % at most"
    assert interval(Quantile(quantile=0.9), np.arange(30.0), False, np.arange(30)) is None
    assert interval("mean", np.array([1.0]), False, np.array([0])) is None


def test_all_of_a_few_seeds_is_not_all() -> None:
    bounds = interval(SHARE, np.ones(5), False, np.arange(5))
    assert bounds is not None
    assert bounds == (pytest.approx(0.025 ** (1 / 5)), 1.0)


def test_without_seeds_a_better_condition_against_a_worse_one_tells_nothing_apart() -> None:
    one = np.array([1.0, 2.0, 3.0])
    others = np.array([[2.0, 3.0, 4.0], [0.0, 3.0, 4.0], [1.0, 2.0, 3.0], [1.0, 2.0, 4.0]])
    assert told_apart(one, others, None).tolist() == [True, False, False, True]


def test_equal_designs_are_told_apart_about_once_in_twenty() -> None:
    random = np.random.default_rng(2)
    wrong = 0
    for _ in range(TRIALS):
        ease = random.normal(0.0, 10.0, 8)  # of each seed, for both designs
        one, other = ease + random.normal(0.0, 1.0, 8), ease + random.normal(0.0, 1.0, 8)
        wrong += bool(told_apart(one, other[None], np.arange(8))[0])
    assert 0.02 <= wrong / TRIALS <= 0.09


def test_pairing_tells_apart_what_the_spread_of_the_seeds_hides() -> None:
    random = np.random.default_rng(3)
    ease = random.normal(0.0, 10.0, 8)
    one, other = ease + random.normal(0.0, 0.1, 8), ease + 0.5 + random.normal(0.0, 0.1, 8)
    assert told_apart(one, other[None], np.arange(8)).tolist() == [True]
    assert abs(other.mean() - one.mean()) < one.std() / math.sqrt(8), "unpaired intervals overlap"
