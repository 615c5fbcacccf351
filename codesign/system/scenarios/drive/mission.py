"""A drive from begin to end, and the watchdogs that make it end."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Generator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import simpy
from numpy.typing import NDArray

from codesign.components import PreemptedError
from codesign.components.command import Command
from codesign.components.path import Polyline, authority, join, starts_clear
from codesign.ground.errors import InputError, RunError
from codesign.ground.memo import Memo
from codesign.ground.records import CommandRecord, PlanRecord, TrajectoryRecord
from codesign.ground.units import PICOSECONDS_PER_SECOND, format_time
from codesign.inputs.scenario import Drive, ReplanPolicy, ReplanTrigger, WhenBusy
from codesign.planners.interface import COMMAND, LOAD, POSE, Problem
from codesign.planners.job import Flow
from codesign.planners.styles import Step
from codesign.system.bind import planner_code
from codesign.system.build import CONTROL, SIDE, Machine
from codesign.system.chain import CHANGE_BITS, Answer, MisreadMapError, SentMap, plan_chain
from codesign.system.messages import Content, LostMessageError
from codesign.system.place import DISPLAY, RENDER_KERNEL
from codesign.system.results.ledger import Ledger, Spent
from codesign.system.scenario import MissionProgress, ProgressOfMission
from codesign.system.scenarios.drive.goals import FrontierGoals, Goals, Tour
from codesign.system.scenarios.drive.log import Fate, Log, PlanRequest, Sight, livelock_text
from codesign.system.scenarios.drive.scene import Look, Scene
from codesign.system.scenarios.drive.tasks import FOLLOWING, MOVE, OCCUPANCY, SEEN, SENSE
from codesign.system.scenarios.drive.world.belief import Update
from codesign.system.scenarios.scenario import tell_field

# The plan that a robot follows, and the path that it makes of it.

OFF_PATH = 1.0
"""Cells: a robot farther than this from its path gets a new path of the same plan."""


class ActivePlan:
    """The plan that the robot follows, and the path that it makes of it.

    Args:
        answer: the plan.
        planner: the one that made it.
        position: where its path begins.
        again: whether a decision is asked for at every turn (``planners.interface.POSE``). The plan is then asked for
            another path where the robot was seen off this one. Otherwise the answer was sent once, and only this path
            of the plan is known here.
        number: which plan of the drive it is, from 1.
    """

    def __init__(
        self, answer: Answer, planner: Any, position: tuple[float, float], *, again: bool, number: int = 1
    ) -> None:
        self.answer, self.number = answer, number
        self._planner, self._again = planner, again
        self.path, self.arrives = self._make(position)

    def from_here(self, position: tuple[float, float], passable: NDArray[np.bool_]) -> Polyline:
        """The path from ``position``. The plan makes a new one where the robot is off it and the plan can be asked."""
        if self._again and self.path.closest(position)[1] > OFF_PATH:
            self.path, self.arrives = self._make(position)
        return join(self.path, position, passable)

    @property
    def target(self) -> tuple[int, int]:
        """The cell in which the path ends."""
        row, column = self.path.points[-1]
        return round(float(row)), round(float(column))

    def lost(self, position: tuple[float, float], passable: NDArray[np.bool_]) -> bool:
        """True if the plan knows no path from ``position``, which is not where it was planned from."""
        if not self._again:
            off = self.path.closest(position)[1] > OFF_PATH
            return off and not starts_clear(join(self.path, position, passable), passable)
        return not self.arrives and self.path.length == 0.0 and self.target != self.answer.problem.starts[0]

    def _make(self, position: tuple[float, float]) -> tuple[Polyline, bool]:
        """The path from ``position``; else from where the plan begins: the robot left that while the plan was made."""
        problem = self.answer.problem
        points, arrives = self._ask(position)
        if not arrives and len(points) == 1:
            row, column = problem.starts[0]
            begun = self._ask((float(row), float(column)))
            if Polyline(begun[0]).closest(position)[1] <= OFF_PATH:
                points, arrives = begun
        return Polyline(around_corners(points, problem.free)), arrives

    def _ask(self, position: tuple[float, float]) -> tuple[NDArray[np.float64], bool]:
        """The planner's path from a position.

        Raises:
            RunError: the planner gives no path.
        """
        with planner_code(self._planner):
            given, arrives = self._planner.path_from(self.answer.problem, self.answer.plan, position)
            points = np.asarray(given, np.float64)
            if points.ndim != 2 or points.shape[1] != 2 or not len(points) or not np.isfinite(points).all():
                raise ValueError("its way is not n × 2 finite numbers, n at least 1")
            if not bool(((points >= -0.5) & (points <= np.array(self.answer.problem.free.shape) - 0.5)).all()):
                raise ValueError("its way leaves the map")
            return points, bool(arrives)


def around_corners(points: NDArray[np.float64], free: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The path with every diagonal step past one obstacle led through the free cell beside it.

    Planners on eight neighbours may pass the corner of an obstacle; a robot would touch it. ``points``: float64 n × 2;
    only steps between the middles of two cells are looked at.
    """
    cells = np.rint(points).astype(np.int64)
    whole = np.abs(points - cells).max(axis=1) < 1e-9
    diagonal = (np.abs(np.diff(cells, axis=0)) == 1).all(axis=1) & whole[:-1] & whole[1:]
    bent = [points[0]]
    for index in range(len(points) - 1):
        if diagonal[index]:
            (row, column), (next_row, next_column) = cells[index], cells[index + 1]
            by_row, by_column = free[next_row, column], free[row, next_column]
            if by_row != by_column:
                bent.append(np.array((next_row, column) if by_row else (row, next_column), np.float64))
        bent.append(points[index + 1])
    return np.array(bent)


