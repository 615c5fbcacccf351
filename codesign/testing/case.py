"""The base of all rules of the contract: the case that a rule checks, and the report of a breach."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from codesign import maps
from codesign.ground.models import Part
from codesign.inputs import load_part
from codesign.planners.interface import COMMAND, Planner, Problem
from codesign.planners.job import Demand, Job
from codesign.planners.plug_in import PlugIn
from codesign.planners.styles import Architecture, Step, TaskStyle

PART = "XC2VP30-6"
"""The shipped part for demands, clock limits and power."""


def require(holds: object, sentence: str) -> None:
    """Report a breach of the contract.

    Raises:
        AssertionError: ``holds`` is false; with ``sentence``.
    """
    if not holds:
        raise AssertionError(sentence)


@dataclass(frozen=True)
class Run:
    """One run of ``work`` or of a task: its ``steps`` in order, and its ``result``."""

    steps: tuple[Step, ...]
    result: Any

    @property
    def phases(self) -> dict[str, int]:
        """Cycles by phase."""
        cycles: dict[str, int] = {}
        for step in self.steps:
            if len(step.cycles):
                cycles[step.phase] = cycles.get(step.phase, 0) + int(step.cycles.sum())
        return cycles

    @property
    def cycles(self) -> int:
        """All cycles."""
        return sum(self.phases.values())


def drained(steps: Generator[Step, None, Any]) -> Run:
    """Run to the end."""
    taken = []
    while True:
        try:
            taken.append(next(steps))
        except StopIteration as done:
            return Run(tuple(taken), done.value)


@dataclass(frozen=True, eq=False)
class Case:
    """One plug-in with one set of parameters of its planning task.

    ``given``: the parameters as a workload writes them. ``problems``: two different problems, each a problem of the
    planner or a mapping for its ``problem_model``; None for maps that the suite generates.
    """

    plug_in: PlugIn
    planner: Planner
    index: int
    given: Mapping[str, Any]
    problems: Sequence[Any] | None = None

    def __str__(self) -> str:
        return f"{self.planner.name}-{self.index}"

    @cached_property
    def parameters(self) -> Any:
        """The validated parameters of the planning task."""
        return self.planner.tasks[self.planner.planning_task].model_validate(dict(self.given))

    @property
    def on_maps(self) -> bool:
        """True if the planner's problem is a map with goals and starts."""
        return self.planner.problem_model is None

    @cached_property
    def problem(self) -> Any:
        """The problem that nearly every rule uses."""
        return self.fresh_problem()

    @cached_property
    def other_problem(self) -> Any:
        """A problem that differs from ``problem``."""
        return _one_cell_changed(_rooms()) if self.problems is None else self._problem_of(self.problems[1])

    def fresh_problem(self) -> Any:
        """A copy of ``problem`` from before the first plan."""
        return pickle.loads(self._pickled)

    @cached_property
    def _pickled(self) -> bytes:
        return pickle.dumps(_rooms() if self.problems is None else self._problem_of(self.problems[0]))

    def _problem_of(self, problem: Any) -> Any:
        model: Any = self.planner.problem_model
        if model is not None and isinstance(problem, Mapping):
            return model.model_validate(problem).problem()
        return problem

    @cached_property
    def plan(self) -> Any:
        """The planner's plan of ``problem``."""
        return self.planner.plan(self.job)

    @property
    def job(self) -> Job[Any, Any]:
        """The job of the planner and of its styles."""
        return Job(self.problem, self.parameters, mapped=frozenset(self.planner.tasks))

    def job_on(self, style: Architecture | TaskStyle, **more: Any) -> Job[Any, Any]:
        """The job on the type of component of the style; ``more``: other fields of the job."""
        return replace(self.job, part=self.part if style.component_type == "fpga" else None, **more)

    @property
    def part(self) -> Part:
        """The part for styles on an FPGA."""
        return load_part(PART)

    @property
    def answering(self) -> frozenset[str]:
        """The tasks that send the answer."""
        flows = self.planner.flows(self.job)
        return frozenset(flow.sender for flow in flows if flow.receiver == COMMAND)

    @property
    def answer(self) -> str:
        """The one task that sends the answer."""
        (task,) = self.answering
        return task

    @property
    def answer_elsewhere(self) -> frozenset[str]:
        """The tasks of the planner where another component answers; all, if the planning task itself answers."""
        return frozenset(self.planner.tasks) - {self.answer} | {self.planner.planning_task}

    @property
    def styles(self) -> tuple[Architecture, ...]:
        """The plug-in's architecture styles."""
        return self.plug_in.styles

    @property
    def task_styles(self) -> tuple[TaskStyle, ...]:
        """The plug-in's styles of tasks that are placed by themselves."""
        return self.plug_in.task_styles

    @property
    def every_style(self) -> tuple[Architecture | TaskStyle, ...]:
        """Styles of both kinds."""
        return (*self.styles, *self.task_styles)

    def demand(self, style: Architecture, inside: frozenset[str] | None = None) -> Demand:
        """The demand of the style."""
        return style.demand(self.job_on(style, inside=inside))

    def work(self, style: Architecture, **more: Any) -> Run:
        """The style's work on ``problem``, drained; ``more``: fields of its job."""
        return drained(style.work(self.job_on(style, **more)))

    def task(self, style: TaskStyle, *, again: bool = False) -> Run:
        """One execution of a task at the first start, drained; ``again``: one more decision of the same plan."""
        ask = style.again if again else style.steps
        return drained(ask(self.job_on(style, plan=self.plan, position=self.position)))

    @property
    def position(self) -> tuple[float, float]:
        """The first start, as a position."""
        row, column = map(float, self.problem.starts[0])
        return row, column

    def same(self, plan: Any) -> bool:
        """True if ``plan`` is the planner's plan of ``problem``."""
        return self.planner.identity(plan) == self.planner.identity(self.plan)


