"""Styles on a processor, of whole planners and of tasks placed by themselves: what they have in common.

The platform declares a processor's clock and power, so no law gives them. Software takes no resource of a part.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Generator
from typing import Any

import numpy as np

from codesign.planners.job import Job
from codesign.planners.styles import Architecture, Step, TaskStyle
from codesign.records import TaskRecord


class HostStyle(Architecture):
    """A planner in software. A subclass gives ``work``, in units of ``kernel``."""

    style: str = "software"
    component_type = "processor"


class HostTask(TaskStyle):
    """One task in software: one step, in units of ``kernel``, once its outcome is known."""

    style: str = "software"
    component_type = "processor"

    @abstractmethod
    def outcome(self, job: Job[Any, Any], /) -> tuple[int, Any]:
        """Units of the kernel that one execution takes, at least 1, and what it makes."""

    def steps(self, job: Job[Any, Any]) -> Generator[Step, None, Any]:
        """One step, booked under the task's name."""
        units, made = self.outcome(job)
        yield one_step(self.task, units)
        return made


def task_record(task: str, cycles: int) -> Callable[[int, int, str], TaskRecord]:
    """The record of a step that is a task by itself, for ``Step.record``."""
    return lambda begin, end, source: TaskRecord(begin, source, task, end, cycles)


def one_step(task: str, cycles: int, ram_addresses: int = 0) -> Step:
    """A step of one unit, told as a ``TaskRecord`` of ``task``."""
    return Step(task, np.array([cycles], np.int64), task_record(task, cycles), ram_addresses)
