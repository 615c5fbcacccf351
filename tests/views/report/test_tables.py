from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest
from report_samples import QUALITY, a_hopeless_study, a_reproduction, a_result, a_study, a_task

from codesign.ground.errors import CodesignError, Fault, SpecError
from codesign.ground.figures import FIGURES, Figure, Status
from codesign.planners.interface import Quality
from codesign.study.outcomes import Outcomes
from codesign.system.results.result import DisplayUse, Reason, Result
from codesign.views.report import (
    best_table,
    comparison_table,
    findings_table,
    front_table,
    infeasible_table,
    nearest_table,
    reasons_table,
    render_text,
    reproduction_sources_table,
    reproduction_table,
    result_tables,
    study_csv,
    study_table,
    write_study_csv,
)
from codesign.views.report.axes import fixed_axes, short_names, varying_axes
from codesign.views.report.reproduction_page import error_text
from codesign.views.report.study_tables import study_counts, summary
from codesign.views.report.winners_table import winners_table
from codesign.views.report.wording import Cell, Column, Table

FRONT = """\
Front
point   block   iterations   schedule       first plan time   slices   block RAMs     energy   share reaching goal
──────────────────────────────────────────────────────────────────────────────────────────────────────────────────
   17   36×66   11           15, 31                    4 ms   32,481          144   7.168 mJ               97.62 %
   11   24×44   11           15, 31                    8 ms   15,321          144   5.408 mJ               97.62 %
   16   36×66   11           7 to 63 by 8          8.129 ms   32,577          144   14.57 mJ               98.65 %
   10   24×44   11           7 to 63 by 8          16.26 ms   15,417          144   10.99 mJ               98.65 %
    5   12×22   11           15, 31                   24 ms    5,025          144   4.352 mJ               97.62 %
    4   12×22   11           7 to 63 by 8          48.77 ms    5,121          144   8.844 mJ               98.65 %
24 design points: 18 feasible, 6 infeasible, 6 on the front
the same for all: fpga.part XC2V6000-4
"""

RESOURCES = """\
Resources
resource     item       demand   budget      used     gap   status
──────────────────────────────────────────────────────────────────────
slices       all        40,000   33,792   118.4 %   6,208
             nodes      39,156                              published
             control       844                              published
block RAMs   all           144      144     100 %       0
             clusters      144                              calibrated
"""

REASONS = """\
Why it is not feasible
kind       what     demand    limit     gap   what would close the gap
────────────────────────────────────────────────────────────────────────────────────────
resource   slices   40,000   33,792   6,208   block: at most 36×66 fits; part: XC4VLX160
"""

REPRODUCTION = """\
Published against modelled
table         quantity                    published   modelled    error   status       use        note
────────────────────────────────────────────────────────────────────────────────────────────────────────────────────
Table 3       slices of 4,608 nodes          59,914     59,914      0 %   calibrated   fitted
              flip-flops of 4,608 nodes      50,699     50,699      0 %   calibrated   fitted
Section 5.4   speed-up at 128 bits              100       97.4   -2.6 %   calibrated   held out   flat software cost
              clock of a 48×96 block        150 MHz          –        –   assumed      held out
"""


def named(tables: tuple[Table, ...], title: str) -> Table:
    return next(table for table in tables if table.title == title)


def values(table: Table, column: str) -> list[object]:
    place = [known.name for known in table.columns].index(column)
    return [row[place].value for row in table.rows]


def test_the_front_table_reads_as_agreed() -> None:
    assert render_text(front_table(a_study())) == FRONT


def test_resources_and_reasons_read_as_agreed() -> None:
    tables = result_tables(a_result(slices=40_000))
    assert render_text(named(tables, "Resources")) == RESOURCES
    assert render_text(named(tables, "Why it is not feasible")) == REASONS


def test_the_reproduction_reads_as_agreed() -> None:
    assert render_text(reproduction_table(a_reproduction())) == REPRODUCTION
    assert render_text(findings_table(a_reproduction())).splitlines()[3:] == [
        "Tables 1 to 3 are met exactly.   yes     rows     12"
    ]
    assert values(reproduction_sources_table(a_reproduction()), "tables") == ["Table 3, Section 5.4", "Section 5.4"]


@pytest.mark.parametrize(
    ("error", "text"),
    [(0.0, "0 %"), (1e-9, "<0.001 %"), (9e-5, "+0.009 %"), (-0.0043, "-0.43 %"), (0.996, "+100 %"), (2.46, "+246 %")],
)
def test_errors_are_told_with_their_sign_and_no_exponent(error: float, text: str) -> None:
    assert error_text(error) == text


