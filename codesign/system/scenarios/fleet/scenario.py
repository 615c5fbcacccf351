"""Scenario ``fleet``, as the system asks for it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from codesign import components
from codesign.ground.errors import Fault
from codesign.ground.memo import Memo
from codesign.ground.records import MissionRecord, PositionsRecord, TaskRecord, TrajectoryRecord
from codesign.ground.units import PICOSECONDS_PER_SECOND, counted, format_time
from codesign.inputs import fault
from codesign.inputs.exploration import FLEET_OBJECTIVES
from codesign.inputs.scenario import Fleet
from codesign.planners.interface import COMMAND, LOAD, Planner
from codesign.planners.job import Flow
from codesign.planners.styles import FleetUpdates
from codesign.system.build import SIDE, Machine
from codesign.system.chain import Answer
from codesign.system.messages import LostMessageError
from codesign.system.outcome import plan_fields, use_fields
from codesign.system.place import DISPLAY, RENDER_KERNEL
from codesign.system.results.ledger import Ledger
from codesign.system.results.result import PACEMAKERS, FleetFigures, Frames, Pacemaker, Power, spread
from codesign.system.scenario import Draft, ProgressOfMission
from codesign.system.scenarios.scenario import Scenario, tell_map

# The messages with the coordinates of all robots to the display, one an update.


def frame_receiver(scenario: Fleet, places: Mapping[str, str], component: str) -> str | None:
    """The task that takes frames of the planning ``component``: the display, or who asked. None: there are none."""
    receiver = DISPLAY if DISPLAY in places else COMMAND
    return None if scenario.report == "none" or places[receiver] == component else receiver


class FrameSender:
    """Sends frames of ``robots`` robots from the planning component to task ``receiver`` and accounts for each of them.

    ``line_ps``: the time of one frame on the slowest link of its route without errors, ps.
    """

    def __init__(self, machine: Machine, receiver: str, robots: int) -> None:
        system = machine.system
        self._machine = machine
        self._receiver = receiver
        self._robots = robots
        flows = system.placement.graph.between(system.planner.planning_task, receiver)
        self.bits = sum(flow.bits for flow in flows)
        self._name = flows[0].name
        # Where a display hangs on the pins of another component, no link is between them.
        self._hops = [
            (machine.messages.fastest(hop, self.bits), hop.sender, hop.receiver)
            for hop in machine.messages.routes.between(system.component, system.placement.places[receiver])
            if hop.links
        ]
        self.line_ps = max((link.duration(self.bits) for link, _, _ in self._hops), default=0)
        self._writer: Any = None
        self._frames = self._skipped = 0
        self._dropped: Counter[str] = Counter()
        self._ages: list[int] = []

    def offer(self) -> None:
        """Send a frame in the background, or skip it where the one before is not in the line's FIFO yet."""
        if self._writer is not None and self._writer.is_alive:
            self._frames += 1
            self._skipped += 1
        else:
            self._writer = self._machine.environment.process(self.hand_over())

    def hand_over(self) -> Generator[Any, Any, None]:
        """Process generator: send a frame, and wait until the line has taken it over."""
        self._frames += 1
        begin = self._machine.now
        if not self._hops:
            self._machine.environment.process(self._arrive(None, begin))
            return
        link, sender, receiver = self._hops[0]
        carrier = yield from link.post(sender, receiver, self._name, self.bits)
        self._machine.environment.process(self._arrive(carrier, begin))

    def _arrive(self, carrier: Any, begin: int) -> Generator[Any, Any, None]:
        """Process generator: over the further links to the receiver, which draws it."""
        if carrier is not None:
            delivery = yield carrier
            for link, sender, receiver in self._hops[1:]:
                if delivery.reason is None:
                    delivery = yield from link.send(sender, receiver, self._name, self.bits)
            if delivery.reason is not None:
                self._dropped[delivery.reason] += 1
                return
        yield from self._machine.charge(self._receiver, RENDER_KERNEL, self._robots, priority=SIDE)
        self._ages.append(self._machine.now - begin)
        self._machine.follow_up(self._receiver)

    def figures(self, step_ps: int) -> Frames:
        """The account so far; a frame is late where it is older than a time step of ``step_ps`` ps when shown."""
        dropped = dict(sorted(self._dropped.items()))
        shown = len(self._ages)
        return Frames(
            receiver=self._machine.system.placement.places[self._receiver],
            bits=self.bits,
            made=self._frames,
            skipped=self._skipped,
            dropped=dropped,
            shown=shown,
            late=sum(age > step_ps for age in self._ages),
            under_way=self._frames - self._skipped - sum(dropped.values()) - shown,
            age=spread(self._ages),
        )


