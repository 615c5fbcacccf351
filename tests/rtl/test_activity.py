"""Toggles counted in a waveform, and what a toggle takes by two public reports."""

from __future__ import annotations

import pytest

from codesign.inputs.part_file import load_part
from codesign.rtl.activity import REPORTS, TYPICAL, count_toggles

WAVES = """
$scope module top $end
$var wire 1 ! clk $end
$var wire 4 " sum $end
$scope module node $end
$var wire 1 # clk $end
$var wire 1 $ changed $end
$upscope $end
$enddefinitions $end
#0
1!
1#
b0000 "
x$
#5
0!
0#
#10
1!
1#
b0110 "
1$
#20
0!
0#
#30
1!
1#
b0111 "
0$
"""


def test_toggles_are_counted_a_bit_and_edge_without_the_clock() -> None:
    counted = count_toggles(WAVES.splitlines())
    assert counted.bits == 5
    assert counted.cycles == 3
    # sum: two bits, then one; changed: from 1 to 0. From unknown to 1 is no toggle.
    assert counted.toggles == 4
    assert counted.rate == pytest.approx(4 / 15)


def test_the_energy_of_a_toggle_is_the_same_in_both_reports() -> None:
    first, second = (report.toggle_energy for report in REPORTS)
    assert first == pytest.approx(second, rel=0.16)
    assert 0.15e-12 < second < first < 0.19e-12


def test_the_power_of_a_slice_of_the_part_is_that_of_the_reports() -> None:
    part = load_part("XC7Z020-1")
    for report in REPORTS:
        by_slice = report.dynamic / (report.clock * report.slices)
        # A slice of the part is two of those that laws count.
        assert part.dynamic_power.value * 2 == pytest.approx(by_slice, rel=0.05)
    assert TYPICAL == 0.125
