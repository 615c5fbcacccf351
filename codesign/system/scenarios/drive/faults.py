"""Faults of a drive that are known before it runs, each with its place in a file."""

from __future__ import annotations

from bisect import bisect_left
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import Fault, InputError, choose_hint, outside_map
from codesign.ground.models import Task
from codesign.inputs import Platform, Workload, fault
from codesign.inputs.components import RobotComponent
from codesign.inputs.problem import ProblemSpec
from codesign.inputs.scenario import Drive, Rectangle
from codesign.maps import nearest_free
from codesign.planners.interface import Planner, Problem
from codesign.planners.job import Job
from codesign.system.assemble import kinematics_of, refused, sensor_of
from codesign.system.change import policy_faults
from codesign.system.scenarios.drive.tasks import drive_of, drive_on, resolution_of, robot_name, robot_of, robots_of
from codesign.system.scenarios.drive.world.inflation import Inflation
from codesign.system.scenarios.drive.world.obstacles import Moving, places_of

_SCENARIO = ("scenario",)
_OBSTACLES = (*_SCENARIO, "obstacles")

CELL_SIDES = (1e-6, 1e3)
"""Least and greatest side of a cell, m: assumed. Beyond these no robot is planned for in cells."""

SLOWEST = 1 / 3.6e6
"""One unit in 1000 h, the longest time that a spec may state: cells/s for a speed, rad/s for a turn."""

MAX_OBSTACLE_CELLS = 20_000_000
"""Cells of all obstacles that appear, and steps of all routes: about 1 GiB of memory."""


def drive_faults(workload: Workload, planner: Planner, problem: Problem) -> list[Fault]:
    """Every fault of a drive that is known without a platform."""
    scenario = drive_on(workload, problem)
    faults = _places(workload, scenario, problem) + _planner(workload, planner, problem)
    faults += _task(workload)
    faults += policy_faults(workload, planner, scenario.replan.policy, (*_SCENARIO, "replan", "policy"))
    faults += _resolution(workload, scenario, problem) + _amount(workload, scenario)
    if not problem.starts:
        text = "no cell leads to a goal, so that no start can be drawn"
        hint = "name a start as [[row, column]], or open the map around a goal"
        faults.append(fault(workload, ("problem", "starts"), text, hint))
    if not faults:
        faults += _random(workload, scenario, problem) + _moving(workload, scenario, problem)
        faults += _over_start(workload, scenario, problem)
    return faults


def faults_of_robot(platform: Platform, workload: Workload, problem: Problem) -> list[Fault]:
    """A platform without the robot of the drive; or what keeps that from this map: its sensor, its pace, its size.

    Called where ``drive_faults`` found none.
    """
    if robot_name(platform, workload) is None:
        return [_no_robot(platform, workload)]
    name, spec = robot_of(platform, workload)
    faults = _pace(platform, name, spec, resolution_of(workload, problem))
    try:
        sensor_of(spec.sensor, resolution_of(workload, problem))
    except InputError as wrong:
        faults.append(refused(platform, ("components", name, "sensor"), spec.sensor, wrong))
    return faults + _start(platform, workload, problem)


def _no_robot(platform: Platform, workload: Workload) -> Fault:
    """No robot can do the drive, or several could."""
    wanted, robots = drive_of(workload).robot, list(robots_of(platform))
    if wanted is not None:
        text = f"platform {platform.name} has no robot {wanted!r}"
        return fault(workload, (*_SCENARIO, "robot"), text, choose_hint(wanted, robots))
    text = f"a drive needs a robot, and platform {platform.name} has {len(robots) or 'none'}"
    hint = f"set robot to one of {', '.join(robots)}" if robots else "give the platform a component of type robot"
    return fault(workload, _SCENARIO, text, hint)


def _resolution(workload: Workload, scenario: Drive, problem: Problem) -> list[Fault]:
    """Cells that are too small or too large, or that have no known side."""
    declared = scenario.resolution is not None
    side = scenario.resolution if declared else problem.resolution
    least, most = CELL_SIDES
    if side is None:
        text = "the map does not say how large a cell is"
        return [fault(workload, _SCENARIO, text, "set resolution, such as 0.1 m, the side of a cell")]
    if least <= side <= most:
        return []
    text = f"{side:g} m is out of bounds for the side of a cell"
    path = (*_SCENARIO, "resolution") if declared else ("problem", "map")
    return [fault(workload, path, text, f"from {least:g} m to {most:g} m")]


