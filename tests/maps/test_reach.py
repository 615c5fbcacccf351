"""Reach, distances and clearance against slow oracles and against MovingAI's published optimal lengths."""

from __future__ import annotations

import networkx
import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from places import SHARED

from codesign import maps
from codesign.ground.errors import MapError

MOVINGAI = SHARED / "maps" / "movingai"
SQRT2 = 2.0**0.5


@st.composite
def free_and_goals(draw: st.DrawFn) -> tuple[np.ndarray, list[tuple[int, int]]]:
    shape = draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
    free = draw(arrays.arrays(bool, shape, elements=st.sampled_from([True, True, True, False])))
    free[draw(st.integers(0, shape[0] - 1)), draw(st.integers(0, shape[1] - 1))] = True
    cells = [tuple(cell) for cell in np.argwhere(free).tolist()]
    return free, draw(st.lists(st.sampled_from(cells), min_size=1, max_size=3))


def grid_graph(free: np.ndarray, *, diagonal: bool) -> networkx.Graph:
    cells = {tuple(cell) for cell in np.argwhere(free).tolist()}
    graph = networkx.Graph()
    graph.add_nodes_from(cells)
    for row, column in cells:
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            other = row + down, column + right
            slanted = down * right != 0
            beside = {(row + down, column), (row, column + right)}
            if other in cells and (not slanted or (diagonal and beside <= cells)):
                graph.add_edge((row, column), other, weight=SQRT2 if slanted else 1.0)
    return graph


@given(free_and_goals())
@settings(max_examples=examples(150))
def test_distances_agree_with_networkx(case: tuple[np.ndarray, list[tuple[int, int]]]) -> None:
    free, goals = case
    for diagonal in (False, True):
        lengths = networkx.multi_source_dijkstra_path_length(grid_graph(free, diagonal=diagonal), set(goals))
        expected = np.full(free.shape, np.inf)
        for cell, length in lengths.items():
            expected[cell] = length
        if diagonal:
            octile = maps.distance_octile(free, goals)
            assert octile.dtype == np.float64
            np.testing.assert_allclose(octile, expected, rtol=1e-12)
        else:
            steps = maps.distance_steps(free, goals)
            assert steps.dtype == np.int32
            assert np.array_equal(np.where(steps < 0, np.inf, steps), expected)
            assert np.array_equal(maps.reachable(free, goals), np.isfinite(expected))


@given(free_and_goals())
@settings(max_examples=60)
def test_clearance_is_the_distance_to_the_nearest_obstacle(case: tuple[np.ndarray, list[tuple[int, int]]]) -> None:
    free, _ = case
    obstacles = np.argwhere(~np.pad(free, 1)) - 1
    for cell, found in np.ndenumerate(maps.clearance(free)):
        expected = np.sqrt(((obstacles - np.array(cell)) ** 2).sum(axis=1).min())
        assert found == pytest.approx(expected, abs=1e-12)


def test_the_walk_through_a_large_spiral_counts_every_cell() -> None:
    free = maps.spiral(255, 255).free
    steps = maps.distance_steps(free, [(0, 0)])
    assert steps.max() == free.sum() - 1
    assert maps.distance_octile(free, [(0, 0)])[free].max() == free.sum() - 1


def test_large_fronts_agree_with_a_heap() -> None:
    """More than 1024 cells stand in one bucket here, so the buckets have to grow."""
    free = maps.empty(1500, 1500).free
    goals = [(row, 0) for row in range(1500)]
    assert np.array_equal(maps.distance_octile(free, goals), np.tile(np.arange(1500.0), (1500, 1)))
    rows, columns = np.indices(free.shape)
    down, right = np.abs(rows - 700), np.abs(columns - 800)
    expected = np.maximum(down, right) + (SQRT2 - 1) * np.minimum(down, right)
    np.testing.assert_allclose(maps.distance_octile(free, [(700, 800)]), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("map_file", "scenario_file", "every"),
    [
        ("dao/arena.map", "dao/arena.map.scen", 1),
        ("cities/Berlin_0_256.map", "cities/Berlin_0_256.map.scen", 20),
        ("mazes/maze512-32-0.map", "mazes/maze512-32-0.map.scen", 400),
        ("rooms/16room_000.map", "rooms/16room_000.map.scen", 150),
        ("mapf/maze-128-128-2.map", "mapf/scen-random/maze-128-128-2-random-1.scen", 20),
        ("mapf/room-64-64-16.map", "mapf/scen-random/room-64-64-16-random-1.scen", 10),
        ("mapf/random-64-64-20.map", "mapf/scen-random/random-64-64-20-random-2.scen", 10),
        ("mapf/warehouse-10-20-10-2-1.map", "mapf/scen-random/warehouse-10-20-10-2-1-random-1.scen", 10),
    ],
)
def test_octile_distance_is_movingais_optimal_length(map_file: str, scenario_file: str, every: int) -> None:
    if not (MOVINGAI / map_file).exists():
        pytest.skip("the MovingAI maps do not lie beside the repository")
    grid = maps.read_map(MOVINGAI / map_file)
    scenarios = maps.read_scenarios(MOVINGAI / scenario_file)[::every]
    assert len(scenarios) > 10
    for scenario in scenarios:
        assert scenario.shape == grid.shape
        distance = maps.distance_octile(grid.free, [scenario.goal])[scenario.start]
        assert distance == pytest.approx(scenario.optimal_length, abs=0.005)


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ([], "there is no goal"),
        ([(1, 1)], r"goal \(1, 1\) is on an obstacle\n  hint: nearest free cell \(0, 1\)"),
        ([(0, 0), (0, 3)], r"outside of the map of 2 × 3 cells\n  hint: nearest free cell \(0, 2\)"),
        ([(-1, 0)], r"goal \(-1, 0\) is outside"),
        ([(10**30, 0)], "outside"),
        ([(0.5, 1)], "is not a cell"),
        ([(1, 2, 3)], "is not a cell"),
        ([7], "is not a cell"),
    ],
)
def test_goals_that_cannot_be_used(cells: list[tuple[int, int]], message: str) -> None:
    free = np.array([[True, True, True], [True, False, True]])
    for function in (maps.reachable, maps.distance_steps, maps.distance_octile):
        with pytest.raises(MapError, match=message):
            function(free, cells)


def test_a_map_without_free_cells_says_so() -> None:
    free = np.zeros((2, 2), dtype=bool)
    assert maps.nearest_free(free, (0, 0)) is None
    with pytest.raises(MapError, match="no free cell at all"):
        maps.check_cells(free, [(0, 0)], name="start")


@given(free_and_goals(), st.integers(-2, 10), st.integers(-2, 10))
@settings(max_examples=60)
def test_nearest_free_cell(case: tuple[np.ndarray, list[tuple[int, int]]], row: int, column: int) -> None:
    free, _ = case
    found = maps.nearest_free(free, (row, column))
    inside = min(max(row, 0), free.shape[0] - 1), min(max(column, 0), free.shape[1] - 1)
    distances = {(r, c): (r - inside[0]) ** 2 + (c - inside[1]) ** 2 for r, c in np.argwhere(free).tolist()}
    assert found == min(distances, key=lambda cell: (distances[cell], cell))