def test_the_energy_of_a_plan_is_divided_by_what_took_it() -> None:
    table = named(result_tables(a_result(energy=0.004)), "Energy of the run")
    rows = [[cell.value for cell in row] for row in table.rows]
    assert rows == [["FPGAs", 0.003, 0.75], ["processors", 0.001, 0.25], ["all", 0.004, 1.0]]
    assert table.strong == {2}


def test_what_a_processor_costs_stands_beside_its_power() -> None:
    figure = Figure(2e-9, "s", Status.ASSUMED, "a guess", 1e-9, 3e-9)
    table = named(result_tables(a_result(processor={"cost of relaxation_cell": figure})), "Clock and power")
    rows = [[cell.text for cell in row] for row in table.rows]
    assert ["cost of relaxation cell", "2 ns", "1 ns to 3 ns", "assumed"] in rows


def test_a_point_that_was_never_run_has_no_tables_of_a_run() -> None:
    titles = [table.title for table in result_tables(a_result(slices=40_000))]
    assert titles == [
        "Design point",
        "Why it is not feasible",
        "Resources",
        "Clock and power",
        "Where the figures come from",
    ]


def test_cycles_by_phase_add_up() -> None:
    table = named(result_tables(a_result()), "Clock cycles by phase")
    *phases, total = values(table, "cycles")
    assert total == sum(phases) == 9504 + 435_000 + 1_022  # type: ignore[arg-type]
    assert table.strong == {len(phases)}


def test_every_source_stands_once_and_names_its_figures() -> None:
    table = named(result_tables(a_result()), "Where the figures come from")
    assert values(table, "status") == ["published", "calibrated", "calibrated", "assumed", "assumed"]
    assert table.rows[0][1].text == "slices: nodes, control"


def test_an_interval_shows_only_where_there_is_one() -> None:
    table = named(result_tables(a_result()), "Clock and power")
    intervals = {row[0].text: row[2].text for row in table.rows}
    assert intervals["clock limit"] == "140 MHz to 165 MHz"
    assert intervals["dynamic power of the FPGA"] == ""


def test_axes_that_vary_are_columns_and_the_others_a_note() -> None:
    study = a_study()
    assert varying_axes(study) == ("relax.block", "relax.iterations", "relax.schedule")
    assert fixed_axes(study) == (("fpga.part", "XC2V6000-4"),)
    names = [column.name for column in study_table(study).columns]
    assert names[:4] == ["point", "block", "iterations", "schedule"]


def test_the_csv_of_a_study_has_raw_numbers_with_units_in_their_names() -> None:
    study = a_study()
    table = study_csv(study)
    names = [column.name for column in table.columns]
    assert {"relax.block", "fpga.part", "cycles", "power_w", "energy_j", "share_reaching_goal"} <= set(names)
    assert names[-1] == "why_not"
    assert {column.unit for column in table.columns} == {""}
    assert values(table, "first_plan_s") == [point.figure(FIGURES["first_plan_s"]) for point in study.points]
    assert values(table, "feasible") == [point.feasible for point in study.points]
    assert [i for i, on_front in enumerate(values(table, "on_front")) if on_front] == list(study.front)


def test_axes_with_the_same_last_word_keep_their_full_names() -> None:
    assert short_names(["fpga.clock", "host.clock", "relax.block"]) == ("fpga.clock", "host.clock", "block")


def test_failed_and_missing_points_are_counted_and_told() -> None:
    study = a_study()
    rest = [point.result for point in study.points[2:]]
    outcomes = Outcomes.of(["RunError: <b>out of memory</b>", None, *rest])
    broken = replace(study, outcomes=outcomes)
    assert dict(study_counts(broken))["failed"] == dict(study_counts(broken))["not computed"] == "1"
    assert "1 failed, 1 not computed" in summary(broken)
    why = values(infeasible_table(broken), "why")
    assert why[0] == "failed: RunError: <b>out of memory</b>"
    assert "not computed" not in why
    assert infeasible_table(broken).notes == study_table(broken).notes[:1] == ("1 point not computed",)
    assert 1 not in values(study_table(broken), "point")
    assert any(row[0].text == "failure" for row in reasons_table(broken).rows)


