"""Where the command line says a mistake is: in the file that holds it, or in the option that brought it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Run = Callable[..., Result]


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("fpga.clock=600 MHz", "--set fpga.clock: 600 MHz is above the 300 MHz limit of part XC2V6000-4\n"),
        ("relax.block=12x18", "--set relax.block: '12x18' is not a list\n  hint: write [12, 18]\n"),
        (
            "relax.blocks=[23, 2]",
            "--set relax.blocks: 23 × 2 equal blocks do not part a map of 24 × 36 cells: ",
        ),
        ("relax.component=hots", "--set relax.component: platform small-board has no component 'hots'\n"),
        ("relax.itrations=1", "--set relax.itrations: unknown key\n  hint: did you mean iterations?"),
        ("relax.iterations=010", "--set relax.iterations: 010 has a leading zero\n"),
    ],
)
def test_faults_of_a_setting_are_not_blamed_on_a_file(
    hwsw: Run, specs: tuple[Path, Path], setting: str, told: str
) -> None:
    result = hwsw("run", *specs, "--set", setting)
    assert result.exit_code == 2
    assert result.stderr.startswith(told)
    assert "rooms.yaml" not in result.stderr


def piped(arguments: list[object], *, joined: bool = False) -> tuple[int, str]:
    """Exit code and standard error of a command whose output nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "codesign", *map(str, arguments)]
    try:
        done = subprocess.run(
            command, stdout=writer, stderr=writer if joined else subprocess.PIPE, text=True, check=False
        )
    finally:
        os.close(writer)
    return done.returncode, done.stderr or ""


def test_a_reader_who_went_away_does_not_change_the_exit_code(
    specs: tuple[Path, Path], tmp_path: Path
) -> None:
    run = ["run", *specs, "--html", tmp_path / "run.html"]
    assert piped(run) == (0, "")
    assert (tmp_path / "run.html").exists()
    assert piped([*run, "--set", "fpga.part=XC3S500E-4", "--set", "fpga.clock=50 MHz"]) == (3, "")
    code, told = piped([*run, "--set", "fpga.clock=1 GHz"])
    assert code == 2
    assert told.startswith("--set fpga.clock: 1 GHz is above")
    assert piped([*run, "--set", "fpga.clock=1 GHz"], joined=True) == (2, "")


def test_a_reader_who_went_away_does_not_end_an_exploration(specs: tuple[Path, Path], tmp_path: Path) -> None:
    page = tmp_path / "study.html"
    store = ("--store", tmp_path / "points.sqlite")
    assert piped(["explore", *specs, *store, "--workers", 1, "--html", page], joined=True) == (0, "")
    assert page.exists()


def test_list_says_what_planners_and_styles_do(hwsw: Run) -> None:
    found = json.loads(hwsw("list", "--json").stdout)
    assert found["planners"]["harmonic"].startswith("A potential without local maxima")
    assert found["styles"]["harmonic.bit_serial"].startswith("on fpga: a bit-serial circuit")
    # Styles that differ in what they cost differ in what is said of them.
    assert found["styles"]["harmonic.software"] != found["styles"]["harmonic.software_limbs"]
    for text in (found["planners"]["harmonic"], found["styles"]["harmonic.bit_serial"]):
        assert "`" not in text
    lines = hwsw("list").stdout.splitlines()
    begin = lines.index("styles:") + 1
    assert len({line.index(" on ") for line in lines[begin : begin + len(found["styles"])]}) == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--memory", "0B"], "--memory: '0B' is too small\n"),
        (["--memory", "7b"], "--memory: '7b' is too small\n"),
        (["--map", "MAP", "--goal=-1,2", "--start=0,0"], "--goal: '-1,2' is no cell\n"),
        (["--map", "MAP", "--goal=1,2,3", "--start=0,0"], "--goal: '1,2,3' is no cell\n"),
    ],
)
def test_an_option_without_a_meaning_is_refused_by_name(
    hwsw: Run, tmp_path: Path, options: list[str], message: str
) -> None:
    file = tmp_path / "map.txt"
    file.write_text("...\n...\n", encoding="utf-8")
    result = hwsw("compare", *(str(file) if option == "MAP" else option for option in options))
    assert result.exit_code == 2
    assert result.stderr.startswith(message)
