"""The shortest path at any angle: exact, and never longer than what a robot can drive."""

from __future__ import annotations

import math

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

from codesign.maps import distance_octile
from codesign.maps.reach import least_distance

Free = NDArray[np.bool_]

maps = arrays.arrays(
    np.bool_, st.tuples(st.integers(1, 7), st.integers(1, 7)), elements=st.sampled_from([True, True, False])
)


def two_cells(data: st.DataObject, free: Free) -> list[tuple[int, int]]:
    free[0, 0] = True
    cells = [(int(row), int(column)) for row, column in np.argwhere(free)]
    return [data.draw(st.sampled_from(cells)) for _ in range(2)]


def fine_graph_length(free: Free, begin: tuple[int, int], end: tuple[int, int], parts: int = 3) -> float:
    """Length of a path over points ``1 / parts`` apart, in 16 directions inside free cells: an upper bound.

    Points on borders of blocked cells are left out, so every such path is one that a robot may drive.
    """
    rows, columns = free.shape

    def is_open(y: int, x: int) -> bool:
        # In units of 1/(2 parts) from the top left corner, odd numbers only: never on a border.
        return (
            0 <= y < 2 * parts * rows
            and 0 <= x < 2 * parts * columns
            and bool(free[y // (2 * parts), x // (2 * parts)])
        )

    graph = nx.Graph()
    steps = [(0, 2), (2, 0), (2, 2), (2, -2), (2, 4), (4, 2), (2, -4), (4, -2)]
    for y in range(1, 2 * parts * rows, 2):
        for x in range(1, 2 * parts * columns, 2):
            if not is_open(y, x):
                continue
            for down, along in steps:
                between = [(y + down * k // 4, x + along * k // 4) for k in range(5)]
                around = [(y + i, x + j) for i in sorted((0, down)) for j in sorted((0, along))]
                if all(is_open(*point) for point in (*between, *around)):
                    graph.add_edge((y, x), (y + down, x + along), weight=math.hypot(down, along) / (2 * parts))
    middle = [(2 * parts * row + parts, 2 * parts * column + parts) for row, column in (begin, end)]
    for node in middle:
        graph.add_node(node)
    try:
        return float(nx.dijkstra_path_length(graph, *middle))
    except nx.NetworkXNoPath:
        return math.inf


@settings(max_examples=60, derandomize=True)
@given(free=maps, data=st.data())
def test_it_is_no_longer_than_any_path_and_no_shorter_than_the_straight_line(free: Free, data: st.DataObject) -> None:
    begin, end = two_cells(data, free)
    least = least_distance(free, [begin], [end], point=True)
    octile = float(distance_octile(free, [end])[begin])
    assert (least == math.inf) == (octile == math.inf)
    if octile == math.inf:
        return
    straight = math.hypot(*(max(abs(a - b) - 0.5, 0.0) for a, b in zip(begin, end, strict=True)))
    assert straight - 1e-12 <= least <= octile + 1e-12
    # The bound is tight: eight directions between middles are at most 8.24 % longer, and a detour of half a cell at
    # each end and at each of the corners they go round.
    fine = fine_graph_length(free, begin, end)
    assert least <= fine + 1e-12
    assert least >= fine / 1.03 - 2.5


@settings(max_examples=60, derandomize=True)
@given(free=maps, data=st.data(), most=st.integers(0, 40))
def test_it_is_symmetric_and_a_bound_wherever_it_is_cut(free: Free, data: st.DataObject, most: int) -> None:
    begin, end = two_cells(data, free)
    there = least_distance(free, [begin], [end])
    assert least_distance(free, [end], [begin]) == pytest.approx(there)
    assert there <= least_distance(free, [begin], [end], point=True)
    assert least_distance(free, [begin], [end], most=most) <= there
    assert least_distance(free.T.copy(), [begin[::-1]], [end[::-1]]) == pytest.approx(there)
    assert least_distance(
        free[::-1].copy(), *([(len(free) - 1 - row, column)] for row, column in (begin, end))
    ) == pytest.approx(there)


def test_known_lengths() -> None:
    wall = np.ones((5, 5), np.bool_)
    wall[0:4, 2] = False
    # From the middle of (0, 1) round the wall's lower end, at row 3.5, to the right side of the wall.
    assert least_distance(wall, [(0, 1)], [(0, 3)], point=True) == pytest.approx(math.hypot(3.5, 0.5) + 1.0 + 3.0)
    diagonal = ~np.eye(4, dtype=np.bool_)
    assert least_distance(diagonal, [(0, 1)], [(1, 0)]) == math.inf
    assert least_distance(np.ones((9, 9), np.bool_), [(0, 0)], [(8, 5)], point=True) == pytest.approx(
        math.hypot(7.5, 4.5)
    )
