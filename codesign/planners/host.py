"""Styles on a processor: base classes for whole planners and for tasks placed by themselves.

The platform declares the clock and the power of a processor, so no law gives them. Software takes no resource of a
part.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Generator
from typing import Any

import numpy as np

from codesign.ground.figures import Figure, Status
from codesign.ground.records import TaskRecord
from codesign.planners.job import Demand, Job, Lever, Line
from codesign.planners.styles import Architecture, Step, TaskStyle


class HostStyle(Architecture):
    """A planner in software. A subclass defines ``work``, in units of ``kernel``, and ``bytes_a_cell``."""

    style: str = "software"
    component_type = "processor"

    def bytes_a_cell(self, _job: Job[Any, Any], /) -> Figure | None:
        """Bytes that a compiled program holds for each cell of the map; None: not known, so none is held to a limit.

        That is not what this simulation takes (``Planner.memory``).
        """
        return None

    def demand(self, job: Job[Any, Any]) -> Demand:
        """No resource of a part; the arrays of the program, where the platform declares the memory of the processor."""
        figure = self.bytes_a_cell(job)
        if figure is None or job.memory is None:
            return Demand(items=())
        side = math.isqrt(int(job.memory.value / figure.value))
        cells, (low, high) = job.problem.free.size, figure.interval
        source = f"{figure.value:g} bytes a cell, {low:g} to {high:g}: {figure.source}"
        arrays = Line.bound(
            name="memory of the processor",
            demand=Figure(cells * figure.value, "bytes", figure.status, source, cells * low, cells * high),
            limit=job.memory,
            unit="bytes",
            status=figure.status,
            source=source,
            levers=(Lever("problem.map", f"at most about {side} × {side} cells; crop or downsample it"),),
        )
        return Demand(items=(), bounds=(arrays,))


def assumed_bytes(value: float, source: str, low: float, high: float) -> Figure:
    """Bytes a cell that nobody measured: ``low`` of a packed layout, ``high`` of a generous one."""
    return Figure(value, "B", Status.ASSUMED, source, low, high)


class HostTask(TaskStyle):
    """One task in software: one step in units of ``kernel``."""

    style: str = "software"
    component_type = "processor"

    @abstractmethod
    def outcome(self, job: Job[Any, Any], /) -> tuple[int, Any]:
        """The units of the kernel that one execution takes, at least 1, and the result of the task."""

    def steps(self, job: Job[Any, Any]) -> Generator[Step, None, Any]:
        """One step, booked under the task's name."""
        units, result = self.outcome(job)
        yield one_step(self.task, units)
        return result


def task_record(task: str, cycles: int) -> Callable[[int, int, str], TaskRecord]:
    """The record of a step that is a task by itself, for ``Step.record``."""
    return lambda begin, end, source: TaskRecord(begin, source, task, end, cycles)


def map_read(phase: str, problem: Any, kernel: str, more: int = 0) -> Step:
    """The reading of a map, which every program pays for: a unit of ``kernel`` for each cell, wherever the goals are.

    ``more``: units that the same pass takes besides.
    """
    return one_step(phase, problem.free.size + more, kernel=kernel)


def one_step(task: str, cycles: int, ram_addresses: int = 0, kernel: str = "") -> Step:
    """A step of one unit, recorded as a ``TaskRecord`` of ``task``; ``kernel`` as of ``Step``."""
    return Step(task, np.array([cycles], np.int64), task_record(task, cycles), ram_addresses, kernel)
