"""The tables of a large study show few rows, and ask no more of it than they show."""

from __future__ import annotations

import csv
import json
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from explore_fakes import result

import codesign
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.inputs.derived import DerivedFigure
from codesign.inputs.expression import figure_node, parse
from codesign.study import study as study_module
from codesign.study.outcomes import Outcomes, State
from codesign.study.rivals import StudyRivals
from codesign.study.study import Study
from codesign.system.results.result import Result
from codesign.system.verdicts import winner_verdict
from codesign.system.verdicts.verdict import Listed
from codesign.views.report import render_text, study_table, study_tables, winners_table, write_study_csv
from codesign.views.report.study_page import chart_data, study_html
from codesign.views.report.study_tables import study_csv, why_out

TIME, SLICES = FIGURES["first_plan_s"], FIGURES["slices"]

SMALL = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: rooms, rows: 24, columns: 36, room: [11, 17], door: 2, seed: 3}
  goals: [[2, 2]]
  starts: {count: 6, seed: 1}
mapping:
  relax: {component: fabric, block: [12, 18], iterations: 4, schedule: {first: 7, step: 8, last: 63}}
explore:
  objectives: [plan_time_worst_s, energy_j]
  axes:
    relax.iterations: [1, 4, 16]
    fabric.clock: [30 MHz, 60 MHz, 100 MHz]
    pci.clock: [33 MHz, 66 MHz]
