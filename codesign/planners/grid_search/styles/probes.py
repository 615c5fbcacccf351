"""The measurements of the kernels of grid search on this machine."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.late import late
from codesign.planners.grid_search.plan.parameters import Heuristic, Method, SearchParameters
from codesign.planners.grid_search.plan.search import GridPlan, search
from codesign.planners.grid_search.styles import (
    ENTRY,
    EXPANSION,
    JUMP_CELL,
    MAP_KERNEL,
    NAVFN_MAP_KERNEL,
    NAVFN_UPDATE,
    SIGHT_CELL,
    THETA_EXPANSION,
)
from codesign.planners.plug_in import Probe

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


def _entry() -> Probe:
    """Entries through a heap."""
    return Probe(_SIDE * _SIDE, _heap(_SIDE * _SIDE))


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


def _sight_cell() -> Probe:
    """Lines of sight alone."""
    return Probe(_SIDE * _SIDE, _sight(_SIDE * _SIDE))


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
    ENTRY: _entry,
    JUMP_CELL: _jump_cell,
    THETA_EXPANSION: _theta_expansion,
    SIGHT_CELL: _sight_cell,
    NAVFN_MAP_KERNEL: lambda: Probe(_SIDE * _SIDE, lambda: _prepare(Method.NAVFN)),
    NAVFN_UPDATE: _navfn_update,
}
"""The measurement of each kernel, by the name of its cost in a platform."""
