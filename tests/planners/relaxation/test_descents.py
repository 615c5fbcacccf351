"""Every field is judged by its descents: reports equal a brute-force count, and the default leads from everywhere."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import Result
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from places import SHARED
from reference_relaxation import iterate

from codesign import maps
from codesign.planners.interface import Problem, Quality
from codesign.planners.job import Job
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, Boundary, End, Method, Search, solve
from codesign.planners.relaxation.plan.parameters import ACCELERATION, SCALE, RelaxParameters
from codesign.planners.relaxation.plan.planner import ANOTHER_PLANNER, PLANNER, Plan

Cell = tuple[int, int]
Run = Callable[..., Result]

REAL = SHARED / "maps"
AROUND = ((-1, 0), (0, 1), (1, 0), (0, -1), (-1, 1), (1, 1), (1, -1), (-1, -1))
SERVING = "every cell of this map leads to a goal"


def lost_cells(free: NDArray[np.bool_], goal: Cell, potential: NDArray[np.float64], upwards: bool) -> int:
    """Cells with a way to the goal from which steepest descent does not arrive: followed cell by cell."""
    rows, columns = free.shape

    def open_(row: int, column: int) -> bool:
        return 0 <= row < rows and 0 <= column < columns and bool(free[row, column])

    joined, front = {goal}, [goal]
    while front:
        row, column = front.pop()
        for down, right in AROUND[:4]:
            cell = row + down, column + right
            if open_(*cell) and cell not in joined:
                joined.add(cell)
                front.append(cell)

    def height(cell: Cell) -> float:
        return float(-potential[cell] if upwards else potential[cell])

    def next_cell(row: int, column: int) -> Cell | None:
        beside = [
            (row + down, column + right)
            for down, right in AROUND
            if open_(row + down, column + right) and open_(row + down, column) and open_(row, column + right)
        ]
        lowest = min(beside, key=height, default=None)
        return lowest if lowest is not None and height(lowest) < height((row, column)) else None

    arrives = {goal: True}
    for start in joined:
        way: list[Cell] = []
        cell: Cell | None = start
        while cell is not None and cell not in arrives:
            way.append(cell)
            cell = next_cell(*cell)
        arrives |= dict.fromkeys(way, cell is not None and arrives[cell])
    return sum(not arrived for arrived in arrives.values())


def judged(free: NDArray[np.bool_], goal: Cell, **parameters: Any) -> tuple[Plan, Quality]:
    problem = Problem(free, (goal,), ())
    plan = PLANNER.plan(Job(problem, RelaxParameters.model_validate(parameters)))
    return plan, PLANNER.quality(problem, plan)


@st.composite
def problems(draw: st.DrawFn) -> tuple[NDArray[np.bool_], Cell]:
    rows, columns = draw(st.integers(2, 14)), draw(st.integers(2, 14))
    density, seed = draw(st.sampled_from([0.0, 0.1, 0.3, 0.45])), draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    free = random.random((rows, columns)) >= density
    goal = draw(st.integers(0, rows - 1)), draw(st.integers(0, columns - 1))
    free[goal] = True
    return free, goal


def takes(method: Method, omega: float, r: float) -> dict[str, float]:
    own = zip(("omega", "r"), (omega, r), ACCELERATION[method], strict=True)
    return {name: value for name, value, default in own if default is not None}


@given(problems())
@settings(max_examples=80)
def test_the_default_leads_from_everywhere_on_random_maps(problem: Any) -> None:
    free, goal = problem
    plan, quality = judged(free, goal)
    assert plan.solution.ended is End.DESCENDS
    assert lost_cells(free, goal, plan.solution.potential, upwards=False) == 0
    assert (quality.cells_leading_nowhere, quality.local_maxima, quality.warnings) == (0, 0, ())


@given(
    problems(),
    st.sampled_from([method for method in Method if method is not Method.DIRECT]),
    st.floats(0.5, 1.98),
    st.floats(0.5, 1.98),
    st.sampled_from([None, 1e-2, 1e-6, 1e-15]),
    st.sampled_from(Boundary),
    st.sampled_from([3, 40, 3000]),
)
@settings(max_examples=examples(150))
def test_what_is_reported_is_what_following_each_cell_gives(
    problem: Any, method: Method, omega: float, r: float, tolerance: float | None, boundary: Boundary, most: int
) -> None:
    free, goal = problem
    plan, quality = judged(
        free,
        goal,
        method=method,
        tolerance=tolerance,
        boundary=boundary,
        max_iterations=most,
        **takes(method, omega, r),
    )
    lost = lost_cells(free, goal, plan.solution.potential, boundary.upwards)
    assert quality.cells_leading_nowhere == lost
    assert (quality.local_maxima == 0) == (lost == 0)
    assert plan.solution.ended is not End.DESCENDS or lost == 0
    assert len(quality.warnings) == (lost > 0)
    assert all(f"{lost:,} of {quality.reachable_cells:,} cells" in words for words in quality.warnings)


@given(
    problems(),
    st.sampled_from([Method.GS, Method.AM, Method.MAM, Method.SOR, Method.RED_BLACK, Method.JACOBI]),
    st.floats(0.3, 1.0),
    st.floats(0.3, 1.0),
    st.integers(1, 12),
)
@settings(max_examples=80)
def test_without_over_relaxation_a_value_that_is_there_has_a_descent(
    problem: Any, method: Method, omega: float, r: float, count: int
) -> None:
    """The proof in ``solve``, watched at work in the plain loops: no cell is ever deeper than its neighbours' mean."""
    free, goal = problem
    values, movable = np.zeros((free.shape[0] + 2, free.shape[1] + 2)), np.pad(free, 1)
    values[goal[0] + 1, goal[1] + 1] = -1.0
    movable[goal[0] + 1, goal[1] + 1] = False
    own = takes(method, omega, r)
    for _ in range(count):
        before, values = values, iterate(values, movable, method, own.get("omega"), own.get("r"))
        assert (values <= before).all(), "depths only grow"
        mean = (values[:-2, 1:-1] + values[2:, 1:-1] + values[1:-1, :-2] + values[1:-1, 2:]) / 4.0
        slack = np.where(movable[1:-1, 1:-1], mean - values[1:-1, 1:-1], 0.0)
        assert (slack <= -1e-15 * mean).all()


