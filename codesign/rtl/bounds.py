"""How many cycles a run may take, and how much work its simulation is."""

from __future__ import annotations

from codesign.planners.circuits import Circuit, Expected


def bound_of(expected: Expected) -> int:
    """The most cycles that a run may take: far more than expected, so that the difference can be seen."""
    cycles, last = sum(expected.cycles.values()), expected.events.cycle.max(initial=0)
    return max(cycles, int(last)) * 9 // 8 + 256


def work_of(circuit: Circuit, expected: Expected) -> int:
    """Elements of the circuit times the cycles of its run: the time of a simulation grows with it."""
    return circuit.elements * sum(expected.cycles.values())
