"""How fast the search is, against SciPy's, NetworkX's and the plain reference, on the same graph in the same run."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import networkx
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from codesign import maps
from codesign.planners.breadth_first.plan import search

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests" / "support"))

SIDE = 1000
REFERENCE_SIDE = 200
"""Side of the map for the searches that would take a minute on the large one."""
TARGET_MS = 50.0
"""1000 × 1000 cells, the size that the Java program of the paper could not hold."""


def best_of(count: int, run: Callable[[], Any]) -> float:
    """The shortest wall time of several runs, s."""
    shortest = float("inf")
    for _ in range(count):
        begin = time.perf_counter()
        run()
        shortest = min(shortest, time.perf_counter() - begin)
    return shortest


def graph_of(free: NDArray[np.bool_]) -> csr_array:
    """The 4-connected graph of the free cells, one node a cell of the map."""
    number = np.arange(free.size).reshape(free.shape)
    across, down = free[:, :-1] & free[:, 1:], free[:-1] & free[1:]
    one = np.concatenate([number[:, :-1][across], number[:-1][down]])
    other = np.concatenate([number[:, 1:][across], number[1:][down]])
    ends = np.concatenate([one, other]), np.concatenate([other, one])
    return csr_array((np.ones(len(ends[0]), np.int8), ends), shape=(free.size, free.size))


def line(case: str, seconds: float, cells: int, other: str = "", factor: float | None = None) -> dict[str, Any]:
    """One line of the table; ``factor``: how many times as long the other search takes."""
    return {
        "case": case,
        "wall ms": f"{seconds * 1e3:.2f}",
        "ns a popped cell": f"{seconds / cells * 1e9:.1f}",
        "against": other,
        "times as fast": "" if factor is None else f"{factor:.1f}",
    }


def run() -> list[dict[str, Any]]:
    """The rows of the benchmark."""
    from reference_breadth_first import trail

    rows = []
    for name, grid in (
        ("empty", maps.empty(SIDE, SIDE)),
        ("25 % random", maps.random_obstacles(SIDE, SIDE, density=0.25, seed=1)),
        ("maze", maps.maze(SIDE, SIDE, corridor=3, seed=1)),
    ):
        start = maps.nearest_free(grid.free, (0, 0))
        cells = np.argwhere(maps.reachable(grid.free, [start]))
        goal = int(cells[-1][0]), int(cells[-1][1])
        found = search(grid.free, start, goal)
        own = best_of(7, partial(search, grid.free, start, goal))
        graph, first = graph_of(grid.free), start[0] * SIDE + start[1]
        scipy = best_of(3, partial(breadth_first_order, graph, first, directed=True))
        case = f"{name}, {SIDE}×{SIDE}"
        rows.append(line(case, own, found.popped_cells, "SciPy, graph at hand", scipy / own))
        rows.append(line(case, own, found.popped_cells, f"target of {TARGET_MS:.0f} ms", TARGET_MS / 1e3 / own))
    free = maps.random_obstacles(REFERENCE_SIDE, REFERENCE_SIDE, density=0.25, seed=1).free
    start = maps.nearest_free(free, (0, 0))
    cells = np.argwhere(maps.reachable(free, [start]))
    goal = int(cells[-1][0]), int(cells[-1][1])
    found = search(free, start, goal)
    own = best_of(7, partial(search, free, start, goal))
    plain = best_of(1, partial(trail, free, start, (goal,)))
    web = networkx.grid_2d_graph(*free.shape)
    web.remove_nodes_from([(int(row), int(column)) for row, column in np.argwhere(~free)])
    other = best_of(1, partial(networkx.shortest_path, web, start, goal))
    case = f"25 % random, {REFERENCE_SIDE}×{REFERENCE_SIDE}"
    rows.append(line(case, own, found.popped_cells, "plain reference", plain / own))
    rows.append(line(case, own, found.popped_cells, "NetworkX, graph at hand", other / own))
    return rows
