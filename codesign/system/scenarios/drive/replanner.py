"""Plans of a drive: made beside the control loop, one at a time, from what the robot believes when each begins."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import simpy
from numpy.typing import NDArray

from codesign import maps
from codesign.components import PreemptedError
from codesign.components.way import Way, join
from codesign.errors import InputError, RunError
from codesign.memo import Memo
from codesign.planners.interface import Problem
from codesign.records import TrajectoryRecord
from codesign.spec.scenario import ReplanPolicy, ReplanTrigger, WhenBusy
from codesign.system.build import LostMessageError
from codesign.system.chain import Answer, plan_chain
from codesign.system.scenarios.drive.goals import Goals
from codesign.system.scenarios.drive.log import Log
from codesign.system.scenarios.drive.scene import Scene
from codesign.system.scenarios.plan_once import tell_field
from codesign.units import format_time

if TYPE_CHECKING:
    from codesign.system.build import Machine

OFF_WAY = 1.0
"""Cells: a robot farther than this from its plan's way is given a new way of the same plan."""


@dataclass(frozen=True)
class Request:
    """A plan that is asked for: since the scan at ``since`` (ps), ``why``, and whether something ``seen`` is why."""

    since: int
    why: str
    seen: bool


class ActivePlan:
    """The plan that the robot follows, and the way it makes from where the robot was."""

    def __init__(self, answer: Answer, planner: Any, position: tuple[float, float]) -> None:
        self.answer = answer
        self._planner = planner
        self.way, self.arrives = self._make(position)

    def from_here(self, position: tuple[float, float], passable: Any) -> Way:
        """The way from ``position``; made anew by the same plan where the robot is off it."""
        points = self.way.points
        if _distance_to(points, position) > OFF_WAY:
            self.way, self.arrives = self._make(position)
        return join(self.way, position, passable)

    @property
    def target(self) -> tuple[int, int]:
        """The cell in which the way ends."""
        row, column = self.way.points[-1]
        return round(float(row)), round(float(column))

    @property
    def lost(self) -> bool:
        """Whether the plan knows no way from where the robot was, which is elsewhere than where it was planned from."""
        return not self.arrives and self.way.length == 0.0 and self.target != self.answer.problem.starts[0]

    def _make(self, position: tuple[float, float]) -> tuple[Way, bool]:
        """The way from ``position``, or else from where the plan begins, which the robot left while it was made."""
        problem, plan = self.answer.problem, self.answer.plan
        points, arrives = self._planner.way(problem, plan, position)
        if not arrives and len(points) == 1:
            row, column = problem.starts[0]
            begun = self._planner.way(problem, plan, (float(row), float(column)))
            if _distance_to(begun[0], position) <= OFF_WAY:
                points, arrives = begun
        return Way(around_corners(points, problem.free)), bool(arrives)


