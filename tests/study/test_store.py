from __future__ import annotations

import contextlib
import multiprocessing
import os
import random
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from codesign.ground.errors import StoreError
from codesign.study.store import SCHEMA, Batch, Entry, EntryState, FileStore, MemoryStore, Store

DONE = Entry("a" * 64, EntryState.DONE, '{"feasible": true}')
FAILED = Entry("b" * 64, EntryState.FAILED, "ZeroDivisionError: µ\n\0")
BLOCKS = {"d" * 64: bytes(range(256)), "e" * 64: b""}
COMPUTATIONS = {"f" * 64: '{"feasible": "µ"}'}


class Contract:
    """What every store does."""

    @pytest.fixture
    def store(self) -> Store:
        raise NotImplementedError

    def test_finds_what_was_put_and_nothing_else(self, store: Store) -> None:
        store.put(Batch([DONE, FAILED]))
        assert store.find([DONE.key, "c" * 64]) == {DONE.key: DONE}
        assert store.find([]) == {}
        assert store.find([FAILED.key, DONE.key]) == {DONE.key: DONE, FAILED.key: FAILED}

    def test_blocks_and_computations(self, store: Store) -> None:
        assert not store.has_entries()
        assert store.computations() == {}
        store.put(Batch(blocks=BLOCKS, computations=COMPUTATIONS))
        assert not store.has_entries()
        assert dict(store.blocks([*BLOCKS, "a" * 64])) == BLOCKS
        assert store.computations() == COMPUTATIONS
        store.put(Batch([DONE], {"d" * 64: b"other"}))
        assert store.has_entries()
        assert dict(store.blocks(["d" * 64])) == {"d" * 64: b"other"}

    def test_finds_many(self, store: Store) -> None:
        entries = [Entry(f"{index:064x}", EntryState.DONE, str(index)) for index in range(2500)]
        store.put(Batch(entries))
        assert store.find([entry.key for entry in entries]) == {entry.key: entry for entry in entries}

    def test_the_later_entry_counts(self, store: Store) -> None:
        store.put(Batch([Entry(DONE.key, EntryState.FAILED, "once")]))
        store.put(Batch([DONE]))
        assert store.find([DONE.key]) == {DONE.key: DONE}

    def test_all_or_nothing(self, store: Store) -> None:
        def entries() -> Iterator[Entry]:
            yield DONE
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            store.put(Batch(entries()))  # type: ignore[arg-type]
        assert store.find([DONE.key]) == {}
        store.put(Batch([FAILED]))
        assert store.find([FAILED.key]) == {FAILED.key: FAILED}

    def test_the_study_noted_last(self, store: Store) -> None:
        assert store.latest() is None
        for key in ("one", "two", "one"):
            store.begin(key, f"definition of {key}")
        assert store.latest() == ("definition of one", b"")


class TestMemoryStore(Contract):
    @pytest.fixture
    def store(self) -> Store:
        return MemoryStore()


class TestFileStore(Contract):
    @pytest.fixture
    def store(self, tmp_path: Path) -> Iterator[Store]:
        with FileStore(tmp_path / "a # strange ? name %41.sqlite") as store:
            yield store


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("store") / "points.sqlite"
    with FileStore(path) as store:
        store.begin("study", "definition", b"plan")
        store.put(Batch([DONE, FAILED], BLOCKS, COMPUTATIONS))
    return path.read_bytes()


@pytest.fixture
def file(tmp_path: Path, written: bytes) -> Path:
    path = tmp_path / "points.sqlite"
    path.write_bytes(written)
    return path


def test_what_was_put_is_there_the_next_time(file: Path) -> None:
    for read_only in (False, True):
        with FileStore(file, read_only=read_only) as store:
            assert store.find([DONE.key, FAILED.key]) == {DONE.key: DONE, FAILED.key: FAILED}
            assert store.latest() == ("definition", b"plan")


def test_one_file_is_left_by_a_store_that_is_closed_twice(tmp_path: Path) -> None:
    with FileStore(tmp_path / "points.sqlite") as store:
        store.put(Batch([DONE]))
        store.close()
    assert os.listdir(tmp_path) == ["points.sqlite"]


def die_after_put(path: Path) -> None:
    store = FileStore(path)
    store.put(Batch([DONE]))
    os._exit(1)


def test_what_was_put_survives_a_process_that_dies(tmp_path: Path) -> None:
    path = tmp_path / "points.sqlite"
    process = multiprocessing.get_context("spawn").Process(target=die_after_put, args=(path,))
    process.start()
    process.join()
    assert process.exitcode == 1
    with FileStore(path) as store:
        assert store.find([DONE.key]) == {DONE.key: DONE}


def test_a_second_process_is_told(file: Path) -> None:
    with FileStore(file), pytest.raises(StoreError, match="in use by another run") as caught:
        FileStore(file)
    assert caught.value.where == str(file)
    assert caught.value.hint is not None


def test_reading_leaves_the_file_as_it_is(file: Path) -> None:
    before = file.read_bytes()
    with FileStore(file, read_only=True) as store:
        store.find([DONE.key])
        with pytest.raises(StoreError, match="cannot be written"):
            store.put(Batch([DONE]))
    assert file.read_bytes() == before


def refusal(path: Path, *, read_only: bool = False) -> str:
    with pytest.raises(StoreError) as caught:
        FileStore(path, read_only=read_only)
    assert caught.value.where == str(path)
    assert caught.value.hint
    return caught.value.what


