"""Styles ``software`` and ``software_java``: the search on a processor.

A cycle of a step is one unit of a kernel: one popped cell with its four neighbours. The platform declares its cost.
``software`` is a compiled search over arrays, kernel ``breadth_first_cell``. It prepares every cell of the map before
the search, kernel ``breadth_first_map_cell``. A popped cell beside an obstacle takes longer, kernel
``breadth_first_wall_cell``: the processor cannot foresee which neighbours are free. ``software_java`` is the program of
Vacariu et al. (2008), section 2.2, kernel ``breadth_first_java_cell``, with its memory wall.

The wall: the program ran on 100 × 100 cells, and at 200 × 200 "required more virtual memory than the operating system
could give"; at 1000 × 1000 memory is "insufficient even to hold the map data". Its bytes a cell are not published. In a
heap of 64 MB, the default of Java machines of its day (from memory, so assumed), the two sizes bound them: more than
1,677 bytes a cell, at most 6,710. The law takes the geometric mean.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.figures import Figure, Status
from codesign.planners.breadth_first import published
from codesign.planners.breadth_first.plan import search
from codesign.planners.breadth_first.plan.parameters import SearchParameters
from codesign.planners.breadth_first.plan.planner import searched
from codesign.planners.breadth_first.plan.search import BreadthFirstPlan, search_everywhere
from codesign.planners.breadth_first.styles.timing import INIT, SEARCH, step, steps
from codesign.planners.interface import Problem
from codesign.planners.job import Demand, Job, Lever, Line
from codesign.planners.map_flood import CELL_KERNEL, MAP_KERNEL, WALL_KERNEL, beside_walls
from codesign.planners.plug_in import Probe
from codesign.planners.styles import Designs, HostStyle, Step, assumed_bytes, map_read

JAVA_HEAP = 64 * 2**20
"""Bytes. Assumed."""
LARGEST_CELLS_RUN = 100 * 100
SMALLEST_CELLS_REFUSED = published.MEMORY_WALL_SIDE**2
JAVA_BYTES_A_CELL_LOW = (JAVA_HEAP + 1) / SMALLEST_CELLS_REFUSED
JAVA_BYTES_A_CELL_HIGH = JAVA_HEAP / LARGEST_CELLS_RUN
JAVA_BYTES_A_CELL = math.sqrt(JAVA_BYTES_A_CELL_LOW * JAVA_BYTES_A_CELL_HIGH)
"""About 3,355: between the bounds from 200 × 200 and from 100 × 100 cells."""

BYTES = assumed_bytes(6, "map and direction in a byte each, and a queue of 32-bit cells for all of them", 1, 8)


def heap_bound(cells: int) -> Line:
    """Bytes of the Java program for a map, against its heap."""
    side = math.isqrt(int(JAVA_HEAP / JAVA_BYTES_A_CELL))
    source = (
        f"{published.PAPER}, section 2.2: ran at 100 × 100, not at 200 × 200; {JAVA_BYTES_A_CELL_LOW:,.0f} to"
        f" {JAVA_BYTES_A_CELL_HIGH:,.0f} bytes a cell in 64 MB"
    )
    value, low, high = (cells * each for each in (JAVA_BYTES_A_CELL, JAVA_BYTES_A_CELL_LOW, JAVA_BYTES_A_CELL_HIGH))
    return Line.bound(
        name="heap of the Java program",
        demand=Figure(value, "bytes", Status.ASSUMED, source, low, high),
        limit=JAVA_HEAP,
        unit="bytes",
        status=Status.ASSUMED,
        source=source,
        levers=(
            Lever("problem.map", f"at most about {side} × {side} cells"),
            Lever("search.style", "software (arrays), or state_machine on an FPGA", axes={"search.style": "software"}),
        ),
    )


def wall_cells(free: NDArray[np.bool_], plan: BreadthFirstPlan) -> int:
    """Popped cells with an obstacle or the edge of the map on one of their four sides."""
    return int(beside_walls(free).ravel()[plan.pushed[: plan.popped_cells]].sum())


class Software(HostStyle):
    """One popped cell after the other."""

    planner = "breadth_first"
    description = "one popped cell after the other"

    def __init__(self, style: str, kernel: str, *, java: bool = False) -> None:
        self.style = style
        self.kernel = kernel
        self._java = java

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """One: no parameter changes the search."""
        return (({},),)

    def kernels(self, _job: Job[Problem, SearchParameters]) -> tuple[str, ...]:
        """The kernels of popped cells and of the map; of the compiled search also for the cells beside walls."""
        return (self.kernel, MAP_KERNEL) if self._java else (self.kernel, MAP_KERNEL, WALL_KERNEL)

    def demand(self, job: Job[Problem, SearchParameters]) -> Demand:
        """No resource of a part; the arrays, or the heap of the Java program."""
        if self._java:
            return Demand(items=(), bounds=(heap_bound(job.problem.free.size),))
        return super().demand(job)

    def bytes_a_cell(self, _job: Job[Problem, SearchParameters]) -> Figure:
        """A byte of the map, a byte of the direction, and four of the queue."""
        return BYTES

    def work(self, job: Job[Problem, SearchParameters]) -> Generator[Step, None, BreadthFirstPlan]:
        """Phase ``init``: the map. Phase ``bf``: a unit of ``kernel`` for each popped cell; it includes the path.

        Of ``software`` besides: a unit of ``WALL_KERNEL`` for those beside an obstacle. The cost of a popped cell of
        the Java program includes these.

        So nothing is saved where another component tracks the path. Every search begins anew: ``start`` and
        ``inside`` of the job change nothing.
        """
        plan = searched(job)
        yield map_read(INIT, job.problem, MAP_KERNEL)
        if not self._java and (walls := wall_cells(job.problem.free, plan)):
            yield replace(step(SEARCH, walls), kernel=WALL_KERNEL)
        if job.detail:
            yield from steps(SEARCH, np.ones(plan.popped_cells, np.int64))
        else:
            yield step(SEARCH, plan.popped_cells)
        return plan


_SIDE = 500


def _prepare() -> object:
    """All that a search does besides popping cells: its start is walled in."""
    free = np.zeros((_SIDE, _SIDE), np.bool_)
    free[0, 0] = True
    return search(free, (0, 0), (0, 0))


def _open(side: int) -> Callable[[], object]:
    """A search that pops every cell of a square without obstacles."""
    free = np.ones((side, side), np.bool_)
    return lambda: search(free, (0, 0), (side - 1, side - 1))


def _breadth_first() -> Probe:
    """A search that pops every cell of a map without obstacles; its preparation is left out."""
    return Probe(_SIDE * _SIDE, _open(_SIDE), _prepare)


def _wall() -> Probe:
    """A search over small rooms, less one that pops as many cells without obstacles. A quarter lie beside a wall."""
    free = maps.rooms(_SIDE, _SIDE, room=(15, 15), door=2, wall=1, seed=1).free
    plan = search_everywhere(free, (8, 8))
    return Probe(wall_cells(free, plan), lambda: search_everywhere(free, (8, 8)), _open(math.isqrt(plan.popped_cells)))


def _map() -> Probe:
    return Probe(_SIDE * _SIDE, _prepare)


PROBES: Mapping[str, Callable[[], Probe]] = {CELL_KERNEL: _breadth_first, MAP_KERNEL: _map, WALL_KERNEL: _wall}
"""The measurement of each kernel, by the name of its cost in a platform."""