# How long a drive may become at most.

EVENTS_OF_A_TURN = 20
"""Events that a turn of the control loop counts for: its scan and its path take about as long as so many messages."""

LONG_DRIVE = 36_001
"""Turns of the longest drive by default: an hour, ten turns a second, the first at 0. Measured: half a minute on a map
of 16 × 16 cells."""


def longest_turns(scenario: Drive) -> int:
    """Turns of the control loop by which a drive has ended: at its limit, or by its events."""
    by_events = scenario.events // EVENTS_OF_A_TURN
    return min(scenario.limit // scenario.control_period, by_events) + 1


def outlook(scenario: Drive) -> str | None:
    """A warning that a drive may become long, for before it begins; None where it becomes no longer than usual."""
    if longest_turns(scenario) <= LONG_DRIVE:
        return None
    seconds = f"{scenario.limit / PICOSECONDS_PER_SECOND:,.10g} s of simulated time"
    return (
        f"a long drive: it may take {longest_turns(scenario):,} turns of the control loop, and ends after {seconds}"
        f" or {scenario.events:,} events at the latest; a lower scenario.limit or scenario.events ends it sooner"
    )


# Plans of a drive: made beside the control loop, one at a time, each from what the robot believes at its begin.


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


# The control loop of a drive: one turn each control period, from a scan to a command.

SPARE_CELLS = 2.0
"""Cells of the path beyond those that the robot drives until an answer is overdue and it stands: assumed."""


STANDS = 1e-3
"""Cells: with less authority than this a robot is taken to stand."""


@dataclass
class Turn:
    """A turn of the control loop, begun at ``begin`` (ps); ``answered`` once nothing more is to come of it.

    ``lost``: a message of it was lost. ``spent``: where its time went. ``plan``: the plan by which it decides and
    commands: the one that was active when it asked.
    """

    begin: int
    plan: ActivePlan | None = None
    answered: bool = False
    lost: bool = False
    spent: Ledger = field(default_factory=Ledger)


class Pilot:
    """Makes the turns, and asks for plans. ``turn``: the latest."""

    def __init__(self, machine: Machine, scene: Scene, goals: Goals, replanner: Replanner, log: Log) -> None:
        self.machine, self.scene, self.goals = machine, scene, goals
        self.replanner, self.log = replanner, log
        graph, planner = machine.system.placement.graph, machine.system.planner
        self._graph = graph
        self._pose = next((flow for flow in graph.flows if flow.name == POSE), None)
        self._steps: tuple[ActivePlan, list[Step]] | None = None
        horizon = planner.horizon(machine.system.job)
        self._lookahead = self._reach() if horizon is None else min(self._reach(), float(horizon))
        self._begun = False
        self._unsent = 0
        self.turn: Turn | None = None

    def run(self) -> Generator[Any, Any, None]:
        """Process generator: turn after turn. A turn that takes longer than the period replaces later ones."""
        machine, period = self.machine, self.scene.scenario.control_period
        while True:
            before, turn = self.turn, Turn(machine.now)
            if before is not None and self.scene.moved_since(before.begin):
                self.log.stall = ""
            self.turn = turn
            self.log.turns += 1
            machine.environment.process(self._watch(turn))
            try:
                yield from self._turn(turn)
            except LostMessageError as lost:
                turn.lost = True
                self.log.stall = f"{lost.where}: {lost.what}"
            self.log.turns_spent.add(turn.spent)
            yield machine.environment.timeout((machine.now // period + 1) * period - machine.now)

    def _watch(self, turn: Turn) -> Generator[Any, Any, None]:
        """Process generator: the robot's own clock. One picosecond after the deadline is too late."""
        yield self.machine.environment.timeout(self.scene.scenario.deadline + 1)
        if turn.answered or self.log.ended is not None:
            return
        self.log.missed += 1
        deadline = self.scene.scenario.deadline / PICOSECONDS_PER_SECOND
        text = f"the turn of {turn.begin / PICOSECONDS_PER_SECOND:.6g} s had no answer within {deadline:g} s"
        self.log.tell("deadline_missed", text)
        if not turn.lost:
            self.log.stall = text
        self.scene.advance()
        robot = self.scene.robot
        before = robot.safety_stops
        if robot.speed > 0:
            robot.stop(self.machine.now)
        if robot.safety_stops > before:
            self.log.tell("safety_stop", text)

    def _turn(self, turn: Turn) -> Generator[Any, Any, None]:
        look = self.scene.look()
        self.machine.follow_up(SENSE)
        read = yield from self._carry(turn, SENSE, LOAD, content=self.scene.sent(look))
        look = read.look
        yield from self.machine.charge(LOAD, OCCUPANCY, look.scan.cells, turn.spent)
        update = self.scene.learn(look)
        self._unsent += len(update.changed)
        self._judge(update, Sight(turn.begin, turn.spent.copy()))
        self.machine.follow_up(LOAD)
        turn.plan = self.replanner.active
        if turn.plan is None or self.log.ended is not None:
            turn.answered = True
            return
        if self._pose is not None:
            yield from self._decide(turn, turn.plan, look, self._pose)
        yield from self._carry(turn, LOAD, COMMAND)
        self._unsent = 0
        yield from self.machine.charge(COMMAND, FOLLOWING, 1, turn.spent)
        command = self._command(turn.plan, look)
        composed = self.machine.now
        self.machine.follow_up(COMMAND)
        if DISPLAY in self.machine.system.placement.places:
            self.machine.environment.process(self._show())
        command = yield from self._carry(turn, COMMAND, MOVE, content=command)
        self._tell_command(command, turn.plan, look, composed)
        self.scene.obey(command)
        turn.answered = True
        self.machine.follow_up(MOVE)

    def _decide(self, turn: Turn, plan: ActivePlan, look: Look, pose: Flow) -> Generator[Any, Any, None]:
        """Ask for the decision where the robot was seen, wherever it is made."""
        placement = self.machine.system.placement
        yield from self.machine.carry(pose, turn.spent)
        task = pose.receiver
        if task in placement.styles:
            steps = self._decision_steps(task, plan, look)
            yield from self.machine.perform(task, steps, turn.spent)
            self.machine.follow_up(task)
        yield from self._carry(turn, task, COMMAND)

    def _decision_steps(self, task: str, active: ActivePlan, look: Look) -> Generator[Step, None, None]:
        """The steps of a decision. All decisions of a plan cost the same, so the steps are computed once a plan."""
        if self._steps is None or self._steps[0] is not active:
            system = self.machine.system
            style = system.placement.styles[task]
            answer = active.answer
            job = replace(system.job, problem=answer.problem, plan=answer.plan, position=look.position)
            self._steps = active, [*style.again(job)]
        yield from self._steps[1]

    def _judge(self, update: Update, sight: Sight) -> None:
        """Act on what was learnt: the first map, a goal reached, a path lost, anything new."""
        scene, replanner, active = self.scene, self.replanner, self.replanner.active
        if not self._begun:
            self._begun = True
            if not self.goals.end_if_over(self.log):
                replanner.request(sight, "the first plan", seen=False)
        elif self.goals.waiting:
            if self.goals.given():
                replanner.request(sight, "the next goal", seen=False)
        elif self.goals.arrived():
            self.log.goals_reached += 1
            self.log.tell("goal_reached", f"goal {self.goals.done} at {scene.named(scene.latest_look.cell)}")
            if not self.goals.end_if_over(self.log) and not self.goals.waiting:
                replanner.request(sight, "the next goal", seen=False)
        elif active is not None and self._is_lost(active) and not replanner.busy:
            replanner.request(sight, "the robot has left the way", seen=False)
        elif update:
            replanner.learnt(sight)

    def _is_lost(self, active: ActivePlan) -> bool:
        """True if the robot was seen where the plan knows no path."""
        look = self.scene.latest_look
        return active.lost(look.position, self.scene.belief.planning_free(look.cell))

    def _command(self, plan: ActivePlan, look: Look) -> Command:
        """The command to the robot, from what is known now: the path from where it was seen, and how far to go."""
        belief = self.scene.belief
        free = belief.known_free(look.cell)
        path = plan.from_here(look.position, free).head(self._lookahead)
        end = authority(path, free)
        if end < STANDS and path.length > STANDS:
            closed = path.first_closed(belief.planning_free(look.cell), 1) >= 0
            why = "leads through or between obstacles" if closed else "was never seen to be free"
            self.log.stall = f"the next cell on the way from {self.scene.named(look.cell)} {why}"
        return Command(path, end, self.scene.resolution)

    def _tell_command(self, command: Command, plan: ActivePlan, look: Look, composed: int) -> None:
        machine = self.machine
        if machine.wants(CommandRecord):
            name, sent = self.scene.robot.name, (plan.number, look.at, composed)
            machine.tell(CommandRecord(machine.now, name, *sent, command.path.points, command.end))

    def _show(self) -> Generator[Any, Any, None]:
        """Process generator: where the robot was seen goes to the display; nothing waits for it."""
        try:
            yield from self._carry(Turn(self.machine.now), COMMAND, DISPLAY, priority=SIDE)
        except LostMessageError:
            return
        yield from self.machine.charge(DISPLAY, RENDER_KERNEL, 1, priority=SIDE)
        self.machine.follow_up(DISPLAY)

    def _carry(
        self, turn: Turn, sender: str, receiver: str, *, priority: int = CONTROL, content: Content | None = None
    ) -> Generator[Any, Any, Any]:
        """Process generator: the messages from one task to another in a turn; returns ``content`` as it is read."""
        for flow in self._graph.between(sender, receiver):
            bits = flow.bits + (CHANGE_BITS * self._unsent if flow.name == SEEN else 0)
            content = yield from self.machine.carry(flow, turn.spent, bits=bits, priority=priority, content=content)
        return content

    def _reach(self) -> float:
        """Cells of the path that a command covers: until an answer is overdue, to brake from there, and some more."""
        scene = self.scene
        kinematics = scene.robot.kinematics
        seconds = (scene.scenario.control_period + scene.scenario.deadline) / PICOSECONDS_PER_SECOND
        return kinematics.speed * seconds + kinematics.braking + SPARE_CELLS


_STEPS_BETWEEN_CALLS = 256
"""Steps of the simulation between two calls of ``progress``."""


@dataclass(frozen=True, eq=False)
class FinishedDrive:
    """A drive that has ended: its scene at the end, its log, and how many events it had (see ``_events_of``)."""

    scene: Scene
    log: Log
    events: int


def _events_of(replanner: Replanner) -> int:
    """Events of the mission up to now: messages, plans asked for, changes of the world, and turns, which count more.

    Events of the simulation are not counted: a plan makes the more of them the finer it is simulated.
    """
    log, scene = replanner.log, replanner.scene
    return replanner.machine.messages_sent + log.asked + scene.changed + EVENTS_OF_A_TURN * log.turns


def drive(machine: Machine, memo: Memo | None = None, progress: ProgressOfMission | None = None) -> FinishedDrive:
    """Let the robot drive until the mission ends. It always ends, and states why.

    ``progress`` is called now and then.
    """
    scene = Scene(machine)
    scenario, log = scene.scenario, Log(scene)
    goals = FrontierGoals(scene) if scenario.purpose == "explore" else Tour(scene)
    replanner = Replanner(machine, scene, goals, log, memo)
    pilot = Pilot(machine, scene, goals, replanner, log)
    environment = machine.environment
    environment.process(scene.changes())
    environment.process(pilot.run())
    environment.process(_patience(replanner, pilot))
    steps = 0
    while log.ended is None:
        now_is_over = environment.peek() > machine.now
        if environment.peek() > scenario.limit:
            if machine.now < scenario.limit:
                # The last event lies where the granularity put it; the mission ends at the limit itself.
                environment.run(until=scenario.limit)
            why = _because(replanner, pilot)
            log.end(f"the limit of {scenario.limit / PICOSECONDS_PER_SECOND:g} s of simulated time was reached{why}")
        elif now_is_over and _events_of(replanner) >= scenario.events:
            why = _because(replanner, pilot)
            log.end(f"the limit of {scenario.events:,} events was reached{why}")
        else:
            try:
                environment.step()
            except RunError as failed:
                log.end(failed.what)
            steps += 1
            if progress is not None and steps % _STEPS_BETWEEN_CALLS == 0:
                events = _events_of(replanner)
                progress(MissionProgress(machine.now, scenario.limit, events, scenario.events, log.turns))
    scene.advance()
    if pilot.turn is None or pilot.turn.begin < replanner.machine.now:
        scene.tell_pose()
    replanner.end()
    return FinishedDrive(scene, log, _events_of(replanner))


def _patience(replanner: Replanner, pilot: Pilot) -> Generator[Any, Any, None]:
    """Process generator: end the mission once the robot has stood for too long without a plan under way."""
    machine, scene, log = replanner.machine, replanner.scene, replanner.log
    patience = scene.scenario.patience
    while log.ended is None:
        scene.advance()
        if replanner.busy:
            log.progress = machine.now
        due = max(log.progress, scene.robot.stood_since, pilot.goals.since) + patience
        if machine.now >= due:
            why = _because(replanner, pilot)
            log.end(f"the robot has stood for {patience / PICOSECONDS_PER_SECOND:g} s{why}")
            return
        yield machine.environment.timeout(due - machine.now)


def _because(replanner: Replanner, pilot: Pilot) -> str:
    """The cause that kept the robot from its goals, if it is known."""
    active, turn = replanner.active, pilot.turn
    why = livelock_text(replanner.request_under_way) or replanner.refusal or replanner.log.stall
    if not why and replanner.busy:
        why = "a plan is under way"
    elif not why and active is not None and not active.arrives:
        why = f"the plan's way ends at {active.target}, short of the goal"
    elif not why and replanner.scene.pressed is not None:
        why = f"it stands against an obstacle at {replanner.scene.pressed} that it does not see"
    elif not why and turn is not None and not turn.answered and turn.begin < replanner.machine.now:
        why = f"the turn of {turn.begin / PICOSECONDS_PER_SECOND:g} s has had no answer"
    return f": {why}" if why else ""
