"""Missions in an exploration: their figures, those that end before their goals, and designs without a chip."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import click.testing
import pytest
from explore_fakes import mission, result
from page_data import column

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.inputs import Constraint, Exploration
from codesign.study.constraints import figure_of, with_constraints
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study
from codesign.system.results.result import Result
from codesign.views.report import front_table, reasons_table, render_text, study_table
from codesign.views.report.study_page import chart_data
from codesign.views.report.study_tables import study_counts

F = FIGURES
TIME_FIGURES = (F["mission_time_s"], F["mission_energy_j"], F["distance_ratio"])


def driven(*, seconds: float = 60.0, reached: bool = True, slices: int = 10) -> Result:
    return result(slices=slices).model_copy(update={"mission": mission(seconds=seconds, reached=reached)})


def study(*outcomes: Result, objectives: tuple[ResultFigure, ...] = (F["mission_time_s"], F["slices"])) -> Study:
    axes = {"relax.iterations": tuple(range(len(outcomes)))}
    return Study("bench", "maze", axes, objectives, (), Outcomes.of(outcomes))


def test_every_figure_of_a_mission_in_its_unit() -> None:
    told = {
        figure: (figure_of(driven(), figure), figure.unit, figure.maximise)
        for figure in FIGURES.values()
        if figure.within.startswith("mission")
    }
    assert told == {
        F["mission_time_s"]: (60.0, "s", False),
        F["mission_energy_j"]: (310.0, "J", False),
        F["distance_ratio"]: (1.2, "1", False),
        F["replans"]: (3.0, "1", False),
        F["replan_latency_95_s"]: (0.02, "s", False),
        F["missed_deadlines"]: (2.0, "1", False),
        F["safety_stops"]: (1.0, "1", False),
        F["contacts"]: (0.0, "1", False),
        F["clearance_least_m"]: (0.15, "m", True),
        F["known_share"]: (0.75, "1", True),
    }
    # What the first plan took stands beside it; without a mission there is none of these.
    assert figure_of(driven(), F["first_plan_s"]) == 1.0
    assert [figure_of(result(), name) for name in told] == [None] * len(told)


def test_a_mission_that_failed_early_gains_nothing_by_it() -> None:
    failed = driven(seconds=1.0, reached=False)
    assert [figure_of(failed, name) for name in TIME_FIGURES] == [None] * 3
    assert figure_of(failed, F["missed_deadlines"]) == 2.0
    made = study(failed, driven(seconds=90.0))
    assert (made.feasible, made.unreached, made.front) == ((0, 1), (0,), (1,))
    # Nor where the objectives are figures that it does have, and has better.
    by_slices = study(driven(reached=False, slices=1), driven(), objectives=(F["slices"],))
    assert by_slices.front == (1,)


def test_tables_and_json_say_why_it_is_left_out() -> None:
    made = study(driven(reached=False), driven(), result(), result(fits=False, slices=120))
    assert ("without their goals", "1") in study_counts(made)
    whys = [row[-1].text for row in study_table(made).rows]
    assert whys == ["goals not reached: no way for 30 s", "", "has no mission time", "slices 120 against 100"]
    reasons = {(count.kind, count.name): count for count in made.reasons}
    assert set(reasons) == {("resource", "slices"), ("unreached", "no way for 30 s"), ("no figure", "mission_time_s")}
    assert (reasons["no figure", "mission_time_s"].nearest, reasons["unreached", "no way for 30 s"].designs) == (2, 1)
    text = render_text(reasons_table(made))
    assert "no way for 30 s" in text
    assert "mission time" in text
    data = chart_data(made)
    assert column(data, data["whys"])[0] == whys[0]
    document = json.loads(made.to_json())
    assert [point["unreached"] for point in document["points"]] == ["no way for 30 s", None, None, None]
    assert (document["counts"]["unreached"], document["counts"]["feasible"]) == (1, 3)
    assert document["points"][1]["figures"]["replans"] == 3
    assert type(document["points"][1]["figures"]["replans"]) is int
    assert [row[0].text for row in front_table(made).rows] == ["1"]


def test_no_constraint_on_the_time_of_a_mission_holds_where_it_failed() -> None:
    limits = (
        Constraint(figure=F["mission_time_s"], at_most=100.0),
        Constraint(figure=F["missed_deadlines"], at_most=1),
    )
    late = with_constraints(driven(), limits)
    assert [(reason.name, reason.demand) for reason in late.reasons] == [("missed_deadlines at most", 2)]
    failed = with_constraints(driven(seconds=1.0, reached=False), limits)
    assert [reason.name for reason in failed.reasons] == [
        "mission_time_s at most: goals not reached",
        "missed_deadlines at most",
    ]
    (point,) = replace(study(driven(seconds=1.0, reached=False)), constraints=limits).points
    assert point.result == failed
    assert (point.feasible, point.unreached) == (False, None)


def test_bounds_on_missions_have_units() -> None:
    section = Exploration.model_validate(
        {
            "constraints": [
                {"figure": "mission_time_s", "at_most": "2 min"},
                {"figure": "replan_latency_95_s", "at_most": "50 ms"},
                {"figure": "mission_energy_j", "at_most": "1 kJ"},
                {"figure": "clearance_least_m", "at_least": "20 cm"},
                {"figure": "contacts", "at_most": 0},
            ]
        },
        context={"document": object()},
    )
    assert [limit.at_most or limit.at_least for limit in section.constraints] == [120, 0.05, 1000, 0.2, None]
    assert section.constraints[4].at_most == 0


@pytest.mark.parametrize(
    ("figure", "expected"),
    [(F["slices"], 0.0), (F["block_rams"], 0.0), (F["multipliers"], 0.0), (F["cycles"], None), (F["power"], None)],
)
def test_a_design_without_a_chip_takes_none_of_its_resources(figure: ResultFigure, expected: float | None) -> None:
    host = result().model_copy(update={"resources": (), "component": "host"})
    assert figure_of(host, figure) == expected
    assert figure_of(result(slices=7), F["slices"]) == 7
    # A part with resources that were not counted is no proof that none are taken.
    assert figure_of(host.model_copy(update={"part": "XC4VLX160-12"}), F["slices"]) is None


def test_host_and_fpga_share_a_front() -> None:
    host = result(seconds=5.0).model_copy(update={"resources": ()})
    made = study(host, result(seconds=1.0), objectives=(F["first_plan_s"], F["slices"]))
    assert made.front == (0, 1)
    limited = with_constraints(host, (Constraint(figure=F["slices"], at_most=5),))
    assert limited.feasible


DRIVE = """\
kind: workload
name: little-drive
planner: harmonic
problem: {map: {generate: empty, rows: 10, columns: 10}, goals: [[8, 8]], starts: [[1, 1]]}
scenario: {type: drive, known: none, resolution: 0.2 m, control_period: 100 ms}
mapping:
  relax: {component: fpga, block: [10, 10], iterations: 6, schedule: [31]}
  decide: {component: fpga}
