"""Bind: platform and workload become one frozen system, with the map read and every name resolved.

Faults that only the map shows (a goal on an obstacle, a start that leads nowhere) are found here: all at once, each
with its place in the workload file.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.errors import CodesignError, Fault, InputError, RunError, SpecError, UnsuitedError, choose_hint
from codesign.ground.figures import Figure
from codesign.ground.models import Part, TaskParameters
from codesign.inputs import Platform, Workload, cross_check, fault
from codesign.inputs.components import FpgaComponent, ProcessorComponent
from codesign.inputs.edit import on_platform
from codesign.inputs.problem import ProblemSpec
from codesign.maps import OccupancyGrid
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.planners.interface import Planner, Problem
from codesign.planners.job import Job
from codesign.planners.styles import Architecture, Step
from codesign.system import catalog
from codesign.system.assemble import platform_faults
from codesign.system.change import with_task
from codesign.system.place import Placement, a_type, external_of, map_work_notes, memory_faults, place
from codesign.system.problem_map import Places, grid_faults, length_notes, map_notes, reach_notes
from codesign.system.scenario import Draft, ScenarioRules

# The code of a planner, which any package may bring: its failures are named after it.


@contextmanager
def planner_code(planner: Planner) -> Iterator[None]:
    """Around the code of a planner, which any package may bring.

    Raises:
        RunError: the code raised an error that is not of this package; named with the planner.
    """
    try:
        yield
    except CodesignError:
        raise
    except Exception as failed:
        text = " ".join(f"{type(failed).__name__}: {failed}".split())[:200]
        raise RunError(f"planner {planner.name} failed: {text}", planner.name) from failed


def planner_steps(planner: Planner, steps: Iterable[Step]) -> Generator[Step, None, Any]:
    """The steps of a planner's style, with failures of its code named after it."""
    source = iter(steps)
    while True:
        with planner_code(planner):
            try:
                step = next(source)
            except StopIteration as done:
                return done.value
        yield step


@dataclass(frozen=True, eq=False)
class Design:
    """The configuration of one FPGA: a style, and the job that it is asked about.

    ``task``: the task that is placed by itself; empty of the design that plans.
    """

    style: Any
    job: Job[Any, Any]
    task: str = ""


@dataclass(frozen=True, eq=False)
class System(Draft):
    """One design point, all settled: the input of ``fit`` and of a run.

    - ``planner``: it computes the plan, without a clock. ``component``: the name of the component that it runs on
      (``Machine.planning_component``). ``part``: its chip, or None on a processor. ``clock``: in Hz.
      ``memory``: bytes of RAM of a processor, a figure, or None.
    - ``placement``: the component of each task.
    - ``external``: the memory beside the FPGA that holds what does not fit in block RAM; None if none is asked for.
    - ``parameters``: the parameters of each mapped task, as the style runs with them.
    - ``notes``: see ``Architecture.notes``.
    - ``found``: by task and parameter, the proof of a value that was left to a search.
    """

    component: str
    part: Part | None
    memory: Figure | None
    clock: int
    placement: Placement
    external: ExternalMemoryLaw | None
    parameters: Mapping[str, TaskParameters]
    notes: tuple[str, ...]
    found: Mapping[str, Mapping[str, Any]]

    def spec(self, name: str) -> Any:
        """The spec of a component or link."""
        return self.platform.links.get(name) or self.platform.components[name]

    def figure(self, name: str, key: str) -> Figure:
        """A figure of the spec of a component or link, by its key."""
        figure: Figure = self.spec(name).figure(key)
        return figure

    @property
    def job(self) -> Job[Any, Any]:
        """The job that planner and style are asked about: the whole problem, before any of it is planned.

        The robot stands at the first start of the problem, if it has one.
        """
        starts = self.problem.starts if isinstance(self.problem, Problem) else ()
        row, column = starts[0] if starts else (0, 0)
        return Job(
            self.problem,
            self.planning,
            part=self.part,
            memory=self.memory,
            inside=self.placement.inside,
            mapped=frozenset(self.parameters),
            external=self.external,
            position=(float(row), float(column)),
        )

    @property
    def designs(self) -> dict[str, Design]:
        """The design on each FPGA that has one, by its name; the one that plans comes first."""
        fpgas, placement = self.platform.of(FpgaComponent), self.placement
        found = {self.component: Design(self.architecture, self.job)} if self.component in fpgas else {}
        for task, style in placement.styles.items():
            name = placement.places[task]
            if name in fpgas and name not in found and task not in placement.inside:
                job = Job(self.problem, self.planning, part=fpgas[name].chip)
                found[name] = Design(style, job, task)
        return found


