"""Potentials: against a heap, SciPy, NetworkX, the circuit cycle by cycle, and the lengths of scenario files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from places import SHARED

from codesign import maps
from codesign.ground.errors import InputError, MapError
from codesign.planners.wavefront.paper import measures as reference
from codesign.planners.wavefront.plan import (
    UNREACHED,
    longest_distance,
    obstacle_potentials,
    octile_length,
    propagate,
    register_bits,
    stop_cycle,
    track,
)
from codesign.planners.wavefront.plan.wave import MAX_OCTILE_RATIO

REAL = SHARED / "maps" / "movingai"

Cell = tuple[int, int]


@st.composite
def problems(draw: st.DrawFn, side: int = 12) -> tuple[NDArray[np.bool_], list[Cell]]:
    """A random map with at least one free cell, and one to three sources on free cells."""
    rows, columns = draw(st.integers(1, side)), draw(st.integers(1, side))
    density = draw(st.floats(0, 0.6))
    free = np.random.default_rng(draw(st.integers(0, 10**6))).random((rows, columns)) >= density
    free[draw(st.integers(0, rows - 1)), draw(st.integers(0, columns - 1))] = True
    cells = [tuple(cell) for cell in np.argwhere(free).tolist()]
    return free, draw(st.lists(st.sampled_from(cells), min_size=1, max_size=3))


@given(problems(), st.booleans(), st.booleans())
@settings(max_examples=examples(150))
def test_potentials_are_those_of_dijkstra(
    problem: tuple[NDArray[np.bool_], list[Cell]], cutting: bool, penalised: bool
) -> None:
    free, sources = problem
    extra = np.add.outer(np.arange(free.shape[0]) * 3, np.arange(free.shape[1]) * 5) % 7 if penalised else None
    options: dict[str, Any] = {"corner_cutting": cutting, "extra_delay": extra}
    potentials = propagate(free, sources, **options)
    assert potentials.dtype == np.int32
    assert (potentials == reference.dijkstra(free, sources, **options)).all()
    assert ((potentials == UNREACHED) | free).all()
    stop = max(map(tuple, np.argwhere(potentials >= 0).tolist()))
    stopped = propagate(free, sources, stop=stop, **options)
    assert (stopped == reference.dijkstra(free, sources, stop=stop, **options)).all()
    assert (stopped == np.where(potentials <= potentials[stop], potentials, UNREACHED)).all()


@given(problems())
@settings(max_examples=60)
def test_the_circuit_holds_the_same_potentials_after_d_plus_one_cycles(
    problem: tuple[NDArray[np.bool_], list[Cell]],
) -> None:
    free, sources = problem
    potentials = propagate(free, sources)
    stop = max(map(tuple, np.argwhere(potentials >= 0).tolist()))
    registers, cycles = reference.delay_line_circuit(free, sources, stop)
    assert cycles == stop_cycle(int(potentials[stop]))
    stopped = propagate(free, sources, stop=stop)
    assert (registers == np.where(stopped == UNREACHED, cycles, stopped)).all()
    registers, cycles = reference.delay_line_circuit(free, sources)
    assert (registers == np.where(potentials == UNREACHED, cycles, potentials)).all()


def graph_of(free: NDArray[np.bool_]) -> Any:
    """The grid as a SciPy sparse graph with weights 2 and 3, corners cut."""
    from scipy.sparse import csr_array

    edges = [
        (cell[0] * free.shape[1] + cell[1], other[0] * free.shape[1] + other[1], delay)
        for cell in map(tuple, np.argwhere(free).tolist())
        for other, delay in reference.edges(free, cell)
    ]
    begin, end, delays = np.array(edges).T
    return csr_array((delays.astype(float), (begin, end)), shape=(free.size, free.size))


@pytest.mark.parametrize("kind", ["rooms", "maze", "random"])
def test_scipy_and_networkx_agree(kind: str) -> None:
    import networkx
    from scipy.sparse.csgraph import dijkstra

    parameters: dict[str, Any] = {
        "rooms": {"room": (9, 9), "door": 2, "seed": 4},
        "maze": {"corridor": 2, "seed": 2},
        "random": {"density": 0.35, "seed": 7},
    }[kind]
    free = maps.generate(kind, rows=40, columns=50, **parameters).free
    source = maps.nearest_free(free, (0, 0))
    assert source is not None
    potentials = propagate(free, [source])
    graph = graph_of(free)
    distances = dijkstra(graph, indices=source[0] * 50 + source[1]).reshape(free.shape)
    assert (potentials == np.where(np.isfinite(distances), distances, UNREACHED)).all()
    lengths = networkx.single_source_dijkstra_path_length(
        networkx.from_scipy_sparse_array(graph), source[0] * 50 + source[1]
    )
    assert {divmod(node, 50): int(length) for node, length in lengths.items() if free[divmod(node, 50)]} == {
        (row, column): int(potentials[row, column]) for row, column in np.argwhere(potentials >= 0).tolist()
    }


def test_open_ground_has_a_closed_form() -> None:
    down, right = np.mgrid[0:31, 0:47]
    near, far = np.minimum(down, right), np.maximum(down, right)
    assert (propagate(np.ones((31, 47), bool), [(0, 0)]) == 3 * near + 2 * (far - near)).all()
    assert (propagate(np.ones((31, 47), bool), [(0, 0)], delays=(5, 7)) == 7 * near + 5 * (far - near)).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (5, 5), (4, 11), (3, 4, 9), (5, 2, 2)])
def test_longest_distance_is_that_between_corners(shape: tuple[int, ...]) -> None:
    corner = (0,) * len(shape)
    assert longest_distance(shape) == propagate(np.ones(shape, bool), [corner]).max()
    if len(shape) == 2:
        reached = propagate(np.ones(shape, bool), [corner], delays=(2, 7)).max()
        assert longest_distance(shape, (2, 7)) == reached


@given(st.integers(0, 1000), st.booleans())
@settings(max_examples=20)
def test_three_dimensions_against_scipy(seed: int, penalised: bool) -> None:
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    rng = np.random.default_rng(seed)
    free = rng.random((4, 5, 6)) > 0.4
    free[0, 0, 0] = True
    extra = rng.integers(0, 5, free.shape) if penalised else None
    edges = []
    for cell in np.argwhere(free):
        for other in np.argwhere(free):
            moved = np.abs(cell - other)
            if moved.max() == 1:
                entry = 0 if extra is None else int(extra[tuple(other)])
                edges.append(
                    (*(np.ravel_multi_index(tuple(x), free.shape) for x in (cell, other)), 1 + moved.sum() + entry)
                )
    begin, end, delays = np.array(edges).T if edges else np.zeros((3, 0), int)
    graph = csr_array((delays.astype(float), (begin, end)), shape=(free.size, free.size))
    expected = dijkstra(graph, indices=0).reshape(free.shape)
    potentials = propagate(free, [(0, 0, 0)], extra_delay=extra)
    assert (potentials == np.where(np.isfinite(expected), expected, UNREACHED)).all()


def test_three_dimensions_without_corner_cutting() -> None:
    free = np.ones((2, 2, 2), bool)
    free[0, 0, 1] = False
    potentials = propagate(free, [(0, 0, 0)], corner_cutting=False)
    # The blocked cell lies beside the diagonals to (0, 1, 1), (1, 0, 1) and (1, 1, 1).
    assert potentials[1, 1, 0] == 3
    assert potentials[0, 1, 1] == 4
    assert potentials[1, 1, 1] == 5


@given(problems(16), st.booleans())
@settings(max_examples=examples(100))
def test_half_the_potential_is_within_its_bound_of_the_octile_distance(
    problem: tuple[NDArray[np.bool_], list[Cell]], cutting: bool
) -> None:
    free, sources = problem
    potentials = propagate(free, sources, corner_cutting=cutting)
    octile = maps.distance_octile(free, sources)
    if not cutting:
        assert ((potentials >= 0) == np.isfinite(octile)).all()
        assert (potentials[potentials >= 0] >= 2 * octile[potentials >= 0] - 1e-9).all()
    both = np.isfinite(octile)
    assert (potentials[both] <= 2 * MAX_OCTILE_RATIO * octile[both] + 1e-9).all()


def test_the_bound_is_approached_by_a_straight_detour_that_ties_with_diagonals() -> None:
    side, depth = 201, 101
    free = np.zeros((side + depth + 1, 2 * side + 1), bool)
    steps = np.arange(side + 1)
    free[side - steps, steps] = free[side - steps, 2 * side - steps] = True  # up to a peak and down again
    free[side:, [0, -1]] = free[side + depth, :] = True  # below: straight steps but for two cut corners
    start = (side, 2 * side)
    potentials = propagate(free, [(side, 0)])
    shortest = 2 * side * math.sqrt(2)
    assert potentials[start] / 2 == pytest.approx(MAX_OCTILE_RATIO * shortest)
    way = track(free, potentials, start)
    assert MAX_OCTILE_RATIO - 0.001 < octile_length(way) / shortest < MAX_OCTILE_RATIO


def test_obstacle_potentials_are_octagonal_distances() -> None:
    free = maps.random_obstacles(23, 31, density=0.1, seed=3).free
    down, right = (
        np.abs(np.subtract.outer(axis, part))
        for axis, part in zip(np.mgrid[0:23, 0:31], np.nonzero(~free), strict=True)
    )
    near, far = np.minimum(down, right), np.maximum(down, right)
    assert (obstacle_potentials(free) == (3 * near + 2 * (far - near)).min(axis=2)).all()
    assert (obstacle_potentials(np.ones((4, 9), bool)) == longest_distance((4, 9)) + 1).all()


def test_register_bits_leave_room_for_infinity() -> None:
    for largest in (0, 1, 2, 1354, 1355, 2045, 2046, 2047):
        bits = register_bits(largest)
        assert 2**bits > largest + 1 >= 2 ** (bits - 1)


@pytest.mark.skipif(not REAL.is_dir(), reason="the real maps are not here")
@pytest.mark.parametrize(
    ("name", "count"),
    [("dao/arena", None), ("mapf/room-64-64-16", None), ("rooms/16room_000", 60), ("cities/Berlin_0_256", 60)],
)
def test_scenarios_stay_within_the_bound_of_two_to_three(name: str, count: int | None) -> None:
    grid = maps.read_movingai(REAL / f"{name}.map")
    listed = REAL / f"{name}.map.scen"
    if not listed.is_file():
        stem = f"{Path(name).name}-random-1.scen"
        listed = REAL / "mapf" / "scen-random" / stem
    if not listed.is_file():
        pytest.skip("no scenario file")
    scenarios = maps.read_scenarios(listed)
    chosen = scenarios if count is None else scenarios[:: max(1, len(scenarios) // count)]
    for one in chosen:
        potential = propagate(grid.free, [one.goal], stop=one.start, corner_cutting=False)[one.start]
        assert one.optimal_length - 0.01 <= potential / 2 <= MAX_OCTILE_RATIO * one.optimal_length + 0.01


FREE = np.ones((4, 5), bool)
FREE[1, 1] = False
WALL = np.array([[True, False, True]])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((FREE, [(4, 0)]), "outside"),
        ((FREE, [(-1, 0)]), "outside"),
        ((FREE, [(1, 1)]), "obstacle"),
        ((FREE, []), "no cell"),
        ((FREE, [(0, 0, 0)]), "not a cell"),
        ((FREE, [(0.5, 0)]), "whole numbers"),
        ((FREE, 7), "not a list"),
        ((FREE.astype(int), [(0, 0)]), "not bool"),
        ((np.ones(4, bool), [(0,)]), "dimensions"),
        ((np.ones((0, 4), bool), [(0, 0)]), "empty"),
        ((np.ones((2**13, 2**12), bool), [(0, 0)]), "more than"),
    ],
)
def test_unusable_maps_and_sources_are_refused(arguments: tuple[Any, Any], said: str) -> None:
    with pytest.raises(MapError, match=said):
        propagate(*arguments)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"stop": (9, 9)}, "stop: cell .*outside"),
        ({"stop": (1, 1)}, "stop: cell .*obstacle"),
        ({"limit": -1}, "limit"),
        ({"delays": (0, 3)}, "delays"),
        ({"delays": (3, 2)}, "delays"),
        ({"delays": (2, 3, 4)}, "delays"),
        ({"extra_delay": np.zeros((2, 2), int)}, "extra_delay"),
        ({"extra_delay": np.full((4, 5), 64)}, "64"),
        ({"extra_delay": np.full((4, 5), -1)}, "-1"),
        ({"extra_delay": np.zeros((4, 5))}, "float"),
    ],
)
def test_unusable_options_are_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        propagate(FREE, [(0, 0)], **options)


def test_a_stop_that_no_way_leads_to_is_told_and_not_waited_for() -> None:
    with pytest.raises(MapError, match=r"\(0, 2\) cannot be reached"):
        propagate(WALL, [(0, 0)], stop=(0, 2))


def test_a_limit_ends_the_wave() -> None:
    potentials = propagate(FREE, [(0, 0)])
    assert (propagate(FREE, [(0, 0)], limit=5) == np.where(potentials <= 5, potentials, UNREACHED)).all()
