"""Grid search on a processor: style ``software``.

A step counts units of a kernel whose cost the platform declares: the cells of the map that every search prepares, the
cells that it expands, the entries of its heap, and the cells that jumps or lines of sight look at. NavFn has no heap:
its work is updates of cells.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.figures import Figure
from codesign.ground.late import late
from codesign.planners.grid_search.plan.parameters import Heuristic, Method, SearchParameters
from codesign.planners.grid_search.plan.planner import GridPlan, search, searched
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.plug_in import Probe
from codesign.planners.styles import Family, HostStyle, Step, assumed_bytes, map_read, one_step

__all__ = ["ARCHITECTURES", "Software"]


MAP_KERNEL = "grid_search_map_cell"
"""A cell of the map, copied with its ring; the cells that a search reaches are held without being cleared."""

EXPANSION = "grid_search_expansion"
"""A cell that A* takes from the heap, with its eight neighbours; the heap is left out."""

ENTRY = "grid_search_heap_entry"
"""An entry put into a binary heap of some hundred, and taken out."""

JUMP_CELL = "grid_search_jump_cell"
"""A cell that a jump looks at."""

THETA_EXPANSION = "grid_search_theta_expansion"
"""A cell that theta* takes from the heap, with its neighbours; the heap and lines of sight are left out."""

SIGHT_CELL = "grid_search_sight_cell"
"""A cell that a line of sight crosses."""

NAVFN_MAP_KERNEL = "grid_search_navfn_map_cell"
"""A cell of the map whose potential is cleared."""

NAVFN_UPDATE = "grid_search_navfn_update"
"""An update of a cell by NavFn, with the path down the gradient."""

KERNELS: dict[Method, tuple[str, ...]] = {
    Method.ASTAR: (MAP_KERNEL, EXPANSION, ENTRY),
    Method.JUMP_POINT: (MAP_KERNEL, EXPANSION, ENTRY, JUMP_CELL),
    Method.THETA_STAR: (MAP_KERNEL, THETA_EXPANSION, ENTRY, SIGHT_CELL),
    Method.NAVFN: (NAVFN_MAP_KERNEL, NAVFN_UPDATE),
}
"""By method: the kernel of the map, then of ``expanded``, ``entries`` and ``looked`` of the plan."""

_HEAP = "an entry of the heap for every second cell"
BYTES = {
    **dict.fromkeys(
        (Method.ASTAR, Method.JUMP_POINT),
        assumed_bytes(20, f"map and side a byte, a 64-bit length, a 32-bit cell before, {_HEAP}", 9, 28),
    ),
    Method.THETA_STAR: assumed_bytes(27, f"map a byte, two doubles, a 32-bit cell before, {_HEAP}", 17, 40),
    Method.NAVFN: assumed_bytes(14, "NavFn's cost and flag a byte, its potential and two gradients a float", 13, 15),
}
"""Bytes a cell, by method."""


class Software(HostStyle):
    """One cell after the other, in the order of a binary heap or of NavFn's blocks."""

    planner = "grid_search"
    description = "one cell after the other, as compiled programs of robots run it"
    kernel = EXPANSION
    beyond = "paths that cut the corners of obstacles"

    def families(self, job: Job[Problem, Any]) -> Iterator[Family]:
        """Every method by itself, with each heuristic that it has: none takes less than its reading of the map."""
        for heuristic, method in product(Heuristic, Method):
            own = {} if heuristic is Heuristic.OCTILE else {"heuristic": heuristic.value}
            if not own or SearchParameters(method=method).exact:
                yield Family(({"method": method.value, **own},), {KERNELS[method][0]: job.problem.free.size})

    def kernels(self, job: Job[Problem, SearchParameters]) -> tuple[str, ...]:
        """Those of the method."""
        return KERNELS[job.parameters.method]

    def bytes_a_cell(self, job: Job[Problem, SearchParameters]) -> Figure:
        """The arrays of the method."""
        return BYTES[job.parameters.method]

    def work(self, job: Job[Problem, SearchParameters]) -> Generator[Step, None, GridPlan]:
        """Phase ``map``: its cells. Phase ``search``: what was counted, each in its kernel; the path is among it."""
        plan = searched(job)
        reading, *kernels = KERNELS[job.parameters.method]
        yield map_read("map", job.problem, reading)
        for kernel, units in zip(kernels, (plan.expanded, plan.entries, plan.looked), strict=False):
            if units:
                yield one_step("search", units, kernel=kernel)
        return plan


