"""The clock laws of all styles on families that they were not fitted to: the interval holds what was placed there."""

from __future__ import annotations

import numpy as np
import pytest

from codesign.figures import Figure, Status
from codesign.inputs import load_platform
from codesign.inputs.part_file import load_part
from codesign.part import Part
from codesign.planners.breadth_first.plan.parameters import SearchParameters
from codesign.planners.breadth_first.styles.state_machine import StateMachine
from codesign.planners.clock_law import MEASURED, on_family
from codesign.planners.harmonic.styles import timing as harmonic
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.velocity_obstacle.styles import timing as robots
from codesign.planners.wavefront.styles import timing as wave
from codesign.scenarios import simulate
from codesign.system import catalog

PROBLEM = Problem(np.ones((1, 2), bool), ((0, 0),), ((0, 1),))


def of_family(family: str, megahertz: int = 400) -> Part:
    """A part of a family with block RAM of that clock."""
    part = load_part("XC7A35T-1")
    ram = Figure(megahertz * 10**6, "Hz", Status.PUBLISHED, "a data sheet")
    return part.model_copy(update={"family": family, "block_ram_clock": ram})


PLACED = (
    ("ECP5", 6, 12, 89.9e6),
    ("ECP5", 12, 24, 89.4e6),
    ("ECP5", 6, 12, 187.1e6),
    ("ECP5", 12, 24, 180.5e6),
    ("GW2A", 6, 12, 194.6e6),
    ("GW2A", 6, 12, 282.8e6),
)
"""Blocks of harmonic control, placed and routed by nextpnr 0.11.1: family, rows, columns, Hz."""


@pytest.mark.parametrize(("family", "rows", "columns", "hertz"), PLACED)
def test_the_interval_holds_what_was_placed(family: str, rows: int, columns: int, hertz: float) -> None:
    limit = harmonic.clock_limit(rows, columns, of_family(family))
    low, high = limit.interval
    assert low < hertz < high
    assert limit.status is Status.ASSUMED
    assert MEASURED in limit.source
    assert f"not to {family}" in limit.source


def test_the_search_holds_what_was_placed_on_ecp5() -> None:
    """75 MHz for 100 × 100 cells on an LFE5U-85F-6."""
    limit = StateMachine().clock_limit(Job(PROBLEM, SearchParameters(), part=of_family("ECP5")))
    assert limit.interval[0] < 75e6 < limit.value == 185e6


@pytest.mark.parametrize("family", ["Virtex-II", "Virtex-4"])
def test_the_families_of_the_published_clocks_keep_the_interval_of_the_fit(family: str) -> None:
    limit = harmonic.clock_limit(36, 66, of_family(family))
    assert limit.interval[0] == pytest.approx(limit.value * (1 - 2 * harmonic.clock_miss()))
    assert limit.status is Status.CALIBRATED


@pytest.mark.parametrize("family", ["Artix-7", "iCE40", "PolarFire SoC"])
def test_every_law_is_wider_on_another_family(family: str) -> None:
    part = of_family(family)
    for limit in (
        harmonic.clock_limit(6, 12, part),
        wave.clock_limit(256, part),
        StateMachine().clock_limit(Job(PROBLEM, SearchParameters(), part=part)),
        robots.clock_limit(part),
    ):
        assert limit.interval[0] <= limit.value / 3
        assert limit.interval[1] >= limit.value
        assert f"not to {family}" in limit.source


def test_the_high_end_stays_below_the_block_ram() -> None:
    limit = Figure(150, "Hz", Status.CALIBRATED, "a fit", 120, 150)
    part = of_family("ECP5", 1)
    slow = part.model_copy(update={"block_ram_clock": Figure(155, "Hz", Status.PUBLISHED, "a data sheet")})
    assert on_family(limit, slow, "Virtex-4").interval == (50.0, 155)
    assert on_family(limit, part, "Virtex-4").interval == (50.0, 150 * 1.1)


def test_a_result_says_that_its_clock_is_not_sure() -> None:
    workload = catalog.load_workload("breadth-first")
    result = simulate(load_platform("arty-a7"), workload)
    assert result.clock is not None
    assert result.clock.limit.interval[0] < result.clock.hz <= result.clock.limit.value
    (note,) = (note for note in result.notes if note.startswith("fpga.clock"))
    assert "not sure that the design runs at 100 MHz; the limit is 185 MHz by its law" in note
    assert "as low as 61.67 MHz" in note
