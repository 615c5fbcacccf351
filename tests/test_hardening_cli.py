"""What the command line does with hostile outputs, names, terminals and machines."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from codesign import files
from codesign.cli.outputs import check_folder, check_outputs
from codesign.errors import InputError, RunError, TraceError
from codesign.files import write_atomically
from codesign.reproduce import plots
from codesign.trace import McapListener

Run = Callable[..., Result]


def command(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own."""
    words = [sys.executable, "-m", "codesign", *map(os.fspath, map(_word, arguments))]
    chosen = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **options}
    return subprocess.run(words, check=False, **chosen)  # type: ignore[call-overload,no-any-return]


def _word(argument: object) -> str | Path:
    return argument if isinstance(argument, Path) else str(argument)


def test_a_link_is_followed_and_stays(tmp_path: Path) -> None:
    real, link = tmp_path / "real.csv", tmp_path / "link.csv"
    real.write_text("old")
    real.chmod(0o640)
    link.symlink_to(real)
    write_atomically(link, b"new")
    assert link.is_symlink()
    assert real.read_text() == "new"
    assert real.stat().st_mode & 0o777 == 0o640


def test_a_fifo_is_written_to_and_stays(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    got: list[bytes] = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    write_atomically(pipe, b"content")
    reader.join(10)
    assert got == [b"content"]
    assert pipe.is_fifo()


def test_a_trace_follows_links_and_replaces_no_fifo(tmp_path: Path) -> None:
    pipe, real, link = tmp_path / "pipe", tmp_path / "real.mcap", tmp_path / "link.mcap"
    os.mkfifo(pipe)
    with pytest.raises(TraceError, match="no regular file"):
        McapListener(pipe)
    assert pipe.is_fifo()
    link.symlink_to(real)
    with McapListener(link):
        pass
    assert link.is_symlink()
    assert real.stat().st_size > 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--html", "rooms.yaml"], "which is read"),
        (["--html", "linked.yaml"], "which is read"),
        (["--html", "new", "--trace", "new"], "is the file of --"),
        (["--html", "new", "--trace", "./sub/../new"], "is the file of --"),
        (["--html", "missing/page.html"], "there is no folder"),
        (["--html", "n" * 300], "--html nnn"),
        (["--html", ""], "--html"),
        (["--trace", "pipe"], "is no regular file"),
    ],
)
def test_outputs_that_would_destroy_or_fail_are_refused_before_the_run(
    hwsw: Run, specs: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, words: list[str], told: str
) -> None:
    folder = specs[0].parent
    (folder / "linked.yaml").symlink_to("rooms.yaml")
    (folder / "sub").mkdir()
    os.mkfifo(folder / "pipe")
    before = specs[1].read_bytes()
    monkeypatch.setattr("codesign.simulate", lambda *_, **__: pytest.fail("the run was begun"))
    result = hwsw("run", *specs, *words)
    assert result.exit_code == 2
    assert told in result.stderr
    assert specs[1].read_bytes() == before


@pytest.mark.parametrize(
    "words", [["--csv", "s"], ["--html", "s"], ["--csv", "s-wal"], ["--html", "board.yaml"]]
)
def test_an_exploration_never_overwrites_its_store_or_inputs(
    hwsw: Run, specs: tuple[Path, Path], words: list[str]
) -> None:
    result = hwsw("explore", *specs, "--store", "s", *words)
    assert result.exit_code == 2
    assert "give every output a file of its own" in result.stderr
    assert not (specs[0].parent / "s").exists()


def test_a_plot_overwrites_no_page(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="may overwrite"):
        check_folder("--plots", tmp_path, {"--html": tmp_path / "page.svg"})
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be made"):
        check_folder("--plots", tmp_path / "file" / "plots", {})
    check_folder("--plots", tmp_path / "new" / "plots", {"--html": tmp_path / "page.html"})


def test_what_is_at_hand_is_let_through(tmp_path: Path) -> None:
    check_outputs(
        {"--csv": tmp_path / "a", "--html": tmp_path / "b"}, ["virtex4-pci"], store=("", tmp_path / "s")
    )
    check_outputs({"--csv": Path("/dev/null"), "--html": Path("/dev/null")})
    with pytest.raises(InputError):
        check_outputs({"--csv": tmp_path / "a", "--html": tmp_path / "a"})


def _full(monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    """A disk that is full after so many files."""
    made = []
    real = files.tempfile.mkstemp

    def mkstemp(**words: object) -> tuple[int, str]:
        made.append(words)
        if len(made) > after:
            raise OSError(28, "No space left on device")
        return real(**words)  # type: ignore[call-overload,no-any-return]

    monkeypatch.setattr(files.tempfile, "mkstemp", mkstemp)


def test_init_on_a_full_disk_leaves_nothing(
    hwsw: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _full(monkeypatch, 1)
    result = hwsw("init", tmp_path / "start")
    assert result.exit_code == 1
    assert "No space left" in result.stderr
    assert list((tmp_path / "start").iterdir()) == []


def test_plots_on_a_full_disk_are_a_failed_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plots, "plot_svg", lambda plot: "<svg/>")
    plot = type("Plot", (), {"name": "one"})()
    reproduction = type("Found", (), {"figures": (plot,)})()
    _full(monkeypatch, 0)
    with pytest.raises(RunError, match="No space left"):
        plots.write_plots(reproduction, tmp_path / "plots")  # type: ignore[arg-type]
    assert list((tmp_path / "plots").iterdir()) == []


def test_an_axis_set_twice_is_refused(hwsw: Run, specs: tuple[Path, Path]) -> None:
    twice = ("--set", "relax.iterations=1", "--set", "relax.iterations=4")
    for words in (("run", *specs), ("compare",)):
        result = hwsw(*words, *twice)
        assert result.exit_code == 2
        assert "relax.iterations is set twice" in result.stderr
