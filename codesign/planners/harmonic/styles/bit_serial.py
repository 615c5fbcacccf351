"""Style ``bit_serial``: one serial node a cell of the block, on an FPGA (Girau et al. 2008, section 5)."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import Figure
from codesign.ground.memo import Same
from codesign.ground.models import Part
from codesign.planners.counted import counted_activity, slice_power
from codesign.planners.harmonic.plan.arguments import Visits
from codesign.planners.harmonic.plan.fixed_point import LowerBound
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop, Termination
from codesign.planners.harmonic.plan.relax import HarmonicPlan
from codesign.planners.harmonic.styles import resources, timing
from codesign.planners.harmonic.styles.designs import BEYOND
from codesign.planners.harmonic.styles.families import BlockSpace
from codesign.planners.harmonic.styles.find import find_schedule
from codesign.planners.harmonic.styles.steps import DECIDE, LOAD, READ, Costs, notes, relax_steps
from codesign.planners.interface import LOWER_BOUND, Problem
from codesign.planners.job import Demand, Job, Line, short_resources
from codesign.planners.styles import Architecture, Family, Found, Memory, Step, one_step


class BitSerial(Architecture):
    """The paper's circuit. Its laws and remedies are in ``resources`` and ``timing``."""

    planner = "harmonic"
    style = "bit_serial"
    description = "a bit-serial circuit for each node of a block: p + 2 cycles an iteration, whatever the block"
    component_type = "fpga"
    beyond = f"{BEYOND}, digits of several bits, registers in the pipeline"

    def notes(self, job: Job[Problem, RelaxParameters]) -> tuple[str, ...]:
        """See ``steps.notes``."""
        return notes(job.problem, job.parameters)

    def find(self, job: Job[Problem, RelaxParameters]) -> Found:
        """The schedule of fewest cycles; see ``find.find_schedule``."""
        last = job.parameters.precisions[-1]
        # Any schedule has at least this one's demand.
        demand = self.demand(replace(job, parameters=job.parameters.model_copy(update={"schedule": (last,)})))
        broken = [bound for bound in demand.bounds if bound.limit is not None and bound.figure.value > bound.limit]
        fits = not broken and not short_resources(demand.items, job.chip)
        return find_schedule(self.style, job, relax_costs(job), fits=fits)

    def families(self, job: Job[Problem, Any]) -> Iterator[Family]:
        """Blocks of every shape that is no larger than the map, at rising precisions."""
        yield from BlockSpace(job.problem, job.chip, job.does(DECIDE), not job.does(LOWER_BOUND)).families()

    def demand(self, job: Job[Problem, RelaxParameters]) -> Demand:
        """Resources of the circuit for the block and the last precision, and the words of its block RAMs.

        Without the decision module where another component does ``decide``. The OR tree that detects a changed bit
        stays where another component does ``detect``, since its answer is sent.
        """
        return _demand(job.problem.shape, machine_of(job), job.parameters.precisions, Same(job.chip))

    def items(self, job: Job[Problem, RelaxParameters]) -> tuple[Line, ...]:
        """Resources of the circuit for the block and the last precision."""
        return resources.items(machine_of(job), job.chip.family)

    def clock_limit(self, job: Job[Problem, RelaxParameters]) -> Figure:
        """The fastest clock for a block of this size on the part, Hz."""
        problem = job.problem
        parameters = job.parameters
        options = timing.options(
            parameters.block_count(*problem.shape),
            decides=job.does(DECIDE),
            sound=parameters.termination is Termination.SOUND,
        )
        block = parameters.block_shape(*problem.shape)
        return timing.clock_limit(*block, job.chip, parameters.pipeline, parameters.digit_bits, options)

    def memory(self, job: Job[Problem, RelaxParameters]) -> Memory:
        """p + 1 words of 18 bits for each block, in every cluster's RAM (section 5.4); see ``resources.words``."""
        problem, parameters = job.problem, job.parameters
        blocks = parameters.block_count(*problem.shape)
        last = parameters.precisions[-1]
        depth = resources.words(1, last, parameters.digit_bits)
        return Memory(resources.RAM_WIDTH, {f"block {block}": depth for block in range(blocks)})

    def work(self, job: Job[Problem, RelaxParameters]) -> Generator[Step, None, HarmonicPlan]:
        """Phases ``load``, ``relax`` and ``decide``; with ``detail`` a unit of ``relax`` is a visit.

        Where another component decides, phase ``read`` takes the place of ``decide``: the field is read out.

        A ``LowerBound`` as start is written into the block RAMs first. Any other start is already in them, from the
        last plan. Then loading the map changes only the values of goals and obstacles.
        """
        problem, parameters, start = job.problem, job.parameters, job.start
        rows, columns = parameters.block_shape(*problem.shape)
        blocks = parameters.block_count(*problem.shape)
        last = parameters.precisions[-1]
        memories = resources.memories(rows, columns, *parameters.block_grid(*problem.shape))
        if start is None:
            load = timing.load_cycles(memories, blocks, last, parameters.digit_bits)
        elif isinstance(start, LowerBound):
            load = timing.load_start_cycles(memories, blocks, last)
        else:
            load = timing.reload_cycles(memories, blocks)
        yield one_step(LOAD, load, ram_addresses=1)

        plan = yield from relax_steps(job, relax_costs(job))
        options = parameters.pipeline, parameters.digit_bits
        if job.does(DECIDE):
            yield one_step(DECIDE, timing.decision_cycles(plan.precision, *options), ram_addresses=1)
        else:
            read = timing.read_cycles(rows, columns, blocks, plan.precision, *options)
            yield one_step(READ, read, ram_addresses=1)
        return plan

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static power of the part, and slices × clock × the part's power a slice and Hz × the counted activity, W."""
        activity = counted_activity(self.planner, self.style)
        return slice_power(demand, clock, part, activity)


