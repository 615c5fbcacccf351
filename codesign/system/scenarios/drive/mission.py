"""A drive from begin to end, and what watches that it ends."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from codesign.memo import Memo
from codesign.system.scenarios.drive.goals import Exploration, Tour
from codesign.system.scenarios.drive.log import Log
from codesign.system.scenarios.drive.pilot import Pilot
from codesign.system.scenarios.drive.replanner import Replanner
from codesign.system.scenarios.drive.scene import Scene

if TYPE_CHECKING:
    from codesign.system.build import Machine


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive that has ended: the scene as it was left, the log, and the events of the simulation it took."""

    scene: Scene
    log: Log
    events: int


def drive(machine: Machine, memo: Memo | None = None) -> Drive:
    """Let the robot drive until the mission ends, for a reason that is stated: it always does."""
    scene = Scene(machine)
    scenario, log = scene.scenario, Log(machine, scene.robot.name)
    goals = Exploration(scene) if scenario.purpose == "explore" else Tour(scene)
    replanner = Replanner(machine, scene, goals, log, memo)
    pilot = Pilot(machine, scene, goals, replanner, log)
    environment = machine.environment
    environment.process(scene.changes())
    environment.process(pilot.run())
    environment.process(_patience(machine, scenario.patience, log, replanner))
    events = 0
    while log.ended is None:
        if environment.peek() > scenario.limit:
            if machine.now < scenario.limit:
                # The last event lies where the granularity put it; the mission ends at the limit itself.
                environment.run(until=scenario.limit)
            log.end(
                f"the limit of {scenario.limit / 1e12:g} s of simulated time was reached{_because(log, replanner)}"
            )
        elif events >= scenario.events:
            log.end(f"the limit of {events:,} events was reached{_because(log, replanner)}")
        else:
            environment.step()
            events += 1
    scene.advance()
    replanner.settle()
    return Drive(scene, log, events)


def _patience(machine: Machine, patience: int, log: Log, replanner: Replanner) -> Generator[Any, Any, None]:
    """Process generator: end the mission once the robot has stood for too long without a plan under way."""
    while log.ended is None:
        if replanner.busy:
            log.progress = machine.now
        due = log.progress + patience
        if machine.now >= due:
            log.end(f"the robot has stood for {patience / 1e12:g} s{_because(log, replanner)}")
            return
        yield machine.environment.timeout(due - machine.now)


def _because(log: Log, replanner: Replanner) -> str:
    """What kept the robot from doing what it was to do, as far as that is known."""
    active = replanner.active
    ends = (
        f"the plan's way ends at {active.target}, short of the goal" if active and not active.arrives else ""
    )
    why = replanner.refusal or log.stall or ends
    return f": {why}" if why else ""
