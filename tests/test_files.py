"""Files are written whole, through links and into pipes."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from codesign.ground.errors import RunError
from codesign.ground.files import (
    kept_folder,
    part_of,
    passing,
    remove_passing,
    scratch,
    write_atomically,
    write_folder,
    written_atomically,
)
from codesign.hardware.rtl.design import kept
from codesign.hardware.rtl.tools import run
from codesign.study.advice import kept_trials
from codesign.study.store import MemoryStore
from codesign.views.bags.export import BagFolder
from codesign.views.trace.listeners import McapListener


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


def test_a_passing_file_of_an_impossible_name_is_forgotten() -> None:
    with pytest.raises(RuntimeError, match="stopped"), passing(Path("a\0.part")):
        raise RuntimeError("stopped")
    remove_passing()


def test_a_full_disk_has_the_words_of_the_system_whoever_writes(tmp_path: Path) -> None:
    with (
        pytest.raises(RunError, match=r"cannot write: No space left on device\n  hint: free some space"),
        written_atomically(tmp_path / "points.parquet"),
    ):
        raise OSError(errno.ENOSPC, "Error writing bytes to file. Detail: [errno 28] No space left on device")


def write_trace(path: Path) -> None:
    with McapListener(path):
        pass


def write_bag(path: Path) -> None:
    pytest.importorskip("rosbags")
    with BagFolder(path):
        pass


WRITERS: dict[str, Callable[[Path], None]] = {
    "file": lambda path: write_atomically(path, b"new"),
    "folder": lambda path: write_folder(path, {"a": b"1", "b": b"2"}),
    "trace": write_trace,
    "bag": write_bag,
}


@pytest.mark.skipif(os.name != "posix", reason="asks for processes by POSIX")
@pytest.mark.parametrize("writer", WRITERS)
def test_what_a_killed_process_left_is_removed_by_the_next_writer(tmp_path: Path, writer: str) -> None:
    dying = subprocess.Popen(
        [
            *(sys.executable, "-c"),
            "import os, sys; from pathlib import Path; from codesign.ground.files import part_of\n"
            "parts = [part_of(Path(sys.argv[1], name)) for name in ('file', 'folder', 'n' * 99)]\n"
            "parts[0].touch(); parts[1].mkdir(); (parts[1] / 'copy').touch(); parts[2].touch()\n"
            "os.kill(os.getpid(), 9)",
            str(tmp_path),
        ]
    )
    dying.wait()
    left = list(tmp_path.iterdir())
    assert len(left) == 3
    dead, machine = str(dying.pid), left[0].name.split(".")[-2].partition("-")[0]
    names = [path.name for path in left]
    stay = {
        *(name.replace(dead, str(os.getppid())) for name in names),
        *(name.replace(machine, "0" * len(machine)) for name in names),
        *(name.removeprefix(".") for name in names),
        f"mine.{dead}.part",
        part_of(tmp_path / "own").name,
    }
    for name in stay:
        (tmp_path / name).touch()
    WRITERS[writer](tmp_path / "target")
    assert {path.name for path in tmp_path.iterdir()} == {*stay, "target"}


@pytest.mark.skipif(os.name != "posix", reason="folders are put on the disk by POSIX")
@pytest.mark.parametrize("writer", WRITERS)
def test_what_is_written_is_on_the_disk_before_it_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writer: str
) -> None:
    done: list[tuple[str, int]] = []
    sync, replace = os.fsync, os.rename

    def synced(descriptor: int) -> None:
        done.append(("on disk", os.fstat(descriptor).st_ino))
        sync(descriptor)

    def renamed(source: Any, target: Any, **more: Any) -> None:
        done.append(("renamed", os.stat(source).st_ino))
        replace(source, target, **more)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "rename", renamed)
    monkeypatch.setattr(os, "replace", renamed)
    target = tmp_path / "target"
    WRITERS[writer](target)
    for path in (target, *(target.rglob("*") if target.is_dir() else ())):
        assert done.index(("on disk", path.stat().st_ino)) < done.index(("renamed", target.stat().st_ino))
    assert done[-1] == ("on disk", tmp_path.stat().st_ino)


def of_another(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    owner = folder.stat().st_uid
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)


def open_to_others(folder: Path, _monkeypatch: pytest.MonkeyPatch) -> None:
    folder.chmod(0o777)


@pytest.mark.skipif(os.name != "posix", reason="owners and modes of POSIX")
@pytest.mark.parametrize("spoilt", [of_another, open_to_others])
def test_a_cache_that_others_may_write_to_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, spoilt: Callable[[Path, pytest.MonkeyPatch], None]
) -> None:
    root = tmp_path / "cache"
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(root))
    made: list[Path] = []
    for _ in range(2):
        with kept("kind", "digest", made.append) as folder, kept_trials() as (store, remark):
            assert folder.is_relative_to(root)
            assert not remark
            assert not isinstance(store, MemoryStore)
    assert len(made) == 1
    assert kept_folder("kind").stat().st_mode & 0o777 == 0o700
    spoilt(root, monkeypatch)
    with kept("kind", "digest", made.append) as folder, kept_trials() as (store, remark):
        assert not folder.is_relative_to(root)
        assert isinstance(store, MemoryStore)
        assert "another user owns the folder or may write to it" in remark
    assert len(made) == 2


def test_a_tool_leaves_nothing_in_the_folder_for_temporary_files(tmp_path: Path) -> None:
    tool = "import tempfile, os; print(tempfile.mkdtemp(), flush=True); os.kill(os.getpid(), 9)"
    finished = run([sys.executable, "-c", tool], tmp_path, seconds=60)
    assert finished.stdout
    assert not Path(finished.stdout.decode().strip()).exists()
    assert list(tmp_path.iterdir()) == []
    with scratch() as folder:
        (folder / "a").touch()
    assert not folder.exists()


def test_a_folder_that_is_replaced_outlives_an_interrupt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even one that removes all that is passing, between the two renames."""
    folder = tmp_path / "design"
    folder.mkdir()
    (folder / "mine.txt").write_text("mine")

    def interrupted(*_: Path) -> None:
        remove_passing()
        raise KeyboardInterrupt

    monkeypatch.setattr("codesign.ground.files.put", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_folder(folder, {"new.txt": b""})
    assert [each.name for each in tmp_path.iterdir()] == ["design"]
    assert (folder / "mine.txt").read_text() == "mine"
