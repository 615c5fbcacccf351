"""The record of measured rows, and the fits of laws to it."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from codesign.hardware.fidelity.points import OTHERS, TOTAL, job_of, laws_of, resource_points, resources, rooms
from codesign.inputs.library import load_part
from codesign.planners.counted import CountedLaws
from codesign.planners.measured import ClockRow, Point, ResourceRow, family_of, fit, rows_text


def row(rows: int, columns: int, lut4: int, family: str = "ecp5") -> ResourceRow:
    pieces = {"nodes": {"lut4": lut4}}
    return ResourceRow("style", "", family, "digest", {"ROWS": rows, "COLUMNS": columns}, pieces, "tools")


def test_a_fit_finds_the_law_and_holds_rows_out() -> None:
    sizes = [(3, 6), (6, 12), (12, 12), (12, 24)]
    rows = [row(n, m, 9 * n * m + 4 * (n + m) + 7) for n, m in sizes]
    rows += [row(24, 24, 2 * (9 * 24 * 24 + 4 * 48 + 7)), row(6, 6, 1, "xc7")]
    laws = CountedLaws("no room", "toy")
    pieces = {"nodes": {"lut4": "(ROWS * COLUMNS, sides, 1)"}}
    table = {"define": {"sides": "ROWS + COLUMNS"}, "held_out": "ROWS == 24", "pieces": pieces}
    vars(laws).update(table=table, rows=tuple(rows))
    law = laws.fit("nodes", "lut4", rows[0].variables, "ecp5")
    assert law.coefficients == pytest.approx((9, 4, 7))
    assert max(map(abs, law.residuals)) < 1e-9
    assert law.held_out == (pytest.approx(-0.5),)
    assert law.worst == law.mean == pytest.approx(0.5)


def test_a_fit_weighs_small_values_as_much_as_large_ones() -> None:
    law = fit([Point((1,), 10), Point((1,), 1000)])
    assert law.value((1,)) < 30


def test_a_line_that_a_row_lacks_counts_nothing() -> None:
    assert row(1, 1, 5).count("decision", "lut4") == row(1, 1, 5).count("nodes", "block_rams") == 0


def test_rows_are_read_as_they_are_written() -> None:
    placed = ClockRow(
        "style", "", "ecp5", "LFE5U-85F-8", "digest", {"ROWS": 1}, {"lut4": 7}, [180_000_000, 190_000_000, 100_000_000],
        "memory", 3.6, 2, 0.5, 1.2, 0.1, "a path", "tools",
    )  # fmt: skip
    assert ClockRow(**json.loads(rows_text([placed]))[0]) == placed
    assert placed.clock == 180e6
    assert replace(placed, clocks=[1]).key == placed.key
    assert [ResourceRow(**each) for each in json.loads(rows_text([row(1, 2, 3)]))] == [row(1, 2, 3)]


def test_families_of_parts_have_rows_of_their_own_or_the_nearest() -> None:
    assert family_of("Virtex-4") == ("xc4v", True)
    assert family_of("Zynq UltraScale+") == ("xc7", False)


PUBLISHED = {"harmonic": {"xc2v", "xc4v"}, "velocity_obstacle": {"xc3se"}}
"""Families whose lines are those of a paper in part: they are another circuit."""


@pytest.mark.parametrize("room", rooms())
def test_every_count_lies_in_the_interval_of_its_law(room: str) -> None:
    points = [point for point in resource_points(room) if point.family not in PUBLISHED.get(room, ())]
    assert points
    for point in points:
        if point.line not in (OTHERS, TOTAL):
            assert point.holds, (point.design, point.line, point.quantity, point.predicted, point.measured)
        low, high = point.predicted.interval
        assert low <= point.predicted.value <= high
        # The papers' figures are exact; every other count of LUT is that of a law.
    assert any(point.predicted.interval[0] < point.predicted.value for point in points)


@pytest.mark.parametrize(
    ("room", "own", "without"),
    [
        ("harmonic", "LFE5U-85F-8", "MPFS250T-STD"),
        ("breadth_first", "XC7Z020-1", "XCZU7EV-2"),
        ("wavefront", "LFE5U-85F-8", "MPFS250T-STD"),
        ("velocity_obstacle", "LFE5U-85F-8", "MPFS250T-STD"),
    ],
)
def test_a_family_without_rows_has_the_same_counts_in_wider_intervals(room: str, own: str, without: str) -> None:
    design = next(each for each in resources(room) if not each.task)
    widths = []
    for name in (own, without):
        demand = laws_of(room, design).demand(job_of(room, design, load_part(name)))
        lines = [line for line in demand.items if line.resource == "lut4"]
        low, high = (sum(line.figure.interval[end] for line in lines) for end in (0, 1))
        widths.append((demand.total("lut4"), high - low))
    assert widths[0][0] == widths[1][0]
    assert 0 < widths[0][1] < widths[1][1]


def test_a_law_is_as_far_off_as_its_rows_and_a_quarter_more() -> None:
    law = fit([Point((1.0,), 100), Point((1.0,), 110, held=True)], [Point((1.0,), 50)])
    assert law.coefficients == pytest.approx((100,))
    low, high = law.ends(1000)
    assert low <= 1000
    assert 1100 <= high <= 1100 * 1.05
    assert law.ends(1000, own=False)[0] <= 500
    assert law.ends(0) == (0, 0)
