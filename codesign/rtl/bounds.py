"""How many cycles a run may take."""

from __future__ import annotations

from codesign.planners.circuits import Expected


def bound_of(expected: Expected) -> int:
    """The most cycles that a run may take: far more than expected, so that the difference can be seen."""
    cycles, last = sum(expected.cycles.values()), expected.events.cycle.max(initial=0)
    return max(cycles, int(last)) * 9 // 8 + 256
