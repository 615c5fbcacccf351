"""``hwsw list PLANNER``, ``show`` and ``init`` with a board, a planner and a map."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from codesign.inputs import list_parts
from codesign.inputs.files import ShippedFile, data_folder, shipped_files
from codesign.system import catalog

Run = Callable[..., Result]
WAREHOUSE = data_folder("workloads") / "maps" / "warehouse.txt"


@pytest.mark.parametrize(
    "planner", ["breadth_first", "grid_search", "harmonic", "relaxation", "velocity_obstacle", "wavefront"]
)
def test_list_has_every_parameter_of_a_planner(hwsw: Run, planner: str) -> None:
    facts = json.loads(hwsw("list", planner, "--json").stdout)
    wanted = {(task, name) for task, model in catalog.planner(planner).tasks.items() for name in model.model_fields}
    assert {(each["task"], each["name"]) for each in facts["parameters"]} == wanted
    assert all(each["accepted"] and each["default"] and each["meaning"] for each in facts["parameters"])
    assert set(catalog.styles_of(planner)) <= set(facts["styles"])
    text = hwsw("list", planner).stdout
    assert "`" not in text
    assert text.startswith(f"{planner}: ")
    for _, name in wanted:
        assert f" {name} " in text


def test_list_of_a_parameter_says_what_is_accepted(hwsw: Run) -> None:
    parameters = json.loads(hwsw("list", "harmonic", "--json").stdout)["parameters"]
    (iterations,) = (each for each in parameters if each["name"] == "iterations")
    assert iterations["accepted"] == "whole number, from 1 to 1,000,000"
    assert iterations["default"] == "required"


def test_list_of_an_unknown_planner_names_the_nearest(hwsw: Run) -> None:
    done = hwsw("list", "wavfront")
    assert done.exit_code == 2
    assert "did you mean wavefront?" in done.stderr


@pytest.mark.parametrize("file", shipped_files(), ids=str)
def test_every_shipped_file_is_shown(hwsw: Run, file: ShippedFile) -> None:
    done = hwsw("show", str(file))
    assert done.exit_code == 0
    assert done.stdout_bytes == file.path.read_bytes()
    assert done.stderr == f"# {file.path}\n"
    assert Path(hwsw("show", str(file), "--path").stdout.strip()) == file.path


def test_a_part_is_shown_by_its_name_with_a_speed_grade(hwsw: Run) -> None:
    for name in list_parts():
        path = Path(hwsw("show", name, "--path").stdout.strip())
        assert name.startswith(path.stem)
    assert hwsw("show", "part:XC7Z020-1", "--path").exit_code == 0


def test_an_ambiguous_or_unknown_name_is_refused(hwsw: Run) -> None:
    several = hwsw("show", "warehouse")
    assert several.exit_code == 2
    assert "write one of map:warehouse, workload:warehouse" in several.stderr
    unknown = hwsw("show", "zynk")
    assert unknown.exit_code == 2
    assert "did you mean zynq?" in unknown.stderr
    assert hwsw("show", "../pyproject").exit_code == 2


@pytest.mark.parametrize("planner", ["breadth_first", "grid_search", "harmonic", "relaxation", "wavefront"])
@pytest.mark.parametrize("board", ["zynq", "arty-a7"])
def test_init_writes_a_board_and_a_planner_that_run(hwsw: Run, tmp_path: Path, board: str, planner: str) -> None:
    done = hwsw("init", "mine", "--board", board, "--planner", planner, "--map", WAREHOUSE)
    assert done.exit_code == 0, done.stderr
    assert "goal: [26, 42], the cell nearest to the middle of the map in its largest area" in done.stdout
    *_, program, command, platform, workload = done.stdout.split()
    assert (program, command) == ("hwsw", "run")
    result = json.loads(hwsw(command, platform, workload, "--json").stdout)
    assert result["feasible"] is True
    assert result["planner"] == planner
    assert result["quality"]["starts"] == 16
    assert '"crop": "free"' in (tmp_path / "mine" / "my-workload.yaml").read_text(encoding="utf-8")
    assert (tmp_path / "mine" / "my-platform.yaml").read_text(encoding="utf-8").count("name: my-platform\n") == 1


def test_init_takes_a_goal_and_a_generated_map(hwsw: Run, tmp_path: Path) -> None:
    assert hwsw("init", "--board", "zynq", "--planner", "wavefront", "--goal", "3,128").exit_code == 0
    text = (tmp_path / "my-workload.yaml").read_text(encoding="utf-8")
    assert "goals: [[3, 128]]" in text
    assert '"generate": "maze"' in text
    assert hwsw("check", "my-platform.yaml", "my-workload.yaml").exit_code == 0


def test_init_says_why_the_fabric_is_not_used(hwsw: Run) -> None:
    done = hwsw("init", "--board", "arty-a7", "--planner", "harmonic")
    assert "planning: software on host" in done.stdout
    assert "bit_serial on fabric takes 11,486 slices at best, where 10,400 are there" in done.stdout


def test_init_overwrites_nothing(hwsw: Run, tmp_path: Path) -> None:
    (tmp_path / "my-workload.yaml").write_text("mine", encoding="utf-8")
    done = hwsw("init", "--board", "zynq", "--map", WAREHOUSE)
    assert done.exit_code == 2
    assert "my-workload.yaml exists already" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["my-workload.yaml"]


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (("--board", "zynk"), "there is no shipped platform 'zynk'\n  hint: did you mean zynq?"),
        (("--planner", "wave"), "no planner is named 'wave'"),
        (("--planner", "velocity_obstacle"), "velocity_obstacle plans on no map with a goal"),
        (("--goal", "1;2"), "--goal: '1;2' is no place"),
        (("--goal", "6,6"), "--goal: goal (6, 6) is on an obstacle"),
        (("--goal", "500,0"), "is outside of the map"),
        (("--map", "walls.txt"), "--map: the map has no free cell"),
        (("--board", "nexys2"), "--board: harmonic does not fit nexys2 with this map: bit_serial on fabric takes "),
    ],
)
def test_init_refuses_what_cannot_run(hwsw: Run, tmp_path: Path, words: tuple[str, ...], fault: str) -> None:
    (tmp_path / "walls.txt").write_text("###\n###\n", encoding="utf-8")
    done = hwsw("init", "mine", *words)
    assert done.exit_code == 2
    assert fault in done.stderr
    assert "hint:" in done.stderr
    assert not (tmp_path / "mine").exists()
