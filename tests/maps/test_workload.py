"""A map in a file, from the workload that names it to a plan, in each format that robots and benchmarks use."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from PIL import Image

import codesign
from codesign.ground.records import MapRecord, TrajectoryRecord
from codesign.views.trace import MemoryListener

Run = Callable[..., Result]

# No two sides alike, so that a map read upside down or sideways is found out. ? is not known: no way for a robot.
DRAWN = """\
.......#....?....
.#####.#.##.?.##.
.#...#.#.#..?..#.
.#.#.#...#.######
.#.#.#####.....#.
...#...........#.
##########.#####.
......#........#.
.####.#.######...
.#..............#
"""
GOAL, START = (0, 0), (9, 0)
CELLS = np.array([list(row) for row in DRAWN.split()])
FREE = CELLS == "."


def reachable_from(goal: tuple[int, int]) -> int:
    """Free cells that 4-connected ways join to the goal, the goal left out."""
    found, waiting = {goal}, [goal]
    while waiting:
        row, column = waiting.pop()
        for cell in ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)):
            inside = 0 <= cell[0] < FREE.shape[0] and 0 <= cell[1] < FREE.shape[1]
            if inside and FREE[cell] and cell not in found:
                found.add(cell)
                waiting.append(cell)
    return len(found) - 1


def write_ros(folder: Path) -> Path:
    """As SLAM tools save it: 254 free, 205 unknown, 0 occupied."""
    pixels = np.select([CELLS == ".", CELLS == "?"], [254, 205], 0).astype(np.uint8)
    (folder / "floor.pgm").write_bytes(b"P5\n%d %d\n255\n" % pixels.shape[::-1] + pixels.tobytes())
    (folder / "floor.yaml").write_text(
        "image: floor.pgm\nresolution: 0.050000\norigin: [-3.2, 1.5, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    return folder / "floor.yaml"


def write_movingai(folder: Path) -> Path:
    """With trees and water in the place of what is not known."""
    rows = DRAWN.replace("#", "@").replace("?", "T").replace("@.@@", "@.@W")
    head = f"type octile\nheight {FREE.shape[0]}\nwidth {FREE.shape[1]}\nmap\n"
    (folder / "floor.map").write_text(head + rows)
    return folder / "floor.map"


def write_png(folder: Path) -> Path:
    Image.fromarray(np.where(FREE, 255, 0).astype(np.uint8)).save(folder / "floor.png")
    return folder / "floor.png"


def write_text(folder: Path) -> Path:
    (folder / "floor.txt").write_text(DRAWN.replace("?", "#"))
    return folder / "floor.txt"


FORMATS = {"ros": write_ros, "movingai": write_movingai, "png": write_png, "text": write_text}


def workload_on(folder: Path, file: str) -> Path:
    path = folder / "floor-workload.yaml"
    path.write_text(
        f"kind: workload\nname: floor\nplanner: harmonic\n"
        f"problem: {{map: {{file: {file}}}, goals: [{list(GOAL)}], starts: [{list(START)}]}}\n"
        "mapping:\n  relax: {component: fpga, block: [5, 6], iterations: 4, schedule: [15, 63, 127]}\n"
    )
    return path


@pytest.mark.parametrize("name", FORMATS)
def test_a_map_in_a_file_is_planned_on(specs: tuple[Path, Path], tmp_path: Path, name: str) -> None:
    (tmp_path / "maps").mkdir()
    file = FORMATS[name](tmp_path / "maps")
    workload = codesign.load_workload(workload_on(tmp_path, f"maps/{file.name}"))
    memory = MemoryListener()
    result = codesign.simulate(codesign.load_platform(specs[0]), workload, listeners=(memory,))

    (seen,) = (record for record in memory.records if isinstance(record, MapRecord))
    assert (seen.free == FREE).all()
    assert seen.resolution == (0.05 if name == "ros" else None)
    assert result.feasible
    assert result.quality is not None
    assert result.quality.reachable_cells == reachable_from(GOAL) < FREE.sum() - 1
    assert (result.quality.share_reaching_goal, result.quality.starts_arrived) == (1.0, 1)

    (way,) = (record for record in memory.records if isinstance(record, TrajectoryRecord))
    assert way.arrived
    assert np.abs(way.points[0] - START).max() <= 1
    assert np.abs(way.points[-1] - GOAL).max() <= 1
    assert FREE[tuple(np.rint(way.points).astype(int).T)].all()


def test_the_format_of_a_map_changes_nothing_else(hwsw: Run, specs: tuple[Path, Path], tmp_path: Path) -> None:
    told = {}
    for name, write in FORMATS.items():
        path = workload_on(tmp_path, write(tmp_path).name)
        result = hwsw("run", specs[0], path, "--json")
        assert result.exit_code == 0, result.output
        told[name] = json.loads(result.stdout)
    for name, figures in told.items():
        for key in ("time", "cycles", "stages", "resources", "quality"):
            assert figures[key] == told["text"][key], (name, key)


def test_faults_of_a_map_file_are_told_at_the_workload(hwsw: Run, specs: tuple[Path, Path], tmp_path: Path) -> None:
    file = write_ros(tmp_path)
    path = workload_on(tmp_path, "floor.yaml")
    file.write_text(file.read_text().replace("0.65", "0.065"))
    result = hwsw("run", specs[0], path)
    assert result.exit_code == 2
    assert "floor-workload.yaml:4:" in result.stderr
    assert "floor.yaml:6:14: free_thresh 0.196 is above occupied_thresh 0.065" in result.stderr
    (tmp_path / "floor.pgm").unlink()
    file.write_text(file.read_text().replace("0.065", "0.65"))
    result = hwsw("run", specs[0], path)
    assert result.exit_code == 2
    assert "floor.pgm" in result.stderr
