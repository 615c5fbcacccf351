"""What is asked of every planner, and timed: a path from each start, a field, a new plan after a change."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.models import Task
from codesign.ground.records import TrajectoryRecord
from codesign.planners.interface import Problem, Quality
from codesign.system import point_of
from codesign.system.energy import watts_of
from codesign.system.results.result import Result, TaskFigures
from codesign.system.scenarios import bind, simulate
from codesign.system.scenarios.requests import requests_of
from codesign.system.scenarios.run import ready

MAZE = {"generate": "maze", "rows": 24, "columns": 40, "corridor": 4, "wall": 1, "loops": 0.2, "seed": 3}
GOAL = [2, 37]
STARTS = [[22, 1], [1, 1], [12, 21], [3, 30]]
CHANGE = {"count": 6, "seed": 2}

DESIGNS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "harmonic": ("virtex4-pci", "labyrinth", {"relax.block": [12, 20]}),
    "harmonic decided on the host": ("virtex4-pci", "labyrinth", {"relax.block": [12, 20], "decide.component": "host"}),
    "harmonic on a host": (
        "virtex4-pci",
        "labyrinth",
        {"relax.component": "host", "relax.style": "software", "decide.component": "host", "relax.schedule.last": 63},
    ),
    "wave in tiles": ("virtex4-pci", "wavefront-tiles", {"propagate.tile": [12, 20]}),
    "wave of delay lines": ("virtex4-pci", "wavefront-tiles", {"propagate.style": "delay_line"}),
    "whole wave, complete paths": (
        "virtex4-pci",
        "wavefront-tiles",
        {"propagate.stop": "whole_map", "propagate.course": "complete"},
    ),
    "wave of adders": (
        "wavefront-array",
        "wavefront-rooms",
        {"propagate.style": "adder_comparator", "fpga.clock": "10 MHz"},
    ),
    "safe wave": ("virtex4-pci", "wavefront-tiles", {"propagate.tile": [12, 20], "propagate.paths": "safe"}),
    "wave on a host": (
        "virtex4-pci",
        "wavefront-tiles",
        {"propagate.component": "host", "propagate.style": "software", "track.component": "host"},
    ),
    "breadth-first": ("virtex2pro", "breadth-first", {}),
    "breadth-first, path on the host": ("virtex2pro", "breadth-first", {"track.component": "powerpc"}),
    "breadth-first on a host": ("pentium4-java", "breadth-first-java", {"search.style": "software"}),
    "relaxation": ("pc-3400mhz", "floor-plan", {}),
}


def asked(name: str, starts: Any = None, **problem: Any) -> tuple[Any, Any]:
    """Platform and workload of a design, asked for a task on the maze."""
    platform, workload, settings = DESIGNS[name]
    spec = {"map": MAZE, "goals": [GOAL], "starts": STARTS if starts is None else starts, **problem}
    loaded = codesign.load_platform(platform), codesign.load_workload(workload)
    return point_of(*loaded, {**settings, "workload.problem": spec})


def figures(result: Result) -> TaskFigures:
    assert result.task is not None
    return result.task


def times(task: TaskFigures) -> dict[str, Any]:
    return {name: value for name, value in task.model_dump().items() if name.endswith("_s")}


@pytest.mark.parametrize("task", list(Task))
@pytest.mark.parametrize("name", DESIGNS)
def test_the_order_of_starts_changes_no_time(name: str, task: Task) -> None:
    """A search took 616 ns or 21.13 ms, by the start that happened to be first."""
    change = {"change": CHANGE} if task is Task.REPLAN else {}
    results = [simulate(*asked(name, starts, task=task.value, **change)) for starts in (STARTS, STARTS[::-1])]
    first, second = results
    assert figures(first) == figures(second)
    assert (first.feasible, first.reasons, first.resources) == (second.feasible, second.reasons, second.resources)
    assert first.energy == second.energy
    assert figures(first).task == task.value


@pytest.mark.parametrize("task", [Task.PATH, Task.REPLAN])
@pytest.mark.parametrize("name", DESIGNS)
def test_each_start_is_timed_as_if_it_were_asked_alone(name: str, task: Task) -> None:
    """Starts that share a plan, or are answered alike, are simulated once: the times are those of each by itself."""
    change = {"change": CHANGE} if task is Task.REPLAN else {}
    system = bind(*asked(name, task=task.value, **change))
    machine = ready(system).machine
    boards = {name: watts_of(power) for name, power in ready(system).held.boards.items()}
    assert machine is not None
    together = requests_of(machine, boards, None).all
    for start, request in zip(system.problem.starts, together, strict=True):
        own = replace(system, problem=system.problem.asked_from(start))
        alone = ready(own).machine
        assert alone is not None
        answer = requests_of(alone, boards, None).first.answer
        assert answer.parts == request.answer.parts, start
        assert answer.answered > 0


def test_a_search_depends_on_its_start_and_a_field_does_not() -> None:
    search = figures(simulate(*asked("breadth-first")))
    assert search.plan_time_worst_s > 1.2 * search.plan_time_mean_s
    assert search.plan_time_mean_s < search.plan_time_95_s <= search.plan_time_worst_s
    field = figures(simulate(*asked("harmonic")))
    assert field.plan_time_mean_s == field.plan_time_95_s == field.plan_time_worst_s
    parts = field.map_mean_s + field.planning_mean_s + field.answer_mean_s
    assert parts == pytest.approx(field.plan_time_mean_s, rel=1e-12)


@pytest.mark.parametrize("name", DESIGNS)
def test_a_field_leads_from_every_cell(name: str) -> None:
    result = simulate(*asked(name, task="field"))
    quality = result.quality
    assert isinstance(quality, Quality)
    assert quality.planned_cells == quality.reachable_cells
    assert quality.share_reaching_goal == 1.0
    assert figures(result).arrive == 1.0
    assert result.cycles is not None
    # Nobody is answered: no path is marked and no direction decided.
    assert not {"path", "track", "decide", "search"} & set(result.cycles)
    assert figures(result).plan_time_mean_s == figures(result).plan_time_worst_s


@pytest.mark.parametrize("name", ["wave in tiles", "wave of delay lines", "wave on a host"])
def test_the_wave_of_a_field_runs_to_its_end_whatever_stop_says(name: str) -> None:
    system = bind(*asked(name, task="field"))
    assert system.planning.stop == "starts"
    result = simulate(*asked(name, task="field"))
    assert "stop_potential" not in result.details
    assert "whatever stop says" in figures(result).text


def test_the_directions_of_a_search_everywhere_are_as_short_as_searches() -> None:
    problem = bind(*asked("breadth-first", task="field")).problem
    planner = bind(*asked("breadth-first")).planner
    from codesign.planners.job import Job

    everywhere = planner.plan(Job(problem, None))
    for start in problem.starts:
        there, arrived = planner.trajectory(problem, everywhere, start)
        alone = replace(problem, task=Task.PATH).asked_from(start)
        path, _ = planner.trajectory(alone, planner.plan(Job(alone, None)), start)
        assert arrived
        assert len(there) == len(path)
        assert (there[0] == start).all()
        assert tuple(there[-1]) == problem.goals[0]


def test_a_search_of_a_field_has_one_goal() -> None:
    with pytest.raises(SpecError) as wrong:
        bind(*asked("breadth-first", task="field", goals=[GOAL, [22, 1]], starts=[[1, 1]]))
    (fault,) = wrong.value.faults
    assert fault.file == "--set workload.problem.goals"
    assert "there are 2 goals: name one, or take task path" in fault.what


@pytest.mark.parametrize("name", ["harmonic", "wave in tiles", "breadth-first", "relaxation"])
def test_a_replan_sends_the_change_and_plans_the_changed_map(name: str) -> None:
    path = simulate(*asked(name))
    replanned = simulate(*asked(name, task="replan", change=CHANGE))
    before, after = figures(path), figures(replanned)
    assert after.changed_cells == 6
    assert after.map_mean_s < before.map_mean_s or before.map_mean_s == 0
    # The plan before the change is the same plan; the times are those after it.
    assert replanned.time == path.time
    assert replanned.cycles is not None
    assert path.cycles is not None
    assert sum(replanned.cycles.values()) > sum(path.cycles.values())
    assert after.arrive == 1.0


def test_a_replan_may_go_on_from_old_values() -> None:
    restart, onward = (
        figures(simulate(*asked("harmonic", task="replan", change={**CHANGE, "policy": policy})))
        for policy in ("restart", "continue")
    )
    assert restart.planning_mean_s != onward.planning_mean_s
    default = figures(simulate(*asked("harmonic", task="replan", change=CHANGE)))
    assert times(default) == times(restart)


def test_a_drawn_change_leaves_every_start_its_path() -> None:
    problem = bind(*asked("harmonic", task="replan", change={"count": 60, "seed": 1})).problem
    assert isinstance(problem, Problem)
    assert int(problem.free.sum()) - int(problem.changed.free.sum()) == 60
    assert np.array_equal(problem.changed.changed.free, problem.free)
    again = bind(*asked("harmonic", task="replan", change={"count": 60, "seed": 1})).problem
    assert again.change == problem.change
    other = bind(*asked("harmonic", task="replan", change={"count": 60, "seed": 2})).problem
    assert other.change != problem.change


@pytest.mark.parametrize(
    ("change", "key", "what"),
    [
        ({"blocked": [[0, 14]]}, "change.blocked[0]", "is an obstacle already"),
        ({"blocked": [[99, 0]]}, "change.blocked[0]", "outside"),
        ({"freed": [[1, 1]]}, "change.freed[0]", "is free already"),
        ({"blocked": [GOAL]}, "change.blocked[0]", "is a goal"),
        ({"blocked": [STARTS[0]]}, "change.blocked[0]", "is a start"),
        ({"blocked": [[21, 1], [23, 1], [22, 0], [22, 2]]}, "change", "no path leads from start (22, 1) to a"),
        ({"count": 9_000}, "change.count", "9000 cells cannot be blocked"),
        ({"count": 5, "policy": "lower_bound"}, "change.policy", "nobody makes the lower bound"),
    ],
)
def test_a_change_that_cannot_be(change: Any, key: str, what: str) -> None:
    with pytest.raises(SpecError) as wrong:
        bind(*asked("harmonic", task="replan", change=change))
    assert [fault.file for fault in wrong.value.faults] == [f"--set workload.problem.{key}"]
    assert what in wrong.value.faults[0].what
    assert wrong.value.faults[0].hint


@pytest.mark.parametrize(
    ("problem", "key"),
    [
        ({"task": "replan"}, "task"),
        ({"task": "paths"}, "task"),
        ({"task": "replan", "change": {}}, "change"),
        ({"task": "replan", "change": 5}, "change"),
        ({"task": "replan", "change": {"blocked": [[1, 2]], "freed": [[1, 2]]}}, "change.freed[0]"),
        ({"task": "replan", "change": {"count": 0}}, "change.count"),
        ({"arrive": 1.5}, "arrive"),
    ],
)
def test_mistakes_in_a_task(problem: Any, key: str) -> None:
    with pytest.raises(SpecError) as wrong:
        asked("harmonic", **problem)
    assert [fault.file for fault in wrong.value.faults] == [f"--set workload.problem.{key}"]


def test_a_listened_run_records_the_first_start_alone() -> None:
    records: list[Any] = []
    listened = simulate(*asked("breadth-first"), listeners=[records.append])
    assert listened == simulate(*asked("breadth-first"))
    paths = [record for record in records if isinstance(record, TrajectoryRecord)]
    assert len(paths) == len(STARTS)
    assert {record.time for record in paths} == {max(record.time for record in paths)}
    ended = max(record.time for record in paths)
    assert ended / 1e12 >= listened.figure(codesign_figure("first_plan_s"))


def codesign_figure(name: str) -> Any:
    from codesign.ground.figures import FIGURES

    return FIGURES[name]


def test_a_plan_of_too_few_starts_is_not_feasible() -> None:
    """ "Feasible: yes" with no start arriving, at the precision that a lever recommends."""
    platform, workload = asked("harmonic")
    few = point_of(platform, workload, {"relax.schedule": [7]})
    result = simulate(*few, levers=True)
    (reason,) = result.reasons
    arrived = result.quality.starts_arrived if isinstance(result.quality, Quality) else 0
    assert (reason.kind, reason.name) == ("quality", "starts arrived")
    assert (reason.demand, reason.limit, reason.gap) == (arrived, 4, 4 - arrived)
    assert not result.feasible
    # The figures of the run stay, and so do those of the task.
    assert result.simulated
    assert result.time is not None
    assert figures(result).arrive == arrived / 4
    (lever,) = reason.levers
    bits = int(lever.partition("end at ")[2].partition(" ")[0])
    assert lever == f"relax.schedule: end at {bits} bits: fits, and 4 of 4 starts arrive"
    assert simulate(*point_of(platform, workload, {"relax.schedule": [7, bits]})).feasible


def test_a_share_of_the_starts_may_be_enough() -> None:
    platform, workload = point_of(*asked("harmonic", arrive=0.0), {"relax.schedule": [7]})
    assert simulate(platform, workload).feasible


def test_a_lever_is_tried_before_it_is_advised() -> None:
    """A block that fits, with precision that leads from too few starts, is named with what came of it."""
    platform, workload = asked("harmonic")
    large = point_of(platform, workload, {"relax.block": [1, 2], "relax.schedule.last": 255})
    told = simulate(*large, levers=True)
    assert not told.simulated
    levers = [lever for reason in told.reasons for lever in reason.levers]
    tried = [lever for lever in levers if "starts arrive" in lever]
    assert tried
    for lever in tried:
        if lever.startswith("relax.schedule"):
            bits = int(lever.partition("end at ")[2].partition(" ")[0])
            moved = point_of(platform, workload, {"relax.block": [1, 2], "relax.schedule": [bits]})
            result = simulate(*moved)
            assert isinstance(result.quality, Quality)
            assert f"{result.quality.starts_arrived} of 4 starts arrive" in lever
            assert ("fits, and" in lever) is result.feasible
    untried = [lever for reason in simulate(*large).reasons for lever in reason.levers]
    assert not any("arrive" in lever for lever in untried)


def test_robots_plan_together() -> None:
    platform, workload = codesign.load_platform("nexys2"), codesign.load_workload("robots-2")
    result = simulate(platform, workload)
    assert result.time is not None
    assert figures(result).task == "robots"
    assert figures(result).plan_time_worst_s == result.time.first_plan_s


def test_a_drive_asks_for_paths() -> None:
    platform, workload = codesign.load_platform("virtex4-pci"), codesign.load_workload("office-harmonic")
    with pytest.raises(SpecError) as wrong:
        bind(*point_of(platform, workload, {"workload.problem.task": "field"}))
    (fault,) = wrong.value.faults
    assert fault.file == "--set workload.problem.task"
    assert "for scenario plan_once" in fault.what
