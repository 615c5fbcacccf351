"""Styles on a processor, of whole planners and of tasks placed by themselves: what they have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator
from typing import Any

import numpy as np

from codesign.errors import InputError
from codesign.figures import Figure
from codesign.memo import Memo
from codesign.planners.interface import Problem
from codesign.planners.styles import Demand, Step, StyleBase
from codesign.records import TaskRecord
from codesign.spec.part import Part


class Software(ABC):
    """What a platform tells of a processor, and no style: its clock and its power."""

    planner: str
    style: str = "software"
    component_type = "processor"
    kernel: str

    def clock_limit(self, problem: Problem, parameters: Any, part: Part | None = None) -> Figure:  # noqa: ARG002
        """A processor's clock is its own: there is no law to hold it against.

        Raises:
            InputError: always.
        """
        raise InputError("a processor's clock has no limit law", self.style, "give it in the platform")

    def power(self, demand: Demand, clock: int, part: Part | None = None) -> tuple[Figure, Figure]:  # noqa: ARG002
        """A processor's power stands in the platform, not in a law.

        Raises:
            InputError: always.
        """
        raise InputError("a processor's power has no law", self.style, "give it in the platform")


class HostStyle(Software, StyleBase):
    """A planner in software: left to say is how it works, in units of ``kernel``."""

    def kernels(self, parameters: Any) -> tuple[str, ...]:  # noqa: ARG002
        """Every kernel that steps under ``parameters`` are counted in."""
        return (self.kernel,)

    def demand(
        self,
        problem: Problem,  # noqa: ARG002
        parameters: Any,  # noqa: ARG002
        part: Part | None = None,  # noqa: ARG002
        *,
        inside: frozenset[str] | None = None,  # noqa: ARG002
    ) -> Demand:
        """Software takes no resource of a part."""
        return Demand(items=())

    def memory(self, problem: Problem, parameters: Any) -> None:
        """What it keeps is in the processor's own memory."""

    @abstractmethod
    def work(
        self,
        problem: Problem,
        parameters: Any,
        *,
        memo: Memo | None = None,
        detail: bool = True,
        start: Any = None,
        inside: frozenset[str] | None = None,
    ) -> Generator[Step, None, Any]:
        """As ``Architecture.work``."""


class HostTask(Software):
    """One task in software: one step, in units of ``kernel``, once its outcome is known."""

    task: str
    description: str

    @abstractmethod
    def outcome(
        self, problem: Problem, parameters: Any, plan: Any, position: tuple[float, float]
    ) -> tuple[int, Any]:
        """Units of the kernel that one execution takes, at least 1, and what it makes."""

    def demand(self, problem: Problem, parameters: Any, part: Part | None = None) -> Demand:  # noqa: ARG002
        """Software takes no resource of a part."""
        return Demand(items=())

    def steps(
        self, problem: Problem, parameters: Any, plan: Any, position: tuple[float, float]
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
