"""The tasks of a drive: where they are done, and the messages between them."""

from __future__ import annotations

from collections.abc import Mapping

from codesign.inputs import Platform, Workload
from codesign.inputs.components import RobotComponent
from codesign.inputs.scenario import Drive
from codesign.planners.interface import COMMAND, LOAD, Problem
from codesign.planners.job import Flow
from codesign.system.assemble import sensor_of
from codesign.system.place import DISPLAY, RENDER_KERNEL
from codesign.system.scenario import Draft

SENSE, MOVE = "sense", "move"

OCCUPANCY, FOLLOWING = "occupancy_cell", "way_following"
"""Kernels of the host's own work in a turn: one seen cell put into the map; and one command made from a path."""

KERNELS = {LOAD: OCCUPANCY, COMMAND: FOLLOWING, DISPLAY: RENDER_KERNEL}
"""The kernel of each task that is done in every turn."""

COMMAND_BITS = 96
"""The bits that say how far to go on which path, and at most how fast: three words of 32 bits. Assumed."""

SEEN, SEEN_BITS = "seen", 96
"""The flow from the task that keeps the map to the one that commands. It carries where the robot was and how fast,
three words of 32 bits (assumed), and every cell that changed since the last such message that arrived."""

FRAME_BITS = 64
"""A robot's position for the display, two words of 32 bits: assumed."""


def drive_of(workload: Workload) -> Drive:
    """The drive that a workload describes."""
    assert isinstance(workload.scenario, Drive), "the registry of scenarios goes by the type"
    return workload.scenario


def drive_on(workload: Workload, problem: Problem) -> Drive:
    """The drive with its cells counted as the cells of the problem, which may be cropped."""
    return drive_of(workload).moved(*problem.corner)


def robots_of(platform: Platform) -> dict[str, RobotComponent]:
    """The robots of a platform by name."""
    return platform.of(RobotComponent)


def robot_name(platform: Platform, workload: Workload) -> str | None:
    """The robot that drives; None where the platform has none, or several and the scenario names none of them."""
    named, robots = drive_of(workload).robot, robots_of(platform)
    if named is not None:
        return named if named in robots else None
    return next(iter(robots)) if len(robots) == 1 else None


def robot_of(platform: Platform, workload: Workload) -> tuple[str, RobotComponent]:
    """The robot that drives, with its name."""
    name = robot_name(platform, workload)
    assert name is not None, "faults_on refuses a drive without a robot"
    return name, robots_of(platform)[name]


def resolution_of(workload: Workload, problem: Problem) -> float:
    """Metres a cell: what the scenario says, or else the map; 1 where neither does."""
    return drive_of(workload).resolution or problem.resolution or 1.0


def drive_flows(draft: Draft, places: Mapping[str, str]) -> list[Flow]:
    """The flows of a drive besides its planner's; ``places``: the component of each task that is done."""
    _, robot = robot_of(draft.platform, draft.workload)
    sensor = sensor_of(robot.sensor, resolution_of(draft.workload, draft.problem))
    flows = [Flow(SENSE, LOAD, "scan", max(1, int(sensor.bits))), Flow(COMMAND, MOVE, "command", COMMAND_BITS)]
    if places[LOAD] != places[COMMAND]:
        flows.append(Flow(LOAD, COMMAND, SEEN, SEEN_BITS))
    if DISPLAY in places:
        flows.append(Flow(COMMAND, DISPLAY, "frame", FRAME_BITS))
    return flows
