"""Grid search: kernels against plain references, against other people's searches, and what each method promises."""

from __future__ import annotations

import itertools
import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
import reference_grid as reference
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from places import SHARED
from reference_navfn import NavFn
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from codesign import maps
from codesign.ground.models import Task
from codesign.planners.grid_search.plan import GridPlan, Heuristic, Method, SearchParameters, kernels, search
from codesign.planners.grid_search.plan.parameters import DIAGONAL, EUCLIDEAN, NONE, OCTILE, STEPS, STRAIGHT
from codesign.planners.grid_search.plan.planner import PLANNER, successors
from codesign.planners.interface import Problem
from codesign.planners.job import Job

Cell = tuple[int, int]
Asked = tuple[NDArray[np.bool_], Cell, list[Cell]]
REAL_MAPS = SHARED / "maps" / "movingai"
ROOT_TWO = math.sqrt(2.0)


@st.composite
def problems(draw: st.DrawFn, side: int = 9) -> Asked:
    rows, columns = draw(st.integers(1, side)), draw(st.integers(1, side))
    cells = draw(st.lists(st.integers(0, 3), min_size=rows * columns, max_size=rows * columns))
    free = np.array(cells).reshape(rows, columns) > draw(st.integers(0, 1))
    place = st.tuples(st.integers(0, rows - 1), st.integers(0, columns - 1))
    start, goals = draw(place), draw(st.lists(place, min_size=1, max_size=3))
    for cell in (start, *goals):
        free[cell] = True
    return free, start, goals


def flat(free: NDArray[np.bool_], *cells: Cell) -> tuple[list[bool], int, list[int]]:
    """The map with its ring as a list, the length of a row, and cells as indices."""
    stride = free.shape[1] + 2
    return np.pad(free, 1).ravel().tolist(), stride, [(row + 1) * stride + column + 1 for row, column in cells]


def by_scipy(
    free: NDArray[np.bool_], goals: list[Cell], *, cutting: bool, without: Cell | None = None
) -> NDArray[np.float64]:
    """The lengths of the shortest paths to a goal, by Dijkstra's algorithm of scipy over the graph of all steps.

    No path leads through ``without``, which is free.
    """
    padded = np.pad(free, 1)
    rows, columns = free.shape
    index = np.arange(padded.size).reshape(padded.shape)
    begins, ends, costs = [], [], []
    for down, right in STEPS:
        there = padded[1 + down : 1 + down + rows, 1 + right : 1 + right + columns]
        allowed = free & there
        if down and right and not cutting:
            allowed = allowed & padded[1 + down : 1 + down + rows, 1:-1] & padded[1:-1, 1 + right : 1 + right + columns]
        begin = index[1:-1, 1:-1][allowed]
        if without is not None:
            left_out = index[1:-1, 1:-1][without]
            begin = begin[(begin != left_out) & (begin + down * padded.shape[1] + right != left_out)]
        begins.append(begin)
        ends.append(begin + down * padded.shape[1] + right)
        costs.append(np.full(len(begin), ROOT_TWO if down and right else 1.0))
    entries = np.concatenate(costs), (np.concatenate(begins), np.concatenate(ends))
    graph = coo_array(entries, shape=(padded.size, padded.size)).tocsr()
    sources = [index[row + 1, column + 1] for row, column in goals]
    lengths: NDArray[np.float64] = dijkstra(graph, indices=sources, min_only=True)
    return lengths.reshape(padded.shape)[1:-1, 1:-1]


def found_by(free: NDArray[np.bool_], start: Cell, goals: list[Cell], **rules: object) -> GridPlan:
    return search(free, start, goals, SearchParameters.model_validate(rules))


EXACT = list(itertools.product([Method.ASTAR, Method.JUMP_POINT], Heuristic, [False, True]))