@given(problems(), st.sampled_from(Boundary), st.integers(1, 8))
@settings(max_examples=60)
def test_the_look_for_descents_counts_what_the_search_counts(problem: Any, boundary: Boundary, count: int) -> None:
    free, goal = problem
    solution = solve(free, [goal], method="gs", boundary=boundary, max_iterations=count)
    flat = Search(solution.potential, free, [goal], neighbours=4, upwards=boundary.upwards).flat().sum()
    assert (solution.ended is End.DESCENDS) == (flat == 0)


@given(problems(), st.sampled_from(Method), st.floats(0.5, 1.9), st.floats(0.5, 1.9))
@settings(max_examples=60)
def test_a_deep_goal_changes_exponents_and_nothing_else(problem: Any, method: Method, omega: float, r: float) -> None:
    free, goal = problem
    own = takes(method, omega, r)
    low, deep = (
        solve(free, [goal], method=method, boundary=boundary, tolerance=1e-9, max_iterations=300, **own)
        for boundary in ("low_goal", "deep_goal")
    )
    # Products of the smallest values may be below the least double where goals are at -1.
    kept = np.abs(low.potential) > 1e-290
    assert np.array_equal(deep.potential[kept], low.potential[kept] * SCALE)
    assert (deep.iterations, deep.change, deep.ended) == (low.iterations, low.change, low.ended)


def corridor(length: int) -> NDArray[np.bool_]:
    """One cell wide: potentials fall by 2 + √3 a cell, 0.57 decades."""
    return np.ones((1, length), np.bool_)


def test_potentials_below_the_least_double_are_told_with_what_mends_them() -> None:
    plan, quality = judged(corridor(900), (0, 0), boundary="low_goal")
    assert plan.solution.ended is End.CONVERGED
    assert quality.cells_leading_nowhere is not None
    assert 300 < quality.cells_leading_nowhere < 370, "308 decades and the denormal ones: 540 to 570 cells"
    assert "below the least double" in quality.warnings[0]
    assert SERVING in quality.warnings[0]
    _, direct = judged(corridor(900), (0, 0), boundary="low_goal", method="direct")
    assert direct.cells_leading_nowhere is not None
    assert direct.warnings
    assert direct.cells_leading_nowhere > 300
    for method in ("am", "direct"):
        assert judged(corridor(900), (0, 0), method=method)[1].cells_leading_nowhere == 0
    _, too_long = judged(corridor(1400), (0, 0))
    assert too_long.cells_leading_nowhere is not None
    assert too_long.cells_leading_nowhere > 200
    assert ANOTHER_PLANNER in too_long.warnings[0], "neither the default nor the direct solver can mend that"
    assert "below the least double" in too_long.warnings[0]
    _, early = judged(corridor(300), (0, 299), method="gs", tolerance=1e-15)
    assert "ended before values came to far cells" in early.warnings[0]
    assert SERVING in early.warnings[0]


