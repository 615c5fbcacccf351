"""Phases, and the planner's answers that styles share."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.planners.interface import Cell, Problem
from codesign.planners.job import Job
from codesign.planners.styles import Step, one_step
from codesign.planners.wavefront.plan.grid import WaveMap
from codesign.planners.wavefront.plan.parameters import Course, PropagateParameters, ReadOut
from codesign.planners.wavefront.plan.plan import WavefrontPlan, cached_plan, plan_key
from codesign.planners.wavefront.plan.wave import run_wave
from codesign.planners.wavefront.styles import timing

kernels = late("codesign.planners.wavefront.plan.kernels")

LOAD, OBSTACLES, PROPAGATE, EXCHANGE = "load", "propagate_obstacles", "propagate", "exchange"
READ_OUT, TRACK = "read_out", "track"
"""The phases to which cycles are booked."""


def planned(job: Job[Problem, PropagateParameters]) -> WavefrontPlan:
    """The plan, once for all design points that have it in common."""
    return job.shared(plan_key(job.problem, job.parameters), lambda: cached_plan(job.problem, job.parameters))


def read_out_steps(job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
    """The shift of a chain after a wave; an addressed array takes none."""
    if job.parameters.read_out is ReadOut.CHAIN:
        yield one_step(READ_OUT, timing.read_out_cycles(job.problem.free.size))


def tracked_steps(job: Job[Problem, PropagateParameters], plan: WavefrontPlan, start: Cell | None = None) -> int:
    """Steps that are tracked before a decision: at least 1, even from a start on the goal.

    ``start``: the first cell of the path; by default the first start of the problem.
    """
    if start is None:
        start = job.problem.starts[0] if job.problem.starts else None
    if start is None or plan.potentials[start] < 0:
        return 1
    most = job.parameters.steps if job.parameters.course is Course.LOCAL else None
    return max(1, len(plan.tracker.follow(start, most)) - 1)


def updates(wave_map: WaveMap, sources: NDArray[np.int64]) -> tuple[int, int]:
    """The largest potential of a wave without a stop, and the parallel updates of equation 3 until it is final."""
    potentials, order = run_wave(wave_map, sources, np.zeros((0, 2), np.int64))
    unreached = np.where(wave_map.free, np.int32(kernels.OPEN), np.int32(kernels.CLOSED))
    flat = wave_map.pad(np.where(potentials >= 0, potentials, unreached).astype(np.int32), kernels.CLOSED)
    return int(potentials.max()), int(kernels.rounds(flat, order, *wave_map.arrays))
