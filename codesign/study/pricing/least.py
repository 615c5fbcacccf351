"""The least that a computation may cost on any machine of a box: bounds on what ``price`` gives.

A box is every combination of the values of some axes, each of which moves costs in one direction
(``Hardware.directions``). The figures themselves do not move in one direction: a message waits for an edge of a clock,
and a faster clock may have its next edge later. So time is bounded by what each act takes without any wait, on the
fastest machine of the box. Power is bounded by that at the slowest clock, as static power does not depend on the clock
and dynamic power rises with it. Energy is bounded by the least power over the least time.
"""

from __future__ import annotations

import numpy as np

from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.study.pricing.boards import boards_of
from codesign.study.pricing.computation import Act, Computation
from codesign.study.pricing.machines import Column, Machines, Specs
from codesign.study.pricing.price import parts_of
from codesign.system.bind import System
from codesign.system.results.ledger import Ledger
from codesign.system.results.result import times_of
from codesign.system.scenarios.requests import mean_of_requests

_ROUNDED = {"plan_time_95_s", "energy_j"}
_ROUNDING = 1e-9
"""Relative, far more than sums of floats may be off. All other figures are whole picoseconds or products: exact."""


def least(system: System, fastest: Specs, slowest: Specs, computation: Computation) -> dict[str, Column]:
    """A bound below each figure that prices move, of boxes: float64, one entry a box.

    Args:
        system: bound, on a machine of the boxes; one that ``why_alone`` lets price.
        fastest, slowest: the machine of each box on which every act is fastest, and the one on which it is slowest.
        computation: what the system computes.
    """
    boards = boards_of(system, slowest)
    watts = {name: board.drawn(slowest.which[name]) for name, board in boards.items()}
    played = [_LeastMachines(system, fastest).play(request, watts) for request in computation.requests]
    parts = [parts_of(each, request) for each, request in zip(played, computation.requests, strict=True)]
    times = times_of([parts[number] for number in computation.of_starts])
    first = computation.requests[0]
    bounds = {
        **{name: times[name] for name in ("plan_time_worst_s", "plan_time_mean_s", "plan_time_95_s")},
        "first_plan_s": played[0].times[first.before or first.answered] / PICOSECONDS_PER_SECOND,
        "energy_j": mean_of_requests([played[number].joules["energy_j"] for number in computation.of_starts]),
    }
    used = tuple(system.designs)
    if used:
        bounds["power"] = sum(watts[used[0]])
    return {
        name: np.broadcast_to(np.asarray(column, np.float64), fastest.count)
        * (1 - _ROUNDING if name in _ROUNDED else 1.0)
        for name, column in bounds.items()
    }


class _LeastMachines(Machines):
    """Machines on which nothing waits. Each act takes at most what it takes on any machine that is not faster."""

    def watts(self, name: str) -> tuple[Column, Column]:
        """Busy and idle power, the idle one at most the busy one: then energy rises with each of the times."""
        busy, idle = super().watts(name)
        return busy, np.minimum(busy, idle)

    def _do(self, act: Act, ledger: Ledger) -> None:
        del ledger
        resource = self._resource(act)
        begin, end = resource.span(np.zeros_like(self.now), act)
        _, clocks = resource.law(act.unit)
        # From time 0 on, an end within a picosecond is rounded up; between other edges it may be 1 ps less.
        span = np.maximum(end - begin - (clocks.hz < PICOSECONDS_PER_SECOND), 0)
        resource.book(act, span)
        self.now = self.now + span
