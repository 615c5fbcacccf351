"""Intervals and verdicts in words: cells, winners, and the table of a run."""

from __future__ import annotations

from dataclasses import replace

import pytest
from shipped_plans import design, on_host, result_of

from codesign.ground.figures import FIGURES, Figure, Status
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study
from codesign.system.verdicts import Fit, need_verdict, winner_verdict
from codesign.views.report import (
    best_table,
    comparison_table,
    front_table,
    render_text,
    winners_certainty_table,
    winners_table,
)
from codesign.views.report.sentences import (
    EXACT,
    HOLDS,
    certainty_table,
    figure_text,
    fit_text,
    verdict_text,
    winner_of,
    winner_text,
)
from codesign.views.report.wording import ends_text, figure_cell

FPGA, ARM, ARTY = design("zynq", "breadth-first"), on_host("zynq", "arm"), design("arty-a7", "breadth-first")
TIME = FIGURES["first_plan_s"]
FLIP = "flips at arm.costs.breadth_first_wall_cell = 84.33 ns (assumed 138 ns, 34.5 to 420)"


@pytest.mark.parametrize(
    ("value", "interval", "text"),
    [
        (0.0123, (0.008, 0.025), "12.3 ms (8 to 25)"),
        (0.0123, (0.0080049, 0.0250001), "12.3 ms (8 to 25.1)"),
        (0.0009, (0.0008, 0.0025), "900 us (800 us to 2.5 ms)"),
        (0.5, (0.5, 0.5), "500 ms"),
        (0.5, None, "500 ms"),
        (None, (1.0, 2.0), "–"),
    ],
)
def test_a_figure_with_its_interval(value: float | None, interval: tuple[float, float] | None, text: str) -> None:
    cell = figure_cell(TIME, value, interval)
    assert (cell.text, cell.value) == (text, value)


def test_ends_are_rounded_outwards() -> None:
    assert ends_text("1 s", 0.99999, 1.00001, "s") == "999 ms to 1.01 s"


def test_a_figure_of_a_part_is_written_as_its_file_writes_it() -> None:
    figure = Figure(2.3e-13, "W/(slice Hz)", Status.ASSUMED, "a guess", 7.5e-14, 5e-13)
    assert figure_text(figure) == "assumed 230 nW, 75 to 500 a slice and MHz"
    assert figure_text(Figure(5, "1", Status.PUBLISHED, "a table")) == "published 5"


def test_verdicts_in_words() -> None:
    results = [result_of(ARM), result_of(FPGA)]
    assert verdict_text(winner_verdict([result_of(ARTY), result_of(FPGA)], TIME)).startswith(HOLDS)
    assert verdict_text(winner_verdict(results, FIGURES["share_reaching_goal"])) == "all others are equal"
    assert verdict_text(winner_verdict(results, FIGURES["cycles"])).startswith("not assessed: the cycles rest")
    assert verdict_text(need_verdict(result_of(FPGA), "block_rams", 1000)) == EXACT
    # A law of slices has an interval.
    assert verdict_text(need_verdict(result_of(FPGA), "slices", 1000)) == HOLDS
    assert verdict_text(need_verdict(result_of(FPGA), TIME, 1e-6)).startswith("fails within all")
    winner = winner_of(["on the ARM", "on the fabric"], results, TIME)
    assert winner is not None
    assert winner_text(winner) == (
        f"least first plan time: on the fabric, {FLIP} against on the ARM; measure arm.costs.breadth_first_wall_cell"
        " first: hwsw calibrate host does it on the machine itself"
    )
    assert winner_of(["alone", "not run"], [results[0], None], TIME) is None


def test_a_number_of_things_flips_at_the_first_whole_one() -> None:
    verdict = need_verdict(result_of(design("zynq", "wavefront-tiles")), TIME, 0.00086)
    assert verdict_text(verdict) == "flips at axi.setup_cycles = 34 (assumed 30, 15 to 60)"


def test_fit_in_words() -> None:
    assert fit_text(Fit(fits="yes", decides="clock")).startswith("yes")
    limit = Figure(150e6, "Hz", Status.CALIBRATED, "a law", 90e6, 200e6)
    fit = Fit(fits="uncertain", decides="clock", demand=(1e8, 1e8), limit=(90e6, 200e6), figure=limit)
    assert fit_text(fit) == "uncertain: clock 100 MHz against a limit of 90 MHz to 200 MHz"


def test_the_table_of_a_run_names_what_moves_each_figure_most() -> None:
    table = certainty_table(result_of(ARM))
    rows = {row[0].text: row[-1].text for row in table.rows}
    assert rows["first plan time"] == "arm.costs.breadth_first_wall_cell (assumed 138 ns, 34.5 to 420)"
    display = certainty_table(result_of(design("virtex2pro-vga", "breadth-first")))
    assert display.rows[0][-1].text.startswith("a display takes cycles")


def study() -> Study:
    outcomes = Outcomes.of([result_of(FPGA), result_of(ARM)])
    axes = {"workload.variant": ("base", "on-arm"), "fpga.clock": ("100 MHz",)}
    return Study("zynq", "breadth-first", axes, (TIME, FIGURES["energy_j"]), (), outcomes)


def test_the_tables_of_a_study_say_how_sure_its_winners_are() -> None:
    winners = winners_table(study())
    assert winners is not None
    assert [row[-1].text for row in winners.rows] == [FLIP]
    best = best_table(study())
    assert (best.columns[-1].name, best.rows[0][-1].text) == ("how sure", FLIP)
    assert "680.5 us (677 to 687)" in render_text(front_table(study()), 200)


def test_a_winner_that_may_not_reach_its_clock_wins_if_it_fits() -> None:
    tiles = [result_of(design("zynq", "wavefront-tiles")), result_of(design("virtex4-pci", "wavefront-tiles"))]
    assert verdict_text(winner_verdict(tiles, FIGURES["energy_j"])) == f"{HOLDS}, if the design fits"


def test_the_best_points_of_a_study_and_their_rivals() -> None:
    table = winners_certainty_table(study())
    assert [row[1].value for row in table.rows] == [0, 0]
    assert [cell.text for cell in table.rows[0][2:]] == ["680.5 us (677 to 687)", FLIP, "1"]
    assert winners_certainty_table(replace(study(), objectives=(FIGURES["slices"],))).rows == ()


def test_compare_says_how_sure_its_winner_is() -> None:
    table = comparison_table([("fabric", result_of(FPGA)), ("arm", result_of(ARM))])
    assert any(note.startswith(f"least worst plan time: fabric, {FLIP} against arm") for note in table.notes)
