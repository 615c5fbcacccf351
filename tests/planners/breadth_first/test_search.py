"""Breadth-first search: the kernel against the plain reference, against other people's searches, and closed forms."""

from __future__ import annotations

import itertools
import pickle

import networkx
import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from places import SHARED
from pydantic import ValidationError
from reference_breadth_first import mark_path, trail

from codesign import maps
from codesign.ground.errors import InputError, MapError
from codesign.planners.breadth_first.plan import EAST, NEIGHBOURS, WEST, BreadthFirstPlan, search, search_nearest
from codesign.planners.breadth_first.plan.parameters import SearchParameters
from codesign.planners.breadth_first.plan.planner import PLANNER
from codesign.planners.interface import Problem
from codesign.planners.job import Job

REAL_MAPS = SHARED / "maps" / "movingai"


@st.composite
def problems(draw: st.DrawFn) -> tuple[NDArray[np.bool_], tuple[int, int], list[tuple[int, int]]]:
    rows, columns = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    cells = draw(st.lists(st.booleans(), min_size=rows * columns, max_size=rows * columns))
    free = np.array(cells, np.bool_).reshape(rows, columns)
    place = st.tuples(st.integers(0, rows - 1), st.integers(0, columns - 1))
    start, goals = draw(place), draw(st.lists(place, min_size=1, max_size=3))
    for cell in (start, *goals):
        free[cell] = True
    return free, start, goals


@settings(max_examples=examples(300))
@given(problems())
def test_kernel_leaves_what_the_listing_leaves(
    given_problem: tuple[NDArray[np.bool_], tuple[int, int], list[tuple[int, int]]],
) -> None:
    free, start, goals = given_problem
    before = free.copy()
    expected, plan = trail(free, start, tuple(goals)), search_nearest(free, start, goals)
    assert (free == before).all()
    assert (plan.directions == expected.directions).all()
    assert plan.popped_cells == expected.popped
    assert plan.queue_depth == expected.depth
    assert plan.goal == expected.goal
    assert tuple(map(tuple, np.stack(np.divmod(plan.pushed, free.shape[1]), 1))) == expected.pushed
    assert tuple(map(tuple, plan.order)) == expected.pushed[: expected.popped]
    if expected.goal is None:
        assert plan.path.shape == (0, 2)
        assert plan.path_steps is None
        assert plan.spreading == len(expected.pushed)
    else:
        assert [tuple(cell) for cell in plan.path] == mark_path(expected.directions, expected.goal)
        on_path = {tuple(cell) for cell in plan.path}
        assert plan.spreading == len([cell for cell in expected.pushed if cell not in on_path])


@settings(max_examples=examples(150))
@given(problems())
def test_path_is_a_shortest_one(
    given_problem: tuple[NDArray[np.bool_], tuple[int, int], list[tuple[int, int]]],
) -> None:
    free, start, goals = given_problem
    plan = search_nearest(free, start, goals)
    steps = int(maps.distance_steps(free, goals)[start])
    assert plan.reached == (steps >= 0)
    if plan.reached:
        assert plan.path_steps == steps
        assert tuple(plan.path[0]) == start
        assert tuple(plan.path[-1]) == plan.goal
        assert (np.abs(np.diff(plan.path, axis=0)).sum(axis=1) == 1).all()
        assert free[tuple(plan.path.T)].all()


