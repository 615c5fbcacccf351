"""Style ``bit_serial``: one serial node a cell of the block, on an FPGA (Girau et al. 2008, section 5)."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from codesign.figures import Figure, Status, weakest
from codesign.memo import Memo
from codesign.part import Part
from codesign.planners.harmonic.plan.fixed_point import Field, LowerBound
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.relax import Relaxation
from codesign.planners.harmonic.styles import levers, resources, timing
from codesign.planners.harmonic.styles.steps import DECIDE, LOAD, Costs, block_notes, relax_steps, task_step
from codesign.planners.interface import Problem
from codesign.planners.styles import Architecture, Demand, Memory, Step, is_done


class BitSerial(Architecture):
    """The paper's circuit. Its laws are in ``resources`` and ``timing``, the remedies in ``levers``."""

    planner = "harmonic"
    style = "bit_serial"
    description = (
        "a bit-serial circuit for each node of a block: p + 2 cycles an iteration, whatever the block"
    )
    component_type = "fpga"
    kernel = ""

    def notes(self, problem: Problem, parameters: RelaxParameters) -> tuple[str, ...]:
        """A block that is larger than the map."""
        return block_notes(problem, parameters)

    def demand(
        self,
        problem: Problem,
        parameters: RelaxParameters,
        part: Part,
        *,
        inside: frozenset[str] | None = None,
    ) -> Demand:
        """Resources of the circuit for the block and the last precision, and the words of its block RAMs.

        Where ``decide`` is not ``inside``, without the decision module. The OR tree that tells whether any bit changed
        stays where ``detect`` is not: its answer is what is sent.
        """
        map_shape = problem.rows, problem.columns
        block = parameters.block_shape(*map_shape)
        last = parameters.precisions[-1]
        depth, decision = resources.word_depth(part), is_done(DECIDE, inside)
        return Demand(
            items=resources.items(*block, last, decision),
            bounds=(levers.word_depth_bound(map_shape, block, last, part, depth, decision),),
            levers=levers.resource_levers(map_shape, block, last, part, depth, decision),
        )

    def clock_limit(self, problem: Problem, parameters: RelaxParameters, part: Part) -> Figure:
        """The fastest clock for a block of this size on the part, Hz."""
        return timing.clock_limit(*parameters.block_shape(problem.rows, problem.columns), part)

    def memory(self, problem: Problem, parameters: RelaxParameters) -> Memory:
        """p + 1 words of 18 bits for each block, in every cluster's RAM (section 5.4)."""
        blocks = parameters.block_count(problem.rows, problem.columns)
        last = parameters.precisions[-1]
        return Memory(resources.RAM_WIDTH, {f"block {block}": last + 1 for block in range(blocks)})

    def work(
        self,
        problem: Problem,
        parameters: RelaxParameters,
        *,
        memo: Memo | None = None,
        detail: bool = True,
        start: Field | None = None,
        inside: frozenset[str] | None = None,
    ) -> Generator[Step, None, Relaxation]:
        """Phases ``load``, ``relax`` and ``decide``; with ``detail`` a unit of ``relax`` is a visit.

        A ``LowerBound`` to start from is written into the block RAMs first. Any other start is what the last plan
        left in them: the map is brought in, and no value is touched but those of goals and obstacles.
        """
        rows, columns = parameters.block_shape(problem.rows, problem.columns)
        blocks = parameters.block_count(problem.rows, problem.columns)
        cells, last = problem.rows * problem.columns, parameters.precisions[-1]
        if start is None:
            load = timing.load_cycles(cells, blocks, last)
        elif isinstance(start, LowerBound):
            load = timing.load_start_cycles(cells, resources.cluster_count(rows, columns), blocks, last)
        else:
            load = timing.reload_cycles(cells)
        yield task_step(LOAD, load, ram_addresses=1)

        def iteration_cost(
            precision: int,
            block: NDArray[np.int32],  # noqa: ARG001
            iterations: NDArray[np.int64],
        ) -> NDArray[np.int64]:
            return iterations * timing.iteration_cycles(precision)

        switch = timing.switch_cycles(rows * columns, blocks)
        costs = Costs(
            iteration_cost, visit=switch, stage_end=timing.stage_end_cycles(rows * columns), ram_addresses=2
        )
        plan = yield from relax_steps(problem, parameters, costs, memo, detail, start, inside)
        if is_done(DECIDE, inside):
            yield self.decision(plan)
        return plan

    def decision(self, plan: Relaxation) -> Step:
        """One decision: the direction to take from one cell, once the plan stands."""
        return task_step(DECIDE, timing.decision_cycles(plan.precision), ram_addresses=1)

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static power of the part, and slices × clock × the part's power a slice and Hz, W.

        Block RAMs and clock tree are in the figure for a slice of a typical design; pins are not counted.
        """
        return slice_power(demand, clock, part)


def slice_power(demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
    """Static and dynamic power of a design of ``demand`` at ``clock`` Hz, W; see ``BitSerial.power``."""
    scale = demand.total("slices") * clock
    rate = part.dynamic_power
    low, high = rate.interval
    dynamic = Figure(
        value=rate.value * scale,
        unit="W",
        status=weakest(Status.CALIBRATED, rate.status),
        source=f"slices × clock × {rate.value * 1e12:.3g} µW a slice and MHz ({rate.source})",
        low=low * scale,
        high=high * scale,
    )
    return part.static_power, dynamic