@lru_cache(maxsize=1024)
def _demand(shape: tuple[int, int], machine: resources.Machine, precisions: tuple[int, ...], on: Same[Part]) -> Demand:
    """See ``BitSerial.demand``; designs that differ in iterations and termination have one object of it."""
    part = on.it
    depth = resources.word_depth(part)
    return Demand(
        items=resources.items(machine, part.family),
        bounds=(resources.word_depth_bound(shape, machine, precisions, part, depth),),
        levers=resources.resource_levers(shape, machine, precisions, part, depth),
    )


def machine_of(job: Job[Problem, RelaxParameters]) -> resources.Machine:
    """The variables that the resources of a design depend on."""
    parameters, shape = job.parameters, job.problem.shape
    return resources.Machine(
        *parameters.block_shape(*shape),
        parameters.precisions[-1],
        job.does(DECIDE),
        *parameters.block_grid(*shape),
        parameters.pipeline,
        len(parameters.precisions),
        parameters.digit_bits,
    )


def relax_costs(job: Job[Problem, RelaxParameters]) -> Costs:
    """The cycles of iterations, and the passes that are dropped: see ``timing``."""
    problem, parameters = job.problem, job.parameters
    shape, blocks = parameters.block_shape(*problem.shape), parameters.block_count(*problem.shape)
    dropped, digit_bits = timing.dropped_pass_cycles(*shape, parameters.pipeline), parameters.digit_bits
    published = parameters.termination is Termination.PUBLISHED

    def visits_cost(precision: int, visits: Visits) -> NDArray[np.int64]:
        # After the published test the next pass could write, so the circuit waits after each sweep.
        ends_sweep = (visits.block == blocks - 1) & published
        drops = np.where(ends_sweep, visits.count, visits.early) if blocks > 1 else 0
        return visits.iterations * timing.iteration_cycles(precision, digit_bits) + dropped * drops

    def stage_end(precision: int) -> int:
        if blocks == 1:
            return dropped
        if not published:
            # The visits of the last sweep take one iteration each: full ones where I = 1.
            return dropped if parameters.iterations == 1 else 0
        # Blocks that were visited before their neighbours are tested for local maxima again.
        checks = parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA
        return blocks * timing.iteration_cycles(precision, digit_bits) + dropped if checks else 0

    return Costs(visits_cost, stage_end, ram_addresses=2)