class Replanner:
    """Makes plans. ``active``: the one that the robot follows. ``busy``: whether one is under way.

    ``no_way``: the last request where it could not be answered, and ``refusal`` why; None where it was. It is asked
    again when more is known.
    """

    def __init__(self, machine: Machine, scene: Scene, goals: Goals, log: Log, memo: Memo | None) -> None:
        self.machine, self.scene, self.goals, self.log, self._memo = machine, scene, goals, log, memo
        self.active: ActivePlan | None = None
        self.busy = False
        self._since: tuple[int, int] | None = None
        self.no_way: Request | None = None
        self.refusal: str | None = None
        self._sent: Problem | None = None
        self._unseen: int | None = None
        self._pending: Request | None = None
        self._wake = machine.environment.event()
        self._policy = scene.scenario.replan.policy or ReplanPolicy(machine.system.planner.policies[0])
        self.process = machine.environment.process(self._run())

    def request(self, since: int, why: str, *, seen: bool) -> None:
        """Ask for a plan; one that waits already is made from what is known when its turn comes."""
        if self._pending is not None:
            return
        self._pending = Request(since, why, seen)
        self.log.tell("plan_requested", why)
        if self.busy and self.scene.scenario.replan.when_busy is WhenBusy.RESTART:
            self.process.interrupt("newer")
        elif not self._wake.triggered:
            self._wake.succeed()

    def ask_again(self, since: int | None = None) -> None:
        """Try again what could not be planned; ``since``: from a newer scan on, which shows another map."""
        if self.no_way is not None:
            begun = self.no_way.since if since is None else since
            self.request(begun, self.no_way.why, seen=self.no_way.seen)

    def learnt(self, seen_at: int) -> None:
        """Something new was seen by the scan at ``seen_at`` (ps): ask for a plan where that calls for one.

        While one is under way that is to be finished, it is looked at once that stands.
        """
        self.ask_again(seen_at)
        if self.busy and self.scene.scenario.replan.when_busy is WhenBusy.FINISH:
            self._unseen = seen_at if self._unseen is None else self._unseen
        else:
            self._look(seen_at)

    def _look(self, seen_at: int) -> None:
        active = self.active
        if active is None:
            return
        if self.scene.scenario.replan.trigger is ReplanTrigger.CHANGE:
            self.request(seen_at, "the map changed", seen=True)
        elif self._blocked(active):
            self.request(seen_at, "the way is blocked", seen=True)
        elif self.goals.obsolete(active.target) and not self.goals.end_if_over(self.log):
            self.request(seen_at, "what lies beyond the frontier was seen", seen=True)

    def _blocked(self, active: ActivePlan) -> bool:
        """Whether anything believed blocked lies on what is left of the way."""
        position = self.scene.robot.position
        free = self.scene.belief.planning_free(self.scene.robot.cell)
        return active.from_here(position, free).first_closed(free, 1) >= 0

    def _run(self) -> Generator[Any, Any, None]:
        while True:
            if self._pending is None:
                self._wake = self.machine.environment.event()
                yield from self._rest(self._wake)
            request, self._pending = self._pending, None
            if request is not None:
                yield from self._answer(request)

    def _answer(self, request: Request) -> Generator[Any, Any, None]:
        problem = self._problem()
        if isinstance(problem, str):
            self._cannot(request, problem)
            return
        scene, machine = self.scene, self.machine
        scene.advance()
        self.busy, self._since = True, (machine.now, scene.robot.moving)
        try:
            answer = yield from self._chain(problem)
        except (simpy.Interrupt, PreemptedError):
            # The request that broke this one off stands for both; what it was sent may be half a map.
            self._sent = None
            if self._pending is not None:
                self._pending = Request(
                    min(request.since, self._pending.since), self._pending.why, request.seen
                )
            return
        except LostMessageError as lost:
            self._sent = None
            self._cannot(request, f"{lost.where}: {lost.what}")
            answer = None
        except (RunError, InputError) as failed:
            self._policy = ReplanPolicy.RESTART
            self._cannot(request, failed.what)
            return
        finally:
            self.settle()
            self.busy, self._since = False, None
        if answer is None:
            # Not busy any more: whoever asks meanwhile finds nothing to break off, and is answered after the pause.
            yield from self._rest(machine.environment.timeout(scene.scenario.control_period))
            self.ask_again()
        else:
            self._install(request, answer)

    def settle(self) -> None:
        """Book the waiting for a plan under way up to now: when it stands, or when the mission ends without it."""
        if self._since is None:
            return
        self.scene.advance()
        now, moving = self.machine.now, self.scene.robot.moving
        self.log.waiting += now - self._since[0] - (moving - self._since[1])
        self._since = now, moving

    def _chain(self, problem: Problem) -> Generator[Any, Any, Answer]:
        planner, policy = self.machine.system.planner, self._policy
        first = self.active is None
        start = None
        if policy is ReplanPolicy.CONTINUE and self.active is not None:
            start = planner.start_of(self.active.answer.plan)
        changed = None if self._sent is None else _changes(self._sent, problem)
        self._sent = problem
        return (
            yield from plan_chain(
                self.machine,
                problem,
                memo=self._memo,
                start=start,
                warm=first or policy is ReplanPolicy.LOWER_BOUND,
                changed=changed,
                preemptible=self.scene.scenario.replan.when_busy is WhenBusy.RESTART,
            )
        )

    def _problem(self) -> Problem | str:
        """What is to be planned now, or why nothing can be."""
        system, scene = self.machine.system, self.scene
        scene.advance()
        here = scene.robot.cell
        goals = self.goals.goals()
        if not goals:
            return self.goals.none_left()
        free = scene.belief.planning_free(here)
        if not maps.reachable(free, goals)[here]:
            return f"no way leads from {here} to a goal in what the robot knows"
        problem = Problem(free=free, goals=tuple(goals), starts=(here,), resolution=scene.resolution)
        wrong = system.planner.check(problem, system.planning)
        return problem if wrong is None else f"{wrong[0]}: {wrong[1]}"

    def _cannot(self, request: Request, why: str) -> None:
        self.no_way, self.refusal = request, why
        self.log.tell("no_way", why)

    def _rest(self, until: simpy.Event) -> Generator[Any, Any, None]:
        """Process generator: wait; a plan that is broken off at the moment it stands wakes what comes after it."""
        with suppress(simpy.Interrupt):
            yield until

    def _install(self, request: Request, answer: Answer) -> None:
        machine, log = self.machine, self.log
        self.no_way = self.refusal = None
        self.active = ActivePlan(answer, machine.system.planner, self.scene.robot.position)
        latency = answer.answered - request.since
        log.plans += 1
        log.first, log.last = log.first or answer, answer
        log.planning.add(answer.ledger)
        log.progress = machine.now
        if request.seen:
            log.latencies.append(latency)
        if machine.listening:
            # Told before the plan is said to be ready, which is when traces show it.
            tell_field(machine, answer.plan)
        log.tell("plan_ready", f"{request.why}: answered after {format_time(latency)}")
        if machine.listening:
            name = self.scene.robot.name
            machine.tell(TrajectoryRecord(machine.now, name, self.active.way.points, self.active.arrives))
        since, self._unseen = self._unseen, None
        if since is not None:
            self._look(since)


