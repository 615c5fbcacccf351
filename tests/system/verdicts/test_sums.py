"""The least margin over a box, against random draws and all corners; and the value of one input that flips a margin."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.laws import Monomial
from codesign.system.verdicts.sums import GRID, Input, Margin

NAMES = ("a", "b", "c", "width")


def box(name: str, low: float, value: float, high: float) -> Input:
    return Input("board", name, value, low, high)


@st.composite
def boxes(draw: st.DrawFn) -> dict[str, Input]:
    inputs = {}
    for name in NAMES:
        numbers = st.integers(1, 12) if name == "width" else st.floats(0.1, 10.0)
        low, value, high = sorted(draw(st.lists(numbers, min_size=3, max_size=3)))
        inputs[name] = box(name, float(low), float(value), float(high))
    return inputs


def monomials(powers: st.SearchStrategy[int]) -> st.SearchStrategy[Monomial]:
    return st.builds(
        lambda amount, exponents, divide: Monomial(
            amount,
            {name: power for name, power in zip("abc", exponents, strict=True) if power},
            divide,
            ("width",) if divide else (),
        ),
        st.floats(0.1, 5.0),
        st.tuples(powers, powers, powers),
        st.sampled_from([0, 0, 7, 30]),
    )


def sums(powers: st.SearchStrategy[int]) -> st.SearchStrategy[tuple[Monomial, ...]]:
    return st.lists(monomials(powers), min_size=1, max_size=4).map(tuple)


def random_margins(margin: Margin, count: int) -> Any:
    random = np.random.default_rng(0)
    values = {
        name: random.integers(int(each.low), int(each.high) + 1, count).astype(float)
        if name == "width"
        else random.uniform(each.low, each.high, count)
        for name, each in margin.inputs.items()
    }
    return np.broadcast_to(margin.at(values), (count,))


@given(inputs=boxes(), ours=sums(st.sampled_from([-1, 0, 1])), theirs=sums(st.sampled_from([-1, 0, 1])))
def test_no_draw_falls_below_the_least_margin(
    inputs: dict[str, Input], ours: tuple[Monomial, ...], theirs: tuple[Monomial, ...]
) -> None:
    margin = Margin((ours,), (theirs,), inputs)
    drawn, scale = (random_margins(margin, 500), 1e-9 * (1.0 + float(np.max(np.abs(random_margins(margin, 500))))))
    assert margin.least().value <= drawn.min() + scale
    assert -margin.reversed.least().value >= drawn.max() - scale


@given(inputs=boxes(), ours=sums(st.sampled_from([0, 1])), theirs=sums(st.sampled_from([0, 1])))
def test_the_least_margin_stands_at_a_corner(
    inputs: dict[str, Input], ours: tuple[Monomial, ...], theirs: tuple[Monomial, ...]
) -> None:
    """Sums that are linear in each input: exact, and equal to the least over all corners and all whole widths."""
    margin = Margin((ours,), (theirs,), inputs)
    ends = [(inputs[name].low, inputs[name].high) for name in "abc"]
    widths = range(int(inputs["width"].low), int(inputs["width"].high) + 1)
    corners = [float(margin.at(dict(zip(NAMES, corner, strict=True)))) for corner in itertools.product(*ends, widths)]
    least = margin.least()
    assert least.exact
    assert least.value == pytest.approx(min(corners), rel=1e-9, abs=1e-9)


def test_what_both_share_cancels() -> None:
    """The same cost in both is one input: 100 units against 101 is proved, whatever a unit costs."""
    inputs = {"cost": box("cost", 1.0, 2.0, 50.0)}
    margin = Margin(((Monomial(100.0, {"cost": 1}),),), ((Monomial(101.0, {"cost": 1}),),), inputs)
    assert margin.least() == (1.0, True)
    assert margin.flip("cost") is None


def test_mixed_exponents_are_bounded_and_not_exact() -> None:
    inputs = {"a": box("a", 1.0, 2.0, 4.0)}
    margin = Margin(((Monomial(1.0, {"a": 1}), Monomial(4.0, {"a": -1})),), ((Monomial(9.0, {}),),), inputs)
    assert margin.least() == (9.0 - 4.0 - 4.0, False)


@pytest.mark.parametrize(
    ("ours", "theirs", "flip"),
    [
        (Monomial(2.0, {"a": 1}), Monomial(6.0, {}), 3.0),
        (Monomial(8.0, {"a": -1}), Monomial(6.0, {}), 4 / 3),
        (Monomial(2.0, {"a": 1}), Monomial(9.0, {}), None),
        (Monomial(1.0, {}, 30, ("width",)), Monomial(5.5, {}), 5.0),
    ],
)
def test_the_value_that_flips_a_margin(ours: Monomial, theirs: Monomial, flip: float | None) -> None:
    inputs = {"a": box("a", 1.0, 2.0, 4.0), "width": box("width", 2.0, 8.0, 9.0)}
    margin = Margin(((ours,),), ((theirs,),), inputs)
    (name,) = ours.inputs
    assert margin.flip(name) == (None if flip is None else pytest.approx(flip))


@settings(max_examples=300)
@given(inputs=boxes(), ours=sums(st.sampled_from([-1, 0, 1])), limit=st.floats(0.0, 1.0), name=st.sampled_from(NAMES))
def test_a_flip_is_the_nearest_value_at_which_the_sign_changes(
    inputs: dict[str, Input], ours: tuple[Monomial, ...], limit: float, name: str
) -> None:
    """Against each whole number, and against each value of a grid; a limit of its own value is kept."""
    alone = Margin((ours,), ((),), inputs)
    ends = [-float(alone.at({name: end})) for end in (inputs[name].low, inputs[name].value, inputs[name].high)]
    least, most = min(ends), max(ends)
    held = ends[1] if limit < 0.1 else least + (most - least) * limit
    margin, each = Margin((ours,), ((Monomial(held, {}),),), inputs), inputs[name]
    whole = np.arange(each.low, each.high + 1.0)
    grid = np.concatenate([np.linspace(each.value, end, GRID) for end in (each.low, each.high)])
    is_whole = any(name in one.by for one in ours)
    values = whole if is_whole else grid
    # A sum that is as near to 0 as its rounding has no sign.
    margins = np.broadcast_to(margin.at({name: values}), values.shape)
    signs = np.where(np.abs(margins) > 1e-9 * (1.0 + held), margins, 0.0)
    own = 1.0 if float(margin.at()) >= 0 else -1.0
    changed = values[(signs < 0) if own > 0 else (signs > 0)]
    flip = margin.flip(name)
    if flip is None:
        assert not len(changed)
        return
    assert each.low <= flip <= each.high
    far = abs(flip - each.value)
    assert (np.abs(changed - each.value) >= far * (1 - 1e-9)).all()
    assert not is_whole or (float(margin.at({name: flip})) >= 0) != (own > 0)
    around = [float(margin.at({name: flip + step * (1e-6 + 1e-6 * far)})) for step in (-1, 0, 1)]
    assert min(own * value for value in around) <= 1e-9 * (1.0 + held)


def test_a_flip_of_mixed_exponents_or_of_several_sums_is_searched() -> None:
    inputs = {"a": box("a", 1.0, 2.0, 10.0)}
    mixed = Margin(((Monomial(1.0, {"a": 1}), Monomial(4.0, {"a": -1})),), ((Monomial(6.0, {}),),), inputs)
    assert mixed.flip("a") == pytest.approx(3 + math.sqrt(5))
    several = Margin(
        ((Monomial(1.0, {"a": 1}),), (Monomial(3.0, {}),)), ((Monomial(5.0, {}),), (Monomial(1.0, {}),)), inputs
    )
    assert several.at() == 2.0
    assert several.flip("a") == pytest.approx(5.0)
    assert several.least() == (-5.0, False)
