"""One suite for every planner and every style that is installed: a new one adds its sample here."""

from __future__ import annotations

import pickle
from dataclasses import asdict, replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from codesign import maps
from codesign.memo import Memo
from codesign.planners.interface import Planner, Problem, Quality
from codesign.planners.styles import RESOURCES
from codesign.spec import load_part
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
        {"method": "direct"},
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


def test_flows_lead_from_the_map_to_the_answer(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    flows = planner.flows(problem, parameters)
    known = {*planner.tasks, "load", "command"}
    assert {task for flow in flows for task in (flow.sender, flow.receiver)} <= known
    assert all(flow.bits > 0 and flow.name for flow in flows)
    assert len({(flow.sender, flow.receiver, flow.name) for flow in flows}) == len(flows)
    assert any((flow.sender, flow.receiver) == ("load", planner.planning_task) for flow in flows)
    assert len(answers(planner, flows)) == 1
    # Every task is reached from the map, and none twice on its way: the flows of one plan make no cycle.
    done, left = {"load"}, list(flows)
    while ready := [
        flow
        for flow in left
        if all(other.sender in done for other in left if other.receiver == flow.receiver)
    ]:
        done |= {flow.receiver for flow in ready}
        left = [flow for flow in left if flow not in ready]
    assert not left
    assert {"command", planner.planning_task} <= done


# Bits of the map (or the robots) and of the answer, on the problem above, where parameters do not change them.
SENT: dict[str, tuple[int, int]] = {
    "harmonic": (2 * 24 * 32, 64),
    "breadth_first": (2 * 24 * 32, 2 * 3),
    "wavefront": (2 * 24 * 32, 64),
    "relaxation": (2 * 24 * 32, 64),
    "velocity_obstacle": (4 * 4 * 16, 4 * 2 * 16),
}


def test_flows_bring_what_one_plan_sends(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    flows = planner.flows(problem, parameters)
    brought = [flow.bits for flow in flows if (flow.sender, flow.receiver) == ("load", planner.planning_task)]
    told = [flow.bits for flow in flows if flow.receiver == "command"]
    assert (brought, told) == tuple([bits] for bits in SENT[planner.name])


def test_a_plan_that_stands_changes_no_flow_but_its_size(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    sizes = getattr(planner, "flows_after", None)
    if sizes is None:
        pytest.skip("the planner knows the sizes before")
    before = planner.flows(problem, parameters)
    after = sizes(problem, parameters, planner.plan(problem, parameters))
    assert [replace(flow, bits=1) for flow in after] == [replace(flow, bits=1) for flow in before]
    assert all(0 < one.bits <= other.bits for one, other in zip(after, before, strict=True))


def test_a_pose_goes_to_the_task_that_answers(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    flows = planner.flows(problem, parameters)
    asked = [(flow.sender, flow.receiver) for flow in flows if flow.name == "pose"]
    assert asked in ([], [("load", answer) for answer in answers(planner, flows)])
    # Asked again it costs something, wherever it is done.
    for _, task in asked:
        kinds = {style.component_type for style in catalog.styles_of(planner.name).values()}
        assert kinds <= {
            style.component_type for style in catalog.task_styles_of(planner.name, task).values()
        }


def test_policies_are_known_and_have_what_they_take(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    assert planner.policies[0] == "restart"
    assert set(planner.policies) <= {"restart", "lower_bound", "continue"}
    assert ("lower_bound" in planner.policies) == ("lower_bound" in planner.tasks)
    start = planner.start_of(planner.plan(problem, parameters))
    assert ("continue" in planner.policies) == (start is not None)


def answers(planner: Planner, flows: Any) -> set[str]:
    return {flow.sender for flow in flows if flow.receiver == "command"}


def phases_of(steps: list[Any]) -> dict[str, int]:
    found: dict[str, int] = {}
    for step in steps:
        if len(step.cycles):
            found[step.phase] = found.get(step.phase, 0) + int(step.cycles.sum())
    return found


def test_work_leaves_out_the_answer_where_it_is_placed_elsewhere(
    case: tuple[Planner, Any], problem: Any
) -> None:
    planner, parameters = case
    (answer,) = answers(planner, planner.flows(problem, parameters))
    everything = frozenset(planner.tasks)
    for style in catalog.styles_of(planner.name).values():
        whole, plan = drained(style.work(problem, parameters))
        same, _ = drained(style.work(problem, parameters, inside=everything))
        for detail in (True, False):
            without = everything - {answer} | {planner.planning_task}
            steps, again = drained(style.work(problem, parameters, inside=without, detail=detail))
            left = phases_of(steps)
            gone = set(phases_of(whole)) - set(left)
            # Software that searches breadth first has its path in the cost of a cell.
            none = answer == planner.planning_task or (planner.name, style.component_type) == (
                "breadth_first",
                "processor",
            )
            assert len(gone) == (0 if none else 1)
            assert left == {phase: spent for phase, spent in phases_of(whole).items() if phase not in gone}
            assert planner.identity(again) == planner.identity(plan)
        assert phases_of(same) == phases_of(whole)


def test_styles_on_a_processor_tell_every_kernel_they_need(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    for style in catalog.styles_of(planner.name).values():
        steps, _ = drained(style.work(problem, parameters))
        if style.component_type == "processor":
            told = getattr(style, "kernels", lambda _, style=style: (style.kernel,))(parameters)
            assert {step.kernel or style.kernel for step in steps} <= set(told)
        else:
            assert not style.kernel
            assert not any(step.kernel for step in steps)


def test_what_is_done_elsewhere_takes_nothing_of_the_part(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    (answer,) = answers(planner, planner.flows(problem, parameters))
    without = frozenset(planner.tasks) - {answer} | {planner.planning_task}
    # Where the published circuits tell what the answering task takes.
    saves = {("harmonic", "bit_serial")}
    for style in catalog.styles_of(planner.name).values():
        part = load_part("XC2VP30-6") if style.component_type == "fpga" else None
        whole = style.demand(problem, parameters, part)
        assert style.demand(problem, parameters, part, inside=frozenset(planner.tasks)) == whole
        left = style.demand(problem, parameters, part, inside=without)
        assert set(left.items) <= set(whole.items)
        assert [bound.demand for bound in left.bounds] == [bound.demand for bound in whole.bounds]
        assert set(left.levers) <= set(whole.levers)
        less = {kind for kind in RESOURCES if left.total(kind) < whole.total(kind)}
        assert less == ({"slices", "lut4", "flip_flops"} if (planner.name, style.style) in saves else set())
        if part is not None:
            powers = [style.power(demand, 50_000_000, part) for demand in (whole, left)]
            assert powers[0][0] == powers[1][0]
            assert (powers[1][1].value < powers[0][1].value) == bool(less)


def test_going_on_from_the_own_answer_is_no_slower_and_as_good(
    case: tuple[Planner, Any], grid_problem: Problem
) -> None:
    planner, parameters = case
    plan = planner.plan(grid_problem, parameters)
    start = planner.start_of(plan)
    for style in catalog.styles_of(planner.name).values():
        cold, _ = drained(style.work(grid_problem, parameters))
        warm, again = drained(style.work(grid_problem, parameters, start=start))
        assert sum(phases_of(warm).values()) <= sum(phases_of(cold).values())
        before, after = (planner.quality(grid_problem, each) for each in (plan, again))
        assert after.starts_arrived >= before.starts_arrived
        coarse, _ = drained(style.work(grid_problem, parameters, start=start, detail=False))
        assert phases_of(coarse) == phases_of(warm)


def test_a_lower_bound_ends_in_the_same_bits(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    if "lower_bound" not in planner.policies:
        pytest.skip("the planner knows no lower bound")
    parameters = parameters.model_copy(update={"stop": "schedule_end"})
    ((_, maker),) = catalog.task_styles_of(planner.name, "lower_bound").items()
    made, bound = drained(maker.steps(problem, parameters, None, (0.0, 0.0)))
    assert sum(int(step.cycles.sum()) for step in made) == int(problem.free.sum())
    plan = planner.plan(problem, parameters)
    for style in catalog.styles_of(planner.name).values():
        cold, _ = drained(style.work(problem, parameters))
        warm, again = drained(style.work(problem, parameters, start=bound))
        assert planner.identity(again) == planner.identity(plan)
        assert phases_of(warm)["relax"] < phases_of(cold)["relax"]


def test_tasks_by_themselves_are_those_of_the_planner(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    plan = planner.plan(problem, parameters)
    answering = answers(planner, planner.flows(problem, parameters))
    for (name, task, _, _), style in catalog.task_styles().items():
        if name != planner.name:
            continue
        assert task in planner.tasks
        assert (style.component_type == "processor") == bool(style.kernel)
        assert style.description
        assert not style.description.endswith(".")
        position = tuple(map(float, problem.starts[0]))
        steps, made = drained(style.steps(problem, parameters, plan, position))
        assert all(int(step.cycles.min()) >= 1 for step in steps)
        if style.component_type == "processor":
            assert style.demand(problem, parameters, None).items == ()
        if task in answering:
            points, arrived = planner.way(problem, plan, position)
            assert np.array_equal(made[0], points)
            assert made[1] == arrived


def test_ways_from_any_position_keep_to_free_cells(case: tuple[Planner, Any], grid_problem: Problem) -> None:
    planner, parameters = case
    problem = grid_problem
    plan = planner.plan(problem, parameters)
    random = np.random.Generator(np.random.PCG64(3))
    for start in problem.starts[:12]:
        middle, arrived = planner.way(problem, plan, (float(start[0]), float(start[1])))
        for off in random.uniform(-0.49, 0.49, (8, 2)):
            position = (start[0] + float(off[0]), start[1] + float(off[1]))
            points, there = planner.way(problem, plan, position)
            assert points.dtype == np.float64
            assert tuple(points[0]) == position
            assert there == arrived
            dense = np.concatenate([np.linspace(a, b, 41) for a, b in pairwise(points)] or [points])
            cells = np.floor(dense + 0.5).astype(int)
            # A corner that a way cuts is on the edge of a cell: only what is inside of an obstacle counts.
            inside = np.abs(dense - cells).max(axis=1) < 0.5 - 1e-9
            assert problem.free[cells[inside, 0], cells[inside, 1]].all()
            if there:
                assert tuple(np.floor(points[-1] + 0.5).astype(int)) in problem.goals
        if arrived:
            assert np.allclose(middle, planner.trajectory(problem, plan, start)[0])


def test_no_way_from_where_no_robot_can_be(case: tuple[Planner, Any], grid_problem: Problem) -> None:
    planner, parameters = case
    plan = planner.plan(grid_problem, parameters)
    wall = tuple(float(value) for value in np.argwhere(~grid_problem.free)[0])
    for position in (wall, (-3.0, 2.0), (2.0, 1e6)):
        points, arrived = planner.way(grid_problem, plan, position)
        assert points.tolist() == [list(position)]
        assert not arrived


def test_every_style_drains_to_the_plan(case: tuple[Planner, Any], problem: Any) -> None:
    planner, parameters = case
    styles = catalog.styles_of(planner.name)
    assert styles
    for style in styles.values():
        settled = style.settled(parameters)
        assert style.settled(settled) == settled
        assert style.notes(problem, settled) == ()
        plan = planner.plan(problem, settled)
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
    reachable = planner.reachable(problem, parameters)
    assert quality.reachable_cells == int(reachable.sum()) - len(problem.goals)
    assert 0 <= quality.planned_cells <= quality.reachable_cells
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
