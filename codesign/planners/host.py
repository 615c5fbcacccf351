"""Styles on a processor, of whole planners and of tasks placed by themselves: what they have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Generator
from typing import Any

import numpy as np

from codesign.errors import InputError
from codesign.figures import Figure
from codesign.part import Part
from codesign.planners.styles import Architecture, Demand, Step, TaskStyle
from codesign.records import TaskRecord


class Software:
    """A style on a processor. The platform declares the processor's clock and power, so no law gives them."""

    style: str = "software"
    component_type: str = "processor"

    def clock_limit(self, problem: Any, parameters: Any, part: Part | None = None) -> Figure:  # noqa: ARG002
        """There is no law to hold a processor's clock against.

        Raises:
            InputError: always.
        """
        raise InputError("a processor's clock has no limit law", self.style, "declare it in the platform")

    def power(self, demand: Demand, clock: int, part: Part | None = None) -> tuple[Figure, Figure]:  # noqa: ARG002
        """There is no law of a processor's power.

        Raises:
            InputError: always.
        """
        raise InputError("a processor's power has no law", self.style, "declare it in the platform")


class HostStyle(Software, Architecture):
    """A planner in software. A subclass gives ``work``, in units of ``kernel``."""

    def demand(
        self,
        problem: Any,  # noqa: ARG002
        parameters: Any,  # noqa: ARG002
        part: Part | None = None,  # noqa: ARG002
        *,
        inside: frozenset[str] | None = None,  # noqa: ARG002
    ) -> Demand:
        """Software takes no resource of a part."""
        return Demand(items=())


class HostTask(Software, TaskStyle):
    """One task in software: one step, in units of ``kernel``, once its outcome is known."""

    @abstractmethod
    def outcome(
        self, problem: Any, parameters: Any, plan: Any, position: tuple[float, float]
    ) -> tuple[int, Any]:
        """Units of the kernel that one execution takes, at least 1, and what it makes."""

    def demand(self, problem: Any, parameters: Any, part: Part | None = None) -> Demand:  # noqa: ARG002
        """Software takes no resource of a part."""
        return Demand(items=())

    def steps(
        self, problem: Any, parameters: Any, plan: Any, position: tuple[float, float]
    ) -> Generator[Step, None, Any]:
        """One step, booked under the task's name."""
        units, made = self.outcome(problem, parameters, plan, position)
        yield one_step(self.task, units)
        return made


def one_step(task: str, cycles: int) -> Step:
    """A step of one unit, told as a ``TaskRecord`` of ``task``."""

    def tell(begin: int, end: int, source: str) -> TaskRecord:
        return TaskRecord(begin, source, task, end, cycles)

    return Step(task, np.array([cycles], np.int64), tell)