def bind_to(
    platform: Platform, workload: Workload, scenario: ScenarioRules, *, grid: OccupancyGrid | None = None
) -> System:
    """Join platform and workload.

    ``scenario``: the one that the workload names. ``grid``: the workload's map, where it was read already; by default
    it is read.

    Raises:
        SpecError: every fault that stands between them, each with its place in the file that holds it; UnsuitedError
            where the workload by itself is sound.
        InputError: the planner plug-in lists flows that cannot be.
    """
    cross_check(platform, workload)
    workload = on_platform(platform, workload)
    planner = catalog.planner(workload.planner)
    task = workload.mapping.get(planner.planning_task)
    if task is None:
        raise SpecError([*plannable(workload, scenario, grid=grid)[1], *platform_faults(platform)])
    architecture, faults = _architecture(platform, workload, planner)
    declared = task.parameters
    if architecture is not None:
        # Planner, laws and results are given what the style makes of the parameters.
        task = task.model_copy(update={"parameters": architecture.settled(declared)})
        workload = workload.model_copy(update={"mapping": {**workload.mapping, planner.planning_task: task}})
    problem, of_workload = plannable(workload, scenario, grid=grid)
    faults += [*of_workload, *platform_faults(platform)]
    draft = placement = None
    if problem is not None and architecture is not None and not of_workload:
        draft = Draft(platform, workload, scenario, planner, architecture, problem)
        of_scenario = scenario.faults_on(draft)
        faults += of_scenario
        if not of_scenario:
            placement, more = place(draft)
            faults += more
        faults += memory_faults(draft)
    if faults or draft is None or placement is None:
        raise (SpecError if of_workload else UnsuitedError)(faults)
    # place() refuses all others.
    fpga = platform.of(FpgaComponent).get(task.component)
    component = fpga or platform.of(ProcessorComponent)[task.component]
    system = System(
        **vars(draft),
        component=task.component,
        part=component.chip,
        memory=component.ram,
        clock=int(component.clock.value),
        placement=placement,
        external=external_of(draft),
        parameters={name: mapped.parameters for name, mapped in workload.mapping.items()},
        notes=(
            *map_notes(workload, grid),
            *(reach_notes(draft.problem) if isinstance(draft.problem, Problem) else ()),
            *length_notes(draft.problem),
            *draft.architecture.notes(Job(draft.problem, declared)),
            *map_work_notes(draft, placement),
        ),
        found={},
    )
    return with_found(system) if system.planning.to_find else system


def with_found(system: System) -> System:
    """The system with the values of the parameters that are left to a search.

    Raises:
        UnsuitedError: they cannot be found, each with its place in the workload.
    """
    task, keys = system.planner.planning_task, system.planning.to_find
    found, what, hint = None, f"style {system.architecture.style} has no search for it", "give its value"
    try:
        found = system.architecture.find(system.job)
    except InputError as wrong:
        what, hint = wrong.what, wrong.hint or hint
    if found is None or found.parameters.to_find:
        raise UnsuitedError(fault(system.workload, ("mapping", task, key), what, hint) for key in keys)
    mapped = system.workload.mapping[task].model_copy(update={"parameters": found.parameters})
    mapping = {**system.workload.mapping, task: mapped}
    return replace(
        system,
        workload=system.workload.model_copy(update={"mapping": mapping}),
        parameters={**system.parameters, task: found.parameters},
        notes=(*system.notes, *found.notes),
        found={f"{task}.{key}": proof for key, proof in found.proofs.items()},
    )


def plannable(
    workload: Workload, scenario: ScenarioRules, *, grid: OccupancyGrid | None = None
) -> tuple[Problem | None, list[Fault]]:
    """The problem of a workload, and every fault of it that is known without a platform.

    ``scenario``, ``grid``: as for ``bind_to``. The problem is None where its planner cannot be asked to plan it.
    """
    planner = catalog.planner(workload.planner)
    task = workload.mapping.get(planner.planning_task)
    if task is None:
        text = f"planner {planner.name} needs task {planner.planning_task}, which no component is given"
        hint = f"add {planner.planning_task}: {{component: ...}}"
        return None, [fault(workload, ("mapping",), text, hint)]
    instead = scenario.instead(planner)
    if instead is not None:
        text = f"scenario {scenario.type} is not for planner {planner.name}"
        return None, [fault(workload, ("scenario", "type"), text, f"scenario {instead}, or another planner")]
    problem, faults = _problem(workload, scenario, planner, task.parameters, grid)
    if problem is None:
        return None, faults
    checked = _to_check(planner, task.parameters, problem) if scenario.begins_anywhere else problem
    wrong = planner.check(Job(checked, task.parameters, mapped=frozenset(workload.mapping)))
    if wrong is not None:
        key, what = wrong
        own = key in type(workload.problem).model_fields
        path = ("problem", key) if own else ("mapping", planner.planning_task, key)
        faults.append(fault(workload, path, what, f"change {key}, or the problem"))
    return None if faults else problem, faults + scenario.faults(workload, planner, problem)


