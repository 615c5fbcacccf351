"""Whatever lies in a file of points: ``report`` and ``explore`` end with a table or with the project's own errors."""

from __future__ import annotations

import json
import re
import shutil
import sqlite3
import zlib
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result as Invoked
from drive_fuzz import bounded
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import Ground
from small_maps import put_map

import codesign
from codesign.ground.errors import EXIT_FAILED, EXIT_NO, CodesignError, StoreError
from codesign.inputs import Platform, Workload
from codesign.study import Entry, EntryState, FileStore, Space, explore, load_study
from codesign.study.blocks import compressed, expanded
from codesign.study.evaluation import EvaluatePoint
from codesign.study.explored import Explored
from codesign.study.identity import canonical_digest
from codesign.study.simulator import Simulator
from codesign.study.store import Batch
from codesign.study.store import _checksum as checksum

Hwsw = Callable[..., Invoked]
Specs = tuple[Path, Path]

fuzzed = settings(max_examples=8)

WILD: tuple[Any, ...] = (
    None,
    True,
    0,
    -1,
    2**63,
    10**39,
    -(10**39),
    1e308,
    -1e308,
    5e-324,
    "",
    "x" * 5000,
    "\x1b[31m\u202e\x00\ud800",
    [],
    {},
    [[]],
    [{}] * 50,
    {"a": {"b": {}}},
)
"""Values in the place of one in a result or a definition."""

COLUMNS: tuple[Any, ...] = (
    None,
    0,
    -1,
    2**63 - 1,
    1.5,
    "",
    "done",
    "failed",
    "DONE",
    "\ud800",
    "\x00",
    b"",
    b"\xff\x00",
)
"""Values in the place of one in a row."""

STATEMENTS = (
    "DROP TABLE point",
    "DROP TABLE study",
    "DELETE FROM point",
    "DELETE FROM study",
    "DROP TABLE block",
    "DROP TABLE computation",
    "DELETE FROM block",
    "INSERT INTO computation VALUES ('a', 'b', 0)",
    "INSERT INTO computation VALUES ('a', x'ff', 0)",
    "PRAGMA user_version = 0",
    "PRAGMA user_version = 2147483647",
    "PRAGMA user_version = -1",
    "PRAGMA application_id = 0",
    "PRAGMA encoding = 'UTF-16'",
    "ALTER TABLE point RENAME COLUMN state TO condition",
    "ALTER TABLE study RENAME COLUMN definition TO text",
    "ALTER TABLE point RENAME TO points",
    "DROP TABLE point; CREATE VIEW point AS SELECT 'a' AS key, 'done' AS state, '' AS text, 0 AS checksum",
    "DROP TABLE point; CREATE TABLE point (key, state, text, checksum)",
    "DROP TABLE study; CREATE TABLE study (number, key, definition, checksum)",
    "CREATE TRIGGER more AFTER INSERT ON point BEGIN SELECT RAISE(ABORT, 'no'); END",
    "PRAGMA journal_mode = WAL",
    "VACUUM",
)


@pytest.fixture(scope="module")
def explored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Specs]:
    """A file of two points of a short drive, and its specs."""
    folder = tmp_path_factory.mktemp("store")
    axes = {"explore": {"axes": {"fpga.clock": ["50 MHz", "100 MHz"]}}}
    specs = Ground(folder).files(goals=[(3, 3)], limit="20 s", workload=axes)
    file = folder / "points.sqlite"
    study = explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), store=file, workers=1)
    assert len(study.feasible) == 2
    return file, specs


def assert_ends_well(hwsw: Hwsw, file: Path, specs: Specs) -> None:
    """Every reader of the file ends with what it is for, or with one of the project's own errors."""
    with bounded():
        read = report(hwsw, file)
        resumed = hwsw("explore", *specs, "--store", file, "--workers", 1)
        assert resumed.exit_code in {0, EXIT_FAILED}, resumed.output
        if resumed.exit_code == 0:
            assert report(hwsw, file), "what explore has mended can be read"
        elif not read:
            assert "hint: " in resumed.output


