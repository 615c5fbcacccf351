"""A run of a circuit decides for the first start of the workload, in the model, in the bench and in the circuit."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from rtl_tools import quickest

from codesign.hardware.rtl.placed import placed
from codesign.inputs import load_platform
from codesign.planners.harmonic.plan.planner import PLANNER
from codesign.planners.harmonic.rtl.expected import decision_value
from codesign.system import catalog

Run = Callable[..., Result]

STARTS = ((4, 10), (0, 0), (1, 9), (4, 1), (0, 5))
MAP = "{generate: rooms, rows: 6, columns: 12, room: [5, 5], door: 2, seed: 1}"
RELAX = "block: [6, 12], iterations: 6, schedule: {first: 7, step: 8, last: 31}"
MAPPINGS = {
    "together": f"{{relax: {{component: fabric, {RELAX}}}, decide: {{component: fabric}}}}",
    "alone": f"{{relax: {{component: host, {RELAX}}}, decide: {{component: fabric}}}}",
}


def workload(folder: Path, start: tuple[int, int], mapping: str) -> Path:
    path = folder / "small.yaml"
    path.write_text(
        f"kind: workload\nname: small\nplanner: harmonic\n"
        f"problem: {{map: {MAP}, goals: [[1, 1]], starts: [{list(start)}, [4, 4]]}}\n"
        f"scenario: {{type: plan_once}}\nmapping: {MAPPINGS[mapping]}\n",
        encoding="utf-8",
    )
    return path


@pytest.mark.parametrize("mapping", MAPPINGS)
def test_what_is_exported_decides_at_the_first_start(hwsw: Run, mapping: str, tmp_path: Path) -> None:
    seen, positions = set(), set()
    for start in STARTS:
        path = workload(tmp_path, start, mapping)
        made = hwsw("rtl", "ulx3s-85f", path, "--set", "fabric.clock=20MHz", "--force", "-o", tmp_path / "out")
        if "obstacle" in made.output:
            continue
        assert made.exit_code == 0, made.output
        with (tmp_path / "out" / "golden.csv").open(encoding="utf-8", newline="") as file:
            (event,) = [int(row["value"]) for row in csv.DictReader(file) if row["event"] == "decision"]
        job = placed(load_platform("ulx3s-85f"), catalog.load_workload(path)).job
        assert event == decision_value(PLANNER.plan(job).field, *start)
        readme = (tmp_path / "out" / "README.md").read_text(encoding="utf-8")
        assert f"row {start[0]}, column {start[1]} of the map" in readme
        seen.add(event)
        positions.add((tmp_path / "out" / "stream.hex").read_text(encoding="utf-8").split()[-1])
    assert len(seen) > 1
    assert len(positions) > 1


@pytest.mark.parametrize("mapping", MAPPINGS)
def test_the_circuit_decides_there_too(hwsw: Run, mapping: str, tmp_path: Path) -> None:
    result = hwsw("verify", "ulx3s-85f", workload(tmp_path, STARTS[0], mapping), "--backend", quickest())
    assert result.exit_code == 0, result.output
