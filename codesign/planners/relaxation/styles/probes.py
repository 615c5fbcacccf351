"""The probes that time the kernels of relaxation on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.planners.plug_in import Probe

_SHORT, _LONG = 10, 300
"""Iterations of two relaxations; the difference of their times is measured."""


def _relaxation() -> Probe:
    """Sweeps of SOR over rooms of the size of Saudi and Sulaiman's area."""
    from codesign import maps
    from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, solve

    free = maps.rooms(270, 330, room=(64, 80), door=12, wall=3, seed=1).free

    def sweeps(count: int) -> Callable[[], object]:
        # To a tolerance, so that no check for cells without a descent is timed.
        return lambda: solve(
            free,
            [(10, 10)],
            method="sor",
            omega=1.95,
            tolerance=PUBLISHED_TOLERANCE,
            boundary="low_goal",
            max_iterations=count,
        )

    return Probe((_LONG - _SHORT) * free.size, sweeps(_LONG), sweeps(_SHORT))


def _relaxation_direct() -> Probe:
    """A direct solution over rooms of a quarter of that area, shared out over the units of its law."""
    from codesign import maps
    from codesign.planners.relaxation.plan import Solution, solve
    from codesign.planners.relaxation.styles.costs import direct_units

    free = maps.rooms(135, 165, room=(32, 40), door=6, wall=2, seed=1).free

    def run() -> Solution:
        return solve(free, [(10, 10)], method="direct")

    return Probe(direct_units(run().updates), run)


PROBES: Mapping[str, Callable[[], Probe]] = {
    "relaxation_node_update": _relaxation,
    "relaxation_direct_cell": _relaxation_direct,
}
"""The probe of each kernel, by the name of its cost in platforms."""
