"""docs/spec.md: its examples load, its faults are real, and it knows every generator and figure."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from codesign.errors import SpecError
from codesign.spec import ResultFigure, cross_check, load_platform, load_workload
from codesign.spec.problem import MAPS
from codesign.system import catalog

TEXT = (Path(__file__).resolve().parent.parent / "docs" / "spec.md").read_text(encoding="utf-8")
BLOCKS = [
    "\n".join(line[4:] for line in block.splitlines()) for block in re.findall(r"(?:^    .*\n?)+", TEXT, re.M)
]


def example(kind: str) -> str:
    (found,) = (block for block in BLOCKS if block.startswith(f"kind: {kind}"))
    return found + "\n"


def test_the_examples_load_and_fit_each_other(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(example("platform"))
    (tmp_path / "w.yaml").write_text(example("workload"))
    cross_check(load_platform(tmp_path / "p.yaml"), load_workload(tmp_path / "w.yaml", catalog.task_models()))


def test_the_faults_are_real(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(
        "kind: platform\nname: mine\ncomponents:\n"
        "  fpga: {type: fpga, part: XC4VLX160-12, clock: 650 MHz}\n"
        "  host:\n    type: processor\n    clock: 2 ghz\n    cost: {harmonic_node_update: 42.088 ns}\n"
        "    power: {busy: 75 W, idle: 010}\n"
    )
    with pytest.raises(SpecError) as caught:
        load_platform("mine.yaml")
    assert str(caught.value) in {block.strip() for block in BLOCKS}


def test_every_generator_with_its_defaults_and_every_figure_stand_there() -> None:
    for name, model in MAPS.items():
        (row,) = re.findall(rf"^\| `{name}` \| (.*) \|$", TEXT, re.M)
        expected = []
        for field, info in model.model_fields.items():
            if field != "generate":
                default = list(info.default) if isinstance(info.default, tuple) else info.default
                expected.append(f"`{field}`" if info.is_required() else f"`{field}: {default}`")
        assert set(re.findall(r"`[^`]+`", row)) == set(expected)
    for figure in ResultFigure:
        assert f"`{figure}`" in TEXT
