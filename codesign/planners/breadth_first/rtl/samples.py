"""Random design points of the state machine."""

from __future__ import annotations

import numpy as np

from codesign.ground.models import Task
from codesign.planners.breadth_first.plan.parameters import Address, MicroArchitecture, SearchParameters, VgaController
from codesign.planners.breadth_first.plan.planner import searched
from codesign.planners.interface import Problem
from codesign.planners.job import Job

MOST_SIDE = 20
MOST_GOALS = 3


def random_job(seed: int) -> Job[Problem, SearchParameters]:
    """A map of 1 × 2 to 20 × 20 cells with up to half of them obstacles, 1 to 3 goals, and every option at random.

    In one job of eight the task is ``field``; in one of three the queue is as short as the search allows, and in one
    of nine even shorter, so that it overflows.
    """
    random = np.random.default_rng([seed, 2008])
    shape = int(random.integers(1, MOST_SIDE + 1)), int(random.integers(2, MOST_SIDE + 1))
    free = random.random(shape) >= random.uniform(0.0, 0.5)
    count = min(1 + int(random.integers(1, MOST_GOALS + 1)), free.size)
    cells = random.choice(free.size, count, replace=False)
    free.ravel()[cells] = True
    start, *goals = ((int(cell) // shape[1], int(cell) % shape[1]) for cell in cells)
    field = random.random() < 1 / 8
    problem = Problem(free, tuple(goals[:1] if field else goals), (start,), task=Task.FIELD if field else Task.PATH)
    micro_architecture = MicroArchitecture(random.choice(list(MicroArchitecture)))
    displays = set(VgaController)
    if micro_architecture is MicroArchitecture.PIPELINED:
        displays.remove(VgaController.SHARED)
    parameters = SearchParameters(
        micro_architecture=micro_architecture,
        address=Address(random.choice(list(Address))),
        display=VgaController(random.choice(sorted(displays))),
    )
    job = Job(problem, parameters)
    if random.random() < 1 / 3:
        depth = searched(job).queue_depth - int(random.random() < 1 / 3)
        job = Job(problem, parameters.model_copy(update={"queue_words": max(1, depth)}))
    return job