variants:
  on-host:
    planner: wavefront
    mapping: {propagate: {component: arm, style: software, corner_cutting: false}, track: {component: arm}}
explore:
  axes:
    workload.variant: [base, on-host]
    workload.scenario.limit: [1 s, 5 min]
"""


def test_drives_are_points_and_one_that_ran_out_of_time_says_so(
    hwsw: Callable[..., click.testing.Result], tmp_path: Path
) -> None:
    file, store = tmp_path / "drive.yaml", tmp_path / "drive.sqlite"
    file.write_text(DRIVE, encoding="utf-8")
    assert hwsw("check", "zynq", file).exit_code == 0
    done = hwsw("explore", "zynq", file, "--store", store, "--workers", 1, "--json")
    assert done.exit_code == 0, done.output
    made = json.loads(done.stdout)
    assert [each["figure"] for each in made["objectives"]] == [
        "mission_time_s", "mission_energy_j", "slices", "block_rams",
    ]  # fmt: skip
    points = made["points"]
    assert [point["feasible"] for point in points] == [True] * 4
    assert [point["unreached"] is None for point in points] == [False, True, False, True]
    for point in points:
        ended = point["result"]["mission"]["ended"]
        assert point["unreached"] in (None, ended)
        assert (point["figures"]["mission_time_s"] is None) == (point["unreached"] is not None)
        assert point["result"]["mission"]["contacts"] == 0
    assert set(made["front"]) <= {1, 3}
    assert made["front"]
    text = hwsw("report", store).stdout
    assert "unreached" in text
    assert points[0]["unreached"][:20] in text
    assert "base: goals not reached" in text
