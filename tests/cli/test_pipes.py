"""A reader who went away, a full disk, and a terminal or a file name that is no text."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from small_maps import put_map


def command(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own."""
    words = [sys.executable, "-m", "codesign", *map(os.fspath, map(_word, arguments))]
    chosen = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **options}
    return subprocess.run(words, check=False, **chosen)  # type: ignore[call-overload,no-any-return]


def _word(argument: object) -> str | Path:
    return argument if isinstance(argument, Path) else str(argument)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
@pytest.mark.parametrize("words", [["list"], ["--help"], ["run", "--help"]])
def test_a_full_standard_output_is_a_short_message(words: list[str]) -> None:
    with open("/dev/full", "w") as full:
        done = command(*words, stdout=full)
    assert done.returncode == 1
    assert done.stderr == "the output cannot be written: No space left on device\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_a_full_standard_error_does_not_stop_an_exploration(specs: tuple[Path, Path], tmp_path: Path) -> None:
    put_map(specs)
    with open("/dev/full", "w") as full:
        done = command("explore", *specs, "--store", tmp_path / "s", "--workers", 1, stderr=full)
    assert done.returncode == 0
    assert "points kept in" in done.stdout


def test_a_terminal_without_unicode_shows_what_it_can() -> None:
    done = command("list", env={**os.environ, "PYTHONIOENCODING": "latin-1"}, text=False)
    assert (done.returncode, done.stderr) == (0, b"")
    told = "from codesign.cli import main; import click; main.add_command; click.echo"
    script = f"{told}; from codesign.cli import output_may_fail as o\nwith o(): click.echo('\\u4e00 \\udcff')"
    env = {**os.environ, "PYTHONIOENCODING": "cp1252"}
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, env=env, check=True)
    assert shown.stdout.split() == [b"?", b"?"]


def test_a_file_name_that_is_no_text_gives_no_traceback(
    specs: tuple[Path, Path], tmp_path: Path, hwsw: Callable[..., Result]
) -> None:
    odd = tmp_path / os.fsdecode(b"b\xff.yaml")
    odd.write_bytes(specs[0].read_bytes().replace(b"100 MHz", b"100 GHz"))
    missing = tmp_path / os.fsdecode(b"no\xff.yaml")
    for words in (["check", odd], ["run", odd, specs[1]], ["check", missing], ["check", odd, "--json"]):
        done = command(*words)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
    assert json.loads(done.stdout)[0]["file"] == str(odd)
    page = tmp_path / os.fsdecode(b"page\xff.html")
    assert hwsw("run", *specs, "--json", "--html", page).exit_code == 0
    assert page.exists()


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


def test_a_reader_who_went_away_does_not_change_the_exit_code(specs: tuple[Path, Path], tmp_path: Path) -> None:
    put_map(specs)
    code, told = piped(["run", *specs])
    assert code == 0
    # A slow computer may show progress there.
    assert "rror" not in told
    assert "pipe" not in told
    # Without progress, nothing is told.
    run: list[object] = ["run", *specs, "-q"]
    assert piped([*run, "--html", tmp_path / "run.html"]) == (0, "")
    assert (tmp_path / "run.html").exists()
    small = ("fpga.part=XC3S500E-4", "fpga.clock=50 MHz", "relax.block=[24, 36]")
    assert piped([*run, *(word for each in small for word in ("--set", each))]) == (3, "")
    code, told = piped(["check", *specs, "--set", "fpga.clock=1 GHz"])
    assert code == 2
    assert told.startswith("--set fpga.clock: 1 GHz is above")
    assert piped(["check", *specs, "--set", "fpga.clock=1 GHz"], joined=True) == (2, "")


def test_a_reader_who_went_away_does_not_end_an_exploration(specs: tuple[Path, Path], tmp_path: Path) -> None:
    put_map(specs)
    page = tmp_path / "study.html"
    store = ("--store", tmp_path / "points.sqlite")
    assert piped(["explore", *specs, *store, "--workers", 1, "--html", page], joined=True) == (0, "")
    assert page.exists()
