"""Plans of a drive: made beside the control loop, one at a time, each from what the robot believes at its begin."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Generator
from contextlib import suppress
from dataclasses import replace
from typing import Any

import simpy

from codesign.components import PreemptedError
from codesign.ground.errors import InputError, RunError
from codesign.ground.memo import Memo
from codesign.ground.records import PlanRecord, TrajectoryRecord
from codesign.ground.units import format_time
from codesign.inputs.scenario import ReplanPolicy, ReplanTrigger, WhenBusy
from codesign.planners.interface import POSE, Problem
from codesign.system.bind import planner_code
from codesign.system.build import Machine
from codesign.system.chain import Answer, MisreadMapError, plan_chain
from codesign.system.messages import LostMessageError
from codesign.system.results.ledger import Spent
from codesign.system.scenarios.drive.active import ActivePlan
from codesign.system.scenarios.drive.goals import Goals
from codesign.system.scenarios.drive.log import Log
from codesign.system.scenarios.drive.request import Fate, PlanRequest, Sight
from codesign.system.scenarios.drive.scene import Look, Scene
from codesign.system.scenarios.records import tell_field
from codesign.system.sent_map import SentMap


class Replanner:
    """Makes plans. ``active``: the one that the robot follows.

    ``request_under_way``: the one that is being answered, or asked again after a pause.
    ``unanswered``: the last request where it could not be answered, and ``refusal`` why; None where it was. It is asked
    again when more is known.
    """

    def __init__(self, machine: Machine, scene: Scene, goals: Goals, log: Log, memo: Memo | None) -> None:
        self.machine, self.scene, self.goals, self.log, self._memo = machine, scene, goals, log, memo
        self.active: ActivePlan | None = None
        self._since: tuple[int, int] | None = None
        self.unanswered: PlanRequest | None = None
        self.refusal: str | None = None
        self._sent = defaultdict[str, SentMap](SentMap)
        self._unseen: Sight | None = None
        self._pending: PlanRequest | None = None
        self.request_under_way: PlanRequest | None = None
        self._wake = machine.environment.event()
        self._again = any(flow.name == POSE for flow in machine.system.placement.graph.flows)
        self._policy = scene.scenario.replan.policy or ReplanPolicy(machine.system.planner.policies[0])
        self.process = machine.environment.process(self._run())

    @property
    def busy(self) -> bool:
        """True if a plan is under way."""
        return self._since is not None

    def request(self, sight: Sight, why: str, *, seen: bool) -> None:
        """Ask for a plan. A request that waits already is answered from what is known when its turn comes."""
        if self._pending is not None:
            return
        self._ask(PlanRequest(sight, why, seen))

    def _ask(self, request: PlanRequest) -> None:
        self._pending = request
        self.log.asked += 1
        self.log.tell("plan_requested", request.why)
        if self.busy and self.scene.scenario.replan.when_busy is WhenBusy.RESTART:
            self.process.interrupt("newer")
        elif not self._wake.triggered:
            self._wake.succeed()

    def ask_again(self, sight: Sight | None = None) -> None:
        """Try again what could not be planned; ``sight``: a newer scan, which shows another map."""
        if self.unanswered is not None:
            self.request(sight or self.unanswered.sight, self.unanswered.why, seen=self.unanswered.seen)

    def learnt(self, sight: Sight) -> None:
        """Something new was seen: ask for a plan where that calls for one.

        While a plan is under way that is to be finished, this is decided once that plan is made.
        """
        self.ask_again(sight)
        if self.busy and self.scene.scenario.replan.when_busy is WhenBusy.FINISH:
            self._unseen = self._unseen or sight
        else:
            self._look(sight)

    def _look(self, sight: Sight) -> None:
        active = self.active
        if active is None:
            return
        if self.scene.scenario.replan.trigger is ReplanTrigger.CHANGE:
            self.request(sight, "the map changed", seen=True)
        elif self._blocked(active):
            self.request(sight, "the way is blocked", seen=True)
        elif self.goals.obsolete(active.target) and not self.goals.end_if_over(self.log):
            self.request(sight, "what lies beyond the frontier was seen", seen=True)

    def _blocked(self, active: ActivePlan) -> bool:
        """True if anything that is believed blocked lies on the rest of the path."""
        look = self.scene.latest_look
        free = self.scene.belief.planning_free(look.cell)
        return active.from_here(look.position, free).first_closed(free, 1) >= 0

    def _run(self) -> Generator[Any, Any, None]:
        while True:
            if self._pending is None:
                self._wake = self.machine.environment.event()
                yield from self._rest(self._wake)
            request, self._pending = self._pending, None
            if request is not None:
                self.request_under_way = request
                request.book_rest(Spent.BEHIND, self.machine.system.component, self.machine.now)
                yield from self._answer(request)
                self.request_under_way = None

    def _answer(self, request: PlanRequest) -> Generator[Any, Any, None]:
        try:
            problem = self._problem()
        except RunError as failed:
            problem = failed.what
        if isinstance(problem, str):
            self._refuse(request, problem)
            return
        scene, machine = self.scene, self.machine
        scene.advance()
        self._since = machine.now, scene.robot.moving
        asked = machine.now, scene.latest_look
        try:
            answer = yield from self._chain(problem)
        except (simpy.Interrupt, PreemptedError):
            # What the planner was sent may be half a map.
            self._sent.clear()
            request.book_rest(Spent.BROKEN_OFF, machine.system.component, machine.now)
            self._go_on(request)
            return
        except (LostMessageError, MisreadMapError) as lost:
            self._sent.clear()
            self._cannot(request, f"{lost.where}: {lost.what}")
            answer, where = None, lost.where or machine.system.component
        except (RunError, InputError) as failed:
            self._policy = ReplanPolicy.RESTART
            request.book_rest(Spent.FAILED, machine.system.component, machine.now)
            self._refuse(request, failed.what)
            return
        finally:
            self.settle()
            self._since = None
        if answer is None:
            # Not busy any more: a request made meanwhile has nothing to break off, and is answered after the pause.
            yield from self._rest(machine.environment.timeout(scene.scenario.control_period))
            request.book_rest(Spent.FAILED, where, machine.now)
            if self._pending is None:
                self._ask(request)
            else:
                self.log.close(request, Fate.REFUSED)
            return
        request.spent.add(answer.ledger)
        self.log.progress = machine.now
        try:
            active = self._active(answer, asked[1])
        except RunError as failed:
            self._refuse(request, failed.what)
            return
        self._tell_plan(active, *asked)
        self._install(request, active)

    def _active(self, answer: Answer, asked: Look) -> ActivePlan:
        """The plan as task ``command`` knows it; ``asked``: the last look when it was asked for."""
        look = self.scene.latest_look if self._again else asked
        planner, number = self.machine.system.planner, self.log.plans + 1
        return ActivePlan(answer, planner, look.position, again=self._again, number=number)

    def _tell_plan(self, active: ActivePlan, asked: int, look: Look) -> None:
        machine, answer = self.machine, active.answer
        if machine.listening:
            times = {"asked": asked, "seen": look.at, "loaded": answer.loaded, "planned": answer.planned}
            machine.tell(PlanRecord(machine.now, machine.system.component, active.number, **times))

    def _go_on(self, request: PlanRequest) -> None:
        """Ask again for the plan that was broken off; the request that broke it off is part of it from now on."""
        newer, self._pending = self._pending, request
        if newer is not None:
            request.why = newer.why
            self.log.close(newer, Fate.MERGED)
        self.log.break_off(request)
        self.log.progress = self.machine.now

    def end(self) -> None:
        """The mission is over: book what is open."""
        self.settle()
        now, where = self.machine.now, self.machine.system.component
        if self.request_under_way is not None:
            kind = Spent.UNFINISHED if self.busy else Spent.FAILED
            self.request_under_way.book_rest(kind, where, now)
            self.log.close(self.request_under_way, Fate.OPEN)
        if self._pending is not None:
            self._pending.book_rest(Spent.BEHIND, where, now)
            self.log.close(self._pending, Fate.OPEN)

    def settle(self) -> None:
        """Book the waiting for a plan under way up to now: when it is made, or when the mission ends without it."""
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
            with planner_code(planner):
                start = planner.start_of(self.active.answer.plan)
        return (
            yield from plan_chain(
                self.machine,
                problem,
                memo=self._memo,
                start=start,
                warm=None if first else policy is ReplanPolicy.LOWER_BOUND,
                sent=self._sent,
                preemptible=self.scene.scenario.replan.when_busy is WhenBusy.RESTART,
            )
        )

    def _problem(self) -> Problem | str:
        """The problem to plan now, or why there is none."""
        system, scene = self.machine.system, self.scene
        here = scene.latest_look.cell
        goals = self.goals.goals()
        if not goals:
            return self.goals.none_left()
        free = scene.belief.planning_free(here)
        problem = replace(
            system.problem,
            free=free,
            goals=tuple(goals),
            starts=(here,),
            resolution=scene.resolution,
            optimal_lengths=(),
        )
        with planner_code(system.planner):
            job = replace(system.job, problem=problem)
            if not system.planner.reachable(job)[here]:
                return f"no way leads from {scene.named(here)} to a goal in what the robot knows"
            wrong = system.planner.check(job)
        return problem if wrong is None else f"{wrong[0]}: {wrong[1]}"

    def _refuse(self, request: PlanRequest, why: str) -> None:
        self._cannot(request, why)
        self.log.close(request, Fate.REFUSED)

    def _cannot(self, request: PlanRequest, why: str) -> None:
        self.unanswered, self.refusal = request, why
        self.log.tell("no_way", why)

    def _rest(self, until: simpy.Event) -> Generator[Any, Any, None]:
        """Process generator: wait; a plan that is broken off at the moment it is made wakes what comes after it."""
        with suppress(simpy.Interrupt):
            yield until

    def _install(self, request: PlanRequest, active: ActivePlan) -> None:
        machine, log, answer = self.machine, self.log, active.answer
        self.unanswered = self.refusal = None
        self.active = active
        latency = answer.answered - request.sight.at
        log.plans += 1
        log.first, log.last = log.first or answer, answer
        log.close(request, Fate.ANSWERED)
        if request.seen:
            log.latencies.append(latency)
        if machine.listening:
            # Recorded before the event `plan_ready`, at which traces show it.
            tell_field(machine, answer.plan)
        log.tell("plan_ready", f"{request.why}: answered after {format_time(latency)}")
        if machine.listening:
            name = self.scene.robot.name
            machine.tell(TrajectoryRecord(machine.now, name, active.path.points, active.arrives))
        sight, self._unseen = self._unseen, None
        if sight is not None:
            self._look(sight)