@settings(max_examples=examples(150))
@given(problems())
def test_kernels_leave_what_the_references_leave(asked: Asked) -> None:
    free, start, goals = asked
    cells, stride, (target, *sources) = flat(free, start, *goals)
    for method, heuristic, cutting in EXACT:
        rule = (OCTILE, EUCLIDEAN, NONE)[[*Heuristic].index(heuristic)]
        jumping = method is Method.JUMP_POINT
        expected = reference.astar(cells, stride, sources, target, rule, cutting=cutting, jumping=jumping)
        plan = found_by(free, start, goals, method=method, heuristic=heuristic, corner_cutting=cutting)
        same_search(plan, expected)
    same_search(found_by(free, start, goals, method="theta_star"), reference.theta_star(cells, stride, sources, target))


def same_search(plan: GridPlan, expected: reference.Found) -> None:
    assert (plan.expanded, plan.entries, plan.looked) == (expected.expanded, expected.entries, expected.looked)
    assert plan.reached == (expected.end >= 0)
    assert set(np.flatnonzero(plan.settled)) == expected.closed
    for cell in expected.closed:
        assert plan.lengths[cell] == expected.lengths[cell]
        assert plan.before[cell] == expected.before[cell]


@settings(max_examples=examples(150))
@given(problems())
def test_a_star_and_jump_points_are_as_short_as_dijkstra_of_scipy(asked: Asked) -> None:
    free, start, goals = asked
    for cutting in (False, True):
        expected = by_scipy(free, goals, cutting=cutting)[start]
        for method, heuristic, rule in EXACT:
            if rule == cutting:
                plan = found_by(free, start, goals, method=method, heuristic=heuristic, corner_cutting=cutting)
                assert plan.reached == np.isfinite(expected)
                if plan.reached:
                    assert plan.length == pytest.approx(expected, rel=1e-12)
                    is_path(free, plan, start, goals, cutting=cutting)


def is_path(free: NDArray[np.bool_], plan: GridPlan, start: Cell, goals: list[Cell], *, cutting: bool) -> None:
    """The path takes steps between free cells from the start to a goal."""
    cells = [(int(row), int(column)) for row, column in plan.path]
    assert np.array_equal(plan.path, cells)
    assert cells[0] == start
    assert cells[-1] in goals
    for (row, column), (next_row, next_column) in itertools.pairwise(cells):
        assert (next_row - row, next_column - column) in STEPS
        assert free[next_row, next_column]
        assert cutting or (free[next_row, column] and free[row, next_column])


@settings(max_examples=examples(60))
@given(problems())
def test_a_field_has_the_length_from_every_cell(asked: Asked) -> None:
    free, start, goals = asked
    for cutting in (False, True):
        parameters = SearchParameters(corner_cutting=cutting)
        problem = Problem(free, tuple(goals), (start,), task=Task.FIELD)
        plan = PLANNER.plan(Job(problem, parameters))
        expected = by_scipy(free, goals, cutting=cutting)
        assert np.allclose(plan.field, expected, rtol=1e-12)
        for cell in map(tuple, np.argwhere(np.isfinite(expected))):
            points, arrived = PLANNER.trajectory(problem, plan, cell)
            assert arrived
            assert np.hypot(*np.diff(points, axis=0).T).sum() == pytest.approx(expected[cell], rel=1e-12)


@given(st.integers(-(2**25), 2**25), st.integers(-(STRAIGHT - 1), STRAIGHT - 1))
def test_sums_of_integers_stand_in_the_order_of_the_true_lengths(straight: int, diagonal: int) -> None:
    """Of paths that differ by so many steps: the sign of a + b √2, found without rounding."""
    squares = math.copysign(1, straight) * straight**2 + math.copysign(1, diagonal) * 2 * Fraction(diagonal) ** 2
    true = (squares > 0) - (squares < 0)
    total = straight * STRAIGHT + diagonal * DIAGONAL
    assert (total > 0) - (total < 0) == true


