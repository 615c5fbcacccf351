"""A run refuses the starts that its own planner cannot lead to a goal, and no others."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mission_specs import Ground
from numpy.typing import NDArray
from reference_breadth_first import trail
from reference_harmonic import relax_reference

from codesign.ground.errors import SpecError
from codesign.inputs import Platform, Workload
from codesign.maps import OccupancyGrid
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.relaxation.plan.planner import STEPS
from codesign.planners.wavefront.paper.measures import dijkstra
from codesign.planners.wavefront.plan import propagate
from codesign.system import catalog
from codesign.system.scenarios import bind, simulate

Cell = tuple[int, int]
Map = NDArray[np.bool_]

CUT = np.array([[1, 0], [0, 1]], bool)
"""Two free cells that touch at a corner, between two obstacles."""


def by_relaxation(free: Map, goals: list[Cell]) -> Map:
    """Where the exact potential is above 0. A cell k steps from a goal is at least 4^-k, less what floors take."""
    plan = relax_reference(free, goals, block=free.shape, iterations=1000, schedule=[5 * free.size])
    return np.asarray(plan.field.to_ints() > 0)


def by_search(free: Map, goals: list[Cell]) -> Map:
    reached = np.zeros_like(free)
    for row, column in np.argwhere(free).tolist():
        reached[row, column] = trail(free, (row, column), tuple(goals)).goal is not None
    return reached


def by_steps(free: Map, goals: list[Cell]) -> Map:
    """Cells joined to a goal by the steps of gradient descent search: a diagonal one cuts no corner."""
    reached = np.zeros_like(free)
    waiting = list(goals)
    while waiting:
        row, column = waiting.pop()
        reached[row, column] = True
        for down, right in STEPS:
            cell = row + down, column + right
            inside = 0 <= cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1]
            if inside and free[cell] and not reached[cell] and free[row, cell[1]] and free[cell[0], column]:
                waiting.append(cell)
    return reached


def by_waves(cutting: bool) -> Callable[[Map, list[Cell]], Map]:
    return lambda free, goals: dijkstra(free, goals, corner_cutting=cutting) >= 0


CASES: dict[str, tuple[str, dict[str, Any], Callable[[Map, list[Cell]], Map]]] = {
    "harmonic": ("harmonic", {"relax": {"block": None, "blocks": [1, 1]}}, by_relaxation),
    "breadth_first": ("breadth-first", {}, by_search),
    **{
        f"grid-{method}": ("grid-search", {"search": {"method": method}}, by_waves(False))
        for method in ("astar", "jump_point", "theta_star", "navfn")
    },
    "grid-corners": ("grid-search", {"search": {"method": "jump_point", "corner_cutting": True}}, by_waves(True)),
    "relaxation-4": ("relaxation", {"relax": {"neighbours": 4}}, by_steps),
    "relaxation-8": ("relaxation", {"relax": {"neighbours": 8}}, by_steps),
    "wavefront": ("wavefront", {"propagate": {"corner_cutting": True}}, by_waves(True)),
    "wavefront-whole-map": ("wavefront", {"propagate": {"corner_cutting": True, "stop": "whole_map"}}, by_waves(True)),
    "wavefront-adder": (
        "wavefront",
        {"propagate": {"corner_cutting": True, "style": "adder_comparator"}},
        by_waves(True),
    ),
    "wavefront-no-corners": ("wavefront-host", {}, by_waves(False)),
}


@cache
def point(case: str) -> tuple[Platform, Workload]:
    """A platform, and a workload that plans once with that planner."""
    placement, mapping, _ = CASES[case]
    with TemporaryDirectory() as folder:
        once = {"scenario": {"=": {"type": "plan_once"}}}
        return Ground(Path(folder)).point(placement, mapping=mapping, workload=once)


def on_map(case: str, free: Map, goals: list[Cell], starts: list[Cell]) -> tuple[Any, Any, OccupancyGrid]:
    """Platform, workload and map of a case with another problem."""
    platform, workload = point(case)
    problem = workload.problem.model_copy(update={"goals": tuple(goals), "starts": tuple(starts)})
    return platform, workload.model_copy(update={"problem": problem}), OccupancyGrid(free)


def refused(case: str, free: Map, goals: list[Cell], starts: list[Cell]) -> set[int]:
    """The starts, by number, that a run refuses as they lead to no goal; any other fault fails the test."""
    platform, workload, grid = on_map(case, free, goals, starts)
    try:
        bind(platform, workload, grid=grid)
    except SpecError as wrong:
        faults = wrong.faults
    else:
        return set()
    assert all("no path leads from start" in each.what for each in faults), faults
    return {int(each.key.removeprefix("problem.starts[").removesuffix("]")) for each in faults}


@st.composite
def problems(draw: st.DrawFn) -> tuple[Map, list[Cell]]:
    """A map of up to 5 × 5 cells, and one or two goals that another cell can be left for."""
    rows, columns = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    free = np.array(draw(st.lists(st.booleans(), min_size=rows * columns, max_size=rows * columns)), bool)
    free = free.reshape(rows, columns)
    free[draw(st.integers(0, rows - 1)), draw(st.integers(0, columns - 1))] = True
    cells = [(int(row), int(column)) for row, column in np.argwhere(free)]
    return free, draw(st.lists(st.sampled_from(cells), min_size=1, max_size=2, unique=True))


@pytest.mark.parametrize("case", CASES)
@given(problem=problems())
@example(problem=(CUT, [(1, 1)]))
@settings(max_examples=examples(30))
def test_a_start_is_refused_where_the_planner_s_reference_does_not_reach_it(
    case: str, problem: tuple[Map, list[Cell]]
) -> None:
    free, goals = problem
    planner = catalog.planner(point(case)[1].planner)
    reached = CASES[case][2](free, goals)
    parameters = point(case)[1].mapping[planner.planning_task].parameters
    assert np.array_equal(planner.reachable(Job(Problem(free, tuple(goals), ()), parameters)), reached)
    if any(reached[goal] and _alone(reached, free, goal, case) for goal in goals):
        return  # A goal that no other cell leads to is refused by itself.
    starts = [(int(row), int(column)) for row, column in np.argwhere(free)]
    # A search answers "no solution"; every other planner is refused such a start.
    wanted = set() if planner.answers_no_way else {index for index, cell in enumerate(starts) if not reached[cell]}
    assert refused(case, free, goals, starts) == wanted


def _alone(reached: Map, free: Map, goal: Cell, case: str) -> bool:
    return free.sum() > 1 and int(CASES[case][2](free, [goal]).sum()) == 1


def test_a_start_that_the_wave_reaches_by_a_cut_corner_is_planned_for() -> None:
    """The case of the report: ``propagate`` gives 3, the run said that the goal is walled in."""
    assert propagate(CUT, [(1, 1)])[0, 0] == 3
    result = simulate(*on_map("wavefront", CUT, [(1, 1)], [(0, 0)])[:2], grid=OccupancyGrid(CUT))
    assert result.quality is not None
    assert (result.quality.starts_arrived, result.quality.reachable_cells) == (1, 1)
    # No path that leaves corners alone exists to hold its length against.
    assert result.quality.path_length_ratio_mean is None
    for case in ("harmonic", "relaxation-8", "wavefront-no-corners"):
        with pytest.raises(SpecError, match="walled in"):
            bind(*on_map(case, CUT, [(1, 1)], [(0, 0)])[:2], grid=OccupancyGrid(CUT))


@pytest.mark.parametrize("case", ["breadth_first", "wavefront", "wavefront-no-corners", "relaxation-8"])
def test_drawn_starts_are_the_same_for_every_planner(case: str) -> None:
    """They are those with a path by sides, which every planner here takes: planners are compared on one problem."""
    free = np.array([[1, 1, 0], [1, 1, 0], [0, 0, 1]], bool)
    platform, workload, grid = on_map(case, free, [(0, 0)], [(0, 1)])
    drawn = workload.problem.model_copy(update={"starts": type(workload.problem).model_fields["starts"].default})
    system = bind(platform, workload.model_copy(update={"problem": drawn}), grid=grid)
    assert system.problem.starts == ((0, 1), (1, 0), (1, 1))
