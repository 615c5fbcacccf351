"""What the model says of a run: values from the plan, cycles from the laws of the style."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from codesign.planners.circuits import Events, Expected, phase_cycles
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.wavefront.plan.parameters import Course, PropagateParameters
from codesign.planners.wavefront.plan.plan import WavefrontPlan
from codesign.planners.wavefront.rtl.layout import Words, cell_flags
from codesign.planners.wavefront.styles import AdderComparator, Tiled, timing
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.steps import EXCHANGE, LOAD, OBSTACLES, PROPAGATE, READ_OUT, TRACK

PHASES = (LOAD, OBSTACLES, PROPAGATE, READ_OUT, TRACK)
TILED_PHASES = (LOAD, OBSTACLES, PROPAGATE, EXCHANGE, TRACK)
KINDS = ("potential", "obstacle_potential", "step", "visit")
POTENTIAL, OBSTACLE_POTENTIAL, STEP, VISIT = range(4)

Part = tuple[NDArray[np.int64], int, NDArray[np.uint64]]
"""Events of one kind: cycles, kind, values."""


def expected_run(style: ArrayStyle, job: Job[Problem, PropagateParameters], words: Words) -> Expected:
    """The events of a run of ``style`` with the settled parameters of ``job``."""
    cycles, plan = phase_cycles(style.work(job))
    parts = [_visit_events(style, job, cycles[LOAD])] if isinstance(style, Tiled) else []
    parts += _parts(style, job, words, cycles, plan)
    events = Events(
        np.concatenate([part[0] for part in parts]),
        np.concatenate([np.full(len(part[0]), part[1], np.uint8) for part in parts]),
        np.concatenate([part[2] for part in parts]),
    )
    return Expected(events, cycles)


def _parts(
    style: ArrayStyle, job: Job[Problem, PropagateParameters], words: Words, cycles: dict[str, int], plan: WavefrontPlan
) -> Iterator[Part]:
    """The events in the order of their cycles: a chain reports before the path is tracked, an array after it."""
    flags = cell_flags(job.problem, job.parameters)
    potentials = np.where(plan.potentials >= 0, plan.potentials, infinity(style, plan, words)).astype(np.int64)
    distances = None
    if plan.obstacle_potentials is not None:
        distances = plan.obstacle_potentials.astype(np.int64)
        if isinstance(style, AdderComparator | Tiled) and job.problem.free.all():
            # No source at all: these leave their own infinity where a delay line leaves the last count.
            distances[...] = (1 << (words.obstacle_bits or words.bits)) - 1
    cells = np.arange(job.problem.free.size, dtype=np.int64)
    begin = cycles[LOAD] + cycles.get(OBSTACLES, 0)
    if words.chain and distances is not None:
        yield begin + cells, OBSTACLE_POTENTIAL, words.packed(distances, None, flags)
        begin += timing.read_out_cycles(len(cells))
    begin += cycles.get(PROPAGATE, 0) + cycles.get(EXCHANGE, 0)
    shown = words.packed(potentials, distances, flags)
    if words.chain:
        yield begin + cells, POTENTIAL, shown
        begin += timing.read_out_cycles(len(cells))
    if job.does(TRACK):
        yield _steps(job, words, plan, begin)
        begin += cycles[TRACK]
    if not words.chain:
        yield begin + timing.READ_LATENCY + cells, POTENTIAL, shown


def _visit_events(style: Tiled, job: Job[Problem, PropagateParameters], begin: int) -> Part:
    """The tiles in the order of their visits, each in the last cycle of the scan that chooses it."""
    tile, tiles = style.array_shape(job), job.parameters.tile_count(*job.problem.shape)
    exchange = timing.exchange_cycles(tile, tiles)
    chosen, cycles = [], []
    for _, visits in style.passes(job):
        begin += timing.scan_cycles(tile[1], tiles)
        ends = begin + np.cumsum(exchange + timing.visit_cycles(visits.span))
        cycles.append(np.concatenate([[begin], ends[:-1]])[: len(ends)] - 1)
        chosen.append(visits.tile.astype(np.uint64))
        begin = int(ends[-1]) if len(ends) else begin
    return np.concatenate(cycles).astype(np.int64), VISIT, np.concatenate(chosen)


def infinity(style: ArrayStyle, plan: WavefrontPlan, words: Words) -> int:
    """The register of a cell that no wave reached: the last count, or all bits of a register or a memory's word."""
    if isinstance(style, AdderComparator | Tiled):
        return (1 << words.bits) - 1
    return plan.largest_potential + 1


def _steps(job: Job[Problem, PropagateParameters], words: Words, plan: WavefrontPlan, begin: int) -> Part:
    """The cells of the path behind the start; each is chosen in the last cycle of its step."""
    start = job.problem.starts[0] if job.problem.starts else (0, 0)
    path = np.zeros((0, 2), np.int64)
    if plan.potentials[start] >= 0:
        most = job.parameters.steps if job.parameters.course is Course.LOCAL else None
        path = plan.tracker.follow(start, most)[1:]
    after = np.array([timing.track_cycles(step + 1) for step in range(len(path))], np.int64)
    values = (path[:, 0] << words.column_bits | path[:, 1]).astype(np.uint64)
    return begin + after - 1, STEP, values
