"""The state machine with an external memory: the memories that move out, their accesses, and the clock.

Vacariu et al. (2008) print three sentences: the process memory can be "in an external dynamic RAM" (section 3.1.1),
"for these situations, an external Dynamic RAM memory can used" (3.2), and "the working frequency will obviously be
smaller" (4). There is no figure. All laws here are assumed, and err on the slow side:

- Design and memory share the memory's clock, so the search runs no faster than the memory. With two clocks the
  search would keep its own, and every access would cross between them.
- Nothing overlaps: the circuit stands still for each access.
- A cell and a direction take a byte each, written without being read first (byte enables). Each access is a random
  one: it takes the latency, and for DRAM it opens a row, though neighbours often lie in one row.
- The queue goes through two buffers of ``BUFFERED`` entries on the chip, which move 16 entries as one run, even where
  it is so short that it never leaves them.
- State Init clears the cells in order: one cycle a cell, or the cycles of the memory where these are more.
"""

from __future__ import annotations

import numpy as np

from codesign.ground.figures import Figure, Status
from codesign.planners.breadth_first.plan.parameters import MemoryPlace, SearchParameters
from codesign.planners.breadth_first.plan.search import BreadthFirstPlan
from codesign.planners.breadth_first.styles import timing
from codesign.planners.breadth_first.styles.resources import address_bits
from codesign.planners.breadth_first.styles.timing import expansions, pushes_of_each_pop
from codesign.planners.external_memory import ExternalMemoryLaw, Traffic
from codesign.planners.interface import Problem
from codesign.planners.job import Lever, Line

BYTE = 8
BUFFERED = 16
"""Queue entries of a buffer: a four-input LUT holds as many bits as a shift register."""

CELLS_A_POP = {MemoryPlace.PROCESS_EXTERNAL: 0, MemoryPlace.EXTERNAL: 4}
"""Cells read outside to expand one: its four neighbours."""
CELLS_A_PUSH = {MemoryPlace.PROCESS_EXTERNAL: 1, MemoryPlace.EXTERNAL: 2}
"""The direction, and the cell that is marked."""
CELLS_A_PATH_CELL = {MemoryPlace.PROCESS_EXTERNAL: 1, MemoryPlace.EXTERNAL: 2}
"""The direction, and the cell that is marked."""


def placed(parameters: SearchParameters, memory: ExternalMemoryLaw | None) -> SearchParameters:
    """The parameters with an external memory: the process memory moves out where they place all on the chip.

    As in the paper, the input matrix stays in block RAM. ``external`` moves it out too.
    """
    if memory is None or parameters.memory is not MemoryPlace.BLOCK_RAM:
        return parameters
    return parameters.model_copy(update={"memory": MemoryPlace.PROCESS_EXTERNAL})


def entry_bits(problem: Problem, parameters: SearchParameters) -> int:
    """Bits of a queue entry outside: an address in whole bytes."""
    return -(-address_bits(*problem.shape, parameters.address) // BYTE) * BYTE


def contents(problem: Problem, parameters: SearchParameters) -> dict[str, int]:
    """Bits of every external memory, by name."""
    words = 1 << address_bits(*problem.shape, parameters.address)
    process = {"directions": BYTE * words, "queue": entry_bits(problem, parameters) * (parameters.queue_words or words)}
    return {"cells": BYTE * words, **process} if parameters.memory is MemoryPlace.EXTERNAL else process


def capacity(problem: Problem, parameters: SearchParameters, memory: ExternalMemoryLaw) -> Line:
    """The bits that move out, against the capacity of the memory."""
    outside = contents(problem, parameters)
    need = sum(outside.values())
    levers = [Lever(axis := f"{memory.name}.capacity", f"at least {need:,} bits", axes={axis: f"{need} bit"})]
    if parameters.queue_words is None:
        levers.append(Lever("search.queue_words", "a circular queue, shorter than the map"))
    return Line.bound(
        name=f"bits of {memory.name}",
        demand=need,
        limit=memory.capacity,
        unit="bits",
        status=Status.ASSUMED,
        source=", ".join(f"{name} {bits:,}" for name, bits in outside.items()) + "; a byte a cell",
        levers=tuple(levers),
    )


def clock_limit(alone: Figure, memory: ExternalMemoryLaw) -> Figure:
    """The slower of the design's own limit (Hz) and the memory's clock, which the two share."""
    if alone.value <= memory.hz:
        return alone
    return Figure(
        value=memory.hz,
        unit="Hz",
        status=Status.ASSUMED,
        source=f"one clock for the design and {memory.name}; the paper says 'smaller', without a figure",
        low=min(memory.hz, alone.interval[0]),
        high=alone.interval[1],
    )


def init(problem: Problem, parameters: SearchParameters, memory: ExternalMemoryLaw) -> tuple[int, Traffic]:
    """Cycles of state Init, and its traffic."""
    inside = timing.init_cycles(problem.shape, parameters)
    if parameters.memory is not MemoryPlace.EXTERNAL:
        return inside, _traffic(0, 0)
    words = _words(BYTE * timing.cell_words(problem.shape, parameters.address), memory)
    outside = memory.sequential_cycles(words)
    return max(inside, outside), _traffic(outside, words)


def path(plan: BreadthFirstPlan, parameters: SearchParameters, memory: ExternalMemoryLaw) -> tuple[int, Traffic]:
    """Cycles of state Path, and its traffic: one cell after the other, as each direction gives the next cell."""
    accesses = CELLS_A_PATH_CELL[parameters.memory] * len(plan.path)
    outside = memory.refreshed(accesses * _cell_cycles(memory))
    inside = timing.path_cycles(len(plan.path), MemoryPlace.BLOCK_RAM, 0)
    return inside + outside, _traffic(outside, accesses * _words(BYTE, memory))


def search(
    plan: BreadthFirstPlan, problem: Problem, parameters: SearchParameters, memory: ExternalMemoryLaw
) -> Traffic:
    """Traffic of state BF: one entry an expansion, and one for the accesses outside of them.

    Where n is a multiple of 16, the n-th pop (from 0) moves 16 entries of the queue in, and the n-th push (from 1)
    moves 16 out. The start is the first pop and the first push, and the goal is the last pop.
    """
    expanded = expansions(plan)
    pushes = pushes_of_each_pop(plan)[:expanded]
    cells, runs = np.zeros(expanded + 1, np.int64), np.zeros(expanded + 1, np.int64)
    cells[:-1] = CELLS_A_POP[parameters.memory] + CELLS_A_PUSH[parameters.memory] * pushes
    runs[:-1] = np.diff(np.cumsum(np.concatenate(([1], pushes))) // BUFFERED)
    runs[: plan.popped_cells : BUFFERED] += 1
    words = _words(BUFFERED * entry_bits(problem, parameters), memory)
    cycles = _cell_cycles(memory) * cells + memory.run_cycles(words) * runs
    return Traffic(memory.refreshed_units(cycles), _words(BYTE, memory) * cells + words * runs)


def _traffic(cycles: int, words: int) -> Traffic:
    return Traffic(np.array([cycles], np.int64), np.array([words], np.int64))


def _cell_cycles(memory: ExternalMemoryLaw) -> int:
    return memory.run_cycles(_words(BYTE, memory))


def _words(bits: int, memory: ExternalMemoryLaw) -> int:
    return -(-bits // memory.width)
