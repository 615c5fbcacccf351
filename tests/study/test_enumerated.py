"""All points are computed in the place of a search where that is cheaper: the exact front, and the study says so."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from explore_fakes import Fake
from small_search import AXES, of, small_workload

import codesign
from codesign.inputs import Platform, Workload, exploration
from codesign.study import evaluation, explore, load_study
from codesign.study.budget import Budget
from codesign.study.search import Problem
from codesign.study.search_run import search_of
from codesign.study.space import Space
from codesign.views.report.study_page import study_html
from codesign.views.report.study_tables import search_picture, search_table

pytest.importorskip("optuna")

SIZE = math.prod(map(len, AXES.values()))
SIMULATIONS = 2


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


@pytest.mark.parametrize(
    ("name", "budget"), [("bound", {}), ("bound", {"points": 9}), ("tpe", {"points": 9}), ("nsga2", {"seconds": 1e6})]
)
def test_the_front_of_a_small_space_is_that_of_all_points(
    platform: Platform, small: Workload, tmp_path: Path, priced: list[int], name: str, budget: dict[str, Any]
) -> None:
    file = tmp_path / "points.sqlite"
    study = explore(platform, small, workers=1, store=file, search=name, seed=3, budget=Budget(**budget))
    assert sum(priced) == SIZE  # each point once, and nothing beside it
    assert study == explore(platform, small, workers=1)
    for held in (study, load_study(file)):
        assert held.search is not None
        (trace,) = held.search.traces
        assert (trace.name, trace.seed, trace.designs, trace.proved, trace.ended) == (name, 3, [], True, "")
        assert f"{name} was not run" in trace.enumerated
        assert f"at most {exploration.ENUMERATED:,}" in trace.enumerated
        assert f"{SIZE} take at most {SIMULATIONS}" in trace.enumerated
        table = search_table(held)
        assert table is not None
        assert [cell.text for cell in table.rows[0]] == [name, str(SIZE), "all points computed"]
        assert table.notes == (trace.enumerated,)
        assert search_picture(held) is None
        assert trace.enumerated in study_html(held)
    explore(platform, small, workers=1, store=file)
    assert load_study(file).search is None


@pytest.mark.parametrize(
    ("name", "budget", "most", "enumerated"),
    [
        ("bound", {}, SIZE, True),
        ("bound", {}, SIZE - 1, False),
        ("tpe", {"points": SIMULATIONS}, SIZE, True),
        ("tpe", {"points": SIMULATIONS - 1}, SIZE, False),
        ("tpe", {"points": 20}, SIZE - 1, False),
        ("nsga2", {"points": SIMULATIONS - 1}, SIZE, False),
        ("random", {"points": 20}, SIZE, False),
    ],
)
def test_a_search_runs_in_a_larger_space_or_one_that_takes_more_simulations(
    platform: Platform,
    small: Workload,
    monkeypatch: pytest.MonkeyPatch,
    priced: list[int],
    name: str,
    budget: dict[str, Any],
    most: int,
    enumerated: bool,
) -> None:
    monkeypatch.setattr(exploration, "ENUMERATED", most)
    study = explore(platform, small, workers=1, search=name, budget=Budget(**budget))
    assert study.search is not None
    assert bool(study.search.traces[0].enumerated) == enumerated
    assert (sum(priced) == SIZE) == enumerated


def test_a_function_of_ones_own_is_called_no_more_than_the_search_asks(
    platform: Platform, small: Workload, tmp_path: Path
) -> None:
    log = tmp_path / "log"
    explore(platform, small, workers=1, evaluate=Fake(log), search="tpe", budget=Budget(points=12))
    assert 12 <= len(log.read_text().splitlines()) <= 24  # and random search beside it


@pytest.mark.parametrize("name", ["nsga2", "tpe"])
@pytest.mark.parametrize("when", [{}, {"a.y": {"a.x": [3, 4, 5]}}])
def test_a_sampler_asks_for_every_design_once_and_ends(name: str, when: dict[str, Any]) -> None:
    """Alike designs, so that it suggests the known ones again; each is told as what came of it before."""
    space = Space({"a.x": list(range(12)), "a.y": [4, 2, 1], "a.z": ["p", "q"]}, "", when=when)
    search = search_of(exploration.Searching(sampler=name), Problem(space, ("f",), (False,), ()))
    asked: list[int] = []
    for _ in range(len(space)):
        if not (designs := search.ask(10)):
            break
        search.tell(designs, np.array(designs, np.float64)[:, None], np.zeros((len(designs), 0)))
        asked += designs
    assert sorted(asked) == list(range(len(space)))
    assert search.complete
    trials = search._study.trials  # type: ignore[attr-defined]
    assert len(trials) == len(asked) + search.repeated <= 2 * len(asked)
    assert {trial.state.name for trial in trials} == {"COMPLETE"}
    assert search.repeated > 0
    told: dict[tuple[Any, ...], set[float]] = {}
    for trial in trials:
        told.setdefault(tuple(sorted(trial.params.items())), set()).add(trial.values[0])
    assert all(len(values) == 1 for values in told.values())
