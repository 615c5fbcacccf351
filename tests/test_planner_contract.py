"""One suite for every planner and every style that is installed: a new one adds its sample here."""

from __future__ import annotations

import pickle
from dataclasses import asdict
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from codesign import maps
from codesign.memo import Memo
from codesign.planners.interface import Planner, Problem, Quality
from codesign.system import catalog

# Parameters of the planning task, small enough to run in a moment, for each planner.
SAMPLES: dict[str, list[dict[str, Any]]] = {
    "harmonic": [
        {"block": (12, 16), "iterations": 6, "schedule": (7, 15, 23)},
        {"blocks": (3, 2), "iterations": 1, "schedule": (9, 40), "termination": "published"},
        {"blocks": (1, 1), "iterations": 40, "schedule": (70,), "stop": "schedule_end"},
    ],
    "breadth_first": [{}, {"micro_architecture": "pipelined"}],
    "wavefront": [{}, {"stop": "starts"}, {"paths": "safe", "tile": (8, 8)}],
    "velocity_obstacle": [{}, {"updates": 40}],
    "relaxation": [
        {"method": "sor", "omega": 1.8, "tolerance": 1e-9},
        {"method": "mam", "omega": 1.7, "r": 1.5},
    ],
}
CASES = [
    (name, index) for name in sorted(catalog.planners()) for index in range(len(SAMPLES.get(name, [{}])))
]


@pytest.fixture(params=CASES, ids=lambda case: f"{case[0]}-{case[1]}")
def case(request: pytest.FixtureRequest) -> tuple[Planner, Any]:
    name, index = request.param
    planner = catalog.planner(name)
    assert name in SAMPLES, f"give planner {name} its sample parameters in {__file__}"
    return planner, planner.tasks[planner.planning_task].model_validate(SAMPLES[name][index])


# The problem of planners that have one of their own, and another that differs in one place.
PROBLEMS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "velocity_obstacle": (
        {"robots": {"count": 4, "arrangement": "circle"}},
        {"robots": {"count": 5, "arrangement": "circle"}},
    )
}


@pytest.fixture
def problem(case: tuple[Planner, Any]) -> Any:
    model = case[0].problem_model
    return _grid_problem() if model is None else model.model_validate(PROBLEMS[case[0].name][0]).problem()


@pytest.fixture
def other_problem(case: tuple[Planner, Any]) -> Any:
    model = case[0].problem_model
    if model is not None:
        return model.model_validate(PROBLEMS[case[0].name][1]).problem()
    problem = _grid_problem()
    free = problem.free.copy()
    free[2, 4] = not free[2, 4]
    starts = tuple(start for start in problem.starts if free[start])
    return Problem(free=free, goals=problem.goals, starts=starts)


@pytest.fixture
def grid_problem(problem: Any) -> Problem:
    if not isinstance(problem, Problem):
        pytest.skip("the planner's problem is not a map with goals and starts")
    return problem


@cache
def _grid_problem() -> Problem:
    grid = maps.generate("rooms", rows=24, columns=32, room=(11, 15), door=3, seed=5)
    cells = np.argwhere(maps.reachable(grid.free, [(2, 2)]))
    starts = tuple((int(row), int(column)) for row, column in cells[3::40])
    return Problem(free=grid.free, goals=((2, 2),), starts=starts)


def drained(steps: Any) -> tuple[list[Any], Any]:
    found = []
    while True:
        try:
            found.append(next(steps))
        except StopIteration as done:
            return found, done.value


def test_planner_names_its_planning_task(case: tuple[Planner, Any]) -> None:
    planner, _ = case
    assert planner.planning_task in planner.tasks
    assert catalog.planners()[planner.name] is planner


