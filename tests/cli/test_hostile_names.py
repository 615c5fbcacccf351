"""A file may have any name: no command writes the marks of a terminal in it, and line breaks stay line breaks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from codesign.cli import rtl
from codesign.hardware.rtl.verify import Checked, StyleChecked

HOSTILE = "run\u202e\x1b[31m\x9bpm"
MARKS = {"\u202e", "\x1b", "\x9b"}


@pytest.fixture
def traces(specs: tuple[Path, Path], hwsw: Callable[..., Result], tmp_path: Path) -> tuple[Path, Path]:
    """A whole trace and the first part of it, under names of this kind."""
    whole, cut = tmp_path / f"{HOSTILE}.mcap", tmp_path / f"cut {HOSTILE}.mcap"
    assert hwsw("run", *map(str, specs), "-q", "--trace", str(tmp_path / "plain.mcap")).exit_code == 0
    content = (tmp_path / "plain.mcap").read_bytes()
    whole.write_bytes(content)
    cut.write_bytes(content[:-300])
    return whole, cut


COMMANDS: tuple[tuple[str, ...], ...] = (
    ("trace", "stats", "FILE"),
    ("trace", "timeline", "FILE"),
    ("trace", "diff", "FILE", "FILE"),
    ("trace", "info", "FILE"),
    ("trace", "show", "FILE", "--limit", "3"),
    ("trace", "export", "FILE", "--poses", "OUT.csv"),
    ("trace", "layout", "FILE", "-o", "OUT.json"),
    ("plot", "timeline", "FILE", "-o", "OUT.svg"),
    ("map", "FILE"),
    ("check", "FILE", "FILE"),
    ("run", "FILE", "FILE"),
    ("explore", "FILE", "FILE"),
    ("compare", "FILE:FILE"),
    ("explain", "FILE"),
    ("report", "FILE"),
    ("rtl", "FILE", "FILE"),
    ("synth", "FILE", "FILE"),
    ("verify", "FILE", "FILE"),
    ("verify-front", "FILE"),
    ("advise", "FILE", "--rate", "10 Hz"),
)


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_no_mark_of_a_file_name_reaches_the_terminal(
    command: tuple[str, ...], traces: tuple[Path, Path], hwsw: Callable[..., Result], tmp_path: Path
) -> None:
    missing = tmp_path / f"none {HOSTILE}.yaml"
    for file in (*traces, missing):
        words = [word.replace("FILE", str(file)).replace("OUT", str(tmp_path / HOSTILE)) for word in command]
        done = hwsw(*words)
        shown = done.output + done.stderr
        assert not MARKS & set(shown)
        assert done.exit_code in {0, 1, 2, 3}
        assert "Traceback" not in shown


def test_a_failure_of_several_lines_keeps_them(capsys: pytest.CaptureFixture[str]) -> None:
    failure = f"parts{HOSTILE}: the tool failed\n  hint: install it\x1b[31m"
    point = Checked("harmonic", "bit_serial", "", "a point", None, failure)
    style = StyleChecked("harmonic", "bit_serial", "", (point,))
    rtl._print([style], None, False, False)
    shown = capsys.readouterr().out
    assert "the tool failed\n  hint: install it" in shown
    assert not MARKS & set(shown)
