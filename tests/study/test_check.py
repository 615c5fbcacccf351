"""Points of a study against single runs, budgets, and the order in which works are begun."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result as Invoked
from explore_fakes import AXES, Fake, computed, exploring
from small_maps import Specs, put_map

import codesign
from codesign.inputs import Platform, Workload
from codesign.study import Space, Study, explore, load_study
from codesign.study.budget import Budget
from codesign.study.check import check_points
from codesign.study.partition import Alone, Order, Turns

Hwsw = Callable[..., Invoked]


@pytest.fixture(scope="module")
def loaded() -> tuple[Platform, Workload]:
    return codesign.load_platform("virtex4-pci"), codesign.load_workload("labyrinth")


@pytest.fixture
def study(specs: Specs) -> Study:
    put_map(specs)
    return explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), workers=1)


def test_points_that_are_run_alone_are_equal(study: Study) -> None:
    check = check_points(study, 1000)
    assert (check.points, check.differences) == (2, ())
    assert check.sentence == "2 points were run alone: all figures equal"


@pytest.mark.parametrize("column", ["figures", "lows", "highs"])
def test_the_last_bit_of_any_figure_counts(study: Study, column: str) -> None:
    values = getattr(study.outcomes, column)["energy_j"]
    values[1] = np.nextafter(values[1], 1)
    check = check_points(study, 2)
    assert [line.partition(" is ")[0].split(": ")[0] for line in check.differences] == ["point 1"]
    assert "energy_j" in check.differences[0]
    assert check.sentence == "2 points were run alone: 1 figure differs"


def test_the_command_checks_and_says_how_many_simulations(specs: Specs, hwsw: Hwsw) -> None:
    put_map(specs)
    ran = hwsw("explore", *specs, "--workers", 1, "--check", 5)
    assert ran.exit_code == 0
    assert "(2 points, 2 simulations)" in ran.output
    assert "2 points were run alone: all figures equal" in ran.output


def test_a_difference_ends_the_command(specs: Specs, hwsw: Hwsw, monkeypatch: pytest.MonkeyPatch) -> None:
    put_map(specs)
    monkeypatch.setattr("codesign.study.check._differences", lambda _study, index: [f"point {index}: no"])
    ran = hwsw("explore", *specs, "--workers", 1, "--check", 1)
    assert ran.exit_code == 1
    assert "1 point was run alone: 1 figure differs" in ran.output


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_budget_of_points(loaded: tuple[Platform, Workload], tmp_path: Path, workers: int) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    workload, budget = exploring(loaded[1], AXES), Budget(points=5)
    part = explore(loaded[0], workload, workers=workers, store=file, evaluate=Fake(log), budget=budget)
    assert len(part.missing) == 7
    assert budget.ended == "the budget of 5 points was used up"
    assert load_study(file).to_json() == part.to_json()
    whole = explore(loaded[0], workload, workers=workers, store=file, evaluate=Fake(log))
    assert whole.missing == ()
    assert sorted(computed(log)) == list(range(12))


def test_works_show_the_whole_space_early_and_designs_are_done_one_by_one() -> None:
    decisions = Space({"a.b": list(range(5)), "a.c": list(range(4))}, "")
    space = Space({"a.b": list(range(5)), "a.c": list(range(4)), "a.d": [1, 2]}, "")
    works = Turns(decisions, 2).sorted(Alone((point,)) for point in space.points())
    begun = [work.indices[0] for work in works]
    assert sorted(begun) == list(range(40))
    assert [index // 2 for index in begun[::2]] == [index // 2 for index in begun[1::2]]
    assert [index // 2 for index in begun[::2]] == Order.of(decisions).indices(0, 20).tolist()
