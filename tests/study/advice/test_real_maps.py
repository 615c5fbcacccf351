"""Board questions on real maps, where these lie beside the repository."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from places import SHARED

Run = Callable[..., Result]

SLAM = SHARED / "maps" / "ros" / "turtlebot3" / "map.yaml"
MAZE = SHARED / "maps" / "movingai" / "mazes" / "maze512-32-0.map"
QUESTIONS = {SLAM: ("0.5,0.5", 7939), MAZE: ("256,256", None)}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not SLAM.exists() or not MAZE.exists(), reason="no real maps beside the repository"),
]


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))


def asked(hwsw: Run, map_file: Path, rate: str) -> dict[str, Any]:
    result = hwsw("advise", map_file, "--goal", QUESTIONS[map_file][0], "--rate", rate, "--json")
    assert result.exit_code in (0, 3), result.output
    answer: dict[str, Any] = json.loads(result.stdout)
    return answer


@pytest.mark.parametrize("map_file", QUESTIONS, ids=["a scan", "a maze of 512 cells a side"])
def test_every_board_has_an_answer_and_a_second_question_computes_nothing(hwsw: Run, map_file: Path) -> None:
    answer = asked(hwsw, map_file, "10 Hz")
    assert len(answer["boards"]) >= 15
    assert answer["not_searched"] == []
    assert answer["free_cells"] == (QUESTIONS[map_file][1] or answer["free_cells"])
    assert answer["certainty"]["rate"]["state"] == "proved"
    assert answer["recommended"] == ("teensy-4-1" if map_file == SLAM else "raspberry-pi-3")
    again = asked(hwsw, map_file, "20 Hz")
    assert again["simulated"] == 0
    assert again["kept"] > 0


def test_a_microcontroller_is_out_for_a_large_map_by_its_memory(hwsw: Run) -> None:
    boards = {board["board"]: board for board in asked(hwsw, MAZE, "10 Hz")["boards"]}
    (short,) = boards["teensy-4-1"]["shortfalls"]
    assert (short["need"], short["name"], short["limit"]) == ("fit", "memory of the processor", 2**20)
