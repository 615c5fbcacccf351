"""A study as a Parquet file: what pandas, Polars and DuckDB read is what the study holds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_samples import a_study

import codesign
from codesign.ground.errors import InputError, RunError
from codesign.ground.progress import Advance
from codesign.inputs.exploring import exploring
from codesign.study import columns
from codesign.study.columns import study_columns
from codesign.study.study import Study

pytest.importorskip("pyarrow", reason="pyarrow is not installed: pip install 'hwsw-codesign[parquet]'")

AXES = {
    "relax.iterations": {"values": [4, 6]},
    "relax.schedule": {"values": [[7, 15], {"first": 7, "step": 8, "last": 31}]},
    "fabric.part": {"values": ["XC2V6000-4", "XC3S500E-4"]},
    "fabric.clock": {"values": ["100 MHz", "200 MHz", "400 MHz"]},
}


@pytest.fixture(scope="module")
def study() -> Study:
    """Points that fit, that do not, and that are too fast."""
    workload = exploring(codesign.load_workload("labyrinth"), AXES, {}, ("energy_j < 0.5 mJ",))
    platform, workload = codesign.inputs.pin(
        codesign.load_platform("virtex4-pci"), workload, {"workload.problem.arrive": 0, "relax.block": [36, 66]}, ""
    )
    return codesign.explore(platform, workload, workers=1)


@pytest.fixture(scope="module")
def file(study: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("parquet") / "study.parquet"
    study.to_parquet(path)
    return path


def columns_of(reader: str, path: Path) -> dict[str, list[Any]]:
    """The columns of a file as a reader has them, with None for what is null."""
    module = pytest.importorskip(reader, reason=f"{reader} is not installed: pip install {reader}")
    if reader == "pandas":
        frame = module.read_parquet(path).astype(object)
        rows = frame.where(frame.notna(), None)
        return {name: rows[name].tolist() for name in rows}
    if reader == "polars":
        return dict(module.read_parquet(path).to_dict(as_series=False))
    cursor = module.sql(f"SELECT * FROM read_parquet('{path}') ORDER BY index")
    return dict(zip(cursor.columns, map(list, zip(*cursor.fetchall(), strict=True)), strict=True))


@pytest.mark.parametrize("reader", ["pandas", "polars", "duckdb"])
def test_every_reader_sees_the_columns_of_the_study(study: Study, file: Path, reader: str) -> None:
    columns = columns_of(reader, file)
    expected = study_columns(study)
    reasons = columns.pop("reason")
    assert list(columns) == list(expected)
    for name, values in expected.items():
        assert columns[name] == values, name
    for point, reason in zip(study.points, reasons, strict=True):
        assert reason == ("; ".join(f"{each.kind} {each.name}" for each in point.reasons) or point.failure)
    assert {text.split()[0] for text in filter(None, reasons)} >= {"resource", "clock", "constraint"}
    assert "failed" in columns["state"]


def test_axes_and_reasons_stand_once_in_a_dictionary(file: Path) -> None:
    from pyarrow.parquet import read_schema

    schema = read_schema(file)
    named = {name: str(schema.field(name).type) for name in ("relax.schedule", "reason", "state")}
    assert all(text.startswith("dictionary<values=string") for text in named.values())
    numeric = {name: str(schema.field(name).type) for name in ("fabric.clock_hz", "slices", "energy_j")}
    assert numeric == {"fabric.clock_hz": "int64", "slices": "int64", "energy_j": "double"}
    assert schema.metadata[b"hwsw.workload"] == b"labyrinth"


def test_groups_change_nothing(study: Study, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pyarrow.parquet import ParquetFile, read_table

    monkeypatch.setattr(columns, "POINTS_A_GROUP", 7)
    study.to_parquet(tmp_path / "groups.parquet")
    assert ParquetFile(tmp_path / "groups.parquet").num_row_groups == -(-len(study.points) // 7)
    # Dictionaries of groups differ; their texts do not.
    assert read_table(tmp_path / "groups.parquet").to_pylist() == read_table(file).to_pylist()


def test_it_says_how_many_rows_are_written(study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "POINTS_A_GROUP", 3)
    shown: list[Advance] = []
    study.to_parquet(tmp_path / "points.parquet", shown.append)
    assert (shown[0].done, shown[0].total) == (0, len(study.points))
    assert (shown[-1].done, shown[-1].left_s) == (len(study.points), 0.0)
    assert {each.words for each in shown} == {"rows of Parquet written"}


def test_a_study_put_together_by_hand_has_failures_and_gaps(tmp_path: Path) -> None:
    from pyarrow.parquet import read_table

    study = a_study()
    study.to_parquet(tmp_path / "hand.parquet")
    table = read_table(tmp_path / "hand.parquet").to_pydict()
    for point, reason, state in zip(study.points, table["reason"], table["state"], strict=True):
        assert state == point.state
        assert reason == ("; ".join(f"{each.kind} {each.name}" for each in point.reasons) or point.failure)


def test_the_file_is_there_whole_or_not_at_all(study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "study.parquet"
    path.write_bytes(b"what was there")
    monkeypatch.setattr(Study, "on_front", property(lambda self: np.zeros(0)[1]))
    with pytest.raises(IndexError):
        study.to_parquet(path)
    assert path.read_bytes() == b"what was there"
    assert [each.name for each in tmp_path.iterdir()] == ["study.parquet"]
    monkeypatch.undo()
    with pytest.raises(RunError, match="cannot write"):
        study.to_parquet(tmp_path / "nowhere" / "study.parquet")


def test_without_pyarrow_the_remedy_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(InputError, match="needs pyarrow"):
        a_study().to_parquet(tmp_path / "study.parquet")


def test_the_command_writes_what_the_study_writes(hwsw: Any, tmp_path: Path) -> None:
    from pyarrow.parquet import read_table

    store, written, again = (tmp_path / name for name in ("s.sqlite", "one.parquet", "two.parquet"))
    words = ("--axis", "relax.iterations=4,6", "--axis", "relax.schedule=[7,15]")
    settings = ("--set", "workload.problem.arrive=0", "--set", "relax.block=[36,66]", "--set", "fabric.clock=100MHz")
    explored = hwsw(
        "explore", "virtex4-pci", "labyrinth", *words, *settings, "--store", store, "--workers", 1, "--parquet", written
    )
    assert explored.exit_code == 0, explored.output
    assert f"parquet: {written}" in explored.output
    assert hwsw("report", store, "--parquet", again, "--json").exit_code == 0
    assert read_table(written).to_pylist() == read_table(again).to_pylist()
    assert len(json.loads(hwsw("report", store, "--json").stdout)["points"]) == read_table(again).num_rows