def _changes(before: Problem, after: Problem) -> int:
    """Cells that differ between two problems: free or not, goal or not."""
    return int(np.count_nonzero(before.free != after.free)) + len({*before.goals} ^ {*after.goals})


def around_corners(points: NDArray[np.float64], free: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The way with every diagonal step past one obstacle led through the free cell beside it.

    Planners on eight neighbours may pass the corner of an obstacle; a robot would touch it. ``points``: float64 n × 2,
    of which steps between the middles of two cells are looked at.
    """
    cells = np.rint(points).astype(np.int64)
    whole = np.abs(points - cells).max(axis=1) < 1e-9
    diagonal = (np.abs(np.diff(cells, axis=0)) == 1).all(axis=1) & whole[:-1] & whole[1:]
    made = [points[0]]
    for index in range(len(points) - 1):
        if diagonal[index]:
            (row, column), (next_row, next_column) = cells[index], cells[index + 1]
            by_row, by_column = free[next_row, column], free[row, next_column]
            if by_row != by_column:
                made.append(np.array((next_row, column) if by_row else (row, next_column), np.float64))
        made.append(points[index + 1])
    return np.array(made)


def _distance_to(points: Any, position: tuple[float, float]) -> float:
    """Distance from a position to a polyline, float64 n × 2."""
    if len(points) == 1:
        return float(np.hypot(*(points[0] - position)))
    base, moved = points[:-1], np.diff(points, axis=0)
    length = np.maximum((moved**2).sum(axis=1), 1e-300)
    share = np.clip(((np.asarray(position) - base) * moved).sum(axis=1) / length, 0.0, 1.0)
    return float(np.hypot(*(base + share[:, None] * moved - position).T).min())
