"""The commands that list, check and begin: what they print and what they leave."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from full_disk import full_disk

from codesign.inputs import list_platforms, list_workloads

Run = Callable[..., Result]
Specs = tuple[Path, Path]


def test_init_on_a_full_disk_leaves_nothing(hwsw: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full_disk(monkeypatch, 1)
    result = hwsw("init", tmp_path / "start")
    assert result.exit_code == 1
    assert "No space left" in result.stderr
    assert list((tmp_path / "start").iterdir()) == []


def test_written_paths_reach_the_terminal_harmless(hwsw: Run, tmp_path: Path) -> None:
    result = hwsw("init", tmp_path / "a\x1b[31mb")
    assert result.exit_code == 0
    assert "\x1b" not in result.output


def test_list_says_what_planners_and_styles_do(hwsw: Run) -> None:
    found = json.loads(hwsw("list", "--json").stdout)
    assert found["planners"]["harmonic"].startswith("A potential without local maxima")
    assert found["styles"]["harmonic.bit_serial"].startswith("on fpga: a bit-serial circuit")
    # Styles that differ in what they cost differ in what is said of them.
    assert found["styles"]["harmonic.software"] != found["styles"]["harmonic.software_limbs"]
    for text in (found["planners"]["harmonic"], found["styles"]["harmonic.bit_serial"]):
        assert "`" not in text
    lines = hwsw("list").stdout.splitlines()
    begin = lines.index("styles:") + 1
    assert len({line.index(" on ") for line in lines[begin : begin + len(found["styles"])]}) == 1


@pytest.mark.parametrize("platform", list_platforms())
def test_every_shipped_platform_is_sound(hwsw: Run, platform: str) -> None:
    result = hwsw("check", platform)
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("workload", list_workloads())
def test_every_shipped_workload_fits_some_platform(hwsw: Run, workload: str) -> None:
    assert any(hwsw("check", platform, workload).exit_code == 0 for platform in list_platforms())


def test_list_names_what_ships(hwsw: Run) -> None:
    found = json.loads(hwsw("list", "--json").output)
    assert {"virtex2-pci", "virtex4-pci"} <= set(found["platforms"])
    assert "labyrinth" in found["workloads"]
    assert {"XC4VLX160-12", "XC2V6000-4", "XC3S500E-4"} <= set(found["parts"])
    assert "harmonic.bit_serial" in found["styles"]
    assert "cortex-a72" in found["hosts"]
    assert found["platforms"]["pynq-z2"].endswith("as the host [XC7Z020-1; 169 USD of 2023, assumed]")
    assert "[" not in found["platforms"]["laptop"]


@pytest.mark.parametrize("kind", ["platform", "workload", "part", "host", "result"])
def test_schema_is_json_schema(hwsw: Run, kind: str) -> None:
    schema = json.loads(hwsw("schema", kind).output)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert schema["type"] == "object"
    assert schema["properties"]


def test_all_faults_are_told_at_once(hwsw: Run, specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8")
    text = text.replace("iterations: 4", "iterations: 0").replace("goals: [[2, 2]]", "goal: [[2, 2]]")
    specs[1].write_text(text.replace("part: [XC2V6000-4", "part: [XC2V6000-9"), encoding="utf-8")
    result = hwsw("check", *specs, "--json")
    assert result.exit_code == 2
    faults = json.loads(result.stdout)
    keys = {fault["key"] for fault in faults}
    assert {"mapping.relax.iterations", "problem.goal"} <= keys


def test_init_writes_files_that_run_and_overwrites_nothing(hwsw: Run, tmp_path: Path) -> None:
    assert hwsw("init", tmp_path / "mine").exit_code == 0
    files = sorted((tmp_path / "mine").iterdir())
    assert len(files) == 2
    assert hwsw("check", *files).exit_code == 0
    again = hwsw("init", tmp_path / "mine")
    assert again.exit_code == 2
    assert "exists already" in again.output
