"""The parameters of breadth-first search, as a workload's mapping gives them.

All of them lay the search out on a chip; none changes the answer. A processor ignores them.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from codesign.models import TaskParameters

MAX_QUEUE_WORDS = 2**24


class MicroArchitecture(StrEnum):
    """How many cycles the state machine takes to look at one neighbour."""

    THREE_CYCLES = "three_cycles"
    TWO_CYCLES = "two_cycles"
    PIPELINED = "pipelined"


class MemoryPlace(StrEnum):
    """Where the memories of the search are.

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
    """How the state machine is laid out."""

    micro_architecture: Annotated[
        MicroArchitecture, Field(description="cycles a neighbour: three_cycles, two_cycles or pipelined")
    ] = MicroArchitecture.THREE_CYCLES
    memory: Annotated[
        MemoryPlace, Field(description="where the cells, the directions and the queue are kept")
    ] = MemoryPlace.BLOCK_RAM
    display: Annotated[
        VgaController, Field(description="VGA controller: none, shared (second port) or copy")
    ] = VgaController.SHARED
    queue_words: Annotated[
        int | None,
        Field(
            ge=1,
            le=MAX_QUEUE_WORDS,
            description="words of a circular queue; left out: one for every cell, which can never run over",
        ),
    ] = None
    external_cycles: Annotated[
        int,
        Field(
            ge=1,
            le=10_000,
            description="clock cycles of one access of the external memory; its time is the memory's, so a faster"
            " clock takes more of them",
        ),
    ] = 15

    def unused(self, external_memory: bool) -> tuple[str, ...]:
        """What a result leaves out: ``external_cycles`` where the platform's own memory, or none, is outside."""
        on_chip = self.memory is MemoryPlace.BLOCK_RAM
        return ("external_cycles",) if external_memory or on_chip else ()


class TrackParameters(TaskParameters):
    """The task that marks the path has nothing to choose."""
