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
from codesign.task_graph import TaskGraph

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
    system, placement = machine.system, machine.system.placement
    planner, parameters = system.planner, system.planning
    ledger = Ledger()
    flows = TaskGraph(
        placement.graph.tasks,
        tuple(
            flow
            for flow in planner.flows(problem, parameters)
            if {flow.sender, flow.receiver} <= set(placement.places)
        ),
    )
    position = _position(problem)

    def carry(sender: str, receiver: str) -> Generator[Any, Any, None]:
        for flow in flows.flows:
            if (flow.sender, flow.receiver) == (sender, receiver) and flow.name != POSE:
                bits = flow.bits
                if sender == LOAD and changed is not None:
                    bits = min(bits, max(1, changed) * CHANGE_BITS)
                yield from machine.carry(flow, ledger, bits=bits, priority=PLANNING)

    planning = planner.planning_task
    if warm and LOWER_BOUND in placement.styles:
        yield from carry(LOAD, LOWER_BOUND)
        steps = placement.styles[LOWER_BOUND].steps(problem, parameters, None, position)
        start = yield from machine.perform(LOWER_BOUND, steps, ledger, priority=PLANNING)
        machine.follow_up(LOWER_BOUND)
        yield from carry(LOWER_BOUND, planning)
    yield from carry(LOAD, planning)
    loaded = machine.now
    detail = machine.listening or preemptible or DETECT in (set(placement.places) - placement.inside)
    external = {} if system.external is None else {"external": system.external}
    steps = system.architecture.work(
        problem, parameters, memo=memo, detail=detail, start=start, inside=placement.inside, **external
    )
    plan = yield from machine.plan(steps, ledger)
    planned = machine.now
    machine.follow_up(planning)
    yield from _answer(machine, problem, plan, carry, flows, ledger)
    return Answer(problem, plan, loaded, planned, machine.now, ledger)


def _answer(
    machine: Machine, problem: Problem, plan: Any, carry: Any, flows: TaskGraph, ledger: Ledger
) -> Generator[Any, Any, None]:
    """Every task between the planning task and ``command``, with the messages between them."""
    placement, planner = machine.system.placement, machine.system.planner
    done = [planner.planning_task]
    for task in flows.order:
        if task in {*done, LOAD, LOWER_BOUND, DETECT} or task not in planner.tasks:
            continue
        for sender in done:
            yield from carry(sender, task)
        if task not in placement.inside:
            steps = placement.styles[task].steps(problem, machine.system.planning, plan, _position(problem))
            yield from machine.perform(task, steps, ledger, priority=PLANNING)
        machine.follow_up(task)
        done.append(task)
    for sender in done:
        yield from carry(sender, COMMAND)
    machine.follow_up(COMMAND)


def _position(problem: Any) -> tuple[float, float]:
    """Where the robot is: the problem's first start, of a problem with cells for starts."""
    if not isinstance(problem, Problem) or not problem.starts:
        return 0.0, 0.0
    row, column = problem.starts[0]
    return float(row), float(column)
