"""Files written whole or not at all, and nothing destroyed that is no file of the user's making."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from codesign.errors import RunError

_passing: set[Path] = set()


@contextmanager
def passing(path: Path) -> Iterator[Path]:
    """A temporary file or folder of this process: removed at the end of the block if it is still there."""
    _passing.add(path)
    try:
        yield path
    finally:
        _remove(path)
        _passing.discard(path)


def remove_passing() -> None:
    """Remove all that is ``passing`` now: for a process that must end without unwinding."""
    for path in list(_passing):
        _remove(path)


def _remove(path: Path) -> None:
    with suppress(OSError):
        path.unlink()
    shutil.rmtree(path, ignore_errors=True)


def landing(path: Path) -> Path:
    """The file that a write to ``path`` is meant for: where its symbolic links end, there or not yet there."""
    return Path(os.path.realpath(path))


def is_stream(path: Path) -> bool:
    """Whether a FIFO or a character device stands at ``path``: something to write to, never to replace."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    return stat.S_ISFIFO(mode) or stat.S_ISCHR(mode)


def is_special(path: Path) -> bool:
    """Whether something other than a regular file stands at ``path``: a folder, device, FIFO or socket."""
    try:
        return not stat.S_ISREG(path.stat().st_mode)
    except (OSError, ValueError):
        return False


def write_atomically(path: Path, content: bytes) -> None:
    """Write ``content`` beside ``path`` and put it in its place at once; what stood there stays until then.

    A symbolic link is followed, and stays. To a FIFO or a character device the content is written as it is.

    Raises:
        RunError: the folder is missing or cannot be written to, the disk is full, or ``path`` is a folder, a
            socket or a disk.
    """
    if is_stream(path):
        _write_through(path, content)
        return
    if is_special(path):
        raise RunError("cannot write: is no regular file", str(path), "name a file")
    target = landing(path)
    try:
        # Of the name only so much that no file system finds the longer one too long.
        handle, name = tempfile.mkstemp(prefix=f".{target.name[:16]}.", suffix=".part", dir=target.parent)
    except (OSError, ValueError) as error:
        raise RunError(
            f"cannot write: {_reason(error)}",
            str(path),
            "name a file in a folder that is there and can be written to",
        ) from error
    with passing(Path(name)) as part:
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            part.chmod(_mode_of(target))
            part.replace(target)
        except OSError as error:
            raise RunError(
                f"cannot write: {_reason(error)}", str(path), "free some space, or name another file"
            ) from error


def _write_through(path: Path, content: bytes) -> None:
    try:
        with path.open("wb") as file:
            file.write(content)
    except OSError as error:
        raise RunError(f"cannot write: {_reason(error)}", str(path), "name a file") from error


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


def _mode_of(target: Path) -> int:
    # mkstemp gives 0o600; a report should be as readable as the file it replaces, or any file its user writes.
    try:
        return stat.S_IMODE(target.stat().st_mode)
    except OSError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask
