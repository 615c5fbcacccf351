"""Generators: exact sizes, the shape each promises, the same cells everywhere, and refusals."""

from __future__ import annotations

import pickle
from typing import Any

import networkx
import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign import maps
from codesign.ground.errors import MapError
from codesign.maps import OccupancyGrid, generate


def graph_of(free: np.ndarray) -> networkx.Graph:
    """The 4-connected graph of the free cells, built in the plainest way."""
    graph = networkx.Graph()
    rows, columns = free.shape
    for row, column in np.argwhere(free).tolist():
        graph.add_node((row, column))
        for below, right in ((1, 0), (0, 1)):
            if row + below < rows and column + right < columns and free[row + below, column + right]:
                graph.add_edge((row, column), (row + below, column + right))
    return graph


def test_same_seed_gives_the_same_cells_on_every_machine() -> None:
    digests = {
        "maze": generate("maze", rows=33, columns=65, seed=7).digest,
        "loops": generate("maze", rows=40, columns=65, corridor=2, wall=2, seed=7, loops=0.2).digest,
        "rooms": generate("rooms", rows=48, columns=96, room=(8, 12), seed=7, extra_doors=0.3).digest,
        "random": generate("random", rows=48, columns=96, density=0.2, seed=7, size=3).digest,
    }
    assert {name: digest[:16] for name, digest in digests.items()} == {
        "maze": "2a7baad0a3cad2b8",
        "loops": "1c31df875a067856",
        "rooms": "cdf5180290e2fa30",
        "random": "c06cb2204873341e",
    }


@given(st.integers(1, 24), st.integers(1, 24), st.integers(0, 2**64 - 1))
@settings(max_examples=60)
def test_a_maze_of_single_cells_is_a_tree(rows: int, columns: int, seed: int) -> None:
    grid = maps.maze(rows, columns, seed=seed)
    assert grid.shape == (rows, columns)
    assert networkx.is_tree(graph_of(grid.free))
    assert grid.free[0 : rows + 1 : 2, 0 : columns + 1 : 2].sum() == ((rows + 1) // 2) * ((columns + 1) // 2)


@given(st.integers(1, 4), st.integers(1, 3), st.integers(1, 6), st.integers(1, 6), st.integers(0, 99))
@settings(max_examples=60)
def test_wide_corridors_are_the_narrow_maze_stretched(
    corridor: int, wall: int, down: int, across: int, seed: int
) -> None:
    pitch = corridor + wall
    narrow = maps.maze(2 * down - 1, 2 * across - 1, seed=seed)
    wide = maps.maze(down * pitch - wall + 1, across * pitch - wall, corridor=corridor, wall=wall, seed=seed)
    thickness = [corridor, wall]
    stretched = np.repeat(narrow.free, [thickness[row % 2] for row in range(narrow.rows)], axis=0)
    stretched = np.repeat(stretched, [thickness[column % 2] for column in range(narrow.columns)], axis=1)
    assert np.array_equal(wide.free[: stretched.shape[0]], stretched)
    # The row too many holds no whole corridor.
    assert stretched.shape[0] == wide.rows - 1
    assert not wide.free[stretched.shape[0] :].any()


@pytest.mark.parametrize("loops", [0.0, 0.25, 1.0])
def test_loops_open_that_share_of_the_remaining_walls(loops: float) -> None:
    graph = graph_of(maps.maze(21, 31, seed=3, loops=loops).free)
    rooms = 11 * 16
    walls = 10 * 16 + 11 * 15
    remaining = walls - (rooms - 1)
    # Each opened wall is a cell with two edges, and closes one loop.
    assert graph.number_of_edges() - graph.number_of_nodes() + 1 == round(loops * remaining)


@given(
    st.integers(1, 40),
    st.integers(1, 40),
    st.tuples(st.integers(1, 9), st.integers(1, 9)),
    st.integers(1, 3),
    st.integers(0, 99),
    st.sampled_from([0.0, 0.5, 1.0]),
    st.data(),
)
@settings(max_examples=examples(100))
def test_rooms_are_whole_and_joined(
    rows: int, columns: int, room: tuple[int, int], wall: int, seed: int, extra: float, data: st.DataObject
) -> None:
    door = data.draw(st.integers(1, min(room)))
    grid = maps.rooms(rows, columns, room=room, door=door, wall=wall, seed=seed, extra_doors=extra)
    assert grid.shape == (rows, columns)
    in_room = np.outer(np.arange(rows) % (room[0] + wall) < room[0], np.arange(columns) % (room[1] + wall) < room[1])
    assert grid.free[in_room].all()
    assert maps.reachable(grid.free, [(0, 0)])[grid.free].all()
    across = -(-rows // (room[0] + wall)), -(-columns // (room[1] + wall))
    walls = across[0] * (across[1] - 1) + (across[0] - 1) * across[1]
    tree = across[0] * across[1] - 1
    doors = tree + round(extra * (walls - tree))
    opened = int(grid.free[~in_room].sum())
    assert opened <= doors * door * wall
    if (rows % (room[0] + wall) in (0, *range(door, rows + 1))) and (
        columns % (room[1] + wall) in (0, *range(door, columns + 1))
    ):
        assert opened == doors * door * wall


def test_doors_have_different_places() -> None:
    free = maps.rooms(17 * 8, 17, room=(16, 16), door=1, seed=1).free
    places = {int(np.flatnonzero(free[16 + 17 * index])[0]) for index in range(7)}
    assert len(places) > 2


@given(st.integers(1, 12), st.integers(1, 12), st.floats(0, 1), st.integers(0, 99))
@settings(max_examples=60)
def test_random_single_cells_have_the_density_asked_for(rows: int, columns: int, density: float, seed: int) -> None:
    free = maps.random_obstacles(rows, columns, density=density, seed=seed).free
    assert int((~free).sum()) == round(density * rows * columns)
    denser = maps.random_obstacles(rows, columns, density=min(1.0, density + 0.2), seed=seed).free
    assert not (denser & ~free).any()


@pytest.mark.parametrize("size", [2, 3, 5])
def test_random_obstacles_are_squares(size: int) -> None:
    free = maps.random_obstacles(40, 50, density=0.25, seed=4, size=size).free
    target = round(0.25 * free.size)
    assert target <= (~free).sum() < target + size * size
    # Beyond the border obstacles go on, so every obstacle cell lies in a whole square.
    padded = np.pad(~free, size, constant_values=True)
    windows = np.lib.stride_tricks.sliding_window_view(padded, (size, size)).all(axis=(2, 3))
    for row, column in np.argwhere(~free).tolist():
        corner = row + size, column + size
        assert windows[corner[0] - size + 1 : corner[0] + 1, corner[1] - size + 1 : corner[1] + 1].any()


@given(st.integers(1, 25), st.integers(1, 25))
@settings(max_examples=60)
def test_a_spiral_is_one_path_over_all_corridors(rows: int, columns: int) -> None:
    graph = graph_of(maps.spiral(rows, columns).free)
    assert networkx.is_tree(graph)
    assert max(degree for _, degree in graph.degree) <= 2
    assert graph.number_of_nodes() == 2 * ((rows + 1) // 2) * ((columns + 1) // 2) - 1


def test_spiral_with_wide_corridors() -> None:
    drawn = maps.to_text(maps.spiral(9, 9, corridor=2))
    assert drawn == (
        "........#\n........#\n######..#\n.....#..#\n.....#..#\n..####..#\n........#\n........#\n#########\n"
    )


def test_corridor_and_empty_are_free_throughout() -> None:
    assert maps.corridor(7, 2).free.all()
    assert maps.corridor(7, 2).shape == (2, 7)
    assert maps.empty(3, 4).free.all()
    assert maps.empty(3, 4).shape == (3, 4)


@pytest.mark.parametrize(
    ("kind", "parameters", "where", "message"),
    [
        ("mase", {}, "kind", "did you mean maze"),
        ("maze", {"rows": 8, "colums": 8}, "colums", "did you mean columns"),
        ("maze", {"rows": 8}, "columns", "needs columns"),
        ("maze", {"rows": 0, "columns": 8}, "rows", "at least 1"),
        ("maze", {"rows": 8.0, "columns": 8}, "rows", "whole number"),
        ("maze", {"rows": True, "columns": 8}, "rows", "whole number"),
        ("maze", {"rows": 10**5, "columns": 10**5}, None, "above the limit"),
        ("maze", {"rows": 8, "columns": 8, "corridor": 0}, "corridor", "from 1 to 8"),
        ("maze", {"rows": 8, "columns": 8, "corridor": 9}, "corridor", "from 1 to 8"),
        ("maze", {"rows": 8, "columns": 8, "wall": 0}, "wall", "from 1"),
        ("maze", {"rows": 8, "columns": 8, "seed": -1}, "seed", "from 0"),
        ("maze", {"rows": 8, "columns": 8, "loops": 1.5}, "loops", "from 0 to 1"),
        ("maze", {"rows": 8, "columns": 8, "loops": float("nan")}, "loops", "from 0 to 1"),
        ("rooms", {"rows": 8, "columns": 8, "room": (3, 4), "door": 4}, "door", "from 1 to 3"),
        ("rooms", {"rows": 8, "columns": 8, "room": "big"}, "room", "(rows, columns)"),
        ("random", {"rows": 8, "columns": 8}, "density", "needs density"),
        ("random", {"rows": 8, "columns": 8, "density": "half"}, "density", "share"),
        ("random", {"rows": 8, "columns": 8, "density": 0.5, "size": 9}, "size", "from 1 to 8"),
        ("spiral", {"rows": 3, "columns": 8, "corridor": 4}, "corridor", "from 1 to 3"),
        ("corridor", {"length": 2**20, "width": 2**20}, None, "above the limit"),
        ("empty", {"rows": 2, "columns": -1}, "columns", "at least 1"),
    ],
)
def test_refusals_name_the_parameter(kind: str, parameters: dict[str, Any], where: str | None, message: str) -> None:
    with pytest.raises(MapError) as caught:
        generate(kind, **parameters)
    assert caught.value.where == where
    assert message in str(caught.value)


def test_grids_are_read_only_also_in_a_worker() -> None:
    source = np.ones((2, 3), dtype=bool)
    grid = OccupancyGrid(source, resolution=0.05, unknown=np.zeros((2, 3), dtype=bool))
    source[0, 0] = False
    copy = pickle.loads(pickle.dumps(grid))
    for each in (grid, copy):
        assert each.free.all()
        with pytest.raises(ValueError, match="read-only"):
            each.free[0, 0] = False
    assert copy == grid
    assert copy.resolution == 0.05
    assert hash(copy) == hash(grid)


def test_digest_tells_shape_and_cells_apart() -> None:
    digests = {maps.empty(rows, columns).digest for rows, columns in ((2, 6), (6, 2), (3, 4), (1, 12))}
    digests.add(OccupancyGrid(np.zeros((3, 4), dtype=bool)).digest)
    assert len(digests) == 5


@pytest.mark.parametrize(
    "array", [np.ones((2, 2)), np.ones(4, dtype=bool), np.ones((0, 3), dtype=bool), np.ones((2, 2, 1), dtype=bool)]
)
def test_a_grid_of_the_wrong_kind_is_refused(array: np.ndarray) -> None:
    with pytest.raises(MapError):
        OccupancyGrid(array)


def test_a_mask_of_another_shape_is_refused() -> None:
    with pytest.raises(MapError, match="unknown has shape"):
        OccupancyGrid(np.ones((2, 2), dtype=bool), unknown=np.ones((2, 3), dtype=bool))