@given(st.integers(0, 4000), st.integers(0, 4000), st.sampled_from(STEPS), st.sampled_from([0, 1, 2]))
def test_estimates_are_consistent_and_compiled_alike(rows: int, columns: int, step: Cell, heuristic: int) -> None:
    cost = DIAGONAL if step[0] and step[1] else STRAIGHT
    here = reference.estimate(rows, columns, heuristic)
    near = reference.estimate(abs(rows + step[0]), abs(columns + step[1]), heuristic)
    assert here <= cost + near
    assert near <= cost + here
    assert here <= reference.estimate(rows, columns, OCTILE)
    assert kernels.estimate(rows, columns, heuristic) == here


@pytest.mark.parametrize("cutting", [False, True])
def test_a_neighbour_is_left_out_where_another_path_around_is_as_good(cutting: bool) -> None:
    """The definition of Harabor and Grastien (2011) tried on every block of nine cells."""
    table = successors(cutting)
    steps = STEPS
    for side, mask in itertools.product(range(8), range(256)):
        block = np.zeros((3, 3), np.bool_)
        for bit, (down, right) in enumerate(steps):
            block[1 + down, 1 + right] = mask >> bit & 1
        down, right = steps[side]
        before = (1 - down, 1 - right)
        middle = [block[1 + a, 1 + b] for a, b in ((-down, 0), (0, -right))] if down and right else [True]
        if not block[before] or not (cutting or all(middle)):
            continue
        block[1, 1] = True
        around = by_scipy(block, [before], cutting=cutting, without=(1, 1))
        through = by_scipy(block, [(1, 1)], cutting=cutting)
        own = ROOT_TWO if down and right else 1.0
        for bit, (a, b) in enumerate(steps):
            cell = (1 + a, 1 + b)
            step = ROOT_TWO if a and b else 1.0
            allowed = block[cell] and through[cell] == step and cell != before
            slack = around[cell] - own - step
            kept = slack > 1e-9 or (side >= 4 and slack > -1e-9)
            assert bool(table[side, mask] >> bit & 1) == bool(allowed and kept), (side, mask, bit)


def crossed(begin: NDArray[np.float64], end: NDArray[np.float64]) -> set[Cell]:
    """The cells whose inside a line between the middles of two cells crosses, in exact arithmetic."""
    (row, column), (last_row, last_column) = begin.astype(int).tolist(), end.astype(int).tolist()
    half = Fraction(1, 2)
    cuts = {Fraction(0), Fraction(1)}
    for first, last in ((row, last_row), (column, last_column)):
        if first != last:
            sides = range(min(first, last), max(first, last))
            cuts |= {(side + half - first) / (last - first) for side in sides}
    middles = [(one + other) / 2 for one, other in itertools.pairwise(sorted(cuts))] or [Fraction(0)]
    return {
        (math.floor(row + at * (last_row - row) + half), math.floor(column + at * (last_column - column) + half))
        for at in middles
    }


@settings(max_examples=examples(200))
@given(problems(side=14))
def test_theta_star_sees_along_its_pieces_and_is_no_longer_than_a_star(asked: Asked) -> None:
    free, start, goals = asked
    plan, shortest = (found_by(free, start, goals, method=method) for method in ("theta_star", "astar"))
    assert plan.reached == shortest.reached
    if not plan.reached:
        return
    straight = min(math.dist(start, goal) for goal in goals)
    assert plan.length is not None
    assert shortest.length is not None
    assert straight - 1e-9 <= plan.length <= shortest.length + 1e-9
    cell = flat(free, start)[2][0]
    stride = free.shape[1] + 2
    while (ahead := int(plan.before[cell])) != cell:
        ends = [np.array(divmod(each, stride), np.float64) - 1.0 for each in (cell, ahead)]
        assert all(free[each] for each in crossed(*ends))
        cell = ahead
    assert np.hypot(*np.diff(plan.path, axis=0).T).max(initial=0.0) <= 1.0 + 1e-9 or free.size == 1


