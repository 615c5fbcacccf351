"""Shares of the variance of a study, against closed forms."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from explore_fakes import result
from hypothesis import given
from hypothesis import strategies as st

from codesign.ground.figures import FIGURES
from codesign.study.outcomes import Outcomes
from codesign.study.sensitivity import inside_of, variance_shares
from codesign.study.study import Study

TIME, SLICES = FIGURES["first_plan_s"], FIGURES["slices"]


def grid(*sizes: int) -> np.ndarray:
    return np.array(list(itertools.product(*map(range, sizes))), np.intp)


def test_an_additive_figure_has_the_variances_of_its_terms() -> None:
    levels = grid(4, 3, 2)
    values = 3.0 * levels[:, 0] + 1.0 * levels[:, 1] ** 2 + 0.0 * levels[:, 2]
    parts = [9 * np.var(range(4)), np.var([0, 1, 4]), 0.0]
    shares = variance_shares(levels, values)
    for (main, total, paired), part in zip(shares, parts, strict=True):
        assert main == pytest.approx(part / sum(parts), abs=1e-9)
        assert total == main
        assert paired == 1


def test_a_product_of_two_centred_axes_is_all_interaction() -> None:
    levels = grid(3, 3, 2)
    values = (levels[:, 0] - 1.0) * (levels[:, 1] - 1.0)
    assert variance_shares(levels, values) == [(0, 1, 1), (0, 1, 1), (0, 0, 1)]


def test_a_product_has_the_indices_of_sobol() -> None:
    """y = a b: V_a = E[b]² Var a, V_ab = Var a Var b."""
    a, b = np.array([1.0, 2.0, 5.0]), np.array([1.0, 4.0])
    levels = grid(3, 2)
    values = a[levels[:, 0]] * b[levels[:, 1]]
    both = a.var() * b.var()
    by_a, by_b = b.mean() ** 2 * a.var(), a.mean() ** 2 * b.var()
    whole = by_a + by_b + both
    (main_a, total_a, _), (main_b, total_b, _) = variance_shares(levels, values)
    assert (main_a, main_b) == pytest.approx((by_a / whole, by_b / whole), abs=1e-9)
    assert (total_a, total_b) == pytest.approx(((by_a + both) / whole, (by_b + both) / whole), abs=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_on_a_full_grid_both_shares_are_conditional_variances(seed: int) -> None:
    levels = grid(3, 2, 4)
    values = np.random.default_rng(seed).normal(size=len(levels)) + 1e3
    cube = values.reshape(3, 2, 4)
    for axis, (main, total, _) in enumerate(variance_shares(levels, values)):
        others = tuple(other for other in range(3) if other != axis)
        assert main == pytest.approx(cube.mean(axis=others).var() / cube.var(), abs=1e-8)
        assert total == pytest.approx(cube.var(axis=axis).mean() / cube.var(), abs=1e-8)


@given(st.integers(0, 2**32 - 1))
def test_holes_move_no_share_of_an_axis_without_effect(seed: int) -> None:
    """Of an additive figure: an axis that moves nothing has 0, and no other share exceeds 1, whatever is missing."""
    chance = np.random.default_rng(seed)
    levels = grid(4, 3, 3)[chance.random(36) < 0.6]
    if len(levels) < 12:
        return
    values = chance.normal(size=4)[levels[:, 0]] + chance.normal(size=3)[levels[:, 1]]
    first, second, idle = variance_shares(levels, values)
    assert idle[:2] == pytest.approx((0, 0), abs=1e-9)
    assert all(0 <= share <= 1 for each in (first, second) for share in each[:2] if share is not None)


def test_an_axis_alone_moves_all_with_holes() -> None:
    levels = grid(4, 3)[[0, 1, 4, 5, 7, 11]]
    values = np.array([1.0, 3.0, 4.0, 9.0])[levels[:, 0]]
    (main, total, _), (other, other_total, _) = variance_shares(levels, values)
    assert (other, other_total) == (0, 0)
    assert main is not None
    assert 0.5 < main <= 1
    assert total is not None


def test_what_does_not_vary_has_no_shares() -> None:
    assert variance_shares(grid(2, 2), np.full(4, 0.1)) == [(None, None, 1), (None, None, 1)]
    assert variance_shares(np.empty((0, 2), np.intp), np.empty(0)) == [(None, None, 0), (None, None, 0)]


def test_a_study_counts_feasible_designs_alone() -> None:
    axes = {"a.x": (1, 2), "a.y": (10, 20), "a.one": (0,)}
    points = []
    for x, y, _ in itertools.product(*axes.values()):
        fits = (x, y) != (2, 20)
        each = result(seconds=float(x), slices=y if fits else 200, fits=fits)
        points.append(each)
    study = Study("bench", "maze", axes, (TIME, SLICES), (), Outcomes.of(points))
    effects = {(each.axis, each.figure): each for each in study.sensitivity()}
    assert list(effects) == [(axis, str(figure)) for axis in ("a.x", "a.y") for figure in (TIME, SLICES)]
    assert effects["a.y", "first_plan_s"].main == 0
    assert effects["a.x", "slices"].main == 0
    assert effects["a.x", "first_plan_s"].paired == pytest.approx(2 / 3)
    assert not any(each.complete for each in effects.values())
    assert study.sensitivity(TIME) == tuple(each for (_, figure), each in effects.items() if figure == "first_plan_s")


def test_an_axis_moves_what_depends_on_it_too() -> None:
    """Half of the designs have axis 1, the other half axis 2: axis 0 says which, and moves the mean of the halves."""
    none = 3
    levels = np.array([*((0, b, none) for b in range(3)), *((1, none, c) for c in range(3))], np.intp)
    inside, outside = np.array([-1.0, 0.0, 1.0]), np.array([-2.0, 0.0, 2.0])
    values = np.concatenate([10 + inside, 20 + outside])
    variant, first, second = variance_shares(levels, values, [[1, 2], [], []])
    parts = 25.0, inside.var() / 2, outside.var() / 2
    assert variant == (pytest.approx(parts[0] / sum(parts)), 1, 1)
    for share, part in ((first, parts[1]), (second, parts[2])):
        assert share == (pytest.approx(part / sum(parts)), pytest.approx(part / sum(parts)), 0.5)


def test_axes_inside_another_are_found_through_those_between() -> None:
    when = {"d": {"c": (1,)}, "b": {"a": (1,)}, "c": {"b": (2,), "x": (0,)}, "y": {"x": (1,)}}
    assert (set(inside_of(when, "a")), set(inside_of(when, "x"))) == ({"b", "c", "d"}, {"c", "d", "y"})
    assert inside_of(when, "d") == []
