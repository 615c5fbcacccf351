"""The search as steps of a clock, for all styles of breadth-first search."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from codesign.planners.breadth_first.plan.reference import NEIGHBOURS, UNKNOWN
from codesign.planners.breadth_first.plan.search import BreadthFirstPlan
from codesign.planners.external_memory import Traffic
from codesign.planners.styles import MemoryStep, Step, task_record

INIT, SEARCH, PATH = "init", "bf", "path"
"""The phases of the cycles, named as the states of the paper; no cycle counts in Standby."""

TRACK = "track"
"""The task of phase ``path``."""

BATCH = 1 << 16
"""The most units of a step, so that memory does not hold a large map twice."""


def discoverers(search: BreadthFirstPlan) -> NDArray[np.int64]:
    """Int64, one entry a pushed cell but the start: the rank, from 0, of the pop that pushed it."""
    columns = search.directions.shape[1]
    offsets = np.array([down * columns + right for down, right in NEIGHBOURS], np.int64)
    discovered = search.pushed[1:].astype(np.int64)
    sides = search.directions.ravel()[discovered]
    assert UNKNOWN not in sides, "every pushed cell but the start was discovered by another"
    rank = np.zeros(search.directions.size, np.int64)
    rank[search.pushed] = np.arange(search.pushed_cells)
    ranks: NDArray[np.int64] = rank[discovered + offsets[sides]]
    return ranks


def pushes_of_each_pop(search: BreadthFirstPlan) -> NDArray[np.int64]:
    """Int64, one entry a popped cell: the number of cells that its expansion pushed."""
    return np.bincount(discoverers(search), minlength=search.popped_cells).astype(np.int64)


def steps(
    phase: str, cycles: NDArray[np.int64], ram_addresses: int = 0, traffic: Traffic | None = None
) -> Iterator[Step]:
    """Steps of ``phase`` with at most ``BATCH`` units each, each recorded as a task.

    ``traffic``: of each unit with an external memory; its cycles are among ``cycles``.
    """
    for first in range(0, len(cycles), BATCH):
        units = cycles[first : first + BATCH]
        record = task_record(phase, int(units.sum()))
        if traffic is None:
            yield Step(phase, units, record, ram_addresses)
        else:
            yield MemoryStep(phase, units, record, ram_addresses, traffic=traffic.part(first, first + BATCH))


def step(phase: str, cycles: int, ram_addresses: int = 0, traffic: Traffic | None = None) -> Step:
    """A phase in one step of one unit; ``traffic`` is summed."""
    (only,) = steps(phase, np.array([cycles], np.int64), ram_addresses, traffic.total if traffic else None)
    return only


def expansions(search: BreadthFirstPlan) -> int:
    """The number of expanded cells: all popped cells but the goal that ended the search."""
    return search.popped_cells - (search.reached and not search.everywhere)