@settings(max_examples=examples(150))
@given(problems(side=16))
def test_navfn_leaves_what_its_source_leaves(asked: Asked) -> None:
    """The potentials bit for bit, and every point of the path."""
    free, start, goals = asked
    plan = found_by(free, start, goals, method="navfn")
    expected, points = navfn_of(free, start, goals)
    assert plan.lengths.tolist() == [float(value) for value in expected.potarr]
    assert plan.expanded == expected.updates
    assert plan.reached == (min(expected.potarr[end] for end in flat(free, *goals)[2]) < 1e10)
    if plan.smooth:
        assert plan.path.tolist() == points
    elif plan.reached:
        is_path(free, plan, start, goals, cutting=False)
        values = [plan.field[int(row), int(column)] for row, column in plan.path]
        assert values == sorted(values)


def navfn_of(free: NDArray[np.bool_], start: Cell, goals: list[Cell]) -> tuple[NavFn, list[list[float]]]:
    cells, stride, (target, *ends) = flat(free, start, *goals)
    expected = NavFn(stride, [50 if each else 254 for each in cells], target, ends)
    expected.propagate()
    nearest = min(ends, key=lambda end: float(expected.potarr[end]))
    path = expected.calc_path(nearest, 4 * free.size + 4) if expected.potarr[nearest] < 1e10 else []
    return expected, [[y - 1.0, x - 1.0] for x, y in reversed(path)]


def test_most_paths_of_navfn_over_rooms_stay_free() -> None:
    kept = 0
    for seed in range(8):
        free = maps.rooms(40, 48, room=(12, 14), door=4, wall=2, seed=seed).free
        goals, start = [(3, 3)], (36, 44)
        plan, (_, points) = found_by(free, start, goals, method="navfn"), navfn_of(free, start, goals)
        assert not plan.smooth or plan.path.tolist() == points
        kept += plan.smooth
    assert kept >= 6


def test_the_potential_of_navfn_is_about_the_distance() -> None:
    free = np.ones((61, 61), np.bool_)
    plan = search(free, (30, 30), [(0, 0)], SearchParameters(method=Method.NAVFN))
    rows, columns = np.indices(free.shape)
    distance = np.hypot(rows - 30, columns - 30)
    near = (distance > 5) & np.isfinite(plan.field)
    ratio = plan.field[near] / 50.0 / distance[near]
    assert ratio.min() > 0.95
    assert ratio.max() < 1.12


@pytest.mark.skipif(not REAL_MAPS.is_dir(), reason="no real maps here")
@pytest.mark.parametrize("name", ["cities/Berlin_0_256", "dao/arena", "mazes/maze512-32-0", "rooms/16room_000"])
def test_lengths_are_those_of_the_scenarios(name: str) -> None:
    free = maps.read_map(REAL_MAPS / f"{name}.map").free
    lines = (REAL_MAPS / f"{name}.map.scen").read_text(encoding="utf-8").splitlines()[1:]
    for line in lines[:: max(1, len(lines) // examples(25))]:
        *_, column, row, goal_column, goal_row, length = line.split("\t")
        for method in ("astar", "jump_point"):
            plan = found_by(free, (int(row), int(column)), [(int(goal_row), int(goal_column))], method=method)
            assert plan.length == pytest.approx(float(length), abs=5e-5 * max(1.0, float(length)))


def test_a_plan_crosses_a_process_pool_with_its_path() -> None:
    free = np.ones((4, 5), np.bool_)
    plan = search(free, (0, 0), [(3, 4)])
    again = pickle.loads(pickle.dumps(plan))
    assert PLANNER.identity(again) == PLANNER.identity(plan)
    assert again.path.tolist() == plan.path.tolist()


def test_a_field_of_another_method_is_refused() -> None:
    problem = Problem(np.ones((4, 5), np.bool_), ((0, 0),), ((3, 4),), task=Task.FIELD)
    for method in Method:
        refused = PLANNER.check(Job(problem, SearchParameters(method=method)))
        assert (refused is None) == (method is Method.ASTAR)
        assert refused is None or refused[0] == "method"
