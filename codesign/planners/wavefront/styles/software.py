"""Style ``software``: the improved Dijkstra algorithm on a processor.

The paper's: sets of nodes with equal potential in place of a search for the minimum, ended at the stop node. A cycle
of a step stands for one unit of the kernel ``wavefront_cell``: one node taken from its set, with its eight neighbours.
The paper's 63 ms on a 133 MHz Pentium fix it, once it is assumed how many nodes of its map the wave reaches.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from codesign.memo import Memo
from codesign.planners.host import HostStyle
from codesign.planners.interface import Problem
from codesign.planners.styles import Step, is_done
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.plan.plan import WavefrontPlan
from codesign.planners.wavefront.styles.steps import (
    OBSTACLES,
    PROPAGATE,
    TRACK,
    planned,
    task_step,
    tracked_steps,
)


class Software(HostStyle):
    """Every node that the wave reaches costs one unit, and so does every step of the way. The latter is assumed."""

    planner = "wavefront"
    description = "one node after the other as the wave reaches it"
    kernel = "wavefront_cell"

    def work(
        self,
        problem: Problem,
        parameters: PropagateParameters,
        *,
        memo: Memo | None = None,
        detail: bool = True,  # noqa: ARG002
        start: Any = None,  # noqa: ARG002
        inside: frozenset[str] | None = None,
    ) -> Generator[Step, None, WavefrontPlan]:
        """Phases ``propagate_obstacles`` (safe paths), ``propagate`` and ``track``; cycles are units of ``kernel``.

        Every wave begins anew: ``start`` changes nothing.
        """
        plan = planned(problem, parameters, Memo() if memo is None else memo)
        if plan.obstacle_potentials is not None:
            yield task_step(OBSTACLES, problem.free.size)
        yield task_step(PROPAGATE, plan.reached_cells)
        if is_done(TRACK, inside):
            yield task_step(TRACK, tracked_steps(problem, parameters, plan))
        return plan