@pytest.mark.parametrize(
    "grid",
    [
        maps.maze(61, 81, corridor=2, seed=3, loops=0.2),
        maps.rooms(60, 70, room=(9, 9), door=2, seed=4),
        maps.random_obstacles(80, 80, density=0.3, seed=5),
        maps.spiral(41, 41),
    ],
    ids=lambda grid: grid.source.split("(")[0],
)
def test_lengths_are_those_of_networkx(grid: maps.OccupancyGrid) -> None:
    graph = networkx.grid_2d_graph(*grid.shape)
    graph.remove_nodes_from([tuple(cell) for cell in np.argwhere(~grid.free).tolist()])
    start = maps.nearest_free(grid.free, (0, 0))
    assert start is not None
    lengths = networkx.single_source_shortest_path_length(graph, start)
    for goal in list(lengths)[:: max(1, len(lengths) // 25)]:
        assert search(grid.free, start, goal).path_steps == lengths[goal]
    # Popped in the order of distance: the search never comes back to a nearer ring.
    whole = search(grid.free, start, list(lengths)[-1])
    rings = [lengths[tuple(cell)] for cell in whole.order.tolist()]
    assert rings == sorted(rings)


def test_neighbours_are_looked_at_north_south_west_east() -> None:
    assert NEIGHBOURS == ((-1, 0), (1, 0), (0, -1), (0, 1))
    plan = search(np.ones((3, 3), np.bool_), (1, 1), (2, 2))
    assert plan.order.tolist()[:5] == [[1, 1], [0, 1], [2, 1], [1, 0], [1, 2]]
    # (2, 2) is discovered from the south neighbour, which is popped before the east one.
    assert plan.path.tolist() == [[1, 1], [2, 1], [2, 2]]
    assert plan.directions[2, 2] == WEST
    assert plan.directions[1, 0] == EAST
    assert plan.directions[1, 1] == -1


@pytest.mark.parametrize("side", [1, 2, 7, 40])
def test_an_empty_square_from_corner_to_corner(side: int) -> None:
    plan = search(np.ones((side, side), np.bool_), (0, 0), (side - 1, side - 1))
    assert plan.popped_cells == plan.pushed_cells == side**2
    assert plan.path_steps == 2 * (side - 1)
    assert plan.spreading == side**2 - (2 * side - 1)
    # The queue holds one diagonal and the beginning of the next.
    assert plan.queue_depth == side


def test_a_corridor_has_no_spreading() -> None:
    plan = search(np.ones((1, 50), np.bool_), (0, 0), (0, 49))
    assert (plan.popped_cells, plan.path_steps, plan.spreading, plan.queue_depth) == (50, 49, 0, 1)


def test_start_on_the_goal() -> None:
    plan = search(np.ones((4, 4), np.bool_), (2, 2), (2, 2))
    assert (plan.popped_cells, plan.path.tolist(), plan.path_steps) == (1, [[2, 2]], 0)


def test_no_way_is_an_answer() -> None:
    free = np.ones((3, 5), np.bool_)
    free[:, 2] = False
    plan = search(free, (0, 0), (0, 4))
    assert not plan.reached
    assert plan.goal is None
    assert plan.popped_cells == plan.pushed_cells == plan.spreading == 6


@pytest.mark.parametrize(
    ("start", "goal", "what"),
    [
        ((0, 9), (0, 0), "start .* outside"),
        ((0, 0), (-1, 0), "goal .* outside"),
        ((1, 1), (0, 0), "start .* obstacle"),
        ((0, 0), (1, 1), "goal .* obstacle"),
        ((0, 0), (0.5, 1), "not a cell"),
        (None, (0, 0), "not a cell"),
    ],
)
def test_start_or_goal_that_cannot_be_used(start: object, goal: object, what: str) -> None:
    free = np.ones((3, 3), np.bool_)
    free[1, 1] = False
    with pytest.raises(MapError, match=what):
        search(free, start, goal)  # type: ignore[arg-type]


@pytest.mark.parametrize("free", [np.ones(5, np.bool_), np.ones((2, 2)), np.ones((0, 3), np.bool_)])
def test_map_that_cannot_be_used(free: NDArray[np.bool_]) -> None:
    with pytest.raises(MapError):
        search(free, (0, 0), (0, 1))


def test_no_goal_at_all() -> None:
    with pytest.raises(MapError, match="no goal"):
        search_nearest(np.ones((2, 2), np.bool_), (0, 0), [])


@pytest.mark.parametrize("kind", ["dao", "mazes", "rooms", "cities"])
def test_real_maps(kind: str) -> None:
    files = sorted((REAL_MAPS / kind).rglob("*.map"))[:1]
    if not files:
        pytest.skip("the real maps are not at hand")
    free = maps.read_map(files[0]).free
    start = maps.nearest_free(free, (0, 0))
    assert start is not None
    distance = maps.distance_steps(free, [start])
    octile = maps.distance_octile(free, [start])
    for goal in np.argwhere(distance >= 0)[:: max(1, int((distance >= 0).sum()) // 5)]:
        steps = search(free, start, (int(goal[0]), int(goal[1]))).path_steps
        assert steps == distance[tuple(goal)]
        assert steps >= octile[tuple(goal)] - 1e-6


# The planner as a plug-in.


@pytest.fixture(scope="module")
def problem() -> Problem:
    grid = maps.rooms(24, 32, room=(11, 15), door=3, seed=5)
    return Problem(grid.free, ((2, 2),), ((20, 28), (5, 20), (2, 2)))


def test_quality_is_of_a_search_from_each_start(problem: Problem) -> None:
    plan = PLANNER.plan(Job(problem, SearchParameters()))
    quality = PLANNER.quality(problem, plan)
    assert (quality.starts, quality.starts_arrived) == (3, 3)
    steps = [
        int(maps.distance_steps(problem.free, problem.goals)[start]) for start in problem.starts if start != (2, 2)
    ]
    straight = [
        float(maps.distance_octile(problem.free, problem.goals)[start]) for start in problem.starts if start != (2, 2)
    ]
    ratios = [a / b for a, b in zip(steps, straight, strict=True)]
    assert quality.path_length_ratio_mean == pytest.approx(np.mean(ratios))
    assert quality.path_length_ratio_worst == pytest.approx(max(ratios))
    assert quality.clearance_mean is not None
    assert quality.clearance_least is not None
    assert quality.clearance_mean >= quality.clearance_least >= 1.0


def test_a_start_without_a_way_has_not_arrived() -> None:
    free = np.ones((3, 5), np.bool_)
    free[:, 2] = False
    lost = Problem(free, ((0, 4),), ((0, 0), (2, 4)))
    plan = PLANNER.plan(Job(lost, SearchParameters()))
    assert PLANNER.figures(plan)["details"] == {
        "answer": "no solution",
        "popped_cells": 6,
        "pushed_cells": 6,
        "spreading_cells": 6,
        "path_steps": "no way",
        "queue_depth_cells": 3,
    }
    quality = PLANNER.quality(lost, plan)
    assert (quality.starts, quality.starts_arrived) == (2, 1)
    points, arrived = PLANNER.trajectory(lost, plan, (0, 0))
    assert (points.tolist(), arrived) == ([[0.0, 0.0]], False)


def test_trajectory_is_the_path(problem: Problem) -> None:
    plan = PLANNER.plan(Job(problem, SearchParameters()))
    for start in problem.starts:
        points, arrived = PLANNER.trajectory(problem, plan, start)
        assert arrived
        assert points.dtype == np.float64
        assert (points == search(problem.free, start, (2, 2)).path).all()


def test_identity_is_that_of_the_answer(problem: Problem) -> None:
    plan = PLANNER.plan(Job(problem, SearchParameters()))
    assert isinstance(pickle.loads(pickle.dumps(plan)), BreadthFirstPlan)
    assert PLANNER.identity(pickle.loads(pickle.dumps(plan))) == PLANNER.identity(plan)
    free = problem.free.copy()
    free[2, 4] = False
    other = PLANNER.plan(Job(Problem(free, problem.goals, problem.starts), SearchParameters()))
    assert PLANNER.identity(other) != PLANNER.identity(plan)


def test_flows_are_the_map_the_directions_and_the_path(problem: Problem) -> None:
    flows = {(flow.sender, flow.receiver): flow for flow in PLANNER.flows(Job(problem, SearchParameters()))}
    steps = search(problem.free, problem.starts[0], (2, 2)).path_steps
    assert steps is not None
    assert flows["load", "search"].bits == flows["search", "track"].bits == 2 * 24 * 32
    assert flows["track", "command"].bits == 2 * steps
    still = Problem(problem.free, (problem.starts[0],), problem.starts[:1])
    assert PLANNER.flows(Job(still, SearchParameters()))[-1].bits == 2, "a path of no step is told too"


def test_way_from_beside_the_path_goes_back_to_it(problem: Problem) -> None:
    plan = PLANNER.plan(Job(problem, SearchParameters()))
    on_path = {tuple(cell) for cell in plan.path.tolist()}
    shortest = maps.distance_steps(problem.free, [plan.start])
    with_path = 0
    for cell in map(tuple, np.argwhere(problem.free).tolist()):
        points, arrived = PLANNER.path_from(problem, plan, (float(cell[0]), float(cell[1])))
        came = plan.directions[cell] >= 0 or cell == plan.start
        assert arrived == came
        if not arrived:
            continue
        with_path += 1
        cells = [tuple(each) for each in points.astype(int).tolist()]
        assert cells[0] == cell
        assert cells[-1] == plan.goal
        assert all(abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1 for a, b in itertools.pairwise(cells))
        met = next(index for index, each in enumerate(cells) if each in on_path)
        assert set(cells[met:]) <= on_path
        # Back along the tree of discovery: one nearer to the start with every step.
        assert [int(shortest[each]) for each in cells[: met + 1]] == list(
            range(int(shortest[cell]), int(shortest[cell]) - met - 1, -1)
        )
    assert with_path > len(on_path)


def test_a_problem_without_start_is_refused(problem: Problem) -> None:
    nowhere = Problem(problem.free, problem.goals, ())
    assert PLANNER.check(Job(problem, SearchParameters())) is None
    refused = PLANNER.check(Job(nowhere, SearchParameters()))
    assert refused is not None
    assert "no start" in refused[1]
    with pytest.raises(InputError, match="no start"):
        PLANNER.plan(Job(nowhere, SearchParameters()))


@pytest.mark.parametrize(
    "given",
    [{"queue_words": 0}, {"external_cycles": 0}, {"micro_architecture": "fast"}, {"queue_words": True}, {"speed": 3}],
)
def test_parameters_that_are_refused(given: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        SearchParameters.model_validate(given)
