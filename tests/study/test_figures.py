"""A figure is declared once: files, studies, tables, schemas and CSV follow from the declaration."""

from __future__ import annotations

import json
import pickle
import re
from pathlib import Path
from typing import Any

import pytest
from explore_fakes import result
from places import ROOT
from report_samples import a_fleet_result, a_mission_result, a_result, a_task
from spec_texts import WORKLOAD

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES, SHORT_NAMES, ResultFigure, label
from codesign.inputs import load_workload
from codesign.inputs.derived import derived
from codesign.inputs.schema import json_schema
from codesign.study import Outcomes, Study
from codesign.study.document import study_schema
from codesign.system.results.result import Result
from codesign.system.verdicts import need_verdict
from codesign.views.report import render_csv
from codesign.views.report.comparison_page import comparison_table
from codesign.views.report.study_tables import front_table, study_csv, study_table

NEW = ResultFigure(
    "reachable_cells",
    "quality",
    "free cells that lead to a goal",
    label="cells within reach",
    unit="cells",
    maximise=True,
    counted="count",
)
"""A field of the result that is no objective until it is declared."""


@pytest.fixture
def declared(monkeypatch: pytest.MonkeyPatch) -> ResultFigure:
    monkeypatch.setitem(FIGURES, NEW.name, NEW)
    return NEW


def a_study(figure: ResultFigure) -> Study:
    outcomes = Outcomes.of([result(seconds=2.0), result(seconds=1.0)])
    return Study("bench", "maze", {"a.b": (0, 1)}, (FIGURES["first_plan_s"], figure), (), outcomes)


def test_a_figure_that_is_computed_reaches_the_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    figure = ResultFigure("double_time", "", "twice the time", value=lambda result: 2 * result.time.first_plan_s)
    monkeypatch.setitem(FIGURES, figure.name, figure)
    assert pickle.loads(pickle.dumps(figure)) is figure


def test_a_declared_figure_is_accepted_in_files(tmp_path: Path, declared: ResultFigure) -> None:
    limit = f"{{figure: {NEW.name}, at_least: 12}}"
    text = f"{WORKLOAD}  objectives: [{NEW.name}]\n  constraints: [{limit}]\n"
    (tmp_path / "w.yaml").write_text(text, encoding="utf-8")
    explore = load_workload(tmp_path / "w.yaml").explore
    assert explore is not None
    assert explore.objectives == (declared,)
    assert (explore.constraints[0].figure, explore.constraints[0].at_least) == (declared, 12)


def test_a_figure_that_is_not_declared_is_refused_with_the_nearest_name(tmp_path: Path) -> None:
    (tmp_path / "w.yaml").write_text(f"{WORKLOAD}  objectives: [clearance_meen]\n", encoding="utf-8")
    with pytest.raises(SpecError, match=r"did you mean clearance_mean\? accepted: arrive, block_rams, clearance_"):
        load_workload(tmp_path / "w.yaml")


def test_a_declared_figure_stands_in_the_study(declared: ResultFigure) -> None:
    study = a_study(declared).to_dict()
    assert study["units"][NEW.name] == "cells"
    assert study["objectives"][1] == {"figure": NEW.name, "unit": "cells", "direction": "maximise"}
    assert [point["figures"][NEW.name] for point in study["points"]] == [100, 100]


def test_a_declared_figure_stands_in_tables_and_in_csv(declared: ResultFigure) -> None:
    study = a_study(declared)
    assert NEW.column in render_csv(study_csv(study)).splitlines()[0].split(",")
    for table in (study_table(study), front_table(study)):
        column = [column.name for column in table.columns].index("cells within reach")
        assert {row[column].text for row in table.rows} == {"100 cells"}
    rows = {row[0].text: row[1].text for row in comparison_table([("a", result())]).rows}
    assert rows["cells within reach"] == "100 cells"
    assert label("reachable_cells at least") == "cells within reach at least"


