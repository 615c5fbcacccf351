"""docs/spec.md: its examples load, its faults are real, and the kinds that it names exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from places import ROOT

from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES as DECLARED
from codesign.inputs import cross_check, load_platform, load_workload
from codesign.inputs.links import LINKS
from codesign.inputs.scenario import SCENARIOS
from codesign.system import catalog

TEXT = (ROOT / "docs" / "spec.md").read_text(encoding="utf-8")
BLOCKS = ["\n".join(line[4:] for line in block.splitlines()) for block in re.findall(r"(?:^    .*\n?)+", TEXT, re.M)]


def example(kind: str) -> str:
    (found,) = (block for block in BLOCKS if block.startswith(f"kind: {kind}"))
    return found + "\n"


def test_the_examples_load_and_fit_each_other(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(example("platform"))
    (tmp_path / "w.yaml").write_text(example("workload"))
    workload = load_workload(tmp_path / "w.yaml", catalog.task_models())
    cross_check(load_platform(tmp_path / "p.yaml"), workload)
    (tmp_path / "p.yaml").write_text(example("platform").replace("fabric: fpga, ", ""))
    with pytest.raises(SpecError, match="fabric"):
        cross_check(load_platform(tmp_path / "p.yaml"), workload)


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


def test_every_scenario_figure_and_link_that_it_names_is_there() -> None:
    kinds = set(re.findall(r"^- `(\w+)`: ", section("## A workload"), re.M))
    assert kinds == set(SCENARIOS)
    links = set(re.findall(r"`(\w+)` (?:is a|takes)", section("## A platform")))
    assert links == set(LINKS)
    named = re.findall(r"^- (`\w+`(?: and `\w+`)?)", section("## Figures"), re.M)
    figures = [each for text in named for each in re.findall(r"\w+", text) if each != "and"]
    assert len(figures) == 7
    assert set(figures) <= set(DECLARED)


def section(heading: str) -> str:
    """The text below a heading, up to the next one."""
    return TEXT.split(f"\n{heading}\n")[1].split("\n## ")[0]
