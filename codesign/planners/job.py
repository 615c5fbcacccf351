"""The one argument of what planners and styles are asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from codesign.memo import Memo
from codesign.part import Part
from codesign.planners.external_memory import ExternalMemoryLaw

ProblemT = TypeVar("ProblemT")
ParametersT = TypeVar("ParametersT")
Made = TypeVar("Made")


@dataclass(frozen=True, eq=False)
class Job(Generic[ProblemT, ParametersT]):
    """One problem to be planned, and everything that is known of it when a planner or a style is asked.

    What is planned:

    - ``problem``: a ``Problem``, or what the ``problem_model`` of the planner makes.
    - ``parameters``: of the planning task, also where the style of another task is asked.

    Where it is planned:

    - ``part``: the part of the FPGA that is asked about; None on a processor.
    - ``inside``: the tasks of the planner that the planning component does itself; None for all of them.
    - ``mapped``: the names of all tasks that the workload maps.
    - ``external``: the external memory that the mapping names, only for a style with ``supports_external``.

    One run of it:

    - ``start``: values to continue from: ``Planner.start_of`` of the last plan, or what the task ``lower_bound`` made.
      A planner without either policy ignores it.
    - ``plan``: the plan that is made; None for a task that comes before it.
    - ``position``: where the robot is, (row, column) in cells.
    - ``memo``: holds work that several runs share; None where nobody asks for it again.
    - ``detail``: whether somebody listens or may interrupt. Without it a step may be as coarse as a whole stage. The
      cycles add up to the same.
    """

    problem: ProblemT
    parameters: ParametersT
    part: Part | None = None
    inside: frozenset[str] | None = None
    mapped: frozenset[str] = frozenset()
    external: ExternalMemoryLaw | None = None
    start: Any = None
    plan: Any = None
    position: tuple[float, float] = (0.0, 0.0)
    memo: Memo | None = None
    detail: bool = True

    def does(self, task: str) -> bool:
        """Whether the planning component does ``task`` itself.

        >>> Job(None, None).does("decide"), Job(None, None, inside=frozenset({"relax"})).does("decide")
        (True, False)
        """
        return self.inside is None or task in self.inside

    def shared(self, key: tuple[object, ...], compute: Callable[[], Made]) -> Made:
        """What ``memo`` holds under ``key``; computed where it holds nothing."""
        return compute() if self.memo is None else self.memo.get(key, compute)

    @property
    def chip(self) -> Part:
        """The part, for a style that runs on an FPGA only."""
        assert self.part is not None, "a style on an FPGA is asked with a part"
        return self.part
