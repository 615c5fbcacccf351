"""Every declared figure of a result: what a study says of it is what a run says, and every view has it."""

from __future__ import annotations

import csv
import io
from functools import cache
from typing import Any

import kinds
import pytest

import codesign
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.study import Study, explore
from codesign.study.check import check_points
from codesign.study.columns import study_columns
from codesign.study.pricing.price import PRICED, _is_of_whole_results
from codesign.system.results.result import Result
from codesign.views.report import render_csv
from codesign.views.report.study_tables import study_csv

AXES: dict[str, Any] = {"fpga.clock": ["10 MHz", "45 MHz"], "line.width": [8, 32]}

NEW = (
    ResultFigure("double_time", "", "twice the time", value=lambda result: 2 * result.time.first_plan_s),
    ResultFigure("links_j", "energy", "energy of links"),
    ResultFigure("map_loaded_s", "time", "when the map was there"),
    ResultFigure("reachable_cells", "quality", "free cells that lead to a goal"),
    ResultFigure("blocks", "", "blocks that the map is cut into"),
)
"""Figures that somebody might declare: computed of a result, moved by prices, not moved, and of the result itself."""


def study_of(axes: dict[str, Any]) -> Study:
    return explore(kinds.platform(kinds.link("bus")), kinds.workload(axes), workers=1)


@cache
def held() -> set[str]:
    """The fields of a result that pricing gives the points of a computation."""
    return {
        name for each in study_of(AXES).outcomes.templates for name, value in dict(each).items() if value is not None
    }


@pytest.fixture(scope="module")
def study() -> Study:
    return study_of(AXES)


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_stands_in_every_view(study: Study, name: str) -> None:
    figure = FIGURES[name]
    result = codesign.simulate(kinds.platform(kinds.link("bus")), kinds.workload())
    if result.figure(figure) is None:
        pytest.skip("a plan of this planner has none")
    assert all(value is not None for value in study_columns(study)[figure.column])
    head, *rows = csv.reader(io.StringIO(render_csv(study_csv(study))))
    assert all(row[head.index(figure.column)] for row in rows)


def test_what_a_study_says_is_what_a_run_says(study: Study) -> None:
    assert study.simulations == 1, "the shipped figures are priced"
    assert check_points(study, 4).differences == ()


@pytest.mark.parametrize("figure", NEW, ids=str)
def test_a_new_figure_is_that_of_a_run_for_every_point(figure: ResultFigure, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FIGURES, figure.name, figure)
    study = study_of(AXES)
    assert check_points(study, 4).differences == ()
    assert all(point.figure(figure) is not None for point in study.points)


@pytest.mark.parametrize("name", sorted({*Result.model_fields, "a_field_that_somebody_adds"}))
def test_what_a_template_does_not_have_is_taken_from_whole_results(name: str) -> None:
    """Else a study would say that a point has no such figure, and a run of the point would have one."""
    run = codesign.simulate(kinds.platform(kinds.link("bus")), kinds.workload())
    kept = name in held() or getattr(run, name, 1) is None
    assert kept or name in PRICED or _is_of_whole_results(ResultFigure(name, "", "a figure"))
