"""The platform that each shipped workload was made for."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import yaml

from codesign.inputs.files import data_folder

PLATFORMS = {
    "labyrinth": "virtex4-pci",
    "million": "virtex4-pci",
    "breadth-first": "virtex2pro",
    "breadth-first-java": "pentium4-java",
    "breadth-first-large": "virtex2pro",
    "breadth-first-external": "virtex2pro-dimm",
    "wavefront-rooms": "wavefront-array",
    "wavefront-tiles": "virtex4-pci",
    "floor-plan": "pc-3400mhz",
    "floor-plan-mam": "pc-3400mhz",
    "office-relaxation": "pc-3400mhz",
    "office-harmonic": "zynq",
    "office-breadth-first": "arty-a7",
    "office-wavefront": "virtex4-pci",
    "office-partition": "zynq",
    "warehouse": "virtex2pro",
    "robots-2": "nexys2",
    "robots-4": "nexys2",
    "robots-8": "nexys2",
    "robots-4-fleet": "nexys2-serial",
    "robots-8-fleet": "nexys2-serial",
    "robots-64": "nexys2-serial",
}
"""By workload; ``test_shipped`` holds that none is missing."""

# The quickest is first: it alone is driven to its end in the fast run.
MISSIONS = tuple(name for name in PLATFORMS if name.startswith(("office", "warehouse")))
SHORT = ("--set", "workload.scenario.limit=15 s")


def short_study(workload: str, folder: Path) -> Path | None:
    """A file of a workload whose exploration is short: two values of its first axis, and one of each other.

    None where there is nothing to explore.
    """
    source: dict[str, Any] = yaml.safe_load((data_folder("workloads") / f"{workload}.yaml").read_text(encoding="utf-8"))
    if "explore" not in source:
        return None
    axes = source["explore"]["axes"]
    source["explore"]["axes"] = {
        axis: values[: 2 if index == 0 else 1] if isinstance(values, list) else [values["from"]]
        for index, (axis, values) in enumerate(axes.items())
    }
    conditions = source["explore"].get("conditions", {})
    source["explore"]["conditions"] = {axis: values[:1] for axis, values in conditions.items()}
    if source["scenario"]["type"] == "drive":
        source["scenario"]["limit"] = "15 s"
    if "file" in source["problem"].get("map", {}):
        drawn = data_folder("workloads") / source["problem"]["map"]["file"]
        source["problem"]["map"]["file"] = drawn.name
        for part in drawn.parent.glob(f"{drawn.stem}.*"):
            shutil.copy(part, folder)
    file = folder / f"{workload}-short.yaml"
    file.write_text(yaml.safe_dump(source), encoding="utf-8")
    return file
