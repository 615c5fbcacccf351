"""Drives that cannot be are refused before they begin, each fault at its place."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result as Invoked
from mission_specs import ENDS, OPEN, Ground, rectangle

from codesign.ground.errors import SpecError

Hwsw = Callable[..., Invoked]


def refused(hwsw: Hwsw, tmp_path: Path, placement: str = "breadth-first", **settings: Any) -> str:
    """What the command line says of a drive that is refused before it runs."""
    done = hwsw("run", *Ground(tmp_path).files(placement, **settings), "--trace", tmp_path / "none.mcap")
    assert done.exit_code == 2, done.output[:500]
    assert "hint: " in done.output
    assert not (tmp_path / "none.mcap").exists()
    return done.output


def test_a_link_to_nowhere_is_refused_by_both_ends(hwsw: Hwsw, tmp_path: Path) -> None:
    text = refused(hwsw, tmp_path, platform={"links": {"uart": None}})
    assert "no link joins" in text
    assert "host" in text
    assert "robot" in text


def test_two_tasks_of_one_name(hwsw: Hwsw, tmp_path: Path) -> None:
    task = {"name": "record", "after": {"search": 8}, "kernel": "log_line"}
    text = refused(hwsw, tmp_path, workload={"tasks": [task, task]})
    assert "record" in text
    assert "tasks" in text


def test_a_task_with_the_name_of_one_that_is_there(hwsw: Hwsw, tmp_path: Path) -> None:
    task = {"name": "sense", "after": {"search": 8}, "kernel": "log_line"}
    assert "sense" in refused(hwsw, tmp_path, workload={"tasks": [task]})


def test_tasks_that_wait_for_each_other(hwsw: Hwsw, tmp_path: Path) -> None:
    tasks = [
        {"name": "one", "after": {"other": 8, "search": 8}, "kernel": "log_line"},
        {"name": "other", "after": {"one": 8}, "kernel": "log_line"},
    ]
    text = refused(hwsw, tmp_path, workload={"tasks": tasks})
    assert "in a circle" in text
    assert "one -> other -> one" in text or "other -> one -> other" in text


def test_a_task_after_itself(hwsw: Hwsw, tmp_path: Path) -> None:
    task = {"name": "record", "after": {"record": 8}, "kernel": "log_line"}
    assert "record" in refused(hwsw, tmp_path, workload={"tasks": [task]})


def test_a_task_after_none_that_there_is(hwsw: Hwsw, tmp_path: Path) -> None:
    task = {"name": "record", "after": {"serch": 8}, "kernel": "log_line"}
    done = hwsw("run", *Ground(tmp_path).files(workload={"tasks": [task]}))
    assert done.exit_code == 2
    assert "drive.yaml" in done.output
    assert "serch" in done.output


def test_a_kernel_without_a_cost(hwsw: Hwsw, tmp_path: Path) -> None:
    task = {"name": "record", "after": {"search": 8}, "kernel": "print_line"}
    assert "no cost of kernel print_line" in refused(hwsw, tmp_path, workload={"tasks": [task]})


def test_a_planner_without_a_cost(hwsw: Hwsw, tmp_path: Path) -> None:
    """Told before the drive."""
    platform = {"components": {"host": {"costs": {"relaxation_node_update": None}}}}
    text = refused(hwsw, tmp_path, "relaxation-sor", platform=platform)
    assert "no cost of kernel relaxation_node_update" in text


@pytest.mark.parametrize(
    ("mapping", "said"),
    [
        ({"sense": {"component": "host"}}, "task sense is on host, which is a processor"),
        ({"move": {"component": "fpga"}}, "task move is on fpga, which is an fpga"),
        ({"load": {"component": "robot"}}, "task load is on robot, which is a robot"),
        ({"search": {"component": "robot"}}, "task search is on robot, which is a robot\n"),
        ({"search": {"component": "robot", "style": "software"}}, "place it on a component of type fpga or"),
        ({"search": {"component": "nowhere"}}, "nowhere"),
        ({"search": {"external_memory": "host"}}, "host"),
        ({"search": {"external_memory": "nowhere"}}, "nowhere"),
    ],
)
def test_a_task_in_a_place_that_cannot_be(hwsw: Hwsw, tmp_path: Path, mapping: dict[str, Any], said: str) -> None:
    assert said in refused(hwsw, tmp_path, mapping=mapping)


@pytest.mark.parametrize(
    ("scenario", "said"),
    [
        ({"tour": [[50, 2]]}, "(50, 2)"),
        ({"hidden": [rectangle(15, 15, 2, 2)]}, "(16, 16)"),
        (
            {"hidden": [rectangle(9, 9), rectangle(0, 0, 3, 2)]},
            "drive.yaml:22:5: scenario.hidden[1]: it covers (1, 1), where the robot starts",
        ),
        ({"obstacles": {"moving": [{"route": [[0, 0], [16, 0]], "speed": "1 m/s"}]}}, "(16, 0)"),
        ({"obstacles": {"moving": [{"route": [[0, 0], [1, 0]], "speed": "0 m/s"}]}}, "speed of 0"),
        ({"obstacles": {"appearing": [rectangle(3, 3, at="2 s", until="1 s")]}}, "gone before it appears"),
        (
            {"obstacles": {"random": {"count": 3, "size": 17, "end": "1 s"}}},
            "drive.yaml:20:13: scenario.obstacles.random.size: there is no place for an obstacle of 17 × 17 cells",
        ),
        ({"resolution": "0 m"}, "resolution of 0"),
        ({"control_period": "0 s"}, "control period below 1 us"),
        ({"deadline": "-1 s"}, "deadline"),
        ({"robot": "other"}, "no robot 'other'"),
        ({"replan": {"policy": "continue"}}, "breadth_first knows no policy 'continue'"),
    ],
)
def test_a_scenario_that_cannot_be(hwsw: Hwsw, tmp_path: Path, scenario: dict[str, Any], said: str) -> None:
    assert said in refused(hwsw, tmp_path, text=OPEN, **ENDS, **scenario)


def test_faults_of_what_was_set_are_told_at_the_setting(hwsw: Hwsw, tmp_path: Path) -> None:
    random = {"random": {"count": 3, "size": 2, "end": "1 s"}}
    files = Ground(tmp_path).files(text=OPEN, **ENDS, obstacles=random)
    axes = "workload.scenario.obstacles.random.size=11", "workload.scenario.hidden=[{row: 1, column: 1}]"
    done = hwsw("check", *files, "--set", axes[0], "--set", axes[1])
    assert done.exit_code == 2
    assert "--set workload.scenario.hidden[0]: it covers (1, 1), where the robot starts" in done.output
    assert "--set workload.scenario.obstacles.random.size: there is no place for" in done.output
    # 10 × 10 cells have a place that covers neither start nor goal.
    assert "hint: 10 or less" in done.output
    assert hwsw("run", *files, "--set", axes[0].replace("11", "10")).exit_code == 0


def test_a_robot_larger_than_its_map(hwsw: Hwsw, tmp_path: Path) -> None:
    platform = {"components": {"robot": {"radius": "3 m"}}}
    assert "larger than the map" in refused(hwsw, tmp_path, text=OPEN, **ENDS, platform=platform)


def test_a_robot_that_does_not_fit_where_it_starts(hwsw: Hwsw, tmp_path: Path) -> None:
    platform = {"components": {"robot": {"radius": "0.3 m"}}}
    text = refused(hwsw, tmp_path, text=OPEN, **ENDS, platform=platform)
    assert "does not fit at its start (1, 1)" in text
    assert "the nearest cell with room is" in text


def test_a_platform_without_a_robot(hwsw: Hwsw, tmp_path: Path) -> None:
    text = refused(hwsw, tmp_path, platform={"components": {"robot": None}, "links": {"uart": None}})
    assert "a drive needs a robot" in text


def test_refusals_stand_in_the_file(tmp_path: Path) -> None:
    """Every fault at its place, all at once."""
    from codesign.system.scenarios import bind

    point = Ground(tmp_path).point(text=OPEN, **ENDS, tour=[[50, 2], [60, 2]], hidden=[rectangle(15, 15, 2, 2)])
    with pytest.raises(SpecError) as caught:
        bind(*point)
    assert len(caught.value.faults) == 3
    for one in caught.value.faults:
        assert "drive.yaml:" in str(one)
