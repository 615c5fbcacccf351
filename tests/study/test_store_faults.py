"""A file of priced points that is damaged, of another study, in use, or on a full disk: an error, and nothing lost."""

from __future__ import annotations

import contextlib
import random
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

import codesign
from codesign.ground.errors import StoreError
from codesign.inputs import Platform, Workload
from codesign.study import FileStore, Study, explore, load_study
from codesign.views.report import study_csv

TEXT = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: rooms, rows: 12, columns: 18, room: [5, 5], door: 2, seed: 3}
  goals: [[2, 2]]
  starts: {count: 3, seed: 1}
mapping:
  relax: {component: fabric, block: [6, 9], iterations: 4, schedule: [15, 31]}
explore:
  axes:
    relax.iterations: [2, 4]
    fabric.clock: [10 MHz, 20 MHz, 50 MHz]
"""
PAGE = 4096


class Kept(NamedTuple):
    """A study, and its file as bytes."""

    platform: Platform
    workload: Workload
    data: bytes
    rows: object
    file: Path


def rows(study: Study) -> object:
    return [[cell.value for cell in row] for row in study_csv(study).rows]


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Kept:
    folder = tmp_path_factory.mktemp("faults")
    (folder / "small.yaml").write_text(TEXT, encoding="utf-8")
    platform = codesign.load_platform("virtex2-pci")
    workload = codesign.load_workload(folder / "small.yaml")
    store = folder / "small.sqlite"
    study = explore(platform, workload, store=store, workers=1)
    assert study.simulations == 2
    return Kept(platform, workload, store.read_bytes(), rows(study), folder / "small.yaml")


def mutated(data: bytes, chance: random.Random) -> bytes:
    """The bytes of a file with one thing wrong."""
    changed, place = bytearray(data), chance.randrange(len(data))
    kind = chance.choice(("bit", "bit", "bytes", "cut", "pages", "zeros", "more"))
    if kind == "bit":
        changed[place] ^= 1 << chance.randrange(8)
    elif kind == "bytes":
        for _ in range(chance.randrange(2, 60)):
            changed[chance.randrange(len(data))] = chance.randrange(256)
    elif kind == "cut":
        del changed[place:]
    elif kind == "pages":
        one, other = (PAGE * chance.randrange(len(data) // PAGE) for _ in range(2))
        changed[one : one + PAGE] = data[other : other + PAGE]
    elif kind == "zeros":
        changed[place : place + 200] = bytes(len(changed[place : place + 200]))
    else:
        changed[place:place] = b"x" * chance.randrange(1, 5000)
    return bytes(changed)


def read(store: Path) -> Study | None:
    """The study of a file; None where it is refused."""
    with contextlib.suppress(StoreError):
        return load_study(store)
    return None


def explored(kept: Kept, store: Path) -> Study | None:
    """The study, computed with a file; None where it is refused. It has every point."""
    with contextlib.suppress(StoreError):
        study = explore(kept.platform, kept.workload, store=store, workers=1)
        assert not study.missing
        return study
    return None


@pytest.mark.parametrize("seed", range(4))
def test_a_damaged_file_is_refused_or_gives_the_same_study(kept: Kept, tmp_path: Path, seed: int) -> None:
    chance, refused = random.Random(seed), 0
    for number in range(25):
        store = tmp_path / f"{number}.sqlite"
        store.write_bytes(mutated(kept.data, chance))
        # Explore may do without what is damaged, which a report then refuses.
        for study in (read(store), explored(kept, store), read(store)):
            refused += study is None
            # A block that is gone is a point that was not computed.
            assert study is None or study.missing or rows(study) == kept.rows
    assert refused


def test_a_file_of_another_study_keeps_both(kept: Kept, tmp_path: Path) -> None:
    store = tmp_path / "both.sqlite"
    store.write_bytes(kept.data)
    other = codesign.load_workload("labyrinth").model_copy(update={"explore": kept.workload.explore})
    with pytest.raises(codesign.ground.errors.SpecError):
        explore(codesign.load_platform("pc-epyc"), other, store=store, workers=1)
    assert rows(load_study(store)) == kept.rows
    text = TEXT.replace("seed: 3", "seed: 4")
    (tmp_path / "other.yaml").write_text(text, encoding="utf-8")
    study = explore(kept.platform, codesign.load_workload(tmp_path / "other.yaml"), store=store, workers=1)
    assert study.simulations == 2
    assert rows(load_study(store)) == rows(study)
    again = explore(kept.platform, kept.workload, store=store, workers=1)
    assert (again.simulations, rows(again)) == (None, kept.rows)


def test_a_file_in_use_is_named_and_left_as_it_is(kept: Kept, tmp_path: Path) -> None:
    store = tmp_path / "used.sqlite"
    store.write_bytes(kept.data)
    text = f"import codesign.study as e; s = e.FileStore({str(store)!r}); print(1, flush=True); input()"
    with subprocess.Popen(
        [sys.executable, "-c", text], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        with pytest.raises(StoreError, match="is in use by another run"):
            FileStore(store)
        other.communicate("\n")
    assert rows(load_study(store)) == kept.rows


@pytest.mark.skipif(sys.platform == "win32", reason="no limit of file sizes")
@pytest.mark.parametrize("most", [1_000, 30_000, 60_000])
def test_on_a_full_disk_what_was_finished_stays(kept: Kept, tmp_path: Path, most: int) -> None:
    """A limit of file sizes stands for the full disk: SQLite reports an error of the disk."""
    store, table = tmp_path / "full.sqlite", tmp_path / "full.csv"
    text = (
        "import resource, sys; from codesign.__main__ import main;"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({most}, {most})); main()"
    )
    names = ("explore", "virtex2-pci", kept.file, "--store", store, "--workers", "1", "--csv", table)
    ran = subprocess.run([sys.executable, "-c", text, *map(str, names)], capture_output=True, text=True, check=False)
    assert ran.returncode == 1, ran.stderr
    assert "cannot be read or written: disk I/O error" in ran.stderr
    assert "run again: it goes on from there" in ran.stderr
    assert "Traceback" not in ran.stderr
    assert not table.exists()
    study = explore(kept.platform, kept.workload, store=store, workers=1)
    assert rows(study) == kept.rows == rows(load_study(store))
