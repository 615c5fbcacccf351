"""Speed of Girau et al. (2008), section 5.4: a maze of 9,500 nodes in 4 blocks, p = 255, I = 6, on own mazes.

The paper publishes neither its maze, nor the cost of its software at 255 bits, nor its steps of precision. So this
module runs mazes of several corridor widths, with two goals, three steps and both terminations, and reports the mean
and the range.

- Software: one synchronous relaxation at full precision, stopped when no bit changes. An iteration of 2,376 nodes takes
  100 µs, at any precision (flat) or for each 64-bit limb.
- Circuit: the visits of the run at 150 MHz, changes of block included.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.planners.circuits import phase_cycles
from codesign.planners.harmonic import published
from codesign.planners.harmonic.plan import HarmonicPlan, relax
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop, Termination
from codesign.planners.harmonic.styles import BitSerial, timing
from codesign.planners.harmonic.styles.steps import RELAX
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.reproduction import Progress

ROWS, COLUMNS = 72, 132
BLOCK = published.WHOLE_DESIGN_ROWS, published.WHOLE_DESIGN_COLUMNS
BLOCKS = 4
PRECISION = published.WHOLE_DESIGN_PRECISION
ITERATIONS = 6
WHOLE_MAP_ITERATIONS = 1 << 20

CORRIDORS = (2, 3, 4, 6, 8)
SEEDS = (1, 2)
LOOPS = (0.0, 0.3)
"""The share of opened walls of a perfect maze: a "not too complex" maze may have several paths."""
STEPS = (8, 16, 32)
TERMINATIONS = ("sound", "published")


@dataclass(frozen=True)
class Measurement:
    """One maze under one schedule and termination.

    ``speed_up``: flat software time over circuit time. ``gain``: the circuit with synchronous iterations
    at full precision over the circuit as published. ``iteration_ratio``: block iterations over the iterations of
    the synchronous run, both per block.
    """

    corridor: int
    step: int
    termination: str
    speed_up: float
    gain: float
    iteration_ratio: float


def software_seconds(iterations: int, nodes: int) -> float:
    """Seconds of ``iterations`` over ``nodes`` at the paper's 100 µs for 2,376 nodes."""
    return iterations * nodes / (BLOCK[0] * BLOCK[1]) * published.SOFTWARE_ITERATION_PS / 1e12


def circuit_run(
    free: NDArray[np.bool_], goal: tuple[int, int], schedule: Sequence[int], termination: str
) -> tuple[float, HarmonicPlan]:
    """Seconds of a relaxation at the paper's 150 MHz, and its plan."""
    parameters = RelaxParameters(
        block=BLOCK,
        iterations=ITERATIONS,
        schedule=tuple(schedule),
        termination=Termination(termination),
        stop=Stop.SCHEDULE_END,
    )
    job = Job(Problem(free, (goal,), ()), parameters, detail=False)
    cycles, plan = phase_cycles(BitSerial().work(job))
    return cycles[RELAX] / published.ESTIMATED_CLOCK, plan


def measurements(quick: bool, progress: Progress, seeds: Sequence[int] | None = None) -> tuple[Measurement, ...]:
    """The measurements of all mazes; ``quick``: of one maze. ``seeds``: others than the published ones."""
    runs: list[Measurement] = []
    for corridor in CORRIDORS[2:3] if quick else CORRIDORS:
        progress(f"speed-up of section 5.4: mazes with corridors of {corridor} cells")
        for seed in seeds or (SEEDS[:1] if quick else SEEDS):
            for loops in LOOPS[:1] if quick else LOOPS:
                grid = maps.maze(ROWS, COLUMNS, corridor=corridor, wall=2, seed=seed, loops=loops)
                for goal in ((0, 0),) if quick else ((0, 0), (ROWS // 2, COLUMNS // 2)):
                    runs += _measure(grid, goal, corridor, STEPS[1:2] if quick else STEPS)
    return tuple(runs)


def _measure(
    grid: maps.OccupancyGrid, wanted: tuple[int, int], corridor: int, steps: tuple[int, ...]
) -> Iterator[Measurement]:
    goal = maps.nearest_free(grid.free, wanted)
    assert goal is not None, "a maze has free cells"
    synchronous = relax(
        grid.free,
        [goal],
        block=(ROWS, COLUMNS),
        iterations=WHOLE_MAP_ITERATIONS,
        schedule=[PRECISION],
        record_visits=False,
    ).total_iterations
    software = software_seconds(synchronous, ROWS * COLUMNS)
    full = synchronous * BLOCKS * timing.iteration_cycles(PRECISION) / published.ESTIMATED_CLOCK
    for step in steps:
        schedule = [*range(step - 1, PRECISION, step), PRECISION]
        for termination in TERMINATIONS:
            circuit, result = circuit_run(grid.free, goal, schedule, termination)
            yield Measurement(
                corridor,
                step,
                termination,
                speed_up=software / circuit,
                gain=full / circuit,
                iteration_ratio=result.total_iterations / BLOCKS / synchronous,
            )
