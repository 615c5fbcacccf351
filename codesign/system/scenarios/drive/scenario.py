"""Scenario ``drive``, as the system asks for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar

import numpy as np

from codesign import maps
from codesign.ground.errors import Fault
from codesign.ground.memo import Memo
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs import Platform, Workload
from codesign.inputs.components import RobotComponent
from codesign.inputs.exploration import MISSION_OBJECTIVES
from codesign.inputs.scenario import ReplanPolicy
from codesign.planners.interface import Planner, Quality
from codesign.planners.job import Flow
from codesign.system.bind import System
from codesign.system.build import Machine
from codesign.system.chain import Answer
from codesign.system.energy import energy
from codesign.system.outcome import plan_fields, quality_of, use_fields
from codesign.system.results.ledger import SPENT, Ledger, Spent
from codesign.system.results.mission import (
    CONTACT_POINTS,
    LIVELOCK,
    Account,
    Bottleneck,
    ContactPoint,
    LatencyShare,
    Mission,
    MissionEnergy,
)
from codesign.system.results.result import Power, Result
from codesign.system.scenario import Draft, LeverProgress, ProgressOfMission
from codesign.system.scenarios.drive.faults import drive_faults, faults_of_robot
from codesign.system.scenarios.drive.levers import with_levers
from codesign.system.scenarios.drive.log import Log, broken_off_text
from codesign.system.scenarios.drive.mission import FinishedDrive, drive, outlook
from codesign.system.scenarios.drive.scene import Scene
from codesign.system.scenarios.drive.tasks import KERNELS, MOVE, SENSE, drive_flows, drive_of, robot_of
from codesign.system.scenarios.drive.world.inflation import Inflation
from codesign.system.scenarios.scenario import Scenario

# The figures of a drive: where time and energy went, and what sets the pace.

WAITING_MATTERS = 0.05
"""Share of a mission that a robot stands waiting, above which the bottleneck is what it waits for. Assumed."""

LATE_MATTERS = 0.05
"""Share of turns without an answer in time, above which the bottleneck is what turns spend their time on. Assumed."""


def result_fields(
    machine: Machine, done: FinishedDrive, boards: Mapping[str, Power], memo: Memo | None
) -> dict[str, Any]:
    """The fields that a drive gives a ``Result``; ``boards``: see ``energy``."""
    fields = first_plan_fields(machine, done.log.first, done.log.last, memo)
    return {**fields, **use_fields(machine, boards), "mission": mission_of(machine, done, boards, memo)}


def mission_of(machine: Machine, done: FinishedDrive, boards: Mapping[str, Power], memo: Memo | None = None) -> Mission:
    """The figures of a drive that has ended."""
    scene, log = done.scene, done.log
    robot, span = scene.robot, machine.now
    corner = machine.system.problem.corner
    shortest = (
        _shortest(scene, Memo() if memo is None else memo)
        if log.reached and scene.scenario.purpose == "reach"
        else None
    )
    latencies = np.array(sorted(log.latencies), np.float64) / PICOSECONDS_PER_SECOND
    latency = _shares(log.planning, log.asking)
    control = _shares(log.turns_spent)
    driving, waiting = robot.moving / PICOSECONDS_PER_SECOND, log.waiting / PICOSECONDS_PER_SECOND
    return Mission(
        ended=log.ended or "",
        reached=log.reached,
        mission_time_s=span / PICOSECONDS_PER_SECOND,
        goals_reached=log.goals_reached,
        plans=log.plans,
        broken_off=log.broken_off,
        broken_off_in_a_row=log.in_a_row,
        replans=len(log.latencies),
        replan_latency_median_s=float(np.quantile(latencies, 0.5)) if len(latencies) else None,
        replan_latency_95_s=float(np.quantile(latencies, 0.95)) if len(latencies) else None,
        replan_latency_worst_s=float(latencies[-1]) if len(latencies) else None,
        distance_m=robot.distance_metres,
        shortest_m=shortest,
        distance_ratio=robot.distance_metres / shortest if shortest else None,
        clearance_least_m=scene.clearance.least * scene.resolution,
        clearance_mean_m=scene.clearance.mean * scene.resolution,
        turns=log.turns,
        missed_deadlines=log.missed,
        safety_stops=robot.safety_stops,
        contacts=len(robot.contacts),
        contact_points=tuple(
            ContactPoint(
                time_s=contact.time / PICOSECONDS_PER_SECOND,
                row=contact.position[0] + corner[0],
                column=contact.position[1] + corner[1],
                speed_m_s=contact.speed * scene.resolution,
            )
            for contact in robot.contacts[:CONTACT_POINTS]
        ),
        deferred_obstacles=len(scene.world.deferrals),
        driving_s=driving,
        waiting_s=waiting,
        known_share=scene.belief.known_share,
        energy=_energy(machine, scene, boards),
        account=_account(machine, done),
        latency=latency,
        control=control,
        bottleneck=_with_livelock(_bottleneck(done, latency, control), log.in_a_row),
    )


def first_plan_fields(machine: Machine, first: Answer | None, last: Answer | None, memo: Memo | None) -> dict[str, Any]:
    """The fields of a drive's first plan; none where it had no plan.

    Plans that go on from old values may inherit mistakes, which the first cannot have. So under policy ``continue``,
    ``details`` has how many cells of the last plan are wrong.
    """
    if first is None or last is None:
        return {}
    fields = plan_fields(machine, first, memo)
    policy = drive_of(machine.system.workload).replan.policy
    if last is first or policy is not ReplanPolicy.CONTINUE:
        return fields
    judged = quality_of(machine.system, last, memo)
    if not isinstance(judged, Quality) or judged.wrong_cells is None:
        return fields
    return fields | {"details": {**fields.get("details", {}), "wrong_cells_of_the_last_plan": judged.wrong_cells}}


def _shortest(scene: Scene, memo: Memo) -> float | None:
    """The least distance from the start over all goals in order, m; None where no path leads there.

    Each leg is the shortest any-angle path from anywhere in a goal's cell to anywhere in the next one's, in the cells
    that the robot's middle may ever enter: what appears or moves may be gone when the robot comes by.
    """
    problem = scene.machine.system.problem
    free = ~Inflation(~scene.true_free, scene.robot.radius_cells).blocked
    free[problem.starts[0]] = True
    here: tuple[tuple[int, int], ...] = (problem.starts[0],)
    cells = 0.0
    for number, leg in enumerate((problem.goals, *((goal,) for goal in scene.scenario.tour))):
        there = tuple(goal for goal in leg if free[goal])
        if not there:
            return None
        # The robot sets out from the middle of its cell, and from anywhere in that of a goal.
        key = ("least distance", free.tobytes(), free.shape, here, there, number)
        cells += memo.get(key, partial(maps.least_distance, free, here, there, point=number == 0))
        here = there
    return cells * scene.resolution if np.isfinite(cells) else None


def _energy(machine: Machine, scene: Scene, boards: Mapping[str, Power]) -> MissionEnergy:
    own = energy(machine, boards)
    spec = machine.system.platform.of(RobotComponent)[scene.robot.name]
    moving, standing = (scene.robot.moving / PICOSECONDS_PER_SECOND, scene.robot.standing / PICOSECONDS_PER_SECOND)
    robot = float(spec.power.moving.value) * moving + float(spec.power.standing.value) * standing
    return MissionEnergy(
        fpga_j=own.fpga_j,
        idle_fpgas_j=own.idle_fpgas_j,
        processors_j=own.processors_j,
        links_j=own.links_j,
        memories_j=own.memories_j,
        robot_j=robot,
        mission_energy_j=own.energy_j + robot,
        not_declared=own.not_declared,
    )


def _account(machine: Machine, done: FinishedDrive) -> dict[str, Account]:
    """The time of each component and link, by what it was spent on.

    ``wait`` of a component is the time that the work of plans and turns waited there; of a link, that all messages did.
    """
    span = machine.now / PICOSECONDS_PER_SECOND
    waited = {
        where: (done.log.planning.spent[Spent.WAIT, where] + done.log.turns_spent.spent[Spent.WAIT, where])
        / PICOSECONDS_PER_SECOND
        for where in machine.by_name
    }
    accounts = {}
    for name, component in machine.by_name.items():
        busy = component.busy / PICOSECONDS_PER_SECOND
        accounts[name] = Account(compute_s=busy, transfer_s=0.0, wait_s=waited[name], idle_s=span - busy)
    for name, link in machine.links.items():
        busy = link.busy / PICOSECONDS_PER_SECOND
        wait = link.queued / PICOSECONDS_PER_SECOND
        accounts[name] = Account(compute_s=0.0, transfer_s=busy, wait_s=wait, idle_s=span - busy)
    return accounts


def _shares(*ledgers: Ledger) -> tuple[LatencyShare, ...]:
    ledger = Ledger()
    for each in ledgers:
        ledger.add(each)
    shares = [
        LatencyShare(kind=what, where=where, seconds=time / PICOSECONDS_PER_SECOND, share=time / ledger.total)
        for (what, where), time in ledger.spent.items()
        if time > 0
    ]
    return tuple(sorted(shares, key=lambda share: (-share.seconds, share.where, share.kind)))


def _bottleneck(
    done: FinishedDrive, latency: tuple[LatencyShare, ...], control: tuple[LatencyShare, ...]
) -> Bottleneck | None:
    """The place where the time was seen to go: late turns, plans that are waited for, or the robot's motion.

    It does not show what a change of the design would save: see ``system.scenarios.drive.levers``.
    """
    log, robot = done.log, done.scene.robot
    span = done.scene.machine.now / PICOSECONDS_PER_SECOND
    if not span:
        return None
    driving, waiting = (robot.moving / PICOSECONDS_PER_SECOND / span, log.waiting / PICOSECONDS_PER_SECOND / span)
    if control and log.missed > LATE_MATTERS * log.turns:
        return _late(log, control[0])
    first = latency[0] if latency else None
    spent = f"; of the time of plans, {first.share:.0%} is {SPENT[first.kind]} at {first.where}" if first else ""
    shares = f"the robot drives {driving:.0%} of the time and stands waiting for plans {waiting:.1%} of it{spent}"
    if first is None or waiting < WAITING_MATTERS:
        return Bottleneck(name=robot.name, kind="drive", share=driving, text=f"{robot.name}: {shares}")
    text = f"{first.where}: {shares}"
    return Bottleneck(name=first.where, kind=first.kind, share=first.share, text=text)


def _with_livelock(seen: Bottleneck | None, in_a_row: int) -> Bottleneck | None:
    """With the livelock that the mission was in for a while, also where it came out of it."""
    if seen is None or in_a_row < LIVELOCK:
        return seen
    return seen.model_copy(update={"text": f"{seen.text}; {broken_off_text(in_a_row)}"})


def _late(log: Log, first: LatencyShare) -> Bottleneck:
    """Turns that are answered too late make the robot brake."""
    mean = first.seconds / log.turns
    text = (
        f"{first.where}: {log.missed} of {log.turns} turns had no answer by their deadline, and the robot braked;"
        f" {first.share:.0%} of the time of turns is {SPENT[first.kind]} there, {mean * 1e3:.3g} ms a turn"
    )
    return Bottleneck(name=first.where, kind=first.kind, share=first.share, text=text)


class DriveScenario(Scenario):
    """One robot senses, plans, drives, discovers and plans again."""

    type = "drive"
    begins_anywhere = True
    asks_again = True
    # Assumed: what a robot believes and what is true, each with its distances, and the plan that it follows.
    bytes_a_cell = 64
    component_types: ClassVar[Mapping[str, tuple[str, ...]]] = {SENSE: ("robot",), MOVE: ("robot",)}
    objectives = MISSION_OBJECTIVES

    def instead(self, planner: Planner) -> str | None:
        """Drives are for planners on maps."""
        return None if planner.problem_model is None else "fleet"

    def faults(self, workload: Workload, planner: Planner, problem: Any) -> list[Fault]:
        """See ``faults.drive_faults``."""
        return drive_faults(workload, planner, problem)

    def faults_on(self, draft: Draft) -> list[Fault]:
        """See ``faults.faults_of_robot``."""
        return faults_of_robot(draft.platform, draft.workload, draft.problem)

    def places(self, draft: Draft) -> Mapping[str, str]:
        """The robot senses and moves."""
        name, _ = robot_of(draft.platform, draft.workload)
        return {SENSE: name, MOVE: name}

    def flows(self, draft: Draft, places: Mapping[str, str], _planned: Sequence[Flow]) -> Sequence[Flow]:
        """Scans, commands, what was seen, and frames for a display."""
        return drive_flows(draft, places)

    def kernels(self, _draft: Draft, _places: Mapping[str, str]) -> Mapping[str, str]:
        """The kernel of each task of a turn."""
        return KERNELS

    def run(
        self, machine: Machine, boards: Mapping[str, Power], memo: Memo | None, progress: ProgressOfMission | None
    ) -> dict[str, Any]:
        """The figures of the first plan, and of the mission."""
        return result_fields(machine, drive(machine, memo, progress), boards, memo)

    def outlook(self, workload: Workload) -> str | None:
        """See ``progress.outlook``."""
        return outlook(drive_of(workload))

    def with_levers(
        self,
        result: Result,
        system: System,
        run: Callable[[Platform, Workload], Result],
        progress: LeverProgress | None,
    ) -> Result:
        """See ``levers.with_levers``."""
        return with_levers(result, system, run, progress)