def _amount(workload: Workload, scenario: Drive) -> list[Fault]:
    """More obstacles, or longer routes, than there is memory for."""
    obstacles, random = scenario.obstacles, scenario.obstacles.random
    counts = {
        "appearing": sum(each.rows * each.columns for each in obstacles.appearing),
        "random": 0 if random is None else random.count * random.size**2,
        "moving": sum(
            max(abs(first - last) for first, last in zip(begin, end, strict=True))
            for moving in obstacles.moving
            for begin, end in pairwise(moving.route)
        ),
    }
    return [
        fault(
            workload,
            (*_OBSTACLES, key),
            f"{'the routes have' if key == 'moving' else 'these obstacles cover'} {count:,}"
            f" {'steps' if key == 'moving' else 'cells'}, more than {MAX_OBSTACLE_CELLS:,}",
            "shorten the routes" if key == "moving" else "take fewer obstacles, or smaller ones",
        )
        for key, count in counts.items()
        if count > MAX_OBSTACLE_CELLS
    ]


def _task(workload: Workload) -> list[Fault]:
    """A task that is asked of one plan: a drive asks for plans on its way."""
    problem = workload.problem
    if not isinstance(problem, ProblemSpec) or problem.task is Task.PATH:
        return []
    text = f"task {problem.task} is for scenario plan_once: a drive asks for new paths as it meets changes"
    return [fault(workload, ("problem", "task"), text, "leave task out, or take scenario plan_once")]


def _places(workload: Workload, scenario: Drive, problem: Problem) -> list[Fault]:
    """Cells and rectangles outside of the map, and goals of the tour on obstacles."""
    shape, faults = problem.free.shape, []
    for index, goal in enumerate(scenario.tour):
        path: tuple[str | int, ...] = (*_SCENARIO, "tour", index)
        if not _inside(goal, shape):
            faults += _outside(workload, path, goal, problem, "goal")
        elif not problem.free[goal]:
            what = f"goal {problem.named(goal)} is on an obstacle"
            faults.append(
                fault(workload, path, what, f"the nearest free cell is {_nearest(problem, problem.free, goal)}")
            )
    placed: list[tuple[tuple[str | int, ...], Rectangle]] = []
    for index, hidden in enumerate(scenario.hidden):
        placed.append(((*_SCENARIO, "hidden", index), hidden))
    for index, appearing in enumerate(scenario.obstacles.appearing):
        placed.append(((*_SCENARIO, "obstacles", "appearing", index), appearing))
    for path, rectangle in placed:
        first = (rectangle.row, rectangle.column)
        faults += _outside(workload, path, first, problem, "its first cell") or _outside(
            workload, path, _last(rectangle), problem
        )
    for index, moving in enumerate(scenario.obstacles.moving):
        rows, columns = moving.size
        for number, (row, column) in enumerate(moving.route):
            path = (*_SCENARIO, "obstacles", "moving", index, "route", number)
            faults += _outside(workload, path, (row, column), problem, "its first cell") or _outside(
                workload, path, (row + rows - 1, column + columns - 1), problem
            )
    return faults


def _random(workload: Workload, scenario: Drive, problem: Problem) -> list[Fault]:
    """Random obstacles that are too large for every place of the map."""
    random = scenario.obstacles.random
    if random is None:
        return []
    free = problem.free & ~covered(problem.free.shape, scenario.hidden)
    keep = kept_clear(problem, scenario)
    # An obstacle that has a place has one in every smaller size.
    most = bisect_left(range(1, random.size + 1), True, key=lambda size: not len(places_of(free, size, keep)))
    if most == random.size:
        return []
    text = f"there is no place for an obstacle of {random.size} × {random.size} cells on this map"
    hint = f"{most} or less; goals and start stay free" if most else "leave random obstacles out"
    return [fault(workload, (*_SCENARIO, "obstacles", "random", "size"), text, hint)]


def _planner(workload: Workload, planner: Planner, problem: Problem) -> list[Fault]:
    """The faults that keep the planner, as it is mapped, from leading a robot."""
    wrong = planner.check_drive(Job(problem, workload.mapping[planner.planning_task].parameters))
    if wrong is None:
        return []
    key, what, hint = wrong
    return [fault(workload, ("mapping", planner.planning_task, key), what, hint)]


def _moving(workload: Workload, scenario: Drive, problem: Problem) -> list[Fault]:
    """Obstacles that move too slowly or too fast for the cells."""
    faults = []
    for index in range(len(scenario.obstacles.moving)):
        try:
            moving_of(scenario, index, resolution_of(workload, problem))
        except InputError as wrong:
            path = (*_OBSTACLES, "moving", index, "speed")
            faults.append(fault(workload, path, wrong.what, wrong.hint))
    return faults


