"""Styles ``software`` and ``software_limbs``: the relaxation on a processor.

A processor has no clock law here: a cycle of a step stands for one unit of the kernel
``harmonic_node_update``, which the platform gives a cost (the paper's "around 100 µs per iteration with a
36x66 block", section 5.4, is 42 ns a node).

The paper does not say how this cost grows with the precision, and its speed-up of about 270 at p = 255 asks
for some growth. So there are two styles: one whose update costs the same at any precision, as doubles would,
and one whose update costs a unit for each 64-bit limb of a value of p + 1 bits, as exact integers would at
the least.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.relax import HarmonicPlan
from codesign.planners.harmonic.styles.steps import DECIDE, Costs, block_notes, relax_steps
from codesign.planners.host import HostStyle
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Step

LIMB_BITS = 64
DECISION_UPDATES = 4
"""Node updates that one decision is worth: four triangles, each about the work of an average. Assumed."""


def limbs(precision: int) -> int:
    """64-bit limbs of a value of p + 1 bits.

    >>> limbs(62), limbs(63), limbs(64), limbs(255)
    (1, 1, 2, 4)
    """
    return -(-(precision + 1) // LIMB_BITS)


def block_cells(map_shape: tuple[int, int], block: tuple[int, int]) -> NDArray[np.int64]:
    """Cells of each block in raster order, int64; the last of a row or column may hold fewer."""
    sides = [
        np.minimum(size, length - np.arange(0, length, size))
        for size, length in zip(block, map_shape, strict=True)
    ]
    return np.outer(*sides).astype(np.int64).ravel()


class Software(HostStyle):
    """Every cell of a block is updated at each of its iterations, one after the other."""

    planner = "harmonic"
    kernel = "harmonic_node_update"

    def __init__(self, style: str, *, limbs: bool = False) -> None:
        cost = "a unit for each 64 bits of a value" if limbs else "one unit at any precision"
        self.style, self.description = style, f"node after node, an update costing {cost}"
        self._limbs = limbs

    def units(self, precision: int) -> int:
        """Units of the kernel that one node update takes at ``precision`` bits."""
        return limbs(precision) if self._limbs else 1

    def notes(self, job: Job[Problem, RelaxParameters]) -> tuple[str, ...]:
        """A block that is larger than the map."""
        return block_notes(job.problem, job.parameters)

    def work(self, job: Job[Problem, RelaxParameters]) -> Generator[Step, None, HarmonicPlan]:
        """Phases ``relax`` and ``decide``; cycles are units of ``kernel``."""
        problem, parameters = job.problem, job.parameters
        map_shape = problem.shape
        cells = block_cells(map_shape, parameters.block_shape(*map_shape))

        def iteration_cost(
            precision: int, block: NDArray[np.int32], iterations: NDArray[np.int64]
        ) -> NDArray[np.int64]:
            return iterations * cells[block] * self.units(precision)

        plan = yield from relax_steps(job, Costs(iteration_cost))
        if job.does(DECIDE):
            yield self.decision(plan)
        return plan

    def decision(self, plan: HarmonicPlan) -> Step:
        """One decision, in units of ``kernel``."""
        return Step(DECIDE, np.array([DECISION_UPDATES * self.units(plan.precision)], np.int64))
