"""Reports with a hierarchy are held against each line of the demand; those of a task alone against its own laws."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from fpga_reports import SAMPLES, Run, nextpnr

from codesign.hardware.calibrate.design import DesignPoint, design_point
from codesign.hardware.calibrate.fpga import REST, Comparison, compare_reports
from codesign.inputs import load_platform
from codesign.inputs.library import CALIBRATIONS
from codesign.system import catalog

ALONE = """\
kind: workload
name: alone
planner: harmonic
problem:
  map: {generate: rooms, rows: 16, columns: 20, room: [7, 9], door: 2, seed: 1}
  goals: [[2, 2]]
mapping:
  relax: {component: host, style: software, blocks: [1, 1], iterations: 50, schedule: [31]}
  decide: {component: fpga}
"""


@pytest.fixture(scope="module")
def point() -> DesignPoint:
    """An array of harmonic control on an Artix-7."""
    settings = {"relax.block": [8, 12], "relax.schedule": [15, 31], "fpga.part": "XC7A100T-1"}
    workload = catalog.load_workload("labyrinth")
    return design_point(load_platform("arty-a7-100t"), workload, settings, "array")


def hierarchy(point: DesignPoint, folder: Path, top: str = "", border: str = "harmonic_border_7") -> Path:
    """A report of Vivado by hierarchy: nodes in an array with LUT of its own, and borders with two memories."""
    text = (SAMPLES / "vivado_hierarchy.rpt").read_text(encoding="utf-8")
    text = text.replace("hwsw_00112233aabb", top or str(point.top))
    begin, end = text.index("| hwsw_" if not top else f"| {top}"), text.rindex("+---")
    rows = [
        (1, str(point.top), "(top)", 2000, 1200, 0, 6),
        (3, f"({point.top})", "(top)", 3, 4, 0, 0),
        (3, "circuit", "harmonic_array", 1997, 1196, 0, 6),
        (5, "(circuit)", "harmonic_array", 90, 40, 0, 0),
        (5, "node_0", "harmonic_node", 900, 500, 0, 0),
        (5, "node_1", "harmonic_node__parameterized0_12", 907, 500, 0, 0),
        (5, "border", border, 100, 156, 0, 6),
        (7, "(border)", border, 60, 116, 0, 0),
        (7, "words", "ram_1w1r__parameterized2", 40, 40, 0, 6),
    ]
    lines = [
        "|" + " " * indent + f"{name} | {module} | {lut} | {lut} | 0 | 0 | {ff} | {ram36} | {ram18} | 0 |"
        for indent, name, module, lut, ff, ram36, ram18 in rows
    ]
    path = folder / "hierarchy.rpt"
    path.write_text(text[:begin] + "\n".join(lines) + "\n" + text[end:], encoding="utf-8")
    return path


def by_line(comparison: Comparison) -> dict[tuple[str, str], float]:
    """What was reported of each line and resource."""
    return {(each.line, each.term): each.reported for each in comparison.lines}


def test_each_line_is_held_against_its_modules(point: DesignPoint, tmp_path: Path) -> None:
    assert point.circuit is not None
    line_of = {module: line for line, modules in point.circuit.pieces.items() for module in modules}
    array, node, border = (line_of[f"harmonic_{name}"] for name in ("array", "node", "border"))
    comparison = compare_reports([hierarchy(point, tmp_path)], point)
    reported = by_line(comparison)
    assert reported[node, "lut4"] == 900 + 907
    assert reported[array, "lut4"] == 90
    # The memory stands in a line of its own, or else with the module around it.
    memory = line_of.get("ram_1w1r", border)
    assert reported[memory, "block_rams"] == 6
    assert reported[border, "lut4"] == 60 + (40 if memory == border else 0)
    assert reported[REST, "lut4"] == 3
    assert sum(value for (_, term), value in reported.items() if term == "lut4") == 2000
    for resource in ("lut4", "flip_flops", "block_rams"):
        predicted = sum(each.predicted.value for each in comparison.lines if each.term == resource)
        assert predicted == point.demand.total(resource), "no line of the law is missing"


def test_lines_cite_their_own_rows(point: DesignPoint, tmp_path: Path) -> None:
    path = hierarchy(point, tmp_path)
    (row,) = (each for each in compare_reports([path], point).lines if (each.line, each.term) == (REST, "lut4"))
    assert path.read_text(encoding="utf-8").splitlines()[int(row.report.rpartition(":")[2]) - 1].startswith("|   (")


def test_a_design_that_is_not_recognised_has_no_lines(point: DesignPoint, tmp_path: Path) -> None:
    comparison = compare_reports([hierarchy(point, tmp_path, top="my_top")], point)
    assert comparison.lines == ()
    assert [each.term for each in comparison.rows if each.term == "lut4"] == ["lut4"]


def test_the_command_shows_the_lines(point: DesignPoint, tmp_path: Path, hwsw: Run) -> None:
    path = hierarchy(point, tmp_path)
    settings = ("relax.block=[8, 12]", "relax.schedule=[15, 31]", "fpga.part=XC7A100T-1")
    words = [word for setting in settings for word in ("--set", setting)]
    arguments = ("calibrate", "fpga", "arty-a7-100t", "labyrinth", *words, "--report", path)
    done = hwsw(*arguments)
    assert done.exit_code == 0, done.output
    assert "Lines of the demand" in done.stdout
    assert REST in done.stdout
    document = json.loads(hwsw(*arguments, "--json").stdout)
    assert {row["line"] for row in document["lines"]} >= {REST}


def alone(folder: Path, hwsw: Run) -> tuple[Path, dict[str, Any]]:
    """The exported decision module, and its manifest."""
    (folder / "alone.yaml").write_text(ALONE, encoding="utf-8")
    done = hwsw("rtl", "ulx3s-85f", folder / "alone.yaml", "-o", folder / "design")
    assert done.exit_code == 0, done.output
    return folder / "design", json.loads((folder / "design" / "manifest.json").read_text(encoding="utf-8"))


def test_a_report_of_a_task_alone_calibrates_that_task(
    tmp_path: Path, hwsw: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    design, manifest = alone(tmp_path, hwsw)
    assert manifest["task"] == "decide"
    counts = {"TRELLIS_COMB": 700, "TRELLIS_FF": 200, "DP16KD": 3}
    report = nextpnr(design, fmax=120.0, **counts)
    (tmp_path / "calibrations").mkdir()
    done = hwsw("calibrate", "fpga", "--report", report, "-o", "calibrations/alone.yaml", "--json")
    assert done.exit_code == 0, done.output
    rows = {row["term"]: row for row in json.loads(done.stdout)["rows"]}
    assert rows["lut4"]["design"] == manifest["top"]
    assert rows["lut4"]["reported"] == 700
    calibration = CALIBRATIONS.load(tmp_path / "calibrations" / "alone.yaml")
    assert (calibration.planner, calibration.task) == ("harmonic", "decide")
    done = hwsw("run", "ulx3s-85f", "alone.yaml", "--set", "fpga.calibration=alone", "--json")
    assert done.exit_code == 0, done.output
    demands = {use["resource"]: use["demand"] for use in json.loads(done.stdout)["resources"]}
    assert demands["lut4"] == 700
