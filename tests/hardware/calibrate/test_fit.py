"""The factor of a term, its interval and its errors."""

from __future__ import annotations

import math

import pytest

from codesign.hardware.calibrate.calibration import errors_of, factor_of, fitted_term
from codesign.inputs.library import Sample


def samples_of(*pairs: tuple[str, float, float]) -> list[Sample]:
    return [Sample(design=d, predicted=p, reported=r, report=f"r:{i}") for i, (d, p, r) in enumerate(pairs)]


def test_one_design_moves_the_law_and_keeps_its_width() -> None:
    term = fitted_term("clock", samples_of(("a", 200.0, 100.0)), (0.4, 1.3))
    assert term.factor.value == pytest.approx(0.5)
    assert term.factor.interval == pytest.approx((0.2, 0.65))
    assert term.held_out is None


def test_a_sure_law_is_widened() -> None:
    term = fitted_term("lut4", samples_of(("a", 100.0, 120.0)), (1.0, 1.0))
    assert term.factor.interval == pytest.approx((1.08, 1.32))


def test_exact_counts_stay_exact() -> None:
    term = fitted_term("block_rams", samples_of(("a", 18.0, 18.0)), (1.0, 1.0))
    assert term.factor.interval == (1.0, 1.0)


def test_several_designs_are_held_out_and_claim_no_less_than_the_law() -> None:
    samples = samples_of(*((name, 100.0 * n, 100.0 * n * ratio) for n, (name, ratio) in enumerate(
        (("a", 1.20), ("b", 1.21), ("c", 1.19), ("d", 1.205)), 1)))  # fmt: skip
    term = fitted_term("lut4", samples, (0.8, 1.3))
    value, low, high = term.at(250.0)
    assert value == pytest.approx(1.2, rel=0.01)
    assert low <= 0.8 * value
    assert high >= 1.3 * value
    errors = errors_of("lut4", samples)
    assert errors.before == pytest.approx(1 - 1 / 1.2, abs=0.01)
    assert errors.after < 0.01
    assert errors.held_out is not None
    assert errors.held_out < 0.015


def test_seeds_of_one_design_weigh_as_one() -> None:
    samples = samples_of(("a", 100.0, 90.0), ("a", 100.0, 90.0), ("a", 100.0, 90.0), ("b", 100.0, 160.0))
    assert factor_of(samples) == pytest.approx(math.sqrt(0.9 * 1.6))
