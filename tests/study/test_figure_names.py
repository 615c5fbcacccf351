"""One name for one figure: that of its column is accepted wherever a figure is named, and any other name is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from pydantic import ValidationError

import codesign
from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES, ResultFigure, named_unit
from codesign.ground.models import RefusalError
from codesign.inputs.constraint import constraint_of, declared
from codesign.inputs.derived import derived, read_figures
from codesign.study.columns import columns_of

DERIVED = {
    "delay": "energy_j * plan_time_worst_s",
    "watts": {"expression": "energy_j / plan_time_worst_s", "unit": "mW"},
    "ratio": "slices / block_rams",
    "wait_s": "2 * plan_time_worst_s",
}
COLUMNS = {"delay": "delay_j_s", "watts": "watts_mw", "ratio": "ratio", "wait_s": "wait_s"}


@pytest.fixture(scope="module")
def study() -> codesign.Study:
    workload = {
        "kind": "workload", "name": "small", "planner": "breadth_first",
        "problem": {"map": {"generate": "empty", "rows": 8, "columns": 8}, "goals": [[0, 0]], "starts": [[7, 7]]},
        "mapping": {"search": {"component": "fpga"}},
        "explore": {
            "axes": {"fpga.clock": ["50 MHz", "100 MHz"]},
            "figures": DERIVED, "objectives": ["power_w", "delay_j_s"], "constraints": ["power_w < 1 kW"],
        },
    }  # fmt: skip
    return codesign.explore("virtex2-pci", workload)


@pytest.mark.parametrize("figure", FIGURES.values(), ids=str)
def test_a_column_names_its_figure_everywhere(figure: ResultFigure) -> None:
    assert declared(figure.column) is figure
    assert derived("twice", f"2 * {figure.column}").names == (figure.name,)
    limit = f"3 {figure.unit}" if figure.unit in ("s", "W", "J", "m") else "1"
    assert constraint_of(f"{figure.column} < {limit}").figure is figure
    said = named_unit(figure.column)[1]
    assert figure.unit in (said, "1") or figure.column.endswith(f"_{figure.unit.lower()}")


def test_every_column_of_a_study_that_is_a_figure_names_it(study: codesign.Study) -> None:
    point = study.points[0]
    names = [each.name for each in columns_of(study) if each.of(np.arange(1)).dtype.kind == "f"]
    assert {"power_w", "delay_j_s", "watts_mw", "wait_s"} < set(names)
    for column in names:
        stem = column.removesuffix("_low").removesuffix("_high")
        figure = study.figure_of(stem)
        assert figure.column == stem
        assert point.figure(stem) == point.figure(figure) == point.figure(figure.name)
        assert study.needing([f"{stem} <= 2 * {figure.name}"]).points
    assert {name: study.figures[name].column for name in COLUMNS} == COLUMNS


def test_a_name_that_no_figure_has_is_refused_with_the_nearest(study: codesign.Study) -> None:
    result = study.points[0].result
    assert result is not None
    assert result.figure("plan_time_worst_s") == result.figure(FIGURES["plan_time_worst_s"]) is not None
    assert result.interval("power_w") == result.interval(FIGURES["power"]) is not None
    for ask in (result.figure, result.interval, *(held for each in (study.points[0], study.designs[0])
                for held in (each.figure, getattr(each, "interval", each.figure)))):  # fmt: skip
        with pytest.raises(InputError, match="'powr_w' is no figure") as caught:
            ask("powr_w")
        assert "did you mean power?" in str(caught.value)
    with pytest.raises(InputError, match="did you mean delay"):
        study.points[0].figure("dellay")


@pytest.mark.parametrize(
    "figures",
    [
        {"plan_time_worst": "2 * plan_time_worst_s"},  # plan_time_worst_s
        {"wait": "plan_time_worst_s", "wait_s": "slices"},
        {"wait_s": "slices", "wait": "plan_time_worst_s"},
        {"wait": "plan_time_worst_s", "wait_s_low": "slices"},
    ],
)
def test_no_two_figures_have_one_column(figures: dict[str, str]) -> None:
    with pytest.raises((ValidationError, RefusalError), match="column"):
        read_figures(figures)


def test_the_command_line_takes_what_its_csv_shows(
    hwsw: Callable[..., Result], specs: tuple[Path, Path], tmp_path: Path
) -> None:
    ran = hwsw("run", *specs, "--need", "power_w < 1 kW", "--need", "power_w * plan_time_worst_s < 1 kJ")
    assert ran.exit_code == 0, ran.output
