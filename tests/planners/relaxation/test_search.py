"""Gradient descent search: every step lower, no corner cut, and counts that agree with following cell by cell."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign import maps
from codesign.ground.errors import InputError
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.relaxation.plan import Ending, Search, descend, solve
from codesign.planners.relaxation.plan.parameters import RelaxParameters
from codesign.planners.relaxation.plan.planner import PLANNER, Plan, search_of

ROOMS = maps.rooms(40, 52, room=(12, 16), door=3, seed=2).free
GOAL = (3, 3)


@pytest.mark.parametrize("neighbours", [4, 8])
@pytest.mark.parametrize("boundary", ["low_goal", "high_goal", "high_walls"])
def test_ways_fall_to_the_goal(neighbours: int, boundary: str) -> None:
    potential = solve(ROOMS, [GOAL], method="gs", boundary=boundary, max_iterations=3000).potential
    upwards = boundary == "high_goal"
    search = Search(potential, ROOMS, [GOAL], neighbours=neighbours, upwards=upwards)
    height = -potential if upwards else potential
    lengths = maps.distance_octile(ROOMS, [GOAL]) if neighbours == 8 else maps.distance_steps(ROOMS, [GOAL])
    arrived = 0
    for start in map(tuple, np.argwhere(ROOMS)[::17]):
        way = search.follow(start)
        arrived += way.arrived
        for (row, column), (down, right) in zip(way.cells, np.diff(way.cells, axis=0), strict=False):
            assert height[row + down, column + right] < height[row, column]
            assert max(abs(down), abs(right)) == 1
            assert ROOMS[row + down, column]
            assert ROOMS[row, column + right]
            assert neighbours == 8 or abs(down) + abs(right) == 1
        if way.arrived:
            assert tuple(way.cells[-1]) == GOAL
            assert way.length >= lengths[start] - 1e-9
    assert arrived >= (100 if boundary != "high_walls" else 20)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25)
def test_counts_agree_with_following_every_cell(seed: int) -> None:
    grid = maps.random_obstacles(12, 15, density=0.3, seed=seed).free.copy()
    grid[5, 5] = True
    # Few iterations, so that far cells are still flat.
    potential = solve(grid, [(5, 5)], method="gs", max_iterations=4).potential
    search = Search(potential, grid, [(5, 5)])
    arriving, flat = search.arriving(), search.flat()
    for cell in map(tuple, np.argwhere(grid)):
        way = search.follow(cell)
        assert way.arrived == arriving[cell]
        if way.ending is Ending.FLAT:
            assert flat[tuple(way.cells[-1])]
        assert (way.ending is Ending.UNREACHABLE) == (not search.reachable[cell])
        for before, after in pairwise(way.cells):
            assert potential[tuple(after)] < potential[tuple(before)]


def test_starts_that_cannot_be_used() -> None:
    free = np.array([[True, True, False, True]])
    potential = solve(free, [(0, 0)]).potential
    assert descend(potential, free, [(0, 0)], (0, 3)).ending is Ending.UNREACHABLE
    assert descend(potential, free, [(0, 0)], (0, 0)).cells.tolist() == [[0, 0]]
    for start, words in (((0, 2), "on an obstacle"), ((0, 4), "outside"), ((-1, 0), "outside"), ("a", "not a cell")):
        with pytest.raises(InputError, match=words):
            descend(potential, free, [(0, 0)], start)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="neighbours"):
        Search(potential, free, [(0, 0)], neighbours=6)
    with pytest.raises(InputError, match="potential"):
        Search(potential[:, :2], free, [(0, 0)])


def test_quality_counts_what_the_search_does() -> None:
    starts = tuple((int(row), int(column)) for row, column in np.argwhere(ROOMS)[5::60])
    problem = Problem(ROOMS, (GOAL,), starts)
    parameters = RelaxParameters(method="am", omega=1.5)
    plan = PLANNER.plan(Job(problem, parameters))
    quality = PLANNER.quality(problem, plan)
    assert quality.share_reaching_goal == 1.0
    assert quality.local_maxima == 0
    assert quality.starts_arrived == quality.starts == len(starts)
    assert quality.path_length_ratio_mean is not None
    assert 1.0 <= quality.path_length_ratio_mean <= (quality.path_length_ratio_worst or 0.0)
    early = Plan(solve(ROOMS, [GOAL], method="gs", max_iterations=20), 8)
    short = PLANNER.quality(problem, early)
    arriving = search_of(problem, early).arriving()
    assert short.share_reaching_goal == (arriving.sum() - 1) / (ROOMS.sum() - 1) < 1.0
    assert short.local_maxima is not None
    assert short.local_maxima > 0
    assert short.starts_arrived < short.starts


def test_planner_says_how_the_potential_came_about() -> None:
    problem = Problem(ROOMS, (GOAL,), ())
    plan = PLANNER.plan(Job(problem, RelaxParameters(method="mam")))
    details = PLANNER.figures(plan)["details"]
    assert details["ended"] == "every cell descends"
    assert details["checks"] == details["iterations"] / 10
    assert (details["omega"], details["r"]) == (1.0, 1.0)
    assert details["node_updates"] == 2 * details["iterations"] * (int(ROOMS.sum()) - 1)
    assert PLANNER.check(Job(problem, RelaxParameters(method="half_sweep_am"))) is None
    two = Problem(ROOMS, (GOAL, (3, 4)), ())
    assert PLANNER.check(Job(two, RelaxParameters(method="half_sweep_am"))) is not None
