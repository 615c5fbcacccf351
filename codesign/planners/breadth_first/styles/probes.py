"""The measurements of the kernels of breadth-first search on this machine."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from codesign import maps
from codesign.planners.breadth_first.plan import search
from codesign.planners.breadth_first.plan.search import search_everywhere
from codesign.planners.breadth_first.styles.software import wall_cells
from codesign.planners.map_flood import CELL_KERNEL, MAP_KERNEL, WALL_KERNEL
from codesign.planners.plug_in import Probe

_SIDE = 500


def _prepare() -> object:
    """All that a search does besides popping cells: its start is walled in."""
    free = np.zeros((_SIDE, _SIDE), np.bool_)
    free[0, 0] = True
    return search(free, (0, 0), (0, 0))


def _open(side: int) -> Callable[[], object]:
    """A search that pops every cell of a square without obstacles."""
    free = np.ones((side, side), np.bool_)
    return lambda: search(free, (0, 0), (side - 1, side - 1))


def _breadth_first() -> Probe:
    """A search that pops every cell of a map without obstacles; its preparation is left out."""
    return Probe(_SIDE * _SIDE, _open(_SIDE), _prepare)


def _wall() -> Probe:
    """A search over small rooms, less one that pops as many cells without obstacles. A quarter lie beside a wall."""
    free = maps.rooms(_SIDE, _SIDE, room=(15, 15), door=2, wall=1, seed=1).free
    plan = search_everywhere(free, (8, 8))
    return Probe(wall_cells(free, plan), lambda: search_everywhere(free, (8, 8)), _open(math.isqrt(plan.popped_cells)))


def _map() -> Probe:
    """The preparation alone."""
    return Probe(_SIDE * _SIDE, _prepare)


PROBES: Mapping[str, Callable[[], Probe]] = {CELL_KERNEL: _breadth_first, MAP_KERNEL: _map, WALL_KERNEL: _wall}
"""The measurement of each kernel, by the name of its cost in a platform."""
