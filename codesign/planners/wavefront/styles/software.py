"""Style ``software``: the improved Dijkstra algorithm on a processor.

The paper's algorithm keeps sets of nodes with equal potential in place of a search for the minimum, and ends at the
stop node. A cycle of a step stands for one unit of the kernel ``wavefront_cell``: one node taken from its set, with its
eight neighbours. The paper's 63 ms on a 133 MHz Pentium and an assumed number of reached nodes give the cost of a unit.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from codesign.figures import Figure
from codesign.planners.host import HostStyle, assumed_bytes, one_step
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Designs, Step
from codesign.planners.wavefront.plan.parameters import Paths, PropagateParameters
from codesign.planners.wavefront.plan.plan import WavefrontPlan
from codesign.planners.wavefront.styles.designs import DESIGNS
from codesign.planners.wavefront.styles.steps import OBSTACLES, PROPAGATE, TRACK, planned, tracked_steps

BYTES = assumed_bytes(
    9, "the map in a byte, a 32-bit potential, and sets of 32-bit cells for all of them", 4, 16
)
SAFE_BYTES = assumed_bytes(13, f"{BYTES.source}; a 32-bit potential of the obstacles", 6, 20)


class Software(HostStyle):
    """Every node that the wave reaches costs one unit, and so does every step of the path. The latter is assumed."""

    planner = "wavefront"
    description = "one node after the other as the wave reaches it"
    kernel = "wavefront_cell"

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """For the starts and for the whole map."""
        return DESIGNS

    def bytes_a_cell(self, job: Job[Problem, PropagateParameters]) -> Figure:
        """The map, the potential and the sets; safe paths take a second potential."""
        return SAFE_BYTES if job.parameters.paths is Paths.SAFE else BYTES

    def work(self, job: Job[Problem, PropagateParameters]) -> Generator[Step, None, WavefrontPlan]:
        """Phases ``propagate_obstacles`` (safe paths), ``propagate`` and ``track``; cycles are units of ``kernel``.

        Every wave begins anew: ``start`` changes nothing.
        """
        plan = planned(job)
        if plan.obstacle_potentials is not None:
            yield one_step(OBSTACLES, job.problem.free.size)
        yield one_step(PROPAGATE, plan.reached_cells)
        if job.does(TRACK):
            yield one_step(TRACK, tracked_steps(job, plan))
        return plan
