"""Style ``delay_line``: the paper's node, three flip-flops and a register, one for each node of the map."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from codesign.planners.interface import Problem
from codesign.planners.job import Job, Line
from codesign.planners.styles import Step, one_step
from codesign.planners.wavefront.plan.parameters import MAX_ELEMENT_CELLS, PropagateParameters
from codesign.planners.wavefront.plan.plan import sizing_plan
from codesign.planners.wavefront.plan.wave import longest_distance
from codesign.planners.wavefront.styles import resources, timing
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.steps import OBSTACLES, PROPAGATE, planned, read_out_steps


class DelayLine(ArrayStyle):
    """Figure 2. The wave is the computation: D_stop + 1 cycles, and fewer nodes reached where it stops early."""

    style = "delay_line"
    description = "a node of delay lines for every cell: the wave is the computation"

    def largest_potential(self, job: Job[Problem, PropagateParameters]) -> int:
        """D_stop of the farthest start, or the largest potential of the map where the wave runs to its end."""
        largest = sizing_plan(job.problem, job.parameters).largest_potential
        return max(largest, self.chained_distance(job))

    def variants(self, job: Job[Problem, Any], design: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """Each read-out, and elements of up to a column: more cells take more cycles and no fewer elements."""
        for variant in super().variants(job, design):
            for power in range(min(MAX_ELEMENT_CELLS, job.problem.rows - 1).bit_length() + 1):
                yield {**variant, "element_cells": 1 << power}

    def items(self, job: Job[Problem, PropagateParameters]) -> tuple[Line, ...]:
        """Nodes or elements, their memories, read-out, tracker and control."""
        return resources.array_items(self.layout(job), job.chip)

    def wave_steps(self, job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
        """D + 1 steps: of the stop, or of the farthest cell; for p^d, of the longest distance of the map."""
        plan, cells = planned(job), job.parameters.element_cells
        if plan.obstacle_potentials is not None:
            longest = longest_distance(job.problem.shape, job.parameters.delays)
            yield one_step(OBSTACLES, timing.wave_cycles(longest, cells))
            yield from read_out_steps(job)
        yield one_step(PROPAGATE, timing.wave_cycles(plan.largest_potential, cells))
        yield from read_out_steps(job)
