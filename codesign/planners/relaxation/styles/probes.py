"""The probes that time the kernels of relaxation on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from codesign import maps
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.plug_in import Probe
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, Solution, solve
from codesign.planners.relaxation.plan.parameters import Method, RelaxParameters
from codesign.planners.relaxation.plan.planner import PLANNER, search_of
from codesign.planners.relaxation.plan.run import CHECK_EVERY
from codesign.planners.relaxation.styles.costs import (
    CHECK_KERNEL,
    DIAGONAL_KERNEL,
    DIRECT_KERNEL,
    MAP_KERNEL,
    direct_units,
)

_SHORT, _LONG = 10, 300
"""Iterations of two relaxations; the difference of their times is measured."""


_ROWS, _COLUMNS = 270, 330
"""The size of Saudi and Sulaiman's area."""


def _rooms() -> Any:
    """Rooms of that size."""
    return maps.rooms(_ROWS, _COLUMNS, room=(64, 80), door=12, wall=3, seed=1).free


def _thin() -> Any:
    """A map of two rows with as many diagonals."""
    return np.ones((2, _ROWS + _COLUMNS - 2), np.bool_)


def _sweeps(free: Any, count: int) -> Callable[[], object]:
    """Sweeps of SOR, to a tolerance, so that no check for cells without a descent is timed."""
    return lambda: solve(
        free,
        [(1, 1)],
        method="sor",
        omega=1.95,
        tolerance=PUBLISHED_TOLERANCE,
        boundary="low_goal",
        max_iterations=count,
    )


def _relaxation() -> Probe:
    """The cells of sweeps over rooms; the diagonals are left out."""
    rooms, long = _rooms(), _sweeps(_rooms(), _LONG)
    short, diagonals = _sweeps(rooms, _SHORT), _sweeps(_thin(), _LONG - _SHORT)
    return Probe((_LONG - _SHORT) * rooms.size, long, lambda: (short(), diagonals()))


def _diagonal() -> Probe:
    """Diagonals of two cells at most."""
    thin = _thin()
    number = (_LONG - _SHORT) * (sum(thin.shape) - 1)
    return Probe(number, _sweeps(thin, _LONG), _sweeps(thin, _SHORT))


def _check() -> Probe:
    """Checks after every tenth iteration, over rooms that take more iterations than these."""
    rooms = _rooms()

    def run(tolerance: float | None) -> Callable[[], object]:
        return lambda: solve(rooms, [(10, 10)], method="gs", tolerance=tolerance, max_iterations=_LONG)

    # The flood fill counts as one check more, as in the law.
    return Probe((1 + _LONG // CHECK_EVERY) * rooms.size, run(None), run(PUBLISHED_TOLERANCE))


def _map() -> Probe:
    """An iteration over rooms, and the search prepared."""
    problem = Problem(_rooms(), ((10, 10),), ())
    parameters = RelaxParameters(method=Method.GS, tolerance=1e-15, max_iterations=1)
    job = Job(problem, parameters)
    return Probe(problem.free.size, lambda: search_of(problem, PLANNER.plan(job)))


def _relaxation_direct() -> Probe:
    """A direct solution over rooms of a quarter of that area, shared out over the units of its law."""
    free = maps.rooms(135, 165, room=(32, 40), door=6, wall=2, seed=1).free

    def run() -> Solution:
        return solve(free, [(10, 10)], method="direct")

    return Probe(direct_units((first := run()).updates, first.factors), run)


PROBES: Mapping[str, Callable[[], Probe]] = {
    "relaxation_node_update": _relaxation,
    DIRECT_KERNEL: _relaxation_direct,
    DIAGONAL_KERNEL: _diagonal,
    CHECK_KERNEL: _check,
    MAP_KERNEL: _map,
}
"""The probe of each kernel, by the name of its cost in platforms."""
