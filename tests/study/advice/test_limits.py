"""Limits on figures of a plan: a design that passes one does not suffice, and the answer says by how much."""

from __future__ import annotations

from pathlib import Path

import pytest
from advice_boards import Run, asked, board, by_name

from codesign import maps


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
