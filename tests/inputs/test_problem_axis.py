"""Axes that move the problem: whole problems, or a key inside."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

import codesign
from codesign.ground.errors import RunError, SpecError
from codesign.inputs import cross_check, design_point
from codesign.study import Progress, explore
from codesign.system.scenarios import bind

WORKLOAD = """\
kind: workload
name: sizes
planner: breadth_first
problem: {map: {generate: empty, rows: 12, columns: 12}, goals: [[11, 11]], starts: [[0, 0]]}
mapping:
  search: {component: fpga}
explore:
  axes:
    workload.problem:
      - {map: {generate: empty, rows: 10, columns: 10}, goals: [[9, 9]], starts: [[0, 0]]}
      - {map: {generate: empty, rows: 20, columns: 20}, goals: [[19, 19]], starts: [[0, 0]]}
    fpga.clock: [120 MHz, 150 MHz]
"""


@pytest.fixture
def sizes(tmp_path: Path) -> Path:
    file = tmp_path / "sizes.yaml"
    file.write_text(WORKLOAD, encoding="utf-8")
    return file


@pytest.mark.parametrize("workers", [1, 2])
def test_each_point_has_its_own_map(hwsw: Callable[..., Result], sizes: Path, workers: int) -> None:
    result = hwsw("explore", "virtex2pro", sizes, "--json", "--workers", workers)
    assert result.exit_code == 0, result.output
    points = json.loads(result.stdout)["points"]
    cells = [point["result"]["quality"]["reachable_cells"] for point in points]
    assert cells == [99, 99, 399, 399]


def test_a_key_inside_moves_alone(sizes: Path) -> None:
    platform, workload = codesign.load_platform("virtex2pro"), codesign.load_workload(sizes)
    moved = design_point(platform, workload, {"workload.problem.map.rows": 30})
    assert bind(*moved).problem.free.shape == (30, 12)
    assert bind(platform, workload).problem.free.shape == (12, 12)
    assert moved[1].digest() != workload.digest()


def test_a_fault_in_a_value_is_told_at_the_value(sizes: Path) -> None:
    sizes.write_text(WORKLOAD.replace("goals: [[19, 19]]", "goals: [[20, 19]]"), encoding="utf-8")
    platform, workload = codesign.load_platform("virtex2pro"), codesign.load_workload(sizes)
    with pytest.raises(SpecError) as caught:
        cross_check(platform, workload)
    (fault,) = caught.value.faults
    assert (fault.line, fault.key) == (11, "explore.axes.workload.problem[1].goals[0]")
    with pytest.raises(SpecError, match=r"point: workload\.problem\.map\.rows.*whole number"):
        design_point(platform, workload, {"workload.problem.map.rows": "many"})


def test_a_map_in_a_file_is_one_of_the_values(sizes: Path, tmp_path: Path) -> None:
    (tmp_path / "map.txt").write_text("....\n....\n", encoding="utf-8")
    text = WORKLOAD.replace(
        "map: {generate: empty, rows: 20, columns: 20}, goals: [[19, 19]]", "map: {file: map.txt}, goals: [[1, 3]]"
    )
    sizes.write_text(text, encoding="utf-8")
    platform, workload = codesign.load_platform("virtex2pro"), codesign.load_workload(sizes)
    cross_check(platform, workload)
    (tmp_path / "map.txt").write_text("....\n#...\n", encoding="utf-8")
    study = codesign.explore(platform, workload)
    cells = [point.result.quality.reachable_cells for point in study.points if point.result]
    assert cells == [99, 99, 6, 6]


def test_steps_of_a_map_are_axes(tmp_path: Path) -> None:
    (tmp_path / "map.txt").write_text("####\n#..#\n#..#\n####\n", encoding="utf-8")
    head, _, _ = WORKLOAD.partition("explore:")
    text = head.replace("{generate: empty, rows: 12, columns: 12}", "{file: map.txt}")
    text = text.replace("[[11, 11]]", "[[2, 2]]").replace("[[0, 0]]", "[[1, 1]]")
    axes = "explore:\n  axes:\n    workload.problem.map.crop: [none, free]\n"
    (tmp_path / "w.yaml").write_text(text + axes, encoding="utf-8")
    platform, workload = codesign.load_platform("virtex2pro"), codesign.load_workload(tmp_path / "w.yaml")
    points = [design_point(platform, workload, {"workload.problem.map.crop": crop}) for crop in ("none", "free")]
    assert [bind(*point).problem.shape for point in points] == [(4, 4), (2, 2)]
    assert len({point[1].digest() for point in points}) == 2
    study = codesign.explore(platform, workload)
    cells = [point.result.quality.reachable_cells for point in study.points if point.result]
    assert cells == [3, 3]


MAPS = """\
kind: workload
name: maps
planner: breadth_first
problem: {map: {file: maps/a.txt}, goals: [[1, 3]], starts: [[0, 0]]}
mapping:
  search: {component: host}
explore:
  axes:
    workload.problem.map.file: [maps/a.txt, maps/b.txt]
"""


@pytest.fixture
def maps(tmp_path: Path) -> Path:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps/a.txt").write_text("....\n....\n", encoding="utf-8")
    (tmp_path / "maps/b.txt").write_text("......\n......\n......\n", encoding="utf-8")
    file = tmp_path / "maps.yaml"
    file.write_text(MAPS, encoding="utf-8")
    return file


def test_an_axis_over_map_files_reads_each_beside_the_workload(maps: Path) -> None:
    study = explore(codesign.load_platform("pc-epyc"), codesign.load_workload(maps), workers=1)
    results = [point.result for point in study.points]
    assert [result and result.quality and result.quality.reachable_cells for result in results] == [7, 17]


def test_a_map_file_that_changed_is_computed_again_and_no_other(maps: Path, tmp_path: Path) -> None:
    def cached() -> int:
        states: list[Progress] = []
        workload = codesign.load_workload(maps)
        explore(
            codesign.load_platform("pc-epyc"), workload, store=tmp_path / "s.sqlite", workers=1, progress=states.append
        )
        return states[-1].cached

    assert (cached(), cached()) == (0, 2)
    (tmp_path / "maps/b.txt").write_text("......\n..#...\n......\n", encoding="utf-8")
    assert cached() == 1


def test_a_map_file_that_changes_meanwhile_ends_the_run(maps: Path, tmp_path: Path) -> None:
    def change(_progress: Progress) -> None:
        (tmp_path / "maps/b.txt").write_text("......\n..#...\n......\n", encoding="utf-8")

    with pytest.raises(RunError, match=r"b\.txt: a map file changed"):
        explore(codesign.load_platform("pc-epyc"), codesign.load_workload(maps), workers=1, progress=change)


def test_a_map_file_that_is_missing_is_reported_at_its_value(maps: Path) -> None:
    maps.write_text(MAPS.replace("maps/b.txt]", "maps/c.txt]"), encoding="utf-8")
    with pytest.raises(SpecError, match=r"maps\.yaml:9:45: .*maps/c\.txt does not exist\n  hint: did you mean"):
        explore(codesign.load_platform("pc-epyc"), codesign.load_workload(maps), workers=1)
