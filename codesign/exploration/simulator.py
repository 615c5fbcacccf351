"""The evaluation of a design point by its simulation."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any

from codesign.errors import CodesignError, InputError, SpecError
from codesign.exploration.space import DesignPoint, Space
from codesign.inputs import Platform, Workload, design_point
from codesign.memo import Memo
from codesign.results.result import Result
from codesign.scenarios import bind, simulate
from codesign.system.ready import ready

if TYPE_CHECKING:
    from codesign.maps import OccupancyGrid

_TRIED_AT_FIRST = 1000


class Simulator:
    """Computes a point by simulating it; what points share is computed once in each process.

    ``grid``: the map that the keys of the points were made for: every process plans on it, whatever becomes of its
    file. ``memory``: bytes that a point may take; one that would take more is refused, and so fails.
    """

    def __init__(
        self,
        platform: Platform,
        workload: Workload,
        grid: OccupancyGrid | None = None,
        memory: int | None = None,
    ) -> None:
        self.platform, self.workload, self.grid, self.memory = platform, workload, grid, memory
        self._memo: Memo | None = None

    def __call__(self, point: DesignPoint) -> Result:
        """The result of one point."""
        if self._memo is None:
            self._memo = Memo()
        moved = design_point(self.platform, self.workload, point.axes)
        own = _grid_for(moved[1], self.workload, self.grid)
        return simulate(*moved, memo=self._memo, grid=own, memory=self.memory)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_memo": None}


def check_some_point(
    platform: Platform, workload: Workload, space: Space, grid: OccupancyGrid | None, memory: int
) -> None:
    """Refuse an exploration with no point that can be bound in so much memory, before each of its points fails.

    Raises:
        SpecError, InputError: those of the first point.
    """
    first: CodesignError | None = None
    for point in islice(space.points(), _TRIED_AT_FIRST):
        try:
            moved = design_point(platform, workload, point.axes)
            ready(bind(*moved, grid=_grid_for(moved[1], workload, grid)), memory=memory)
        except (SpecError, InputError) as fault:
            first = first or fault
        else:
            return
    if first is not None and len(space) <= _TRIED_AT_FIRST:
        raise first


def _grid_for(moved: Workload, workload: Workload, grid: OccupancyGrid | None) -> OccupancyGrid | None:
    """The map that was read before, unless an axis moved the problem."""
    return grid if moved.problem is workload.problem else None