def test_a_continued_run_ends_at_once_or_begins_anew() -> None:
    free = maps.rooms(40, 52, room=(12, 16), door=3, seed=2, extra_doors=0.5).free
    goal = (3, 3)
    old = solve(free, [goal], method="gs", tolerance=1e-12).potential
    same = solve(free, [goal], start=old)
    assert (same.iterations, same.ended, same.change) == (0, End.DESCENDS, 0.0)
    assert np.array_equal(same.potential, old)
    for seed in range(12):
        random = np.random.default_rng(seed)
        fewer = free & (random.random(free.shape) > 0.1)
        fewer[goal] = True
        for method in ("am", "gs", "half_sweep_am"):
            solution = solve(fewer, [goal], method=method, start=old)
            if method == "half_sweep_am" and solution.ended is not End.DESCENDS:
                continue  # to diagonal steps some cells are closed
            assert lost_cells(fewer, goal, solution.potential, upwards=False) == 0


DESIGN = ("--set", "relax.method=sor", "--set", "relax.omega=1.95", "--set", "relax.tolerance=1e-15")


def test_run_compare_and_page_say_that_cells_lead_nowhere(hwsw: Run, tmp_path: Path) -> None:
    design = "pc-3400mhz:floor-plan"
    for settings_, lost in (((), 0), (DESIGN, 5907)):
        told = json.loads(hwsw("compare", design, "--on", "labyrinth", *settings_, "--json").stdout)[design]["quality"]
        assert told["cells_leading_nowhere"] == lost
        assert told["share_reaching_goal"] == (told["reachable_cells"] - lost) / told["reachable_cells"]
        assert len(told["warnings"]) == (lost > 0)
        said = " ".join(hwsw("compare", design, "--on", "labyrinth", *settings_).stdout.split())
        assert ("5,907 of 8,117 cells (72.7 %) lead nowhere" in said) == (lost > 0)
        assert ("converged, but" in said and SERVING in said) == (lost > 0)
    workload = tmp_path / "labyrinth.yaml"
    workload.write_text(
        "kind: workload\nname: labyrinth-in-doubles\nplanner: relaxation\n"
        "problem:\n  map: {generate: maze, rows: 72, columns: 132, corridor: 6, wall: 1, loops: 0.15, seed: 1}\n"
        "  goals: [[3, 128]]\n"
        "mapping: {relax: {component: pc, method: sor, omega: 1.95, tolerance: 1.0e-15}}\n",
        encoding="utf-8",
    )
    text = " ".join(hwsw("run", "pc-3400mhz", workload, "-v", "--html", "page.html").stdout.split())
    page = " ".join((tmp_path / "page.html").read_text(encoding="utf-8").split())
    for shown in (text, page):
        assert "cells that lead nowhere" in shown
        assert "5,907 of 8,117 cells (72.7 %) lead nowhere" in shown


HELD_OUT = {
    "movingai/dao/arena.map": 2,
    "movingai/cities/Berlin_0_256.map": 1,
    "movingai/mapf/maze-128-128-2.map": 2,
    "movingai/mapf/warehouse-10-20-10-2-1.map": 2,
    "movingai/mapf/random-64-64-20.map": 2,
    "movingai/mapf/room-64-64-16.map": 2,
    "movingai/rooms/16room_000.map": 1,
    "ros/nav2/depot.yaml": 1,
    "ros/turtlebot3/map.yaml": 1,
    "ros/willow/lse_arena.yaml": 2,
}


@pytest.mark.skipif(not REAL.is_dir(), reason="the real maps are not here")
@pytest.mark.parametrize("name", HELD_OUT)
def test_the_default_leads_from_everywhere_on_maps_it_was_not_tuned_to(name: str) -> None:
    free = maps.read_map(REAL / name).free
    random = np.random.default_rng(3)
    cells = np.argwhere(free)
    for number in random.integers(0, len(cells), HELD_OUT[name]):
        row, column = (int(value) for value in cells[number])
        plan, quality = judged(free, (row, column))
        assert plan.solution.ended is End.DESCENDS
        assert quality.cells_leading_nowhere == 0


@pytest.mark.skipif(not REAL.is_dir(), reason="the real maps are not here")
def test_over_relaxation_to_the_papers_tolerance_is_told_on_a_real_map() -> None:
    free = maps.read_map(REAL / "movingai/mapf/warehouse-10-20-10-2-1.map").free
    _, quality = judged(free, (29, 145), method="sor", omega=1.95, tolerance=PUBLISHED_TOLERANCE)
    assert quality.share_reaching_goal is not None
    assert quality.share_reaching_goal < 0.5
    assert "over-relaxation (ω = 1.95)" in quality.warnings[0]
    assert SERVING in quality.warnings[0]
