"""Tables and page of a study over conditions."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest
from explore_fakes import result
from page_data import column, data_of

from codesign.ground.figures import FIGURES
from codesign.inputs import Constraint
from codesign.inputs.aggregate import Share
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study
from codesign.system.results.result import Result
from codesign.views.report import (
    best_table,
    front_picture,
    front_table,
    nearest_table,
    reasons_table,
    render_text,
    spread_table,
    study_table,
    winners_table,
)
from codesign.views.report.study_page import study_html
from codesign.views.report.study_tables import infeasible_table, summary

TIME, SLICES = FIGURES["first_plan_s"], FIGURES["slices"]
VARIANTS = ("fabric", "host", "large")
CELLS = [
    [result(seconds=1e-3), result(seconds=9e-3)],
    [result(seconds=2e-3, slices=9), result(seconds=8e-3, slices=9)],
    [result(seconds=1e-4, slices=50), result(slices=130, fits=False)],
]


def study(cells: list[list[Result]] = CELLS, **changes: Any) -> Study:
    sizes = (20, 40)
    fields: dict[str, Any] = {
        "platform": "bench", "workload": "maze", "axes": {"workload.variant": VARIANTS[: len(cells)]},
        "objectives": (TIME, SLICES), "constraints": (),
        "outcomes": Outcomes.of([each for row in cells for each in row]),
        "conditions": {"workload.problem.map.rows": sizes},
    }  # fmt: skip
    return Study(**(fields | changes))


def test_the_head_says_decisions_conditions_and_rule() -> None:
    told = summary(study())
    assert told.startswith("3 designs × 2 conditions = 6 points, compared by the worst over the conditions: 2 feasible")
    mixed = summary(study(aggregate={"first_plan_s": "mean"}))
    assert "compared over the conditions, first plan time by the mean; slices by the worst" in mixed


def test_the_front_has_the_aggregated_figure_with_its_spread() -> None:
    (row,) = front_table(study()).rows
    assert [cell.text for cell in row] == ["1", "host", "8 ms, over the conditions 2 ms to 8 ms", "9"]
    assert row[2].value == pytest.approx(8e-3)


def test_by_share_the_head_names_the_limit() -> None:
    rule = Share(share=Constraint(figure=TIME, at_most=5e-3))
    table = front_table(study(aggregate={"first_plan_s": rule}))
    assert table.columns[2].name == "share with first plan time at most 5 ms"
    assert [row[2].text for row in table.rows] == ["50 %, over the conditions 2 ms to 8 ms"]
    assert (
        best_table(study(aggregate={"first_plan_s": rule})).rows[0][0].text
        == "most share with first plan time at most 5 ms"
    )


def test_a_design_that_is_out_names_the_condition() -> None:
    for table in (infeasible_table(study()), nearest_table(study())):
        assert [[cell.text for cell in row] for row in table.rows] == [
            ["2", "large", "slices 130 against 100 (at rows 40)"]
        ]
    assert reasons_table(study()).title == "Why designs were left out"
    whys = [row[-1].text for row in study_table(study()).rows]
    assert whys == ["", "", "", "", "slices 130 against 100 (at rows 40)", "slices 130 against 100"]


def test_what_the_conditions_do_not_tell_apart_is_said() -> None:
    equal = [[*CELLS[0]], [result(seconds=2e-3), result(seconds=8e-3)], [*CELLS[2]]]
    text = render_text(front_table(study(equal)))
    assert re.search(r"1 +host +8 ms, over the conditions 2 ms to 8 ms +10 +0\n", text)
    assert "not told apart: each of the two is better in some conditions" in text


def test_winners_stand_by_condition() -> None:
    table = winners_table(study())
    assert table is not None
    assert [[cell.text for cell in row][:2] for row in table.rows] == [["20", "large"], ["40", "host"]]
    assert "large: infeasible" in table.rows[1][-1].text


def test_a_constraint_on_all_conditions_is_told_without_one() -> None:
    out = study(constraints=(Constraint(figure=TIME, at_most=8.5e-3),))
    assert render_text(infeasible_table(out)).count("first plan time at most 9 ms against 8.5 ms\n") == 1


def test_seeds_have_their_interval_in_the_table_of_spreads() -> None:
    drawn = replace(study(), conditions={"a.seed": (0, 1)}, aggregate={"default": "mean"})
    rows = {row[1].text: row for row in spread_table(drawn).rows if row[0].value == 1}
    # 3 ms times the t of one degree of freedom, 12.706, over no root: two values, whose deviation is 4.243 ms.
    half = 12.7062047 * 3.0
    bounds = re.findall(r"-?[\d.]+", rows["first plan time"][3].text)
    assert [abs(float(bound)) for bound in bounds] == pytest.approx([half - 5, half + 5], rel=1e-3)


def test_the_page_shows_each_condition_by_itself() -> None:
    html = study_html(study())
    data = data_of(html)
    frames = data["frames"]
    assert [frame["name"] for frame in frames] == ["by the worst over the conditions", "rows 20", "rows 40"]
    fronts = [column(data, frame["front"]).tolist() for frame in frames]
    assert fronts == [[0, 1, 0], [1, 1, 1], [0, 1, 0]]
    assert html.count("<details>") == 2
    assert "3 designs × 2 conditions = 6 points" in html
    plain = study(conditions={}, outcomes=study().at({"workload.problem.map.rows": 20}).outcomes)
    assert "<details>" not in study_html(plain)


def test_the_picture_is_of_designs() -> None:
    assert front_picture(study()).alt.endswith("2 feasible designs, front outlined and joined")
