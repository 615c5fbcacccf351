"""What a workload says of a drive that its map cannot hold: told before anything runs, at its place in the file."""

from __future__ import annotations

from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from codesign.errors import Fault, outside_map
from codesign.maps import nearest_free
from codesign.planners.interface import LOWER_BOUND, Problem
from codesign.spec import Platform, Workload, fault
from codesign.spec.components import RobotComponent
from codesign.spec.scenario import Drive, Rectangle, ReplanPolicy
from codesign.system import catalog
from codesign.system.place import resolution_of, robot_of

_SCENARIO = ("scenario",)


def drive_faults(platform: Platform, workload: Workload, problem: Problem) -> list[Fault]:
    """Every fault of a drive; none where the scenario is another."""
    scenario = workload.scenario
    if not isinstance(scenario, Drive):
        return []
    faults = _places(workload, scenario, problem) + _planner(workload, problem) + _policy(workload, scenario)
    if scenario.resolution is None and problem.resolution is None:
        text = "the map does not say how large a cell is"
        faults.append(fault(workload, _SCENARIO, text, "set resolution, such as 0.1 m, the side of a cell"))
    if not faults:
        faults += _random(workload, scenario, problem) + _start(platform, workload, scenario, problem)
    return faults


def _policy(workload: Workload, scenario: Drive) -> list[Fault]:
    """A replan policy that the planner does not know, or whose task nobody does."""
    policy, planner = scenario.replan.policy, catalog.planner(workload.planner)
    if policy is None:
        return []
    path = (*_SCENARIO, "replan", "policy")
    if policy.value not in planner.policies:
        text = f"planner {planner.name} knows no policy {policy.value!r}"
        return [fault(workload, path, text, f"accepted: {', '.join(planner.policies)}")]
    if policy is ReplanPolicy.LOWER_BOUND and LOWER_BOUND not in workload.mapping:
        text = "nobody makes the lower bound that plans are to start from"
        hint = f"map task {LOWER_BOUND} to a processor: {LOWER_BOUND}: {{component: NAME}}"
        return [fault(workload, path, text, hint)]
    return []


def _places(workload: Workload, scenario: Drive, problem: Problem) -> list[Fault]:
    """Cells and rectangles outside of the map, and goals of the tour on obstacles."""
    shape, faults = problem.free.shape, []
    for index, goal in enumerate(scenario.tour):
        path: tuple[str | int, ...] = (*_SCENARIO, "tour", index)
        if not _inside(goal, shape):
            faults.append(fault(workload, path, *outside_map(goal, shape, "goal")))
        elif not problem.free[goal]:
            near = nearest_free(problem.free, goal)
            faults.append(
                fault(workload, path, f"goal {goal} is on an obstacle", f"the nearest free cell is {near}")
            )
    placed: list[tuple[tuple[str | int, ...], Rectangle]] = []
    for index, hidden in enumerate(scenario.hidden):
        placed.append(((*_SCENARIO, "hidden", index), hidden))
    for index, appearing in enumerate(scenario.obstacles.appearing):
        placed.append(((*_SCENARIO, "obstacles", "appearing", index), appearing))
    for path, one in placed:
        faults += _outside(workload, path, _last(one), shape)
    for index, moving in enumerate(scenario.obstacles.moving):
        rows, columns = moving.size
        for number, (row, column) in enumerate(moving.route):
            path = (*_SCENARIO, "obstacles", "moving", index, "route", number)
            faults += _outside(workload, path, (row + rows - 1, column + columns - 1), shape)
    return faults


def _random(workload: Workload, scenario: Drive, problem: Problem) -> list[Fault]:
    """Random obstacles so large that the map has no place for one."""
    random = scenario.obstacles.random
    if random is None:
        return []
    from codesign.mission.obstacles import places_of

    free = problem.free & ~covered(problem.free.shape, scenario.hidden)
    keep = kept_clear(problem, scenario)
    # What has a place has one in every smaller size.
    most = bisect_left(range(1, random.size + 1), True, key=lambda size: not len(places_of(free, size, keep)))
    if most == random.size:
        return []
    text = f"there is no place for an obstacle of {random.size} × {random.size} cells on this map"
    hint = f"{most} or less; goals and start stay free" if most else "leave random obstacles out"
    return [fault(workload, (*_SCENARIO, "obstacles", "random", "size"), text, hint)]


def _planner(workload: Workload, problem: Problem) -> list[Fault]:
    """What keeps the planner, as it is mapped, from leading a robot."""
    planner = catalog.planner(workload.planner)
    check = getattr(planner, "check_drive", None)
    wrong = None if check is None else check(problem, workload.mapping[planner.planning_task].parameters)
    if wrong is None:
        return []
    key, what, hint = wrong
    return [fault(workload, ("mapping", planner.planning_task, key), what, hint)]


def _start(platform: Platform, workload: Workload, scenario: Drive, problem: Problem) -> list[Fault]:
    """A robot that stands in an obstacle at the start, or a platform whose robot is too large or too fast."""
    name = robot_of(platform, workload)
    assert name is not None, "place() refuses a drive without a robot"
    from codesign.mission.inflation import Inflation

    spec = platform.components[name]
    assert isinstance(spec, RobotComponent), "robot_of names robots"
    start, resolution = problem.starts[0], resolution_of(workload, problem)
    obstacles = ~problem.free | covered(problem.free.shape, scenario.hidden)
    over = [
        fault(
            workload,
            (*_SCENARIO, "hidden", index),
            f"it covers {start}, where the robot starts",
            "leave the start free, or start elsewhere",
        )
        for index, hidden in enumerate(scenario.hidden)
        if covered(problem.free.shape, (hidden,))[start]
    ]
    if over:
        return over
    path = ("problem", "starts", 0)
    radius = float(spec.radius.value) / resolution
    if radius > max(problem.free.shape):
        text = f"a robot with a radius of {radius:.3g} cells is larger than the map"
        return [fault(platform, ("components", name, "radius"), text, "make it smaller, or the cells larger")]
    blocked = Inflation(obstacles, radius).blocked
    if blocked[start]:
        near = nearest_free(~blocked, start) if not blocked.all() else None
        wide = f"the robot, {2 * float(spec.radius.value):.3g} m wide,"
        text = f"{wide} does not fit at its start {start}: somewhere in that cell it would touch an obstacle"
        hint = "no cell has room for it" if near is None else f"the nearest cell with room is {near}"
        return [fault(workload, path, text, hint)]
    return []


def covered(shape: tuple[int, ...], rectangles: tuple[Rectangle, ...]) -> NDArray[np.bool_]:
    """Bool, rows × columns: the cells that the rectangles cover."""
    mask = np.zeros(shape, np.bool_)
    for one in rectangles:
        mask[one.row : one.row + one.rows, one.column : one.column + one.columns] = True
    return mask


def kept_clear(problem: Problem, scenario: Drive) -> tuple[tuple[int, int], ...]:
    """The cells that no random obstacle covers: goals and start."""
    return (*problem.goals, *scenario.tour, problem.starts[0])


def _inside(cell: tuple[int, ...], shape: tuple[int, ...]) -> bool:
    return all(0 <= place < side for place, side in zip(cell, shape, strict=True))


def _last(one: Rectangle) -> tuple[int, int]:
    return one.row + one.rows - 1, one.column + one.columns - 1


def _outside(
    workload: Workload, path: tuple[str | int, ...], last: tuple[int, int], shape: tuple[int, ...]
) -> list[Fault]:
    if _inside(last, shape):
        return []
    return [fault(workload, path, *outside_map(last, shape, "its last cell"))]
