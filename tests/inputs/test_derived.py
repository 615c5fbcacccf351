"""Figures that an exploration derives: read from a file, as objectives, in constraints, over columns."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.models import RefusalError
from codesign.inputs.constraint import constraint_of, limit_text, needs_of
from codesign.inputs.derived import DerivedFigure, derived, derived_column, derived_ends, in_scope
from codesign.inputs.exploration import Exploration

FIGURES = {
    "energy_delay": "energy_j * plan_time_worst_s",
    "slices_a_ms": {
        "expression": "slices / (plan_time_worst_s / 1 ms)",
        "direction": "maximise",
        "label": "slices a ms",
    },
    "steep": {"expression": "energy_delay * plan_time_worst_s", "unit": "mJ ms s"},
}


def section(**more: Any) -> Exploration:
    return Exploration.model_validate({"figures": FIGURES, **more})


def test_objectives_constraints_and_rules_name_derived_figures() -> None:
    held = section(
        objectives=["energy_delay", "slices_a_ms", "slices"],
        constraints=["energy_delay < 3 mJ s", "slices_a_ms >= 2", "steep <= 5 J s s"],
        aggregate={"energy_delay": "mean", "slices_a_ms": "best"},
    )
    first, second, _ = held.objectives
    assert (first.unit, first.direction, first.label) == ("J s", "minimise", "energy delay")
    assert (second.unit, second.direction, second.label) == ("1", "maximise", "slices a ms")
    assert [constraint.bounds for constraint in held.constraints] == [
        {"below": 0.003},
        {"at_least": 2},
        {"at_most": pytest.approx(5e6)},
    ]
    again = Exploration.model_validate(held.model_dump(mode="json"))
    assert again == held
    assert pickle.loads(pickle.dumps(held)) == held


def test_a_constraint_may_be_an_expression_itself() -> None:
    with in_scope({}):
        limit = constraint_of("energy * time < 3 mJ s")
        assert (limit.figure.name, limit.bounds) == ("energy * time", {"below": 0.003})
        assert limit_text(limit) == "energy * time < 0.003 J s"
        assert constraint_of(limit_text(limit)) == limit
        apart = constraint_of("plan_time_worst_s <= 2 * plan_time_mean_s")
        assert (apart.figure.unit, apart.bounds) == ("s", {"at_most": 0.0})
        assert apart.figure.value is not None
        below = constraint_of("slices < cycles / 10")
        assert (below.figure.name, below.bounds) == ("slices - (cycles / 10)", {"below": 0.0})


def test_a_need_may_name_the_figures_of_a_study() -> None:
    figures = section().figures
    (need,) = needs_of(["energy_delay < 3 mJ s"], figures=figures)
    assert (need.figure, need.bounds) == (figures["energy_delay"], {"below": 0.003})
    with pytest.raises(SpecError, match="'energy_delay' is no figure"):
        needs_of(["energy_delay < 3 mJ s"])


def figure(text: str, **more: Any) -> DerivedFigure:
    return derived("it", text, **more)


def test_a_column_and_a_single_result_are_equal_to_the_bit() -> None:
    it = figure("sqrt(slices) * energy_j / (cycles - 3)", unit="mJ")
    columns = {
        "slices": np.array([1.0, 2.0, 3.0, math.nan]),
        "energy_j": np.array([0.1, 0.2, 0.3, 0.4]),
        "cycles": np.array([1.0, 3.0, 7.0, 9.0]),
    }
    together = derived_column(it, columns.__getitem__)
    for place, entry in enumerate(together):
        values = {name: float(column[place]) for name, column in columns.items()}
        alone = it.of({name: None if math.isnan(each) else each for name, each in values.items()}.get)
        assert (alone is None and math.isnan(entry)) or alone == entry
    assert [math.isnan(entry) for entry in together] == [False, True, False, True]
    row = {"slices": 4.0, "energy_j": 1.0, "cycles": 3.0}
    assert it.why_none(row.get) == "division by zero in sqrt(slices) * energy_j / (cycles - 3)"
    low, high = derived_ends(it, lambda name: (columns[name], columns[name] + 1))
    assert low[2] < together[2] < high[2]


REST = """
kind: workload
name: mine
planner: wavefront
problem:
  map: {generate: empty, rows: 8, columns: 8}
  goals: [[1, 1]]
  starts: [[6, 6]]
mapping:
  propagate: {component: fabric, style: tiled, tile: [4, 4]}
"""


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("{a: tme * 2}", "4:16: explore.figures.a: 'tme * 2', character 1: there is no figure 'tme'"),
        ("{energy_j: slices}", "4:13: explore.figures.energy_j: energy_j is a figure"),
        ("{min: slices}", "explore.figures.min: min is a function"),
        ("{ms: slices}", "explore.figures.ms: ms is a unit"),
        ("{a b: slices}", "explore.figures.a b: 'a b' is not a name"),
        ("{a: 3 * 4}", "'3 * 4' names no figure"),
        ("{a: 3}", "3 is no expression"),
        ("{a: {expression: energy_j, unit: s}}", "explore.figures.a.unit: 'energy_j' is in J, not in s"),
        ("{a: {expression: energy_j, unit: joule}}", "explore.figures.a.unit: 'joule' is no unit"),
        ("{a: {expression: energy_j, direction: up}}", "explore.figures.a.direction: 'up' is not accepted"),
        ("{a: {expresion: energy_j}}", "did you mean expression?"),
        ("{a: b_later, b_later: slices}", "there is no figure 'b_later'"),
        ("[slices]", "explore.figures: "),
        ("{a: slices}\n  objectives: [b]", "explore.objectives[0]: 'b' is not accepted"),
        ("{a: slices}\n  objectives: [a * rows]", "explore.objectives[0]: 'a * rows', character 5: there is no figure"),
        ("{a: energy_j}\n  constraints: [a < 3 s]", "'3 s' is in s, and a in J"),
        ("{a: slices}\n  constraints: [a < 1 / 0]", "division by zero in 1 / 0"),
        ("{a: energy_j}\n  constraints: [{figure: a, at_most: 3}]", "3 has no unit"),
    ],
)
def test_faults_have_a_place(tmp_path: Path, written: str, told: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(f"explore:\n  axes: {{}}\n  # figures\n  figures: {written}\n{REST}", encoding="utf-8")
    with pytest.raises(SpecError) as caught:
        codesign.load_workload(path)
    message = str(caught.value)
    assert told in message
    assert f"{path}:4" in message or f"{path}:5" in message


def test_one_expression_cannot_grow_without_bound() -> None:
    figures = {"a0": "slices + slices"} | {f"a{n}": f"a{n - 1} + a{n - 1}" for n in range(1, 12)}
    with pytest.raises(ValueError, match="is too long"):
        Exploration.model_validate({"figures": figures})


def test_a_figure_of_no_known_name_is_refused() -> None:
    with pytest.raises(RefusalError, match="there is no figure 'speed'"):
        figure("speed * 2")