def report(hwsw: Hwsw, file: Path) -> bool:
    """Whether all that ``report`` writes of the file can be written; else it says why, and writes nothing."""
    outputs = [file.with_name("points.csv"), file.with_name("points.html")]
    for output in outputs:
        output.unlink(missing_ok=True)
    told = hwsw("report", file, "--csv", outputs[0], "--html", outputs[1])
    # A file without a point has no feasible one.
    assert told.exit_code in {0, EXIT_FAILED, EXIT_NO}, told.output
    if told.exit_code == EXIT_FAILED:
        assert f"{file}: " in told.output
        assert "hint: " in told.output
        with pytest.raises(StoreError):
            load_study(file)
        return False
    assert all(output.exists() for output in outputs)
    json.loads(hwsw("report", file, "--json").stdout)
    return True


def leaves(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield path
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in entries:
        yield from leaves(value, (*path, key))


def replaced(tree: Any, path: tuple[Any, ...], value: Any) -> Any:
    if not path:
        return value
    made = dict(tree) if isinstance(tree, dict) else list(tree)
    made[path[0]] = replaced(tree[path[0]], path[1:], value)
    return made


def rows(file: Path, table: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(file, timeout=0.1)) as database:
        return list(database.execute(f"SELECT * FROM {table}"))


def checksum_of(row: dict[str, Any]) -> int:
    """That of a row of ``point`` or ``study``."""
    texts = [row[name] for name in ("key", "state", "text", "definition") if name in row]
    return zlib.crc32(row.get("plan", b""), checksum(*texts))


def forge(data: st.DataObject, file: Path) -> None:
    """Change one value of one result, or of the study's definition, and make the checksum right."""
    table = data.draw(st.sampled_from(["point", "study"]))
    text = "text" if table == "point" else "definition"
    with closing(sqlite3.connect(file, timeout=0.1)) as database:
        query = f"SELECT * FROM {table}"
        database.row_factory = sqlite3.Row
        row = dict(database.execute(query).fetchall()[0])
        tree = json.loads(row[text])
        path = data.draw(st.sampled_from(list(leaves(tree))))
        row[text] = json.dumps(replaced(tree, path, data.draw(st.sampled_from(WILD))))
        row["checksum"] = checksum_of(row)
        names = ", ".join(f"{name} = :{name}" for name in row)
        database.execute(f"UPDATE {table} SET {names} WHERE key = :key", row)
        database.commit()


def put(data: st.DataObject, file: Path) -> None:
    """Put a value of any type into a column, and make the checksum right where it can be."""
    table = data.draw(st.sampled_from(["point", "study"]))
    with closing(sqlite3.connect(file, timeout=0.1)) as database:
        database.row_factory = sqlite3.Row
        row = dict(database.execute(f"SELECT * FROM {table}").fetchall()[0])
        # The state is one word of two; any other is a row that no checksum tells.
        columns = [*row, *["state"] * (2 * len(row) if table == "point" else 0)]
        key, column = row["key"], data.draw(st.sampled_from(columns))
        row[column] = data.draw(st.sampled_from(COLUMNS))
        if column != "checksum":
            with suppress(TypeError, AttributeError):
                row["checksum"] = checksum_of(row)
        names = ", ".join(f"{name} = :{name}" for name in row)
        try:
            database.execute(f"UPDATE {table} SET {names} WHERE key = :was", row | {"was": key})
        except (sqlite3.Error, UnicodeError):
            return
        database.commit()


def alter(data: st.DataObject, file: Path) -> None:
    """Change the tables, or what the file says of itself."""
    with closing(sqlite3.connect(file, timeout=0.1)) as database:
        database.executescript(data.draw(st.sampled_from(STATEMENTS)))


def damage(data: st.DataObject, file: Path) -> None:
    """Cut the file, or put other bytes into it."""
    content = file.read_bytes()
    at = data.draw(st.integers(0, len(content)))
    piece = data.draw(st.one_of(st.binary(max_size=40), st.just(b"\xff" * 5000), st.just(b"")))
    cut = data.draw(st.booleans())
    file.write_bytes(content[:at] + piece + (b"" if cut else content[at + len(piece) :]))


def assert_any_change_ends_well(hwsw: Hwsw, explored: tuple[Path, Specs], folder: Path, data: st.DataObject) -> None:
    file = folder / "forged.sqlite"
    for left in folder.glob("forged.sqlite*"):
        left.unlink()
    shutil.copy(explored[0], file)
    for change in data.draw(st.lists(st.sampled_from([forge, put, alter, damage]), min_size=1, max_size=2)):
        try:
            change(data, file)
        except (sqlite3.Error, ValueError, LookupError):
            break
    assert_ends_well(hwsw, file, explored[1])


@fuzzed
@given(st.data())
def test_any_file_of_points(hwsw: Hwsw, explored: tuple[Path, Specs], tmp_path: Path, data: st.DataObject) -> None:
    assert_any_change_ends_well(hwsw, explored, tmp_path, data)


@pytest.mark.slow
@settings(fuzzed, max_examples=examples(120))
@given(st.data())
def test_many_files_of_points(hwsw: Hwsw, explored: tuple[Path, Specs], tmp_path: Path, data: st.DataObject) -> None:
    assert_any_change_ends_well(hwsw, explored, tmp_path, data)


@pytest.mark.parametrize("state", ["", "DONE", "running"])
def test_a_row_in_an_unknown_state_is_told(explored: tuple[Path, Specs], tmp_path: Path, state: str) -> None:
    file = tmp_path / "forged.sqlite"
    shutil.copy(explored[0], file)
    with closing(sqlite3.connect(file, timeout=0.1)) as database:
        for key, text in list(database.execute("SELECT key, text FROM point")):
            row = (state, checksum(key, state, text), key)
            database.execute("UPDATE point SET state = ?, checksum = ? WHERE key = ?", row)
        database.commit()
    with pytest.raises(StoreError, match="state") as caught:
        load_study(file)
    assert caught.value.where == str(file)
    assert isinstance(caught.value, CodesignError)
    keys = [key for key, *_ in rows(file, "point")]
    with FileStore(file) as store, pytest.raises(StoreError, match=", ".join(EntryState)):
        store.find(keys)


def loaded(specs: Specs) -> tuple[Platform, Workload]:
    return codesign.load_platform(specs[0]), codesign.load_workload(specs[1])


def kept(specs: Specs, tmp_path: Path, evaluate: EvaluatePoint | None = None) -> tuple[Path, str, str]:
    """A file of two points, the definition of its study, and the key of a point. ``evaluate``: see ``explore``."""
    put_map(specs)
    file = tmp_path / "points.sqlite"
    study = explore(*loaded(specs), workers=1, store=file, evaluate=evaluate)
    assert len(study.feasible) == 2
    with FileStore(file, read_only=True) as store:
        latest = store.latest()
    assert latest is not None
    definition, _ = latest
    known = json.loads(definition)
    return file, definition, Space(known["axes"], canonical_digest(known["identity"])).point(0).key


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"axes": {"relax.iterations": [1, 4]}', '"axes": {"relax.iterations": ' + "[" * 9000 + "]" * 9000 + "}"),
        ('"axes": {"relax.iterations": [1, 4]}', '"axes": {"a.b": [1e999]}'),
        ('"axes": {"relax.iterations": [1, 4]}', '"axes": [[1, 2]]'),
        (
            '"axes": {"relax.iterations": [1, 4]}',
            '"axes": ' + json.dumps({f"a.x{axis}": list(range(1000)) for axis in range(9)}),
        ),
        ('"platforms": {', '"platforms": {}, "other": {'),
        ('"workload": {', '"workload": 7, "others": {'),
        ('"constraints": []', '"constraints": 7'),
    ],
)
def test_a_tampered_study_is_told(specs: Specs, tmp_path: Path, old: str, new: str) -> None:
    file, definition, _ = kept(specs, tmp_path)
    assert old in definition
    with FileStore(file) as store:
        store.begin("tampered", definition.replace(old, new))
    with pytest.raises(StoreError):
        load_study(file)


