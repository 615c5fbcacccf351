"""The chain of one plan: the map goes to the planner, the planner works, its answer goes to who wants it."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from codesign.memo import Memo
from codesign.planners.interface import COMMAND, LOAD, LOWER_BOUND, POSE, Problem
from codesign.system.build import PLANNING
from codesign.system.ledger import Ledger
from codesign.system.place import DETECT
from codesign.task_graph import Flow, TaskGraph

if TYPE_CHECKING:
    from codesign.system.build import Machine

CHANGE_BITS = 34
"""One changed cell: row and column, 16 bits each, and what it became, 2 bits. Assumed."""


@dataclass(frozen=True, eq=False)
class Answer:
    """A plan with what was planned for, and when things were done (ps)."""

    problem: Any
    plan: Any
    loaded: int
    planned: int
    answered: int
    ledger: Ledger = field(compare=False)


def plan_chain(
    machine: Machine,
    problem: Problem,
    *,
    memo: Memo | None,
    start: Any = None,
    warm: bool = True,
    changed: int | None = None,
    preemptible: bool = False,
) -> Generator[Any, Any, Answer]:
    """Process generator: make one plan.

    Args:
        machine: where.
        problem: what is to be planned.
        memo: shares functional work.
        start: values to go on from.
        warm: have task ``lower_bound`` make the start, where it is mapped.
        changed: cells that changed since the planner was last sent the map; None sends the whole map.
        preemptible: somebody may break it off, so that it must be computed in detail.

    Raises:
        LostMessageError: a message of it was lost.
    """
    chain = _Chain(machine, problem, changed)
    planning = machine.system.planner.planning_task
    if warm and LOWER_BOUND in machine.system.placement.styles:
        start = yield from chain.make_start()
    yield from chain.carry(LOAD, planning)
    loaded = machine.now
    plan = yield from chain.make_plan(start, memo, detail=machine.listening or preemptible)
    planned = machine.now
    machine.follow_up(planning)
    yield from chain.tell(plan)
    return Answer(problem, plan, loaded, planned, machine.now, chain.ledger)


class _Chain:
    """One plan under way: its messages, and what they and the tasks took, in ``ledger``."""

    def __init__(self, machine: Machine, problem: Problem, changed: int | None) -> None:
        self.machine, self.problem, self.ledger = machine, problem, Ledger()
        self._changed = changed
        system = machine.system
        self._flows = self._done_here(system.planner.flows(problem, system.planning))

    def _done_here(self, flows: tuple[Flow, ...]) -> TaskGraph:
        """The flows between tasks that are done."""
        placement = self.machine.system.placement
        done = set(placement.places)
        return TaskGraph(
            placement.graph.tasks, tuple(flow for flow in flows if {flow.sender, flow.receiver} <= done)
        )

    def carry(self, sender: str, receiver: str) -> Generator[Any, Any, None]:
        """Process generator: every message of one plan between two tasks; of the map, what is not known there yet."""
        for flow in self._flows.between(sender, receiver):
            if flow.name != POSE:
                bits = flow.bits
                if sender == LOAD and self._changed is not None:
                    bits = min(bits, max(1, self._changed) * CHANGE_BITS)
                yield from self.machine.carry(flow, self.ledger, bits=bits, priority=PLANNING)

    def _perform(self, task: str, plan: Any) -> Generator[Any, Any, Any]:
        """Process generator: a task that is done by itself; returns what it makes."""
        system = self.machine.system
        style = system.placement.styles[task]
        steps = style.steps(self.problem, system.planning, plan, _position(self.problem))
        return (yield from self.machine.perform(task, steps, self.ledger, priority=PLANNING))

    def make_start(self) -> Generator[Any, Any, Any]:
        """Process generator: the start that task ``lower_bound`` makes, brought to the planning task."""
        yield from self.carry(LOAD, LOWER_BOUND)
        start = yield from self._perform(LOWER_BOUND, None)
        self.machine.follow_up(LOWER_BOUND)
        yield from self.carry(LOWER_BOUND, self.machine.system.planner.planning_task)
        return start

    def make_plan(self, start: Any, memo: Memo | None, *, detail: bool) -> Generator[Any, Any, Any]:
        """Process generator: the plan."""
        system, placement = self.machine.system, self.machine.system.placement
        apart = set(placement.places) - placement.inside
        external = {} if system.external is None else {"external": system.external}
        steps = system.architecture.work(
            self.problem,
            system.planning,
            memo=memo,
            detail=detail or DETECT in apart,
            start=start,
            inside=placement.inside,
            **external,
        )
        return (yield from self.machine.plan(steps, self.ledger))

    def tell(self, plan: Any) -> Generator[Any, Any, None]:
        """Process generator: every task between the planning task and ``command``, with the messages between them."""
        machine, system = self.machine, self.machine.system
        planner, placement = system.planner, system.placement
        sizes = getattr(planner, "flows_after", None)
        if sizes is not None:
            self._flows = self._done_here(sizes(self.problem, system.planning, plan))
        done = [planner.planning_task]
        for task in self._flows.order:
            if task in {*done, LOAD, LOWER_BOUND, DETECT} or task not in planner.tasks:
                continue
            for sender in done:
                yield from self.carry(sender, task)
            if task not in placement.inside:
                yield from self._perform(task, plan)
            machine.follow_up(task)
            done.append(task)
        for sender in done:
            yield from self.carry(sender, COMMAND)
        machine.follow_up(COMMAND)


def _position(problem: Any) -> tuple[float, float]:
    """Where the robot is: the problem's first start, of a problem with cells for starts."""
    if not isinstance(problem, Problem) or not problem.starts:
        return 0.0, 0.0
    row, column = problem.starts[0]
    return float(row), float(column)
