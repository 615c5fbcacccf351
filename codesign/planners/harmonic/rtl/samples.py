"""Random design points on random maps."""

from __future__ import annotations

from typing import Any

import numpy as np

from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.styles import timing
from codesign.planners.interface import Problem
from codesign.planners.job import Job

LARGEST_ROWS, LARGEST_COLUMNS = 10, 14
DENSITIES = (0.0, 0.1, 0.25, 0.4)
LONGEST_STAGE, MOST_BITS = 5, 14
NEARLY_ALWAYS = 0.9


def random_job(seed: int) -> Job[Problem, RelaxParameters]:
    """A design point, every option at random."""
    random = np.random.default_rng(seed)
    shape = int(random.integers(1, LARGEST_ROWS + 1)), int(random.integers(1, LARGEST_COLUMNS + 1))
    free = random.random(shape) >= random.choice(DENSITIES)
    free.flat[int(random.integers(free.size))] = True
    cells = [(int(row), int(column)) for row, column in np.argwhere(free)]
    # Three goals or less: no free cell has four of them around it.
    goals = tuple(
        cells[index] for index in random.choice(len(cells), min(len(cells), int(random.integers(1, 4))), False)
    )
    parameters = _parameters(random, shape)
    start = cells[int(random.integers(len(cells)))]
    inside = None if random.random() < NEARLY_ALWAYS else frozenset({"relax", "detect"})
    position = float(start[0]), float(start[1])
    return Job(Problem(free, goals, (start,)), parameters, inside=inside, position=position)


def _parameters(random: np.random.Generator, shape: tuple[int, int]) -> RelaxParameters:
    parts = [int(random.integers(1, min(side, 3) + 1)) for side in shape]
    beyond = [int(random.random() > NEARLY_ALWAYS) for _ in range(2)]
    block = -(-shape[0] // parts[0]) + beyond[0], -(-shape[1] // parts[1]) + beyond[1]
    pipeline = int(random.integers(2))
    digit_bits = int(random.choice([1, 1, 2, 4, 8]))
    options: dict[str, Any] = {
        "block": block,
        "iterations": int(random.choice([1, 2, 3, 5, 8, 20])),
        "schedule": _schedule(random, timing.least_precision(*block, pipeline, digit_bits)),
        "termination": str(random.choice(["sound", "published"])),
        "stop": str(random.choice(["first_without_local_maxima", "schedule_end"])),
        "pockets": str(random.choice(["kept", "filled"])),
        "pipeline": pipeline,
        "digit_bits": digit_bits,
    }
    return RelaxParameters(**options)


def _schedule(random: np.random.Generator, least: int) -> tuple[int, ...]:
    """One to three rising precisions from ``least`` on."""
    steps = random.integers(1, LONGEST_STAGE + 1, int(random.integers(1, 4)))
    bits = least + np.cumsum(steps) - 1
    return tuple(int(precision) for precision in bits[bits <= max(least + LONGEST_STAGE, MOST_BITS)])
