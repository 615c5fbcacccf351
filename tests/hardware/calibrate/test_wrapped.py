"""Reports of more than the design: a wrapper around it, a factor without a reason, a clock before routing, units."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from fpga_reports import DESIGN, SAMPLES, Run, nextpnr

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, Status
from codesign.hardware.calibrate.calibration import Compared
from codesign.hardware.calibrate.design import DesignPoint, design_point
from codesign.hardware.calibrate.fpga import Comparison, compare_reports
from codesign.hardware.calibrate.reports import read_report
from codesign.hardware.calibrate.reports.engine import Stage
from codesign.inputs import load_platform
from codesign.inputs.library import CALIBRATIONS, CLOCK, DYNAMIC, STATIC
from codesign.system import catalog
from codesign.views.report.hardware_tables import calibration_tables

SETTINGS = {"fpga.part": "XC7A100T-1", "search.display": "none"}


@pytest.fixture(scope="module")
def point() -> DesignPoint:
    """A search engine on an Artix-7."""
    workload = catalog.load_workload("breadth-first")
    return design_point(load_platform("arty-a7-100t"), workload, SETTINGS, "engine")


def wrapped(folder: Path, *designs: str) -> Path:
    """A report of Vivado by hierarchy: a video core and these designs, of 214 LUT in two modules each, in a wrapper."""
    text = (SAMPLES / "vivado_hierarchy.rpt").read_text(encoding="utf-8")
    begin, end = text.index("| hwsw_"), text.rindex("+---")
    rows = [
        (1, "board", "(top)", 1000 + 214 * len(designs), 900 + 100 * len(designs), 1 + 18 * len(designs)),
        (3, "(board)", "(top)", 40, 60, 0),
        (3, "video", "video_core", 960, 840, 1),
    ]
    for index, name in enumerate(designs):
        rows += [
            (3, f"engine_{index}", name, 214, 100, 18),
            (5, "(engine)", name, 14, 10, 0),
            (5, "circuit", "breadth_first_top", 200, 90, 18),
        ]
    lines = [
        f"|{' ' * indent}{name} | {module} | {lut} | {lut} | 0 | 0 | {ff} | 0 | {ram} | 0 |"
        for indent, name, module, lut, ff, ram in rows
    ]
    text = text[:begin] + "\n".join(lines) + "\n" + text[end:]
    path = folder / "utilization.rpt"
    path.write_text(text.replace("hwsw_00112233aabb", "board"), encoding="utf-8")
    return path


def counts(comparison: Comparison) -> dict[str, float]:
    return {row.term: row.reported for row in comparison.rows}


@pytest.mark.parametrize("copied", ["", "_0"])
def test_a_design_in_a_wrapper_is_counted_alone(point: DesignPoint, tmp_path: Path, copied: str) -> None:
    compared = compare_reports([wrapped(tmp_path, f"{point.top}{copied}")], point)
    reported = counts(compared)
    assert (reported["lut4"], reported["flip_flops"], reported["block_rams"]) == (214, 100, 18)
    assert any(f"module {point.top}, inside of board" in note for note in compared.notes)
    assert not any("has no digest" in note for note in compared.notes)
    assert sum(each.reported for each in compared.lines if each.term == "lut4") == 214


def test_two_designs_in_a_wrapper_are_refused(point: DesignPoint, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has 2 copies"):
        compare_reports([wrapped(tmp_path, str(point.top), f"{point.top}_1")], point)


def test_a_wrapper_without_the_design_needs_a_reason(point: DesignPoint, tmp_path: Path) -> None:
    path = wrapped(tmp_path, "another_engine")
    with pytest.raises(InputError, match="times what the law says") as refused:
        compare_reports([path], point)
    assert "--explain " in str(refused.value)
    reasons = dict.fromkeys(("lut4", "flip_flops"), "the whole board")
    compared = compare_reports([path], point, explained=reasons)
    assert compared.calibration is not None
    assert compared.calibration.terms["lut4"].explained == "the whole board"
    assert any("has no digest" in note for note in compared.notes)


def test_a_reason_is_kept_in_the_file_and_a_file_without_one_is_refused(
    tmp_path: Path, hwsw: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    report = nextpnr(tmp_path, TRELLIS_COMB=900)
    command = ("calibrate", "fpga", *DESIGN, "--report", report, "-o", "mine.yaml")
    assert hwsw(*command).exit_code == 2
    assert not (tmp_path / "mine.yaml").exists()
    assert hwsw(*command, "--explain", "lut4=").exit_code == 2
    assert hwsw(*command, "--explain", "luts=x").exit_code == 2
    done = hwsw(*command, "--explain", "lut4=a debug core")
    assert done.exit_code == 0, done.output
    path = tmp_path / "mine.yaml"
    assert CALIBRATIONS.load(path).terms["lut4"].explained == "a debug core"
    path.write_text(re.sub(r" *explained: .*\n", "", path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(Exception, match="are not explained"):
        CALIBRATIONS.load(path)


TIMING = (SAMPLES / "vivado_timing.rpt").read_text(encoding="utf-8")
NET = "                         net (fo=5, {})           0.814     1.270    circuit/state\n"


@pytest.mark.parametrize(
    ("file", "state", "nets", "stage"),
    [
        ("x_timing_summary_routed.rpt", "", (), Stage.ROUTED),
        ("x_timing_summary_postroute_physopted.rpt", "", (), Stage.ROUTED),
        ("x_timing_summary_synth.rpt", "", (), Stage.SYNTHESISED),
        ("x_timing_summary_placed.rpt", "", (), Stage.PLACED),
        ("timing.rpt", "", (), Stage.PLACED),
        ("timing.rpt", "Routed", (), Stage.ROUTED),
        ("timing.rpt", "Synthesized", ("unplaced",), Stage.SYNTHESISED),
        ("timing.rpt", "", ("routed", "routed"), Stage.ROUTED),
        ("timing.rpt", "", ("unplaced",), Stage.SYNTHESISED),
        ("timing.rpt", "", ("estimated", "routed"), Stage.PLACED),
        ("x_timing_summary_routed.rpt", "", ("unplaced",), Stage.SYNTHESISED),
    ],
)
def test_a_timing_summary_is_of_the_stage_that_it_shows(
    tmp_path: Path, file: str, state: str, nets: tuple[str, ...], stage: Stage
) -> None:
    text = TIMING.replace("top_timing_summary_routed.rpt", file) + "".join(NET.format(net) for net in nets)
    if state:
        text = text.replace("| Speed File", f"| Design State : {state}\n| Speed File")
    (tmp_path / "timing.rpt").write_text(text, encoding="utf-8")
    assert read_report(tmp_path / "timing.rpt").stage == stage


def test_the_clock_of_a_design_that_is_not_routed_is_left_out(tmp_path: Path, point: DesignPoint) -> None:
    for file, expected in (("x_synth.rpt", False), ("timing.rpt", False), ("x_routed.rpt", True)):
        text = TIMING.replace("top_timing_summary_routed.rpt", file).replace("hwsw_00112233aabb", str(point.top))
        (tmp_path / "timing.rpt").write_text(text, encoding="utf-8")
        compared = compare_reports([tmp_path / "timing.rpt"], point)
        assert (CLOCK in counts(compared)) is expected
        assert any("its clock" in note for note in compared.notes) is not expected


@pytest.mark.parametrize("watts", [1e-4, 0.0021, 0.0971, 0.455, 12.5])
@pytest.mark.parametrize("term", [STATIC, DYNAMIC])
def test_a_table_says_the_power_that_was_reported(watts: float, term: str) -> None:
    law = Figure(2 * watts, "W", Status.CALIBRATED, "law")
    row = Compared(term, "engine", law, watts, "report:1")
    (table,) = calibration_tables(Comparison((row,), (), {}, None, ()))
    (cells,) = table.rows
    texts = [cell.text for cell in cells if cell.text.endswith((" mW", " W"))]
    for text, value in zip(texts, (2 * watts, watts), strict=True):
        number, unit = text.replace(",", "").split()
        assert float(number) * {"mW": 1e-3, "W": 1.0}[unit] == pytest.approx(value, abs=5.1e-5)


def test_the_document_has_the_offset_and_the_reason(hwsw: Run, tmp_path: Path) -> None:
    report = nextpnr(tmp_path, TRELLIS_COMB=900)
    arguments = ("calibrate", "fpga", *DESIGN, "--report", report, "--json", "--explain", "lut4=a debug core")
    term = json.loads(hwsw(*arguments).stdout)["calibration"]["terms"]["lut4"]
    assert (term["offset"], term["explained"]) == (0.0, "a debug core")


def test_an_offset_moves_a_small_design_more_than_a_large_one() -> None:
    from codesign.hardware.calibrate.calibration import fitted_term
    from codesign.inputs.library import Sample

    samples = [
        Sample(design=str(size), predicted=size, reported=size + 200, report="r") for size in (400, 800, 1600, 3200)
    ]
    term = fitted_term("lut4", samples, (0.9, 1.1))
    assert [round(size * term.at(size)[0]) for size in (500, 6400)] == [700, 6600]


def test_the_timing_of_a_mapped_design_is_no_routed_one_in_ise_and_quartus(tmp_path: Path) -> None:
    mapped = (SAMPLES / "ise.twr").read_text(encoding="utf-8")
    assert read_report(SAMPLES / "ise.twr").stage == Stage.ROUTED
    (tmp_path / "ise.twr").write_text(re.sub(r"(\w+)\.ncd", r"\1_map.ncd", mapped), encoding="utf-8")
    assert read_report(tmp_path / "ise.twr").stage == Stage.SYNTHESISED
    timing = (SAMPLES / "quartus.sta.rpt").read_text(encoding="utf-8")
    assert read_report(SAMPLES / "quartus.sta.rpt").stage == Stage.ROUTED
    for word, stage in (("synthesized", Stage.SYNTHESISED), ("placed", Stage.PLACED), ("final", Stage.ROUTED)):
        (tmp_path / "q.sta.rpt").write_text(f"{timing}\n; Snapshot ; {word} ;\n", encoding="utf-8")
        assert read_report(tmp_path / "q.sta.rpt").stage == stage
