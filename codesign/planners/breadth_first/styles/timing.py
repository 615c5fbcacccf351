"""Cycles of the state machine.

    cycles = c_init·cells + b·(V - 1) + c_path·(L + 1) + c_0

V popped cells with the goal, L steps of the path, cells = rows × columns. Own RTL follows this exactly: c_init = 1
(CopyMem clears one cell a cycle), c_path = 2 (MarkPath reads a direction, then marks the cell), and b = 14 where a
neighbour takes 3 cycles, 9 where it takes 2, 6 where the four are pipelined. The constant of the RTL was not kept;
c_0 is assumed from the states: see ``CONSTANT``.

Every access to an external memory adds its latency: a queue word for each pop, a queue word and a direction for each
push, a direction for each cell of the path. Where the cells are external too, each pop reads four of them, and each
push and each cell of the path marks one. Init runs through the memory in order; its bursts are assumed to hide the
latency. All of this is assumed: the paper has no figure.
"""

from __future__ import annotations

from codesign.planners.breadth_first.plan.parameters import MemoryPlace, MicroArchitecture

INIT_CYCLES = 1
"""c_init: cycles for each cell of the map."""
PATH_CYCLES = 2
"""c_path: cycles for each cell of the path."""

EXPANSION_CYCLES = {
    MicroArchitecture.THREE_CYCLES: 14,
    MicroArchitecture.TWO_CYCLES: 9,
    MicroArchitecture.PIPELINED: 6,
}
"""b: cycles from one pop to the next."""

SEARCH_ADDRESSES = {
    MicroArchitecture.THREE_CYCLES: 1,
    MicroArchitecture.TWO_CYCLES: 1,
    MicroArchitecture.PIPELINED: 2,
}
"""Addresses that the memory of the cells gets in a cycle. Pipelined, one neighbour is read while the previous one is
marked."""

INIT_CHANGES, SEARCH_CHANGES, PATH_CHANGES = 1, 3, 2
"""Standby to Init; Init to BF, the push of the start and the pop of the goal; BF to Path, and back to Standby."""
CONSTANT = INIT_CHANGES + SEARCH_CHANGES + PATH_CHANGES
"""c_0, assumed."""

ACCESSES_A_POP = {MemoryPlace.BLOCK_RAM: 0, MemoryPlace.PROCESS_EXTERNAL: 1, MemoryPlace.EXTERNAL: 5}
ACCESSES_A_PUSH = {MemoryPlace.BLOCK_RAM: 0, MemoryPlace.PROCESS_EXTERNAL: 2, MemoryPlace.EXTERNAL: 3}
ACCESSES_A_PATH_CELL = {MemoryPlace.BLOCK_RAM: 0, MemoryPlace.PROCESS_EXTERNAL: 1, MemoryPlace.EXTERNAL: 2}
"""Accesses to the external memory."""


def init_cycles(cells: int) -> int:
    """Cycles of state Init."""
    return INIT_CYCLES * cells + INIT_CHANGES


def path_cycles(path_cells: int, place: MemoryPlace, external_cycles: int) -> int:
    """Cycles of state Path, for the L + 1 cells of a path."""
    # MarkPath (figure 5): a direction is read and a cell is marked; each external access adds its latency.
    each = PATH_CYCLES + external_cycles * ACCESSES_A_PATH_CELL[place]
    return each * path_cells + PATH_CHANGES


def ending_cycles(place: MemoryPlace, external_cycles: int) -> int:
    """Cycles of state BF outside of its expansions: push of the start, pop of the goal (or an empty queue)."""
    return SEARCH_CHANGES + (0 if place is MemoryPlace.BLOCK_RAM else 2 * external_cycles)


def total_cycles(
    cells: int,
    popped: int,
    path_steps: int,
    micro_architecture: MicroArchitecture = MicroArchitecture.THREE_CYCLES,
) -> int:
    """The law for a search that reaches its goal, all memories on the chip.

    >>> total_cycles(100 * 100, 4075, 300)
    67644
    """
    # The goal is popped but not expanded: V - 1 expansions. A path of L steps marks L + 1 cells.
    expansions = EXPANSION_CYCLES[micro_architecture] * (popped - 1)
    return INIT_CYCLES * cells + expansions + PATH_CYCLES * (path_steps + 1) + CONSTANT