def test_same_answer_twice(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    first, second = planner.plan(problem, parameters), planner.plan(problem, parameters)
    assert planner.identity(first) == planner.identity(second)
    assert planner.figures(first) == planner.figures(second)


def test_another_problem_another_answer(case: tuple[Planner, Any], problem: Any, other_problem: Any) -> None:
    planner, parameters = case
    plans = [planner.plan(each, parameters) for each in (problem, other_problem)]
    assert planner.identity(plans[0]) != planner.identity(plans[1])
    assert problem.digest != other_problem.digest


def test_messages_are_sent_and_answered(case: tuple[Planner, Any], problem: Any) -> None:
    messages = case[0].messages(problem)
    assert messages.problem_bits > 0
    assert messages.answer_bits > 0
    assert messages.problem != messages.answer


def test_every_style_drains_to_the_plan(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    plan = planner.plan(problem, parameters)
    styles = catalog.styles_of(planner.name)
    assert styles
    for style in styles.values():
        steps, drawn = drained(style.work(problem, parameters, detail=True))
        assert planner.identity(drawn) == planner.identity(plan)
        assert planner.figures(drawn) == planner.figures(plan)
        assert all(int(step.cycles.min()) >= 1 for step in steps if len(step.cycles))


def test_coarse_steps_cost_the_same(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    for style in catalog.styles_of(planner.name).values():
        memo = Memo()
        runs = [
            drained(style.work(problem, parameters, detail=True)),
            drained(style.work(problem, parameters, memo=memo, detail=False)),
            drained(style.work(problem, parameters, memo=memo, detail=False)),
        ]
        assert memo.hits, "the second coarse run found nothing to share"
        sums = []
        for steps, plan in runs:
            phases: dict[str, int] = {}
            for step in steps:
                phases[step.phase] = phases.get(step.phase, 0) + int(step.cycles.sum())
            sums.append((phases, planner.identity(plan), planner.figures(plan)))
        assert sums[0] == sums[1] == sums[2]


def test_quality_is_of_this_problem(case: tuple[Planner, Any], grid_problem: Problem) -> None:
    planner, parameters = case
    problem = grid_problem
    quality = planner.quality(problem, planner.plan(problem, parameters))
    reachable = maps.reachable(problem.free, problem.goals)
    assert quality.reachable_cells == int(reachable.sum()) - len(problem.goals)
    if quality.share_reaching_goal is not None:
        assert 0.0 <= quality.share_reaching_goal <= 1.0
        assert quality.local_maxima is None or (quality.local_maxima == 0) == (
            quality.share_reaching_goal == 1.0
        )
    assert quality.starts == len(problem.starts)
    assert quality.wrong_cells is None or 0 <= quality.wrong_cells <= quality.reachable_cells
    assert 0 <= quality.starts_arrived <= quality.starts
    if quality.starts_arrived:
        assert quality.path_length_ratio_worst >= quality.path_length_ratio_mean > 0.9
        assert quality.clearance_mean >= quality.clearance_least >= 1.0
    assert isinstance(quality, Quality)
    assert pickle.loads(pickle.dumps(quality)) == quality
    assert set(asdict(quality)) >= {"local_maxima", "share_reaching_goal"}


def test_trajectories_stay_in_free_space(case: tuple[Planner, Any], grid_problem: Problem) -> None:
    planner, parameters = case
    problem = grid_problem
    plan = planner.plan(problem, parameters)
    arrivals = 0
    for start in problem.starts:
        points, arrived = planner.trajectory(problem, plan, start)
        assert points.dtype == np.float64
        assert points.shape[1] == 2
        # Every point of the way between the samples too: ten steps between each pair.
        dense = np.concatenate([np.linspace(a, b, 11) for a, b in pairwise(points)] or [points])
        cells = np.floor(dense + 0.5).astype(int)
        assert problem.free[cells[:, 0], cells[:, 1]].all()
        last = tuple(int(value) for value in np.floor(points[-1] + 0.5))
        assert arrived == (last in problem.goals)
        arrivals += arrived
    assert arrivals == planner.quality(problem, plan).starts_arrived


def test_plans_and_parameters_cross_a_process_pool(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    plan = planner.plan(problem, parameters)
    assert planner.identity(pickle.loads(pickle.dumps(plan))) == planner.identity(plan)
    assert pickle.loads(pickle.dumps(parameters)) == parameters
