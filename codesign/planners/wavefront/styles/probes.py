"""The probes that time the kernels of wavefront propagation on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.planners.plug_in import Probe
from codesign.planners.wavefront.styles.software import MAP_KERNEL, TIME_KERNEL

_SIDE = 256
_LAST = 3 * (_SIDE - 1)
"""The last time of a wave over an empty square: steps along its diagonal."""


def _prepare() -> object:
    """A map of that square prepared for a wave, which ends at once."""
    import numpy as np

    from codesign.planners.wavefront.plan import propagate

    return propagate(np.ones((_SIDE, _SIDE), np.bool_), [(0, 0)], limit=0)


def _times() -> object:
    """A wave along a corridor of one cell, until that time."""
    import numpy as np

    from codesign.planners.wavefront.plan import propagate

    return propagate(np.ones((1, _LAST), np.bool_), [(0, 0)], limit=_LAST)


def _wavefront() -> Probe:
    """The nodes of a wave over all of a map without obstacles; its preparation and its times are left out."""
    import numpy as np

    from codesign.planners.wavefront.plan import propagate

    free = np.ones((_SIDE, _SIDE), np.bool_)
    return Probe(free.size, lambda: propagate(free, [(0, 0)]), lambda: (_prepare(), _times()))


def _map() -> Probe:
    """The preparation alone."""
    return Probe(_SIDE * _SIDE, _prepare)


def _time() -> Probe:
    """The times alone, from one corridor to a longer one."""
    import numpy as np

    from codesign.planners.wavefront.plan import propagate

    long = np.ones((1, 20 * _LAST), np.bool_)
    return Probe(19 * _LAST, lambda: propagate(long, [(0, 0)], limit=20 * _LAST), _times)


PROBES: Mapping[str, Callable[[], Probe]] = {
    "wavefront_cell": _wavefront,
    MAP_KERNEL: _map,
    TIME_KERNEL: _time,
}
"""The probe of each kernel, by the name of its cost in platforms."""
