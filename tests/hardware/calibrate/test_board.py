"""The script that measures a board with NumPy alone: its programs do what planners do, and its file is a host."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codesign import maps
from codesign.ground.errors import SpecError
from codesign.hardware.calibrate import board
from codesign.hardware.calibrate import host_fit as host_times
from codesign.hardware.calibrate.board import read_board, script
from codesign.inputs.library import HOSTS
from codesign.planners.relaxation.plan import solve
from codesign.planners.relaxation.styles.board import sweeps

SMALL = (("rooms", {"rows": 30, "columns": 40, "seed": 1}), ("random", {"rows": 25, "columns": 20, "density": 0.2}))
COMPILER = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two small maps in place of twelve."""
    monkeypatch.setattr(board, "questions", lambda: host_times.questions(SMALL))


def ran(folder: Path, compiler: str = "cc") -> Path:
    (folder / "probe.py").write_text(script(0.0))
    environment = {"PATH": "/usr/bin:/bin", "CC": compiler, "PYTHONPATH": ":".join(sys.path[1:])}
    done = subprocess.run(
        [sys.executable, "-S", "probe.py"], cwd=folder, env=environment, capture_output=True, check=True
    )
    (folder / "board.json").write_bytes(done.stdout)
    return folder / "board.json"


@COMPILER
@pytest.mark.usefixtures("few")
def test_every_program_counts_what_the_planner_does_and_makes_a_host(tmp_path: Path) -> None:
    """A program whose count differs from that of the style is left out, so that all are there says that none does."""
    file = ran(tmp_path)
    document = json.loads(file.read_text())
    assert document["not_timed"] == {}
    assert {how.split()[0] for how in document["made"].values()} == {"C", "Python"}
    host = read_board(file)
    assert {"breadth_first_cell", "wavefront_cell", "relaxation_node_update"} <= host.costs.keys()
    assert all("board.json" in cost.source for cost in host.costs.values())
    assert "C by cc -O2" in host.costs["breadth_first_cell"].source


@pytest.mark.usefixtures("few")
def test_without_a_compiler_the_file_says_what_was_left_out(
    tmp_path: Path, hwsw: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = ran(tmp_path, "no-such-compiler")
    document = json.loads(file.read_text())
    assert set(document["not_timed"]) == {"breadth_first software", "wavefront software"}
    monkeypatch.chdir(tmp_path)
    done = hwsw("calibrate", "host", "--from", file, "--write", "mine.yaml", "--like", "cortex-a72")
    assert done.exit_code == 0, done.output
    assert "breadth_first software was not timed: no C compiler" in done.output
    host = HOSTS.find("mine", [tmp_path])
    assert "breadth_first_cell" not in host.costs
    assert host.all_costs()["breadth_first_cell"].status == "assumed"


@pytest.mark.usefixtures("few")
def test_faults_of_a_board_file_are_told_with_their_places(tmp_path: Path) -> None:
    (tmp_path / "board.json").write_text(
        '{"kind": "board", "script": "0", "machine": "m", "cores": 0, "clock_hz": null,\n "made": {},'
        ' "times": {}, "nottimed": {}}'
    )
    with pytest.raises(SpecError) as caught:
        read_board(tmp_path / "board.json")
    text = str(caught.value)
    assert "board.json:1:" in text
    assert "cores" in text
    assert "did you mean not_timed?" in text
    (tmp_path / "board.json").write_text(
        '{"kind": "board", "script": "0", "machine": "m", "cores": 1, "clock_hz": null,'
        ' "made": {}, "times": {}, "not_timed": {}}'
    )
    with pytest.raises(SpecError, match="script of another version"):
        read_board(tmp_path / "board.json")


def test_a_script_is_printed_alone(hwsw: Callable[..., Any]) -> None:
    assert hwsw("calibrate", "host", "--script", "--like", "cortex-a72").exit_code == 2


@pytest.mark.parametrize("count", [1, 7])
def test_the_sweeps_of_a_board_are_those_of_the_planner(count: int) -> None:
    free = maps.random_obstacles(14, 19, density=0.2, seed=3).free
    goal = tuple(int(each) for each in np.argwhere(free)[20])
    expected = solve(free, [goal], method="gs", tolerance=1e-15, max_iterations=count).potential
    assert (sweeps(free, goal, count)[0][1:-1, 1:-1] == expected).all()
