"""Questions that cannot be asked, and planners that fail on a board."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from advice_boards import FABRIC, Run, asked, board

from codesign.planners.styles import Family
from codesign.system import catalog


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (("--rate", "0 Hz"), "--rate: '0 Hz' is zero"),
        (("--rate", "1e9 Hz"), "--rate: '1e9 Hz' is too large"),
        (("--rate", "1 GHz"), "--rate: '1 GHz' is too large"),
        (("--rate", "10"), "--rate: '10' has no unit"),
        (("--power", "5"), "--power: '5' has no unit"),
        (("--price", "200 EUR"), "--price: '200 EUR' has no unit of price"),
        (("--clearance", "-1 m"), "--clearance: '-1 m' is negative"),
        (("--goal", "north"), "--goal: 'north' is no"),
        (("--goal", "1.5,0.5"), "--goal: {x: 1.5 m, y: 0.5 m} is in metres, and the map does not say how large"),
        (("--clearance", "0.1 m"), "--clearance: a radius of 0.1 m on a map that does not say how large a cell is"),
        (("--resolution", "5"), "--resolution: '5' has no unit"),
        (("--goal", "0,5"), "obstacle"),
        (("--goal", "7,7"), "outside of the map"),
        (("--start", "0,5"), "obstacle"),
        (("--boards", "raspberri"), "there is no shipped platform 'raspberri'"),
        (("--boards", "zynq,zynq"), "board zynq is named twice"),
        (("--boards", ","), "no board is named"),
        (("--planner", "wavefrnt"), "did you mean wavefront? accepted: breadth_first, grid_search, "),
        (("--style", "tild"), "no style 'tild'"),
        (("--certify", "none/here.cert"), "here.cert: folder "),
        (("--html", "none/here.html"), "here.html: folder "),
        (("--certify", "map.txt"), "map.txt, which is read"),
    ],
)
def test_bad_input_is_a_fault_with_a_remedy(hwsw: Run, tmp_path: Path, options: tuple[str, str], fault: str) -> None:
    (tmp_path / "map.txt").write_text(".....#....\n..........\n", encoding="utf-8")
    words = {"--goal": "0,0", "--rate": "10 Hz", "--boards": "zynq"} | {options[0]: options[1]}
    result = hwsw("advise", tmp_path / "map.txt", *(word for pair in words.items() for word in pair))
    assert result.exit_code == 2, result.output
    assert fault in result.output
    assert "hint: " in result.output


@pytest.mark.parametrize("option", ["--share", "--detour", "--budget", "--reach"])
@pytest.mark.parametrize("number", ["nan", "inf", "-inf", "-1", "much"])
def test_a_number_that_is_none_or_out_of_bounds_is_refused(hwsw: Run, corridor: Path, option: str, number: str) -> None:
    result = hwsw("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--boards", "zynq", f"{option}={number}")
    assert result.exit_code == 2, result.output
    assert f"Invalid value for '{option}" in result.output


@pytest.mark.parametrize("number", ["0", "1.01"])
def test_a_share_of_nothing_or_of_more_than_the_part_is_refused(hwsw: Run, corridor: Path, number: str) -> None:
    words = ("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--boards", "zynq", "--share", number)
    result = hwsw(*words)
    assert (result.exit_code, "is not in the range 0<x<=1" in result.output) == (2, True)


def test_a_style_of_another_planner_is_refused_with_the_styles_of_this_one(hwsw: Run, corridor: Path) -> None:
    words = ("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--boards", "zynq", "--planner", "wavefront")
    result = hwsw(*words, "--style", "state_machine")
    assert result.exit_code == 2, result.output
    assert "--style: no style of wavefront 'state_machine'" in result.output
    result = hwsw("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--style", "tild")
    accepted = result.output.split("accepted: ")[1].split(", ")
    assert len(accepted) == len(set(accepted))


def test_a_board_without_a_design_of_what_is_asked_says_so(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    quick = board(tmp_path, "quick", 1)
    for words, what in (
        (("--on", "fabric"), "it has no design on fabric"),
        (("--on", "split", "--planner", "wavefront"), "it has no design on split wavefront"),
    ):
        code, answer = asked(hwsw, corridor, [quick], "10 Hz", *words)
        assert (code, answer["recommended"]) == (3, None)
        assert f"excludes quick ({what})" in answer["verdict"]
        assert answer["boards"][0]["shortfalls"][0]["name"] == what


def test_output_files_are_no_others(hwsw: Run, corridor: Path) -> None:
    result = hwsw(
        *("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--boards", "zynq"),
        *("--html", "answer", "--certify", "answer"),
    )
    assert (result.exit_code, "give every output a file of its own" in result.output) == (2, True), result.output


def test_a_map_without_a_free_cell_is_a_fault(hwsw: Run, tmp_path: Path) -> None:
    (tmp_path / "map.txt").write_text("#####\n#####\n", encoding="utf-8")
    result = hwsw("advise", tmp_path / "map.txt", "--goal", "0,0", "--rate", "10 Hz")
    assert result.exit_code == 2, result.output
    assert "free" in result.output
    assert "hint: " in result.output


def broken(*_: object) -> Any:
    raise ZeroDivisionError("division by zero")


def parts_fail(*_: object) -> Iterator[Family]:
    yield Family((), least={}, parts=broken)


def bounds_fail(*_: object) -> Iterator[Family]:
    yield Family(({},), sharper=broken)


@pytest.mark.parametrize(
    ("method", "code_of"),
    [("demand", broken), ("families", broken), ("families", parts_fail), ("families", bounds_fail)],
)
def test_a_planner_that_fails_on_one_board_is_reported_and_the_others_go_on(
    hwsw: Run, corridor: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str, code_of: Any
) -> None:
    (style,) = (each for (_, name), each in catalog.architectures().items() if name == "state_machine")
    monkeypatch.setattr(type(style), method, code_of)
    fabric = tmp_path / "fabric.yaml"
    fabric.write_text(FABRIC, encoding="utf-8")
    code, answer = asked(hwsw, corridor, [fabric], "1 MHz")
    assert code == 4
    assert "fabric: planner breadth_first failed: ZeroDivisionError: division by zero" in answer["remarks"]
    # A design that could not be tried may be the one that suffices.
    assert answer["proof"]["state"] == "not proved"
    assert "the code of a planner failed before all their designs were looked at" in answer["verdict"]


def test_without_a_folder_to_write_to_the_answer_is_told(
    hwsw: Run, corridor: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "file" / "cache"))
    fabric = tmp_path / "fabric.yaml"
    fabric.write_text(FABRIC, encoding="utf-8")
    code, answer = asked(hwsw, corridor, [fabric], "10 Hz")
    assert (code, answer["recommended"], answer["command"]) == (0, "fabric", None)
    remarks = " ".join(answer["remarks"])
    assert "no trial is kept" in remarks
    assert "--write FOLDER" in remarks
    result = hwsw(
        *("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--boards", fabric),
        *("--write", tmp_path / "file" / "mine"),
    )
    assert result.exit_code in (1, 2)