"""


def wide(computed: int, settings: int = 2_640) -> Study:
    """Two variants at each of so many settings, of which the first points of every seventh setting are computed."""
    axes = {"workload.variant": ("base", "on-host"), "relax.iterations": tuple(range(1, settings + 1))}
    results: list[Result | None] = [None] * (2 * settings)
    for number in range(computed):
        variant, setting = number % 2, 7 * (number // 2) % settings
        fits = number % 5 > 0
        results[variant * settings + setting] = result(seconds=1 + variant + setting, slices=200, fits=fits)
    return Study("bench", "maze", axes, (TIME, SLICES), (), Outcomes.of(results))


def counted(monkeypatch: pytest.MonkeyPatch, owner: Any, name: str) -> Counter[Any]:
    """How often a function is called with each argument behind the first."""
    calls: Counter[Any] = Counter()
    whole: Callable[..., Any] = getattr(owner, name)

    def watched(*arguments: Any, **others: Any) -> Any:
        calls[arguments[1:]] += 1
        return whole(*arguments, **others)

    monkeypatch.setattr(owner, name, watched)
    return calls


@pytest.mark.parametrize("computed", [4, 50, 5_280])
def test_few_settings_are_shown_and_the_others_counted(computed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    study = wide(computed)
    verdicts = counted(monkeypatch, StudyRivals, "verdict")
    table = winners_table(study)
    assert table is not None
    settings = (computed + 1) // 2
    assert len(table.rows) == min(30, settings)
    assert verdicts.total() <= len(table.rows)
    assert ("the first 30 of 2,640 settings" in table.notes) == (computed == 5_280)
    assert (f"{2_640 - settings:,} settings without a computed point" in table.notes) == (computed < 5_280)
    lines = "".join(map(render_text, study_tables(study))).splitlines()
    assert len(lines) < 100
    longer = winners_table(study, most=100)
    assert longer is not None
    assert longer.rows[: len(table.rows)] == table.rows
    assert len(longer.rows) == min(100, settings)


def test_files_and_tables_have_the_computed_points_alone(tmp_path: Path) -> None:
    study = wide(50)
    computed = [point.index for point in study.points if point.state != "missing"]
    assert len(computed) == 50
    assert study_table(study).notes[0] == "5,230 points not computed"
    assert [row[0].value for row in study_table(study).rows] == computed
    write_study_csv(study, tmp_path / "study.csv")
    with (tmp_path / "study.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["index"]) for row in rows] == computed
    assert {row["state"] for row in rows} == {"done"}
    assert [row["why_not"] for row in rows] == [why_out(study, study.designs[index]) for index in computed]
    nothing = wide(0)
    write_study_csv(nothing, tmp_path / "nothing.csv")
    assert len((tmp_path / "nothing.csv").read_text(encoding="utf-8").splitlines()) == 1
    assert study_csv(nothing).rows == ()


def test_parquet_has_the_computed_points_alone(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    study = wide(50)
    study.to_parquet(tmp_path / "study.parquet")
    rows = parquet.read_table(tmp_path / "study.parquet").to_pylist()
    assert [row["index"] for row in rows] == study.outcomes.computed.tolist()
    assert [row["feasible"] for row in rows] == study.judged.feasible_points[study.outcomes.computed].tolist()


class Counted(Listed):
    """Results that would have to be simulated; it counts which are."""

    def __init__(self, results: list[Result]) -> None:
        super().__init__(results)
        self.asked: set[int] = set()

    def at_hand(self, position: int) -> bool:
        return position in self.asked

    def result(self, position: int) -> Result:
        self.asked.add(position)
        return super().result(position)


def test_what_intervals_prove_is_not_simulated() -> None:
    study = codesign.explore("virtex4-pci", SMALL, workers=1)
    results = [point.result for point in study.points if point.feasible and point.result is not None]
    spared = 0
    for figure in study.objectives:
        rivals = Counted(results)
        verdict, whole = winner_verdict(rivals, figure), winner_verdict(results, figure)
        assert (verdict.state, verdict.winner, verdict.rival) == (whole.state, whole.winner, whole.rival)
        assert verdict.winner is not None
        low, high = rivals.ends(figure)
        touch = np.flatnonzero(low <= high[verdict.winner])
        assert rivals.asked <= {verdict.winner, *touch.tolist()}
        spared += len(results) - len(rivals.asked)
        if whole.state == "proved" and verdict.least is not None and whole.least is not None:
            assert verdict.least <= whole.least
    assert spared > 0


def test_a_verdict_about_few_points_reads_no_column_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    study = wide(5_280)
    nodes = {figure.name: figure_node(figure.name, figure.unit) for figure in (TIME, SLICES)}
    derived = DerivedFigure("work", "derived", "", node=parse("first_plan_s * slices", nodes))
    read: list[int] = []
    whole = Outcomes.column

    def watched(self: Outcomes, figure: ResultFigure, *within: Any) -> Any:
        column = whole(self, figure, *within)
        read.append(len(column))
        return column

    monkeypatch.setattr(Outcomes, "column", watched)
    StudyRivals(study.outcomes, np.array([3, 4, 5]), study.result).verdict(derived)
    assert set(read) == {3}


def alike(count: int) -> Study:
    """So many points that do not fit for one of three reasons, and one that does."""
    outcomes = Outcomes.empty(count)
    outcomes.state[:] = State.DONE
    outcomes.templates += [result(slices=100 * number, fits=False) for number in (2, 3, 4)] + [result()]
    outcomes.which[:] = np.arange(count) % 3
    outcomes.which[count - 1] = 3
    axes = {"relax.iterations": tuple(range(count))}
    return Study("bench", "maze", axes, (SLICES, TIME), (), outcomes)


def test_the_page_words_each_reason_once(monkeypatch: pytest.MonkeyPatch) -> None:
    study = alike(600)
    data = chart_data(study)
    calls = counted(monkeypatch, sys.modules[study_csv.__module__], "why_not")
    assert chart_data(study) == data
    assert calls.total() < 10
    whys = dict.fromkeys(why_out(study, study.designs[index], gaps=True) for index in study.distinct)
    assert data["whys"]["count"] == len(json.dumps(list(whys)))


def test_the_page_computes_the_effects_on_each_figure_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[ResultFigure] = []
    whole = study_module.axis_effects

    def watched(study: Study, figures: Any) -> Any:
        asked.extend(figures)
        return whole(study, figures)

    monkeypatch.setattr(study_module, "axis_effects", watched)
    study_html(wide(5_280, 6))
    assert len(asked) == len(set(asked)) > 0