@pytest.mark.parametrize("number", ["1e999", "Infinity", "NaN", "9" * 400, "[" * 100_000])
def test_a_tampered_result_is_told(specs: Specs, tmp_path: Path, number: str) -> None:
    file, _, key = kept(specs, tmp_path, Simulator(Explored.of(*loaded(specs))))
    with FileStore(file) as store:
        text = store.find([key])[key].text
        changed = re.sub(r'"energy_j":[^,}]*', f'"energy_j":{number}', text)
        assert changed != text
        store.put(Batch([Entry(key, EntryState.DONE, changed)]))
    with pytest.raises(StoreError):
        load_study(file)


def tampered(header: dict[str, Any], arrays: bytes, change: str) -> bytes:
    """A block with one change, as bytes."""
    text = json.dumps(header)
    match change:
        case "cut off":
            arrays = arrays[:-1]
        case "too long":
            arrays += b"0"
        case "infinite":
            arrays = arrays[:-2] + b"\x7f\xf0"
        case "no template":
            text = json.dumps(header | {"templates": 0})
        case "too many":
            text = json.dumps(header | {"count": header["count"] + 1})
        case "nested":
            text = text.replace('"templates": ', '"templates": ' + "[" * 100_000, 1)
        case "no texts":
            text = json.dumps(header | {"texts": []})
        case "fewer texts":
            text = json.dumps(header | {"texts": header["texts"] | {"resources": 0}})
        case "negative texts":
            text = json.dumps(header | {"texts": header["texts"] | {"resources": -1, "stages": 3}})
        case "no header":
            text = ""
        case number:
            text = re.sub(r'"power": [^,}]*', f'"power": {number}', text)
            assert number in text
    return compressed(text.encode() + b"\n" + arrays)


