"""The measurements of the kernels of breadth-first search on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.planners.breadth_first.styles.software import MAP_KERNEL
from codesign.planners.plug_in import Probe

_SIDE = 500


def _prepare() -> object:
    """All that a search does besides popping cells: its start is walled in."""
    import numpy as np

    from codesign.planners.breadth_first.plan import search

    free = np.zeros((_SIDE, _SIDE), np.bool_)
    free[0, 0] = True
    return search(free, (0, 0), (0, 0))


def _breadth_first() -> Probe:
    """A search that pops every cell of a map of small rooms.

    The processor predicts the branches of a search best where there is no obstacle, and worst in narrow mazes: 0.7 and
    1.4 times this cost. The preparation of the map is left out.
    """
    from codesign import maps
    from codesign.planners.breadth_first.plan.search import search_everywhere

    free = maps.rooms(_SIDE, _SIDE, room=(15, 15), door=2, wall=1, seed=1).free
    popped = search_everywhere(free, (8, 8)).popped_cells
    return Probe(popped, lambda: search_everywhere(free, (8, 8)), _prepare)


def _map() -> Probe:
    """The preparation alone."""
    return Probe(_SIDE * _SIDE, _prepare)


PROBES: Mapping[str, Callable[[], Probe]] = {"breadth_first_cell": _breadth_first, MAP_KERNEL: _map}
"""The measurement of each kernel, by the name of its cost in a platform."""
