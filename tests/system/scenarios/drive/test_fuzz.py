"""Whatever platform and workload say: ``check`` and ``run`` refuse the same, and a run ends with a result, soon."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from click.testing import Result as Invoked
from drive_fuzz import DISPLAY, MEMORY, Change, bounded, changes, files, placements
from examples import examples
from hypothesis import given, settings
from mission_specs import Ground, rectangle

import codesign
from codesign.ground.errors import EXIT_BAD_SPEC, CodesignError, Fault
from codesign.inputs.files import data_folder
from codesign.system.scenarios import check_files

Hwsw = Callable[..., Invoked]

fuzzed = settings(max_examples=25)


def assert_agree(board: Path, drive: Path) -> list[Fault]:
    """The faults that ``check`` finds; ``run`` ends with a refusal if there are any, and with a result if not."""
    with bounded():
        faults = check_files((board, drive))
        try:
            result = codesign.simulate(codesign.load_platform(board), codesign.load_workload(drive))
        except CodesignError as wrong:
            refused = wrong
            result = None
        else:
            refused = None
    assert bool(faults) == (refused is not None), (faults, refused)
    assert refused is None or refused.exit_code == EXIT_BAD_SPEC
    assert result is None or result.feasible or result.reasons
    assert all(fault.hint for fault in faults if fault.what != "unknown key")
    return faults


@fuzzed
@given(placements, changes())
def test_check_and_run_agree(tmp_path: Path, placement: str, made: list[Change]) -> None:
    assert_agree(*files(tmp_path, placement, made, limit="20 s", events=600))


@pytest.mark.slow
@settings(fuzzed, max_examples=examples(400))
@given(placements, changes(most=6))
def test_check_and_run_agree_on_many(tmp_path: Path, placement: str, made: list[Change]) -> None:
    assert_agree(*files(tmp_path, placement, made, limit="20 s", events=3000))


def robot(**keys: Any) -> list[Change]:
    return [("board", ("components", "robot", key), value) for key, value in keys.items()]


def scenario(**keys: Any) -> list[Change]:
    return [("drive", ("scenario", key), value) for key, value in keys.items()]


def screen(**keys: Any) -> list[Change]:
    return [
        ("board", ("components", "ram"), MEMORY),
        ("board", ("components", "screen"), DISPLAY | {"beside": "ram"} | keys),
    ]


EMPTY = {"generate": "empty", "rows": 300, "columns": 300}
LARGE = {"generate": "empty", "rows": 2000, "columns": 2000}
MOVING = {"size": [1, 1], "route": [[0, 0], [0, 9]]}
REFUSED: dict[str, tuple[str, list[Change], str]] = {
    "many blocks": (
        "harmonic",
        [("drive", ("problem", "map"), EMPTY), ("drive", ("mapping", "relax", "block"), [1, 1])],
        "mapping.relax.block: 90,000 blocks of 1 × 1 nodes, more than 65,536",
    ),
    "a long line": (
        "breadth-first",
        screen(total_columns=1_000_000),
        "components.screen.total_columns: total_columns of 1000000",
    ),
    "a display that takes all": (
        "breadth-first",
        screen(pixel_clock="100 MHz", total_columns=640, total_rows=480),
        "components.screen: the display takes every cycle of the memory",
    ),
    "clocks": (
        "breadth-first",
        screen(pixel_clock="999999999989 Hz"),
        "components.screen: clocks of 100000000 and 999999999989 Hz have too little in common",
    ),
    "a wide radius": (
        "breadth-first",
        robot(sensor={"type": "radius", "range": "51 km"}),
        "components.robot.sensor.range: a radius of 5.1e+05 cells",
    ),
    "a wide robot": (
        "breadth-first",
        [
            ("drive", ("problem", "map"), EMPTY | {"generate": "random", "density": 0.3, "seed": 1}),
            *robot(radius="15.1 m"),
        ],
        "components.robot.radius: a robot with a radius of 151 cells is larger than the map of 300 × 300 cells",
    ),
    "no start": (
        "breadth-first",
        [
            ("drive", ("problem", "map"), {"generate": "empty", "rows": 1, "columns": 1}),
            ("drive", ("problem", "goals"), [[0, 0]]),
            ("drive", ("problem", "starts"), {"count": 1}),
        ],
        "problem.starts: ",
    ),
    "a standing obstacle": (
        "breadth-first",
        scenario(obstacles={"moving": [MOVING | {"speed": "1e-300 m/s"}]}),
        "scenario.obstacles.moving[0].speed: a speed of 1e-299 cells/s is out of bounds",
    ),
    "a standing robot": (
        "breadth-first",
        robot(kinematics={"type": "point", "speed": "1e-300 m/s"}),
        "components.robot.kinematics.speed: 1e-300 m/s is too slow: the robot needs 1000 h for a cell of 0.1 m",
    ),
    "no acceleration": (
        "breadth-first",
        robot(kinematics={"type": "omnidirectional", "speed": "1 m/s", "acceleration": "1e-300 m/s^2"}),
        "components.robot.kinematics.acceleration: 1e-300 m/s² is too slow",
    ),
    "small cells": (
        "breadth-first",
        scenario(resolution="1e-300 m"),
        "scenario.resolution: 1e-300 m is out of bounds for the side of a cell",
    ),
    "many cells of obstacles": (
        "breadth-first",
        [
            ("drive", ("problem", "map"), LARGE),
            *scenario(obstacles={"appearing": [rectangle(99, 99, 1500, 1500, at="1 s")] * 9}),
        ],
        "scenario.obstacles.appearing: these obstacles cover 20,250,000 cells, more than 20,000,000",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_check_refuses_what_run_refuses(tmp_path: Path, name: str) -> None:
    """Each passed ``check`` once, or ended either of the two with a traceback."""
    placement, made, said = REFUSED[name]
    faults = assert_agree(*files(tmp_path, placement, made))
    assert any(said in str(fault) for fault in faults), [str(fault) for fault in faults]
    assert all(fault.line for fault in faults)


def test_long_routes_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("codesign.system.scenarios.drive.faults.MAX_OBSTACLE_CELLS", 1000)
    moving = [MOVING | {"route": [[0, 0], [0, 15]] * 10, "speed": "1 m/s"}]
    assert not assert_agree(*files(tmp_path, "breadth-first", scenario(obstacles={"moving": moving * 3})))
    (fault,) = assert_agree(*files(tmp_path, "breadth-first", scenario(obstacles={"moving": moving * 4})))
    assert fault.key == "scenario.obstacles.moving"
    assert fault.what == "the routes have 1,140 steps, more than 1,000"


def test_all_faults_are_told_at_once(tmp_path: Path, hwsw: Hwsw) -> None:
    made = [*screen(total_columns=1_000_000), *scenario(resolution="1e-300 m", tour=[[99, 99]])]
    done = hwsw("check", *files(tmp_path, "breadth-first", made))
    assert done.exit_code == EXIT_BAD_SPEC
    for said in ("screen.total_columns", "scenario.resolution", "scenario.tour[0]"):
        assert said in done.output


@pytest.mark.parametrize("scenario", ["plan_once", "drive", "fleet"])
@pytest.mark.parametrize("name", ["labyrinth", "robots-2"])
def test_a_scenario_is_for_the_planner_or_refused(tmp_path: Path, name: str, scenario: str) -> None:
    """A drive of a planner of robots asked its problem for a map, and ended with a ValueError."""
    source = data_folder("workloads") / f"{name}.yaml"
    tree = yaml.safe_load(source.read_text(encoding="utf-8"))
    kept = {key: value for key, value in tree.items() if key not in {"variants", "explore"}}
    file = tmp_path / "drive.yaml"
    file.write_text(json.dumps(kept | {"scenario": {"type": scenario}}), encoding="utf-8")
    faults = check_files(["virtex4-pci", file])
    refused = {"drive", "fleet"} - {"fleet" if name == "robots-2" else "drive"}
    assert any("is not for planner" in fault.what for fault in faults) == (scenario in refused)


@pytest.mark.parametrize(("name", "file"), [("a long line", 0), ("many blocks", 1), ("small cells", 1)])
def test_one_file_is_checked_as_far_as_it_goes(tmp_path: Path, name: str, file: int) -> None:
    placement, made, said = REFUSED[name]
    both = files(tmp_path, placement, made)
    assert not check_files([both[1 - file]])
    (fault,) = check_files([both[file]])
    assert said in str(fault)


def test_variants_of_a_workload_alone_are_checked(tmp_path: Path) -> None:
    varied = {"far": {"scenario": {"tour": [[99, 99]]}}, "near": {"scenario": {"tour": [[1, 2]]}}}
    _, drive = Ground(tmp_path).files(workload={"variants": varied})
    (fault,) = check_files([drive])
    assert fault.key == "variants.far.scenario.tour[0]"


def test_a_wide_robot_is_refused_soon(tmp_path: Path) -> None:
    """To grow 75,000 obstacles one by one, each by 125,000 cells, took a minute."""
    places = {"map": {"generate": "random", "rows": 500, "columns": 500, "density": 0.3, "seed": 1}}
    made = [("drive", ("problem",), places | {"goals": [[0, 0]], "starts": {"count": 1}}), *robot(radius="20 m")]
    (fault,) = assert_agree(*files(tmp_path, "breadth-first", made))
    assert "does not fit at its start" in fault.what


@pytest.mark.parametrize("metres", ["40 m", "100 m"])
def test_a_wide_sensor_takes_no_more_memory_than_the_map(tmp_path: Path, metres: str) -> None:
    """Over cells of 1 cm such a disc has 50 to 314 million cells."""
    import tracemalloc

    made = [*robot(sensor={"type": "radius", "range": metres}), *scenario(resolution="1 cm")]
    point = [
        load(file)
        for load, file in zip(
            (codesign.load_platform, codesign.load_workload),
            files(tmp_path, "breadth-first", made, events=300),
            strict=True,
        )
    ]
    codesign.simulate(*point)  # Whatever is imported or compiled once is not the sensor's.
    tracemalloc.start()
    result = codesign.simulate(*point)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert result.mission is not None
    assert peak < 64 * 2**20
