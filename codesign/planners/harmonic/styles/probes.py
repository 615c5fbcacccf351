"""The measurements of the kernels of harmonic control on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from codesign import maps
from codesign.ground.late import late
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.plan.decision import directions
from codesign.planners.harmonic.plan.warm_start import warm_start
from codesign.planners.plug_in import Probe

node_kernels = late("codesign.planners.harmonic.styles.node_kernels")


def _harmonic() -> Probe:
    """Iterations over a maze as one block, from zero, node after node.

    Its values fill 2.1 MB. On smaller maps, which the caches hold, an iteration is faster, and on larger ones slower.
    """
    free = maps.maze(360, 360, corridor=6, seed=1).free

    def run() -> Any:
        return node_kernels.relax_nodes(free, [(3, 3)], (31,), most=100)[1]

    return Probe(sum(run()) * free.size, run)


def _harmonic_decision() -> Probe:
    """Directions at all free cells of a map of rooms, at 62 bits."""
    free = maps.rooms(128, 128, room=(40, 40), door=8, wall=2, seed=4).free
    field = relax(free, [(64, 64)], block=free.shape, iterations=64, schedule=(62,), record_visits=False).field
    return Probe(int(free.sum()), lambda: directions(field, free))


def _sparse_solve() -> Probe:
    """A start nowhere above the field at 63 bits: factors, refinement, certificate."""
    free = maps.rooms(128, 128, room=(40, 40), door=8, wall=2, seed=4).free
    return Probe(int(free.sum()), lambda: warm_start(free, [(64, 64)], 63))


PROBES: Mapping[str, Callable[[], Probe]] = {
    "harmonic_node_update": _harmonic,
    "harmonic_decision": _harmonic_decision,
    "sparse_solve_cell": _sparse_solve,
}
"""The measurement of each kernel, by the name of its cost in a platform."""
