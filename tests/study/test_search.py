"""Searches: one contract for all, one store, and the front that branch and bound proves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from search_boxes import check_boxes
from small_search import AXES, MHZ, of, small_workload

import codesign
from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES
from codesign.inputs import Platform, Workload
from codesign.inputs.exploration import Searching
from codesign.study import explore, load_study
from codesign.study.bounds import Bounds
from codesign.study.budget import Budget
from codesign.study.evaluation import Pricer
from codesign.study.explored import Explored
from codesign.study.hypervolume import Scale, curves_of
from codesign.study.search import Problem, Search
from codesign.study.search_run import SEARCHES, search_of
from codesign.study.space import Space

pytest.importorskip("optuna")

pytestmark = pytest.mark.usefixtures("searched")

SAMPLING = [name for name in SEARCHES if name != "bound"]


@pytest.fixture(scope="module")
def platform() -> Platform:
    return codesign.load_platform("virtex4-pci")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Workload:
    return small_workload(tmp_path_factory.mktemp("search"))


def space_of(axes: dict[str, Any], when: dict[str, Any] | None = None) -> Space:
    return Space(axes, "", when=when)


def told(designs: list[int], problem: Problem) -> tuple[Any, Any]:
    """Two objectives that trade, and a limit that every third design breaks."""
    numbers = np.array(designs, np.float64)
    objectives = np.column_stack([numbers % 17, -(numbers % 13)])
    excess = np.where(numbers % 3 == 0, 0.5, 0.0)[:, None]
    return np.where(excess > 0, math.nan, objectives), excess


@pytest.mark.parametrize("name", SAMPLING)
@pytest.mark.parametrize(
    ("axes", "when"),
    [
        ({"a.x": list(range(30)), "a.y": ["p", "q", "r"], "a.z": [1]}, {}),
        ({"a.k": ["p", "q"], "a.x": list(range(9)), "a.y": [4, 2, 1]}, {"a.x": {"a.k": ["p"]}, "a.y": {"a.x": [3, 4]}}),
        ({f"a.x{axis}": list(range(1000)) for axis in range(4)}, {}),
    ],
)
def test_contract(name: str, axes: dict[str, Any], when: dict[str, Any]) -> None:
    space = space_of(axes, when)
    problem = Problem(space, ("f", "g"), (False, True), ("limit",))

    def course(seed: int) -> list[int]:
        search: Search = search_of(Searching(sampler=name, seed=seed), problem)
        asked: list[int] = []
        for count in (7, 20, 1, 20, 20):
            designs = search.ask(count)
            assert len(designs) <= count
            assert all(0 <= design < len(space) for design in designs)
            assert len({*asked, *designs}) == len(asked) + len(designs), "each is new"
            objectives, excess = told(designs, problem)
            if asked and designs:
                # A design that failed has no figures at all.
                objectives[0], excess[0] = math.nan, math.nan
            search.tell(designs, objectives, excess)
            asked += designs
            if not designs:
                break
        return asked

    assert course(1) == course(1)
    assert len(set(course(1))) > 1
    if len(space) > 100:
        assert course(1) != course(2)


def test_random_draws_each_design_once() -> None:
    problem = Problem(space_of({"a.x": list(range(50))}), ("f",), (False,), ())
    search = search_of(Searching(sampler="random", seed=3), problem)
    assert sorted(search.ask(40) + search.ask(40)) == list(range(50))
    assert search.complete
    assert search.ask(1) == []


@pytest.mark.parametrize("name", ["nsga2", "tpe"])
def test_a_sampler_learns_from_figures_and_limits(name: str) -> None:
    """The best designs keep the limit; a sampler finds more of them than chance does."""
    problem = Problem(space_of({"a.x": list(range(100)), "a.y": list(range(100))}), ("f",), (False,), ("limit",))
    search, designs = search_of(Searching(sampler=name), problem), []
    while len(designs) < 300:
        asked = search.ask(50)
        x, y = np.divmod(np.array(asked), 100)
        excess = np.maximum(0, 60 - x)[:, None] / 60
        search.tell(asked, np.where(excess > 0, math.nan, (x + y)[:, None] / 100), excess)
        designs += asked
    x, y = np.divmod(np.array(designs[-100:]), 100)
    assert ((x >= 60) & (x + y < 110)).mean() > 0.3  # by chance 0.1


@pytest.mark.parametrize(
    ("objectives", "constraints", "conditions"),
    [
        (("plan_time_worst_s", "slices", "power"), (), {}),
        (("plan_time_mean_s", "energy_j"), ("power < 1.2 W",), {}),
        (("energy_j",), (), {}),
        (("plan_time_95_s", "power", "slices"), ("time < 1 ms", "slices < 20 %"), {}),
        (("plan_time_worst_s", "power"), (), {"workload.problem.starts.seed": [1, 2, 3]}),
        (("energy_j * plan_time_worst_s", "slices"), (), {}),
    ],
)
def test_the_front_that_is_proved_is_that_of_the_enumeration(
    platform: Platform,
    small: Workload,
    objectives: tuple[str, ...],
    constraints: tuple[str, ...],
    conditions: dict[str, Any],
) -> None:
    workload = of(small, AXES, objectives, constraints, conditions=conditions)
    every = explore(platform, workload, workers=1)
    proved = explore(platform, workload, workers=1, search="bound")
    assert proved.front == every.front
    assert proved.search is not None
    assert proved.search.proved
    trace = proved.search.traces[0]
    check_boxes(every, trace)
    assert len(trace.designs) < len(every.designs) / 2


def test_bounds_are_below_every_design(platform: Platform, small: Workload) -> None:
    workload = of(
        small,
        AXES,
        ("plan_time_worst_s", "plan_time_mean_s", "plan_time_95_s", "first_plan_s", "energy_j", "power", "cycles"),
    )
    every = explore(platform, workload, workers=1)
    explored = Explored.of(platform, workload)
    space = Space(workload.explore.axes, "")  # type: ignore[union-attr]
    bounds = Bounds(space, space, explored.section, Pricer(explored, space))
    costs = np.column_stack([every.judged.figure(figure) for figure in every.objectives])
    random = np.random.default_rng(5)
    checked = 0
    for family in bounds.families():
        opened = bounds.open(family)
        assert opened is not None
        ends = np.sort(np.array([[random.integers(size, size=2) for size in family.sizes] for _ in range(60)]), axis=2)
        low, last = ends[:, :, 0], ends[:, :, 1]
        for own, bottom, top in zip(opened.costs(low, last), low, last, strict=True):
            for _ in range(5):
                place = [int(random.integers(a, b + 1)) for a, b in zip(bottom, top, strict=True)]
                row = costs[bounds.design(family.part, family.at(place))]
                held = ~np.isnan(row)
                assert (own[held] <= row[held]).all()
                checked += int(held.all())
    assert checked > 300


def test_families_that_are_out_are_excluded_as_a_whole(platform: Platform, small: Workload) -> None:
    axes = {**AXES, "fpga.clock": [MHZ(mhz) for mhz in (100, 300, 450)]}
    workload = of(small, axes, constraints=("time < 1 us",))
    every = explore(platform, workload, workers=1)
    proved = explore(platform, workload, workers=1, search="bound")
    assert (proved.front, proved.feasible) == (every.front, every.feasible) == ((), ())
    assert proved.search is not None
    whys = {box.why.split(" ")[0] for box in proved.search.excluded}
    assert whys == {"clock", "constraint"}


@pytest.mark.parametrize("name", SEARCHES)
def test_conditional_axes(platform: Platform, small: Workload, name: str) -> None:
    axes = {
        "workload.variant": ["base", "other"],
        "relax.block": [[6, 8], [4, 4]],
        "fpga.clock": [MHZ(mhz) for mhz in (60, 90, 120)],
        "pci.clock": [MHZ(mhz) for mhz in (10, 33, 66)],
    }
    when = {"relax.block": {"workload.variant": ["base"]}}
    workload = of(small, axes, when=when)
    every = explore(platform, workload, workers=1)
    budget = None if name == "bound" else Budget(points=27)
    study = explore(platform, workload, workers=1, search=name, seed=1, budget=budget)
    assert set(study.feasible) <= set(every.feasible)
    assert all(study.designs[index].axes == every.designs[index].axes for index in study.feasible)
    if name in ("bound", "random"):
        assert study.front == every.front


def test_one_store_for_all_searches(platform: Platform, small: Workload, tmp_path: Path) -> None:
    workload, file = of(small, AXES), tmp_path / "points.sqlite"
    first = explore(platform, workload, workers=1, store=file, search="nsga2", seed=4, budget=Budget(points=60))
    again = explore(platform, workload, workers=1, store=file, search="nsga2", seed=4, budget=Budget(points=60))
    assert again == first == load_study(file)
    assert again.search is not None
    assert first.search is not None
    assert again.search.simulated == 0
    assert [trace.designs for trace in again.search.traces] == [trace.designs for trace in first.search.traces]
    proved = explore(platform, workload, workers=1, store=file, search="bound")
    assert proved.search is not None
    assert proved.search.simulated == 0
    every = explore(platform, workload, workers=1, store=file)
    assert not every.simulations
    assert every.front == proved.front
    assert explore(platform, workload, workers=1) == every == load_study(file)


def test_workers_change_nothing(platform: Platform, small: Workload) -> None:
    workload = of(small, AXES)
    one, two = (
        explore(platform, workload, workers=workers, search="nsga2", seed=2, budget=Budget(points=60))
        for workers in (1, 2)
    )
    assert one == two


def test_a_space_that_is_too_large_to_hold(platform: Platform, small: Workload, tmp_path: Path) -> None:
    axes = {
        **AXES,
        "fpga.clock": [f"{khz} kHz" for khz in range(50_000, 150_000, 100)],
        "pci.clock": [f"{khz} kHz" for khz in range(10_000, 60_000, 50)],
        "pci.burst_words": list(range(1, 300)),
    }
    workload, file = of(small, axes), tmp_path / "points.sqlite"
    assert workload.explore is not None
    assert workload.explore.points > 10**9
    study = explore(platform, workload, workers=1, store=file, search="random", seed=1, budget=Budget(points=40))
    assert len(study.designs) == 40 == len(study.feasible)
    assert load_study(file) == study
    design = study.designs[study.front[0]]
    assert study.decisions.index(design.axes) == design.index
    assert len(study.to_json()) > 1000
    assert study.points[3].result is not None
    with pytest.raises(InputError, match="too many to explore"):
        explore(platform, workload, workers=1)


def test_hypervolume() -> None:
    pytest.importorskip("moocore")
    scale = Scale.of(np.array([[0.0, 1.0], [1.0, 0.0], [math.nan, math.nan]]))
    assert scale.hypervolume(np.array([[0.0, 1.0]])) == pytest.approx(1.1 * 0.1 / 1.21)
    assert scale.hypervolume(np.array([[0.0, 1.0], [1.0, 0.0]])) == pytest.approx(0.21 / 1.21)
    assert scale.hypervolume(np.full((1, 2), math.nan)) == 0
    assert scale.reference.tolist() == [1.1, 1.1]


def test_the_hypervolume_of_a_search_rises_to_that_of_the_front(platform: Platform, small: Workload) -> None:
    study = explore(platform, of(small, AXES), workers=1, search="bound")
    proved, random = curves_of(study)
    assert proved.evaluations[-1] == random.evaluations[-1]
    assert list(proved.hypervolumes) == sorted(proved.hypervolumes)  # type: ignore[type-var]
    assert proved.hypervolumes[-1] >= random.hypervolumes[-1]  # type: ignore[operator]


def test_nothing_is_feasible(platform: Platform, small: Workload) -> None:
    workload = of(small, AXES, constraints=("time < 1 ns",))
    for name in SAMPLING:
        study = explore(platform, workload, workers=1, search=name, budget=Budget(points=30))
        assert study.feasible == ()
        assert study.reasons


@pytest.mark.parametrize(
    ("name", "seed", "budget", "axes", "what"),
    [
        ("nsga", 0, 10, AXES, "there is no search nsga\n  hint: did you mean nsga2"),
        ("tpe", -1, 10, AXES, "-1 is no seed"),
        ("tpe", 2**32, 10, AXES, "4294967296 is no seed"),
        ("random", 0, None, AXES, "has no end of its own"),
        ("random", 0, 10, {"relax.iterations": [2]}, "there is nothing to search"),
    ],
)
def test_refusals(
    platform: Platform, small: Workload, name: str, seed: int, budget: int | None, axes: dict[str, Any], what: str
) -> None:
    limit = Budget(points=budget) if budget else None
    with pytest.raises(InputError) as refused:
        explore(platform, of(small, axes), workers=1, search=name, seed=seed, budget=limit)
    assert what in str(refused.value)


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "optuna", None)
    problem = Problem(space_of({"a.x": [1, 2]}), ("f",), (False,), ())
    with pytest.raises(InputError, match=r"Optuna is not installed(.|\n)*hwsw-codesign\[search\]"):
        search_of(Searching(sampler="tpe"), problem)


def test_figures_are_declared() -> None:
    assert {"plan_time_worst_s", "power"} <= FIGURES.keys()