def test_counts_add_up_to_all_points() -> None:
    counts = dict(study_counts(a_study()))
    assert int(counts["explored"]) == int(counts["feasible"]) + int(counts["infeasible"])


def test_reasons_are_counted_with_their_least_gap_and_its_levers() -> None:
    table = reasons_table(a_study())
    assert [cell.value for cell in table.rows[0]] == [
        "resource",
        "slices",
        6,
        56_505 - 33_792,
        19,
        "block: at most 36×66 fits; part: XC4VLX160",
    ]
    assert values(nearest_table(a_study()), "point") == [19, 21, 23]


def test_a_row_of_reasons_is_of_one_point() -> None:
    """The levers stand beside the gap that they close, though another point's are more frequent."""

    def short(gap: int, *levers: str) -> Reason:
        return Reason(kind="resource", name="block_rams", demand=144 + gap, limit=144, gap=gap, unit="", levers=levers)

    far, near = (a_result(slices=99_999, reasons=(each,)) for each in (short(90, "far"), short(2, "near")))
    outcomes = Outcomes.of([far, far, near, far, near, "no such_file: x"])
    study = replace(a_study(), axes={"a.b": tuple(range(6))}, constraints=(), outcomes=outcomes)
    table = reasons_table(study)
    assert [[cell.text for cell in row] for row in table.rows] == [
        ["resource", "block RAMs", "5", "2", "2", "near"],
        ["failure", "no such_file: x", "1", "–", "5", "–"],
    ]


def test_the_best_in_each_objective_is_best_and_on_the_front() -> None:
    study = a_study()
    table = best_table(study)
    for figure, row in zip(study.objectives, table.rows, strict=True):
        chosen = study.points[row[1].value]  # type: ignore[index]
        known = [study.points[i].figure(figure) for i in study.feasible]
        best = (max if figure.maximise else min)(value for value in known if value is not None)
        assert chosen.figure(figure) == best
        assert chosen.index in study.front
    assert [row[0].text for row in table.rows][::4] == ["least first plan time", "most share reaching goal"]


def test_a_front_that_rises_is_listed_from_the_top() -> None:
    study = replace(a_study(), objectives=(FIGURES["share_reaching_goal"], FIGURES["first_plan_s"]))
    shares = values(front_table(study), "share reaching goal")
    assert shares == sorted(shares, reverse=True)  # type: ignore[type-var]


def test_a_study_with_nothing_feasible_or_nothing_at_all_has_tables() -> None:
    study = a_study()
    hopeless = a_hopeless_study()
    assert front_table(hopeless).rows == best_table(hopeless).rows == ()
    empty = replace(study, axes={"a.b": ()}, outcomes=Outcomes.of([]), objectives=())
    assert front_table(empty).rows == study_table(empty).rows == reasons_table(empty).rows == ()


def test_a_comparison_shows_multiples_of_the_first() -> None:
    results = [("a", a_result()), ("b", a_result(time_s=0.00642)), ("c", a_result(slices=50_000))]
    table = comparison_table(results)
    rows = {row[0].text: row[1:] for row in table.rows}
    assert [cell.text for cell in rows["first plan time"]] == ["3.21 ms", "6.42 ms (×2)", "–"]
    assert [cell.value for cell in rows["feasible"]] == [True, True, False]
    assert rows["slices"][2].text == "50,000 (×1.59)"


def test_a_comparison_is_with_the_first_design_that_has_a_plan() -> None:
    lost = a_result(time_s=0.001, quality=Quality(**(QUALITY | {"share_reaching_goal": 0.5, "starts_arrived": 0})))
    fault = Fault("a.yaml", 3, 1, "relax.block", "a block of 36 × 66 nodes on a map of 40 × 60 cells", "change block")
    results: list[tuple[str, Result | CodesignError]] = [
        ("refused", SpecError([fault])),
        ("large", a_result(slices=50_000)),
        ("lost", lost),
        ("base", a_result()),
        ("slow", a_result(time_s=0.00642)),
    ]
    table = comparison_table(results)
    rows = {row[0].text: [cell.text for cell in row[1:]] for row in table.rows}
    assert rows["feasible"] == ["not run", "no", "yes", "yes", "yes"]
    assert rows["starts that arrive"] == ["–", "–", "0 of 64", "63 of 64", "63 of 64"]
    assert rows["first plan time"] == ["–", "–", "1 ms (×0.312)", "3.21 ms", "6.42 ms (×2)"]
    why = zip(*([c.text for c in row[1:]] for row in table.rows if row[0].text in {"why infeasible", ""}), strict=True)
    assert [" ".join(lines).strip() for lines in why] == [fault.what, "slices: 50,000 against 33,792", "–", "–", "–"]
    assert "in brackets: as a multiple of base" in table.notes
    alone = comparison_table(results[:3])
    assert not any("×" in cell.text for row in alone.rows if row[0].text == "first plan time" for cell in row)
    assert not any("in brackets" in note for note in alone.notes)