ARCHITECTURES = (Software(),)


kernels = late("codesign.planners.grid_search.plan.kernels")

_SIDE = 500
_HELD = 300
"""Entries that the heap of a search holds at a time."""

_LINE = 2_000


def _prepare(method: Method = Method.ASTAR) -> GridPlan:
    """All that a search does besides: its start is its goal."""
    return search(np.ones((_SIDE, _SIDE), np.bool_), (0, 0), [(0, 0)], SearchParameters(method=method))


def _rooms() -> NDArray[np.bool_]:
    return maps.rooms(_SIDE, _SIDE, room=(15, 15), door=2, wall=1, seed=1).free


def _across(free: NDArray[np.bool_], method: Method, heuristic: Heuristic = Heuristic.OCTILE) -> Callable[[], GridPlan]:
    """A search from one corner of a map to the other."""
    begin, end = (tuple(int(each) for each in np.argwhere(free)[index]) for index in (0, -1))
    parameters = SearchParameters(method=method, heuristic=heuristic)
    return lambda: search(free, (begin[0], begin[1]), [(end[0], end[1])], parameters)


def _heap(entries: int) -> Callable[[], object]:
    """That many entries through a heap; their keys rise, as those of a search do."""
    keys = np.arange(entries, dtype=np.int64) + np.random.Generator(np.random.PCG64(1)).integers(0, 4 * _HELD, entries)
    return lambda: kernels.heap_sort(keys, _HELD)


def _sight(looked: int) -> Callable[[], object]:
    """Lines of sight over an open square, one after the other, until so many cells were looked at."""
    stride = _LINE + 2
    cells = kernels.padded(np.ones((_LINE, _LINE), np.bool_))
    begin, end = stride + 1, (_LINE * 3 // 4) * stride + _LINE
    times = math.ceil(looked / int(kernels.in_sight(cells, stride, begin, end)[1]))
    return lambda: [kernels.in_sight(cells, stride, begin, end) for _ in range(times)]


def _expansion() -> Probe:
    """A* over small rooms; its preparation and its heap are left out."""
    run = _across(_rooms(), Method.ASTAR)
    plan, heap = run(), _heap(run().entries)
    return Probe(plan.expanded, run, lambda: (_prepare(), heap()))


def _jump_cell() -> Probe:
    """Jumps over small rooms, less a search without estimate that expands as many cells."""
    run = _across(_rooms(), Method.JUMP_POINT)
    plan = run()
    side = math.isqrt(plan.expanded)
    expansions = _across(np.ones((side, side), np.bool_), Method.ASTAR, Heuristic.NONE)
    return Probe(plan.looked, run, lambda: (_prepare(), expansions()))


def _theta_expansion() -> Probe:
    """Theta* over small rooms; its preparation, its heap and its lines of sight are left out."""
    run = _across(_rooms(), Method.THETA_STAR)
    plan = run()
    heap, sight = _heap(plan.entries), _sight(plan.looked)
    return Probe(plan.expanded, run, lambda: (_prepare(), heap(), sight()))


def _navfn_update() -> Probe:
    """NavFn over small rooms; its preparation is left out."""
    run = _across(_rooms(), Method.NAVFN)
    return Probe(run().expanded, run, lambda: _prepare(Method.NAVFN))


PROBES: Mapping[str, Callable[[], Probe]] = {
    MAP_KERNEL: lambda: Probe(_SIDE * _SIDE, _prepare),
    EXPANSION: _expansion,
    ENTRY: lambda: Probe(_SIDE * _SIDE, _heap(_SIDE * _SIDE)),
    JUMP_CELL: _jump_cell,
    THETA_EXPANSION: _theta_expansion,
    SIGHT_CELL: lambda: Probe(_SIDE * _SIDE, _sight(_SIDE * _SIDE)),
    NAVFN_MAP_KERNEL: lambda: Probe(_SIDE * _SIDE, lambda: _prepare(Method.NAVFN)),
    NAVFN_UPDATE: _navfn_update,
}
"""The measurement of each kernel, by the name of its cost in a platform."""
