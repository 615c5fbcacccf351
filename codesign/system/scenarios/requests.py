"""The requests of a task: one from each start, each simulated from the map that is sent to the answer received.

Where a plan serves every start, starts that are answered alike (``Planner.answer_class``) are simulated once.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from codesign.ground.memo import Memo
from codesign.ground.models import Task
from codesign.inputs.problem import ProblemSpec
from codesign.planners.interface import Problem
from codesign.system.bind import System, planner_code
from codesign.system.chain import Answer, PlanMachine, SentMap, plan_chain
from codesign.system.results.ledger import Ledger

Boards = Mapping[str, tuple[float, float]]
"""Static and dynamic power of each FPGA, W."""

SHARED_BYTES = 128 * 2**20
"""Bytes of functional work that the requests of one run share, where no exploration brings a memo."""


@dataclass(frozen=True, eq=False)
class Request:
    """One request that was simulated.

    ``answer``: to it. ``before``: of a replan, the plan of the map before its change; else the answer itself.
    ``joules``: from the request to the end, as the parts of an ``Energy`` by name. ``machine``: that it ran on.
    """

    answer: Answer
    before: Answer
    joules: Mapping[str, float]
    machine: PlanMachine


@dataclass(frozen=True, eq=False)
class Requests:
    """All requests of a task. ``first``: the first start's. ``all``: one of each start, equals as one object."""

    first: Request
    all: tuple[Request, ...] = field(default=())

    @property
    def ledgers(self) -> tuple[Ledger, ...]:
        """The account of each request, equals as one object."""
        return tuple(request.answer.ledger for request in self.all)

    @property
    def joules(self) -> dict[str, float]:
        """The energy a request, mean over all."""
        # fsum rounds once, so that no sum depends on the order of the starts.
        return {part: mean_of_requests([request.joules[part] for request in self.all]) for part in self.first.joules}


def mean_of_requests(values: Sequence[Any]) -> Any:
    """The mean of numbers, or of arrays entry by entry; each sum is rounded once."""
    if not any(np.ndim(value) for value in values):
        return math.fsum(values) / len(values)
    if all(value is values[0] for value in values):
        # A product is rounded once, as a sum of as many equals is.
        return values[0] * len(values) / len(values)
    columns = np.broadcast_arrays(*values)
    return np.array([math.fsum(entries) for entries in zip(*columns, strict=True)]) / len(values)


def requests_of(machine: PlanMachine, boards: Boards, memo: Memo | None) -> Requests:
    """Simulate the requests of the task that the problem names.

    The first start runs on ``machine``, with its listeners. Every other one runs on a machine of its own.

    Raises:
        LostMessageError: a message of one was lost. MisreadMapError: see ``plan_chain``.
    """
    system, problem = machine.system, machine.system.problem
    if not isinstance(problem, Problem) or problem.task is Task.FIELD or len(problem.starts) < 2:
        first = _ask(machine, problem, boards, memo)
        return Requests(first, (first,))
    memo = Memo(SHARED_BYTES) if memo is None else memo
    first = _ask(machine, problem, boards, memo)
    classes = _classes(system, first.answer)
    requests = {classes[problem.starts[0]]: first}
    for start, name in classes.items():
        if name not in requests:
            requests[name] = _ask(machine.another(), problem.asked_from(start), boards, memo)
    return Requests(first, tuple(requests[classes[start]] for start in problem.starts))


def _classes(system: System, answer: Answer) -> dict[Any, Any]:
    """The class of each start: the starts of one class are answered in the same time."""
    planner, starts = system.planner, system.problem.starts
    with planner_code(planner):
        job = replace(system.job, problem=answer.problem, plan=answer.plan)
        if planner.plans_for_start(job):
            return {start: start for start in starts}
        return {start: planner.answer_class(job, start) for start in starts}


def _ask(machine: PlanMachine, problem: Any, boards: Boards, memo: Memo | None) -> Request:
    """One request on a machine at time 0; of a replan, the plan before it too."""
    answers: list[tuple[Answer, Answer]] = []
    spent: list[dict[str, float]] = []

    def mission() -> Generator[Any, Any, None]:
        if not isinstance(problem, Problem) or problem.change is None:
            answer = yield from plan_chain(machine, problem, memo=memo)
            answers.append((answer, answer))
            return
        sent = defaultdict[str, SentMap](SentMap)
        before = yield from plan_chain(machine, problem, memo=memo, sent=sent)
        spent.append(machine.joules(boards))
        policy = _policy(machine.system)
        start = None
        if policy == "continue":
            with planner_code(machine.system.planner):
                start = machine.system.planner.start_of(before.plan)
        warm = policy == "lower_bound"
        changed = problem.changed
        answer = yield from plan_chain(machine, changed, memo=memo, start=start, warm=warm, sent=sent)
        answers.append((before, answer))

    machine.run(mission())
    ((before, answer),) = answers
    whole = machine.joules(boards)
    joules = {part: value - sum(each[part] for each in spent) for part, value in whole.items()}
    return Request(answer, before, joules, machine)


def _policy(system: System) -> str:
    """The policy of a replan: the one that is named, or the planner's first."""
    spec = system.workload.problem
    named = spec.change.policy if isinstance(spec, ProblemSpec) and spec.change is not None else None
    return system.planner.policies[0] if named is None else named.value
