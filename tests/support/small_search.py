"""A small workload, and explorations of it that are searched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import codesign
from codesign.inputs import Workload
from codesign.inputs.constraint import constraint_of
from codesign.inputs.exploration import Exploration
from codesign.study.explored import _with_section

MHZ = "{} MHz".format


SMALL = """
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: rooms, rows: 18, columns: 24, room: [5, 5], door: 2, seed: 1}
  goals: [[2, 2]]
  starts: {count: 4, seed: 1}
mapping:
  relax: {component: fpga, block: [6, 8], iterations: 4, schedule: {first: 7, step: 8, last: 31}}
  decide: {component: fpga}
variants:
  other:
    mapping:
      relax: {component: fpga, block: [6, 8], iterations: 2, schedule: {first: 7, step: 8, last: 31}}
"""


def small_workload(folder: Path) -> Workload:
    """A workload with one variant; its file is written to the folder."""
    (folder / "small.yaml").write_text(SMALL)
    return codesign.load_workload(folder / "small.yaml")


def of(
    workload: Workload,
    axes: dict[str, Any],
    objectives: tuple[str, ...] = ("plan_time_worst_s", "slices", "power"),
    constraints: tuple[str, ...] = (),
    when: dict[str, Any] | None = None,
    conditions: dict[str, Any] | None = None,
) -> Workload:
    section = Exploration.model_validate(
        {
            "axes": axes,
            "when": when or {},
            "conditions": conditions or {},
            "objectives": list(objectives),
            "constraints": [constraint_of(each) for each in constraints],
        }
    )
    return _with_section(workload, section)


AXES = {
    "relax.iterations": [2, 4],
    "fpga.part": ["XC2V6000-4", "XC4VLX160-12"],
    "fpga.clock": [MHZ(mhz) for mhz in range(60, 150, 15)],
    "pci.clock": [MHZ(mhz) for mhz in (66, 50, 33, 10)],
    "pci.setup_cycles": [2, 8, 20],
}
