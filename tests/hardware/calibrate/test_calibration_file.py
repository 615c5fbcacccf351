"""A calibration in a platform: its figures, as an axis, of another style, and against physics."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from fpga_reports import DESIGN, Run, codesign_folder, nextpnr

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.figures import Status
from codesign.inputs.library import CALIBRATIONS


def test_a_result_with_a_calibration_says_what_the_tool_reported(calibrated: Path) -> None:
    platform = yaml.safe_load((codesign_folder() / "ulx3s-85f.yaml").read_text(encoding="utf-8"))
    before = codesign.simulate(platform, "breadth-first")
    platform["components"]["fpga"]["calibration"] = "mine"
    result = codesign.simulate(platform, "breadth-first")
    demands = {use.resource: use.demand for use in result.resources}
    assert (demands["lut4"], demands["flip_flops"], demands["block_rams"]) == (420, 180, 18)
    law = {use.resource: use.demand for use in before.resources}
    assert demands["slices"] == law["slices"], "no report says them"
    for use in result.resources:
        assert sum(int(item.figure.value) for item in use.items) == use.demand
        if use.resource == "lut4":
            assert {item.figure.status for item in use.items} == {Status.CALIBRATED}
            assert all("calibration mine" in item.figure.source for item in use.items)
            assert all("nextpnr, report.json:" in item.figure.source for item in use.items)
    assert result.clock is not None
    limit = result.clock.limit
    assert limit.value == pytest.approx(160e6)
    assert limit.status == Status.CALIBRATED
    assert limit.interval[0] < limit.value < limit.interval[1] <= 300e6
    digest = CALIBRATIONS.load(calibrated / "calibrations" / "mine.yaml").digest()
    assert result.provenance is not None
    assert result.provenance.calibration_digests == {"ulx3s-85f.fpga": digest}
    assert before.provenance is not None
    assert before.provenance.platform_digests != result.provenance.platform_digests


def test_a_calibration_is_an_axis(calibrated: Path, hwsw: Run) -> None:
    done = hwsw("run", *DESIGN, "--set", "fpga.calibration=mine", "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["resources"][1]["demand"] == 420
    done = hwsw("run", *DESIGN, "--set", "fpga.calibration=mein")
    assert done.exit_code == 2
    assert "there is no calibration 'mein'" in done.stderr
    assert "did you mean mine?" in done.stderr


def test_an_edited_calibration_is_read_again(calibrated: Path, hwsw: Run) -> None:
    nextpnr(calibrated, TRELLIS_COMB=500)
    done = hwsw("calibrate", "fpga", *DESIGN, "--report", "report.json", "-o", "calibrations/mine.yaml")
    assert done.exit_code == 0, done.output
    done = hwsw("run", *DESIGN, "--set", "fpga.calibration=mine", "--json")
    assert json.loads(done.stdout)["resources"][1]["demand"] == 500


def test_the_calibration_of_another_style_is_left_out_with_a_note(calibrated: Path) -> None:
    platform = yaml.safe_load((codesign_folder() / "ulx3s-85f.yaml").read_text(encoding="utf-8"))
    platform["components"]["fpga"]["calibration"] = "mine"
    result = codesign.simulate(platform, "robots-2")
    (note,) = (note for note in result.notes if "calibration" in note)
    assert "mine is for breadth_first" in note
    assert all("calibration mine" not in item.figure.source for use in result.resources for item in use.items)


def change(folder: Path, edit: Callable[[dict[str, Any]], None]) -> None:
    """Edit the calibration ``mine``."""
    path = folder / "calibrations" / "mine.yaml"
    tree = yaml.safe_load(path.read_text(encoding="utf-8"))
    edit(tree)
    path.write_text(yaml.safe_dump(tree, sort_keys=False), encoding="utf-8")


def _another_family(tree: dict[str, Any]) -> None:
    tree["family"] = "Virtex-4"


def _too_fast(tree: dict[str, Any]) -> None:
    term = tree["terms"]["clock"]
    term["samples"][0]["reported"] = 400e6
    term["factor"] = 400e6 / term["samples"][0]["predicted"]
    term["explained"] = "a test"


def _too_many(tree: dict[str, Any]) -> None:
    term = tree["terms"]["lut4"]
    term["samples"][0] |= {"reported": 90_000.0, "predicted": 80_000.0}
    term["factor"] = 90_000 / 80_000


def _off_its_samples(tree: dict[str, Any]) -> None:
    tree["terms"]["lut4"]["factor"]["value"] = tree["terms"]["lut4"]["factor"]["high"] = 3.5


def _negative(tree: dict[str, Any]) -> None:
    tree["terms"]["lut4"]["samples"][0]["reported"] = -1.0


@pytest.mark.parametrize(
    ("edit", "expected"),
    [
        (_another_family, "calibration mine was fitted on Virtex-4, and LFE5U-85F is a ECP5"),
        (_too_fast, "is above the 300 MHz that a block RAM of LFE5U-85F-6 reaches"),
        (_too_many, "90,000 lut4 (nextpnr, report.json:"),
        (_off_its_samples, "a factor of 3.5 is outside of its samples"),
        (_negative, "terms.lut4.samples[0].reported"),
    ],
)
def test_a_calibration_that_contradicts_physics_is_refused(
    calibrated: Path, edit: Callable[[dict[str, Any]], None], expected: str
) -> None:
    change(calibrated, edit)
    platform = (codesign_folder() / "ulx3s-85f.yaml").read_text(encoding="utf-8")
    (calibrated / "p.yaml").write_text(
        platform.replace("part: LFE5U-85F-6", "part: LFE5U-85F-6\n    calibration: mine").replace(
            "name: ulx3s-85f", "name: p"
        ),
        encoding="utf-8",
    )
    with pytest.raises(SpecError) as refused:
        codesign.load_platform("./p.yaml")
    assert expected in str(refused.value)
    assert "yaml:" in str(refused.value), "FILE:LINE:COLUMN"
