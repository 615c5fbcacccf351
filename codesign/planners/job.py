"""The argument that every method of planners and styles takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from codesign.ground.figures import Figure
from codesign.ground.memo import Memo
from codesign.ground.part import Part
from codesign.planners.external_memory import ExternalMemoryLaw

ProblemT = TypeVar("ProblemT")
ParametersT = TypeVar("ParametersT")
AnswerT = TypeVar("AnswerT")


@dataclass(frozen=True, eq=False)
class Job(Generic[ProblemT, ParametersT]):
    """One problem to be planned, with everything that a planner or a style may need to know about it.

    What is planned:

    - ``problem``: a ``Problem``, or what the ``problem_model`` of the planner makes.
    - ``parameters``: of the planning task, also for the style of another task.

    Where it is planned:

    - ``part``: the part of the FPGA; None on a processor.
    - ``memory``: bytes of RAM that the processor has for a plan, a figure; None on an FPGA, and where none is declared.
    - ``inside``: the tasks of the planner that the planning component does itself; None for all of them.
    - ``mapped``: the names of all tasks that the workload maps.
    - ``external``: the external memory that the mapping names, only for a style with ``supports_external``.

    One run of it:

    - ``start``: values to continue from: ``Planner.start_of`` of the last plan, or the result of the task
      ``lower_bound``. A planner without either policy ignores it.
    - ``plan``: the plan; None for a task that runs before it.
    - ``position``: where the robot is, (row, column) in cells.
    - ``memo``: holds work that several runs share; None where no other run needs it.
    - ``detail``: whether a listener wants single steps, or a user may interrupt. Without it a step may be as coarse as
      a whole stage. The sum of the cycles is the same.
    """

    problem: ProblemT
    parameters: ParametersT
    part: Part | None = None
    memory: Figure | None = None
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

    def shared(self, key: tuple[object, ...], compute: Callable[[], AnswerT]) -> AnswerT:
        """The answer that ``memo`` holds under ``key``; computed where there is none."""
        return compute() if self.memo is None else self.memo.get(key, compute)

    @property
    def chip(self) -> Part:
        """The part, for a style that runs on an FPGA only."""
        assert self.part is not None, "a style on an FPGA needs a part"
        return self.part
