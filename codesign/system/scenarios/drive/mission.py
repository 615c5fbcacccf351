"""A drive from begin to end, and the watchdogs that make it end."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, field, replace
from typing import Any

from codesign.components.command import Command
from codesign.components.path import authority
from codesign.ground.errors import RunError
from codesign.ground.memo import Memo
from codesign.ground.records import CommandRecord
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.planners.interface import COMMAND, LOAD, POSE
from codesign.planners.styles import Step
from codesign.planners.task_graph import Flow
from codesign.system.build import CONTROL, SIDE, Machine
from codesign.system.messages import Content, LostMessageError
from codesign.system.place import DISPLAY, RENDER_KERNEL
from codesign.system.results.ledger import Ledger
from codesign.system.scenario import MissionProgress, ProgressOfMission
from codesign.system.scenarios.drive.active import ActivePlan
from codesign.system.scenarios.drive.goals import FrontierGoals, Goals, Tour
from codesign.system.scenarios.drive.log import Log
from codesign.system.scenarios.drive.progress import EVENTS_OF_A_TURN
from codesign.system.scenarios.drive.replanner import Replanner
from codesign.system.scenarios.drive.request import Sight, livelock_text
from codesign.system.scenarios.drive.scene import Look, Scene
from codesign.system.scenarios.drive.tasks import FOLLOWING, MOVE, OCCUPANCY, SEEN, SENSE
from codesign.system.scenarios.drive.world.belief import Update
from codesign.system.sent_map import CHANGE_BITS

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
