"""Quality counts over the cells that a plan covers: what was never computed is neither good nor bad."""

from __future__ import annotations

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from reference_breadth_first import trail

from codesign import maps
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.wavefront.paper.measures import dijkstra, edges
from codesign.system import catalog

PARAMETERS = {
    "harmonic": {"blocks": (1, 1), "iterations": 50, "schedule": (7, 63), "stop": "schedule_end"},
    "relaxation": {"method": "direct"},
}


@st.composite
def problems(draw: st.DrawFn) -> Problem:
    """A random map, one or two goals, and one to three starts with a path by sides to a goal."""
    rows, columns = draw(st.integers(1, 9)), draw(st.integers(2, 9))
    density = draw(st.floats(0, 0.5))
    free = np.random.default_rng(draw(st.integers(0, 10**6))).random((rows, columns)) >= density
    free[draw(st.integers(0, rows - 1)), draw(st.integers(0, columns - 1))] = True
    cells = [(int(row), int(column)) for row, column in np.argwhere(free)]
    goals = draw(st.lists(st.sampled_from(cells), min_size=1, max_size=2, unique=True))
    starts = [(int(row), int(column)) for row, column in np.argwhere(maps.reachable(free, goals))]
    return Problem(free, tuple(goals), tuple(draw(st.lists(st.sampled_from(starts), min_size=1, max_size=3))))


def off_goals(problem: Problem, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    blocked = cells.copy()
    blocked[tuple(np.array(problem.goals).T)] = False
    return blocked


@given(problems(), st.booleans(), st.sampled_from(["starts", "whole_map"]))
@settings(max_examples=examples(100))
def test_a_stopped_wave_is_judged_by_the_cells_that_it_reached(problem: Problem, cutting: bool, stop: str) -> None:
    planner = catalog.planner("wavefront")
    parameters = planner.tasks["propagate"].model_validate({"stop": stop, "corner_cutting": cutting})
    quality = planner.quality(problem, planner.plan(Job(problem, parameters)))
    everything = dijkstra(problem.free, problem.goals, corner_cutting=cutting)
    ended = everything.max() if stop == "whole_map" else everything[problem.starts[0]]
    covered = off_goals(problem, (everything >= 0) & (everything <= ended))
    flat = [
        cell
        for cell in map(tuple, np.argwhere(covered).tolist())
        if all(everything[other] >= everything[cell] for other, _ in edges(problem.free, cell, cutting))
    ]
    assert quality.reachable_cells == int(off_goals(problem, everything >= 0).sum())
    assert quality.planned_cells == int(covered.sum())
    assert quality.local_maxima == len(flat) == 0
    assert quality.share_reaching_goal == (1.0 if covered.any() else None)
    assert quality.starts_arrived == quality.starts == len(problem.starts)


@given(problems())
@settings(max_examples=60)
def test_a_search_is_judged_by_the_cells_that_it_came_to(problem: Problem) -> None:
    planner = catalog.planner("breadth_first")
    plan = planner.plan(Job(problem, planner.tasks["search"]()))
    quality = planner.quality(problem, plan)
    come_to = trail(problem.free, problem.starts[0], problem.goals).pushed
    covered = set(come_to) - set(problem.goals)
    assert quality.planned_cells == len(covered)
    assert quality.share_reaching_goal == (1.0 if covered else None)
    arriving = [cell for cell in covered if planner.path_from(problem, plan, (float(cell[0]), float(cell[1])))[1]]
    assert len(arriving) == len(covered)
    assert quality.planned_cells <= quality.reachable_cells


def test_a_search_without_an_answer_covers_no_cell() -> None:
    problem = Problem(np.array([[1, 1, 0, 1, 1]], bool), ((0, 4),), ((0, 0),))
    planner = catalog.planner("breadth_first")
    quality = planner.quality(problem, planner.plan(Job(problem, planner.tasks["search"]())))
    assert (quality.reachable_cells, quality.planned_cells, quality.starts_arrived) == (1, 0, 0)
    assert quality.share_reaching_goal is None


@pytest.mark.parametrize("name", PARAMETERS)
@given(problem=problems())
@settings(max_examples=15)
def test_a_field_covers_every_cell_that_leads_to_a_goal(name: str, problem: Problem) -> None:
    planner = catalog.planner(name)
    parameters = planner.tasks["relax"].model_validate(PARAMETERS[name])
    quality = planner.quality(problem, planner.plan(Job(problem, parameters)))
    assert quality.planned_cells == quality.reachable_cells
    assert quality.reachable_cells == int(off_goals(problem, planner.reachable(Job(problem, parameters))).sum())
