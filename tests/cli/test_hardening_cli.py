"""What the command line does with hostile outputs, names, terminals and machines."""

from __future__ import annotations

import json
import os
import pickle
import stat
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from codesign import files, kernel_cache
from codesign.cli.outputs import check_folder, check_outputs
from codesign.errors import CodesignError, Fault, InputError, RunError, SpecError, TraceError
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
        (["--html", "missing/page.html"], "does not exist"),
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


NASTY = "a\x1b[31m\u202eb\udcff"


def test_no_error_reaches_the_terminal_raw() -> None:
    faults = [Fault(f"{NASTY}.yaml", 1, 1, NASTY, NASTY, NASTY)]
    for error in (CodesignError(NASTY, NASTY, NASTY), SpecError(faults)):
        shown = str(error)
        assert shown.count("a\N{REPLACEMENT CHARACTER}[31m") >= 3
        assert all(mark.isprintable() or mark == "\n" for mark in shown)
        assert str(pickle.loads(pickle.dumps(error))) == shown
    assert str(InputError("two\nlines", "here", "do")) == "here: two\nlines\n  hint: do"


def test_written_paths_reach_the_terminal_harmless(hwsw: Run, tmp_path: Path) -> None:
    result = hwsw("init", tmp_path / "a\x1b[31mb")
    assert result.exit_code == 0
    assert "\x1b" not in result.output


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
@pytest.mark.parametrize("words", [["list"], ["--help"], ["run", "--help"]])
def test_a_full_standard_output_is_a_short_message(words: list[str]) -> None:
    with open("/dev/full", "w") as full:
        done = command(*words, stdout=full)
    assert done.returncode == 1
    assert done.stderr == "the output cannot be written: No space left on device\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_a_full_standard_error_does_not_stop_an_exploration(specs: tuple[Path, Path], tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        done = command("explore", *specs, "--store", tmp_path / "s", "--workers", 1, stderr=full)
    assert done.returncode == 0
    assert "points kept in" in done.stdout


def test_a_terminal_without_unicode_shows_what_it_can() -> None:
    done = command("list", env={**os.environ, "PYTHONIOENCODING": "latin-1"}, text=False)
    assert (done.returncode, done.stderr) == (0, b"")
    told = "from codesign.cli import main; import click; main.add_command; click.echo"
    script = f"{told}; from codesign.cli.pipes import output_may_fail as o\nwith o(): click.echo('\\u4e00 \\udcff')"
    env = {**os.environ, "PYTHONIOENCODING": "cp1252"}
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, env=env, check=True)
    assert shown.stdout.split() == [b"?", b"?"]


def test_a_file_name_that_is_no_text_gives_no_traceback(specs: tuple[Path, Path], tmp_path: Path) -> None:
    odd = tmp_path / os.fsdecode(b"b\xff.yaml")
    odd.write_bytes(specs[0].read_bytes().replace(b"100 MHz", b"100 GHz"))
    missing = tmp_path / os.fsdecode(b"no\xff.yaml")
    for words in (["check", odd], ["check", odd, "--json"], ["run", odd, specs[1]], ["check", missing]):
        done = command(*words)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
    assert json.loads(command("check", odd, "--json").stdout)[0]["file"] == str(odd)
    page = tmp_path / os.fsdecode(b"page\xff.html")
    assert command("run", *specs, "--html", page).returncode == 0
    assert page.exists()


def test_a_deleted_current_folder_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hwsw: Run) -> None:
    def gone() -> str:
        raise FileNotFoundError(2, "No such file or directory")

    monkeypatch.setattr(os, "getcwd", gone)
    result = hwsw("list")
    assert result.exit_code == 2
    assert "the current folder does not exist any more" in result.stderr


@pytest.mark.parametrize("kind", ["EOFError()", "__import__('pickle').UnpicklingError('truncated')"])
def test_a_broken_kernel_cache_is_told(hwsw: Run, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    names: dict[str, Callable[..., None]] = {}
    exec(compile(f"def load(*a):\n    raise {kind}\n", "/x/numba/core/caching.py", "exec"), names)
    monkeypatch.setattr("codesign.system.at_hand", names["load"])
    result = hwsw("list")
    assert result.exit_code == 1
    assert "cache of compiled kernels" in result.stderr
    assert "NUMBA_CACHE_DIR" in result.stderr


def test_kernels_find_a_private_cache_where_there_is_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "numba")
    kernel_cache.provide_kernel_cache()
    assert "NUMBA_CACHE_DIR" not in os.environ
    monkeypatch.setattr(kernel_cache, "_may_write", lambda folder: False)
    seen = []
    for _ in range(2):
        kernel_cache.provide_kernel_cache()
        seen.append(Path(os.environ["NUMBA_CACHE_DIR"]))
        monkeypatch.delenv("NUMBA_CACHE_DIR")
    assert seen[0] == seen[1]
    assert seen[0].parent == tmp_path
    assert stat.S_IMODE(seen[0].stat().st_mode) == 0o700
    seen[0].chmod(0o777)
    kernel_cache.provide_kernel_cache()
    # Others could have put anything there.
    assert Path(os.environ["NUMBA_CACHE_DIR"]) != seen[0]
    monkeypatch.delenv("NUMBA_CACHE_DIR")


def test_a_folder_can_be_written_to_only_below_a_folder(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert kernel_cache._may_write(tmp_path / "new" / "numba")
    assert not kernel_cache._may_write(tmp_path / "file" / "numba")


@pytest.mark.parametrize(("name", "kept"), [("list", False), ("explore", True)])
def test_only_an_exploration_keeps_what_was_finished(
    hwsw: Run, specs: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, name: str, kept: bool
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("codesign.system.at_hand", interrupted)
    monkeypatch.setattr("codesign.explore", interrupted)
    result = hwsw("list") if name == "list" else hwsw("explore", *specs)
    assert result.exit_code == 130
    assert ("kept" in result.stderr) is kept


def test_an_interrupt_while_loading_gives_no_traceback() -> None:
    script = """
import sys
class Interrupt:
    def find_spec(self, name, *_):
        if name == "click":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupt())
from codesign.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")


def test_progress_is_told_by_time_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from codesign.cli import progress

    clock = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    lines = progress.PlainLines()
    for done, now in ((0, 1000.0), (1, 1001.0), (2, 1011.0), (3, 1012.0)):
        clock[0] = now
        lines(progress.Advance(done, 1000, "points"))
    assert [line.split()[0] for line in capsys.readouterr().err.splitlines()] == ["0/1000", "2/1000"]
