"""A workload with variants that is right, for tests that put a mistake in."""

from __future__ import annotations

from pathlib import Path

import pytest
from spec_texts import PLATFORM, TASKS, WORKLOAD, Decide

from codesign.ground.errors import SpecError
from codesign.ground.models import TaskParameters
from codesign.inputs import Platform, Workload, cross_check, load_platform, load_workload
from codesign.inputs.workload import TaskModels
from codesign.inputs.yaml_tree import parse_document


class Search(TaskParameters):
    depth: int = 1


class Elsewhere(TaskParameters):
    robots: int


ALL_TASKS: TaskModels = {**TASKS, "search": {"find": Search, "decide": Decide}, "crowd": {"steer": Search}}
PROBLEMS = {"crowd": Elsewhere}

DRIVE = """\
scenario:
  type: drive
  control_period: 50 ms
  replan: {policy: restart, trigger: change}
"""
VARIANTS = """\
variants:
  on-host:
    description: the host searches
    planner: search
    mapping:
      find: {component: host, depth: 3}
  coarse:
    mapping:
      relax: {component: fpga, block: [10, 10], iterations: 2, schedule: [7]}
      sense: {component: host}
  patient:
    scenario: {replan: {policy: continue}}
"""
WITH = WORKLOAD.replace("explore:\n", f"{DRIVE}{VARIANTS}explore:\n").replace(
    "    relax.block: [[20, 30], [10, 15]]\n    relax.schedule.last: [63, 127]\n", ""
)
VARIANT_AXIS = "  axes:\n    workload.variant: [base, coarse]\n"


def load(folder: Path, *changes: tuple[str, str], text: str = WITH) -> tuple[Platform, Workload]:
    platform = PLATFORM
    for old, new in changes:
        assert old in platform + text, old
        platform, text = platform.replace(old, new), text.replace(old, new)
    (folder / "p.yaml").write_text(platform)
    (folder / "w.yaml").write_text(text)
    return load_platform(folder / "p.yaml"), load_workload(folder / "w.yaml", ALL_TASKS, PROBLEMS)


def faults(folder: Path, *changes: tuple[str, str], text: str = WITH) -> str:
    with pytest.raises(SpecError) as caught:
        cross_check(*load(folder, *changes, text=text))
    return str(caught.value).replace(f"{folder}/", "")


TREE = parse_document(
    WITH.replace(
        "  axes:\n",
        "  axes:\n    workload.variant: [base, coarse]\n    relax.iterations: [1, 6]\n    pci.clock: [33 MHz]\n"
        "    workload.scenario.control_period: [50 ms, 70 ms]\n",
    ).encode(),
    "w",
    Path(),
).tree
