"""Grid search on a processor: style ``software``.

A step counts units of a kernel whose cost the platform declares: the cells of the map that every search prepares, the
cells that it expands, the entries of its heap, and the cells that jumps or lines of sight look at. NavFn has no heap:
its work is updates of cells.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from codesign.ground.figures import Figure
from codesign.planners.grid_search.plan.parameters import Method, SearchParameters
from codesign.planners.grid_search.plan.planner import searched
from codesign.planners.grid_search.plan.search import GridPlan
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Designs, HostStyle, Step, assumed_bytes, map_read, one_step

MAP_KERNEL = "grid_search_map_cell"
"""A cell of the map, copied with its ring; the cells that a search reaches are held without being cleared."""

EXPANSION = "grid_search_expansion"
"""A cell that A* takes from the heap, with its eight neighbours; the heap is left out."""

ENTRY = "grid_search_heap_entry"
"""An entry put into a binary heap of some hundred, and taken out."""

JUMP_CELL = "grid_search_jump_cell"
"""A cell that a jump looks at."""

THETA_EXPANSION = "grid_search_theta_expansion"
"""A cell that theta* takes from the heap, with its neighbours; the heap and lines of sight are left out."""

SIGHT_CELL = "grid_search_sight_cell"
"""A cell that a line of sight crosses."""

NAVFN_MAP_KERNEL = "grid_search_navfn_map_cell"
"""A cell of the map whose potential is cleared."""

NAVFN_UPDATE = "grid_search_navfn_update"
"""An update of a cell by NavFn, with the path down the gradient."""

KERNELS: dict[Method, tuple[str, ...]] = {
    Method.ASTAR: (MAP_KERNEL, EXPANSION, ENTRY),
    Method.JUMP_POINT: (MAP_KERNEL, EXPANSION, ENTRY, JUMP_CELL),
    Method.THETA_STAR: (MAP_KERNEL, THETA_EXPANSION, ENTRY, SIGHT_CELL),
    Method.NAVFN: (NAVFN_MAP_KERNEL, NAVFN_UPDATE),
}
"""By method: the kernel of the map, then of ``expanded``, ``entries`` and ``looked`` of the plan."""

_HEAP = "an entry of the heap for every second cell"
BYTES = {
    **dict.fromkeys(
        (Method.ASTAR, Method.JUMP_POINT),
        assumed_bytes(20, f"map and side a byte, a 64-bit length, a 32-bit cell before, {_HEAP}", 9, 28),
    ),
    Method.THETA_STAR: assumed_bytes(27, f"map a byte, two doubles, a 32-bit cell before, {_HEAP}", 17, 40),
    Method.NAVFN: assumed_bytes(14, "NavFn's cost and flag a byte, its potential and two gradients a float", 13, 15),
}
"""Bytes a cell, by method."""


class Software(HostStyle):
    """One cell after the other, in the order of a binary heap or of NavFn's blocks."""

    planner = "grid_search"
    description = "one cell after the other, as compiled programs of robots run it"
    kernel = EXPANSION

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """Every method by itself: their paths differ, or their times do."""
        return tuple(({"method": method.value},) for method in Method)

    def kernels(self, job: Job[Problem, SearchParameters]) -> tuple[str, ...]:
        """Those of the method."""
        return KERNELS[job.parameters.method]

    def bytes_a_cell(self, job: Job[Problem, SearchParameters]) -> Figure:
        """The arrays of the method."""
        return BYTES[job.parameters.method]

    def work(self, job: Job[Problem, SearchParameters]) -> Generator[Step, None, GridPlan]:
        """Phase ``map``: its cells. Phase ``search``: what was counted, each in its kernel; the path is among it."""
        plan = searched(job)
        reading, *kernels = KERNELS[job.parameters.method]
        yield map_read("map", job.problem, reading)
        for kernel, units in zip(kernels, (plan.expanded, plan.entries, plan.looked), strict=False):
            if units:
                yield one_step("search", units, kernel=kernel)
        return plan


ARCHITECTURES = (Software(),)

__all__ = ["ARCHITECTURES", "Software"]
