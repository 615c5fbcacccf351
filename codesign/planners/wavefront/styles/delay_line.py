"""Style ``delay_line``: the paper's node, three flip-flops and a register, one for each node of the map."""

from __future__ import annotations

from collections.abc import Iterator

from codesign.planners.demand import Line
from codesign.planners.host import one_step
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Step
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.plan.plan import sizing_plan
from codesign.planners.wavefront.plan.wave import longest_distance, stop_cycle
from codesign.planners.wavefront.styles import resources, timing
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.steps import OBSTACLES, PROPAGATE, planned


class DelayLine(ArrayStyle):
    """Figure 2. The wave is the computation: D_stop + 1 cycles, and fewer nodes reached where it stops early."""

    style = "delay_line"
    description = "a node of delay lines for every cell: the wave is the computation"

    def largest_potential(self, job: Job[Problem, PropagateParameters]) -> int:
        """D_stop of the farthest start, or the largest potential of the map where the wave runs to its end."""
        return sizing_plan(job.problem, job.parameters).largest_potential

    def items(self, job: Job[Problem, PropagateParameters]) -> tuple[Line, ...]:
        """Nodes, counter, select lines."""
        layout = self.layout(job)
        return resources.array_items(resources.delay_line_node(layout), layout)

    def wave_steps(self, job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
        """D_stop + 1 cycles; with no stop until the counter is full; for p^d, to the longest distance of the map."""
        plan = planned(job)
        if plan.obstacle_potentials is not None:
            longest = longest_distance(job.problem.shape, job.parameters.delays)
            yield one_step(OBSTACLES, stop_cycle(longest))
        if plan.stop_potential is None:
            yield one_step(PROPAGATE, timing.whole_map_cycles(self.bits(job)))
        else:
            yield one_step(PROPAGATE, stop_cycle(plan.stop_potential))
