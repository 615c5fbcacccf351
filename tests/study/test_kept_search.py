"""What a store keeps of searches, and that nothing in it is evaluated twice."""

from __future__ import annotations

import json
import sqlite3
import zlib
from pathlib import Path
from typing import Any

import pytest
from small_search import AXES, of, small_workload

import codesign
from codesign.ground.errors import StoreError
from codesign.inputs import Platform, Workload
from codesign.study import evaluation, explore, load_study
from codesign.study.blocks import compressed, expanded
from codesign.study.budget import Budget
from codesign.study.search_run import CUT_OFF
from codesign.study.store import FileStore
from codesign.study.study import Study
from codesign.views.report.study_page import study_html
from codesign.views.report.study_tables import search_table, study_tables

pytestmark = pytest.mark.usefixtures("searched")


@pytest.fixture(scope="module")
def platform() -> Platform:
    return codesign.load_platform("virtex4-pci")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Workload:
    return of(small_workload(tmp_path_factory.mktemp("search")), AXES)


@pytest.fixture
def priced(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many points were priced, each time."""
    counts: list[int] = []
    price = evaluation.price

    def counting(groups: Any) -> Any:
        counts.extend(group.specs.count for group in groups)
        return price(groups)

    monkeypatch.setattr(evaluation, "price", counting)
    return counts


def held(study: Study) -> int:
    return len(study.outcomes) - len(study.missing)


@pytest.mark.parametrize(("name", "points"), [("bound", None), ("random", 30), ("random", 101)])
def test_all_points_after_a_search(
    platform: Platform, small: Workload, tmp_path: Path, priced: list[int], name: str, points: int | None
) -> None:
    file = tmp_path / "points.sqlite"
    searched = explore(platform, small, workers=1, store=file, search=name, budget=Budget(points=points))
    assert sum(priced) == held(searched)
    every = explore(platform, small, workers=1, store=file)
    assert sum(priced) == len(every.outcomes)
    assert not every.simulations
    assert explore(platform, small, workers=1) == every == load_study(file)
    count = len(priced)
    for again in ({}, {"search": name, "budget": Budget(points=points)}):
        assert explore(platform, small, workers=1, store=file, **again) == every  # type: ignore[arg-type]
        assert len(priced) == count


def test_budgets_cut_priced_points_without_simulating_them(
    platform: Platform, small: Workload, tmp_path: Path, priced: list[int]
) -> None:
    file, total = tmp_path / "points.sqlite", len(explore(platform, small, workers=1).outcomes)
    priced.clear()
    simulations = 0
    for done in (7, 60, 61, 200, total):
        budget = Budget(points=done - sum(priced))
        study = explore(platform, small, workers=1, store=file, budget=budget)
        simulations += study.simulations or 0
        assert sum(priced) == done == held(study)
        assert load_study(file) == study
    assert simulations == 2
    assert study == explore(platform, small, workers=1)
    with FileStore(file, read_only=True) as store:
        assert not store.has_entries()


def test_a_report_has_the_tables_of_the_search(platform: Platform, small: Workload, tmp_path: Path) -> None:
    file = tmp_path / "points.sqlite"
    for name, points in (("random", 20), ("bound", None), ("random", 40)):
        study = explore(platform, small, workers=1, store=file, search=name, budget=Budget(points=points))
        read = load_study(file)
        assert search_table(read) == search_table(study) is not None
        assert [table.rows for table in study_tables(read)] == [table.rows for table in study_tables(study)]
        assert "Hypervolume over evaluations" in study_html(read)
    explore(platform, small, workers=1, store=file)
    assert load_study(file).search is None


def test_a_search_that_is_interrupted_is_reported(platform: Platform, small: Workload, tmp_path: Path) -> None:
    file = tmp_path / "points.sqlite"

    def strike(progress: Any) -> None:
        if progress.done >= 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        explore(platform, small, workers=1, store=file, search="bound", seed=5, progress=strike)
    search = load_study(file).search
    assert search is not None
    assert [(trace.name, trace.seed, trace.ended) for trace in search.traces] == [
        ("bound", 5, CUT_OFF),
        ("random", 5, CUT_OFF),
    ]
    assert search.traces[0].designs


@pytest.mark.parametrize(
    "change",
    [
        {"simulated": -1},
        {"kept": "3"},
        {"traces": []},
        {"traces": [{}]},
        {"name": 3},
        {"seed": 1.5},
        {"designs": [0, 10**9]},
        {"designs": [True]},
        {"excluded": [[0, [0], [1], None, None, "fit"]]},
        {"ended": None},
        {"proved": 1},
    ],
)
def test_a_damaged_search_is_refused(
    platform: Platform, small: Workload, tmp_path: Path, change: dict[str, Any]
) -> None:
    file = tmp_path / "points.sqlite"
    explore(platform, small, workers=1, store=file, search="random", budget=Budget(points=4))
    with sqlite3.connect(file) as connection:
        ((key, data),) = connection.execute("SELECT key, data FROM block WHERE key LIKE 'searched %'")
        record = json.loads(expanded(data))
        place = record if change.keys() <= record.keys() else record["traces"][0]
        place.update(change)
        damaged = compressed(json.dumps(record).encode())
        checksum = zlib.crc32(damaged, zlib.crc32(key.encode()))
        connection.execute("UPDATE block SET data = ?, checksum = ? WHERE key = ?", (damaged, checksum, key))
    connection.close()
    with pytest.raises(StoreError, match="holds a search that this version cannot read"):
        load_study(file)
