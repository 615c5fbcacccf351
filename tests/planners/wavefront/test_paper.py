"""Möller and Paschke (1998) reproduced: published figures as printed, and what the model makes of them."""

from __future__ import annotations

import json
import math

import pytest
from findings_page import check_figures, check_statements

from codesign.planners.reproduction import Reproduction, Use
from codesign.planners.wavefront.paper.measures import COSTS, PAPER, largest_error, potential_ratio


@pytest.fixture(scope="module")
def quick() -> Reproduction:
    return PAPER(quick=True)


def modelled(reproduction: Reproduction, quantity: str) -> float:
    (found,) = [row.modelled for row in reproduction.rows if row.quantity == quantity]
    assert isinstance(found, int | float)
    return found


def test_every_figure_of_the_paper_has_its_row(quick: Reproduction) -> None:
    published = [row.published for row in quick.rows]
    for figure in (1355, 1356, 68e-6, 63e-3, 1000, 768, 38e-6, 3):
        assert figure in published


def test_rows_that_must_hold_exactly(quick: Reproduction) -> None:
    assert modelled(quick, "cycle of the stop") == 1356
    assert modelled(quick, "nodes that differ from Dijkstra's potentials") == 0
    assert modelled(quick, "safe ways that arrive") == 100
    assert modelled(quick, "cycles of the obstacle map") == 766
    assert modelled(quick, "flip-flops of all nodes") == 1_048_576
    (clocked,) = [row for row in quick.rows if "circuit clocked" in row.quantity]
    assert clocked.published == f"D + 1 = {clocked.modelled}"
    assert clocked.note.startswith("0 registers differ")


def test_times_and_speed_up_are_near_the_printed_ones(quick: Reproduction) -> None:
    for row in quick.rows:
        if isinstance(row.published, int | float) and row.table != "Conclusion":
            assert row.error is not None
            assert abs(row.error) < 0.1, row.quantity
    assert not [
        row for row in quick.rows if row.use is not Use.FITTED and row.quantity == "time on the 133 MHz Pentium"
    ]


def test_generated_maps_come_near_the_published_path(quick: Reproduction) -> None:
    found = [row.modelled for row in quick.rows if row.quantity.startswith("potential of the stop node")]
    assert len(found) == 2
    assert all(abs(float(value) / 1355 - 1) < 0.02 for value in found if value is not None)


def test_the_approximation_errors_are_those_of_their_octagons() -> None:
    for costs in COSTS.values():
        worst = max(potential_ratio(angle / 100, *costs) for angle in range(9001)) - 1
        assert largest_error(costs) == pytest.approx(worst, abs=1e-6)
    assert largest_error((1.0, 1.5)) == pytest.approx(math.sqrt(1.25) - 1)


def test_it_is_told_in_words_and_as_json(quick: Reproduction) -> None:
    check_statements(quick, {"The adder/comparator array takes fewer cycles than the wave."})
    check_figures(quick, ["The published speed-up", "The obstacle map", "Safe paths need", "The error of 2:3"])
    assert json.loads(quick.to_json())["paper"].startswith("Möller")
    assert {plot.name for plot in quick.figures} == {"wave-front", "delays"}
    assert quick == PAPER(quick=True)
