"""Dynamic power: the toggles that were counted, the energy of one by public reports, and the interval of both."""

from __future__ import annotations

import pytest
from places import ROOT

from codesign.ground.figures import Status
from codesign.inputs.library import load_part
from codesign.planners.counted import REPORTS, TYPICAL, PowerReport, activity_by, counted_activity, slice_power
from codesign.planners.job import Demand, Line
from codesign.planners.measured import ActivityRow, activity_rows
from codesign.system import catalog

COUNTED = [
    ("breadth_first", "state_machine"),
    ("harmonic", "bit_serial"),
    ("wavefront", "delay_line"),
    ("wavefront", "adder_comparator"),
    ("wavefront", "tiled"),
]
"""Styles with counts. Velocity obstacles keep the power that the paper measured."""


def row(toggles: int, seed: int = 1) -> ActivityRow:
    """A row of 100 nets over 1,000 cycles."""
    return ActivityRow("s", "", "", {}, "design", seed, toggles, 100, 1000, "tools")


def toggle_energy(report: PowerReport) -> float:
    """J a toggle of an output of a LUT or a flip-flop, wires and clock tree with it."""
    return report.dynamic / (report.clock * TYPICAL * (report.luts + report.flip_flops))


def test_the_energy_of_a_toggle_is_the_same_in_both_reports() -> None:
    first, second = (toggle_energy(report) for report in REPORTS)
    assert first == pytest.approx(second, rel=0.16)
    assert 0.15e-12 < second < first < 0.19e-12


def test_the_power_of_a_slice_of_the_part_is_that_of_the_reports() -> None:
    part = load_part("XC7Z020-1")
    for report in REPORTS:
        by_slice = report.dynamic / (report.clock * report.slices)
        # A slice of the part is two of those that laws count.
        assert part.dynamic_power.value * 2 == pytest.approx(by_slice, rel=0.05)


@pytest.mark.parametrize("report", REPORTS)
def test_toggles_times_their_energy_give_the_reports(report: object) -> None:
    """A design at the activity of the reports has their power, on the LUT and flip-flops of either."""
    part = load_part("XC7Z020-1")
    (mine,) = (each for each in REPORTS if each is report)
    (other,) = (each for each in REPORTS if each is not report)
    nets = mine.luts + mine.flip_flops
    assert nets * TYPICAL * toggle_energy(other) * mine.clock == pytest.approx(mine.dynamic, rel=0.17)
    slices = Line.item("all", "slices", 2 * mine.slices, Status.PUBLISHED, "the report")
    _, dynamic = slice_power(Demand(items=(slices,)), int(mine.clock), part)
    assert dynamic.value == pytest.approx(mine.dynamic, rel=0.03)
    low, high = dynamic.interval
    assert low < mine.dynamic < high


def test_an_activity_is_the_mean_and_its_interval_what_a_row_held_out_was_missed_by() -> None:
    activity = activity_by([row(10_000, 1), row(12_000, 2), row(14_000, 3)])
    assert activity is not None
    assert activity.value == pytest.approx(0.12 / TYPICAL)
    # 0.10 is predicted by the mean of 0.12 and 0.14, 0.13; 0.14 by 0.11: 27 % off.
    margin = 1.25 * (0.14 / 0.11 - 1)
    assert activity.interval == pytest.approx((0.96 * (1 - margin), 0.96 * (1 + margin)))
    assert activity_by([]) is None
    alike = activity_by([row(10_000, 1), row(10_000, 2)])
    assert alike is not None
    assert alike.interval == pytest.approx((0.8 * 0.95, 0.8 * 1.05))


@pytest.mark.parametrize(("room", "style"), COUNTED)
def test_every_count_lies_inside_the_interval_of_its_style(room: str, style: str) -> None:
    activity, rows = counted_activity(room, style), activity_rows(room, style)
    assert activity is not None
    assert len(rows) >= 3
    assert activity.status is Status.MEASURED
    low, high = activity.interval
    assert all(low <= each.rate / TYPICAL <= high for each in rows)
    # Far from what any circuit can do, a count would be a mistake.
    assert all(0.01 < each.rate < 0.4 for each in rows)


@pytest.mark.parametrize(("room", "style"), COUNTED)
def test_the_power_of_a_style_follows_from_its_toggles(room: str, style: str) -> None:
    part, activity = load_part("XC7A100T-1"), counted_activity(room, style)
    assert activity is not None
    slices = Line.item("nodes", "slices", 1000, Status.ASSUMED, "made up")
    demand = Demand(items=(slices,))
    _, dynamic = catalog.architectures()[room, style].power(demand, 100_000_000, part)
    assert dynamic.value == pytest.approx(1000 * 1e8 * part.dynamic_power.value * activity.value)
    low, high = dynamic.interval
    assert low < dynamic.value < high
    assert "toggles a net and cycle" in dynamic.source


@pytest.mark.parametrize(("room", "style"), COUNTED)
def test_the_table_of_the_page_has_the_counts(room: str, style: str) -> None:
    page = (ROOT / "docs" / "synthesis.md").read_text(encoding="utf-8")
    activity, rates = counted_activity(room, style), [each.rate for each in activity_rows(room, style)]
    assert activity is not None
    value, low, high = (TYPICAL * each for each in (activity.value, *activity.interval))
    counted = f"{len(rates)} | {min(rates):.3f} to {max(rates):.3f} | {value:.3f} | {low:.3f} to {high:.3f}"
    assert f"| {room} `{style}` | {counted} |" in page
