"""Axes, shares and quantities read naturally."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.views.report.wording import axis_text, prefix, quantity_text, share_text


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("relax.block", (36, 66), "36×66"),
        ("relax.blocks", [2, 2], "2×2"),
        ("relax.schedule", [15, 31], "15, 31"),
        ("relax.schedule", {"first": 7, "step": 8, "last": 255}, "7 to 255 by 8"),
        ("relax.schedule", {"best_of": {"first": 7, "step": 8, "last": 63}}, "best_of 7 to 63 by 8"),
        ("fpga.clock", "100 MHz", "100 MHz"),
        ("x.flag", True, "yes"),
        ("x.share", 0.25, "0.25"),
        ("x.none", None, "–"),
        ("x.long", "a" * 500, "a" * 159 + "…"),
    ],
)
def test_values_of_axes_read_naturally(name: str, value: object, text: str) -> None:
    assert axis_text(name, value) == text


@given(st.floats(0, 1))
def test_only_one_is_all_and_only_zero_is_nothing(share: float) -> None:
    text = share_text(share)
    assert (text == "100 %") == (share == 1)
    assert (text == "0 %") == (share == 0)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.00321, "s", "3.21 ms"),
        (3_210_000_000, "ps", "3.21 ms"),
        (150e6, "Hz", "150 MHz"),
        (0.0, "Hz", "0 Hz"),
        (0.0, "s", "0 s"),
        (-2e6, "Hz", "-2,000,000 Hz"),
        (99.4, "%", "99.4 %"),
        (67_584.0, "1", "67,584"),
        (2.5, "", "2.5"),
        (1.7, "cells", "1.7 cells"),
        (1.0, "cells", "1 cell"),
        (float("inf"), "s", "inf"),
        (float("nan"), "", "nan"),
        (11013.7, "", "11,014"),
        (-10400.5, "cells", "-10,400 cells"),
        (9876.54, "", "9,877"),
    ],
)
def test_quantities_read_naturally(value: float, unit: str, text: str) -> None:
    assert quantity_text(value, unit) == text


@given(st.lists(st.floats(1e-12, 1e3), min_size=1), st.sampled_from(["s", "J", "W"]))
def test_the_prefix_of_an_axis_suits_its_middle(values: list[float], unit: str) -> None:
    size, name = prefix(values, unit)
    middle = sorted(values)[len(values) // 2]
    assert name.endswith(unit)
    assert 1 <= middle / size < 1000 or size in {1.0, 1e-9}
    assert middle >= size or size == 1e-9
