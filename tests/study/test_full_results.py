"""Points that were priced: what templates and columns have is enough, and full results are simulated on demand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import codesign
from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES
from codesign.study import Outcomes, Study, load_study
from codesign.study.pricing.price import PRICED
from codesign.views.report import render_csv, render_text, study_csv, study_sentence, study_tables
from codesign.views.report.study_page import chart_data

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
variants:
  on-host:
    planner: wavefront
    mapping: {propagate: {component: host, style: software, corner_cutting: false}, track: {component: host}}
explore:
  objectives: [plan_time_worst_s, energy_j, slices]
  constraints: [{figure: plan_time_worst_s, at_most: 50 ms}]
  axes:
    workload.variant: [base, on-host]
    fabric.clock: [50 MHz, 100 MHz, 200 MHz]
    pci.clock: [33 MHz, 66 MHz]
"""


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Study, Path]:
    """A study of twelve points, and its file."""
    file = tmp_path_factory.mktemp("study") / "small.sqlite"
    return codesign.explore("virtex4-pci", SMALL, store=file, workers=1), file


def priced(study: Study) -> Study:
    """The study with templates in place of full results: without what prices move."""
    moved: dict[str, Any] = {
        **dict.fromkeys(("clock", "power", "time", "cycles", "energy", "terms"), None),
        **{"processor": {}, "idle_fpgas": {}},
    }
    whole = study.outcomes
    templates = [
        template.model_copy(
            update={
                **moved,
                "reasons": tuple(reason for reason in template.reasons if reason.kind != "clock"),
                "feasible": all(reason.kind == "clock" for reason in template.reasons),
            }
        )
        for template in whole.templates
    ]
    clocks = [[each for each in template.reasons if each.kind == "clock"] for template in whole.templates]
    reasons = [each for found in clocks for each in found]
    numbers = np.cumsum([len(found) for found in clocks]) - 1
    of_template = np.where([len(found) for found in clocks], numbers, -1).astype(np.int32)
    outcomes = Outcomes(
        whole.state, whole.which, whole.figures, whole.lows, whole.highs, of_template[whole.which],
        templates, set(), reasons,
    )  # fmt: skip
    return replace(study, outcomes=outcomes)


def test_full_results_are_those_of_the_single_runs(stored: tuple[Study, Path]) -> None:
    study, file = stored
    for each in (priced(study), priced(load_study(file))):
        for index in (0, 3, 7, 11):
            assert each.points[index].result == study.points[index].result
            assert each.points[index].reasons == study.points[index].reasons
    assert priced(study).to_json() == study.to_json()


def test_tables_and_data_of_priced_points_are_those_of_full_results(stored: tuple[Study, Path]) -> None:
    study = stored[0]
    twin = priced(study)
    assert (study.feasible, study.front, study.reasons) == (twin.feasible, twin.front, twin.reasons)
    assert 0 < len(study.feasible) < 12
    assert study_sentence(study) == study_sentence(twin)
    for ours, theirs in zip(study_tables(study, everything=True), study_tables(twin, everything=True), strict=True):
        assert render_text(ours, 200) == render_text(theirs, 200)
    assert render_csv(study_csv(study)) == render_csv(study_csv(twin))
    assert chart_data(study) == chart_data(twin)
    for index in (study.feasible[0], 5):
        assert study.explain(index) == twin.explain(index)


def test_tables_need_no_full_result_of_most_points(stored: tuple[Study, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """Not one of a study that cannot be simulated: its verdicts are not assessed then, and all else is told."""
    alone = replace(priced(stored[0]), specs=None)
    titles = [table.title for table in study_tables(alone, everything=True)]
    assert titles == [table.title for table in study_tables(stored[0], everything=True)]
    (row, *_) = study_tables(alone)[1].rows
    assert "nothing is known of its specs" in row[3].text
    with pytest.raises(InputError, match="of no exploration"):
        _ = alone.points[0].result


def test_a_point_that_comes_to_other_figures_now_is_refused(stored: tuple[Study, Path]) -> None:
    study = priced(stored[0])
    figures = {name: study.outcomes.figures[name] * (1.5 if name == "energy_j" else 1) for name in PRICED}
    other = replace(study, outcomes=replace(study.outcomes, figures=figures))
    index = study.feasible[0]
    with pytest.raises(InputError, match=f"point {index} has another {FIGURES['energy_j'].label} now"):
        _ = other.points[index].result
