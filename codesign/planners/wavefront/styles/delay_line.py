"""Style ``delay_line``: the paper's node, three flip-flops and a register, one for each node of the map."""

from __future__ import annotations

from collections.abc import Iterator

from codesign.memo import Memo
from codesign.part import Part
from codesign.planners.interface import Problem
from codesign.planners.styles import Line, Step
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.plan.plan import known_plan, sizing_parameters
from codesign.planners.wavefront.plan.wave import longest_distance, stop_cycle
from codesign.planners.wavefront.styles import resources, timing
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.resources import Layout
from codesign.planners.wavefront.styles.steps import OBSTACLES, PROPAGATE, planned, task_step


class DelayLine(ArrayStyle):
    """Figure 2. The wave is the computation: D_stop + 1 cycles, and fewer nodes reached where it stops early."""

    style = "delay_line"
    description = "a node of delay lines for every cell: the wave is the computation"

    def largest_potential(self, problem: Problem, parameters: PropagateParameters) -> int:
        """D_stop, or the largest potential of the map where the wave runs to its end."""
        return known_plan(problem, sizing_parameters(problem, parameters)).largest_potential

    def items(self, layout: Layout, problem: Problem, part: Part) -> tuple[Line, ...]:  # noqa: ARG002
        """Nodes, counter, select lines."""
        return resources.array_items(resources.delay_line_node(layout), layout)

    def wave_steps(
        self,
        problem: Problem,
        parameters: PropagateParameters,
        memo: Memo,
        detail: bool,  # noqa: ARG002
    ) -> Iterator[Step]:
        """D_stop + 1 cycles; with no stop until the counter is full; for p^d, to the longest distance of the map."""
        plan = planned(problem, parameters, memo)
        if plan.obstacle_potentials is not None:
            longest = longest_distance((problem.rows, problem.columns), parameters.delays)
            yield task_step(OBSTACLES, stop_cycle(longest))
        if plan.stop_potential is None:
            yield task_step(PROPAGATE, timing.whole_map_cycles(self.bits(problem, parameters)))
        else:
            yield task_step(PROPAGATE, stop_cycle(plan.stop_potential))
