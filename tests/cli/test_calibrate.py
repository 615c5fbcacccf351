"""Costs that are measured on this machine."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import yaml
from click.testing import Result

Run = Callable[..., Result]


def test_calibrate_prints_costs_that_a_platform_takes(hwsw: Run, tmp_path: Path) -> None:
    result = hwsw("calibrate", "host", "--seconds", "0.02")
    assert result.exit_code == 0, result.output
    costs = yaml.safe_load(result.stdout)["costs"]
    assert {"harmonic_node_update", "relaxation_node_update", "breadth_first_cell", "wavefront_cell"} <= set(costs)
    head = "kind: platform\nname: here\ncomponents:\n  host:\n    type: processor\n    clock: 3 GHz\n"
    indented = "".join(f"    {line}\n" for line in result.stdout.splitlines())
    (tmp_path / "here.yaml").write_text(f"{head}    power: {{busy: 20 W, idle: 5 W}}\n{indented}", encoding="utf-8")
    assert hwsw("check", tmp_path / "here.yaml").exit_code == 0
    assert hwsw("calibrate", "host", "--seconds", "nan").exit_code == 2
