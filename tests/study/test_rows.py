"""A study and a result as raw columns and data frames, and as short texts."""

import numpy as np
import pytest
from report_samples import a_result, a_study

from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES
from codesign.study.columns import study_columns

pandas = pytest.importorskip("pandas")


def test_the_frame_of_a_study_has_each_point_and_its_figures() -> None:
    study = a_study()
    frame = study.frame()
    assert list(frame["index"]) == [point.index for point in study.points]
    figure = FIGURES["energy_j"]
    for point, value in zip(study.points, frame["energy_j"], strict=True):
        expected = point.figure(figure)
        assert value == expected if expected is not None else pandas.isna(value)
    assert list(frame.columns) == list(study_columns(study))


def test_an_axis_of_quantities_is_a_column_of_numbers() -> None:
    study = a_study()
    axes = {**study.axes, "fpga.clock": ("100 MHz", "1.5 MHz"), "link.delay": ("1 ms", 3)}
    outcomes = study.outcomes.chosen(np.repeat(np.arange(len(study.points)), 4))
    columns = study_columns(type(study)("a", "b", axes, study.objectives, (), outcomes))
    assert columns["fpga.clock_hz"][:4] == [100_000_000] * 2 + [1_500_000] * 2
    # One value is no quantity, so the column keeps what the workload says.
    assert columns["link.delay"][:4] == ["1 ms", 3] * 2
    assert "[" in str(columns["relax.block"][0])


def test_the_frame_of_a_result_has_its_figures_with_units() -> None:
    result = a_result()
    frame = result.frame().set_index("figure")
    assert frame.loc["energy_j", "unit"] == "J"
    assert frame.loc["energy_j", "value"] == result.figure(FIGURES["energy_j"])


def test_the_texts_of_a_study_and_its_parts_are_short() -> None:
    study = a_study()
    assert len(repr(study)) < 200
    assert all(len(repr(point)) < 200 for point in study.points)
    assert len(repr(a_result())) < 300
    assert repr(study).startswith(f"Study({study.platform} × {study.workload}: ")


def test_without_pandas_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(InputError, match="needs pandas"):
        a_study().frame()
