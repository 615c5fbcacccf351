"""The store of an exploration: entries, blocks and computations by key, and the definitions of studies.

A store lasts as long as the process, or is one SQLite file that holds the results of any number of studies. An
exploration goes on there where it stopped. A result stands under the key of its point: a digest over platform,
workload, map, axis values and the code that computed it, so a result is found again only where it would come out the
same. The file is written by one process at a time; each group of points is one transaction, so what was finished is
there whatever happens next. After an orderly end it is a single file that can be copied and read anywhere. Every row
carries a checksum: SQLite itself does not notice a flipped bit, and a wrong figure is worse than none.

A reader works on a private copy, so that reading leaves nothing behind and locks nothing. SQLite itself writes when it
reads: beside a file in write-ahead logging it makes ``FILE-shm``, it plays back what a killed process left, and it
locks the file, so that a run that begins meanwhile is refused. The database may be written to while it is copied, by a
process that logs ahead. It is copied first, then the log. A page that a checkpoint moves into the database meanwhile
stands in the log as well, and the log counts when the copy is opened. Only a log that was begun anew in between lacks
such pages. Its header then differs (by its two salts), and the copy is made again.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sqlite3
import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from tempfile import gettempdir
from typing import Protocol

from codesign.ground.errors import StoreError
from codesign.ground.files import landing, scratch

MOST_COMPUTATIONS = 2**26
"""Bytes of computations that are read at once: each worker gets them."""


class EntryState(StrEnum):
    """The way in which the computation of a point ended."""

    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True)
class Entry:
    """A point that was computed.

    Attributes:
        key: of its ``DesignPoint``.
        state: done, or failed where the computation raised.
        text: the result as JSON; the message where it failed.
    """

    key: str
    state: EntryState
    text: str


@dataclass(frozen=True)
class Batch:
    """The outcomes that are kept together, all of them or none.

    - ``entries``: of points that were simulated by themselves.
    - ``blocks``: outcomes of points that compute the same, by key (``blocks.block_of``).
    - ``computations``: what they compute, as JSON by digest.
    """

    entries: Sequence[Entry] = ()
    blocks: Mapping[str, bytes] = field(default_factory=dict)
    computations: Mapping[str, str] = field(default_factory=dict)


class Store(Protocol):
    """The outcomes that were computed, by key, and the definitions of the studies that they were computed for."""

    def find(self, keys: Sequence[str]) -> dict[str, Entry]:
        """The entries there are under ``keys``."""

    def blocks(self, keys: Sequence[str]) -> Iterator[tuple[str, bytes]]:
        """The blocks there are under ``keys``, one by one."""

    def has_entries(self) -> bool:
        """True if any point that was simulated by itself is kept."""

    def computations(self) -> dict[str, str]:
        """Every computation, up to ``MOST_COMPUTATIONS`` bytes of them, by digest."""

    def put(self, batch: Batch) -> None:
        """Keep all of a batch or nothing; what stands under the same key is replaced."""

    def begin(self, key: str, definition: str, plan: bytes = b"") -> None:
        """Note a study: what ``latest`` gives from now on. The same study again is noted anew, not twice.

        ``plan``: which points compute the same (``blocks.plan_of``).
        """

    def latest(self) -> tuple[str, bytes] | None:
        """The definition and the plan of the study noted last, or None."""

    def plan(self, key: str) -> bytes:
        """The plan of the study noted under a key; empty where there is none."""

    def close(self) -> None:
        """Let go of the file; may be called twice."""


class MemoryStore:
    """A store that lasts as long as the process."""

    def __init__(self) -> None:
        self._entries: dict[str, Entry] = {}
        self._blocks: dict[str, bytes] = {}
        self._computations: dict[str, str] = {}
        self._studies: dict[str, tuple[str, bytes]] = {}

    def find(self, keys: Sequence[str]) -> dict[str, Entry]:
        """The entries there are under ``keys``."""
        return {key: self._entries[key] for key in keys if key in self._entries}

    def blocks(self, keys: Sequence[str]) -> Iterator[tuple[str, bytes]]:
        """The blocks there are under ``keys``."""
        yield from ((key, self._blocks[key]) for key in keys if key in self._blocks)

    def has_entries(self) -> bool:
        """True if any entry is kept."""
        return bool(self._entries)

    def computations(self) -> dict[str, str]:
        """Every computation."""
        return dict(self._computations)

    def put(self, batch: Batch) -> None:
        """Keep all of a batch."""
        self._entries.update({entry.key: entry for entry in batch.entries})
        self._blocks.update(batch.blocks)
        self._computations.update(batch.computations)

    def begin(self, key: str, definition: str, plan: bytes = b"") -> None:
        """Note a study."""
        self._studies.pop(key, None)
        self._studies[key] = definition, plan

    def latest(self) -> tuple[str, bytes] | None:
        """The definition and the plan of the study noted last, or None."""
        return next(reversed(self._studies.values()), None)

    def plan(self, key: str) -> bytes:
        """The plan of a study."""
        return self._studies.get(key, ("", b""))[1]

    def close(self) -> None:
        """Nothing to let go of."""


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
    """Leave the locks of the database at ``path`` alone when it is copied, while this process writes it. It exists."""
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
    """The marks that stay as they are between two looks unless a copy made between them may hold half of a change."""
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


SCHEMA = 4
"""The format of the tables and of all that stands in them: definitions, plans, blocks, computations, searches."""

_APPLICATION = int.from_bytes(b"HwSw", "big")
_KEYS_A_QUERY = 500
_OURS = "name a file that hwsw explore wrote; to explore anew, name a file that does not exist"

_TABLES = (
    """CREATE TABLE study (
        number INTEGER PRIMARY KEY,
        key TEXT NOT NULL UNIQUE,
        definition TEXT NOT NULL,
        plan BLOB NOT NULL,
        checksum INTEGER NOT NULL)""",
    """CREATE TABLE point (
        key TEXT PRIMARY KEY,
        state TEXT NOT NULL,
        text TEXT NOT NULL,
        checksum INTEGER NOT NULL) WITHOUT ROWID""",
    """CREATE TABLE block (
        key TEXT PRIMARY KEY,
        data BLOB NOT NULL,
        checksum INTEGER NOT NULL)""",
    """CREATE TABLE computation (
        key TEXT PRIMARY KEY,
        text TEXT NOT NULL,
        checksum INTEGER NOT NULL)""",
)


class FileStore:
    """A store in one SQLite file.

    Args:
        path: made if there is none; its folder must exist.
        read_only: for a look at what was committed when it was opened, beside a run that goes on as well; the file must
            exist. It is copied, so nothing in its folder changes.

    Raises:
        StoreError: the file cannot be opened, is in use by another run, is none of ours, is damaged, or was
            written by a newer version. Every method may raise it.
    """

    def __init__(self, path: Path | str, *, read_only: bool = False) -> None:
        self.path = Path(path)
        self.read_only = read_only
        self._check_place()
        self._held = contextlib.ExitStack()
        try:
            with self._reported_faults():
                self._connection = self._held.enter_context(self._connected())
                self._open()
                if not read_only:
                    self._held.enter_context(written_here(self.path))
        except BaseException:
            self._held.close()
            raise

    def find(self, keys: Sequence[str]) -> dict[str, Entry]:
        """The entries there are under ``keys``."""
        entries: dict[str, Entry] = {}
        with self._reported_faults():
            for begin in range(0, len(keys), _KEYS_A_QUERY):
                some = keys[begin : begin + _KEYS_A_QUERY]
                marks = ",".join("?" * len(some))
                query = f"SELECT key, state, text, checksum FROM point WHERE key IN ({marks})"
                for key, state, text, checksum in self._connection.execute(query, some):
                    self._check_row(checksum, key, state, text)
                    entries[key] = Entry(key, self._state(state), text)
        return entries

    def blocks(self, keys: Sequence[str]) -> Iterator[tuple[str, bytes]]:
        """The blocks there are under ``keys``, one by one."""
        query = "SELECT data, checksum FROM block WHERE key = ?"
        for key in keys:
            with self._reported_faults():
                row = self._connection.execute(query, (key,)).fetchone()
                if row is None:
                    continue
                data, checksum = row
                if not isinstance(data, bytes) or checksum != zlib.crc32(data, zlib.crc32(key.encode())):
                    raise self._damaged()
            yield key, data

    def has_entries(self) -> bool:
        """True if any point that was simulated by itself is kept."""
        with self._reported_faults():
            return self._connection.execute("SELECT 1 FROM point LIMIT 1").fetchone() is not None

    def computations(self) -> dict[str, str]:
        """Every computation, up to ``MOST_COMPUTATIONS`` bytes of them, by digest."""
        found: dict[str, str] = {}
        left = MOST_COMPUTATIONS
        with self._reported_faults():
            for key, text, checksum in self._connection.execute("SELECT key, text, checksum FROM computation"):
                self._check_row(checksum, key, text)
                left -= len(text)
                if left < 0:
                    break
                found[key] = text
        return found

    def put(self, batch: Batch) -> None:
        """Keep all of a batch or nothing; what stands under the same key is replaced."""
        entries = [(e.key, e.state.value, e.text, _checksum(e.key, e.state.value, e.text)) for e in batch.entries]
        blocks = [(key, data, zlib.crc32(data, zlib.crc32(key.encode()))) for key, data in batch.blocks.items()]
        computations = [(key, text, _checksum(key, text)) for key, text in batch.computations.items()]
        with self._reported_faults(), self._transaction():
            self._connection.executemany("INSERT OR REPLACE INTO point VALUES (?, ?, ?, ?)", entries)
            self._connection.executemany("INSERT OR REPLACE INTO block VALUES (?, ?, ?)", blocks)
            self._connection.executemany("INSERT OR REPLACE INTO computation VALUES (?, ?, ?)", computations)

    def begin(self, key: str, definition: str, plan: bytes = b"") -> None:
        """Note a study: what ``latest`` gives from now on."""
        row = (key, definition, plan, zlib.crc32(plan, _checksum(key, definition)))
        with self._reported_faults(), self._transaction():
            self._connection.execute("DELETE FROM study WHERE key = ?", (key,))
            self._connection.execute("INSERT INTO study (key, definition, plan, checksum) VALUES (?, ?, ?, ?)", row)

    def latest(self) -> tuple[str, bytes] | None:
        """The definition and the plan of the study noted last, or None."""
        return self._study("ORDER BY number DESC LIMIT 1")

    def plan(self, key: str) -> bytes:
        """The plan of the study noted under a key; empty where there is none."""
        study = self._study("WHERE key = ?", key)
        return b"" if study is None else study[1]

    def _study(self, which: str, *values: str) -> tuple[str, bytes] | None:
        with self._reported_faults():
            query = f"SELECT key, definition, plan, checksum FROM study {which}"
            row = self._connection.execute(query, values).fetchone()
        if row is None:
            return None
        key, definition, plan, checksum = row
        texts = isinstance(key, str) and isinstance(definition, str) and isinstance(plan, bytes)
        if not texts or checksum != zlib.crc32(plan, _checksum(key, definition)):
            raise self._damaged()
        return definition, plan

    def close(self) -> None:
        """Let go of the file, and leave it as a single one."""
        with contextlib.suppress(sqlite3.Error):
            if not self.read_only:
                # Out of write-ahead logging: a reader then needs no more than the file, not even a writable
                # folder.
                self._connection.execute("PRAGMA journal_mode = DELETE")
        # The connection first: closing what ``written_here`` kept would drop its locks.
        self._connection.close()
        self._held.close()

    def __enter__(self) -> FileStore:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check_place(self) -> None:
        if self.path.is_dir():
            raise StoreError("is a folder, not a file", str(self.path), "give the name of a file")
        if self.read_only and not self.path.exists():
            raise StoreError("no such file", str(self.path), "hwsw explore makes one")
        if self.path.exists() and not self.path.is_file():
            # A FIFO or a device would keep SQLite waiting, or give it what is no database.
            raise StoreError("is not a regular file", str(self.path), "give the name of a file")
        if not self.path.parent.is_dir():
            raise StoreError(f"there is no folder {self.path.parent}", str(self.path), "make it first")

    def _connected(self) -> contextlib.AbstractContextManager[sqlite3.Connection]:
        if self.read_only:
            return connected_copy(self.path)
        uri = f"{self.path.absolute().as_uri()}?mode=rwc"
        return contextlib.closing(sqlite3.connect(uri, uri=True, timeout=0.5, isolation_level=None))

    def _open(self) -> None:
        # Before the first access: from then on the file is locked, and a second run fails at once.
        if not self.read_only:
            self._connection.execute("PRAGMA locking_mode = EXCLUSIVE")
        application = self._number("application_id")
        version = self._number("user_version")
        objects = self._connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
        if application != _APPLICATION and (objects or application or self.read_only):
            raise StoreError("is not a file of explored points", str(self.path), _OURS)
        if application == _APPLICATION and version != SCHEMA:
            raise StoreError(
                f"was written in format {version}, and this version reads format {SCHEMA}",
                str(self.path),
                "give another file name: its points are computed again"
                if version < SCHEMA
                else "update hwsw-codesign, or give another file name",
            )
        if not self.read_only:
            self._connection.execute("PRAGMA journal_mode = WAL")
            with self._transaction():
                if application != _APPLICATION:
                    for table in _TABLES:
                        self._connection.execute(table)
                    self._connection.execute(f"PRAGMA application_id = {_APPLICATION}")
                    self._connection.execute(f"PRAGMA user_version = {SCHEMA}")
        tables = {name for (name,) in self._connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        if not {"study", "point", "block", "computation"} <= tables:
            raise StoreError("is damaged: its tables are missing", str(self.path), _OURS)

    def _number(self, pragma: str) -> int:
        return int(self._connection.execute(f"PRAGMA {pragma}").fetchone()[0])

    def _check_row(self, checksum: object, *texts: object) -> None:
        if not all(isinstance(text, str) for text in texts) or checksum != _checksum(*map(str, texts)):
            raise self._damaged()

    def _damaged(self) -> StoreError:
        return StoreError("is damaged: a row does not match its checksum", str(self.path), _OURS)

    def _state(self, word: str) -> EntryState:
        try:
            return EntryState(word)
        except ValueError:
            text = f"holds a point in state {word!r:.40}, which is none of {', '.join(EntryState)}"
            raise StoreError(text, str(self.path), _OURS) from None

    @contextlib.contextmanager
    def _transaction(self) -> Iterator[None]:
        self._connection.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            self._connection.rollback()
            raise
        self._connection.commit()

    @contextlib.contextmanager
    def _reported_faults(self) -> Iterator[None]:
        """Faults of SQLite and of the file as errors for the user."""
        try:
            yield
        except sqlite3.Error as fault:
            what, hint = _message_of(fault)
            raise StoreError(what, str(self.path), hint) from fault
        except UnsteadyError as fault:
            raise StoreError(str(fault), str(self.path), "try again when less is written to it") from fault
        except OSError as fault:
            what = f"cannot be read through a copy in {gettempdir()}: {fault.strerror or fault}"
            raise StoreError(what, str(self.path), "make it readable, and room for the copy: see TMPDIR") from fault
        except UnicodeError as fault:
            raise StoreError("is damaged: a text in it is none", str(self.path), _OURS) from fault


def _message_of(fault: sqlite3.Error) -> tuple[str, str]:
    code = getattr(fault, "sqlite_errorcode", 0) & 0xFF
    messages = {
        sqlite3.SQLITE_BUSY: ("is in use by another run", "wait for it to end, or give another file name"),
        sqlite3.SQLITE_READONLY: ("cannot be written", "give a file name where you may write"),
        sqlite3.SQLITE_CANTOPEN: ("cannot be opened", "give a file name where you may write"),
        sqlite3.SQLITE_PERM: ("cannot be opened", "give a file name where you may write"),
        sqlite3.SQLITE_FULL: ("cannot be written: the disk is full", "make room and run again: it goes on from there"),
        sqlite3.SQLITE_IOERR: (
            f"cannot be read or written: {fault}",
            "look at the disk and the limit of file sizes (ulimit -f), and run again: it goes on from there",
        ),
        sqlite3.SQLITE_NOTADB: ("is not a file of explored points", _OURS),
        sqlite3.SQLITE_CORRUPT: ("is damaged", _OURS),
    }
    # Without a code, or with that of a wrong statement: a text is none, or a table has other columns.
    damaged = code in (0, sqlite3.SQLITE_ERROR)
    return messages.get(code, (f"{'is damaged' if damaged else 'cannot be used'}: {fault}", _OURS))


def _checksum(*texts: str) -> int:
    return zlib.crc32("\0".join(texts).encode("utf-8", "surrogatepass"))
