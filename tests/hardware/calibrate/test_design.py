"""The design that a report is of: recognised by its manifest, its top and its part."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from fpga_reports import SAMPLES, Run

from codesign.hardware.calibrate.design import names_part
from codesign.inputs import load_part


def test_a_design_is_recognised_by_its_manifest(tmp_path: Path, hwsw: Run) -> None:
    from codesign.hardware.calibrate.design import design_point
    from codesign.inputs import load_platform
    from codesign.system import catalog

    top = design_point(load_platform("ulx3s-85f"), catalog.load_workload("robots-2"), {}, "").top
    assert top is not None
    manifest = {"top": top, "task": "", "platform": "ulx3s-85f", "workload": "robots-2", "settings": {}, "study": None}
    (tmp_path / "build" / "impl").mkdir(parents=True)
    (tmp_path / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    path = tmp_path / "build" / "impl" / "map.mrp"
    text = (SAMPLES / "diamond.mrp").read_text(encoding="utf-8").replace("hwsw_00112233aabb", top)
    path.write_text(
        text.replace("60000", " 6000").replace("31000", " 5000").replace("34000", " 4000"), encoding="utf-8"
    )
    text = path.read_text(encoding="utf-8").replace("144 out", "  2 out")
    path.write_text(text, encoding="utf-8")
    reasons = [
        word for term in ("flip_flops", "slices", "lut4", "multipliers") for word in ("--explain", f"{term}=a test")
    ]
    done = hwsw("calibrate", "fpga", "--report", path, *reasons, "--json")
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    assert {row["design"] for row in document["rows"]} == {top}
    assert document["notes"] == []
    assert document["calibration"]["planner"] == "velocity_obstacle"
    manifest["top"] = "hwsw_ffffffffffff"
    (tmp_path / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    done = hwsw("calibrate", "fpga", "--report", path)
    assert done.exit_code == 2
    assert f"the design point now makes {top}, and the manifest has hwsw_ffffffffffff" in done.stderr
    (tmp_path / "manifest.json").write_text('{"top": 1', encoding="utf-8")
    done = hwsw("calibrate", "fpga", "--report", path)
    assert "manifest.json:1:1: is no JSON" in done.stderr


@pytest.mark.parametrize(
    ("written", "part", "same"),
    [
        ("7a100t-csg324-1", "XC7A100T-1", True),
        ("xc7a100tcsg324-1", "XC7A100T-1", True),
        ("xc7a100tcsg324-2", "XC7A100T-1", False),
        ("xc4vlx160ff1148-12", "XC4VLX160-12", True),
        ("3s500efg320-4", "XC3S500E-4", True),
        ("LFE5U-85FCABGA381-6", "LFE5U-85F-6", True),
        ("LFE5U-85F-8", "LFE5U-85F-6", False),
        ("LFE5U-25F-6", "LFE5U-85F-6", False),
        ("GW2A-LV18PG256C8/I7", "GW2A-18-8", True),
        ("GW1NR-LV9QN88PC6/I5", "GW2A-18-8", False),
        ("iCE40UP5K", "LFE5U-85F-6", False),
    ],
)
def test_parts_as_tools_write_them(written: str, part: str, same: bool) -> None:
    assert names_part(written, load_part(part)) is same
