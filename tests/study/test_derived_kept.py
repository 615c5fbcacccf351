"""Derived figures of any unit: what an exploration computes, its store, JSON, CSV and Parquet give again."""

from __future__ import annotations

import contextlib
import csv
import io
import json
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

import codesign
from codesign.ground.models import RefusalError
from codesign.inputs.constraint import constraint_of, limit_text
from codesign.inputs.derived import MAX_UNIT, derived, in_scope, read_figures
from codesign.inputs.exploration import Exploration
from codesign.inputs.expression import parse
from codesign.study import explore, load_study
from codesign.views.report import render_csv, study_csv

FIGURES = ["energy_j", "plan_time_worst_s", "power", "slices", "clearance_mean", "precision"]
UNITS = ["1 J", "2 mV", "3 A", "1 m / s", "1 b"]


def expressions() -> st.SearchStrategy[str]:
    """Products, quotients and roots, which give every power of every unit; sums of what has one unit."""

    def wider(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        pairs = st.tuples(st.sampled_from(["({} * {})", "({} / ({}))"]), inner, inner)
        return st.one_of(
            pairs.map(lambda each: each[0].format(each[1], each[2])),
            inner.map(lambda each: f"sqrt({each})"),
            inner.map(lambda each: f"max({each}, 2 * {each})"),
        )

    leaves = st.one_of(st.sampled_from(FIGURES), st.sampled_from(UNITS).map(lambda unit: f"({unit})"))
    return st.recursive(leaves, wider, max_leaves=8)


SMALL = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: rooms, rows: 12, columns: 18, room: [5, 5], door: 2, seed: 3}
  goals: [[2, 2]]
  starts: {count: 3, seed: 1}
mapping:
  relax: {component: fabric, block: [6, 9], iterations: 4, schedule: [15]}
explore:
  axes: {fabric.clock: [10 MHz, 40 MHz], pci.clock: [10 MHz, 33 MHz]}
  figures:
"""


def named(text: str) -> Any:
    """The derived figure of a text; None if it names no figure or is too long."""
    with contextlib.suppress(RefusalError):
        return derived("it", text)
    return None


@settings(max_examples=examples(300))
@given(expressions(), st.floats(1e-9, 1e9))
def test_every_unit_that_an_expression_has_is_read_again(text: str, limit: float) -> None:
    figure = named(text)
    if figure is None:
        return
    # As a file has it, behind a number, below a fraction line, and as the unit of a limit.
    assert read_figures({"it": figure.as_written})["it"] == figure
    if figure.unit != "1":
        assert parse(f"3 {figure.unit}", {}).powers == figure.node.powers
        assert (derived("it", text, figure.unit).size, figure.limit(f"3 {figure.unit}")) == (1.0, 3.0)
    with in_scope({"it": figure}):
        below = constraint_of(f"it < {limit:.12g}{'' if figure.unit == '1' else ' ' + figure.unit}")
        assert constraint_of(limit_text(below)) == below
    section = Exploration.model_validate({"figures": {"it": text}, "objectives": ["it"]})
    assert Exploration.model_validate(section.model_dump(mode="json")) == section


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("1 / (plan_time_worst_s * plan_time_worst_s)", "/ s^2"),
        ("sqrt(plan_time_worst_s)", "s^(1/2)"),
        ("slices / sqrt(plan_time_worst_s)", "/ s^(1/2)"),
        ("energy_j * sqrt(energy_j)", "J^(3/2)"),
        ("sqrt(sqrt(energy_j)) / plan_time_worst_s", "J^(1/4) / s"),
        ("energy_j * " + "sqrt(" * 30 + "energy_j" + ")" * 30, f"J^({2**30 + 1}/{2**30})"),
        (" * ".join(["energy"] * 50), "J^50"),
    ],
)
def test_units_of_any_power(text: str, unit: str) -> None:
    figure = derived("it", text)
    assert figure.unit == unit
    assert read_figures({"it": figure.as_written})["it"] == figure


def test_a_unit_too_long_to_be_kept_is_refused_before_anything_is_computed() -> None:
    deep: dict[str, Any] = {
        "a0": "energy_j / " + " / ".join(f"(1 {unit})" for unit in ("A", "m", "b", "s", "USD", "cells"))
    }
    deep |= {f"a{number}": "sqrt(" * 25 + f"a{number - 1}" + ")" * 25 for number in range(1, 6)}
    with pytest.raises(ValueError, match="has a unit of"):
        read_figures(deep)
    assert len(read_figures({"a0": deep["a0"]})["a0"].unit) <= MAX_UNIT


@pytest.mark.parametrize(
    ("unit", "what"),
    [
        ("mJ^(1/2)", "a root of mJ is not exact"),
        ("ps^1000", "no powers"),
        ("ps^(99999999999999999999/1)", "a power that is too large"),
        ("s^(1/0)", "no powers"),
        ("s^^2", "no powers"),
        ("s^2^2", "no powers"),
    ],
)
def test_powers_that_are_none(unit: str, what: str) -> None:
    with pytest.raises(RefusalError) as caught:
        parse(f"3 {unit}", {})
    assert what in caught.value.what


@settings(max_examples=12, deadline=None)
@given(st.lists(expressions().filter(lambda text: named(text) is not None), min_size=8, max_size=16))
def test_what_was_computed_is_read_again(tmp_path_factory: pytest.TempPathFactory, texts: list[str]) -> None:
    folder = tmp_path_factory.mktemp("kept")
    figures = "".join(f"    f{number}: {json.dumps(text)}\n" for number, text in enumerate(texts))
    (folder / "small.yaml").write_text(SMALL + figures, encoding="utf-8")
    platform, workload = codesign.load_platform("virtex2-pci"), codesign.load_workload(folder / "small.yaml")
    study = explore(platform, workload, workers=1, store=folder / "a.hwsw")
    again = load_study(folder / "a.hwsw")
    assert again.figures == study.figures
    document = json.loads(study.to_json())
    assert read_figures(document["figures"]) == study.figures
    columns = {name: study.outcomes.column(figure) for name, figure in study.figures.items()}
    (header, *rows) = csv.reader(io.StringIO(render_csv(study_csv(again))))
    study.to_parquet(folder / "a.parquet")
    table = pytest.importorskip("pyarrow.parquet").read_table(folder / "a.parquet")
    for name, column in columns.items():
        np.testing.assert_array_equal(again.outcomes.column(again.figures[name]), column)
        held = [point["figures"][name] for point in document["points"]]
        np.testing.assert_array_equal([np.nan if each is None else each for each in held], column)
        title = study.figures[name].column
        assert title == name if study.figures[name].unit == "1" else title.startswith(f"{name}_")
        if np.isnan(column).all():
            assert title not in header
            continue
        place = header.index(title)
        assert [float(row[place] or "nan") for row in rows] == pytest.approx(column.tolist(), nan_ok=True)
        np.testing.assert_array_equal(table[title].to_numpy(), column)
