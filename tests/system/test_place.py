"""The processor in the chip is a place like any other: each planner split between it and the fabric, either way."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from click.testing import Result
from places import ROOT
from small_maps import Specs, put_map

from codesign.inputs import load_platform
from codesign.inputs.components import ProcessorComponent
from codesign.planners.harmonic.styles.resources import Machine, totals
from codesign.system.scenarios import check_files

Run = Callable[..., Result]

ZYNQ = ROOT / "platforms" / "zynq.yaml"

CHIPS = {"zynq": ("arm", "axi"), "virtex2pro": ("powerpc", "plb")}
"""Platforms with a processor in the FPGA's own chip: its name, and that of the link between them."""

RELAX = "block: [12, 16], iterations: 6, schedule: [15, 31]"
SPLITS = {
    "harmonic": (
        f"relax: {{component: fpga, {RELAX}}}",
        f"relax: {{component: PROCESSOR, style: software, {RELAX}}}",
        "decide",
    ),
    "breadth_first": ("search: {component: fpga}", "search: {component: PROCESSOR, style: software}", "track"),
    "wavefront": (
        "propagate: {component: fpga, style: tiled, tile: [8, 8]}",
        "propagate: {component: PROCESSOR, style: software}",
        "track",
    ),
}
"""The planning task in the fabric and on the processor, and the task that answers."""

SPARED = {
    ("zynq", "harmonic"): 109,
    ("virtex2pro", "harmonic"): 116,
    ("zynq", "wavefront"): 69,
    ("virtex2pro", "wavefront"): 79,
}
"""Slices of the fabric that a design leaves free where the processor answers."""

SENT = {"harmonic": "field", "breadth_first": "directions", "wavefront": "potentials"}

WORKLOAD = """\
kind: workload
name: rooms
planner: {planner}
problem:
  map: {{generate: rooms, rows: 24, columns: 32, room: [11, 15], door: 3, seed: 5}}
  goals: [[2, 2]]
  starts: [[20, 28]]
mapping:
  {planning}
  {answering}: {{component: {place}}}
"""


def told(hwsw: Run, folder: Path, chip: str, planner: str, *, planning: str, answering: str) -> dict[str, Any]:
    """The JSON of a run with the two tasks on ``fpga`` or ``processor``."""
    processor = CHIPS[chip][0]
    in_fabric, in_software, task = SPLITS[planner]
    text = WORKLOAD.format(
        planner=planner,
        planning=(in_fabric if planning == "fpga" else in_software).replace("PROCESSOR", processor),
        answering=task,
        place="fpga" if answering == "fpga" else processor,
    )
    file = folder / "rooms.yaml"
    file.write_text(text, encoding="utf-8")
    result = hwsw("run", chip, file, "--json")
    assert result.exit_code == 0, result.output
    found: dict[str, Any] = json.loads(result.stdout)
    return found


@pytest.mark.parametrize("chip", CHIPS)
@pytest.mark.parametrize("planner", SPLITS)
def test_fabric_plans_and_the_processor_answers(hwsw: Run, tmp_path: Path, chip: str, planner: str) -> None:
    processor, link = CHIPS[chip]
    whole = told(hwsw, tmp_path, chip, planner, planning="fpga", answering="fpga")
    split = told(hwsw, tmp_path, chip, planner, planning="fpga", answering="processor")
    assert whole["feasible"]
    assert split["feasible"]
    assert split["places"][SPLITS[planner][2]] == processor
    # The answer is the same; what it is made of has crossed the link, and one phase is done elsewhere.
    assert split["quality"] == whole["quality"]
    assert split["quality"]["starts_arrived"] == 1
    assert split["links"][link]["bits"] > whole["links"][link]["bits"] + 24 * 32
    assert len(set(whole["cycles"]) - set(split["cycles"])) == 1
    assert split["time"]["planned_s"] < split["time"]["first_plan_s"]
    used = [{use["resource"]: use["demand"] for use in each["resources"]} for each in (whole, split)]
    # No paper has the slices of these families: the answering task and what it takes of control, as synthesis counts.
    spared = SPARED.get((chip, planner), 0)
    assert used[0]["slices"] - used[1]["slices"] == spared
    if planner == "harmonic":
        family = load_platform(chip).components["fpga"].chip.family  # type: ignore[union-attr]
        laws = [totals(Machine(12, 16, 31, inside, 2, 2, stages=2), family) for inside in (True, False)]
        assert [each["slices"] for each in used] == [each["slices"] for each in laws]


@pytest.mark.parametrize("planning", ["fpga", "processor"])
def test_the_field_is_sent_at_the_precision_that_the_plan_came_to(
    hwsw: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, planning: str
) -> None:
    longer = tuple(text.replace("[15, 31]", "[15, 31, 47, 63]") for text in SPLITS["harmonic"][:2])
    monkeypatch.setitem(SPLITS, "harmonic", (*longer, "decide"))
    answering = "processor" if planning == "fpga" else "fpga"
    found = told(hwsw, tmp_path, "zynq", "harmonic", planning=planning, answering=answering)
    reached = found["stages"][-1]["precision"]
    assert reached < 63
    # A map to the fabric and a field from it, or a field to it and a direction back.
    beside = 2 * 24 * 32 if planning == "fpga" else 64
    assert found["links"]["axi"]["bits"] == beside + 24 * 32 * (reached + 1)


