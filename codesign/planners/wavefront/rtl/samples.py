"""Random design points on random maps."""

from __future__ import annotations

from typing import Any

import numpy as np

from codesign.ground.models import Task
from codesign.planners.interface import Cell, Problem
from codesign.planners.job import Job
from codesign.planners.wavefront.plan.parameters import PropagateParameters, WaveEnd
from codesign.planners.wavefront.plan.planner import PLANNER

LARGEST_SIDE = {"delay_line": 12, "adder_comparator": 7, "tiled": 14}
DENSITIES = (0.0, 0.1, 0.25, 0.4)


def random_job(seed: int, style: str) -> Job[Problem, PropagateParameters]:
    """A design point of a style, every option at random, on a map that the planner accepts."""
    rng = np.random.default_rng(seed)
    problem = _problem(rng, LARGEST_SIDE[style])
    parameters = PropagateParameters(**_options(rng, style))
    inside = frozenset({"propagate"}) if rng.random() < 0.2 else None
    job = Job(problem, parameters, inside=inside)
    if PLANNER.check(job) is not None:
        # The start cannot be reached: the wave runs to its own end.
        job = Job(problem, parameters.model_copy(update={"stop": WaveEnd.WHOLE_MAP}), inside=inside)
    return job


def _problem(rng: np.random.Generator, largest_side: int) -> Problem:
    """A random map with one goal or two, and a start."""
    shape = tuple(int(side) for side in rng.integers(1, largest_side + 1, 2))
    free = rng.random(shape) >= rng.choice(DENSITIES)
    free.flat[int(rng.integers(free.size))] = True
    cells = [(int(row), int(column)) for row, column in np.argwhere(free)]

    def chosen(count: int) -> tuple[Cell, ...]:
        return tuple(cells[index] for index in rng.integers(len(cells), size=count))

    goals = tuple(dict.fromkeys(chosen(int(rng.integers(1, 3)))))
    starts = chosen(1)
    task = Task.FIELD if rng.random() < 0.2 else Task.PATH
    return Problem(free, goals, starts, task=task)


def _options(rng: np.random.Generator, style: str) -> dict[str, Any]:
    """Every parameter of the planning task, raw."""
    straight = int(rng.integers(1, 5))
    delays = (2, 3) if rng.random() < 0.5 else (straight, straight + int(rng.integers(0, 4)))
    options: dict[str, Any] = {
        "stop": str(rng.choice(["starts", "whole_map"])),
        "paths": str(rng.choice(["shortest", "safe"])),
        "course": str(rng.choice(["local", "complete"])),
        "steps": int(rng.integers(1, 6)),
        "corner_cutting": bool(rng.integers(2)),
        "delays": delays,
        "read_out": str(rng.choice(["addressed", "chain"])),
    }
    if rng.random() < 0.4:
        options["penalty"] = {"distance": int(rng.integers(1, 6)), "delay": int(rng.integers(1, 5))}
    if style == "delay_line" and rng.random() < 0.4:
        options["element_cells"] = int(rng.choice([2, 4, 8, 16]))
        options["read_out"] = "addressed"
    if style == "tiled" and rng.random() < 0.9:
        options["tile"] = tuple(int(side) for side in rng.integers(1, 7, 2))
    return options
