"""The probes that time the kernels of wavefront propagation on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.planners.plug_in import Probe


def _wavefront() -> Probe:
    """A wave over all of a map without obstacles."""
    import numpy as np

    from codesign.planners.wavefront.plan import propagate

    free = np.ones((256, 256), np.bool_)
    return Probe(free.size, lambda: propagate(free, [(0, 0)]))


PROBES: Mapping[str, Callable[[], Probe]] = {"wavefront_cell": _wavefront}
"""The probe of each kernel, by the name of its cost in platforms."""
