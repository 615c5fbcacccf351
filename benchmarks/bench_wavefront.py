"""The wave on one core: time, against SciPy's Dijkstra on the same graph, and linear in nodes."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.planners.wavefront.plan import propagate
from codesign.planners.wavefront.plan.grid import check_map
from codesign.planners.wavefront.plan.tiles import run_tiles

SIDE = 256
RUNS = 15


def best(call: Callable[[], Any], runs: int = RUNS) -> float:
    """The shortest of several times, s: what the machine can do when nobody disturbs it."""
    call()
    times = []
    for _ in range(runs):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


def graph_of(free: NDArray[np.bool_]) -> Any:
    """The same graph for SciPy: sparse, one entry an edge, weights 2 and 3."""
    from scipy.sparse import csr_array

    wave_map = check_map(free)
    number = np.arange(free.size).reshape(free.shape)
    padded = np.pad(np.where(free, number, -1), 1, constant_values=-1)
    begins, ends, delays = [], [], []
    for (down, right), delay in zip(wave_map.neighbours.steps, wave_map.neighbours.delays, strict=True):
        other = padded[1 + down : 1 + down + free.shape[0], 1 + right : 1 + right + free.shape[1]]
        joined = free & (other >= 0)
        begins.append(number[joined])
        ends.append(other[joined])
        delays.append(np.full(int(joined.sum()), float(delay)))
    begin, end, delay = (np.concatenate(parts) for parts in (begins, ends, delays))
    return csr_array((delay, (begin, end)), shape=(free.size, free.size))


def run() -> list[dict[str, str]]:
    """Every row: the map, the time, and what it is a ratio to."""
    from scipy.sparse.csgraph import dijkstra

    rooms = maps.rooms(SIDE, SIDE, room=(24, 24), door=3, wall=2, seed=1).free
    found = {"rooms": (rooms, (8, 8)), "empty": (np.ones_like(rooms), (0, 0))}
    rows = []
    for name, (free, source) in found.items():
        own = best(lambda free=free, source=source: propagate(free, [source]))
        graph, index = graph_of(free), source[0] * SIDE + source[1]
        theirs = best(lambda graph=graph, index=index: dijkstra(graph, indices=index), 5)
        building = best(lambda free=free: graph_of(free), 5)
        potentials = propagate(free, [source])
        distances = dijkstra(graph, indices=index).reshape(free.shape)
        assert (potentials == np.where(np.isfinite(distances), distances, -1)).all()
        rows.append(
            {
                "case": f"{SIDE}×{SIDE} {name}",
                "time": f"{1e3 * own:.2f} ms",
                "ratio": f"{theirs / own:.1f}",
                "to": "SciPy's Dijkstra on the graph as it stands",
            }
        )
        rows.append(
            {
                "case": f"{SIDE}×{SIDE} {name}",
                "time": f"{1e3 * own:.2f} ms",
                "ratio": f"{(theirs + building) / own:.1f}",
                "to": "SciPy's Dijkstra, its graph built from the map first",
            }
        )
    rows += [*_sizes(), *_tiles(rooms)]
    return rows


def _sizes() -> list[dict[str, str]]:
    """The same rooms on larger maps: time a node."""
    rows, first = [], 0.0
    for side in (256, 512, 1024, 2048):
        free = maps.rooms(side, side, room=(24, 24), door=3, wall=2, seed=1).free
        a_node = best(lambda free=free: propagate(free, [(8, 8)]), 5) / side**2
        first = first or a_node
        rows.append(
            {
                "case": f"{side}×{side} rooms",
                "time": f"{1e9 * a_node:.1f} ns a node",
                "ratio": f"{a_node / first:.2f}",
                "to": "time a node on 256×256",
            }
        )
    return rows


def _tiles(free: NDArray[np.bool_]) -> list[dict[str, str]]:
    wave_map, source = check_map(free), np.array([(8, 8)])
    none = np.zeros((0, 2), np.int64)
    whole = best(lambda: propagate(free, [(8, 8)]))
    taken = best(lambda: run_tiles(wave_map, source, none, (52, 52)), 5)
    return [
        {
            "case": f"{SIDE}×{SIDE} rooms in tiles of 52×52",
            "time": f"{1e3 * taken:.1f} ms",
            "ratio": f"{taken / whole:.1f}",
            "to": "the whole map at once",
        }
    ]
