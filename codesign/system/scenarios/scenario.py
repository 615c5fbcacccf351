"""The questions of a run to the scenario that a workload names."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.memo import Memo
from codesign.ground.records import FieldRecord, MapRecord
from codesign.inputs import Platform, Workload
from codesign.system.bind import System
from codesign.system.build import Machine
from codesign.system.results.result import Power, Result
from codesign.system.scenario import LeverProgress, ProgressOfMission, ScenarioRules


class Scenario(ScenarioRules, ABC):
    """One kind of scenario: its rules, and how it runs. Only ``type`` and ``run`` are required."""

    @abstractmethod
    def run(
        self, machine: Machine, boards: Mapping[str, Power], memo: Memo | None, progress: ProgressOfMission | None, /
    ) -> dict[str, Any]:
        """Run a machine that is at time 0 to the end of the scenario.

        Args:
            machine: the bound system on its components.
            boards: the power of each FPGA of the platform, by name.
            memo: shares functional work with other runs; the figures are the same without.
            progress: is called now and then while a mission goes on.

        Returns:
            The fields of ``Result`` that the run gives a value.
        """

    def outlook(self, _workload: Workload, /) -> str | None:
        """A warning that the run may take long, for before it begins; None where it takes no longer than usual."""
        return None

    def with_levers(
        self,
        result: Result,
        _system: System,
        _run: Callable[[Platform, Workload], Result],
        _progress: LeverProgress | None,
        /,
    ) -> Result:
        """The result with what moving each lever of the system gives.

        ``_run`` simulates another design point. By default there are no levers, and the result stays as it is.
        """
        return result


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
