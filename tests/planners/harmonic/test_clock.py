"""The clock of the array: what a law fitted without a placement says of it, and how wide its interval is."""

from __future__ import annotations

import pytest

from codesign.planners.clock_law import Placement, clock_law
from codesign.planners.harmonic.styles import timing

PLACEMENTS = timing.placements()
ECP5 = [each for each in PLACEMENTS if each.row.part == "LFE5U-85F-8" and not each.registers.doublings]
"""Those of the part with several sizes of each pipeline, one bit a cycle."""
DIGITS = [each for each in PLACEMENTS if each.registers.doublings and each.registers.pipeline == "relax.pipeline 1"]
"""Those of several bits a cycle: each number of bits was placed at one size."""


def name(placement: Placement) -> str:
    row = placement.row
    size, pipeline = (f"{row.variables[key]}" for key in ("ROWS", "COLUMNS")), row.variables["PIPELINE"]
    return f"{row.part}, {' x '.join(size)}, pipeline {pipeline}, digits of {row.variables['DIGIT_BITS']}"


def held(placement: Placement) -> float:
    """The width of the interval of a law that is fitted without a placement, which it holds."""
    law = clock_law(tuple(each for each in PLACEMENTS if each is not placement))
    assert law is not None
    row = placement.row
    period = law.period(row.part, row.family, placement.registers)
    assert period is not None
    width = law.width(row.family)
    assert abs(row.period_ns / period - 1) <= width
    return width


@pytest.mark.parametrize("placement", ECP5, ids=name)
def test_the_interval_of_a_law_without_it_holds_a_placement(placement: Placement) -> None:
    """Fit and interval know neither its size nor its pipeline on the family: ±15 % between others, more at the ends."""
    ends = {f(each.registers.size for each in ECP5) for f in (min, max)}
    assert held(placement) <= (0.35 if placement.registers.size in ends else 0.15)


@pytest.mark.parametrize("placement", DIGITS, ids=name)
def test_the_interval_holds_digits_too(placement: Placement) -> None:
    assert held(placement) <= 0.35


def test_a_large_array_runs_at_180_megahertz() -> None:
    (clock,) = (each.row.clock for each in ECP5 if each.registers.size == 12 * 24 and each.row.variables["PIPELINE"])
    assert clock >= 180e6