@pytest.mark.parametrize(
    "change",
    [
        *("cut off", "too long", "no template", "too many", "nested", "no header"),
        *("no texts", "fewer texts", "negative texts"),
        *("1e999", "Infinity", "NaN", "9" * 400, '"x"', "[]"),
    ],
)
def test_a_tampered_block_is_told(specs: Specs, tmp_path: Path, change: str) -> None:
    file, _, _ = kept(specs, tmp_path)
    key, data, _ = rows(file, "block")[0]
    text, _, arrays = expanded(data).partition(b"\n")
    block = tampered(json.loads(text), arrays, change)
    with FileStore(file) as store:
        store.put(Batch(blocks={key: block}))
    with pytest.raises(StoreError):
        load_study(file)
    with pytest.raises(StoreError):
        explore(*loaded(specs), workers=1, store=file)


@pytest.mark.parametrize("plan", [b"", b"no plan", compressed(b"[]"), compressed(b'[["a", 3]]\n'), b"far"])
def test_a_tampered_plan_is_told_or_gives_no_points(specs: Specs, tmp_path: Path, plan: bytes) -> None:
    file, definition, _ = kept(specs, tmp_path)
    key = rows(file, "block")[0][0]
    if plan == b"far":
        plan = compressed(f'[["{key}", 2]]\n'.encode() + bytes([0, 9, *[0] * 14]))
    with FileStore(file) as store:
        store.begin("tampered", definition, plan)
    try:
        study = load_study(file)
    except StoreError:
        return
    assert plan == compressed(b"[]")
    assert study.missing == (0, 1)
