"""Conditional axes, ranges and derived figures end to end; studies that were cut off, and went on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from explore_fakes import result
from pydantic import ValidationError

import codesign
from codesign.ground.figures import FIGURES
from codesign.ground.models import RefusalError
from codesign.inputs.derived import DerivedFigure, read_figures
from codesign.study import Study, explore, load_study
from codesign.study.budget import Budget
from codesign.study.order import Order
from codesign.study.outcomes import Outcomes
from codesign.study.space import Space
from codesign.views.report import reasons_table, render_text, study_csv, study_sentence
from codesign.views.report.study_page import study_html

TEXT = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: rooms, rows: 12, columns: 18, room: [5, 5], door: 2, seed: 3}
  goals: [[2, 2]]
  starts: {count: 3, seed: 1}
mapping:
  relax: {component: fabric, block: [6, 9], iterations: 4, schedule: [15, 31]}
variants:
  on-host:
    planner: relaxation
    mapping: {relax: {component: host, method: sor, omega: 1.8}}
explore:
  axes:
    workload.variant: [base, on-host]
    relax.iterations: {from: 1, to: 4, factor: 2, when: {workload.variant: base}}
    relax.omega: {from: 1.5, to: 1.9, step: 0.2, when: {workload.variant: on-host}}
    fabric.clock: {from: 10 MHz, to: 40 MHz, count: 4, when: {workload.variant: base}}
    pci.clock: {from: 10 MHz, to: 1 GHz, count: 2, scale: log}
  figures:
    energy_delay: {expression: energy_j * plan_time_worst_s, unit: mJ s}
    spread: {expression: slices / (plan_time_worst_s - plan_time_mean_s), label: slices a spread}
  objectives: [energy_delay, slices]
  constraints: [sqrt(slices * block_rams) < 1e4, plan_time_worst_s <= 2 * plan_time_mean_s]
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return explore(*specs(tmp_path_factory.mktemp("spaces")), workers=1)


def specs(folder: Path) -> tuple[Any, Any]:
    (folder / "small.yaml").write_text(TEXT, encoding="utf-8")
    return codesign.load_platform("virtex2-pci"), codesign.load_workload(folder / "small.yaml")


def test_a_point_has_the_axes_that_exist_for_it(study: Study) -> None:
    assert len(study.designs) == 3 * 4 * 2 + 3 * 2
    levels = study.space.levels(np.arange(len(study.points)))
    for point in study.points:
        own = {"relax.iterations", "fabric.clock"} if point.axes["workload.variant"] == "base" else {"relax.omega"}
        assert set(point.axes) == {"workload.variant", "pci.clock", *own}
        assert {axis for axis, column in levels.items() if column[point.index] >= 0} == set(point.axes)
        assert study.space.index(point.axes) == point.index
        result = point.result
        assert result is not None
        assert result.planner == ("harmonic" if "relax.iterations" in point.axes else "relaxation")
    assert study.failed == study.missing == ()


def test_what_is_written_has_derived_figures_and_no_values_of_axes_that_do_not_exist(study: Study) -> None:
    document = json.loads(study.to_json())
    assert document["when"]["relax.omega"] == {"workload.variant": ["on-host"]}
    assert document["figures"]["energy_delay"] == {
        "expression": "energy_j * plan_time_worst_s",
        "unit": "mJ s",
        "direction": "minimise",
        "label": "energy delay",
    }
    assert document["units"]["energy_delay"] == "mJ s"
    table = study_csv(study)
    names = [column.name for column in table.columns]
    columns = {name: [row[place].value for row in table.rows] for place, name in enumerate(names)}
    frame = study.frame()
    for index, entry in enumerate(document["points"]):
        figures = entry["figures"]
        own = 1e3 * (figures["energy_j"] * figures["plan_time_worst_s"])
        assert figures["energy_delay"] == pytest.approx(own, rel=1e-12)
        column = "energy_delay_mj_s"
        assert columns[column][index] == frame[column][index] == figures["energy_delay"]
        least, most = (columns[f"{column}_{end}"][index] for end in ("low", "high"))
        assert least <= figures["energy_delay"] <= most
        assert (columns["relax.omega"][index] is None) == (entry["axes"].get("relax.omega") is None)
    page = study_html(study)
    assert "energy delay" in page
    assert "energy delay" in render_text(codesign.views.report.front_table(study))


def test_a_point_without_a_derived_figure_says_why_and_is_on_no_front(study: Study) -> None:
    spread = study.figures["spread"]
    other = Study(
        study.platform, study.workload, study.axes, (spread, FIGURES["slices"]), study.constraints,
        study.outcomes, specs=study.specs, when=study.when, figures=study.figures,
    )  # fmt: skip
    lacking = [design.index for design in other.designs if design.figure(spread) is None]
    assert lacking
    assert not set(other.front) & set(lacking)
    why = "division by zero in slices / (plan_time_worst_s - plan_time_mean_s)"
    (count,) = (each for each in other.reasons if each.kind == "no figure")
    assert (count.name, count.designs) == (f"spread: {why}", len(lacking))
    assert why in render_text(reasons_table(other))
    names = [column.name for column in study_csv(other).columns]
    whys = {study_csv(other).rows[index][names.index("why_not")].value for index in lacking}
    assert whys == {f"has no slices a spread: {why}"}
    held = other.needing(["spread > 0 Hz"])
    assert held.designs[lacking[0]].out[0].reason.words == f"spread above: {why}"


FAR = {"far": {"expression": "energy_j * 1e300 * 1e9", "unit": "pJ"}, "root": "sqrt(slices - 10)", "half": "slices / 2"}


def test_derived_columns_have_no_value_where_a_step_has_none() -> None:
    figures: dict[str, DerivedFigure] = read_figures(FAR)
    results = [result(slices=slices) for slices in (5, 10, 14)]
    outcomes = Outcomes.of([*results, "too large", None])
    assert outcomes.column(figures["root"]).tolist()[1:3] == [0.0, 2.0]
    assert np.isnan(outcomes.column(figures["root"])[[0, 3, 4]]).all()
    assert outcomes.value(figures["root"], 0) is None
    assert np.isnan(outcomes.column(figures["far"])).all(), "no energy, or a number too large"
    assert outcomes.column(figures["half"]).tolist()[:3] == [2.5, 5.0, 7.0]
    whys = [(why, where.tolist()) for why, where in outcomes.whys(figures["root"])]
    assert ("there is no slices", [False, False, False, True, True]) in whys
    assert ("root of a negative number in sqrt(slices - 10)", [True, False, False, True, True]) in whys
    for figure in figures.values():
        low, high = outcomes.bounds(figure)
        assert np.isnan(low).tolist() == np.isnan(high).tolist()


def test_a_value_too_large_for_its_unit_is_none_in_columns_and_alone() -> None:
    figure = read_figures({"far": {"expression": "slices * 1 J * 1e290", "unit": "pJ"}})["far"]
    outcomes = Outcomes.of([result(slices=10**9)])
    assert np.isnan(outcomes.column(figure)).all()
    assert outcomes.value(figure, 0) is None
    assert figure.why_none(lambda _name: 1e9) == "a number too large for its unit"
    assert [why for why, where in outcomes.whys(figure) if where[0]] == ["a number too large for its unit"]


@pytest.mark.parametrize(
    "name",
    ["index", "state", "on_front", "why_not", "seeds", "energy_j_low", "power_w", "other_high", "plan_time_worst_s"],
)
def test_a_derived_figure_has_no_name_of_another_column(name: str) -> None:
    with pytest.raises((ValidationError, RefusalError), match=r"is a column of tables|is a figure"):
        read_figures({"other": "slices * 2", name: "slices * 3"})


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_study_that_was_cut_goes_on_to_the_whole_one(study: Study, tmp_path: Path, workers: int) -> None:
    platform, workload = specs(tmp_path)
    store = tmp_path / "cut.sqlite"
    done = 0
    for points in (1, 7, 5):
        part = explore(platform, workload, store=store, workers=workers, budget=Budget(points=points))
        done += points
        assert len(part.points) - sum(point.state == "missing" for point in part.points) == done
        assert load_study(store).to_json() == part.to_json()
    whole = explore(platform, workload, store=store, workers=workers)
    assert study_csv(whole).rows == study_csv(study).rows
    assert whole.front == study.front
    assert study_sentence(load_study(store)) == study_sentence(study)


SIZES = {"a.b": 12, "a.c": 7, "a.d": 5}


@pytest.mark.parametrize("trend", list(SIZES))
def test_a_study_cut_off_anywhere_estimates_the_mean_better_than_chance(trend: str) -> None:
    """Any axis may have a trend: the mean over the first designs is nearer to that of all than in random orders."""
    when = {"a.d": {"a.c": tuple(range(4))}}
    space = Space({axis: tuple(range(size)) for axis, size in SIZES.items()}, "", when=when)
    levels = space.levels(np.arange(len(space)))
    values = levels[trend].astype(float) + 0.1 * levels["a.b"] + 0.05 * levels["a.d"]
    turns = Order.of(space).indices(0, len(space))
    assert sorted(turns.tolist()) == list(range(len(space)))
    chance = np.random.default_rng(1)
    for part in (10, 25, 60, 130, 200):
        own = abs(values[turns[:part]].mean() - values.mean())
        errors = [abs(values[chance.permutation(len(space))[:part]].mean() - values.mean()) for _ in range(200)]
        assert own <= np.quantile(errors, 0.95), part
        first = abs(values[:part].mean() - values.mean())
        assert own <= max(first, np.quantile(errors, 0.5))


def test_over_random_shifts_a_cut_study_is_unbiased() -> None:
    space = Space({"a.b": tuple(range(11)), "a.c": tuple(range(6))}, "")
    values = np.array([point.axes["a.b"] ** 2 + point.axes["a.c"] for point in space.points()], float)
    means = [values[Order.of(space, seed=seed).indices(0, 9)].mean() for seed in range(1, 400)]
    spread = np.std(means) / np.sqrt(len(means))
    assert abs(np.mean(means) - values.mean()) < 4 * spread
