"""Style ``tiled``: an array of one tile of delay-line nodes, which visits the tiles of a larger map.

The answer is exact (``codesign.planners.wavefront.plan.tiles``). Its costs are the exchange of tiles with the memories
of the columns (phase ``exchange``), and the visits that are repeated when a path winds in and out of a tile.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from codesign.memo import Memo
from codesign.part import Part
from codesign.planners.interface import Problem
from codesign.planners.styles import Line, Memory, Step, beyond_map
from codesign.planners.wavefront.plan.grid import check_cells
from codesign.planners.wavefront.plan.parameters import Paths, PropagateParameters
from codesign.planners.wavefront.plan.plan import (
    known_plan,
    plan_key,
    problem_map,
    sizing_parameters,
    stop_cells,
)
from codesign.planners.wavefront.plan.tiles import Visits, run_tiles
from codesign.planners.wavefront.plan.wave import longest_distance, obstacle_map
from codesign.planners.wavefront.styles import resources, timing
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.resources import Layout
from codesign.planners.wavefront.styles.steps import EXCHANGE, OBSTACLES, PROPAGATE, planned, task_step

_kept = Memo(max_bytes=32 * 2**20)


class Tiled(ArrayStyle):
    """Visits of tiles, the one with the earliest change first."""

    style = "tiled"
    description = "delay-line nodes for one tile, which visits the tiles of a larger map"

    def largest_potential(self, problem: Problem, parameters: PropagateParameters) -> int:
        """The largest that a register meets on the way: potentials of the plan, and of p^d."""
        parameters = sizing_parameters(problem, parameters)
        largest = known_plan(problem, parameters).largest_potential
        visits = self._visits(problem, parameters, _kept)
        if parameters.paths is Paths.SAFE:
            largest = max(largest, longest_distance((problem.rows, problem.columns), parameters.delays))
        return max(largest, visits.largest)

    def notes(self, problem: Problem, parameters: PropagateParameters) -> tuple[str, ...]:
        """A tile that is larger than the map."""
        map_shape = problem.rows, problem.columns
        return beyond_map("propagate.tile", "tile", parameters.tile_shape(*map_shape), map_shape)

    def array_shape(self, problem: Problem, parameters: PropagateParameters) -> tuple[int, int]:
        """Rows and columns of a tile."""
        return parameters.tile_shape(problem.rows, problem.columns)

    def items(self, layout: Layout, problem: Problem, part: Part) -> tuple[Line, ...]:
        """A tile's nodes and cells around, the memories of its columns, a scheduler."""
        return resources.tiled_items(layout, (problem.rows, problem.columns), layout.shape, part)

    def memory(self, problem: Problem, parameters: PropagateParameters) -> Memory:
        """F and the potential of every cell in a column of the tiles; deeper than one block RAM, over several."""
        width = self.bits(problem, parameters) + resources.RAM_FLAG_BITS
        rows, _ = self.array_shape(problem, parameters)
        words = parameters.tile_count(problem.rows, problem.columns) * rows
        # Virtex and Spartan-3 parts have the same shapes: 18 kbit, 1,024 words at 18 bits.
        depth = 512 if width > 18 else 1024 if width > 9 else 2048
        contents = ["potentials"] + ["obstacle potentials"] * (parameters.paths is Paths.SAFE)
        each = -(-words * len(contents) // depth)
        return Memory(width, {name: -(-words // each) for name in contents})

    def wave_steps(
        self, problem: Problem, parameters: PropagateParameters, memo: Memo, detail: bool
    ) -> Iterator[Step]:
        """A visit is an exchange and a wave; p^d first where ways are to be safe."""
        plan = planned(problem, parameters, memo)
        if plan.obstacle_potentials is not None:
            key = ("wavefront obstacle tiles", problem.digest, parameters.delays, parameters.tile)
            visits = memo.get(key, lambda: obstacle_visits(problem, parameters))
            yield from self._visit_steps(problem, parameters, OBSTACLES, visits, detail)
        visits = self._visits(problem, parameters, memo)
        yield from self._visit_steps(problem, parameters, PROPAGATE, visits, detail)

    def _visits(self, problem: Problem, parameters: PropagateParameters, memo: Memo) -> Visits:
        key = ("tiles", *plan_key(problem, parameters), parameters.tile)

        def compute() -> Visits:
            sources = check_cells(problem.goals, problem.free, "goals")
            stops = stop_cells(problem, parameters)
            tile = parameters.tile_shape(problem.rows, problem.columns)
            return run_tiles(problem_map(problem, parameters), sources, stops, tile)[1]

        return memo.get(key, lambda: _kept.get(key, compute))

    def _visit_steps(
        self, problem: Problem, parameters: PropagateParameters, phase: str, visits: Visits, detail: bool
    ) -> Iterator[Step]:
        rows, _ = self.array_shape(problem, parameters)
        exchange = timing.exchange_cycles(rows, parameters.tile_count(problem.rows, problem.columns))
        longest = parameters.delays[-1] + (0 if parameters.penalty is None else parameters.penalty.delay)
        waves = timing.visit_cycles(visits.span, longest)
        if not len(waves):
            return
        if not detail:
            yield Step(EXCHANGE, np.array([exchange * len(waves)], np.int64), ram_addresses=1)
            yield Step(phase, np.array([int(waves.sum())], np.int64))
            return
        for wave in waves.tolist():
            yield task_step(EXCHANGE, exchange, ram_addresses=1)
            yield task_step(phase, wave)


def obstacle_visits(problem: Problem, parameters: PropagateParameters) -> Visits:
    """The visits of the wave from all obstacles; a map without any takes none."""
    wave_map, obstacles = obstacle_map(problem.free, parameters.delays)
    if not len(obstacles):
        return Visits(np.zeros(0, np.int32), np.zeros(0, np.int64), 0)
    tile = parameters.tile_shape(problem.rows, problem.columns)
    return run_tiles(wave_map, obstacles, np.zeros((0, 2), np.int64), tile)[1]
