"""The change of the map that a task ``replan`` follows: named or drawn, and held against the map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from codesign import maps
from codesign.ground.errors import Fault, outside_map
from codesign.ground.models import Task
from codesign.inputs import Workload, fault
from codesign.inputs.problem import ProblemSpec
from codesign.inputs.scenario import ReplanPolicy
from codesign.inputs.tasks import DeclaredChange, DrawnChange
from codesign.planners.interface import LOWER_BOUND, Cell, MapChange, Planner, Problem
from codesign.planners.job import Job

_CHANGE = ("problem", "change")

MOST_TRIALS = 400
"""Searches of the map that a draw may take."""

_NAMED = 3


def with_task(
    workload: Workload, planner: Planner, parameters: object, problem: Problem
) -> tuple[Problem, list[Fault]]:
    """The problem with its task and, for a replan, its change; or every fault of them."""
    spec = workload.problem
    assert isinstance(spec, ProblemSpec), "a problem with a map"
    asked = replace(problem, task=spec.task)
    if spec.task is not Task.REPLAN or spec.change is None:
        return asked, []
    faults = policy_faults(workload, planner, spec.change.policy, (*_CHANGE, "policy"))
    if isinstance(spec.change, DrawnChange):
        change, more = _drawn(workload, asked, spec.change)
    else:
        change, more = _declared(workload, asked, spec.change)
    asked = replace(asked, change=change)
    if not faults and not more and not planner.answers_no_way:
        more += _cut_off(workload, planner, parameters, asked)
    return asked, faults + more


def policy_faults(
    workload: Workload, planner: Planner, policy: ReplanPolicy | None, path: tuple[str | int, ...]
) -> list[Fault]:
    """A replan policy that the planner does not know, or that needs a task that is not mapped."""
    if policy is None:
        return []
    if policy.value not in planner.policies:
        text = f"planner {planner.name} knows no policy {policy.value!r}"
        return [fault(workload, path, text, f"accepted: {', '.join(planner.policies)}")]
    if policy is ReplanPolicy.LOWER_BOUND and LOWER_BOUND not in workload.mapping:
        text = "nobody makes the lower bound that plans are to start from"
        hint = f"map task {LOWER_BOUND} to a processor: {LOWER_BOUND}: {{component: NAME}}"
        return [fault(workload, path, text, hint)]
    return []


def _declared(workload: Workload, problem: Problem, change: DeclaredChange) -> tuple[MapChange | None, list[Fault]]:
    """The named cells, or a fault for each that cannot change so. They are named in the whole map."""
    faults = []
    moved: dict[str, list[Cell]] = {"blocked": [], "freed": []}
    for name, before in (("blocked", True), ("freed", False)):
        for index, cell in enumerate(vars(change)[name]):
            path = (*_CHANGE, name, index)
            row, column = place = cell[0] - problem.corner[0], cell[1] - problem.corner[1]
            moved[name].append(place)
            if not (0 <= row < problem.rows and 0 <= column < problem.columns):
                faults.append(fault(workload, path, *_outside(cell, problem)))
            elif bool(problem.free[place]) is not before:
                state = "an obstacle" if before else "free"
                text = f"cell {cell} is {state} already, so this changes nothing"
                faults.append(fault(workload, path, text, "name another cell, or leave it out"))
            elif before and place in {*problem.goals, *problem.starts}:
                what = "goal" if place in problem.goals else "start"
                text = f"cell {cell} is a {what}, which cannot become an obstacle"
                faults.append(fault(workload, path, text, f"name another cell, or move the {what}"))
    return (None if faults else MapChange(tuple(moved["blocked"]), tuple(moved["freed"]))), faults


def _outside(cell: Cell, problem: Problem) -> tuple[str, str]:
    """The fault of a cell outside of the map that is planned on, and the remedy."""
    first, last = problem.corner, problem.named((problem.rows - 1, problem.columns - 1))
    if first == (0, 0):
        return outside_map(cell, problem.shape)
    return (f"cell {cell} is outside of the cropped map", f"(row, column) from {first} to {last}, or leave crop out")


def _drawn(workload: Workload, problem: Problem, change: DrawnChange) -> tuple[MapChange | None, list[Fault]]:
    """Free cells in random order; one that would cut a start off is passed over."""
    keep = np.zeros(problem.shape, np.bool_)
    for cell in (*problem.goals, *problem.starts):
        keep[cell] = True
    candidates = np.argwhere(problem.free & ~keep)
    order = np.random.Generator(np.random.PCG64(change.seed)).permutation(len(candidates))
    chosen = _kept_apart(problem, candidates[order], change.count)
    if len(chosen) == change.count:
        return MapChange(blocked=tuple((int(row), int(column)) for row, column in chosen)), []
    text = (
        f"{change.count} cells cannot be blocked: {len(chosen)} were found that leave every start a path, of"
        f" {len(candidates)} free cells that are no start and no goal"
    )
    return None, [fault(workload, (*_CHANGE, "count"), text, f"at most {len(chosen)}, or another seed")]


def _kept_apart(problem: Problem, cells: np.ndarray, count: int) -> np.ndarray:
    """The first ``count`` of ``cells``, n × 2, that can be blocked together with every start still joined to a goal.

    Cells are tried in runs: a run that cuts a start off is halved, down to the single cell, which is passed over. At
    most ``MOST_TRIALS`` searches of the map.
    """
    free = problem.free.copy()
    starts = np.array(problem.starts, np.int64).reshape(-1, 2)
    joined = starts[maps.reachable(free, problem.goals)[tuple(starts.T)]]
    chosen: list[np.ndarray] = []
    taken = position = trials = 0
    run = count
    while taken < count and position < len(cells) and trials < MOST_TRIALS:
        part = cells[position : position + max(1, min(run, count - taken))]
        free[tuple(part.T)] = False
        trials += 1
        if maps.reachable(free, problem.goals)[tuple(joined.T)].all():
            chosen.append(part)
            taken, position, run = taken + len(part), position + len(part), 2 * run
            continue
        free[tuple(part.T)] = True
        position += len(part) == 1
        run = max(1, len(part) // 2)
    return np.concatenate(chosen) if chosen else cells[:0]


def _cut_off(workload: Workload, planner: Planner, parameters: object, problem: Problem) -> list[Fault]:
    """The starts that the planner's moves lead to a goal before the change, and to none after it."""
    before = planner.reachable(Job(problem, parameters))
    after = planner.reachable(Job(problem.changed, parameters))
    lost: list[Cell] = [start for start in problem.starts if before[start] and not after[start]]
    if not lost:
        return []
    named = ", ".join(str(problem.named(start)) for start in lost[:_NAMED])
    more = f" and {len(lost) - _NAMED} more" if len(lost) > _NAMED else ""
    text = f"after the change no path leads from start {named}{more} to a goal"
    return [fault(workload, _CHANGE, text, "leave a passage open, or leave these starts out")]
