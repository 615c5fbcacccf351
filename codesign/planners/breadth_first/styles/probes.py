"""The measurements of the kernels of breadth-first search on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.planners.plug_in import Probe


def _breadth_first() -> Probe:
    """A search that pops every cell of a map without obstacles."""
    import numpy as np

    from codesign.planners.breadth_first.plan import search

    free = np.ones((500, 500), np.bool_)
    return Probe(free.size, lambda: search(free, (0, 0), (499, 499)))


PROBES: Mapping[str, Callable[[], Probe]] = {
    "breadth_first_cell": _breadth_first,
}
"""The measurement of each kernel, by the name of its cost in a platform."""
