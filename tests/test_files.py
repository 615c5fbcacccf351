"""Files are written whole, through links and into pipes."""

from __future__ import annotations

import errno
import os
import threading
from pathlib import Path

import pytest

from codesign.errors import RunError
from codesign.files import passing, remove_passing, write_atomically, written_atomically


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
