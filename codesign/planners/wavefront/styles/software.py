"""Style ``software``: the improved Dijkstra algorithm on a processor.

The paper's algorithm keeps sets of nodes with equal potential in place of a search for the minimum, and ends at the
stop node. A cycle of a step stands for one unit of the kernel ``wavefront_cell``: one node taken from its set, with its
eight neighbours. The paper's 63 ms on a 133 MHz Pentium and an assumed number of reached nodes give the cost of a unit.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from typing import Any

import numpy as np

from codesign import maps
from codesign.ground.figures import Figure
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.plug_in import Probe
from codesign.planners.styles import Designs, Family, HostStyle, Step, assumed_bytes, map_read, one_step
from codesign.planners.wavefront.plan import propagate
from codesign.planners.wavefront.plan.parameters import Paths, PropagateParameters
from codesign.planners.wavefront.plan.plan import WavefrontPlan
from codesign.planners.wavefront.styles.designs import BEYOND, DESIGNS, exact_families
from codesign.planners.wavefront.styles.timing import OBSTACLES, PROPAGATE, TRACK, planned, tracked_steps

MAP_KERNEL = "wavefront_map_cell"
"""One cell of the map, prepared for a wave or for the tracking of paths."""

TIME_KERNEL = "wavefront_time_step"
"""One time of a wave: the eight directions are gone through, however few nodes send. A narrow maze has many times."""

SEED_CELLS = 14
"""Units of ``MAP_KERNEL`` of each obstacle, a source of the wave of safe paths. Fitted: docs/laws.md."""

BYTES = assumed_bytes(9, "the map in a byte, a 32-bit potential, and sets of 32-bit cells for all of them", 4, 16)
SAFE_BYTES = assumed_bytes(13, f"{BYTES.source}; a 32-bit potential of the obstacles", 6, 20)


def preparation(job: Job[Problem, PropagateParameters]) -> Step:
    """The cells of the map, prepared for the tracking of paths: a unit each, fitted (docs/laws.md)."""
    return map_read(TRACK, job.problem, MAP_KERNEL)


class Software(HostStyle):
    """Every node that the wave reaches costs one unit, and so does every step of the path. The latter is assumed.

    The work besides the nodes counts in units of ``MAP_KERNEL`` and ``TIME_KERNEL``.
    """

    planner = "wavefront"
    description = "one node after the other as the wave reaches it"
    kernel = "wavefront_cell"
    beyond = BEYOND

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """For the starts and for the whole map."""
        return DESIGNS

    def families(self, job: Job[Problem, Any]) -> Iterator[Family]:
        """Each design by itself, with its exact units."""
        yield from exact_families(self, job, (design for chain in self.designs(job) for design in chain))

    def kernels(self, _job: Job[Problem, PropagateParameters]) -> tuple[str, ...]:
        """Those of the nodes, of the cells of the map, and of the times of the wave."""
        return self.kernel, MAP_KERNEL, TIME_KERNEL

    def bytes_a_cell(self, job: Job[Problem, PropagateParameters]) -> Figure:
        """The map, the potential and the sets; safe paths take a second potential."""
        return SAFE_BYTES if job.parameters.paths is Paths.SAFE else BYTES

    def work(self, job: Job[Problem, PropagateParameters]) -> Generator[Step, None, WavefrontPlan]:
        """Phases ``propagate_obstacles`` (safe paths), ``propagate`` and ``track``; cycles are units of ``kernel``.

        Every wave begins anew: ``start`` changes nothing.
        """
        plan = planned(job)
        free = job.problem.free
        if plan.obstacle_potentials is not None:
            obstacles = int(free.size - free.sum())
            yield one_step(OBSTACLES, free.size)
            yield map_read(OBSTACLES, job.problem, MAP_KERNEL, SEED_CELLS * obstacles)
            yield one_step(OBSTACLES, int(plan.obstacle_potentials.max()) + 1, kernel=TIME_KERNEL)
        yield one_step(PROPAGATE, plan.reached_cells)
        yield map_read(PROPAGATE, job.problem, MAP_KERNEL)
        yield one_step(PROPAGATE, plan.largest_potential + 1, kernel=TIME_KERNEL)
        if job.does(TRACK):
            yield preparation(job)
            yield one_step(TRACK, tracked_steps(job, plan))
        return plan


_SIDE = 256
_LAST = 4 * _SIDE
"""About the last time of a wave over a square of rooms."""


def _prepare() -> object:
    return propagate(np.ones((_SIDE, _SIDE), np.bool_), [(0, 0)], limit=0)


def _times() -> object:
    """A wave along a corridor of one cell, until that time."""
    return propagate(np.ones((1, _LAST), np.bool_), [(0, 0)], limit=_LAST)


def _wavefront() -> Probe:
    """The nodes of a wave over small rooms; its preparation and its times are left out."""
    free = maps.rooms(_SIDE, _SIDE, room=(15, 15), door=2, wall=1, seed=1).free
    reached = int((propagate(free, [(8, 8)], limit=_LAST) >= 0).sum())
    return Probe(reached, lambda: propagate(free, [(8, 8)], limit=_LAST), lambda: (_prepare(), _times()))


def _time() -> Probe:
    long = np.ones((1, 20 * _LAST), np.bool_)
    return Probe(19 * _LAST, lambda: propagate(long, [(0, 0)], limit=20 * _LAST), _times)


PROBES: Mapping[str, Callable[[], Probe]] = {
    "wavefront_cell": _wavefront,
    MAP_KERNEL: lambda: Probe(_SIDE * _SIDE, _prepare),
    TIME_KERNEL: _time,
}
"""The probe of each kernel, by the name of its cost in platforms."""
