"""Every shipped workload on the platform it was made for, and the commands that look across planners."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from click.testing import Result

from codesign.inputs import list_workloads
from codesign.inputs.files import data_folder
from codesign.units import format_time

Run = Callable[..., Result]

PLATFORMS = {
    "labyrinth": "virtex4-pci",
    "breadth-first": "virtex2pro",
    "breadth-first-java": "pentium4-java",
    "breadth-first-large": "virtex2pro",
    "breadth-first-external": "virtex2pro-dimm",
    "wavefront-rooms": "wavefront-array",
    "wavefront-tiles": "virtex4-pci",
    "floor-plan": "pc-3400mhz",
    "floor-plan-mam": "pc-3400mhz",
    "office-harmonic": "zynq",
    "office-breadth-first": "arty-a7",
    "office-wavefront": "virtex4-pci",
    "office-relaxation": "pc-3400mhz",
    "office-partition": "zynq",
    "warehouse": "virtex2pro",
    "robots-2": "nexys2",
    "robots-4": "nexys2",
    "robots-8": "nexys2",
    "robots-4-fleet": "nexys2-serial",
    "robots-8-fleet": "nexys2-serial",
    "robots-64": "nexys2-serial",
}


def test_every_workload_has_its_platform() -> None:
    assert set(PLATFORMS) == set(list_workloads())


@pytest.mark.parametrize("workload", PLATFORMS)
def test_every_workload_runs_traces_and_reports(hwsw: Run, tmp_path: Path, workload: str) -> None:
    platform, trace, page = PLATFORMS[workload], tmp_path / "run.mcap", tmp_path / "run.html"
    result = hwsw("run", platform, workload, "--json", "--trace", trace, "--html", page)
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["time"]["first_plan_s"] >= told["time"]["planned_s"] > 0
    assert told["quality"] is not None
    assert told["energy"]["energy_j"] > 0
    if workload.startswith(("office", "warehouse")):
        mission = told["mission"]
        assert mission["reached"], mission["ended"]
        assert mission["replans"] > 0
        assert mission["contacts"] == 0
    shown = hwsw("trace", "show", trace, "--json", "--limit", 100_000)
    assert shown.exit_code == 0
    told_of = {json.loads(line)["what"].split()[0] for line in shown.stdout.splitlines()}
    assert {"map", "trajectory"} <= told_of
    assert page.stat().st_size > 3000


@pytest.mark.parametrize(
    "workload", [name for name in PLATFORMS if name not in ("labyrinth", "wavefront-rooms")]
)
def test_every_exploration_starts_and_ends(hwsw: Run, tmp_path: Path, workload: str) -> None:
    """With one value of each axis, so that it is quick: every axis is bound, computed and reported."""
    source = yaml.safe_load((data_folder("workloads") / f"{workload}.yaml").read_text(encoding="utf-8"))
    if "explore" not in source:
        pytest.skip("nothing to explore")
    axes = source["explore"]["axes"]
    source["explore"]["axes"] = {
        axis: values[:2] if index == 0 else values[:1] for index, (axis, values) in enumerate(axes.items())
    }
    if source["scenario"]["type"] == "drive":
        source["scenario"]["limit"] = "15 s"
    file = tmp_path / "short.yaml"
    if "file" in source["problem"].get("map", {}):
        source["problem"]["map"]["file"] = str(data_folder("workloads") / source["problem"]["map"]["file"])
    file.write_text(yaml.safe_dump(source), encoding="utf-8")
    result = hwsw(
        "explore", PLATFORMS[workload], file, "--workers", 1, "--json", "--store", tmp_path / "s.sqlite"
    )
    assert result.exit_code in (0, 3), result.output
    points = json.loads(result.stdout)["points"]
    assert len(points) == min(2, len(next(iter(axes.values()))))
    assert all(point["result"] is not None for point in points)


def test_a_map_beside_the_chip_keeps_its_memory_busy_at_a_lower_clock(hwsw: Run) -> None:
    name = PLATFORMS["breadth-first-external"]
    told = json.loads(hwsw("run", name, "breadth-first-external", "--json").stdout)
    assert told["external_memory"] == "dimm"
    assert {use["resource"]: use["demand"] for use in told["resources"]}["block_rams"] == 0
    assert told["utilisation"]["dimm"] > 0.5
    assert told["clock"]["hz"] == told["clock"]["limit"]["value"] == 100_000_000
    shown = hwsw("run", name, "breadth-first-external").stdout
    assert re.search(r"^external memory +dimm$", shown, re.MULTILINE)
    assert "external_cycles" not in shown
    assert "external_cycles" in hwsw("run", "virtex2pro", "breadth-first-large").stdout


def test_the_page_tells_what_a_memory_beside_the_chip_costs(hwsw: Run) -> None:
    page = (data_folder("workloads").parent / "docs" / "breadth_first.md").read_text(encoding="utf-8")
    lines = re.findall(r"^\| .*? \| `(virtex2pro\S*)`, (\d+) MHz \| (.*) \|$", page, re.MULTILINE)
    places = [
        {},
        {},
        *({"memory": place, "external_memory": "dimm"} for place in ("process_external", "external")),
    ]
    for (platform, clock, cells), placed in zip(lines, places, strict=True):
        keys = {"micro_architecture": "pipelined", "display": "none", **placed}
        settings = [part for key, value in keys.items() for part in ("--set", f"search.{key}={value}")]
        told = json.loads(hwsw("run", platform, "breadth-first", *settings, "--json").stdout)
        rams = {use["resource"]: use["demand"] for use in told["resources"]}["block_rams"]
        busy = told["utilisation"]["dimm"]
        figures = (
            f"{rams}",
            f"{sum(told['cycles'].values()):,}",
            format_time(round(told["time"]["first_plan_s"] * 1e12)),
            f"{told['energy']['energy_j'] * 1e3:.3g} mJ",
            f"{busy:.0%}".replace("%", " %") if busy else "",
        )
        assert told["clock"]["hz"] == int(clock) * 10**6
        assert tuple(cell.strip() for cell in f"{cells} ".split(" | ")) == figures


def test_compare_puts_designs_of_four_planners_side_by_side(hwsw: Run) -> None:
    result = hwsw("compare", "--json")
    assert result.exit_code == 0, result.output
    results = json.loads(result.stdout)
    assert {each["planner"] for each in results.values()} == {
        "harmonic",
        "wavefront",
        "breadth_first",
        "relaxation",
    }
    assert all(each["feasible"] for each in results.values())
    shortest = results["virtex4-pci:wavefront-tiles"]["quality"]["path_length_ratio_mean"]
    assert shortest < results["virtex2pro:breadth-first"]["quality"]["path_length_ratio_mean"]


def test_compare_takes_a_map_and_refuses_half_a_problem(hwsw: Run, tmp_path: Path) -> None:
    (tmp_path / "map.txt").write_text("\n".join(["." * 60] * 40) + "\n", encoding="utf-8")
    half = hwsw("compare", "virtex2pro:breadth-first", "--map", tmp_path / "map.txt")
    assert half.exit_code == 2
    assert "--goal" in half.output
    whole = hwsw(
        "compare",
        "virtex2pro:breadth-first",
        "--map",
        tmp_path / "map.txt",
        "--goal",
        "2,3",
        "--start",
        "30,50",
    )
    assert whole.exit_code == 0, whole.output
    assert hwsw("compare", "nexys2:robots-4").exit_code == 1
    assert hwsw("compare", "labyrinth").exit_code == 2


def test_a_design_that_cannot_take_the_map_does_not_end_the_comparison(hwsw: Run, tmp_path: Path) -> None:
    # Two halves that touch at a corner: only a wave that cuts corners passes.
    halves = ["." * 30 + "#" * 30] * 20 + ["#" * 30 + "." * 30] * 20
    (tmp_path / "map.txt").write_text("\n".join(halves) + "\n", encoding="utf-8")
    where = ("--map", tmp_path / "map.txt", "--goal", "2,3", "--start", "30,50")
    designs = ("virtex4-pci:labyrinth", "virtex4-pci:wavefront-tiles")
    told = hwsw("compare", *designs, *where, "--json")
    assert told.exit_code == 0, told.output
    results = json.loads(told.stdout)
    assert "no path leads from start (30, 50)" in results[designs[0]]["error"]
    assert results[designs[1]]["quality"]["starts_arrived"] == 1
    shown = hwsw("compare", *designs, *where)
    assert shown.exit_code == 0
    assert "virtex4-pci:labyrinth did not run: " in shown.stderr
    assert "in brackets: as a multiple of virtex4-pci:wavefront-tiles" in shown.stdout
    assert hwsw("compare", designs[0], *where).exit_code == 1
    assert hwsw("compare", *designs, *where, "--set", "relax.component=nowhere").exit_code == 2


def test_faults_of_the_map_given_name_the_options_that_gave_it(hwsw: Run, tmp_path: Path) -> None:
    (tmp_path / "map.txt").write_text("....\n..#.\n....\n", encoding="utf-8")

    def compare(goal: str, start: str) -> Result:
        given = ("--map", tmp_path / "map.txt", "--goal", goal, "--start", start)
        return hwsw("compare", "virtex2pro:breadth-first", "virtex4-pci:wavefront-tiles", *given)

    outside = compare("2,300", "0,0")
    assert outside.exit_code == 1
    assert "did not run: --goal: cell (2, 300) is outside of the map" in outside.stderr
    assert "did not run: --start: cell (1, 2) is on an obstacle" in compare("2,3", "1,2").stderr
    assert "--goal: -2 is out of bounds" in compare("-2,3", "0,0").stderr
    (tmp_path / "map.txt").write_text("abc\n", encoding="utf-8")
    assert "did not run: --map: " in compare("0,0", "0,1").stderr


def test_calibrate_prints_costs_that_a_platform_takes(hwsw: Run, tmp_path: Path) -> None:
    result = hwsw("calibrate", "host", "--seconds", "0.2")
    assert result.exit_code == 0, result.output
    costs = yaml.safe_load(result.stdout)["costs"]
    assert {"harmonic_node_update", "relaxation_node_update", "breadth_first_cell", "wavefront_cell"} <= set(
        costs
    )
    head = "kind: platform\nname: here\ncomponents:\n  host:\n    type: processor\n    clock: 3 GHz\n"
    indented = "".join(f"    {line}\n" for line in result.stdout.splitlines())
    (tmp_path / "here.yaml").write_text(
        f"{head}    power: {{busy: 20 W, idle: 5 W}}\n{indented}", encoding="utf-8"
    )
    assert hwsw("check", tmp_path / "here.yaml").exit_code == 0
    assert hwsw("calibrate", "host", "--seconds", "nan").exit_code == 2


def test_reproduce_runs_every_paper(hwsw: Run, tmp_path: Path) -> None:
    result = hwsw("reproduce", "--quick", "--json")
    assert result.exit_code == 0, result.output
    rows = json.loads(result.stdout)["rows"]
    for author in ("Girau", "Vacariu", "Möller", "Dubey", "Saudi"):
        assert any(row["table"].startswith(author) for row in rows), author


def test_compare_applies_each_setting_where_it_exists_and_drops_none_in_silence(hwsw: Run) -> None:
    designs = "virtex4-pci:labyrinth", "pc-3400mhz:floor-plan"
    result = hwsw("compare", *designs, "--json", "--set", "relax.omega=1.5", "--set", "relax.iterations=16")
    assert result.exit_code == 0, result.output
    harmonic, relaxation = (each["parameters"]["relax"] for each in json.loads(result.stdout).values())
    assert harmonic["iterations"] == 16
    assert "omega" not in harmonic
    assert relaxation["omega"] == 1.5
    slip = hwsw("compare", *designs, "--set", "relax.iteratoins=16")
    assert slip.exit_code == 2
    assert "--set relax.iteratoins" in slip.output
