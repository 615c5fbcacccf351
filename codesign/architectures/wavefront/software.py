"""Style ``software``: the improved Dijkstra algorithm on a processor.

The paper's: sets of nodes with equal potential in place of a search for the minimum, ended at the stop node. A cycle
of a step stands for one unit of the kernel ``wavefront_cell``: one node taken from its set, with its eight neighbours.
The paper's 63 ms on a 133 MHz Pentium fix it, once it is assumed how many nodes of its map the wave reaches.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from codesign.architectures.interface import Demand, Step, is_done
from codesign.architectures.wavefront.steps import (
    OBSTACLES,
    PROPAGATE,
    TRACK,
    planned,
    task_step,
    tracked_steps,
)
from codesign.errors import InputError
from codesign.figures import Figure
from codesign.memo import Memo
from codesign.planners.interface import Problem
from codesign.planners.wavefront.parameters import PropagateParameters
from codesign.planners.wavefront.plan import WavefrontPlan
from codesign.spec.part import Part


class Software:
    """Every node that the wave reaches costs one unit, and so does every step of the way. The latter is assumed."""

    planner = "wavefront"
    style = "software"
    description = "one node after the other as the wave reaches it"
    component_type = "processor"
    kernel = "wavefront_cell"

    def demand(
        self,
        problem: Problem,  # noqa: ARG002
        parameters: PropagateParameters,  # noqa: ARG002
        part: Part | None = None,  # noqa: ARG002
        *,
        inside: frozenset[str] | None = None,  # noqa: ARG002
    ) -> Demand:
        """Software takes no resource of a part."""
        return Demand(items=())

    def clock_limit(
        self,
        problem: Problem,  # noqa: ARG002
        parameters: PropagateParameters,  # noqa: ARG002
        part: Part | None = None,  # noqa: ARG002
    ) -> Figure:
        """A processor's clock is its own: there is no law to hold it against.

        Raises:
            InputError: always.
        """
        raise InputError("a processor's clock has no limit law", self.style, "give it in the platform")

    def memory(self, problem: Problem, parameters: PropagateParameters) -> None:
        """Software keeps its potentials in the processor's own memory."""

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

    def power(self, demand: Demand, clock: int, part: Part | None = None) -> tuple[Figure, Figure]:  # noqa: ARG002
        """A processor's power stands in the platform, not in a law.

        Raises:
            InputError: always.
        """
        raise InputError("a processor's power has no law", self.style, "give it in the platform")