def test_a_declared_figure_stands_in_the_schemas(declared: ResultFigure) -> None:
    workload = json_schema("workload")["$defs"]
    for held in (
        workload["Exploration"]["properties"]["objectives"]["items"],
        workload["Constraint"]["properties"]["figure"],
        study_schema()["$defs"]["Objective"]["properties"]["figure"],
        study_schema()["$defs"]["Point"]["properties"]["figures"]["propertyNames"],
    ):
        assert NEW.name in held["anyOf"][0]["enum"]
    assert json.dumps(study_schema())


def test_a_figure_may_be_computed_from_others(monkeypatch: pytest.MonkeyPatch) -> None:
    each = ResultFigure("cycles_a_sweep", "", "cycles over sweeps", value=lambda held: sum(held.cycles.values()) / 14)
    monkeypatch.setitem(FIGURES, each.name, each)
    assert a_result().figure(each) == sum(a_result().cycles.values()) / 14  # type: ignore[union-attr]


def at(schema: dict[str, Any], path: str) -> list[dict[str, Any]]:
    """Every property that a dotted path of a schema may mean."""
    held = [schema]
    for step in path.split("."):
        held = [part for each in held for part in resolved(schema, each)]
        held = [part["properties"][step] for part in held if step in part.get("properties", {})]
    return held


def resolved(schema: dict[str, Any], held: dict[str, Any]) -> list[dict[str, Any]]:
    if "$ref" in held:
        return resolved(schema, schema["$defs"][held["$ref"].rpartition("/")[2]])
    return [part for each in held["anyOf"] for part in resolved(schema, each)] if "anyOf" in held else [held]


@pytest.mark.parametrize("figure", FIGURES.values(), ids=str)
def test_a_figure_has_the_name_of_its_field(figure: ResultFigure) -> None:
    schema = Result.model_json_schema(mode="serialization")
    if figure.is_resource:
        assert figure.name in {use.resource for use in a_result().resources} | {"lut4", "flip_flops", "multipliers"}
        return
    assert figure.path.rpartition(".")[2] == figure.name
    fields = at(schema, figure.path)
    assert fields
    assert all(field["description"] for field in fields)
    suffix = {"s": "_s", "J": "_j", "m": "_m"}.get(figure.unit)
    assert suffix is None or figure.name.endswith(suffix)


def test_every_figure_has_a_value_in_some_result() -> None:
    planned = a_result().model_copy(update={"task": a_task()})
    results = [planned, a_fleet_result(), a_mission_result()]
    told = {name for name, figure in FIGURES.items() if any(each.figure(figure) is not None for each in results)}
    assert set(FIGURES) - told <= {"lut4", "flip_flops", "multipliers"}


def test_the_earlier_names_are_no_figures() -> None:
    assert not set(SHORT_NAMES) & set(FIGURES)
    assert set(SHORT_NAMES.values()) <= set(FIGURES)


def test_the_shipped_workloads_name_declared_figures() -> None:
    for path in sorted((ROOT / "workloads").glob("*.yaml")):
        explore = codesign.load_workload(path).explore
        if explore is not None:
            assert set(explore.objectives) <= set(FIGURES.values())


def test_no_time_of_a_result_is_in_picoseconds() -> None:
    names = re.findall(r'"(\w+)"', json.dumps(Result.model_json_schema(mode="serialization")))
    assert not [name for name in names if name.endswith("_ps")]


def test_a_derived_figure_of_a_result_is_made_of_its_declared_ones() -> None:
    result = a_result()
    assert isinstance(result, Result)
    each = derived("cycles_a_slice", "cycles / slices", unit="%")
    cycles, slices = result.figure(FIGURES["cycles"]), result.figure(FIGURES["slices"])
    assert cycles is not None
    assert slices is not None
    assert result.figure(each) == pytest.approx(100 * cycles / slices, rel=1e-15)
    assert pickle.loads(pickle.dumps(each)) == each
    assert result.figure(pickle.loads(pickle.dumps(each))) == result.figure(each)
    assert result.figure(derived("none", "mission_time_s * 2")) is None
    assert result.figure(derived("zero", "slices / (slices - slices)")) is None
    assert need_verdict(result, each, 1e9).state == "proved"
    assert need_verdict(result, each, 1e-9).state == "refuted"
