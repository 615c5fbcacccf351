"""docs/spec.md: its examples load, its faults are real, and it knows every generator and figure."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from doc_tables import fields, rows, says_default, section
from places import ROOT

from codesign.errors import SpecError
from codesign.figures import FIGURES
from codesign.inputs import cross_check, load_platform, load_workload
from codesign.inputs.components import COMPONENTS
from codesign.inputs.exploration import DEFAULT_OBJECTIVES, MISSION_OBJECTIVES
from codesign.inputs.links import LINKS
from codesign.inputs.problem import MAPS
from codesign.inputs.scenario import SCENARIOS, Fleet, PlanOnce
from codesign.inputs.tasks import ExtraTask
from codesign.inputs.workload import TaskMapping, Variant, Workload
from codesign.system import catalog

TEXT = (ROOT / "docs" / "spec.md").read_text(encoding="utf-8")
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


def test_every_generator_stands_there_with_its_defaults() -> None:
    for name, model in MAPS.items():
        (row,) = re.findall(rf"^\| `{name}` \| (.*) \|$", TEXT, re.M)
        expected = []
        for field, info in model.model_fields.items():
            if field != "generate":
                default = list(info.default) if isinstance(info.default, tuple) else info.default
                expected.append(f"`{field}`" if info.is_required() else f"`{field}: {default}`")
        assert set(re.findall(r"`[^`]+`", row)) == set(expected)


def test_the_table_of_figures_is_that_of_the_declarations() -> None:
    """One line a figure: name, unit, what is best, description; and the objectives of files that name none."""
    listed = re.findall(r"^\| `(\w+)` \| (\w*) ?\| (most|least) \| (.*) \|$", TEXT, re.M)
    assert listed == [
        (figure.name, "" if figure.unit == "1" else figure.unit, figure.aim.split()[0], figure.description)
        for figure in FIGURES.values()
    ]
    for objectives in (DEFAULT_OBJECTIVES, MISSION_OBJECTIVES):
        assert f"`{' '.join(figure.name for figure in objectives)}`" in TEXT


@pytest.mark.parametrize("kind", COMPONENTS)
def test_every_key_of_a_component_with_its_default(kind: str) -> None:
    table = rows(section(TEXT, f"### `type: {kind}`"))
    wanted = dict(fields(COMPONENTS[kind]))
    assert {key.replace("costs.KERNEL", "costs") for key in table} == set(wanted)
    for key, info in wanted.items():
        assert says_default(info, table["costs.KERNEL" if key == "costs" else key][0]), key


@pytest.mark.parametrize("kind", LINKS)
def test_every_key_of_a_link_with_its_default(kind: str) -> None:
    """Errors and outages are among what all links have."""
    shared = rows(section(TEXT, "### Links"))
    own = rows(section(TEXT, f"### `type: {kind}`")) if kind != "ideal" else {}
    wanted = dict(fields(LINKS[kind]))
    assert {*shared, *own} - {"type"} == set(wanted)
    for key, info in wanted.items():
        assert says_default(info, {**shared, **own}[key][0]), key


def test_every_scenario_has_its_keys_here_or_in_missions() -> None:
    text = section(TEXT, "### Scenarios")
    assert set(re.findall(r"^- `(\w+)`", text, re.M)) == set(SCENARIOS)
    assert not dict(fields(PlanOnce))
    table, wanted = rows(text), dict(fields(Fleet))
    assert set(table) == set(wanted)
    assert all(says_default(info, table[key][0]) for key, info in wanted.items())


def test_every_key_of_a_workload_with_its_default() -> None:
    table = rows(section(TEXT, "### Added tasks"))
    wanted = dict(fields(ExtraTask))
    assert set(table) == set(wanted)
    assert all(says_default(info, table[key][0]) for key, info in wanted.items())
    table = rows(section(TEXT, "## Workload"))
    assert {key.split(".")[0] for key in table} == set(Workload.model_fields) - {"kind"}
    placed = {key.removeprefix("mapping.TASK."): told for key, (told, _) in table.items()}
    for key, info in TaskMapping.model_fields.items():
        assert key == "parameters" or says_default(info, placed[key]), key
    varied = {key.removeprefix("variants.NAME."): told for key, (told, _) in table.items()}
    assert set(Variant.model_fields) <= set(varied)
