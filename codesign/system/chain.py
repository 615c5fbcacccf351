"""The chain of one plan: the map goes to the planner, the planner works, its answer goes to ``command``."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Generator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.errors import CodesignError
from codesign.ground.memo import Memo
from codesign.ground.models import Task
from codesign.ground.records import Record, TaskRecord
from codesign.planners.interface import COMMAND, LOAD, LOWER_BOUND, POSE, Problem
from codesign.planners.job import Flow, TaskGraph
from codesign.planners.styles import Step
from codesign.system.bind import System, planner_code
from codesign.system.build import PLANNING
from codesign.system.messages import Content, Wrong
from codesign.system.place import DETECT
from codesign.system.results.ledger import Ledger

OBSTACLE, FREE, GOAL = 0, 1, 2
"""The two bits of a cell; 3 is read as an obstacle (assumed)."""

STATE_BITS, PLACE_BITS = 2, 16
CHANGE_BITS = 2 * PLACE_BITS + STATE_BITS
"""One changed cell: row and column, 16 bits each, and what it became, 2 bits. Assumed."""


def states(problem: Problem) -> NDArray[np.int8]:
    """Int8, rows × columns: the state of each cell of a problem's map."""
    cells = np.where(problem.free, FREE, OBSTACLE).astype(np.int8)
    for goal in problem.goals:
        cells[goal] = GOAL
    return cells