@dataclass(frozen=True)
class Rule:
    """One rule of the contract. ``holds`` raises AssertionError with a sentence where a case breaks it.

    ``applies``: whether the rule concerns a case.
    """

    name: str
    holds: Callable[[Case], None]
    applies: Callable[[Case], bool]

    def __call__(self, case: Case) -> None:
        """Check the rule. Raises AssertionError where the case breaks it."""
        self.holds(case)


def rule(applies: Callable[[Case], bool] = lambda _: True) -> Callable[[Callable[[Case], None]], Rule]:
    """A decorator that turns a function into a rule of its name."""

    def rule_of(holds: Callable[[Case], None]) -> Rule:
        return Rule(holds.__name__, holds, applies)

    return rule_of


def on_maps(case: Case) -> bool:
    """The planner's problem is a map with goals and starts."""
    return case.on_maps


def names(values: Iterable[Any]) -> str:
    """The names in a sentence, sorted."""
    return ", ".join(sorted(map(str, values))) or "none"


def of(style: Architecture | TaskStyle) -> str:
    """A style in a sentence."""
    task = f"{style.task}, " if isinstance(style, TaskStyle) else ""
    return f"style {style.style!r} ({task}{style.component_type})"


def _rooms() -> Problem:
    """Six rooms on 24 × 32 cells, one goal and some dozen starts that lead to it."""
    grid = maps.generate("rooms", rows=24, columns=32, room=(11, 15), door=3, seed=5)
    cells = np.argwhere(maps.reachable(grid.free, [(2, 2)]))
    starts = tuple((int(row), int(column)) for row, column in cells[3::40])
    return Problem(free=grid.free, goals=((2, 2),), starts=starts)


def _one_cell_changed(problem: Problem) -> Problem:
    free = problem.free.copy()
    free[2, 4] = not free[2, 4]
    starts = tuple(start for start in problem.starts if free[start])
    return Problem(free=free, goals=problem.goals, starts=starts)
