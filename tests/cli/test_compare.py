"""Designs held against each other on one map."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Run = Callable[..., Result]


def test_compare_puts_designs_of_four_planners_side_by_side(hwsw: Run) -> None:
    result = hwsw("compare", "--json")
    assert result.exit_code == 0, result.output
    results = json.loads(result.stdout)
    assert {each["planner"] for each in results.values()} == {"harmonic", "wavefront", "breadth_first", "relaxation"}
    assert all(each["feasible"] for each in results.values())
    shortest = results["virtex4-pci:wavefront-tiles"]["quality"]["path_length_ratio_mean"]
    assert shortest < results["virtex2pro:breadth-first"]["quality"]["path_length_ratio_mean"]


def test_compare_takes_a_map_and_refuses_half_a_problem(hwsw: Run, tmp_path: Path) -> None:
    (tmp_path / "map.txt").write_text("\n".join(["." * 60] * 40) + "\n", encoding="utf-8")
    half = hwsw("compare", "virtex2pro:breadth-first", "--map", tmp_path / "map.txt")
    assert half.exit_code == 2
    assert "--goal" in half.output
    whole = hwsw(
        "compare", "virtex2pro:breadth-first", "--map", tmp_path / "map.txt", "--goal", "2,3", "--start", "30,50"
    )
    assert whole.exit_code == 0, whole.output
    where = ("--map", tmp_path / "map.txt", "--goal", "2,3", "--start", "30,50")
    assert hwsw("compare", "nexys2:robots-4", *where).exit_code == 1
    assert hwsw("compare", "labyrinth").exit_code == 2


OWN = """\
kind: workload
name: own
planner: breadth_first
problem:
  map: {{generate: rooms, rows: {rows}, columns: 20, room: [5, 5], door: 2, seed: 1}}
  goals: [[2, 2]]
  starts: {{count: 2, seed: 1}}
mapping: {{search: {{component: fpga}}}}
"""


def test_each_design_plans_on_the_map_of_its_workload_unless_one_is_given(hwsw: Run, tmp_path: Path) -> None:
    for name, rows in (("a", 12), ("b", 16)):
        (tmp_path / f"{name}.yaml").write_text(OWN.format(rows=rows), encoding="utf-8")
    one, other = (f"virtex2pro:{tmp_path / name}.yaml" for name in "ab")

    def maps(*given: object) -> list[str]:
        told = json.loads(hwsw("compare", one, other, *given, "--json").stdout)
        return [told[design]["task"]["map"] for design in (one, other)]

    alone = [json.loads(hwsw("run", *each.split(":"), "--json").stdout)["task"] for each in (one, other)]
    assert maps() == [task["map"] for task in alone]
    assert maps() != maps("--on", tmp_path / "b.yaml") == [alone[1]["map"]] * 2
    assert "labyrinth" not in "".join(maps())
    told = hwsw("compare", one, other)
    assert "2 different questions were asked" in told.stdout
    assert "least" not in told.stdout, "no design is best at another question"
    (tmp_path / "map.txt").write_text("\n".join(["." * 30] * 20) + "\n", encoding="utf-8")
    given = maps("--map", tmp_path / "map.txt", "--goal", "2,3", "--start", "15,20")
    assert given[0] == given[1]


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
    (tmp_path / "map.txt").write_text("abc\n", encoding="utf-8")
    assert "did not run: --map: " in compare("0,0", "0,1").stderr


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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--memory", "0B"], "--memory: '0B' is too small\n"),
        (["--memory", "7b"], "--memory: '7b' is too small\n"),
        (["--map", "MAP", "--goal=1;2", "--start=0,0"], "--goal: '1;2' is no place\n"),
        (["--map", "MAP", "--goal=1,2,3", "--start=0,0"], "--goal: '1,2,3' is no place\n"),
    ],
)
def test_an_option_without_a_meaning_is_refused_by_name(
    hwsw: Run, tmp_path: Path, options: list[str], message: str
) -> None:
    file = tmp_path / "map.txt"
    file.write_text("...\n...\n", encoding="utf-8")
    result = hwsw("compare", *(str(file) if option == "MAP" else option for option in options))
    assert result.exit_code == 2
    assert result.stderr.startswith(message)


def test_a_comparison_as_a_page_says_how_it_was_made(hwsw: Run, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    asked = (
        "virtex2pro:breadth-first",
        "virtex4-pci:wavefront-tiles",
        "--on",
        "wavefront-rooms",
        "--need",
        "time < 1 s",
    )
    result = hwsw("compare", *asked, "--html", page)
    assert result.exit_code == 0, result.output
    assert result.stdout.endswith(f"page: {page}\n")
    html = page.read_text(encoding="utf-8")
    assert "least slices: virtex2pro:breadth-first" in html
    assert "met (proved)" in html
    assert "hwsw compare virtex2pro:breadth-first virtex4-pci:wavefront-tiles --on wavefront-rooms --need" in html


def test_a_page_overwrites_no_input_and_is_refused_before_any_work(hwsw: Run, tmp_path: Path) -> None:
    file = tmp_path / "map.txt"
    file.write_text("...\n...\n", encoding="utf-8")
    asked = ("compare", "--map", file, "--goal=0,0", "--start=1,1", "--html")
    assert "which is read" in hwsw(*asked, file).stderr
    assert hwsw(*asked, tmp_path / "none" / "page.html").exit_code == 2
    assert [path.name for path in tmp_path.iterdir()] == ["map.txt"]
