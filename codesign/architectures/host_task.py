"""Tasks that are placed on a processor by themselves: what their styles have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator
from typing import Any

import numpy as np

from codesign.architectures.interface import Demand, Step
from codesign.errors import InputError
from codesign.figures import Figure
from codesign.planners.interface import Problem
from codesign.records import TaskRecord
from codesign.spec.part import Part


class HostTask(ABC):
    """One task in software: one step, in units of ``kernel``, once its outcome is known."""

    planner: str
    task: str
    style = "software"
    description: str
    component_type = "processor"
    kernel: str

    @abstractmethod
    def outcome(
        self, problem: Problem, parameters: Any, plan: Any, position: tuple[float, float]
    ) -> tuple[int, Any]:
        """Units of the kernel that one execution takes, at least 1, and what it makes."""

    def demand(self, problem: Problem, parameters: Any, part: Part | None = None) -> Demand:  # noqa: ARG002
        """Software takes no resource of a part."""
        return Demand(items=())

    def clock_limit(self, problem: Problem, parameters: Any, part: Part | None = None) -> Figure:  # noqa: ARG002
        """A processor's clock is its own: there is no law to hold it against.

        Raises:
            InputError: always.
        """
        raise InputError("a processor's clock has no limit law", self.style, "give it in the platform")

    def steps(
        self, problem: Problem, parameters: Any, plan: Any, position: tuple[float, float]
    ) -> Generator[Step, None, Any]:
        """One step, booked under the task's name."""
        units, made = self.outcome(problem, parameters, plan, position)
        yield one_step(self.task, units)
        return made

    def power(self, demand: Demand, clock: int, part: Part | None = None) -> tuple[Figure, Figure]:  # noqa: ARG002
        """A processor's power stands in the platform, not in a law.

        Raises:
            InputError: always.
        """
        raise InputError("a processor's power has no law", self.style, "give it in the platform")


def one_step(task: str, cycles: int) -> Step:
    """A step of one unit, told as a ``TaskRecord`` of ``task``."""

    def tell(begin: int, end: int, source: str) -> TaskRecord:
        return TaskRecord(begin, source, task, end, cycles)

    return Step(task, np.array([cycles], np.int64), tell)
