"""Limits on figures of a plan: a design that passes one does not suffice, and the answer says by how much."""

from __future__ import annotations

import json
import shlex
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from advice_boards import Run, asked, board, by_name

from codesign import maps
from codesign.planners.interface import Problem, judge_paths


@pytest.fixture
def hall(tmp_path: Path) -> Path:
    """A hall with blocks, where the paths of planners differ."""
    path = tmp_path / "hall.png"
    maps.write_image(maps.generate("random", rows=24, columns=24, density=0.2, size=3, seed=1), str(path))
    return path


def test_a_detour_and_a_limit_on_the_same_figure_agree(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    quick = board(tmp_path, "quick", 1)
    code, answer = asked(hwsw, corridor, [quick], "10 Hz")
    design = by_name(answer)["quick"]["design"]["trial"]
    assert (code, design["detour"], design["figures"]["path_length_ratio_mean"]) == (0, 1.0, 1.0)
    assert asked(hwsw, corridor, [quick], "10 Hz", "--detour", "1")[0] == 0
    code, answer = asked(hwsw, corridor, [quick], "10 Hz", "--need", "path_length_ratio_mean < 1")
    assert code == 3
    (short,) = by_name(answer)["quick"]["shortfalls"]
    assert (short["need"], short["demand"], short["limit"], short["lower"]) == ("figure", 1.0, 1.0, False)
    assert "a limit excludes quick (its path length ratio is 1, against 1" in answer["verdict"]


@pytest.mark.parametrize("limit", ["clearance_mean >= 0.1", "clearance_mean <= 1000"])
def test_a_limit_that_is_kept_changes_nothing(hwsw: Run, hall: Path, tmp_path: Path, limit: str) -> None:
    quick = board(tmp_path, "quick", 1)
    words = ("advise", hall, "--goal", "12,12", "--rate", "1 Hz", "--boards", quick)
    plain, limited = hwsw(*words), hwsw(*words, "--need", limit)
    assert plain.exit_code == limited.exit_code == 0, limited.output
    assert plain.stdout.splitlines()[1].split(";")[0] == limited.stdout.splitlines()[1].split(";")[0]
    assert "clearance at" in limited.stdout.splitlines()[0]


def test_a_limit_that_no_design_keeps_is_named(hwsw: Run, hall: Path, tmp_path: Path) -> None:
    quick = board(tmp_path, "quick", 1)
    words = ("advise", hall, "--goal", "12,12", "--rate", "1 Hz", "--boards", quick)
    none = hwsw(*words, "--need", "clearance_mean >= 100")
    assert none.exit_code == 3
    assert "a limit excludes quick (its clearance is " in none.stdout
    bad = hwsw(*words, "--need", "clearence_mean >= 1")
    assert (bad.exit_code, "did you mean clearance_mean" in bad.output) == (2, True)


@pytest.mark.parametrize("figure", ["path_length_ratio_mean", "clearance_mean", "turning_mean"])
def test_a_limit_on_a_path_means_the_same_to_advise_and_to_run(
    hwsw: Run, hall: Path, tmp_path: Path, figure: str
) -> None:
    """On both sides of a path's own figure the two agree, and the better side is the one that holds."""
    quick = board(tmp_path, "quick", 1)
    words = ("advise", hall, "--goal", "12,12", "--rate", "1 Hz", "--boards", quick, "--planner", "breadth_first")
    answer = json.loads(hwsw(*words, "--write", tmp_path / "written", "--json").stdout)
    value = answer["boards"][0]["design"]["trial"]["figures"][figure]
    assert value > 0
    for sign in ("<=", ">="):
        for limit in (0.9 * value, 1.1 * value):
            need = f"{figure} {sign} {limit}"
            kept = value <= limit if sign == "<=" else value >= limit
            run = hwsw(*shlex.split(answer["command"])[1:], "--need", need)
            advised = hwsw(*words, "--need", need)
            assert [run.exit_code, advised.exit_code] == [0 if kept else 3] * 2, (need, run.output, advised.output)


def test_the_turning_of_a_path_is_the_sum_of_its_angles() -> None:
    """Whatever the steps are cut into, and whichever way the path is walked; a straight path has none."""
    free = np.ones((20, 20), bool)
    problem = Problem(free=free, goals=((0, 0),), starts=((9, 9),))
    corner = np.array([[9.0, 9.0], [9.0, 0.0], [0.0, 0.0]])
    zigzag = np.array([[9.0, 9.0], [6.0, 6.0], [3.0, 6.0], [0.0, 3.0], [0.0, 0.0]])
    for points, degrees in ((corner, 90.0), (zigzag, 135.0), (corner[:2], 0.0), (corner[:1], 0.0)):
        fine = np.concatenate([points[:1], *(np.linspace(*pair, 8) for pair in pairwise(points))])
        for path in (points, points[::-1], fine):
            assert judge_paths(problem, [((9, 9), path)])["turning_mean"] == degrees
