"""The evaluation of a design point by its simulation."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any

from codesign.ground.errors import CodesignError, Fault, InputError, SpecError, UnsuitedError
from codesign.ground.memo import Memo
from codesign.inputs import Workload
from codesign.inputs.edit import VARIANT_AXIS, choose_variant
from codesign.study.explored import Explored
from codesign.study.space import DesignPoint, Space
from codesign.system.catalog import planner
from codesign.system.results.result import Reason, Result
from codesign.system.scenarios import bind, simulate
from codesign.system.scenarios.run import ready

if TYPE_CHECKING:
    from codesign.maps import OccupancyGrid

_TRIED_AT_FIRST = 1000


class Simulator:
    """Computes a point by simulating it; what points share is computed once in each process.

    Over several platforms, a point that cannot be placed on its platform is a result: infeasible by its mapping.
    ``grid``: the map that the keys of the points were made for: every process plans on it, whatever becomes of its
    file. ``memory``: bytes that a point may take; one that would take more is refused, and so fails.
    """

    def __init__(self, explored: Explored, grid: OccupancyGrid | None = None, memory: int | None = None) -> None:
        self.explored, self.grid, self.memory = explored, grid, memory
        self._memo: Memo | None = None

    def __call__(self, point: DesignPoint) -> Result:
        """The result of one point."""
        if self._memo is None:
            self._memo = Memo()
        try:
            moved = self.explored.point(point.axes)
            own = grid_for(moved[1], self.explored.workload, self.grid)
            return simulate(*moved, memo=self._memo, grid=own, memory=self.memory)
        except UnsuitedError as wrong:
            if self.explored.single is not None:
                raise
            return _unsuited(self.explored, point, wrong)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_memo": None}


def check_some_point(explored: Explored, space: Space, grid: OccupancyGrid | None, memory: int) -> None:
    """Refuse an exploration with no point that can be bound in so much memory, before each of its points fails.

    Raises:
        SpecError, InputError: the fault of the first point.
    """
    first: CodesignError | None = None
    for point in islice(space.points(), _TRIED_AT_FIRST):
        try:
            moved = explored.point(point.axes)
            ready(bind(*moved, grid=grid_for(moved[1], explored.workload, grid)), memory=memory)
        except (SpecError, InputError) as fault:
            first = first or fault
        else:
            return
    if first is not None and len(space) <= _TRIED_AT_FIRST:
        raise first


def _unsuited(explored: Explored, point: DesignPoint, wrong: UnsuitedError) -> Result:
    """The result of a point that cannot be placed on its platform: each fault is a reason."""
    workload = explored.workload
    if VARIANT_AXIS in point.axes:
        workload = choose_variant(workload, point.axes[VARIANT_AXIS])
    task = workload.mapping[planner(workload.planner).planning_task]
    faults = {_sentence(fault): fault for fault in wrong.faults}
    platform = explored.platform(point.axes)
    return Result(
        platform=platform.name,
        workload=workload.name,
        planner=workload.planner,
        style=task.style or "",
        component=task.component,
        places={name: mapped.component for name, mapped in workload.mapping.items()},
        roles=platform.filled,
        parameters={name: mapped.parameters.model_dump(mode="json") for name, mapped in workload.mapping.items()},
        part=None,
        feasible=False,
        reasons=tuple(_reason(name, fault.hint) for name, fault in faults.items()),
    )


def _reason(name: str, hint: str | None) -> Reason:
    levers = (hint,) if hint else ()
    return Reason(kind="mapping", name=name, demand=1, limit=0, gap=1, unit="", levers=levers)


def _sentence(fault: Fault) -> str:
    """The fault in words; of the value of an axis, with the axis."""
    axis = fault.file.removeprefix("point: ")
    return fault.what if axis == fault.file else f"{axis}: {fault.what}"


def grid_for(moved: Workload, workload: Workload, grid: OccupancyGrid | None) -> OccupancyGrid | None:
    """The map that was read before, unless an axis moved the problem."""
    return grid if moved.problem is workload.problem else None
