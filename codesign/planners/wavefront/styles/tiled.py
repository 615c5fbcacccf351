"""Style ``tiled``: an array of one tile of delay-line nodes, which visits the tiles of a larger map.

The answer is exact (``codesign.planners.wavefront.plan.tiles``). Its costs are the exchange of tiles with the memories
of the columns (phase ``exchange``), and repeated visits where a path winds in and out of a tile.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from codesign.ground.figures import Figure
from codesign.ground.memo import Memo
from codesign.ground.models import Task
from codesign.planners.interface import Cell, Problem
from codesign.planners.job import Job, Line, short_resources
from codesign.planners.styles import Family, Memory, Step, beyond_map, one_step
from codesign.planners.wavefront.plan.bounds import VisitBounds
from codesign.planners.wavefront.plan.grid import check_cells
from codesign.planners.wavefront.plan.parameters import Paths, PropagateParameters, ReadOut
from codesign.planners.wavefront.plan.plan import (
    cached_plan,
    plan_key,
    problem_map,
    sizing_plan,
    sizing_stops,
    stops_of,
)
from codesign.planners.wavefront.plan.tiles import NEVER, NO_LIMIT, NONE_SURE, Visits, run_tiles
from codesign.planners.wavefront.plan.wave import longest_distance, obstacle_map, register_bits
from codesign.planners.wavefront.styles import timing
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.designs import DESIGNS
from codesign.planners.wavefront.styles.tile import TileLayout, tiled_items
from codesign.planners.wavefront.styles.tile_families import Frontier, TileCycles, TileSpace, fixed_cycles
from codesign.planners.wavefront.styles.timing import EXCHANGE, OBSTACLES, PROPAGATE, TRACK

_kept = Memo(max_bytes=32 * 2**20)
_bounds = Memo(max_bytes=64 * 2**20)


class Tiled(ArrayStyle):
    """Visits of tiles, the one with the earliest change first."""

    style = "tiled"
    description = "delay-line nodes for one tile, which visits the tiles of a larger map"

    def settled(self, parameters: PropagateParameters) -> PropagateParameters:
        """Addressed, and without shared nodes: the potentials are in the memories of the columns."""
        return parameters.model_copy(update={"read_out": ReadOut.ADDRESSED, "element_cells": 1})

    def largest_potential(self, job: Job[Problem, PropagateParameters]) -> int:
        """The largest that a register ever holds: potentials of the plan and of the visits, and p^d."""
        problem, parameters = job.problem, job.parameters
        largest = sizing_plan(problem, parameters).largest_potential
        for each in dict.fromkeys((problem, problem.changed)):
            sized = replace(job, problem=each)
            largest = max(largest, self._visits(sized, sizing_stops(each, parameters)).largest)
        if parameters.paths is Paths.SAFE:
            longest = longest_distance(problem.shape, parameters.delays)
            largest = max(largest, longest, self._obstacle_visits(job).largest)
        return largest

    def notes(self, job: Job[Problem, PropagateParameters]) -> tuple[str, ...]:
        """A note where a tile is larger than the map."""
        problem = job.problem
        map_shape = problem.shape
        return beyond_map("propagate.tile", "tile", job.parameters.tile_shape(*map_shape), map_shape)

    def families(self, job: Job[Problem, Any]) -> Iterator[Family]:
        """All tiles that are no larger than the map, without cut corners; the wave ends at the starts, or by itself."""
        space = self._space(job)
        yield from space.promising()
        yield from space.families()

    def _space(self, job: Job[Problem, Any]) -> TileSpace:
        problem = job.problem
        asked = bool(problem.starts) and problem.task is not Task.FIELD
        designs = [design for chain in DESIGNS[0 if asked else 1 :] for design in chain]
        base, least = (PropagateParameters.model_validate(dict(design)) for design in (designs[0], designs[-1]))
        sized = register_bits(sizing_plan(problem, base).largest_potential)
        stops = sizing_stops(problem, base)
        last = cached_plan(problem, base, stops).stop_potential
        until = NEVER if last is None else last

        def cycles() -> TileCycles:
            potentials = cached_plan(problem, base, ()).potentials
            return TileCycles(problem.shape, VisitBounds(potentials, until))

        def of(tile: tuple[int, int]) -> Job[Problem, PropagateParameters]:
            return replace(job, parameters=least.model_copy(update={"tile": tile, "register_bits": sized}))

        def may_fit(tile: tuple[int, int]) -> bool:
            # A map of this one tile has the shortest words of all that are counted in tiles.
            return not short_resources(tiled_items(self.layout(of(tile)), tile, tile, job.chip), job.chip)

        def run(tile: tuple[int, int], stop: str, most_cycles: int) -> int:
            end = until if stop == base.stop else NEVER
            visits = visits_until(problem, of(tile).parameters, end, most_cycles, bounded.visits)
            return visits_cycles(visits, fixed_cycles(problem.shape, tile)[1])

        bounded = _bounds.get((*plan_key(problem, base, stops), until), cycles)
        return TileSpace(
            bounded,
            designs,
            sized,
            timing.track_cycles(1) if job.does(TRACK) else 0,
            lambda tile: not short_resources(self.items(of(tile)), job.chip),
            Frontier(may_fit),
            run,
        )

    def array_shape(self, job: Job[Problem, PropagateParameters]) -> tuple[int, int]:
        """Rows and columns of a tile."""
        return job.parameters.tile_shape(*job.problem.shape)

    def items(self, job: Job[Problem, PropagateParameters]) -> tuple[Line, ...]:
        """A tile's nodes and cells around, the memories of its columns, a scheduler."""
        layout = self.layout(job)
        return tiled_items(layout, job.problem.shape, layout.shape, job.chip)

    def clock_limit(self, job: Job[Problem, PropagateParameters]) -> Figure:
        """The fastest clock of the array of a tile, whose tracker reads the memories of its columns, Hz."""
        return timing.clock_limit(self.outline(job), job.chip, tiled=True)

    def memory(self, job: Job[Problem, PropagateParameters]) -> Memory:
        """F and the potential of every cell in a column of the tiles; deeper than one block RAM, over several.

        Safe paths have as many for p^d, driven alike.
        """
        layout = TileLayout(self.layout(job), job.problem.shape)
        # Virtex and Spartan-3 parts have the same shapes: 18 kbit, 1,024 words at 18 bits.
        width = layout.memory_bits
        depth = 512 if width > 18 else 1024 if width > 9 else 2048
        return Memory(width, {"potentials": -(-layout.words // -(-layout.words // depth))})

    def load_cycles(self, job: Job[Problem, PropagateParameters]) -> int:
        """Cycles to load the map into the memories of the columns."""
        return timing.tile_load_cycles(self.array_shape(job), job.parameters.tile_count(*job.problem.shape))

    def wave_steps(self, job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
        """A visit is an exchange and a wave; for safe paths, p^d first."""
        for phase, visits in self.passes(job):
            yield from self._visit_steps(job, phase, visits)

    def passes(self, job: Job[Problem, PropagateParameters]) -> Iterator[tuple[str, Visits]]:
        """The phases of waves, and their visits."""
        problem, parameters = job.problem, job.parameters
        if parameters.paths is Paths.SAFE:
            yield OBSTACLES, self._obstacle_visits(job)
        yield PROPAGATE, self._visits(job, stops_of(problem, parameters))

    def _obstacle_visits(self, job: Job[Problem, PropagateParameters]) -> Visits:
        problem, parameters = job.problem, job.parameters
        key = ("wavefront obstacle tiles", problem.map_digest, parameters.delays, parameters.tile)
        return _kept.get(key, lambda: obstacle_visits(problem, parameters))

    def _visits(self, job: Job[Problem, PropagateParameters], stops: tuple[Cell, ...]) -> Visits:
        problem, parameters = job.problem, job.parameters
        last = cached_plan(problem, parameters, stops).stop_potential
        return visits_until(problem, parameters, NEVER if last is None else last)

    def _visit_steps(self, job: Job[Problem, PropagateParameters], phase: str, visits: Visits) -> Iterator[Step]:
        problem, parameters = job.problem, job.parameters
        tile, tiles = self.array_shape(job), parameters.tile_count(*problem.shape)
        scan, exchange = timing.scan_cycles(tile[1], tiles), timing.exchange_cycles(tile, tiles)
        waves = timing.visit_cycles(visits.span)
        yield one_step(EXCHANGE, scan, ram_addresses=1)
        if not len(waves):
            return
        if not job.detail:
            yield Step(EXCHANGE, np.array([exchange * len(waves)], np.int64), ram_addresses=1)
            yield Step(phase, np.array([int(waves.sum())], np.int64))
            return
        for wave in waves.tolist():
            yield one_step(EXCHANGE, exchange, ram_addresses=1)
            yield one_step(phase, wave)


def visits_until(
    problem: Problem,
    parameters: PropagateParameters,
    until: int,
    most_cycles: int = NO_LIMIT,
    bounds: VisitBounds | None = None,
) -> Visits:
    """The visits up to the potential ``until`` of a stop, kept in this process: near stops take the first of them.

    Beyond ``most_cycles``, exchanges included, they are given up, and ``Visits.until`` is smaller. ``bounds``: of the
    visits of this map, to give up sooner.
    """
    key = ("tiles", *plan_key(problem, parameters, ()), parameters.tile)
    kept: Visits | None = _kept.held(key)
    tile, tiles = parameters.tile_shape(*problem.shape), parameters.tile_count(*problem.shape)
    exchange = timing.exchange_cycles(tile, tiles)
    if kept is None or (kept.until < until and visits_cycles(kept, exchange) <= most_cycles):
        sources = check_cells(problem.goals, problem.free, "goals")
        sure = NONE_SURE if bounds is None else bounds.sure(tile)
        kept = run_tiles(problem_map(problem, parameters), sources, tile, until, exchange, most_cycles, sure)[1]
        _kept.keep(key, kept)
    return kept.before(until) if until <= kept.until else kept


def visits_cycles(visits: Visits, exchange: int) -> int:
    """Cycles of visits, with ``exchange`` each beside the wave, and at least those of the ones that were given up."""
    return exchange * len(visits.span) + int(timing.visit_cycles(visits.span).sum()) + visits.left


def obstacle_visits(problem: Problem, parameters: PropagateParameters) -> Visits:
    """The visits of the wave from all obstacles; a map without any takes none."""
    wave_map, obstacles = obstacle_map(problem.free, parameters.delays)
    if not len(obstacles):
        none = np.zeros(0, np.int64)
        return Visits(none, none, none, none)
    return run_tiles(wave_map, obstacles, parameters.tile_shape(*problem.shape))[1]
