"""Reading a store gives all that was committed and leaves the folder as it found it, whoever writes or wrote there."""

import multiprocessing
import os
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from explore_fakes import Fake

import codesign
from codesign.ground.errors import StoreError
from codesign.inputs import Exploration
from codesign.study import Progress, explore, load_study
from codesign.study.store import Batch, Entry, EntryState, FileStore

COUNTS = [0, 1, 2500]
WRITER = """
import sys
from codesign.study.store import FileStore
from codesign.study.store import Batch, Entry, EntryState
store = FileStore(sys.argv[1])
store.begin("study", "definition")
for index in range(int(sys.argv[2])):
    store.put(Batch([Entry(f"{index:064x}", EntryState.DONE, f"{index} " * 50)]))
print("written", flush=True)
sys.stdin.read()
store.close()
"""


def entries(count: int) -> dict[str, Entry]:
    every = (Entry(f"{index:064x}", EntryState.DONE, f"{index} " * 50) for index in range(count))
    return {entry.key: entry for entry in every}


def state_of(folder: Path) -> dict[str, tuple[bytes, int, int]]:
    found = {path.name: (path.read_bytes(), path.stat()) for path in sorted(folder.iterdir())}
    return {name: (content, status.st_mtime_ns, status.st_ino) for name, (content, status) in found.items()}


@contextmanager
def writer(file: Path, count: int) -> Iterator[subprocess.Popen[str]]:
    """A process that committed ``count`` entries one by one, and goes on holding the file."""
    command = [sys.executable, "-c", WRITER, str(file), str(count)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **pipes) as process:  # type: ignore[call-overload]
        try:
            assert process.stdout.readline() == "written\n"
            yield process
        finally:
            process.kill()


@contextmanager
def finished(file: Path, count: int) -> Iterator[None]:
    with FileStore(file) as store:
        store.begin("study", "definition")
        store.put(Batch([*entries(count).values()]))
    yield


@contextmanager
def running(file: Path, count: int) -> Iterator[None]:
    with writer(file, count) as process:
        yield
        process.stdin.close()
        assert process.wait(60) == 0
    with FileStore(file) as store:
        assert store.find(list(entries(count))) == entries(count)


@contextmanager
def killed(file: Path, count: int) -> Iterator[None]:
    with writer(file, count) as process:
        process.send_signal(signal.SIGKILL)
        process.wait(60)
    assert file.with_name(f"{file.name}-wal").exists()
    yield


@contextmanager
def killed_beside_an_index(file: Path, count: int) -> Iterator[None]:
    """What an ordinary SQLite writer leaves: FILE-shm lies there too, of a state that is past."""
    with killed(file, count):
        file.with_name(f"{file.name}-shm").write_bytes(os.urandom(32768))
        yield


@contextmanager
def killed_in_a_transaction(file: Path, count: int) -> Iterator[None]:
    """A journal lies there, and pages of what was not committed stand in the file."""
    with finished(file, count):
        pass
    script = (
        "import os, sqlite3, sys; c = sqlite3.connect(sys.argv[1], isolation_level=None);"
        "c.execute('PRAGMA cache_size = 1'); c.execute('BEGIN');"
        "c.execute(\"UPDATE study SET definition = 'half', checksum = 1\"); c.execute('DELETE FROM point');"
        "c.executemany('INSERT INTO point VALUES (?, ?, ?, 0)',"
        " ((str(i), 'done', 'x' * 3000) for i in range(300))); os._exit(1)"
    )
    subprocess.run([sys.executable, "-c", script, str(file)], check=False, timeout=60)
    assert file.with_name(f"{file.name}-journal").stat().st_size > 0
    yield


@contextmanager
def logging_without_log(file: Path, count: int) -> Iterator[None]:
    """The file alone, copied while it was in write-ahead logging."""
    with finished(file, count), sqlite3.connect(file) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
    connection.close()
    assert [path.name for path in file.parent.iterdir()] == [file.name]
    yield


@contextmanager
def in_a_folder_that_is_read_only(file: Path, count: int) -> Iterator[None]:
    with killed(file, count):
        file.parent.chmod(0o555)
        try:
            yield
        finally:
            file.parent.chmod(0o755)