def _architecture(platform: Platform, workload: Workload, planner: Planner) -> tuple[Architecture | None, list[Fault]]:
    """The style of the planning task, or why there is none."""
    task_name = planner.planning_task
    task = workload.mapping[task_name]
    component = platform.components[task.component]
    styles_by_name = catalog.styles_of(planner.name)
    styles = {name: style for name, style in styles_by_name.items() if style.component_type == component.type}
    if not styles:
        text = f"task {task_name} is on {task.component}, which is {a_type(component.type)}"
        if component.plans:
            text += f": {planner.name} has no style for it"
        types = " or ".join(sorted({style.component_type for style in styles_by_name.values()}))
        hint = f"place it on a component of type {types}"
        return None, [fault(workload, ("mapping", task_name, "component"), text, hint)]
    wanted = task.style or next(iter(styles), "")
    if wanted in styles:
        return styles[wanted], []
    text = f"{planner.name} has no style {wanted!r} on a component of type {component.type}"
    return None, [fault(workload, ("mapping", task_name, "style"), text, choose_hint(wanted, styles))]


def _problem(
    workload: Workload, scenario: ScenarioRules, planner: Planner, parameters: Any, grid: OccupancyGrid | None
) -> tuple[Problem | None, list[Fault]]:
    """The planner's own kind of problem; or the map with its goals and starts, or every fault in them."""
    if not isinstance(workload.problem, ProblemSpec):
        return workload.problem.problem(), []  # type: ignore[attr-defined]
    grid, faults = grid_faults(workload, grid)
    if grid is None:
        return None, faults
    places = Places(workload, grid)
    faults = places.faults
    if not faults and not scenario.begins_anywhere and not planner.answers_no_way:
        whole = Problem(grid.free, places.goals, places.starts)
        faults = _reach_faults(workload, planner, parameters, whole)
    if faults:
        return None, faults
    asked, faults = with_task(workload, planner, parameters, places.problem())
    return None if faults else asked, faults


def _to_check(planner: Planner, parameters: Any, problem: Problem) -> Problem:
    """The problem that the planner checks for a scenario that may begin where no path leads to a goal.

    There the planner checks the map alone, and each problem of the run once that comes.
    """
    reach = planner.reachable(Job(problem, parameters))
    if all(reach[start] for start in problem.starts):
        return problem
    return replace(problem, starts=problem.goals)


def _reach_faults(workload: Workload, planner: Planner, parameters: Any, problem: Problem) -> list[Fault]:
    """Goals that the planner leads no other cell to, though there are others, and starts that it leads to no goal."""

    def alone(goal: tuple[int, int]) -> bool:
        return int(planner.reachable(Job(replace(problem, goals=(goal,)), parameters)).sum()) == 1

    elsewhere = int(problem.free.sum()) > len(set(problem.goals))
    faults = []
    for index, goal in enumerate(problem.goals):
        # Most goals have a free cell beside them: only of the others the planner is asked.
        if elsewhere and not _has_free_neighbour(problem.free, goal) and alone(goal):
            text = f"goal {goal} is walled in: the moves of planner {planner.name} lead there from no other cell"
            hint = "move it to where a robot can come from, or open the map beside it"
            faults.append(fault(workload, ("problem", "goals", index), text, hint))
    if faults or not (isinstance(workload.problem, ProblemSpec) and isinstance(workload.problem.starts, tuple)):
        return faults
    reach = planner.reachable(Job(problem, parameters))
    for index, start in enumerate(problem.starts):
        if not reach[start]:
            near = maps.nearest_free(reach, start)
            hint = f"the nearest cell from which a path leads to a goal is {near}"
            text = f"no path leads from start {start} to a goal"
            faults.append(fault(workload, ("problem", "starts", index), text, hint))
    return faults


def _has_free_neighbour(free: NDArray[np.bool_], cell: tuple[int, int]) -> bool:
    row, column = cell
    around = ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1))
    return any(
        0 <= beside < free.shape[0] and 0 <= across < free.shape[1] and bool(free[beside, across])
        for beside, across in around
    )
