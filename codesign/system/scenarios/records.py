"""Records that several scenarios make of a run as a whole."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.records import FieldRecord, MapRecord
from codesign.system.build import Machine


def tell_map(machine: Machine, free: NDArray[np.bool_], resolution: float | None, radius: float = 0.0) -> None:
    """Record the map ``free`` with the goals of the problem for listeners. ``radius``: of the robots, cells."""
    if machine.listening:
        problem = machine.system.problem
        goals = np.array(problem.goals, np.int32).reshape(-1, 2)
        origin = None if problem.origin is None else np.array(problem.origin, np.float64)
        unknown = problem.unknown if problem.unknown is None or problem.unknown.any() else None
        where = (*problem.corner, origin, radius)
        machine.tell(MapRecord(machine.now, "map", free, goals, resolution, *where, unknown=unknown))


def tell_field(machine: Machine, plan: Any) -> None:
    """Record the field of a plan for listeners, where its planner leaves one and has no other record of it."""
    field = machine.system.planner.field_of(plan) if machine.wants(FieldRecord) else None
    if field is not None:
        name, unit, values = field
        machine.tell(FieldRecord(machine.now, machine.system.component, name, unit, values))
