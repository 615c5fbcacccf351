"""Reports of FPGA tools that tests write, and the calibration that follows from one."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from click.testing import Result
from places import ROOT

Run = Callable[..., Result]

SAMPLES = ROOT / "tests" / "hardware" / "calibrate" / "samples"
DESIGN = ("ulx3s-85f", "breadth-first")


def nextpnr(folder: Path, name: str = "report.json", *, fmax: float = 160.0, **counts: int) -> Path:
    """A report of nextpnr for an ECP5."""
    used = {"TRELLIS_COMB": 420, "TRELLIS_FF": 180, "DP16KD": 18, "MULT18X18D": 0} | counts
    report = {
        "critical_paths": [],
        "fmax": {"$glbnet$clk$TRELLIS_IO_IN": {"achieved": fmax, "constraint": 250.0}},
        "utilization": {kind: {"used": count, "available": 10**6} for kind, count in used.items()},
    }
    (folder / name).write_text(json.dumps(report, indent=1), encoding="utf-8")
    return folder / name


def codesign_folder() -> Path:
    """The folder of the shipped platforms."""
    from codesign.inputs.files import data_folder

    return data_folder("platforms")
