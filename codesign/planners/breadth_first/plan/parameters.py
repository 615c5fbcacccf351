"""The parameters of breadth-first search in the mapping of a workload.

All of them describe the layout on a chip; none changes the answer. A processor ignores them.
"""

from __future__ import annotations

from enum import StrEnum

from pydantic import Field

from codesign.ground.models import TaskParameters

MAX_QUEUE_WORDS = 2**24


class MicroArchitecture(StrEnum):
    """The cycles that the state machine takes to look at one neighbour."""

    THREE_CYCLES = "three_cycles"
    TWO_CYCLES = "two_cycles"
    PIPELINED = "pipelined"


class Address(StrEnum):
    """The address of a cell in the memories.

    - ``side_by_side``: row and column, each of whole bits; no word is added to the map.
    - ``linear``: row × (columns + 1) + column; a wall follows every row but the last.
    """

    SIDE_BY_SIDE = "side_by_side"
    LINEAR = "linear"


class MemoryPlace(StrEnum):
    """The place of the memories of the search.

    - ``block_ram``: all on the chip.
    - ``process_external``: the cells on the chip, the process memory (directions and queue) outside.
    - ``external``: everything outside.
    """

    BLOCK_RAM = "block_ram"
    PROCESS_EXTERNAL = "process_external"
    EXTERNAL = "external"


class VgaController(StrEnum):
    """The VGA controller: none, on the second port of the cells' memory, or with its own copy of it."""

    NONE = "none"
    SHARED = "shared"
    COPY = "copy"


class SearchParameters(TaskParameters):
    """The layout of the state machine."""

    micro_architecture: MicroArchitecture = Field(
        default=MicroArchitecture.THREE_CYCLES, description="cycles a neighbour: three_cycles, two_cycles or pipelined"
    )
    address: Address = Field(
        default=Address.SIDE_BY_SIDE,
        description="address of a cell: side_by_side (row and column), or linear, which takes fewer memories where"
        " a side is a little over a power of two",
    )
    memory: MemoryPlace = Field(
        default=MemoryPlace.BLOCK_RAM, description="where the cells, the directions and the queue are kept"
    )
    display: VgaController = Field(
        default=VgaController.SHARED, description="VGA controller: none, shared (second port) or copy"
    )
    queue_words: int | None = Field(
        default=None,
        ge=1,
        le=MAX_QUEUE_WORDS,
        description="words of a circular queue; by default one for every cell, which never overflows",
    )
    external_cycles: int = Field(
        default=15,
        ge=1,
        le=10_000,
        description="clock cycles of one access to the external memory; the memory sets the time of an access, so"
        " a faster clock takes more cycles",
    )

    def unused(self, external_memory: bool) -> tuple[str, ...]:
        """A result leaves out ``external_cycles`` where the platform declares the memory, or all is on the chip."""
        on_chip = self.memory is MemoryPlace.BLOCK_RAM
        return ("external_cycles",) if external_memory or on_chip else ()


class TrackParameters(TaskParameters):
    """The task that marks the path has no parameters."""
