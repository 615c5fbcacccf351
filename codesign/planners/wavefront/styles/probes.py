"""The probes that time the kernels of wavefront propagation on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from codesign import maps
from codesign.planners.plug_in import Probe
from codesign.planners.wavefront.plan import propagate
from codesign.planners.wavefront.styles.software import MAP_KERNEL, TIME_KERNEL

_SIDE = 256
_LAST = 4 * _SIDE
"""About the last time of a wave over a square of rooms."""


def _prepare() -> object:
    """A square without obstacles prepared for a wave, which ends at once."""
    return propagate(np.ones((_SIDE, _SIDE), np.bool_), [(0, 0)], limit=0)


def _times() -> object:
    """A wave along a corridor of one cell, until that time."""
    return propagate(np.ones((1, _LAST), np.bool_), [(0, 0)], limit=_LAST)


def _wavefront() -> Probe:
    """The nodes of a wave over small rooms; its preparation and its times are left out."""
    free = maps.rooms(_SIDE, _SIDE, room=(15, 15), door=2, wall=1, seed=1).free
    reached = int((propagate(free, [(8, 8)], limit=_LAST) >= 0).sum())
    return Probe(reached, lambda: propagate(free, [(8, 8)], limit=_LAST), lambda: (_prepare(), _times()))


def _map() -> Probe:
    """The preparation alone."""
    return Probe(_SIDE * _SIDE, _prepare)


def _time() -> Probe:
    """The times alone, from one corridor to a longer one."""
    long = np.ones((1, 20 * _LAST), np.bool_)
    return Probe(19 * _LAST, lambda: propagate(long, [(0, 0)], limit=20 * _LAST), _times)


PROBES: Mapping[str, Callable[[], Probe]] = {"wavefront_cell": _wavefront, MAP_KERNEL: _map, TIME_KERNEL: _time}
"""The probe of each kernel, by the name of its cost in platforms."""