@dataclass(frozen=True, eq=False)
class MapMessage:
    """A map in its message.

    ``cells``: int64 n × 2, (row, column), the cells that it has, in raster order; ``states``: int8, one each.
    ``bits``: its size; ``whole``: whether it is all of the map. Then all cells take as many bits, and the lowest two
    are the state. A change is row, column and state, the lowest bit first.
    """

    cells: NDArray[np.int64]
    states: NDArray[np.int8]
    bits: int
    whole: bool

    def misread(self, wrong: Wrong) -> MapMessage | None:
        """The message as it is read where these bits are wrong."""
        cells, read = self.cells.copy(), self.states.copy()
        width = self.bits // len(cells) if self.whole else CHANGE_BITS
        for bit in wrong:
            index, place = divmod(bit, width)
            if index >= len(cells):
                continue
            if self.whole or place >= 2 * PLACE_BITS:
                place -= 0 if self.whole else 2 * PLACE_BITS
                read[index] ^= 1 << place if place < STATE_BITS else 0
            else:
                cells[index, place // PLACE_BITS] ^= 1 << place % PLACE_BITS
        if np.array_equal(cells, self.cells) and np.array_equal(read, self.states):
            return None
        return replace(self, cells=cells, states=read)


class SentMap:
    """The map that a planner holds over the plans of a drive, and the one that its sender believes it to hold.

    They differ once a message was misread, until the cell is sent again.
    """

    def __init__(self) -> None:
        self._sent: NDArray[np.int8] | None = None
        self._held: NDArray[np.int8] | None = None

    def message(self, problem: Problem, bits: int) -> MapMessage:
        """The message to send: the changes, or the whole map of ``bits`` bits where that is no longer."""
        now = states(problem)
        changed = np.ones(now.shape, np.bool_) if self._sent is None else now != self._sent
        cells = np.argwhere(changed)
        size = max(1, len(cells)) * CHANGE_BITS
        whole = self._sent is None or size >= bits
        if whole:
            cells, size = np.argwhere(np.ones(now.shape, np.bool_)), bits
        self._sent = now
        return MapMessage(cells, now[tuple(cells.T)], size, whole)

    def take(self, message: MapMessage, problem: Problem) -> Problem:
        """The problem that the planner then plans: ``problem``, but on the map that it holds."""
        held = np.zeros((problem.rows, problem.columns), np.int8) if self._held is None else self._held.copy()
        inside = (message.cells < held.shape).all(axis=1)
        held[tuple(message.cells[inside].T)] = message.states[inside]
        self._held = held
        if np.array_equal(held, states(problem)):
            return problem
        goals = [goal for goal in problem.goals if held[goal] == GOAL]
        goals += [(int(row), int(column)) for row, column in np.argwhere(held == GOAL)]
        free = (held == FREE) | (held == GOAL)
        return replace(problem, free=free, goals=tuple(dict.fromkeys(goals)))


@dataclass(frozen=True, eq=False)
class Answer:
    """A plan with what was planned for, and when it was asked for and things were done (ps)."""

    problem: Any
    plan: Any
    loaded: int
    planned: int
    answered: int
    ledger: Ledger = field(compare=False)
    asked: int = 0

    @property
    def parts(self) -> tuple[int, int, int]:
        """Picoseconds until the map was there, of planning, and until the answer was received."""
        return self.loaded - self.asked, self.planned - self.loaded, self.answered - self.planned


class PlanMachine(Protocol):
    """The machine that a plan is made on: a simulated one, or a recorder of what its components and links do.

    See ``Machine`` for each method.
    """

    @property
    def system(self) -> System:
        """The bound system."""

    @property
    def now(self) -> int:
        """The simulated time, ps; or how much was recorded."""

    def joules(self, boards: Mapping[str, tuple[float, float]]) -> dict[str, float]:
        """The parts of an energy up to now, by name; none of a recorder."""

    def wants(self, kind: type[Record]) -> bool:
        """True if a listener wants records of this class."""

    def run(self, process: Generator[Any, Any, None]) -> None:
        """Run a process generator to the end."""

    def another(self) -> PlanMachine:
        """A machine of the same system at time 0."""

    def carry(
        self,
        flow: Flow,
        ledger: Ledger | None = None,
        *,
        bits: int | None = None,
        priority: int = 0,
        content: Content | None = None,
    ) -> Generator[Any, Any, Any]:
        """Process generator: a message between two tasks."""

    def plan(self, steps: Generator[Step, None, Any], ledger: Ledger | None = None) -> Generator[Any, Any, Any]:
        """Process generator: the steps of the planner's style."""

    def perform(
        self, task: str, steps: Generator[Step, None, Any], ledger: Ledger | None = None, *, priority: int = 0
    ) -> Generator[Any, Any, Any]:
        """Process generator: the steps of a task."""

    def charge(
        self, task: str, kernel: str, units: int, ledger: Ledger | None = None, *, what: str = "", priority: int = 0
    ) -> Generator[Any, Any, None]:
        """See ``Machine.charge``."""

    def follow_up(self, task: str) -> None:
        """Start the user's own tasks after a task."""


def plan_chain(
    machine: PlanMachine,
    problem: Problem,
    *,
    memo: Memo | None,
    start: Any = None,
    warm: bool | None = None,
    sent: defaultdict[str, SentMap] | None = None,
    preemptible: bool = False,
) -> Generator[Any, Any, Answer]:
    """Process generator: make one plan. For task ``field`` it ends where the task that decides holds the plan.

    Args:
        machine: where.
        problem: what is to be planned.
        memo: shares functional work.
        start: values to go on from.
        warm: have task ``lower_bound`` make the start, where it is mapped. None: as the parameters have it.
        sent: by task, what it was sent of the map before, so that only the changes are sent; kept up. None: the whole
            map is sent, and unnoticed damage to it is ignored: one plan is judged on the map that was sent.
        preemptible: the plan may be broken off, so it is computed in detail.

    Raises:
        LostMessageError: a message of it was lost.
        MisreadMapError: the map that the planner holds after damage is none that it can plan on.
    """
    chain, asked = _Chain(machine, problem, sent, memo), machine.now
    planning = machine.system.planner.planning_task
    yield from chain.prepare_map()
    if warm is None:
        warm = machine.system.planning.begins_at_bound
    if warm and LOWER_BOUND in machine.system.placement.styles:
        start = yield from chain.make_start()
    yield from chain.load(planning)
    loaded = machine.now
    plan = yield from chain.make_plan(start, memo, detail=machine.wants(TaskRecord) or preemptible)
    planned = machine.now
    machine.follow_up(planning)
    yield from chain.tell(plan)
    return Answer(chain.problem, plan, loaded, planned, machine.now, chain.ledger, asked)


class MisreadMapError(CodesignError):
    """A map that a planner cannot plan on, as bits of it arrived wrong."""


class _Chain:
    """One plan under way: its messages, and what they and the tasks took, in ``ledger``.

    For task ``field`` the tasks that answer (``_left_out``) receive the plan, and answer nobody.

    ``problem``: what is planned. The map is the one that was handed to the first link, as the planner read it.
    """

    def __init__(
        self, machine: PlanMachine, problem: Problem, sent: defaultdict[str, SentMap] | None, memo: Memo | None
    ) -> None:
        self.machine, self.problem, self.ledger = machine, problem, Ledger()
        self._sent, self._memo = sent, memo
        system = machine.system
        flows = system.planner.flows(replace(system.job, problem=problem, memo=memo))
        self._flows = self._done_here(flows)
        answering = {flow.sender for flow in flows if flow.receiver == COMMAND}
        field = isinstance(problem, Problem) and problem.task is Task.FIELD
        self._left_out = answering - {system.planner.planning_task} if field else set()
        self._to_command = not field

    def _done_here(self, flows: tuple[Flow, ...]) -> TaskGraph:
        """The flows between tasks that are done."""
        placement = self.machine.system.placement
        done = set(placement.places)
        return TaskGraph(placement.graph.tasks, tuple(flow for flow in flows if {flow.sender, flow.receiver} <= done))

    def carry(self, sender: str, receiver: str) -> Generator[Any, Any, None]:
        """Process generator: every message of one plan between two tasks, the map to the planner aside."""
        for flow in self._flows.between(sender, receiver):
            if flow.name != POSE:
                yield from self.machine.carry(flow, self.ledger, priority=PLANNING)

    def prepare_map(self) -> Generator[Any, Any, None]:
        """Process generator: what the component that sends the map does to it before."""
        system = self.machine.system
        with planner_code(system.planner):
            works = system.planner.map_work(replace(system.job, problem=self.problem, memo=self._memo))
        for what, kernel, units in works:
            yield from self.machine.charge(LOAD, kernel, units, self.ledger, what=what, priority=PLANNING)

    def load(self, task: str) -> Generator[Any, Any, None]:
        """Process generator: the map to a task: what it does not hold yet.

        What ``lower_bound`` reads wrong is not simulated: a start above the answer would have no meaning.
        """
        if self._sent is None:
            yield from self.carry(LOAD, task)
            return
        held, plans = self._sent[task], task != LOWER_BOUND
        for flow in self._flows.between(LOAD, task):
            if flow.name != POSE:
                message = held.message(self.problem, flow.bits)
                content, bits = message if plans else None, message.bits
                read = yield from self.machine.carry(flow, self.ledger, bits=bits, priority=PLANNING, content=content)
                if plans:
                    self._take(held.take(read, self.problem))

    def _take(self, held: Problem) -> None:
        """Plan on the map that the planner holds.

        Raises:
            MisreadMapError: no plan can be made on it.
        """
        if held is self.problem:
            return
        system, (start, *_) = self.machine.system, held.starts
        if not maps.reachable(held.free, held.goals)[start]:
            what = f"the map that the planner read wrong has no way from {held.named(start)} to a goal"
            raise MisreadMapError(what, system.planner.planning_task)
        with planner_code(system.planner):
            wrong = system.planner.check(replace(system.job, problem=held))
        if wrong is not None:
            raise MisreadMapError(
                f"of the map that the planner read wrong: {wrong[0]}: {wrong[1]}", system.planner.planning_task
            )
        self.problem = held

    def _perform(self, task: str, plan: Any) -> Generator[Any, Any, Any]:
        """Process generator: a task that is done by itself; returns what it makes."""
        system = self.machine.system
        style = system.placement.styles[task]
        steps = style.steps(replace(system.job, problem=self.problem, plan=plan, position=_position(self.problem)))
        return (yield from self.machine.perform(task, steps, self.ledger, priority=PLANNING))

    def make_start(self) -> Generator[Any, Any, Any]:
        """Process generator: the start that task ``lower_bound`` makes, brought to the planning task."""
        yield from self.load(LOWER_BOUND)
        start = yield from self._perform(LOWER_BOUND, None)
        self.machine.follow_up(LOWER_BOUND)
        yield from self.carry(LOWER_BOUND, self.machine.system.planner.planning_task)
        return start

    def make_plan(self, start: Any, memo: Memo | None, *, detail: bool) -> Generator[Any, Any, Any]:
        """Process generator: the plan."""
        system, placement = self.machine.system, self.machine.system.placement
        apart = set(placement.places) - placement.inside
        job = replace(
            system.job,
            problem=self.problem,
            inside=placement.inside - self._left_out,
            memo=memo,
            detail=detail or DETECT in apart,
            start=start,
        )
        steps = system.architecture.work(job)
        return (yield from self.machine.plan(steps, self.ledger))

    def tell(self, plan: Any) -> Generator[Any, Any, None]:
        """Process generator: every task between the planning task and ``command``, with the messages between them."""
        machine, system = self.machine, self.machine.system
        planner, placement = system.planner, system.placement
        self._flows = self._done_here(
            planner.flows_after(replace(system.job, problem=self.problem, plan=plan, memo=self._memo))
        )
        done = [planner.planning_task]
        for task in self._flows.order:
            if task in {*done, LOAD, LOWER_BOUND, DETECT} or task not in planner.tasks:
                continue
            for sender in done:
                yield from self.carry(sender, task)
            done.append(task)
            if task in self._left_out:
                continue
            if task not in placement.inside:
                yield from self._perform(task, plan)
            machine.follow_up(task)
        if not self._to_command:
            return
        for sender in done:
            yield from self.carry(sender, COMMAND)
        machine.follow_up(COMMAND)


def _position(problem: Any) -> tuple[float, float]:
    """The cell of the robot: the problem's first start, of a problem with cells for starts."""
    if not isinstance(problem, Problem) or not problem.starts:
        return 0.0, 0.0
    row, column = problem.starts[0]
    return float(row), float(column)
