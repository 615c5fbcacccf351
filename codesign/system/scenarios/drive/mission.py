"""A drive from begin to end, and the watchdogs that make it end."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

from codesign.ground.errors import RunError
from codesign.ground.memo import Memo
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.system.build import Machine
from codesign.system.scenario import MissionProgress, ProgressOfMission
from codesign.system.scenarios.drive.goals import FrontierGoals, Tour
from codesign.system.scenarios.drive.log import Log
from codesign.system.scenarios.drive.pilot import Pilot
from codesign.system.scenarios.drive.progress import EVENTS_OF_A_TURN
from codesign.system.scenarios.drive.replanner import Replanner
from codesign.system.scenarios.drive.request import livelock_text
from codesign.system.scenarios.drive.scene import Scene

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
    """What kept the robot from its goals, where that is known."""
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