def test_a_plan_that_fails_is_told_beside_feasible() -> None:
    def overview(arrived: int) -> dict[str, str]:
        result = a_result(quality=Quality(**(QUALITY | {"share_reaching_goal": 0.5, "starts_arrived": arrived})))
        return {row[0].text: row[1].text for row in result_tables(result)[0].rows}

    assert overview(0)["starts that arrive"] == "0 of 64"
    assert overview(63)["starts that arrive"] == "63 of 64"
    assert "starts that arrive" not in overview(64)


def test_what_displays_read_is_told() -> None:
    use = DisplayUse(frames=12, starved_words=3456, port_share=0.25)
    table = named(result_tables(a_result(displays={"screen": use})), "Displays")
    assert [[cell.value for cell in row] for row in table.rows] == [["screen", 12, 3456, 0.25]]
    assert all(table.title != "Displays" for table in result_tables(a_result(displays={})))


def test_a_figure_of_quality_has_the_unit_that_its_field_declares() -> None:
    quality = Quality(share_reaching_goal=0.5, **QUALITY)
    rows = {row[0].text: row[1].text for row in named(result_tables(a_result(quality=quality)), "Plan quality").rows}
    assert (rows["clearance, mean"], rows["clearance, least"]) == ("1.7 cells", "0.5 cells")


def test_path_length_ratios_say_what_the_shortest_is() -> None:
    notes = named(result_tables(a_result()), "Plan quality").notes
    assert notes == ("path length: the shortest is 8-connected without corner cutting",)
    assert notes[0] in comparison_table([("a", a_result())]).notes


def test_a_row_of_the_wrong_length_is_refused() -> None:
    with pytest.raises(ValueError, match="row 0 of 'T' has 1 cells, not 2"):
        Table("T", (Column("a"), Column("b")), ((Cell("1"),),))


def test_results_side_by_side_say_what_was_asked() -> None:
    planned = [a_result(time_s=time).model_copy(update={"task": a_task()}) for time in (0.001, 0.002)]
    table = comparison_table([("one", planned[0]), ("two", planned[1])])
    asked = "asked: task path, from each of 64 starts; maze of 72 × 132 cells, goal (3, 128)"
    assert table.title == f"Comparison, {asked}"
    study = a_study()
    outcomes = Outcomes.of(
        [
            point.result.model_copy(update={"task": a_task(question=str(point.index % 2))})
            for point in study.points
            if point.result is not None
        ]
    )
    assert front_table(replace(study, outcomes=outcomes)).notes[0].startswith("2 different questions were asked")
    winners = winners_table(replace(study, outcomes=outcomes), axis="relax.schedule")
    assert winners is not None
    assert {row[-1].text.count("another question") for row in winners.rows} == {2}
    assert winners.notes[0].endswith("none in 12")


def test_figures_of_cells_are_compared_where_every_plan_covers_all_cells() -> None:
    result = a_result()
    assert isinstance(result.quality, Quality)
    quality = replace(result.quality, planned_cells=result.quality.reachable_cells)
    whole = result.model_copy(update={"quality": quality})
    stopped = whole.model_copy(update={"quality": replace(quality, planned_cells=1)})
    shown, without = (comparison_table([("one", whole), ("two", two)]) for two in (whole, stopped))
    assert "share reaching goal" in {row[0].text for row in shown.rows}
    assert "share reaching goal" not in {row[0].text for row in without.rows}
    assert any(note.startswith("left out: share reaching goal") for note in without.notes)


def test_points_are_written_in_blocks_as_they_are_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study = a_study()
    write_study_csv(study, tmp_path / "whole.csv")
    monkeypatch.setattr(sys.modules[write_study_csv.__module__], "_ROWS_AT_ONCE", 7)
    write_study_csv(study, tmp_path / "parts.csv")
    assert (tmp_path / "parts.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    assert len((tmp_path / "whole.csv").read_text(encoding="utf-8").splitlines()) == 25
