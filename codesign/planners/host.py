"""Styles on a processor, of whole planners and of tasks placed by themselves: what they have in common.

The platform declares a processor's clock and power, so no law gives them. Software takes no resource of a part.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Generator
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


def one_step(task: str, cycles: int, ram_addresses: int = 0) -> Step:
    """A step of one unit, told as a ``TaskRecord`` of ``task``."""

    def tell(begin: int, end: int, source: str) -> TaskRecord:
        return TaskRecord(begin, source, task, end, cycles)

    return Step(task, np.array([cycles], np.int64), tell, ram_addresses)
