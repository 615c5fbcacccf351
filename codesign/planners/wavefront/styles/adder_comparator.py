"""Style ``adder_comparator``: eight adders and eight comparators a node (Hassoun and Sanghvi 1990).

The paper compares its node with this one (reference [4]). Every node gathers its neighbours' potentials and updates its
own by equation 3, all nodes in every cycle, until none changes. The array cannot stop at a stop node, as a smaller
potential may still come by a path of more steps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from codesign.ground.figures import Figure
from codesign.ground.memo import Memo
from codesign.planners.interface import Problem
from codesign.planners.job import Job, Line
from codesign.planners.styles import Designs, Step, one_step
from codesign.planners.wavefront.plan.grid import check_cells
from codesign.planners.wavefront.plan.parameters import Paths, PropagateParameters, WaveEnd
from codesign.planners.wavefront.plan.plan import plan_key, problem_map
from codesign.planners.wavefront.plan.wave import longest_distance, obstacle_map
from codesign.planners.wavefront.styles import resources, timing
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.designs import DESIGNS
from codesign.planners.wavefront.styles.steps import OBSTACLES, PROPAGATE, read_out_steps, updates

_waves = Memo(max_bytes=2**20)


class AdderComparator(ArrayStyle):
    """An update a cycle: as many as the longest shortest path has steps, and one before and after them."""

    style = "adder_comparator"
    description = "a node with adders and comparators for every cell (Hassoun and Sanghvi)"

    def settled(self, parameters: PropagateParameters) -> PropagateParameters:
        """With ``stop: whole_map``: the potential of a start is final only when no potential changes any more.

        Nodes are not shared.
        """
        return parameters.model_copy(update={"stop": WaveEnd.WHOLE_MAP, "element_cells": 1})

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """One: it cannot wait for a start."""
        return DESIGNS[-1:]

    def notes(self, job: Job[Problem, PropagateParameters]) -> tuple[str, ...]:
        """A note where the parameters ask for a stop at the starts, which this style cannot do."""
        if job.parameters.stop is WaveEnd.WHOLE_MAP or not job.problem.starts:
            return ()
        return (
            f"propagate.stop: style {self.style} runs as with whole_map, as it cannot stop at a start: a smaller"
            " potential may still come by a path of more steps",
        )

    def largest_potential(self, job: Job[Problem, PropagateParameters]) -> int:
        """The largest potential of the whole map: nothing stops the updates before. Of a replan both maps count."""
        maps = dict.fromkeys((job.problem, job.problem.changed))
        largest = max(self._whole(replace(job, problem=each))[0] for each in maps)
        # One register for both: p^d of safe paths is computed by the same adders.
        if job.parameters.paths is Paths.SAFE:
            largest = max(largest, longest_distance(job.problem.shape, job.parameters.delays))
        return largest

    def items(self, job: Job[Problem, PropagateParameters]) -> tuple[Line, ...]:
        """Nodes, read-out, tracker and control, with the tree that detects a changed potential."""
        return resources.array_items(replace(self.layout(job), adders=True), job.chip)

    def wave_steps(self, job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
        """Updates until no potential changes; for safe paths, p^d first."""
        problem, parameters = job.problem, job.parameters
        if parameters.paths is Paths.SAFE:
            key = ("wavefront obstacle updates", problem.map_digest, parameters.delays)
            count = job.shared(key, lambda: obstacle_updates(problem, parameters))
            yield one_step(OBSTACLES, timing.adder_cycles(count))
            yield from read_out_steps(job)
        yield one_step(PROPAGATE, timing.adder_cycles(self._whole(job)[1]))
        yield from read_out_steps(job)

    def clock_limit(self, job: Job[Problem, PropagateParameters]) -> Figure:
        """The fastest clock: five operations over R bits are chained in a cycle."""
        return timing.clock_limit(replace(self.outline(job), adders=True, bits=self.bits(job)), job.chip)

    def _whole(self, job: Job[Problem, PropagateParameters]) -> tuple[int, int]:
        problem, parameters = job.problem, job.parameters
        key = ("whole", *plan_key(problem, parameters, ()))

        def compute() -> tuple[int, int]:
            sources = check_cells(problem.goals, problem.free, "goals")
            return updates(problem_map(problem, parameters), sources)

        return _waves.get(key, compute)


def obstacle_updates(problem: Problem, parameters: PropagateParameters) -> int:
    """Updates until p^d is final; 0 on a map without obstacles."""
    wave_map, obstacles = obstacle_map(problem.free, parameters.delays)
    return updates(wave_map, obstacles)[1] if len(obstacles) else 0
