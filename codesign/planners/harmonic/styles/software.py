"""Styles ``software`` and ``software_limbs``: the relaxation on a processor.

A processor has no clock law here. A cycle of a step is one unit of the kernel ``harmonic_node_update``, and the
platform declares its cost. The paper's "around 100 µs per iteration with a 36x66 block" (section 5.4) is 42 ns a node.

The paper does not say how this cost grows with the precision, and its speed-up of about 270 at p = 255 requires some
growth. So there are two styles. An update of ``software`` costs the same at any precision, as with doubles. An update
of ``software_limbs`` costs a unit for each 64-bit limb of a value of p + 1 bits, the least for exact integers.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.figures import Figure
from codesign.ground.late import late
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.plan.arguments import Visits
from codesign.planners.harmonic.plan.fixed_point import limbs_needed
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.relax import HarmonicPlan
from codesign.planners.harmonic.plan.trajectory import directions
from codesign.planners.harmonic.plan.warm_start import warm_start
from codesign.planners.harmonic.styles.designs import BEYOND, FIRST, LAST, WORD, host_designs
from codesign.planners.harmonic.styles.families import QUICK, least_stages
from codesign.planners.harmonic.styles.find import find_schedule
from codesign.planners.harmonic.styles.steps import DECIDE, Costs, notes, relax_steps
from codesign.planners.interface import LOWER_BOUND, Problem
from codesign.planners.job import Job
from codesign.planners.plug_in import Probe
from codesign.planners.styles import Designs, Family, Found, HostStyle, Step, assumed_bytes

DECISION_UPDATES = 4
"""The cost of one decision in node updates: four triangles, each about the work of an average. Assumed."""


def block_cells(map_shape: tuple[int, int], block: tuple[int, int]) -> NDArray[np.int64]:
    """Cells of each block in raster order, int64; the last of a row or column may hold fewer."""
    sides = [
        np.minimum(size, length - np.arange(0, length, size)) for size, length in zip(block, map_shape, strict=True)
    ]
    return np.outer(*sides).astype(np.int64).ravel()


class Software(HostStyle):
    """Every cell of a block is updated at each of its iterations, one after the other."""

    planner = "harmonic"
    kernel = "harmonic_node_update"
    beyond = f"blocks smaller than the map, {BEYOND}"

    def __init__(self, style: str, *, limbs: bool = False) -> None:
        cost = "a unit for each 64 bits of a value" if limbs else "one unit at any precision"
        self.style, self.description = style, f"node after node, an update costing {cost}"
        self._limbs = limbs

    def units(self, precision: int) -> int:
        """Units of the kernel that one node update takes at ``precision`` bits."""
        return limbs_needed(precision) if self._limbs else 1

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """The whole map as one block, at rising precisions, which end with a word at one unit an update."""
        return host_designs(LAST[-1] if self._limbs else WORD)

    def families(self, job: Job[Problem, Any]) -> Iterator[Family]:
        """The chain of ``designs``: its first stages take at least the iterations of the whole map as one block."""
        stages = least_stages(job.problem, QUICK) if job.does(LOWER_BOUND) else ((FIRST, 1),)
        updates = sum(count * self.units(bits) for bits, count in stages) * job.problem.free.size
        decision = DECISION_UPDATES * self.units(stages[-1][0]) if job.does(DECIDE) else 0
        for chain in self.designs(job):
            yield Family(
                chain,
                {self.kernel: updates + decision},
                {"last bits": (LAST[0], LAST[-1] if self._limbs else WORD)},
                len(chain),
            )

    def bytes_a_cell(self, job: Job[Problem, RelaxParameters]) -> Figure:
        """The map in a byte, and a value of the last precision in 64-bit limbs."""
        last = job.parameters.precisions[-1]
        limbs = 8 * limbs_needed(last)
        source = f"the map in a byte, and a value of {last} bits in {limbs} bytes, updated in place"
        return assumed_bytes(limbs + 1, source, low=(last + 2) / 8, high=2 * limbs + 1)

    def notes(self, job: Job[Problem, RelaxParameters]) -> tuple[str, ...]:
        """See ``steps.notes``."""
        return notes(job.problem, job.parameters)

    def work(self, job: Job[Problem, RelaxParameters]) -> Generator[Step, None, HarmonicPlan]:
        """Phases ``relax`` and ``decide``; cycles are units of ``kernel``."""
        plan = yield from relax_steps(job, self.costs(job))
        if job.does(DECIDE):
            yield self.decision(plan)
        return plan

    def find(self, job: Job[Problem, RelaxParameters]) -> Found:
        """The schedule of fewest node updates; see ``find.find_schedule``."""
        return find_schedule(self.style, job, self.costs(job))

    def costs(self, job: Job[Problem, RelaxParameters]) -> Costs:
        """Units of ``kernel`` for visits: every cell of the block at each iteration."""
        map_shape = job.problem.shape
        cells = block_cells(map_shape, job.parameters.block_shape(*map_shape))

        def iteration_cost(precision: int, visits: Visits) -> NDArray[np.int64]:
            return visits.iterations * cells[visits.block] * self.units(precision)

        return Costs(iteration_cost)

    def decision(self, plan: HarmonicPlan) -> Step:
        """One decision, in units of ``kernel``."""
        return Step(DECIDE, np.array([DECISION_UPDATES * self.units(plan.precision)], np.int64))


node_kernels = late("codesign.planners.harmonic.styles.node_kernels")


def _harmonic() -> Probe:
    """Iterations over a maze as one block, from zero, node after node.

    Its values fill 2.1 MB. On smaller maps, which the caches hold, an iteration is faster, and on larger ones slower.
    """
    free = maps.maze(360, 360, corridor=6, seed=1).free

    def run() -> Any:
        return node_kernels.relax_nodes(free, [(3, 3)], (31,), most=100)[1]

    return Probe(sum(run()) * free.size, run)


def _harmonic_decision() -> Probe:
    """Directions at all free cells of a map of rooms, at 62 bits."""
    free = maps.rooms(128, 128, room=(40, 40), door=8, wall=2, seed=4).free
    field = relax(free, [(64, 64)], block=free.shape, iterations=64, schedule=(62,), record_visits=False).field
    return Probe(int(free.sum()), lambda: directions(field, free))


def _sparse_solve() -> Probe:
    """A start nowhere above the field at 63 bits: factors, refinement, certificate."""
    free = maps.rooms(128, 128, room=(40, 40), door=8, wall=2, seed=4).free
    return Probe(int(free.sum()), lambda: warm_start(free, [(64, 64)], 63))


PROBES: Mapping[str, Callable[[], Probe]] = {
    "harmonic_node_update": _harmonic,
    "harmonic_decision": _harmonic_decision,
    "sparse_solve_cell": _sparse_solve,
}
"""The measurement of each kernel, by the name of its cost in a platform."""
