"""Cycles of the state machine.

    cycles = c_init·words + b·(V - 1) + c_path·(L + 1) + c_0

V popped cells with the goal, L steps of the path. The RTL of this package follows this exactly, and so do its events
(``hwsw verify``):

- c_init = 1: CopyMem takes a cell a cycle from the stream that brings the map. With linear addresses it also writes
  the wall after every row but the last. Pipelined, the last cell is written two cycles later.
- b = 14 where a neighbour takes 3 cycles, 9 where it takes 2, 6 where the four are pipelined. One more cycle shows
  that the popped cell is the goal, or that the queue is empty: then there are b·V cycles before it.
- c_path = 2: MarkPath reads a direction, then marks the cell. One more cycle shows that the cell is the start.

So c_0 is 2, pipelined 4. A search for a field ends with the empty queue, and has no state Path.

Every access to an external memory adds its latency: a queue word for each pop, a queue word and a direction for each
push, a direction for each cell of the path. Where the cells are external too, each pop reads four of them, and each
push and each cell of the path marks one. Init runs through the memory in order; its bursts are assumed to hide the
latency. All of this is assumed: the paper has no figure.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
from numpy.typing import NDArray

from codesign.planners.breadth_first.plan.parameters import Address, MemoryPlace, MicroArchitecture, SearchParameters
from codesign.planners.breadth_first.plan.search import NEIGHBOURS, UNKNOWN, BreadthFirstPlan
from codesign.planners.clock_law import Placement, Registers
from codesign.planners.external_memory import Traffic
from codesign.planners.measured import clock_rows
from codesign.planners.styles import MemoryStep, Step, task_record

INIT, SEARCH, PATH = "init", "bf", "path"
"""The phases of the cycles, named as the states of the paper; no cycle counts in Standby."""

TRACK = "track"
"""The task of phase ``path``."""

BATCH = 1 << 16
"""The most units of a step, so that memory does not hold a large map twice."""


def discoverers(search: BreadthFirstPlan) -> NDArray[np.int64]:
    """Int64, one entry a pushed cell but the start: the rank, from 0, of the pop that pushed it."""
    columns = search.directions.shape[1]
    offsets = np.array([down * columns + right for down, right in NEIGHBOURS], np.int64)
    discovered = search.pushed[1:].astype(np.int64)
    sides = search.directions.ravel()[discovered]
    assert UNKNOWN not in sides, "every pushed cell but the start was discovered by another"
    rank = np.zeros(search.directions.size, np.int64)
    rank[search.pushed] = np.arange(search.pushed_cells)
    ranks: NDArray[np.int64] = rank[discovered + offsets[sides]]
    return ranks


def pushes_of_each_pop(search: BreadthFirstPlan) -> NDArray[np.int64]:
    """Int64, one entry a popped cell: the number of cells that its expansion pushed."""
    return np.bincount(discoverers(search), minlength=search.popped_cells).astype(np.int64)


def steps(
    phase: str, cycles: NDArray[np.int64], ram_addresses: int = 0, traffic: Traffic | None = None
) -> Iterator[Step]:
    """Steps of ``phase`` with at most ``BATCH`` units each, each recorded as a task.

    ``traffic``: of each unit with an external memory; its cycles are among ``cycles``.
    """
    for first in range(0, len(cycles), BATCH):
        units = cycles[first : first + BATCH]
        record = task_record(phase, int(units.sum()))
        if traffic is None:
            yield Step(phase, units, record, ram_addresses)
        else:
            yield MemoryStep(phase, units, record, ram_addresses, traffic=traffic.part(first, first + BATCH))


def step(phase: str, cycles: int, ram_addresses: int = 0, traffic: Traffic | None = None) -> Step:
    """A phase in one step of one unit; ``traffic`` is summed."""
    (only,) = steps(phase, np.array([cycles], np.int64), ram_addresses, traffic.total if traffic else None)
    return only


def expansions(search: BreadthFirstPlan) -> int:
    """The number of expanded cells: all popped cells but the goal that ended the search."""
    return search.popped_cells - (search.reached and not search.everywhere)


INIT_CYCLES = 1
"""c_init: cycles for each word of the memory of the cells."""
PATH_CYCLES = 2
"""c_path: cycles for each cell of the path."""

EXPANSION_CYCLES = {MicroArchitecture.THREE_CYCLES: 14, MicroArchitecture.TWO_CYCLES: 9, MicroArchitecture.PIPELINED: 6}
"""b: cycles from one pop to the next."""

PUSH_CYCLES = {
    MicroArchitecture.THREE_CYCLES: (3, 6, 9, 12),
    MicroArchitecture.TWO_CYCLES: (3, 5, 7, 8),
    MicroArchitecture.PIPELINED: (2, 3, 4, 5),
}
"""Cycles from a pop to the push of its northern, southern, western and eastern neighbour."""

SEARCH_ADDRESSES = {MicroArchitecture.THREE_CYCLES: 1, MicroArchitecture.TWO_CYCLES: 1, MicroArchitecture.PIPELINED: 2}
"""Addresses that the memory of the cells gets in a cycle. Pipelined, one neighbour is read while another is marked."""

DRAIN_CYCLES = {MicroArchitecture.THREE_CYCLES: 0, MicroArchitecture.TWO_CYCLES: 0, MicroArchitecture.PIPELINED: 2}
"""Cycles of state Init after the last cell. Pipelined, the port that writes gets its address through two registers."""

SEARCH_CHANGES = 1
"""Cycles of state BF besides its expansions: the goal, or the empty queue, is seen."""
PATH_CHANGES = 1
"""Cycles of state Path after its last cell: the start is seen."""

ACCESSES_A_POP = {MemoryPlace.BLOCK_RAM: 0, MemoryPlace.PROCESS_EXTERNAL: 1, MemoryPlace.EXTERNAL: 5}
ACCESSES_A_PUSH = {MemoryPlace.BLOCK_RAM: 0, MemoryPlace.PROCESS_EXTERNAL: 2, MemoryPlace.EXTERNAL: 3}
ACCESSES_A_PATH_CELL = {MemoryPlace.BLOCK_RAM: 0, MemoryPlace.PROCESS_EXTERNAL: 1, MemoryPlace.EXTERNAL: 2}
"""Accesses to the external memory."""


def cell_words(shape: tuple[int, int], address: Address) -> int:
    """Words that state Init writes for a map of (rows, columns): its cells, and the walls of linear addresses.

    >>> cell_words((130, 130), Address.SIDE_BY_SIDE), cell_words((130, 130), Address.LINEAR)
    (16900, 17029)
    """
    rows, columns = shape
    return rows * columns + (rows - 1 if address is Address.LINEAR else 0)


def init_cycles(shape: tuple[int, int], parameters: SearchParameters) -> int:
    """Cycles of state Init for a map of (rows, columns)."""
    words = cell_words(shape, parameters.address)
    return INIT_CYCLES * words + DRAIN_CYCLES[parameters.micro_architecture]


def path_cycles(path_cells: int, place: MemoryPlace, external_cycles: int) -> int:
    """Cycles of state Path, for the L + 1 cells of a path."""
    # MarkPath (figure 5): a direction is read and a cell is marked; each external access adds its latency.
    each = PATH_CYCLES + external_cycles * ACCESSES_A_PATH_CELL[place]
    return each * path_cells + PATH_CHANGES


def ending_cycles(place: MemoryPlace, external_cycles: int) -> int:
    """Cycles of state BF outside of its expansions: pop of the goal, or an empty queue."""
    return SEARCH_CHANGES + (0 if place is MemoryPlace.BLOCK_RAM else 2 * external_cycles)


def registers(
    shape: tuple[int, int], address: Address, *, shown: bool = False, short: bool = False, external: bool = False
) -> Registers:
    """The variables of the clock of an engine: its address and its cells. All micro-architectures are as fast.

    A linear address is added up; one side by side is put together. Options: a display, a queue of fewer words than
    the map has cells, memories outside.
    """
    rows, columns = shape
    words = {"a display": shown, "a short queue": short, "an external memory": external}
    options = frozenset(word for word, present in words.items() if present)
    return Registers(f"memories with output registers, address {address}", rows * columns, options=options)


@cache
def placements() -> tuple[Placement, ...]:
    """The engines that were placed and routed."""
    return tuple(
        Placement(
            row,
            registers(
                (row.variables["ROWS"], row.variables["COLUMNS"]),
                Address.LINEAR if row.variables["LINEAR"] else Address.SIDE_BY_SIDE,
                shown=bool(row.variables.get("SHOWN", 0)),
                short=row.variables["QUEUE_WORDS"] < 1 << row.variables["ADDRESS_BITS"],
            ),
        )
        for row in clock_rows("breadth_first", "state_machine")
    )
