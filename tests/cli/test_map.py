"""``hwsw map``: a map with its coordinates, its cells, its components, and what cropping saves."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

from codesign import maps

Run = Callable[..., Result]

DRAWN = """\
##########
####..####
####.#####
######.###
##########
"""


@pytest.fixture
def drawn(tmp_path: Path) -> Path:
    (tmp_path / "map.txt").write_text(DRAWN)
    return tmp_path / "map.txt"


def test_a_map_is_shown_with_its_coordinates(hwsw: Run, drawn: Path) -> None:
    result = hwsw("map", drawn, "--resolution", "5cm", "--at", "0,0")
    assert result.exit_code == 0
    assert result.stdout == (
        f"{drawn}: 5 × 10 cells (rows × columns)\n"
        "metres: 0.05 m a cell, 0.5 × 0.25 m (x × y), lower left corner {x: 0 m, y: 0 m}\n"
        "cells: 4 free, 46 blocked, 0 unknown\n"
        "free space: 2 components across the sides of cells, the largest has 3 cells\n"
        "crop: free leaves 3 × 3 cells, (1, 4) to (3, 6): 18.0% of the map\n"
        "crop: reachable leaves 2 × 2 cells, (1, 4) to (2, 5): 8.0% of the map\n"
        "at (0, 0), {x: 0.025 m, y: 0.225 m}: blocked;"
        " the nearest free cell is (1, 4), {x: 0.225 m, y: 0.175 m}\n"
        "\n"
        "   column 0 to 9\n"
        "0  X███▀▀████\n"
        "2  ████▄█▀███\n"
        "4  ██████████\n"
        "half a character is 1 cell: blank free, █ blocked, ░ unknown, X the place asked for\n"
    )


def test_json_has_the_same_figures(hwsw: Run, drawn: Path) -> None:
    result = hwsw("map", drawn, "--crop", "free", "--resolution", "5cm", "--at", "0.225,0.175", "--json")
    figures = json.loads(result.stdout)
    assert figures["part"] == figures["around_free"] == {"row": 1, "column": 4, "rows": 3, "columns": 3}
    assert (figures["free"], figures["components"], figures["largest_component"]) == (4, 2, 3)
    assert (figures["at"], figures["nearest_free"]) == ([1, 4], [1, 4])


def test_the_part_is_written_as_an_image(hwsw: Run, drawn: Path, tmp_path: Path) -> None:
    result = hwsw("map", drawn, "--crop", "free", "--png", tmp_path / "part.png")
    assert result.stdout.endswith(f"written: {tmp_path / 'part.png'}\n")
    assert maps.read_map(tmp_path / "part.png").free.tolist() == [
        [True, True, False],
        [True, False, False],
        [False, False, True],
    ]


def test_a_large_map_is_shown_within_72_columns(hwsw: Run, tmp_path: Path) -> None:
    free = np.ones((500, 1000), bool)
    free[250] = False
    maps.write_image(maps.OccupancyGrid(free), tmp_path / "large.png")
    lines = hwsw("map", tmp_path / "large.png").stdout.splitlines()
    picture = lines[lines.index("") + 1 : -1]
    assert max(map(len, picture)) <= 5 + 72
    assert len(picture) <= 1 + 40
    assert sum("▀" * 20 in line or "▄" * 20 in line for line in picture) == 1


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--crop", "fre"], "--crop: 'fre' is not accepted\n  hint: did you mean free?"),
        (["--inflate", "3"], "--inflate: '3' has no unit"),
        (["--inflate", "0.3 m"], "--inflate: a radius of 0.3 m on a map that does not say how large a cell is"),
        (["--downsample", "0"], "--downsample: 0 is out of bounds"),
        (["--at", "here"], "--at: 'here' is no place\n  hint: write ROW,COLUMN as in 40,60"),
        (["--at", "1.5,2"], "--at: {x: 1.5 m, y: 2 m} is in metres, and the map does not say"),
        (["--at", "5,0"], "--at: cell (5, 0) is outside of the map of 5 × 10 cells"),
        (["--png", "map.gif"], "map.gif: the suffix '.gif' names no image format"),
    ],
)
def test_mistakes_are_named_at_their_options(hwsw: Run, drawn: Path, options: list[str], expected: str) -> None:
    result = hwsw("map", drawn, *options)
    assert result.exit_code == 2
    assert expected in result.stderr


def test_a_file_that_is_none(hwsw: Run) -> None:
    result = hwsw("map", "none.yaml")
    assert result.exit_code == 2
    assert "FILE: none.yaml does not exist" in result.stderr
