"""Styles on a processor: base classes for whole planners and for tasks placed by themselves.

The platform declares the clock and the power of a processor, so no law gives them. Software takes no resource of a
part.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Generator
from dataclasses import replace
from typing import Any

import numpy as np

from codesign.planners.job import Job
from codesign.planners.styles import Architecture, Step, TaskStyle
from codesign.records import TaskRecord


class HostStyle(Architecture):
    """A planner in software. A subclass defines ``work``, in units of ``kernel``."""

    style: str = "software"
    component_type = "processor"


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


def side_step(step: Step, kernel: str, instead: int = 0) -> Step:
    """A step in units of a kernel that a platform may leave out: then it takes ``instead`` units of the style's kernel.

    A cost that was published or assumed for a whole planner holds such work already.
    """
    return replace(step, kernel=kernel, instead=instead)


def one_step(task: str, cycles: int, ram_addresses: int = 0) -> Step:
    """A step of one unit, recorded as a ``TaskRecord`` of ``task``."""
    return Step(task, np.array([cycles], np.int64), task_record(task, cycles), ram_addresses)