def moving_of(scenario: Drive, index: int, resolution: float) -> Moving:
    """The moving obstacle at ``index`` of the scenario, on cells of ``resolution`` metres.

    Raises:
        InputError: its speed is out of bounds.
    """
    moving = scenario.obstacles.moving[index]
    return Moving(moving.size, moving.route, moving.speed / resolution, moving.begin)


def _over_start(workload: Workload, scenario: Drive, problem: Problem) -> list[Fault]:
    """Hidden obstacles where the robot starts."""
    start = problem.starts[0]
    return [
        fault(
            workload,
            (*_SCENARIO, "hidden", index),
            f"it covers {problem.named(start)}, where the robot starts",
            "leave the start free, or start elsewhere",
        )
        for index, hidden in enumerate(scenario.hidden)
        if covered(problem.free.shape, (hidden,))[start]
    ]


def _pace(platform: Platform, name: str, spec: RobotComponent, resolution: float) -> list[Fault]:
    """A robot so slow that it does not leave its cell in 1000 h."""
    declared = kinematics_of(spec)
    in_cells = declared.scaled(1.0 / resolution)
    faults = []
    for key in type(spec.kinematics).model_fields:
        if key == "type" or vars(in_cells)[key] >= SLOWEST:
            continue
        unit = {"speed": "m/s", "acceleration": "m/s²", "turn_rate": "rad/s"}[key]
        least = SLOWEST * (vars(declared)[key] / vars(in_cells)[key])
        text = f"{vars(declared)[key]:g} {unit} is too slow: the robot needs 1000 h for a cell of {resolution:g} m"
        path = ("components", name, "kinematics", key)
        faults.append(fault(platform, path, text, f"at least {least:.3g} {unit}"))
    return faults


def _start(platform: Platform, workload: Workload, problem: Problem) -> list[Fault]:
    """A robot that is too large for the map, or for the place where it starts."""
    name, spec = robot_of(platform, workload)
    start, resolution = problem.starts[0], resolution_of(workload, problem)
    obstacles = ~problem.free | covered(problem.free.shape, drive_on(workload, problem).hidden)
    path = ("problem", "starts", 0)
    radius = float(spec.radius.value) / resolution
    if 2 * radius > min(problem.free.shape):
        size = " × ".join(str(side) for side in problem.free.shape)
        text = f"a robot with a radius of {radius:.3g} cells is larger than the map of {size} cells"
        return [fault(platform, ("components", name, "radius"), text, "make it smaller, or the cells larger")]
    blocked = Inflation(obstacles, radius).blocked
    if blocked[start]:
        near = _nearest(problem, ~blocked, start)
        wide = f"the robot, {2 * float(spec.radius.value):.3g} m wide,"
        there = f"at its start {problem.named(start)}: somewhere in that cell it would touch an obstacle"
        text = f"{wide} does not fit {there}"
        hint = "no cell has room for it" if near is None else f"the nearest cell with room is {near}"
        return [fault(workload, path, text, hint)]
    return []


def covered(shape: tuple[int, ...], rectangles: tuple[Rectangle, ...]) -> NDArray[np.bool_]:
    """Bool, rows × columns: the cells that the rectangles cover."""
    mask = np.zeros(shape, np.bool_)
    for each in rectangles:
        mask[each.row : each.row + each.rows, each.column : each.column + each.columns] = True
    return mask


def kept_clear(problem: Problem, scenario: Drive) -> tuple[tuple[int, int], ...]:
    """The cells that no random obstacle covers: goals and start."""
    return (*problem.goals, *scenario.tour, problem.starts[0])


def _inside(cell: tuple[int, ...], shape: tuple[int, ...]) -> bool:
    return all(0 <= place < side for place, side in zip(cell, shape, strict=True))


def _last(rectangle: Rectangle) -> tuple[int, int]:
    return rectangle.row + rectangle.rows - 1, rectangle.column + rectangle.columns - 1


def _nearest(problem: Problem, free: NDArray[np.bool_], cell: tuple[int, int]) -> tuple[int, int] | None:
    """The nearest free cell as users count it; None where there is none."""
    near = nearest_free(free, cell)
    return None if near is None else problem.named(near)


def _outside(
    workload: Workload,
    path: tuple[str | int, ...],
    cell: tuple[int, int],
    problem: Problem,
    name: str = "its last cell",
) -> list[Fault]:
    if _inside(cell, problem.shape):
        return []
    return [fault(workload, path, *outside_map(problem.named(cell), problem.shape, name, problem.corner))]