# A fleet's run from begin to end, and its figures.

# The records of a fleet's run: positions, arrivals, contacts, and the robot that the others wait for.

TASK_OF_EACH = 8
"""Up to so many robots each have a ``TaskRecord`` an update; of more, only the one that the others wait for."""
TRAJECTORIES = 64

_SOURCE = "fleet"


class FleetTrace:
    """Makes records for the listeners of a machine; none where it has no listeners.

    ``PositionsRecord`` at the begin, after each update, and where robots that decided late begin to take their new
    velocities; ``TaskRecord`` for each robot and update, or the slowest's; ``MissionRecord`` for ``deadline_missed``,
    ``goal_reached`` (one robot each), ``contact`` (two robots begin to touch) and ``ended``; a ``TrajectoryRecord`` for
    each robot at the end.

    A contact has the moment at which the bodies first touch, between two updates as at one. Robots of a free-running
    fleet take their time step at once, so there the text alone says when in the step.
    """

    def __init__(self, machine: Machine, work: FleetUpdates) -> None:
        self._machine = machine
        self._work = work
        self._robots = len(work.cycles)
        self._arrived = np.zeros(self._robots, np.bool_)

    def begin(self) -> None:
        """The arena with the targets, and the robots at their starts."""
        if not self._machine.listening:
            return
        problem = self._machine.system.problem
        tell_map(self._machine, problem.free, problem.resolution, self._work.radius)
        self._positions()

    def began(self) -> None:
        """An update has begun: robots see whether they have arrived."""
        if not self._machine.listening:
            return
        arrived = self._work.arrived
        for robot in np.flatnonzero(arrived & ~self._arrived).tolist():
            self._tell("goal_reached", f"robot {robot} has arrived")
        self._arrived = arrived.copy()

    def decided(self, begin: int, fpgas: tuple[components.Fpga, ...], missed: bool) -> None:
        """The update that began at ``begin`` (ps) has been decided by all."""
        if not self._machine.listening:
            return
        slowest, task = self._work.slowest, self._machine.system.planner.planning_task
        clock = fpgas[0].clock
        first = clock.cycle_at_or_after(begin)
        several = range(len(fpgas)) if len(fpgas) <= TASK_OF_EACH else (slowest,)
        for robot in several if self._machine.wants(TaskRecord) else ():
            cycles = int(self._work.cycles[robot])
            times = clock.edge(first), clock.edge(first + cycles)
            self._machine.tell(TaskRecord(times[0], fpgas[robot].name, task, times[1], cycles))
        if missed:
            update = self._work.done + 1
            text = f"update {update} took longer than its time step; robot {slowest} was last"
            self._tell("deadline_missed", text)

    def moved(self, update: int, steps: int, taken: int) -> None:
        """The robots have moved on for ``steps`` time steps, in this update, counted from 1.

        ``taken``: the time that this took here, ps; 0 for robots that are simulated by the boards themselves.
        """
        if not self._machine.listening:
            return
        first = self._work.touches()
        # A pair that touches at the begin of a motion was told of at the end of the one before.
        new = np.flatnonzero((first > 0.0) & (first <= 1.0))
        if len(new):
            pairs = np.column_stack(np.triu_indices(self._robots, 1))[new]
            for share, (one, other) in sorted(zip(first[new].tolist(), pairs.tolist(), strict=True)):
                after = format_time(round(share * steps * self._work.step_ps, -6))
                text = f"robots {one} and {other} touch {after} after they began the motion of update {update}"
                self._tell("contact", text, self._machine.now - taken + round(share * taken))
        self._positions()

    def ended(self, text: str, plan: Any) -> None:
        """The run is over."""
        if not self._machine.listening:
            return
        self._tell("ended", text)
        system = self._machine.system
        for robot in range(min(self._robots, TRAJECTORIES)):
            points, arrived = system.planner.trajectory(system.problem, plan, robot)
            self._machine.tell(TrajectoryRecord(self._machine.now, f"robot_{robot}", points, arrived))

    def _positions(self) -> None:
        work = self._work
        self._machine.tell(PositionsRecord(self._machine.now, _SOURCE, work.done, work.positions))

    def _tell(self, event: str, text: str, time: int | None = None) -> None:
        self._machine.tell(MissionRecord(self._machine.now if time is None else time, _SOURCE, event, text))


