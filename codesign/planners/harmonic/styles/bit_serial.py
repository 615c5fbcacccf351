"""Style ``bit_serial``: one serial node a cell of the block, on an FPGA (Girau et al. 2008, section 5)."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from codesign.figures import Figure
from codesign.part import Part
from codesign.planners.demand import Demand
from codesign.planners.harmonic.plan.fixed_point import LowerBound
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.relax import HarmonicPlan
from codesign.planners.harmonic.styles import levers, resources, timing
from codesign.planners.harmonic.styles.designs import block_designs
from codesign.planners.harmonic.styles.steps import DECIDE, LOAD, Costs, block_notes, relax_steps
from codesign.planners.host import one_step
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Architecture, Designs, Memory, Step, slice_power


class BitSerial(Architecture):
    """The paper's circuit. Its laws are in ``resources`` and ``timing``, the remedies in ``levers``."""

    planner = "harmonic"
    style = "bit_serial"
    description = (
        "a bit-serial circuit for each node of a block: p + 2 cycles an iteration, whatever the block"
    )
    component_type = "fpga"

    def notes(self, job: Job[Problem, RelaxParameters]) -> tuple[str, ...]:
        """A block that is larger than the map."""
        return block_notes(job.problem, job.parameters)

    def designs(self, job: Job[Problem, Any]) -> Designs:
        """Blocks that fit the part, each at rising precisions."""
        return block_designs(job.problem.shape, job.chip, job.does(DECIDE))

    def demand(self, job: Job[Problem, RelaxParameters]) -> Demand:
        """Resources of the circuit for the block and the last precision, and the words of its block RAMs.

        Without the decision module where another component does ``decide``. The OR tree that detects a changed bit
        stays where another component does ``detect``, since its answer is sent.
        """
        problem, parameters, part = job.problem, job.parameters, job.chip
        map_shape = problem.shape
        block = parameters.block_shape(*map_shape)
        precisions = parameters.precisions
        last = precisions[-1]
        depth, decision = resources.word_depth(part), job.does(DECIDE)
        return Demand(
            items=resources.items(*block, last, decision),
            bounds=(levers.word_depth_bound(map_shape, block, precisions, part, depth, decision),),
            levers=levers.resource_levers(map_shape, block, precisions, part, depth, decision),
        )

    def clock_limit(self, job: Job[Problem, RelaxParameters]) -> Figure:
        """The fastest clock for a block of this size on the part, Hz."""
        problem = job.problem
        return timing.clock_limit(*job.parameters.block_shape(*problem.shape), job.chip)

    def memory(self, job: Job[Problem, RelaxParameters]) -> Memory:
        """p + 1 words of 18 bits for each block, in every cluster's RAM (section 5.4)."""
        problem, parameters = job.problem, job.parameters
        blocks = parameters.block_count(*problem.shape)
        last = parameters.precisions[-1]
        return Memory(resources.RAM_WIDTH, {f"block {block}": last + 1 for block in range(blocks)})

    def work(self, job: Job[Problem, RelaxParameters]) -> Generator[Step, None, HarmonicPlan]:
        """Phases ``load``, ``relax`` and ``decide``; with ``detail`` a unit of ``relax`` is a visit.

        A ``LowerBound`` as start is written into the block RAMs first. Any other start is already in them, from the
        last plan. Then loading the map changes only the values of goals and obstacles.
        """
        problem, parameters, start = job.problem, job.parameters, job.start
        rows, columns = parameters.block_shape(*problem.shape)
        blocks = parameters.block_count(*problem.shape)
        cells, last = problem.rows * problem.columns, parameters.precisions[-1]
        if start is None:
            load = timing.load_cycles(cells, blocks, last)
        elif isinstance(start, LowerBound):
            load = timing.load_start_cycles(cells, resources.cluster_count(rows, columns), blocks, last)
        else:
            load = timing.reload_cycles(cells)
        yield one_step(LOAD, load, ram_addresses=1)

        costs = Costs(
            lambda precision, _block, iterations: iterations * timing.iteration_cycles(precision),
            visit=timing.switch_cycles(rows * columns, blocks),
            stage_end=timing.stage_end_cycles(rows * columns),
            ram_addresses=2,
        )
        plan = yield from relax_steps(job, costs)
        if job.does(DECIDE):
            yield self.decision(plan)
        return plan

    def decision(self, plan: HarmonicPlan) -> Step:
        """One decision after planning: the direction from one cell."""
        return one_step(DECIDE, timing.decision_cycles(plan.precision), ram_addresses=1)

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static power of the part, and slices × clock × the part's power a slice and Hz, W."""
        return slice_power(demand, clock, part)