SITUATIONS = [
    finished,
    running,
    killed,
    killed_beside_an_index,
    killed_in_a_transaction,
    logging_without_log,
    in_a_folder_that_is_read_only,
]


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("situation", SITUATIONS, ids=lambda situation: situation.__name__)
def test_all_that_was_committed_is_read_and_nothing_is_changed(situation, count: int, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    file = folder / "points.sqlite"
    wanted = entries(count)
    with situation(file, count):
        before = state_of(folder)
        for _ in range(2):
            with FileStore(file, read_only=True) as store:
                assert state_of(folder) == before
                assert store.find([*wanted, "f" * 64]) == wanted
                assert store.latest() == ("definition", b"")
        assert state_of(folder) == before


def test_the_log_beside_the_end_of_a_link_is_read(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    file, link = tmp_path / "elsewhere" / "points.sqlite", tmp_path / "link.sqlite"
    link.symlink_to(file)
    with killed(file, 3), FileStore(link, read_only=True) as store:
        assert store.find(list(entries(3))) == entries(3)


def write_for_ever(file: Path, committed) -> None:
    with FileStore(file) as store:
        for index in range(1_000_000):
            text = f"{index} " * 500
            numbers = 3 * index, 3 * index + 1
            store.put(Batch([Entry(f"{number:064x}", EntryState.DONE, text) for number in numbers]))
            committed.value = index + 1


def test_beside_a_run_that_goes_on_each_reading_gives_whole_transactions(tmp_path: Path) -> None:
    file = tmp_path / "points.sqlite"
    context = multiprocessing.get_context("spawn")
    committed = context.Value("q", 0)
    process = context.Process(target=write_for_ever, args=(file, committed), daemon=True)
    process.start()
    try:
        seen = 0
        for _ in range(25):
            while committed.value <= seen:
                assert process.is_alive()
            before = committed.value
            with FileStore(file, read_only=True) as store:
                after = committed.value + 1
                found = store.find([f"{3 * index + half:064x}" for index in range(after) for half in (0, 1)])
            transactions = {int(key, 16) // 3 for key in found}
            assert len(found) == 2 * len(transactions)
            assert transactions == set(range(len(transactions)))
            assert before <= len(transactions) <= after
            seen = before
        assert process.is_alive()
    finally:
        process.kill()
        process.join()


def test_reading_holds_no_run_up_and_takes_none_of_its_locks(tmp_path: Path) -> None:
    file = tmp_path / "points.sqlite"
    with finished(file, 3), FileStore(file, read_only=True) as reader:
        with FileStore(file) as store:
            store.put(Batch([Entry("e" * 64, EntryState.DONE, "later")]))
            with FileStore(file, read_only=True) as second:
                assert len(second.find(["e" * 64])) == 1
            # In the process that writes: closing a file there drops its locks, unless care is taken.
            refused = subprocess.run(
                [sys.executable, "-c", WRITER, str(file), "1"], text=True, capture_output=True, check=False, timeout=60
            )
            assert "in use by another run" in refused.stderr
        assert reader.find([*entries(3), "e" * 64]) == entries(3)
    assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_a_study_can_be_loaded_from_within_its_own_exploration(tmp_path: Path) -> None:
    file = tmp_path / "points.sqlite"
    counts: list[tuple[int, int]] = []

    def look(progress: Progress) -> None:
        counts.append((progress.done, len(load_study(file).points) - len(load_study(file).missing)))

    section = Exploration(axes={"bench.slices": [10, 50, 2000]})
    workload = codesign.load_workload("labyrinth").model_copy(update={"explore": section})
    platform = codesign.load_platform("virtex4-pci")
    explore(platform, workload, store=file, workers=1, progress=look, evaluate=Fake())
    assert counts
    assert all(done == seen for done, seen in counts)


def test_nothing_stays_in_the_folder_for_temporary_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, temporary = tmp_path / "points.sqlite", tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    with killed(file, 3), FileStore(file, read_only=True) as store:
        assert store.find(list(entries(3))) == entries(3)
        assert os.name != "posix" or list(temporary.iterdir()) == []
    other = tmp_path / "other.sqlite"
    other.write_bytes(b"no database at all" * 50)
    with pytest.raises(StoreError, match="is not a file of explored points"):
        FileStore(other, read_only=True)
    assert list(temporary.iterdir()) == []
    temporary.rmdir()
    with pytest.raises(StoreError, match="through a copy"):
        FileStore(file, read_only=True)