@pytest.mark.parametrize("chip", CHIPS)
@pytest.mark.parametrize("planner", SPLITS)
def test_the_processor_plans_and_fabric_answers(hwsw: Run, tmp_path: Path, chip: str, planner: str) -> None:
    processor, link = CHIPS[chip]
    alone = told(hwsw, tmp_path, chip, planner, planning="processor", answering="processor")
    split = told(hwsw, tmp_path, chip, planner, planning="processor", answering="fpga")
    assert split["feasible"]
    assert split["component"] == processor
    assert split["places"][SPLITS[planner][2]] == "fpga"
    assert split["quality"] == alone["quality"]
    assert alone["links"][link]["sent"] == 0
    assert split["links"][link]["sent"] == 2
    assert not alone["resources"]
    used = {use["resource"]: use["demand"] for use in split["resources"]}
    assert used["slices"] > 0
    assert used["block_rams"] > 0
    assert split["utilisation"]["fpga"] > 0 == alone["utilisation"]["fpga"]


def test_relaxation_in_doubles_is_for_a_processor_that_has_its_cost(hwsw: Run, tmp_path: Path) -> None:
    file = tmp_path / "rooms.yaml"
    base = WORKLOAD.format(
        planner="relaxation",
        planning="relax: {component: PROCESSOR, method: sor, omega: 1.8}",
        answering="search",
        place="PROCESSOR",
    )
    file.write_text(base.replace("PROCESSOR", "arm"), encoding="utf-8")
    result = hwsw("run", "zynq", file, "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["quality"]["starts_arrived"] == 1
    file.write_text(base.replace("PROCESSOR", "powerpc"), encoding="utf-8")
    refused = hwsw("run", "virtex2pro", file)
    assert refused.exit_code == 2
    assert "powerpc has no cost of kernels relaxation_node_update, relaxation_map_cell" in refused.output
    file.write_text(base.replace("PROCESSOR", "fpga"), encoding="utf-8")
    refused = hwsw("run", "zynq", file)
    assert refused.exit_code == 2
    told = " ".join(refused.output.split())
    assert "mapping.relax.component: task relax is on fpga, which is an fpga: relaxation has no style" in told
    assert "hint: place it on a component of type processor" in told


def without_cost(folder: Path, kernel: str) -> Path:
    """The zynq with a host of its own, which has no cost of a kernel."""
    platform = yaml.safe_load(ZYNQ.read_text(encoding="utf-8"))
    arm = load_platform(ZYNQ).components["arm"]
    assert isinstance(arm, ProcessorComponent)
    costs = {name: f"{cost.value} ps" for name, cost in arm.costs.items() if name != kernel}
    power = {"busy": "1.3 W", "idle": "0.8 W"}
    platform["components"]["arm"] = {"type": "processor", "clock": "667 MHz", "costs": costs, "power": power}
    file = folder / "poor.yaml"
    file.write_text(yaml.safe_dump(platform), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("planner", "planning", "kernel", "user"),
    [
        ("harmonic", "fpga", "harmonic_decision", "task decide"),
        ("harmonic", "processor", "harmonic_node_update", "style software"),
        ("breadth_first", "fpga", "breadth_first_cell", "task track"),
        ("breadth_first", "processor", "breadth_first_cell", "style software"),
        ("wavefront", "fpga", "wavefront_cell", "task track"),
        ("wavefront", "processor", "wavefront_cell", "style software"),
    ],
)
def test_a_cost_that_is_missing_is_named(
    hwsw: Run, tmp_path: Path, planner: str, planning: str, kernel: str, user: str
) -> None:
    poor = without_cost(tmp_path, kernel)
    in_fabric, in_software, task = SPLITS[planner]
    file = tmp_path / "rooms.yaml"
    file.write_text(
        WORKLOAD.format(
            planner=planner,
            planning=in_fabric if planning == "fpga" else in_software.replace("PROCESSOR", "arm"),
            answering=task,
            place="arm",
        ),
        encoding="utf-8",
    )
    refused = hwsw("run", poor, file)
    assert refused.exit_code == 2
    assert f"arm has no cost of kernel {kernel}, which {user} is counted in" in refused.output.replace("\n", " ")
    assert f"add {kernel}: TIME" in refused.output


def test_a_cost_that_only_the_method_needs_is_named_beforehand(hwsw: Run, tmp_path: Path) -> None:
    poor, file = without_cost(tmp_path, "relaxation_direct_cell"), tmp_path / "rooms.yaml"

    def write(method: str) -> None:
        planning = f"relax: {{component: arm, method: {method}}}"
        text = WORKLOAD.format(planner="relaxation", planning=planning, answering="search", place="arm")
        file.write_text(text, encoding="utf-8")

    write("direct")
    for command in ("check", "run"):
        refused = hwsw(command, poor, file)
        assert refused.exit_code == 2, refused.output
        said = refused.output.replace("\n", " ")
        assert "arm has no cost of kernel relaxation_direct_cell, which style sequential is counted in" in said
    write("jacobi")
    assert hwsw("check", poor, file).exit_code == 0


def test_what_a_platform_lacks_for_a_workload_is_told_by_check(specs: Specs) -> None:
    put_map(specs)
    platform = specs[0].read_text(encoding="utf-8")
    specs[0].write_text(platform.partition("links:")[0], encoding="utf-8")
    (fault,) = check_files(specs)
    assert fault.file == str(specs[0])
    assert "no link joins host" in fault.what
    assert "between: [host, fpga]" in str(fault.hint)
    specs[0].write_text(platform.replace("costs: {harmonic_node_update: 40 ns}, ", ""), encoding="utf-8")
    text = specs[1].read_text(encoding="utf-8").replace("component: fpga", "component: host")
    specs[1].write_text(text, encoding="utf-8")
    (fault,) = check_files(specs)
    assert fault.line == 5
    assert "harmonic_node_update" in str(fault.hint)
