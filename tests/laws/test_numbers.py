"""Sums of monomials: directions of inputs, and operations that have no such sum."""

from __future__ import annotations

import pytest

from codesign.laws import Sum, ceil_div, symbol

WIDTH, CLOCK = symbol("width"), symbol("clock")


@pytest.mark.parametrize(
    ("number", "direction"),
    [
        (3 * WIDTH, 1),
        (CLOCK / WIDTH, -1),
        (ceil_div(100, WIDTH), -1),
        (ceil_div(100, WIDTH) / WIDTH, -1),
        (ceil_div(100, WIDTH) * WIDTH, None),
        (WIDTH + CLOCK / WIDTH, None),
        (2 * CLOCK, 0),
    ],
)
def test_the_direction_of_an_input(number: Sum, direction: int | None) -> None:
    assert number.direction("width") == direction


def test_a_number_divides_exactly() -> None:
    [each] = (7 * 10**12 * WIDTH / 10**12).monomials
    assert each.amount == 7


def test_no_sum_is_divided_by_a_quotient() -> None:
    with pytest.raises(TypeError, match="quotient"):
        CLOCK / ceil_div(100, WIDTH)
