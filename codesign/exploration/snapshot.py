"""A private copy of an SQLite database, so that reading it leaves nothing behind and locks nothing.

SQLite itself writes when it reads: beside a file in write-ahead logging it makes ``FILE-shm``, it plays back what a
killed process left, and it locks the file, so that a run that begins meanwhile is refused. So the files are copied,
and SQLite works on the copy.

The database may be written to meanwhile, by a process that logs ahead. The database is copied first, then the log. A
page that a checkpoint moves into the database while it is copied stands in the log as well, and the log counts when the
copy is opened. Only a log that was begun anew in between lacks such pages. Its header then differs (by its two salts),
and the copy is made again.
"""

from __future__ import annotations

import os
import shutil
import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from codesign.files import landing, scratch

_TRIES = 50
_SECONDS_BETWEEN = 0.02
_AT_ONCE = 2**20
_DATABASE_HEADER = 100
_LOG_HEADER = 32

_written: dict[tuple[int, int], list[int]] = {}
"""Files that this process writes through SQLite, by (device, inode), each with the descriptors kept open for it.

POSIX drops all locks that a process has on a file when it closes any descriptor of it.
"""


class UnsteadyError(OSError):
    """The database changed all the time while it was copied."""


@contextmanager
def written_here(path: Path) -> Iterator[None]:
    """While this process writes the database at ``path``, which exists, copying it leaves its locks alone."""
    place = _place(os.stat(path))
    descriptors = _written.setdefault(place, [])
    try:
        yield
    finally:
        _written.pop(place, None)
        for descriptor in descriptors:
            os.close(descriptor)


@contextmanager
def connected_copy(path: Path) -> Iterator[sqlite3.Connection]:
    """A connection to a copy of the database at ``path`` as it was last committed; both end with the block.

    Raises:
        OSError: the files cannot be read, or there is no room for the copy. UnsteadyError: they never stood still.
        sqlite3.Error: what was copied is no database.
    """
    with scratch() as folder:
        copy = folder / "copy"
        _copy_steady(landing(path), copy)
        with closing(sqlite3.connect(copy, isolation_level=None)) as connection:
            # Exclusive: the index of the log stands in memory. The mode: the log is merged into the copy now.
            connection.execute("PRAGMA locking_mode = EXCLUSIVE")
            connection.execute("PRAGMA journal_mode = DELETE").fetchall()
            connection.execute("PRAGMA query_only = ON")
            # Where an open file can do without its name, no killed process leaves the copy behind.
            shutil.rmtree(folder, ignore_errors=True)
            yield connection


def _copy_steady(source: Path, copy: Path) -> None:
    for _ in range(_TRIES):
        before = _marks(source)
        for suffix in ("", "-wal", "-journal"):
            _copy(Path(f"{source}{suffix}"), Path(f"{copy}{suffix}"), needed=not suffix)
        if _marks(source) == before:
            return
        time.sleep(_SECONDS_BETWEEN)
    raise UnsteadyError("changed all the time while it was read")


def _marks(source: Path) -> tuple[object, ...]:
    """What stays as it is between two looks unless a copy made between them may hold half of a change."""
    log = _head(Path(f"{source}-wal"), _LOG_HEADER)
    journal = _head(Path(f"{source}-journal"), _DATABASE_HEADER)
    status = os.stat(source)
    if log:
        return log, journal, _place(status)
    head = _head(source, _DATABASE_HEADER)
    return log, journal, _place(status), status.st_size, status.st_mtime_ns, head


def _head(path: Path, count: int) -> bytes:
    try:
        descriptor = os.open(path, _READING)
    except FileNotFoundError:
        return b""
    try:
        return os.read(descriptor, count)
    finally:
        _let_go(descriptor)


def _copy(source: Path, copy: Path, *, needed: bool) -> None:
    copy.unlink(missing_ok=True)
    try:
        descriptor = os.open(source, _READING)
    except FileNotFoundError:
        if needed:
            raise
        return
    try:
        with copy.open("wb") as file:
            while content := os.read(descriptor, _AT_ONCE):
                file.write(content)
    finally:
        _let_go(descriptor)


def _let_go(descriptor: int) -> None:
    """Close the descriptor, at once or when this process is done writing the file."""
    kept = _written.get(_place(os.fstat(descriptor)))
    if kept is None:
        os.close(descriptor)
    else:
        kept.append(descriptor)


def _place(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino


_READING = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