ARRIVED = "all robots stand at their targets"


@dataclass(frozen=True, eq=False)
class Flight:
    """A fleet's run up to its last complete update, its figures, and the FPGAs.

    ``fpgas``: the first is the platform's own. ``loaded``: when starts and targets stood in the FPGAs, and the first
    update began, ps; ``ends``: when each update was over. ``events``: messages, and decisions of single robots.
    """

    plan: Any
    figures: FleetFigures
    fpgas: tuple[components.Fpga, ...]
    loaded: int
    ends: tuple[int, ...]
    events: int


def fly(machine: Machine) -> Flight:
    """Run scenario ``fleet`` on a machine that has done nothing yet.

    A message that no link brings, the scenario's limit and its most events end the run with that as its reason.
    """
    return _FleetRun(machine).run()


class _FleetRun:
    """A run under way. ``begins``, ``decided``, ``ends``: of each update, ps."""

    def __init__(self, machine: Machine) -> None:

        system = machine.system
        scenario = system.workload.scenario
        assert isinstance(scenario, Fleet), "the caller looks at the scenario"
        work = system.architecture.updates(system.job)
        assert work is not None, "faults_on refuses a style that plans for one robot only"
        self.machine, self.scenario = machine, scenario
        self.environment = machine.environment
        self.work: FleetUpdates = work
        self.trace = FleetTrace(machine, work)
        own = machine.planning_component
        self.fpgas: tuple[components.Fpga, ...] = (
            own,
            *(
                components.Fpga(self.environment, f"{own.name}.robot_{number}", own.clock)
                for number in range(1, len(work.cycles))
            ),
        )
        self.step_ps = work.step_ps
        self.begins: list[int] = []
        self.decided: list[int] = []
        self.ends: list[int] = []
        self.loaded = self.missed = 0
        self.frames = self._frames()
        self._failure: str | None = None
        self._starting = self.environment.event()
        self._barrier = self.environment.event()
        self._deciding = 0

    def run(self) -> Flight:
        """Simulate until no event is left, or until a watchdog ends the run."""
        environment = self.environment
        # The robots first: where starts and targets take no time, the first update begins with the mission.
        for robot in range(len(self.fpgas)):
            environment.process(self._robot(robot))
        environment.process(self._mission())
        limit, most = self.scenario.limit, self.scenario.events
        horizon = environment.peek()
        # The limits are checked between two moments only: the steps of a moment depend on the granularity.
        while horizon <= limit and (horizon == environment.now or self._event_count() < most):
            environment.step()
            horizon = environment.peek()
        stopped = None
        if horizon != float("inf"):
            seconds = f"{limit / PICOSECONDS_PER_SECOND:g} s of simulated time"
            stopped = f"the limit of {seconds if horizon > limit else f'{most:,} events'} was reached"
        return self._flight(stopped, self._event_count())

    def _event_count(self) -> int:
        """Events up to now: messages, and decisions of single robots, without the simulation's own events."""
        return self.machine.messages_sent + len(self.begins) * len(self.fpgas)

    def _mission(self) -> Generator[Any, Any, None]:
        """Process generator: load, then update after update."""
        system = self.machine.system
        self.trace.begin()
        try:
            for flow in system.planner.flows(system.job):
                if (flow.sender, flow.receiver) == (LOAD, system.planner.planning_task):
                    yield from self.machine.carry(flow)
        except LostMessageError as lost:
            self._failure = f"{lost.what} on {lost.where}"
            return
        self.loaded = self.machine.now
        while not self.work.over:
            yield from self._update()

    def _update(self) -> Generator[Any, Any, None]:
        """Process generator: one update, up to where the next one begins."""
        begin, work = self.machine.now, self.work
        work.decide()
        self.trace.began()
        if work.departure is not None:
            return
        self.begins.append(begin)
        self._barrier, self._deciding = self.environment.event(), len(self.fpgas)
        start, self._starting = self._starting, self.environment.event()
        start.succeed()
        yield self._barrier
        decided = self.machine.now
        self.decided.append(decided)
        missed = decided - begin > self.step_ps
        self.missed += missed
        self.trace.decided(begin, self.fpgas, missed)
        self.machine.follow_up(self.machine.system.planner.planning_task)
        taken = self.step_ps if self.scenario.pace == "real_time" else 0
        if taken:
            if self.frames is not None:
                self.frames.offer()
            yield from self._step_out(begin, decided, missed)
        elif self.frames is not None:
            yield from self.frames.hand_over()
        if work.departure is None:
            work.act()
        if work.departure is None:
            self.ends.append(self.machine.now)
            self.trace.moved(len(self.begins), 1, taken)

    def _step_out(self, begin: int, decided: int, missed: bool) -> Generator[Any, Any, None]:
        """Process generator: to the end of the time step in which the robots take their new velocities."""
        steps = max(1, -(-(decided - begin) // self.step_ps))
        if begin + steps * self.step_ps > decided:
            yield self.environment.timeout(begin + steps * self.step_ps - decided)
        if missed:
            self.work.hold(steps)
            if self.work.departure is None:
                self.trace.moved(len(self.begins), steps, steps * self.step_ps)
                yield self.environment.timeout(self.step_ps)

    def _robot(self, robot: int) -> Generator[Any, Any, None]:
        """Process generator: one robot's FPGA decides in every update; the last one ends the update for all."""
        fpga, visits = self.fpgas[robot], self.machine.granularity == "visit"
        while True:
            yield self._starting
            # Only the first robot's phases are reported: one event an update is enough for the others.
            whole = robot > 0 and not visits
            steps = self.work.whole(robot) if whole else self.work.steps(robot, visits=visits)
            yield from fpga.execute(steps, self.machine.granularity)
            self._deciding -= 1
            if not self._deciding:
                self._barrier.succeed()

    def _frames(self) -> FrameSender | None:
        """The sender of the coordinates; None where they are not reported, or the FPGA itself draws them."""
        places = self.machine.system.placement.places
        receiver = frame_receiver(self.scenario, places, self.machine.system.component)
        if receiver is None:
            return None
        return FrameSender(self.machine, receiver, len(self.fpgas))

    def _flight(self, stopped: str | None, events: int) -> Flight:
        plan = self.work.plan()
        arrivals = self.work.arrivals(plan)
        arrived = sum(arrival is not None for arrival in arrivals)
        all_arrived, collisions = arrived == len(self.fpgas), self.work.collisions(plan)
        ended = (
            self._failure
            or stopped
            or self.work.departure
            or (_there(collisions) if all_arrived else _waiting(self.work.done, arrived, len(self.fpgas)))
        )
        self.trace.ended(ended, plan)
        completed = all_arrived and not collisions
        figures = self._figures(ended, completed, arrivals, self.work.time_steps(plan))
        return Flight(plan, figures, self.fpgas, self.loaded, tuple(self.ends), events)

    def _figures(self, ended: str, completed: bool, arrivals: list[int | None], steps: int) -> FleetFigures:
        updates = len(self.ends)
        span = self.ends[-1] - self.loaded if updates else 0
        last = max((arrival for arrival in arrivals if arrival is not None), default=None)
        deciding = [done - begin for done, begin in zip(self.decided, self.begins, strict=False)][:updates]
        periods = [end - begin for end, begin in zip(self.ends, self.begins, strict=False)]
        spent = {"fpga": sum(deciding), "line": 0, "time_step": 0}
        spent["time_step" if self.scenario.pace == "real_time" else "line"] = span - spent["fpga"]
        shares: dict[Pacemaker, float] = {name: spent[name] / span if span else 0.0 for name in PACEMAKERS}
        pace: Pacemaker = max(PACEMAKERS, key=shares.__getitem__)
        line = 0 if self.frames is None else self.frames.line_ps
        slowest = max(spent["fpga"] / updates if updates else 0.0, line)
        busy = [fpga.busy for fpga in self.fpgas]
        whole = max(self.machine.now, 1)
        return FleetFigures(
            robots=len(self.fpgas),
            fpgas=len(self.fpgas),
            ended=ended,
            completed=completed,
            updates=updates,
            span_s=span / PICOSECONDS_PER_SECOND,
            robots_s=steps * self.step_ps / PICOSECONDS_PER_SECOND,
            arrived_s=None if last is None else (self.begins[last] - self.loaded) / PICOSECONDS_PER_SECOND,
            time_step_s=self.step_ps / PICOSECONDS_PER_SECOND,
            decide=spread(deciding),
            period=spread(periods),
            updates_a_second=updates * PICOSECONDS_PER_SECOND / span if span else 0.0,
            reachable_a_second=PICOSECONDS_PER_SECOND / slowest if slowest else 0.0,
            pace=pace if span else None,
            shares=shares,
            missed_updates=self.missed,
            frames=None if self.frames is None else self.frames.figures(self.step_ps),
            fpga_busy_s=sum(busy) / PICOSECONDS_PER_SECOND,
            fpga_utilisation=(min(busy) / whole, max(busy) / whole),
        )


def _there(collisions: int) -> str:
    """All robots have arrived: bodies do not stop each other here, so some may have driven through one another."""
    if not collisions:
        return ARRIVED
    return f"{ARRIVED}, but {counted(collisions, 'pair')} of them touched on the way and drove on"


def _waiting(updates: int, arrived: int, robots: int) -> str:
    return f"after {updates:,} updates {arrived} of {robots} robots have arrived: the others still wait or drive"


class FleetScenario(Scenario):
    """Robots with an FPGA each, update by update."""

    type = "fleet"
    objectives = FLEET_OBJECTIVES

    def instead(self, planner: Planner) -> str | None:
        """Fleets are for planners with a problem of robots."""
        return "drive" if planner.problem_model is None else None

    def faults_on(self, draft: Draft) -> list[Fault]:
        """A style that plans for one robot only."""
        if draft.architecture.updates(draft.job) is not None:
            return []
        text = f"style {draft.architecture.style} does not say what each robot takes for an update"
        hint = "take a style with a method updates, as those of velocity_obstacle have, or scenario plan_once"
        return [fault(draft.workload, ("mapping", draft.planner.planning_task, "style"), text, hint)]

    def flows(self, _draft: Draft, places: Mapping[str, str], planned: Sequence[Flow]) -> Sequence[Flow]:
        """The answers of the planner, which the first robot's board itself sends to the display too."""
        if DISPLAY not in places:
            return ()
        return [replace(flow, receiver=DISPLAY) for flow in planned if flow.receiver == COMMAND]

    def kernels(self, draft: Draft, places: Mapping[str, str]) -> Mapping[str, str]:
        """The frames that are drawn."""
        assert isinstance(draft.workload.scenario, Fleet), "the registry of scenarios goes by the type"
        receiver = frame_receiver(draft.workload.scenario, places, places[draft.planner.planning_task])
        return {} if receiver is None else {receiver: RENDER_KERNEL}

    def run(
        self, machine: Machine, boards: Mapping[str, Power], memo: Memo | None, _progress: ProgressOfMission | None
    ) -> dict[str, Any]:
        """The figures of the plan that the fleet carried out, and of the fleet."""
        flight = fly(machine)
        ended = flight.ends[-1] if flight.ends else flight.loaded
        answer = Answer(machine.system.problem, flight.plan, flight.loaded, ended, ended, Ledger())
        fields = plan_fields(machine, answer, memo) | use_fields(machine, boards, flight.fpgas[1:])
        return {**fields, "fleet": flight.figures}
