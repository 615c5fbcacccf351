"""Style ``state_machine``: Standby, Init, BF, Path on an FPGA (Vacariu et al. 2008, section 3)."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import Figure, Status, weakest
from codesign.ground.memo import Memo
from codesign.ground.models import Part
from codesign.planners.breadth_first import published
from codesign.planners.breadth_first.plan.parameters import (
    MemoryPlace,
    MicroArchitecture,
    SearchParameters,
    VgaController,
)
from codesign.planners.breadth_first.plan.planner import searched
from codesign.planners.breadth_first.plan.search import BreadthFirstPlan
from codesign.planners.breadth_first.styles import external as outside
from codesign.planners.breadth_first.styles import resources, timing
from codesign.planners.breadth_first.styles.timing import (
    INIT,
    PATH,
    SEARCH,
    TRACK,
    expansions,
    pushes_of_each_pop,
    step,
    steps,
)
from codesign.planners.clock_law import on_family
from codesign.planners.counted import counted_activity, slice_power
from codesign.planners.external_memory import Traffic
from codesign.planners.interface import Problem
from codesign.planners.job import Demand, Job
from codesign.planners.styles import Architecture, Designs, Memory, Step

SLICES_A_BLOCK_RAM = 16
"""Slices that count for a block RAM in the dynamic power; 4 to 64 bound it. Assumed: the figure of the part for a slice
is for designs of mostly logic and wires. This design is mostly memory."""
SLICES_A_BLOCK_RAM_LOW, SLICES_A_BLOCK_RAM_HIGH = 4, 64

_depths = Memo(max_bytes=2**20)


class StateMachine(Architecture):
    """The paper's circuit. Its laws are in ``timing`` and ``resources``, and in ``external`` for an external memory.

    ``Job.external`` is the memory that the mapping names. Without it, ``search.external_cycles`` describes one.
    """

    planner = "breadth_first"
    style = "state_machine"
    description = "one cell after the other by a state machine, its memories in block RAM or outside"
    component_type = "fpga"
    supports_external = True
    beyond = "a queue of fewer words, a map in the logic, other forms of its addresses"

    def designs(self, job: Job[Problem, Any]) -> Designs:
        """Every micro-architecture without a screen, the fastest first; memories on the chip, or in the one outside."""
        inside, *outside_chip = MemoryPlace
        places = [inside] if job.external is None else outside_chip
        return tuple(
            ({"micro_architecture": str(each), "memory": str(memory), "display": str(VgaController.NONE)},)
            for each in reversed(MicroArchitecture)
            for memory in places
        )

    def demand(self, job: Job[Problem, SearchParameters]) -> Demand:
        """Memories and logic for a map of this size, the ports of the cells' memory, the queue, the screen.

        With an external memory, the memories that move out are no demand of the part; their bits are a bound.
        ``Job.inside`` changes nothing. The states were synthesised as one machine, so the share of Path is unknown. The
        directions, which only Path reads, are sent where another component does ``track``. A queue that is given holds
        the search from every start.
        """
        problem, parameters, part, external = job.problem, job.parameters, job.chip, job.external
        parameters = outside.placed(parameters, external)
        depth = None if parameters.queue_words is None else _deepest(job)
        return Demand(
            items=resources.items(problem, parameters, part, external),
            bounds=(
                *resources.bounds(problem, parameters, depth),
                *resources.other_rams(problem.shape, parameters, part),
                *([outside.capacity(problem, parameters, external)] if external is not None else ()),
            ),
            levers=resources.levers(problem, parameters, part),
        )

    def clock_limit(self, job: Job[Problem, SearchParameters]) -> Figure:
        """The paper's 185 MHz, or the limit of the block RAM or the external memory where that is lower, Hz.

        Published for the XC2VP30-6, for no size in particular: other parts, sizes and micro-architectures are
        assumed to reach it too. The low end is the fastest clock with published times, on other families less
        (``on_family``).
        """
        if job.external is not None:
            return outside.clock_limit(self.clock_limit(replace(job, external=None)), job.external)
        part = job.chip
        ram = resources.ram_clock(job.problem.shape, job.parameters, part)
        synthesised = part.full_name == "XC2VP30-6"
        limit = Figure(
            value=published.CLOCK_LIMIT,
            unit="Hz",
            status=Status.PUBLISHED if synthesised else Status.ASSUMED,
            source=f"{published.PAPER}, section 3.2: synthesis for the XC2VP30-6",
            low=published.SHOWN_CLOCK,
            high=published.CLOCK_LIMIT,
        )
        return on_family(
            ram if ram.value < published.CLOCK_LIMIT else limit,
            part,
            published.FAMILY,
            registers=timing.registers(
                job.problem.shape,
                job.parameters.address,
                shown=job.parameters.display is not VgaController.NONE,
                short=job.parameters.queue_words is not None,
                external=job.parameters.memory is not MemoryPlace.BLOCK_RAM,
            ),
            placements=timing.placements(),
        )

    def memory(self, job: Job[Problem, SearchParameters]) -> Memory | None:
        """One bit of the cells in each of their block RAMs; None where the cells are external."""
        problem = job.problem
        if job.parameters.memory is MemoryPlace.EXTERNAL:
            return None
        words = 1 << resources.address_bits(*problem.shape, job.parameters.address)
        return Memory(1, {"cells": min(words, 16_384)})

    def work(self, job: Job[Problem, SearchParameters]) -> Generator[Step, None, BreadthFirstPlan]:
        """Phases ``init``, ``bf`` and ``path``; with ``detail`` a unit of ``bf`` is a popped cell.

        State Path is the task ``track``; a search for a field ends with the empty queue. Every search begins anew:
        ``start`` changes nothing. The addresses are those that a search makes. A display that reads the same memory is
        a component of its own.
        """
        problem, parameters, external = job.problem, job.parameters, job.external
        parameters = outside.placed(parameters, external)
        addresses = int(parameters.memory is not MemoryPlace.EXTERNAL)
        cycles, traffic = timing.init_cycles(problem.shape, parameters), None
        if external is not None:
            cycles, traffic = outside.init(problem, parameters, external)
        yield step(INIT, cycles, addresses, traffic)
        plan = searched(job)
        if external is not None:
            traffic = outside.search(plan, problem, parameters, external)
        units = self.expansion_cycles(plan, parameters, traffic)
        searching = timing.SEARCH_ADDRESSES[parameters.micro_architecture] * addresses
        if job.detail:
            yield from steps(SEARCH, units, searching, traffic)
        else:
            yield step(SEARCH, int(units.sum()), searching, traffic)
        if plan.reached and not plan.everywhere and job.does(TRACK):
            cycles = timing.path_cycles(len(plan.path), parameters.memory, parameters.external_cycles)
            if external is not None:
                cycles, traffic = outside.path(plan, parameters, external)
            yield step(PATH, cycles, addresses, traffic)
        return plan

    def expansion_cycles(
        self, plan: BreadthFirstPlan, parameters: SearchParameters, traffic: Traffic | None = None
    ) -> NDArray[np.int64]:
        """Cycles of state BF: int64, one entry an expansion, and one for the cycles outside of them.

        ``traffic``: of the external memory that the mapping names.
        """
        place, latency = parameters.memory, parameters.external_cycles
        each = timing.EXPANSION_CYCLES[parameters.micro_architecture]
        cycles = np.full(expansions(plan) + 1, each, np.int64)
        if traffic is not None:
            cycles[-1] = timing.SEARCH_CHANGES
            return cycles + traffic.cycles
        if place is not MemoryPlace.BLOCK_RAM:
            pushes = pushes_of_each_pop(plan)[: expansions(plan)]
            cycles[:-1] += latency * (timing.ACCESSES_A_POP[place] + timing.ACCESSES_A_PUSH[place] * pushes)
        cycles[-1] = timing.ending_cycles(place, latency)
        return cycles

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static power of the part, and (slices × activity + 16 a block RAM) × clock × the part's power a slice, W."""
        static, slices = slice_power(demand, clock, part, counted_activity(self.planner, self.style))
        rate = part.dynamic_power
        others = sum(line.figure.value for line in demand.bounds if line.figure.unit == resources.RAM_BLOCKS)
        (low, high), scale = rate.interval, clock * (demand.total("block_rams") + others)
        dynamic = Figure(
            value=slices.value + SLICES_A_BLOCK_RAM * rate.value * scale,
            unit="W",
            status=weakest(Status.ASSUMED, rate.status),
            source=f"{slices.source}; {SLICES_A_BLOCK_RAM} slices a block RAM, {SLICES_A_BLOCK_RAM_LOW} to"
            f" {SLICES_A_BLOCK_RAM_HIGH} bound it",
            low=slices.interval[0] + SLICES_A_BLOCK_RAM_LOW * low * scale,
            high=slices.interval[1] + SLICES_A_BLOCK_RAM_HIGH * high * scale,
        )
        return static, dynamic


def _deepest(job: Job[Problem, SearchParameters]) -> int:
    """The most words that a search of the problem queues: of each start and, for a replan, of each map."""
    problem = job.problem

    def depth(of: Job[Problem, SearchParameters]) -> int:
        key = (of.problem.map_digest, of.problem.starts[0], of.problem.task)
        return _depths.get(key, lambda: searched(replace(of, memo=None)).queue_depth)

    return max(
        depth(replace(job, problem=each.asked_from(start)))
        for each in dict.fromkeys((problem, problem.changed))
        for start in problem.starts
    )
