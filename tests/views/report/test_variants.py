"""Who wins where."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import pytest
from explore_fakes import mission, result

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study
from codesign.system.results.result import Result
from codesign.views.report import render_text, study_csv, study_table, winners_table
from codesign.views.report.axes import axis_levels
from codesign.views.report.study_page import chart_data, study_html

F = FIGURES
SIZES = (10, 100, 1000)


def study(
    cells: Mapping[tuple[str, int], Result | None],
    objectives: tuple[ResultFigure, ...] = (F["first_plan_s"], F["slices"]),
) -> Study:
    """A point for each variant and size; where there is none, one whose computation failed."""
    variants = tuple(dict.fromkeys(name for name, _ in cells))
    axes: dict[str, tuple[Any, ...]] = {
        "workload.variant": variants,
        "map.rows": tuple(dict.fromkeys(rows for _, rows in cells)),
        "fpga.clock": ("100 MHz",),
    }
    outcomes = [cells[variant, rows] or "too large" for variant, rows, _ in itertools.product(*axes.values())]
    return Study("bench", "maze", axes, objectives, (), Outcomes.of(outcomes))


UNPRICED = "not assessed: the result has no terms"
EXACT = "holds: it rests on no assumed figure"

CROSSING = {
    ("base", 10): result(seconds=0.004, slices=50),
    ("base", 100): result(seconds=0.010, slices=50),
    ("base", 1000): result(slices=500, fits=False),
    ("on-host", 10): result(seconds=0.001, slices=0),
    ("on-host", 100): result(seconds=0.025, slices=0),
    ("on-host", 1000): result(seconds=2.5, slices=0),
}


def texts(table: Any) -> list[list[str]]:
    return [[cell.text for cell in row] for row in table.rows]


def test_the_winner_of_each_setting_and_by_how_much() -> None:
    table = winners_table(study(CROSSING))
    assert table is not None
    assert table.title == "Best variant by setting: least first plan time"
    assert [column.name for column in table.columns] == [
        "rows", "best", "first plan time", "runner-up", "its first plan time", "times better", "how sure", "left out",
    ]  # fmt: skip
    assert texts(table) == [
        ["10", "on-host", "1 ms", "base", "4 ms", "4", UNPRICED, ""],
        ["100", "base", "10 ms", "on-host", "25 ms", "2.5", UNPRICED, ""],
        ["1000", "on-host", "2.5 s", "–", "–", "–", "–", "base: infeasible"],
    ]
    assert table.rows[1][5].value == 2.5
    assert table.notes == (
        "least first plan time, of 3 settings: on-host in 2, base in 1",
        "least slices, of 3 settings: on-host in 3",
    )
    assert "times better" in render_text(table)


def test_most_is_best_where_more_is_better() -> None:
    cells = {("base", 10): result(share=0.9), ("on-host", 10): result(share=0.45)}
    table = winners_table(study(cells), F["share_reaching_goal"])
    assert table is not None
    assert table.title.endswith("most share reaching goal")
    assert texts(table) == [["base", "90 %", "on-host", "45 %", "2", EXACT]]


def test_equals_win_together_and_nobody_is_said_too() -> None:
    cells = {
        ("base", 10): result(seconds=1), ("b", 10): result(seconds=1), ("c", 10): result(seconds=3),
        ("base", 20): result(seconds=1), ("b", 20): result(seconds=1), ("c", 20): result(seconds=1),
        ("base", 30): None, ("b", 30): result(fits=False, slices=200), ("c", 30): None,
    }  # fmt: skip
    table = winners_table(study(cells))
    assert table is not None
    assert [row[1:] for row in texts(table)] == [
        ["base = b", "1 s", "c", "3 s", "3", UNPRICED, ""],
        ["base = b = c", "1 s", "–", "–", "–", UNPRICED, ""],
        ["–", "–", "–", "–", "–", "–", "base: failed; b: infeasible; c: failed"],
    ]
    assert table.notes[0] == "least first plan time, of 3 settings: a tie in 2, none in 1"


def test_a_mission_that_missed_its_goals_wins_nothing() -> None:
    cells = {
        ("base", 10): result(slices=1).model_copy(update={"mission": mission(reached=False)}),
        ("b", 10): result(slices=9).model_copy(update={"mission": mission(seconds=80)}),
        ("c", 10): result(slices=5),
    }
    for objective, best in ((F["slices"], "c"), (F["mission_time_s"], "b")):
        table = winners_table(study(cells), objective)
        assert table is not None
        assert table.rows[0][0].text == best
        assert "base: goals not reached" in table.rows[0][-1].text
        assert ("c: no mission time" in table.rows[0][-1].text) == (best == "b")


def test_a_figure_of_zero_has_no_ratio() -> None:
    cells = {("base", 10): result(slices=0), ("b", 10): result(slices=9)}
    table = winners_table(study(cells), F["slices"])
    assert table is not None
    assert texts(table) == [["base", "0", "b", "9", "–", EXACT]]


@pytest.mark.parametrize("axis", ["workload.variant", "fpga.clock", "no.such"])
def test_without_a_choice_there_is_no_contest(axis: str) -> None:
    cells = {("base", 10): result(), ("base", 20): result()}
    assert winners_table(study(cells), axis=axis) is None


def test_the_page_of_a_study_has_the_table() -> None:
    page = study_html(study(CROSSING))
    assert "Best variant by setting: least first plan time" in page
    assert "least first plan time, of 3 settings: on-host in 2, base in 1" in page
    one = {key: value for key, value in CROSSING.items() if key[0] == "base"}
    assert "Best variant by setting" not in study_html(study(one))


def test_of_whole_problems_only_what_differs_is_told() -> None:
    problems = [
        {"map": {"generate": "empty", "rows": rows, "columns": 12, "seed": 0}, "goals": [[rows - 1, 3]]}
        for rows in (10, 20)
    ]
    axes: dict[str, tuple[Any, ...]] = {"workload.problem": tuple(problems), "workload.variant": ("base", "b")}
    outcomes = Outcomes.of([result(seconds=1 + index) for index in range(4)])
    made = Study("bench", "maze", axes, (F["first_plan_s"],), (), outcomes)
    table = winners_table(made)
    assert table is not None
    assert [row[0] for row in texts(table)] == ["rows 10, goals 9, 3", "rows 20, goals 19, 3"]
    assert [row[1].text for row in study_table(made).rows][::2] == ["rows 10, goals 9, 3", "rows 20, goals 19, 3"]
    assert chart_data(made)["axes"][0]["levels"] == ["rows 10, goals 9, 3", "rows 20, goals 19, 3"]
    # A program gets all of it.
    assert '"generate": "empty"' in study_csv(made).rows[0][1].text


def test_values_that_are_alike_for_long_are_still_told_apart() -> None:
    same = {f"parameter{number}": number for number in range(40)}
    axes: dict[str, tuple[Any, ...]] = {"workload.scenario": ({**same, "last": 1}, {**same, "last": 2})}
    made = Study("bench", "maze", axes, (F["first_plan_s"],), (), Outcomes.of([result(), None]))
    assert axis_levels(made, "workload.scenario") == ["last 1", "last 2"]


def nested(times: tuple[float | None, ...]) -> Study:
    """Variant ``base`` with three blocks, ``on-host`` with two omegas, at two clocks of the link."""
    axes: dict[str, tuple[Any, ...]] = {
        "workload.variant": ("base", "on-host"),
        "relax.block": (1, 2, 3),
        "relax.omega": (1.5, 1.7),
        "pci.clock": ("33 MHz", "66 MHz"),
    }
    when = {"relax.block": {"workload.variant": ("base",)}, "relax.omega": {"workload.variant": ("on-host",)}}
    outcomes = [result(fits=False) if time is None else result(seconds=time) for time in times]
    return Study("bench", "maze", axes, (F["first_plan_s"],), (), Outcomes.of(outcomes), when=when)


def test_each_variant_is_at_its_best_over_the_axes_that_it_alone_has() -> None:
    table = winners_table(nested((9, 9, 3, 9, None, 4, 8, None, 6, None)))
    assert table is not None
    assert [column.name for column in table.columns][:2] == ["clock", "best"]
    assert [row[:6] for row in texts(table)] == [
        ["33 MHz", "base", "3 s", "on-host", "6 s", "2"],
        ["66 MHz", "base", "4 s", "–", "–", "–"],
    ]
    assert texts(table)[1][-1] == "on-host: infeasible"
    assert table.notes == (
        "least first plan time, of 2 settings: base in 2",
        "each at its best over the axes that depend on it: block, omega",
    )


def test_several_points_of_one_variant_are_no_tie() -> None:
    table = winners_table(nested((3, 3, 3, 3, 3, 3, 3, 4, 5, 4)))
    assert table is not None
    assert table.notes[0] == "least first plan time, of 2 settings: a tie in 1, base in 1"
    assert [row[1] for row in texts(table)] == ["base = on-host", "base"]