@pytest.mark.parametrize("read_only", [False, True])
def test_files_of_others_are_refused_and_left_alone(tmp_path: Path, read_only: bool) -> None:
    text = tmp_path / "notes.txt"
    text.write_text("not a database at all, but long enough to look at " * 40)
    other = tmp_path / "other.sqlite"
    with sqlite3.connect(other) as connection:
        connection.execute("CREATE TABLE point (a)")
    connection.close()
    for path in (text, other):
        before = path.read_bytes()
        assert "is not a file of explored points" in refusal(path, read_only=read_only)
        assert path.read_bytes() == before
    assert sorted(os.listdir(tmp_path)) == ["notes.txt", "other.sqlite"]


def test_places_where_no_file_can_be(tmp_path: Path) -> None:
    assert "folder" in refusal(tmp_path)
    assert "no folder" in refusal(tmp_path / "none" / "points.sqlite")
    assert "no such file" in refusal(tmp_path / "points.sqlite", read_only=True)
    assert not (tmp_path / "points.sqlite").exists()
    (tmp_path / "empty.sqlite").touch()
    assert "not a file of explored points" in refusal(tmp_path / "empty.sqlite", read_only=True)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="nothing is read-only to the superuser")
def test_a_file_that_may_not_be_written(file: Path) -> None:
    file.chmod(0o400)
    assert "cannot be" in refusal(file)


def test_an_empty_file_becomes_a_store(tmp_path: Path) -> None:
    path = tmp_path / "points.sqlite"
    path.touch()
    with FileStore(path) as store:
        store.put(Batch([DONE]))
        assert store.find([DONE.key]) == {DONE.key: DONE}


def test_a_newer_format_is_named(file: Path) -> None:
    with sqlite3.connect(file) as connection:
        connection.execute(f"PRAGMA user_version = {SCHEMA + 1}")
    connection.close()
    assert f"format {SCHEMA + 1}" in refusal(file)
    with pytest.raises(StoreError, match="update hwsw-codesign"):
        FileStore(file)


def test_of_an_older_format_the_points_are_computed_again(file: Path) -> None:
    with sqlite3.connect(file) as connection:
        connection.execute(f"PRAGMA user_version = {SCHEMA - 1}")
    connection.close()
    assert f"was written in format {SCHEMA - 1}, and this version reads format {SCHEMA}" in refusal(file)
    with pytest.raises(StoreError, match="give another file name: its points are computed again"):
        FileStore(file)


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE point SET text = replace(text, 'true', 'false')",
        "UPDATE point SET state = 'failed'",
        "UPDATE point SET text = 7",
        "UPDATE point SET text = x'ff'",
        "UPDATE point SET checksum = 'none'",
    ],
)
def test_a_row_that_was_tampered_with_is_refused(file: Path, change: str) -> None:
    with sqlite3.connect(file) as connection:
        connection.execute(change)
    connection.close()
    with FileStore(file) as store, pytest.raises(StoreError, match="damaged"):
        store.find([DONE.key])


@pytest.mark.parametrize(
    "change", ["data = x'00'", "data = 'text'", "data = NULL || data", "checksum = 7", "key = 'dd'"]
)
def test_a_block_that_was_tampered_with_is_refused(file: Path, change: str) -> None:
    with sqlite3.connect(file) as connection, contextlib.suppress(sqlite3.IntegrityError):
        connection.execute(f"UPDATE block SET {change} WHERE key LIKE 'd%'")
    connection.close()
    with FileStore(file) as store:
        if "NULL" in change:
            assert dict(store.blocks([*BLOCKS])) == BLOCKS, "NOT NULL refuses it"
            return
        with pytest.raises(StoreError, match="damaged"):
            dict(store.blocks([*BLOCKS, "dd"]))


@pytest.mark.parametrize("change", ["text = '{}'", "text = x'ff'", "checksum = 'none'", "key = 'other'"])
def test_a_computation_that_was_tampered_with_is_refused(file: Path, change: str) -> None:
    with sqlite3.connect(file) as connection:
        connection.execute(f"UPDATE computation SET {change}")
    connection.close()
    with FileStore(file) as store, pytest.raises(StoreError, match="damaged"):
        store.computations()


@pytest.mark.parametrize("change", ["definition = 'other'", "plan = x'00'", "plan = 'plan'"])
def test_a_study_that_was_tampered_with_is_refused(file: Path, change: str) -> None:
    with sqlite3.connect(file) as connection:
        connection.execute(f"UPDATE study SET {change}")
    connection.close()
    with FileStore(file, read_only=True) as store, pytest.raises(StoreError, match="damaged"):
        store.latest()


@pytest.mark.parametrize("seed", range(150))
def test_whatever_happens_to_the_bytes_no_wrong_entry_comes_out(file: Path, seed: int) -> None:
    chance = random.Random(seed)
    content = bytearray(file.read_bytes())
    if seed % 5 == 0:
        content = content[: chance.randrange(len(content))]
    for _ in range(chance.choice([1, 1, 2, 30])):
        if content:
            content[chance.randrange(len(content))] = chance.randrange(256)
    file.write_bytes(content)
    truth = {DONE.key: DONE, FAILED.key: FAILED}
    try:
        with FileStore(file, read_only=seed % 2 == 0) as store:
            found = store.find([DONE.key, FAILED.key, "c" * 64])
            latest = store.latest()
            blocks = dict(store.blocks(list(BLOCKS)))
            computations = store.computations()
    except StoreError:
        return
    assert found.items() <= truth.items()
    assert blocks.items() <= BLOCKS.items()
    assert computations.items() <= COMPUTATIONS.items()
    assert latest in (None, ("definition", b"plan"))


def test_what_is_no_regular_file_is_no_store(tmp_path: Path) -> None:
    fifo = tmp_path / "points.sqlite"
    os.mkfifo(fifo)
    for read_only in (True, False):
        with pytest.raises(StoreError, match="not a regular file"):
            FileStore(fifo, read_only=read_only)
