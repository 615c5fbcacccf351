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
from functools import partial
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.figures import Status
from codesign.planners.circuits import phase_cycles
from codesign.planners.harmonic import published
from codesign.planners.harmonic.plan import HarmonicPlan, relax
from codesign.planners.harmonic.plan.fixed_point import limbs_needed
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop, Termination
from codesign.planners.harmonic.styles import BitSerial, timing
from codesign.planners.harmonic.styles.steps import RELAX
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.reproduction import Finding, Progress, Row, Use, row

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
    at full precision over the circuit as published. ``iteration_ratio``: block iterations over those of
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


def measurements(
    quick: bool, progress: Progress, seeds: Sequence[int] | None = None
) -> tuple[Measurement, ...]:
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


def speed_rows(runs: tuple[Measurement, ...]) -> tuple[Row, ...]:
    """The speed-ups of section 5.4 and the gain of section 4.5.2."""
    flat = [run.speed_up for run in runs]
    words = limbs_needed(PRECISION)
    gains = [run.gain for run in runs]
    source = f"{len(runs)} runs on own mazes of {ROWS} × {COLUMNS}, corridors of {corridors(runs)} cells"
    text = partial(row, "Section 5.4", status=Status.ASSUMED, source=source, use=Use.HELD_OUT)
    return (
        text(
            "speed-up, 9,500-node maze, flat software",
            270,
            fmean(flat),
            note=f"mean; {min(flat):.0f} to {max(flat):.0f}",
        ),
        text(
            "speed-up, 9,500-node maze, software a limb",
            270,
            words * fmean(flat),
            note=f"mean; {words * min(flat):.0f} to {words * max(flat):.0f}; {words} limbs",
        ),
        text('final speed-up, "up to 400x", flat software', 400, max(flat), note="the largest of the runs"),
        text(
            'final speed-up, "up to 400x", software a limb',
            400,
            words * max(flat),
            note="the largest of the runs",
        ),
        row(
            "Section 4.5.2",
            "gain of blocks and rising precision",
            "2 to 4",
            fmean(gains),
            status=Status.ASSUMED,
            source=source,
            use=Use.HELD_OUT,
            note=f"mean; {min(gains):.1f} to {max(gains):.1f}",
        ),
    )


def corridors(runs: tuple[Measurement, ...]) -> str:
    """The corridor widths of the runs, as a list in words."""
    return ", ".join(str(width) for width in sorted({run.corridor for run in runs}))


def speed_findings(runs: tuple[Measurement, ...]) -> tuple[Finding, ...]:
    """Findings on the speed-ups."""
    flat = [run.speed_up for run in runs]
    words = limbs_needed(PRECISION)
    low, high = words * min(flat), words * max(flat)
    ratios = [run.iteration_ratio for run in runs]
    gains = [run.gain for run in runs]
    by_step = {
        f"mean with steps of {step} bits": f"{fmean(run.speed_up for run in runs if run.step == step):.0f}"
        for step in sorted({run.step for run in runs})
    }
    return (
        Finding(
            "Software of flat cost reaches a speed-up of 270 on none of our mazes.",
            {"least": f"{min(flat):.0f}", "most": f"{max(flat):.0f}", **by_step},
            max(flat) < 270,
        ),
        Finding(
            "With software that pays for each 64-bit limb, 270 lies within the range.",
            {"least": f"{low:.0f}", "most": f"{high:.0f}"},
            low <= 270 <= high,
        ),
        Finding(
            "The gain from blocks and rising precision stays below the published 2 to 4.",
            {"least": f"{min(gains):.1f}", "most": f"{max(gains):.1f}"},
            max(gains) < 2,
        ),
        Finding(
            "Rising precision gains by shorter iterations more than by fewer.",
            {
                "iterations, least ratio": f"{min(ratios):.2f}",
                "iterations, largest ratio": f"{max(ratios):.2f}",
            },
            fmean(1 / ratio for ratio in ratios) < fmean(gains),
        ),
    )
