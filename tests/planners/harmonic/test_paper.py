"""Published against modelled: golden errors, what is held out, and figures that come out the same at every run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from findings_page import check_figures, check_statements, figures
from places import ROOT

from codesign.ground.errors import InputError
from codesign.ground.figures import Status
from codesign.hardware.reproduce import plot_svg, write_plots
from codesign.planners import reproduction
from codesign.planners.harmonic.paper import theory
from codesign.planners.harmonic.paper.measures import LAWS, PAPER, HarmonicRuns, Measurement, software_seconds
from codesign.planners.harmonic.paper.theory import (
    bits_a_doubling,
    environments,
    largest_eigenvalue,
    node_power,
    plateau,
    settled_spread,
    slope,
)
from codesign.planners.harmonic.published import HarmonicSettings
from codesign.planners.reproduction import Finding, Plot, Reproduction, Row, Series, Use, silent
from codesign.system import catalog

TOLD: list[str] = []
THEORY = {"Section 3.2.2", "Section 4.2", "Section 4.4.1", "Section 4.4.2"}

GOLDEN = """\
Table 1 flip-flops 11 11 fitted
Table 1 LUT 22 22 fitted
Table 1 slices 13 13 fitted
Table 1 clock 3.61e+08 +0.1% fitted
Table 2 flip-flops 198 198 held out
Table 2 LUT 398 -0.5% held out
Table 2 slices 235 -0.4% held out
Table 2 clock 3e+08 -0.1% fitted
Table 3 flip-flops 50699 50699 fitted
Table 3 LUT 101396 101396 fitted
Table 3 slices 59914 59914 fitted
Table 3 clock 1.5e+08 +0.0% fitted
Section 5.4 logic cells a node 26 26 held out
Section 5.4 logic cells a cluster 470 -0.4% held out
Section 5.4 logic cells of XC2V6000 for 36×66 nodes < 92 % 91.4062 held out
Section 5.4 block RAMs for 36×66 nodes 132 132 held out
Section 5.4 block RAMs for its 204 border nodes 12 12 held out
Section 5.4 slices of XC2V6000, 4 blocks, p = 255 99.4 -0.0% fitted
Section 5.4 precision with 4 blocks 255 255 held out
Section 5.4 word with 1 block (up to 1K bits) 1024 1024 held out
Section 1 blocks of 96×48 with 64 bits 16 16 held out
Section 1 nodes of 16 such blocks 73728 73728 held out
Section 1 block RAMs of XC4VLX160 for a 96×48 block ≤ 288 274 held out
Section 5.4 block RAMs for a 54×108 block, largest FPGA 336 +1.8% held out
Section 5.4 clock of 36×66 nodes on the Virtex-2 board 1.5e+08 +11.3% held out
Section 5.4 speed-up at 128 bits, 100 µs at any precision 100 +15.4% held out
Section 5.4 speed-up at 128 bits, 100 µs a 64-bit limb 100 +246.2% held out
"""


def table_rows() -> list[Row]:
    """The rows of the laws that need no simulation."""
    runs = HarmonicRuns(True, silent, HarmonicSettings())
    vars(runs)["speed"] = (Measurement(4, 16, "sound", 1.0, 1.0, 1.0),)
    speed = ("speed-up, 9", "final", "gain")
    return [row for row in PAPER.rows(runs, LAWS) if not row.quantity.startswith(speed)]


def shown(value: float | str | None) -> str:
    return f"{value:.6g}" if isinstance(value, int | float) else str(value)


def test_rows_that_need_no_simulation_are_golden() -> None:
    lines = []
    for row in table_rows():
        modelled = shown(row.modelled) if not row.error else f"{row.error:+.1%}"
        lines.append(f"{row.table} {row.quantity} {shown(row.published)} {modelled} {row.use}\n")
    assert "".join(lines) == GOLDEN


def test_the_documented_table_is_the_one_that_is_computed(quick: Reproduction) -> None:
    page = (ROOT / "docs" / "reproduction.md").read_text(encoding="utf-8").splitlines()
    # What a quick run takes from the same maps as a full one.
    same = [row for row in quick.rows if row.table in THEORY and not row.quantity.endswith("room")]
    assert len(same) == 13
    for row in (*table_rows(), *same):
        error = "" if row.error is None else "0" if row.error == 0 else f"{row.error:+.1%}".replace("%", " %")
        ending = f"| {error} | {row.use} | {row.note} |"
        assert any(f"| {row.quantity} |" in line and line.endswith(ending) for line in page), row.quantity


@pytest.fixture(scope="module")
def quick() -> Reproduction:
    return catalog.papers()["harmonic"](quick=True, progress=TOLD.append)


def test_quick_run_covers_every_row_of_the_full_one(quick: Reproduction) -> None:
    places = {row.table for row in quick.rows}
    assert {"Table 1", "Table 2", "Table 3", "Section 5.4", "Section 4.5.2"} <= places
    assert {f"Figure {number}" for number in (3, 4, 5, 6)} | THEORY <= places
    assert [plot.name for plot in quick.figures] == ["figure-3", "figure-4", "figure-5", "figure-6"]
    assert any("Figure 5" in line for line in TOLD)


def test_speed_up_of_the_maze_is_golden(quick: Reproduction) -> None:
    speed = {row.quantity: row for row in quick.rows if row.quantity.startswith("speed-up, 9,500")}
    flat = speed["speed-up, 9,500-node maze, flat software"]
    limbs = speed["speed-up, 9,500-node maze, software a limb"]
    assert flat.modelled == pytest.approx(90.45, abs=0.1)
    assert limbs.modelled == pytest.approx(4 * flat.modelled)  # type: ignore[operator]
    assert flat.status is Status.ASSUMED
    assert flat.use is Use.HELD_OUT


def test_every_row_has_a_source_and_errors_are_relative(quick: Reproduction) -> None:
    for row in quick.rows:
        assert row.source
        if row.error is not None:
            assert isinstance(row.published, int | float)
            assert row.modelled == pytest.approx(row.published * (1 + row.error))


def test_fitted_rows_are_those_the_laws_were_made_from(quick: Reproduction) -> None:
    fitted = {(row.table, row.quantity) for row in quick.rows if row.use is Use.FITTED}
    assert len(fitted) == 10
    assert all(
        table in {"Table 1", "Table 2", "Table 3"}
        for table, _ in fitted - {("Section 5.4", "slices of XC2V6000, 4 blocks, p = 255")}
    )


def test_findings_speak_of_the_data(quick: Reproduction) -> None:
    check_statements(quick)
    check_figures(quick, ["The clock law"])
    flat = next(row for row in quick.rows if "flat software" in row.quantity)
    assert figures(quick, "Software of flat cost")["mean with steps of 16 bits"] == f"{flat.modelled:.0f}"
    powers = [row for row in quick.rows if row.table == "Figure 4"]
    measured = figures(quick, "Iterations grow").values()
    assert all(f"{row.modelled:.2f}" in measured for row in powers)


def test_the_headline_leaves_no_miss_out(quick: Reproduction) -> None:
    headline = figures(quick, "The laws meet")
    assumed = [row for row in quick.rows if row.status is Status.ASSUMED and row.error is not None]
    assert len(assumed) == 5
    for row in assumed:
        assert headline[row.quantity] == f"{row.error:+.0%}"
    assert (headline["rows that need none"], headline["of these exact"]) == ("14", "8")


def share_findings(*curves: Series) -> list[Finding]:
    """The findings on Figure 6 where these are its curves."""
    runs = HarmonicRuns(True, silent, HarmonicSettings())
    vars(runs)["shares"] = list(curves)
    named = ("level_soon", "level_left", "smaller_blocks")
    sheet = PAPER.sheet.model_copy(
        update={"findings": tuple(each for each in PAPER.sheet.findings if each.measure in named)}
    )
    return list(PAPER.findings(runs, sheet))


def test_figure_6_gets_a_verdict_on_each_claim() -> None:
    level = (0.1, 0.3, *[0.5] * 16, 0.3, 0.1)
    small = Series("k=2", tuple(range(20)), level)
    assert plateau(small) == (0.1, 0.9)
    larger = Series("k=3", tuple(range(20)), (0.7,) * 20)
    soon, before_the_end, fewer = share_findings(small, larger)
    assert (soon.holds, before_the_end.holds, fewer.holds) == (True, True, False)
    assert before_the_end.figures == {"earliest": "90%", "latest": "100%"}
    assert fewer.figures["mean Î/I, largest blocks"] == "0.44"
    slow = Series("k=2", tuple(range(20)), tuple(index / 20 for index in range(20)))
    assert not share_findings(slow)[0].holds
    assert share_findings(larger, slow)[2].holds


def test_estimates_of_section_4_stand_beside_what_is_counted(quick: Reproduction) -> None:
    rows = {row.quantity: row for row in quick.rows if row.table in THEORY}
    gain, first = rows["K, labyrinth"], rows["k_1 at 255 bits, labyrinth"]
    assert gain.published == pytest.approx(theory.noise_gain(61, 61))
    assert gain.modelled == pytest.approx(16.726, abs=1e-3)
    assert first.published == round(theory.first_iterations(255, theory.noise_gain(61, 61), 1))
    assert first.modelled == 2562
    assert rows["bits for an error below 2^-16, labyrinth"].modelled == 20
    assert rows["time with 4 equal stages over one, labyrinth"].modelled == pytest.approx(0.7156, abs=1e-4)
    assert rows["bits for a corridor of 100 cells"].modelled == 187
    best = rows["time with the best schedule over one stage, labyrinth"].modelled
    assert all(best < row.modelled for name, row in rows.items() if name.endswith("equal stages over one, labyrinth"))


@pytest.mark.parametrize(("rows", "columns"), [(3, 4), (7, 5)])
def test_the_largest_eigenvalue_of_open_ground_is_gamma(rows: int, columns: int) -> None:
    # The goal lies below the rectangle, alone in its row: to the cells above it is one more cell that stays.
    free = np.ones((rows + 1, columns), bool)
    free[-1, 1:] = False
    assert largest_eigenvalue(free, (rows, 0)) == pytest.approx(theory.gamma(rows + 1, columns + 1), rel=1e-9)


def test_json_holds_everything(quick: Reproduction) -> None:
    held = json.loads(quick.to_json())
    assert held["schema_version"] == 1
    assert len(held["rows"]) == len(quick.rows)
    assert held["figures"][0]["series"][0]["x"] == list(quick.figures[0].series[0].x)


def test_plots_are_written_and_the_same_twice(quick: Reproduction, tmp_path: Path) -> None:
    written = write_plots(quick, tmp_path / "new" / "folder")
    assert [path.name for path in written] == [f"figure-{number}.svg" for number in (3, 4, 5, 6)]
    text = written[0].read_text(encoding="utf-8")
    assert text == plot_svg(quick.figures[0])
    assert "<svg" in text
    assert str(tmp_path) not in text


def test_a_folder_that_cannot_be_made_is_told(quick: Reproduction, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write plots"):
        write_plots(quick, tmp_path / "file" / "folder")


def test_environments_are_magnified_cell_by_cell() -> None:
    for small, large in zip(environments(1), environments(3), strict=True):
        assert large.nodes == 9 * small.nodes
        assert (large.free[::3, ::3] == small.free).all()
        assert large.farthest > 2 * small.farthest


def test_shapes_of_known_curves() -> None:
    x = (2.0, 4.0, 8.0, 16.0)
    assert slope(x, [3 * value + 1 for value in x]) == pytest.approx(3)
    assert bits_a_doubling(Series("log", x, (5.0, 7.0, 9.0, 11.0))) == pytest.approx((2.0, 2.0))
    assert node_power(Series("square", x, tuple(value**2 for value in x))) == pytest.approx(2)
    assert settled_spread(Series("flat", x, (0.5,) * 4)) == 0.0


def test_error_is_left_out_where_a_side_is_no_number() -> None:
    assert reproduction.row("T", "q", "< 1", 0.5, status=Status.MEASURED, source="s", use=Use.HELD_OUT).error is None
    assert reproduction.row("T", "q", 2, 3, status=Status.MEASURED, source="s", use=Use.HELD_OUT).error == 0.5


def test_software_takes_100_microseconds_for_a_block_and_400_for_four() -> None:
    assert software_seconds(1, 36 * 66) == pytest.approx(100e-6)
    assert software_seconds(10, 72 * 132) == pytest.approx(4e-3)


def test_plot_escapes_what_it_is_told() -> None:
    plot = Plot("p", "<script>", "", "x", "y", (Series("<b>", (1.0, 2.0), (1.0, 2.0)),))
    assert "<script>" not in plot_svg(plot)
