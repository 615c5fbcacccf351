"""``hwsw synth``: the tables and JSON of a design point, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from codesign.cli import main
from codesign.hardware.rtl import tools

WORKLOAD = """
kind: workload
name: small
planner: breadth_first
problem:
  map: {generate: empty, rows: 11, columns: 11}
  goals: [[9, 9]]
  starts: [[1, 1]]
scenario: {type: plan_once}
mapping:
  search: {component: fabric, style: state_machine, display: none}
"""


@pytest.fixture
def workload(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))
    path = tmp_path / "small.yaml"
    path.write_text(WORKLOAD, encoding="utf-8")
    return str(path)


def synth(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(main, ["synth", *words])
    return result.exit_code, result.output


def test_a_design_point_is_counted_by_line_and_by_module(workload: str) -> None:
    pytest.importorskip("pyosys")
    code, output = synth("ulx3s-85f", workload)
    assert code == 0, output
    assert "Lines of the demand, ecp5" in output
    assert "breadth_first_top" in output
    code, output = synth("ulx3s-85f", workload, "--json")
    document = json.loads(output)
    assert document["clock_hz"] is None
    assert document["law_hz"]["low"] < document["law_hz"]["high"]
    by_resource = {
        kind: sum(line["synthesised"] for line in document["lines"] if line["resource"] == kind)
        for kind in document["total"]
    }
    assert by_resource == document["total"]
    assert document["total"]["lut4"] == sum(module["lut4"] for module in document["modules"])


@pytest.mark.slow
def test_a_7_series_part_has_counts_and_no_clock(workload: str) -> None:
    pytest.importorskip("pyosys")
    code, output = synth("zynq", workload)
    assert code == 0, output
    assert "their open timing is not to be trusted" in output


def test_another_family_is_not_held_against_the_laws_of_the_part(workload: str) -> None:
    pytest.importorskip("pyosys")
    code, output = synth("ulx3s-85f", workload, "--family", "gowin", "--json")
    assert code == 0, output
    document = json.loads(output)
    assert document["family"] == "gowin"
    assert all(line["predicted"] is None for line in document["lines"])


@pytest.mark.parametrize(
    ("platform", "options", "fault"),
    [
        ("zynq", ["--place"], "no open place and route is to be trusted for part XC7Z020-1"),
        ("icicle-kit", [], "no open tool synthesises for PolarFire SoC"),
        ("ulx3s-85f", ["--family", "ecp6"], "did you mean ecp5"),
        ("ulx3s-85f", ["--family", "gowin", "--place"], "leave --family out"),
        ("ulx3s-85f", ["--seeds", "3"], "add --place"),
        ("laptop", [], "a processor: it has no circuit"),
    ],
)
def test_what_no_open_tool_does_is_refused(workload: str, platform: str, options: list[str], fault: str) -> None:
    if platform == "laptop":
        text = Path(workload).read_text(encoding="utf-8")
        text = text.replace("fabric, style: state_machine, display: none", "host, style: software")
        Path(workload).write_text(text, encoding="utf-8")
    code, output = synth(platform, workload, *options)
    assert code == 2, output
    assert fault in output


def test_a_missing_tool_is_named_with_what_installs_it(workload: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tools, "command_of", lambda _name: None)
    code, output = synth("ulx3s-85f", workload)
    assert code == 1
    assert "pyosys is not installed" in output
    assert "pip install" in output
