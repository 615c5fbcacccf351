"""Where finished points are kept, so that an exploration can go on where it stopped.

One SQLite file holds the results of any number of studies. A result stands under the key of its point: a
digest over platform, workload, map, axis values and the code that computed it, so a result is found again
only where it would come out the same. The file is written by one process at a time; each group of points is
one transaction, so what was finished is there whatever happens next. After an orderly end it is a single
file that can be copied and read anywhere.

Every row carries a checksum: SQLite itself does not notice a flipped bit, and a wrong figure is worse than
none.
"""

from __future__ import annotations

import contextlib
import sqlite3
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import gettempdir

from codesign.errors import StoreError
from codesign.exploration.snapshot import UnsteadyError, connected_copy, written_here
from codesign.exploration.store import MOST_COMPUTATIONS, Batch, Entry, EntryState

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
            exist. It is copied (see ``snapshot``), so nothing in its folder changes.

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
        """Whether any point that was simulated by itself is kept."""
        with self._reported_faults():
            return self._connection.execute("SELECT 1 FROM point LIMIT 1").fetchone() is not None

    def computations(self) -> dict[str, str]:
        """Every computation, up to ``MOST_COMPUTATIONS`` bytes of them, by digest."""
        found: dict[str, str] = {}
        left = MOST_COMPUTATIONS
        with self._reported_faults():
            for key, text, checksum in self._connection.execute(
                "SELECT key, text, checksum FROM computation"
            ):
                self._check_row(checksum, key, text)
                left -= len(text)
                if left < 0:
                    break
                found[key] = text
        return found

    def put(self, batch: Batch) -> None:
        """Keep all of a batch or nothing; what stands under the same key is replaced."""
        entries = [
            (e.key, e.state.value, e.text, _checksum(e.key, e.state.value, e.text)) for e in batch.entries
        ]
        blocks = [
            (key, data, zlib.crc32(data, zlib.crc32(key.encode()))) for key, data in batch.blocks.items()
        ]
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
            self._connection.execute(
                "INSERT INTO study (key, definition, plan, checksum) VALUES (?, ?, ?, ?)", row
            )

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
        tables = {
            name
            for (name,) in self._connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
        }
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
            raise StoreError(
                what, str(self.path), "make it readable, and room for the copy: see TMPDIR"
            ) from fault
        except UnicodeError as fault:
            raise StoreError("is damaged: a text in it is none", str(self.path), _OURS) from fault


def _message_of(fault: sqlite3.Error) -> tuple[str, str]:
    code = getattr(fault, "sqlite_errorcode", 0) & 0xFF
    messages = {
        sqlite3.SQLITE_BUSY: ("is in use by another run", "wait for it to end, or give another file name"),
        sqlite3.SQLITE_READONLY: ("cannot be written", "give a file name where you may write"),
        sqlite3.SQLITE_CANTOPEN: ("cannot be opened", "give a file name where you may write"),
        sqlite3.SQLITE_PERM: ("cannot be opened", "give a file name where you may write"),
        sqlite3.SQLITE_FULL: (
            "cannot be written: the disk is full",
            "make room and run again: it goes on from there",
        ),
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
