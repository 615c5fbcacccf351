"""The rules of the contract, in the order in which they are checked: declarations first.

``RULES`` has every function under ``rule``.
"""

from __future__ import annotations

import pickle
from collections import Counter
from dataclasses import replace
from itertools import islice, pairwise
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.figures import RESOURCES, Figure, Status
from codesign.ground.memo import Memo
from codesign.ground.models import SpecModel, TaskParameters
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.design import digest_of_circuit
from codesign.hardware.rtl.verify import verify
from codesign.inputs.components import PLANNING_TYPES
from codesign.planners.circuits import MOST_KINDS, Circuit, CircuitStyle, Expected
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.planners.interface import COMMAND, LOAD, LOWER_BOUND, POSE, Planner, Policy, Quality, RobotsQuality
from codesign.planners.job import Demand
from codesign.planners.plug_in import PlugIn
from codesign.planners.styles import Architecture, Memory, TaskStyle
from codesign.system.place import sound_flows
from codesign.testing.case import Case, Rule, Run, drained, names, of, on_maps, require, rule

# Rules of the declarations of a plug-in: names, types, and members that have a default.

POLICIES = set(get_args(Policy))
FIGURES = {"stages", "precision", "details"}


def _is_count(value: Any) -> bool:
    return type(value) is int and value >= 0


def _is_line(text: Any) -> bool:
    return isinstance(text, str) and bool(text.strip()) and "\n" not in text and not text.endswith(".")


@rule()
def plug_in_holds_parts_of_one_planner(case: Case) -> None:
    """A ``PlugIn`` of a planner with at least one style, all of them the planner's own, none twice."""
    plug_in, planner = case.plug_in, case.planner
    require(isinstance(plug_in, PlugIn), f"a {type(plug_in).__name__} is given, not a PlugIn")
    require(isinstance(planner, Planner), f"{planner!r} does not derive from codesign.plugin.Planner")
    for style, base in [(style, Architecture) for style in case.styles] + [
        (style, TaskStyle) for style in case.task_styles
    ]:
        require(isinstance(style, base), f"{style!r} does not derive from codesign.plugin.{base.__name__}")
        require(style.planner == planner.name, f"{of(style)} is of planner {style.planner!r}, not of {planner.name!r}")
    require(plug_in.planner is None or case.styles, "no style: nothing can run the planner")
    require(case.styles or case.task_styles, "neither a planner nor a style is registered")
    keys = Counter(style.style for style in case.styles)
    require(max(keys.values(), default=1) == 1, f"two styles have one name, of {names(keys)}")
    tasks = Counter((style.task, style.component_type, style.style) for style in case.task_styles)
    require(max(tasks.values(), default=1) == 1, f"two styles of one task have one name, of {names(tasks)}")
    for kernel, probe in plug_in.probes.items():
        require(kernel and callable(probe), f"the probe of kernel {kernel!r} cannot be called")


@rule()
def planner_names_its_planning_task(case: Case) -> None:
    """``planning_task`` is one of ``tasks``, and each has a model of parameters."""
    planner = case.planner
    require(planner.name, "the planner has no name")
    require(_is_line(planner.description), f"description {planner.description!r} is no line without a full stop")
    sound = planner.planning_task in planner.tasks
    require(sound, f"planning task {planner.planning_task!r} is none of the tasks {names(planner.tasks)}")
    for task, model in planner.tasks.items():
        sound = isinstance(model, type) and issubclass(model, TaskParameters)
        require(sound, f"task {task!r} has parameters of {model!r}, which is no subclass of TaskParameters")
    for style in case.task_styles:
        require(style.task in planner.tasks, f"{of(style)} is of no task of {names(planner.tasks)}")


@rule()
def planner_members_have_their_types(case: Case) -> None:
    """Members with defaults keep the types of ``Planner``, and the sample parameters fit the problem."""
    planner, job = case.planner, case.job
    model: Any = planner.problem_model
    sound = model is None or (isinstance(model, type) and issubclass(model, SpecModel))
    require(sound, f"problem_model {model!r} is neither None nor a subclass of SpecModel")
    require(type(planner.answers_no_way) is bool, f"answers_no_way is {planner.answers_no_way!r}, not a boolean")
    wrong: Any = planner.check(job)
    require(wrong is None, f"check refuses the sample parameters: {wrong!r}; give others")
    refused: Any = planner.check_drive(job)
    sound = isinstance(refused, tuple) and len(refused) == 3 and all(isinstance(each, str) for each in refused)
    require(refused is None or sound, f"check_drive gives {refused!r}, not (key, sentence, hint) or None")
    taken = planner.memory(job)
    require(_is_count(taken), f"memory gives {taken!r}, not a number of bytes")
    levers: Any = planner.memory_levers(job)
    require(isinstance(levers, list), f"memory_levers gives {levers!r}, not a list of texts")
    require(all(isinstance(lever, str) for lever in levers), f"memory_levers gives {levers!r}, not texts")
    fields = planner.fields_a_stage
    require(_is_count(fields), f"fields_a_stage is {fields!r}, not a number of fields")
    horizon = planner.horizon(job)
    require(horizon is None or horizon > 0, f"horizon gives {horizon!r}, neither None nor above 0 cells")


@rule()
def figures_and_field_fit_a_result(case: Case) -> None:
    """``figures`` fills only the planner's own fields; ``field_of`` gives one float64 for each cell."""
    figures: Any = case.planner.figures(case.plan)
    require(isinstance(figures, dict), f"figures gives {type(figures).__name__}, not a dictionary")
    strange = set(figures) - FIGURES
    require(not strange, f"figures fills {names(strange)}; a planner fills only {names(FIGURES)}")
    field: Any = case.planner.field_of(case.plan)
    if field is not None:
        name, unit, values = field
        require(name and isinstance(name, str) and isinstance(unit, str), "field_of gives no name or no unit")
        shape = (case.problem.rows, case.problem.columns)
        sound = values.dtype == np.float64 and values.shape == shape
        require(sound, f"field_of gives {values.dtype} {values.shape}, not float64 {shape}")


@rule()
def policies_have_what_they_take(case: Case) -> None:
    """``restart`` is the default; ``lower_bound`` has its task, and ``continue`` has a start."""
    planner = case.planner
    require(planner.policies[:1] == ("restart",), f"the first policy of {planner.policies} is not 'restart'")
    strange = set(planner.policies) - POLICIES
    require(not strange, f"policies {names(strange)} are none of {names(POLICIES)}")
    sound = ("lower_bound" in planner.policies) == (LOWER_BOUND in planner.tasks)
    require(sound, "policy 'lower_bound' and task 'lower_bound' come together: one of them is missing")
    start = planner.start_of(case.plan)
    require(
        ("continue" in planner.policies) == (start is not None),
        f"start_of gives {type(start).__name__}: policy 'continue' needs a start, and only that policy has one",
    )


@rule(lambda case: bool(case.every_style))
def style_members_have_their_types(case: Case) -> None:
    """Members of styles keep the types of their base classes."""
    for style in case.every_style:
        require(style.style, f"a style of planner {style.planner!r} has no name")
        sound = _is_line(style.description)
        require(sound, f"description {style.description!r} of {of(style)} is no line without a full stop")
        require(style.component_type in PLANNING_TYPES, f"{of(style)} runs on none of {names(PLANNING_TYPES)}")
    for style in case.styles:
        require(type(style.supports_external) is bool, f"supports_external of {of(style)} is no boolean")
        sound = style.supports_external <= (style.component_type == "fpga")
        require(sound, f"{of(style)} runs on no FPGA and cannot keep its memories beside one")
        memory: Any = style.memory(case.job_on(style))
        if memory is not None:
            require(isinstance(memory, Memory), f"memory of {of(style)} gives {type(memory).__name__}")
            sound = memory.width > 0 and memory.words and all(words > 0 for words in memory.words.values())
            require(sound, f"memory of {of(style)} has no words or words of no bits: {memory}")


# Rules of a planner on any problem: its answers, and the flows between its tasks.


@rule()
def same_answer_twice(case: Case) -> None:
    """Equal problems and parameters have equal plans, figures and quality."""
    planner = case.planner
    first, second = (planner.plan(case.job) for _ in range(2))
    require(planner.identity(first) == planner.identity(second), "two plans of one problem differ in identity")
    require(planner.identity(first) == planner.identity(first), "one plan has two identities")
    require(planner.figures(first) == planner.figures(second), "two plans of one problem differ in figures")
    qualities = [planner.quality(case.problem, plan) for plan in (first, second)]
    require(qualities[0] == qualities[1], "two plans of one problem differ in quality")


@rule()
def another_problem_another_answer(case: Case) -> None:
    """``identity`` and the problem's ``digest`` differ for different problems."""
    other = case.planner.plan(replace(case.job, problem=case.other_problem))
    require(not case.same(other), "plans of two problems that differ have one identity")
    require(case.problem.digest != case.other_problem.digest, "two problems that differ have one digest")


@rule()
def asking_changes_nothing(case: Case) -> None:
    """A planner leaves its problem as it is; ``quality``, ``figures`` and paths leave the plan as it is."""
    planner, problem = case.planner, case.fresh_problem()
    before = {name: pickle.dumps(value) for name, value in vars(problem).items()}
    job = replace(case.job, problem=problem)
    plan = planner.plan(job)
    identity = planner.identity(plan)
    planner.flows(job)
    planner.quality(problem, plan)
    planner.figures(plan)
    planner.field_of(plan)
    planner.start_of(plan)
    if case.on_maps:
        planner.reachable(job)
        planner.trajectory(problem, plan, problem.starts[0])
        planner.path_from(problem, plan, case.position)
    require(planner.identity(plan) == identity, "a plan changes when it is asked for quality, figures or a path")
    # A digest that is computed here adds an attribute, and changes none.
    changed = [name for name, value in before.items() if pickle.dumps(vars(problem)[name]) != value]
    require(not changed, f"the planner changes {names(changed)} of the problem that it is given")


@rule()
def map_work_is_counted_in_kernels(case: Case) -> None:
    """Work on the map before it is sent has a name and a kernel, and a count that is the same each time."""
    first, second = (case.planner.map_work(case.job) for _ in range(2))
    require(first == second, "map_work differs from call to call")
    for work in first:
        require(bool(work.what and work.kernel), f"map_work has {work}: give it a name and a kernel")
        counted = type(work.units) is int and work.units >= 0
        require(counted, f"map_work counts {work.units!r} units of {work.kernel}: give an integer of 0 or more")


@rule()
def flows_lead_from_the_map_to_the_answer(case: Case) -> None:
    """Flows name tasks, have bits, make no circle, and reach the answer and the planning task from the map."""
    planner = case.planner
    try:
        flows = sound_flows(planner, case.job)
    except InputError as wrong:
        raise AssertionError(wrong.what) from wrong
    require(all(flow.name for flow in flows), "a flow has no name")
    loaded = any((flow.sender, flow.receiver) == (LOAD, planner.planning_task) for flow in flows)
    require(loaded, f"nothing flows from 'load' to the planning task {planner.planning_task!r}")
    require(
        len(case.answering) == 1, f"tasks {names(case.answering)} send an answer to 'command': exactly one must send it"
    )
    done, left = {LOAD}, list(flows)
    while ready := [
        flow for flow in left if all(other.sender in done for other in left if other.receiver == flow.receiver)
    ]:
        done |= {flow.receiver for flow in ready}
        left = [flow for flow in left if flow not in ready]
    require(
        not left, f"flows {names(flow.name for flow in left)} never start: no task sends the data that they wait for"
    )
    missing = {COMMAND, planner.planning_task} - done
    require(not missing, f"no flow leads from 'load' to {names(missing)}")


@rule()
def flows_after_a_plan_differ_in_size_only(case: Case) -> None:
    """``flows_after`` gives the flows of ``flows``, none of them larger, none empty."""
    before = case.planner.flows(case.job)
    after = case.planner.flows_after(replace(case.job, plan=case.plan))
    sound = [replace(flow, bits=1) for flow in after] == [replace(flow, bits=1) for flow in before]
    require(sound, "flows_after gives other flows than flows")
    for planned, flow in zip(after, before, strict=True):
        sound = 0 < planned.bits <= flow.bits
        require(sound, f"flow {flow.name!r} has {planned.bits} bits after the plan, at most {flow.bits} before")


@rule()
def a_pose_goes_to_the_task_that_answers(case: Case) -> None:
    """The answering task makes a decision, at a cost on every type of component that plans."""
    flows = case.planner.flows(case.job)
    asked = [(flow.sender, flow.receiver) for flow in flows if flow.name == POSE]
    sound = asked in ([], [(LOAD, case.answer)])
    require(sound, f"flow 'pose' goes {asked}; it leads from 'load' to the answering task {case.answer!r}")
    if asked and case.plug_in.planner is not None:
        planning = {style.component_type for style in case.styles}
        answering = {style.component_type for style in case.task_styles if style.task == case.answer}
        sound = planning <= answering
        require(sound, f"task {case.answer!r} has no style on {names(planning - answering)}, where the planner has one")


@rule()
def quality_is_a_record(case: Case) -> None:
    """``quality`` gives a ``Quality`` or ``RobotsQuality`` that crosses a process pool."""
    quality = case.planner.quality(case.problem, case.plan)
    sound = isinstance(quality, Quality if case.on_maps else Quality | RobotsQuality)
    require(sound, f"quality gives {type(quality).__name__}")
    require(pickle.loads(pickle.dumps(quality)) == quality, "quality does not survive pickling")


@rule()
def plans_and_parameters_cross_a_process_pool(case: Case) -> None:
    """Plan and parameters are the same after pickling."""
    try:
        plan = pickle.loads(pickle.dumps(case.plan))
        parameters = pickle.loads(pickle.dumps(case.parameters))
    except (pickle.PickleError, AttributeError, TypeError) as wrong:
        raise AssertionError(f"plan or parameters cannot be pickled: {wrong}") from wrong
    require(case.same(plan), "a plan has another identity after pickling")
    require(parameters == case.parameters, "parameters differ after pickling")


# Rules of a planner on maps: which cells lead to a goal, which paths it gives, and their quality.


def _dense(points: NDArray[np.float64], samples: int) -> NDArray[np.float64]:
    """Points along the path, ``samples`` for each piece of it."""
    return np.concatenate([np.linspace(a, b, samples) for a, b in pairwise(points)] or [points])


def _cell(point: NDArray[np.float64]) -> tuple[int, int]:
    row, column = (int(value) for value in np.floor(point + 0.5))
    return row, column


def _is_path(points: Any, begin: tuple[float, float]) -> None:
    require(points.dtype == np.float64, f"a path has points of {points.dtype}, not float64")
    require(points.ndim == 2 and points.shape[1] == 2, f"a path has shape {points.shape}, not n × 2")
    require(tuple(points[0]) == begin, f"a path from {begin} begins at {tuple(points[0].tolist())}")


@rule(on_maps)
def reachable_cells_lead_to_a_goal(case: Case) -> None:
    """``reachable`` covers the goals, free cells only, and every start from which a path arrives."""
    problem = case.problem
    reachable: Any = case.planner.reachable(case.job)
    sound = reachable.dtype == np.bool_ and reachable.shape == problem.free.shape
    require(sound, f"reachable gives {reachable.dtype} {reachable.shape}, not bool {problem.free.shape}")
    require(all(reachable[goal] for goal in problem.goals), "reachable leaves out a goal")
    require(not (reachable & ~problem.free).any(), "reachable covers an obstacle")
    for start in problem.starts:
        arrived = case.planner.trajectory(problem, case.plan, start)[1]
        require(reachable[start] or not arrived, f"a path from {start} arrives, but reachable leaves the cell out")


@rule(on_maps)
def quality_is_of_this_problem(case: Case) -> None:
    """Counts of ``quality`` are within the problem's counts, and its figures agree with each other."""
    problem = case.problem
    quality = case.planner.quality(problem, case.plan)
    assert isinstance(quality, Quality), "quality of a map is a Quality"
    reachable = int(case.planner.reachable(case.job).sum()) - len(problem.goals)
    require(
        quality.reachable_cells == reachable,
        f"quality counts {quality.reachable_cells} reachable cells, reachable gives {reachable} besides the goals",
    )
    for name, count, most in (
        ("planned_cells", quality.planned_cells, quality.reachable_cells),
        ("wrong_cells", quality.wrong_cells, quality.reachable_cells),
        ("starts_arrived", quality.starts_arrived, quality.starts),
    ):
        require(count is None or 0 <= count <= most, f"{name} is {count}, beyond 0 to {most}")
    share = quality.share_reaching_goal
    require(share is None or 0.0 <= share <= 1.0, f"share_reaching_goal is {share}")
    if share is not None and quality.local_maxima is not None:
        sound = (quality.local_maxima == 0) == (share == 1.0)
        require(sound, f"{quality.local_maxima} local maxima, but a share of {share} that reaches a goal")
    require(quality.starts == len(problem.starts), f"quality tries {quality.starts} starts of {len(problem.starts)}")
    if quality.starts_arrived:
        mean, worst = quality.path_length_ratio_mean, quality.path_length_ratio_worst
        require(mean is not None and worst is not None, "starts arrive, but no ratio of lengths is given")
        assert mean is not None
        assert worst is not None
        require(worst >= mean > 0.9, f"path length ratios {mean} (mean) and {worst} (worst) cannot be")
        room, least = quality.clearance_mean, quality.clearance_least
        require(room is not None and least is not None, "starts arrive, but no clearance is given")
        assert room is not None
        assert least is not None
        require(room >= least >= 1.0, f"clearances {room} (mean) and {least} (least) cannot be")
        require((quality.turning_mean or 0.0) >= 0.0, f"turning of {quality.turning_mean} degrees cannot be")


@rule(on_maps)
def trajectories_stay_in_free_space(case: Case) -> None:
    """Every point of a path lies in a free cell, and a path arrives if and only if it ends at a goal."""
    planner, problem = case.planner, case.problem
    arrivals = 0
    for start in problem.starts:
        points, arrived = planner.trajectory(problem, case.plan, start)
        _is_path(points, (float(start[0]), float(start[1])))
        # Points between the samples count too: ten steps between each pair.
        cells = np.floor(_dense(points, 11) + 0.5).astype(int)
        require(problem.free[cells[:, 0], cells[:, 1]].all(), f"the path from {start} leaves free space")
        sound = arrived == (_cell(points[-1]) in problem.goals)
        require(sound, f"the path from {start} says {arrived} for its arrival, and ends in cell {_cell(points[-1])}")
        arrivals += arrived
    counted: Any = planner.quality(problem, case.plan)
    require(arrivals == counted.starts_arrived, f"{arrivals} paths arrive, quality counts {counted.starts_arrived}")


@rule(on_maps)
def paths_from_any_position_keep_to_free_cells(case: Case) -> None:
    """``path_from`` begins at the position, agrees with ``trajectory`` in the middle of a cell, and ends at a goal."""
    planner, problem = case.planner, case.problem
    random = np.random.Generator(np.random.PCG64(3))
    for start in problem.starts[:12]:
        middle, arrived = planner.path_from(problem, case.plan, (float(start[0]), float(start[1])))
        for off in random.uniform(-0.49, 0.49, (8, 2)):
            position = (start[0] + float(off[0]), start[1] + float(off[1]))
            points, there = planner.path_from(problem, case.plan, position)
            _is_path(points, position)
            require(there == arrived, f"a path from {position} arrives: {there}; from its cell: {arrived}")
            dense = _dense(points, 41)
            cells = np.floor(dense + 0.5).astype(int)
            # The corner of an obstacle lies on the edge of a cell: only points inside of an obstacle count.
            inside = np.abs(dense - cells).max(axis=1) < 0.5 - 1e-9
            free = problem.free[cells[inside, 0], cells[inside, 1]].all()
            require(free, f"the path from {position} leaves free space")
            sound = not there or _cell(points[-1]) in problem.goals
            require(sound, f"the path from {position} arrives at {_cell(points[-1])}, which is no goal")
        if arrived:
            other = planner.trajectory(problem, case.plan, start)[0]
            same = middle.shape == other.shape and np.allclose(middle, other)
            require(same, f"path_from and trajectory give two paths from {start}")


@rule(on_maps)
def no_path_from_where_no_robot_can_be(case: Case) -> None:
    """From an obstacle and from outside of the map, ``path_from`` gives the position alone, and False."""
    obstacles = [(float(row), float(column)) for row, column in np.argwhere(~case.problem.free)[:1]]
    for position in (*obstacles, (-3.0, 2.0), (2.0, 1e6)):
        points, arrived = case.planner.path_from(case.problem, case.plan, position)
        sound = points.tolist() == [list(position)] and not arrived
        require(sound, f"path_from gives a path from {position}, where no robot can be")


# Rules of architecture styles and task styles: their steps end in the plan, and their laws are sound.

CLOCK = 50_000_000
"""Hz at which power is asked for."""

EXTERNAL = ExternalMemoryLaw("sram", 100_000_000, 32, 2**26, 2)
"""A memory beside the FPGA, for styles that can use one."""


def _steps_are_sound(run: Run, style: Architecture | TaskStyle) -> None:
    for step in run.steps:
        require(step.phase, f"a step of {of(style)} has no phase")
        whole = step.cycles.dtype == np.int64 and step.cycles.ndim == 1
        require(whole, f"cycles of {of(style)} in phase {step.phase!r} are no line of int64")
        sound = not len(step.cycles) or step.cycles.min() >= 1
        require(sound, f"a step of {of(style)} in phase {step.phase!r} takes less than one cycle")


def _demand_is_sound(demand: Demand, style: Architecture | TaskStyle) -> None:
    require(isinstance(demand, Demand), f"demand of {of(style)} gives {type(demand).__name__}")
    for item in demand.items:
        require(
            item.resource in RESOURCES,
            f"item {item.name!r} of {of(style)} asks for {item.resource!r}: accepted are {', '.join(RESOURCES)}",
        )
        sound = item.amount == item.figure.value >= 0
        require(sound, f"item {item.name!r} of {of(style)} asks for {item.figure.value!r} {item.resource}")
    for line in (*demand.items, *demand.bounds):
        require(line.name and line.figure.source, f"a line of the demand of {of(style)} has no name or no source")
        sound = isinstance(line.figure.status, Status)
        require(sound, f"{line.name!r} in the demand of {of(style)} has status {line.figure.status!r}")
    strange = set(demand.levers) - set(RESOURCES)
    require(not strange, f"levers of {of(style)} are for {names(strange)}: accepted are {', '.join(RESOURCES)}")
    sound = style.component_type != "processor" or not demand.items
    require(sound, f"{of(style)} runs on a processor and asks for resources of a part")


def _amounts(demand: Demand) -> Counter[tuple[str, str, Status, str]]:
    """Units by name, resource, status and source of the lines."""
    amounts: Counter[tuple[str, str, Status, str]] = Counter()
    for item in demand.items:
        amounts[item.name, item.resource, item.figure.status, item.figure.source] += item.amount
    return amounts


def _figure_is_sound(figure: Any, unit: str, what: str) -> None:
    require(isinstance(figure, Figure), f"{what} gives {type(figure).__name__}, not a Figure")
    require(figure.unit == unit, f"{what} is in {figure.unit!r}, not in {unit!r}")
    low, high = figure.interval
    require(0 <= low <= figure.value <= high, f"{what} is {figure.value}, beyond its interval {low} to {high}")
    require(isinstance(figure.status, Status), f"{what} has status {figure.status!r}")
    require(figure.source, f"{what} has no source")


def _refuses(ask: Any, what: str) -> None:
    try:
        ask()
    except InputError:
        return
    raise AssertionError(f"{what} gives a law on a processor, where the platform declares the figure")


@rule()
def work_drained_ends_in_the_plan(case: Case) -> None:
    """``work`` ends in the plan of ``Planner.plan`` with the settled parameters of the style."""
    planner = case.planner
    for style in case.styles:
        settled = style.settled(case.parameters)
        require(style.settled(settled) == settled, f"{of(style)} settles its settled parameters otherwise")
        sound = style.notes(replace(case.job, parameters=settled)) == ()
        require(sound, f"{of(style)} has notes on its own settled parameters")
        plan = planner.plan(replace(case.job, parameters=settled))
        run = case.work(style)
        _steps_are_sound(run, style)
        sound = planner.identity(run.result) == planner.identity(plan)
        require(sound, f"work of {of(style)}, drained, ends in another plan than Planner.plan")
        sound = planner.figures(run.result) == planner.figures(plan)
        require(sound, f"work of {of(style)}, drained, ends in other figures than Planner.plan")


MOST_FAMILIES = 12
"""Families of a style whose designs are looked at, the most promising ones."""


@rule(on_maps)
def designs_are_accepted(case: Case) -> None:
    """Each design that a style gives first is a sound set of parameters for its planner and for the problem."""
    planner = case.planner
    model = planner.tasks[planner.planning_task]
    for style in case.styles:
        families = islice(style.families(case.job_on(style, parameters=None)), MOST_FAMILIES)
        for design in (design for family in families for design in family.chain):
            job = case.job_on(style, parameters=model.model_validate(dict(design)))
            wrong = planner.check(job)
            require(wrong is None, f"a design of {of(style)}, {dict(design)}, is refused: {wrong}")


@rule()
def coarse_steps_cost_the_same(case: Case) -> None:
    """Without ``detail``, and from the memo, cycles by phase and the plan are the same."""
    planner, memo = case.planner, Memo()
    for style in case.styles:
        fine = case.work(style)
        for what in ("without detail", "a second time from the memo"):
            coarse = case.work(style, memo=memo, detail=False)
            sound = coarse.phases == fine.phases
            require(sound, f"{of(style)} takes {coarse.phases} cycles {what}, {fine.phases} with detail")
            same = planner.identity(coarse.result) == planner.identity(fine.result)
            require(same, f"{of(style)} ends in another plan {what}")
            sound = planner.figures(coarse.result) == planner.figures(fine.result)
            require(sound, f"{of(style)} ends in other figures {what}")


@rule()
def styles_on_a_processor_list_their_kernels(case: Case) -> None:
    """Cycles on a processor are units of listed kernels; an FPGA has none."""
    for style in case.styles:
        run = case.work(style)
        if style.component_type == "processor":
            listed = set(style.kernels(case.job))
            require("" not in listed, f"{of(style)} lists no kernel")
            used = {step.kernel or style.kernel for step in run.steps}
            require(used <= listed, f"{of(style)} counts in {names(used - listed)}, which kernels leaves out")
        else:
            used = {style.kernel, *(step.kernel for step in run.steps)} - {""}
            require(not used, f"{of(style)} counts in {names(used)}: kernels are for processors")
    for task in case.task_styles:
        sound = (task.component_type == "processor") == bool(task.kernel)
        require(sound, f"{of(task)} has kernel {task.kernel!r}: a processor needs one, and nothing else has one")


@rule(on_maps)
def programs_pay_for_their_map(case: Case) -> None:
    """On a processor the whole map is read, whichever cells the plan needs: a unit of some kernel a cell, or more."""
    cells = case.problem.free.size
    for style in case.styles:
        if style.component_type == "processor":
            units = Counter[str]()
            for step in case.work(style).steps:
                units[step.kernel or style.kernel] += int(step.cycles.sum())
            require(max(units.values()) >= cells, f"{of(style)} does not pay for the {cells} cells of its map")


@rule()
def work_leaves_out_the_answer_where_it_is_placed_elsewhere(case: Case) -> None:
    """Without the answering task inside, its phase alone is left out, and the plan is the same.

    One phase may end the work in its place: the plan is read out for the component that answers.
    """
    everything = frozenset(case.planner.tasks)
    for style in case.styles:
        whole = case.work(style)
        sound = case.work(style, inside=everything).phases == whole.phases
        require(sound, f"{of(style)} takes other cycles with every task inside than by default")
        for detail in (True, False):
            run = case.work(style, inside=case.answer_elsewhere, detail=detail)
            gone = set(whole.phases) - set(run.phases)
            sound = len(gone) <= (0 if case.answer == case.planner.planning_task else 1)
            require(sound, f"{of(style)} leaves out phases {names(gone)} where {case.answer!r} alone is done elsewhere")
            read_out = set(run.phases) - set(whole.phases)
            require(
                len(read_out) <= len(gone) and read_out <= {[*run.phases][-1]},
                f"{of(style)} adds phases {names(read_out)} where {case.answer!r} is done elsewhere, not one that"
                " reads the plan out in place of the answer",
            )
            kept = {phase: cycles for phase, cycles in whole.phases.items() if phase not in gone}
            same = {phase: cycles for phase, cycles in run.phases.items() if phase not in read_out}
            require(same == kept, f"{of(style)} takes {same} where {case.answer!r} is done elsewhere, not {kept}")
            sound = case.same(run.result) == case.same(whole.result)
            require(sound, f"{of(style)} ends in another plan where the answer is elsewhere")


@rule()
def demand_names_resources_of_a_part(case: Case) -> None:
    """Items, bounds and levers of every style are of known resources, with status and source."""
    for style in case.styles:
        _demand_is_sound(case.demand(style), style)
    for task in case.task_styles:
        _demand_is_sound(task.demand(case.job_on(task)), task)


@rule()
def what_is_done_elsewhere_takes_nothing_of_the_part(case: Case) -> None:
    """A task that is not inside adds nothing to the demand, and makes no line of it larger."""
    for style in case.styles:
        whole = case.demand(style)
        everything = case.demand(style, frozenset(case.planner.tasks))
        require(everything == whole, f"{of(style)} asks for other resources with every task inside")
        left = case.demand(style, case.answer_elsewhere)
        more = {name for name, *_ in _amounts(left) - _amounts(whole)}
        require(not more, f"{of(style)} asks for more of {names(more)} where {case.answer!r} is elsewhere")
        sound = [bound.figure.value for bound in left.bounds] == [bound.figure.value for bound in whole.bounds]
        require(sound, f"bounds of {of(style)} change where {case.answer!r} is elsewhere")
        require(set(left.levers) <= set(whole.levers), f"levers of {of(style)} are added where less is asked for")
        if style.component_type == "fpga":
            static, dynamic = style.power(whole, CLOCK, case.part)
            less_static, less_dynamic = style.power(left, CLOCK, case.part)
            require(static == less_static, f"static power of {of(style)} changes with the demand")
            saved = any(left.total(kind) < whole.total(kind) for kind in RESOURCES)
            require(
                less_dynamic.value <= dynamic.value if saved else less_dynamic == dynamic,
                f"dynamic power of {of(style)} goes from {dynamic.value} to {less_dynamic.value} W for less work",
            )


@rule(lambda case: bool(case.every_style))
def clock_limit_and_power_have_units_and_sources(case: Case) -> None:
    """On an FPGA both are figures within their intervals; on a processor the platform declares them."""
    part = case.part
    for style in case.every_style:
        job = case.job_on(style)
        demand = style.demand(job)
        if style.component_type == "fpga":
            limit = style.clock_limit(job)
            _figure_is_sound(limit, "Hz", f"clock_limit of {of(style)}")
            require(limit.value > 0, f"clock_limit of {of(style)} is 0")
            for power in style.power(demand, CLOCK, part):
                _figure_is_sound(power, "W", f"power of {of(style)}")
        else:
            _refuses(lambda s=style, j=job: s.clock_limit(j), f"clock_limit of {of(style)}")
            _refuses(lambda s=style, d=demand: s.power(d, CLOCK, part), f"power of {of(style)}")


@rule(lambda case: any(style.supports_external for style in case.styles))
def an_external_memory_changes_no_plan(case: Case) -> None:
    """Styles that support one look at ``Job.external`` in ``demand``, ``clock_limit`` and ``work``."""
    for style in case.styles:
        if not style.supports_external:
            continue
        job = case.job_on(style, external=EXTERNAL)
        _demand_is_sound(style.demand(job), style)
        limit = style.clock_limit(job)
        _figure_is_sound(limit, "Hz", f"clock_limit of {of(style)} beside an external memory")
        require(limit.value <= EXTERNAL.hz, f"{of(style)} runs faster than the memory beside it")
        run = drained(style.work(job))
        _steps_are_sound(run, style)
        require(case.same(run.result), f"{of(style)} ends in another plan beside an external memory")


@rule(on_maps)
def going_on_from_the_own_answer_is_no_slower_and_as_good(case: Case) -> None:
    """``work`` from ``start_of`` the plan takes no more cycles and leads as many starts to a goal."""
    start = case.planner.start_of(case.plan)
    before: Any = case.planner.quality(case.problem, case.plan)
    for style in case.styles:
        cold, warm = case.work(style), case.work(style, start=start)
        sound = warm.cycles <= cold.cycles
        require(sound, f"{of(style)} takes {warm.cycles} cycles from its own answer, {cold.cycles} from nothing")
        after: Any = case.planner.quality(case.problem, warm.result)
        require(
            after.starts_arrived >= before.starts_arrived,
            f"{of(style)} leads {after.starts_arrived} starts to a goal from its own answer,"
            f" {before.starts_arrived} from nothing",
        )
        coarse = case.work(style, start=start, detail=False)
        require(coarse.phases == warm.phases, f"{of(style)}, from its own answer, takes other cycles without detail")


@rule(lambda case: "lower_bound" in case.planner.policies and case.plug_in.planner is not None)
def a_lower_bound_can_be_made_and_taken(case: Case) -> None:
    """Task ``lower_bound`` has a style, and ``work`` takes its bound as a start."""
    makers = [task for task in case.task_styles if task.task == LOWER_BOUND]
    require(makers, "policy 'lower_bound' needs a style of task 'lower_bound': there is none")
    for maker in makers:
        bound = drained(maker.steps(case.job_on(maker)))
        _steps_are_sound(bound, maker)
        for style in case.styles:
            warm = case.work(style, start=bound.result)
            _steps_are_sound(warm, style)
            require(warm.cycles <= case.work(style).cycles, f"{of(style)} is slower from a lower bound than without")


@rule(lambda case: bool(case.task_styles))
def tasks_by_themselves_are_those_of_the_planner(case: Case) -> None:
    """A task placed by itself takes cycles, and the answering one gives the planner's own path."""
    for style in case.task_styles:
        run = case.task(style)
        for each in (run, case.task(style, again=True)):
            _steps_are_sound(each, style)
            require(each.cycles >= 1, f"{of(style)} takes no cycle")
        if style.task == case.answer:
            points, arrived = case.planner.path_from(case.problem, case.plan, case.position)
            sound = np.array_equal(run.result[0], points) and run.result[1] == arrived
            require(sound, f"{of(style)} gives another path than Planner.path_from")


# Rules of circuits: what they declare, and that a run of each reports what the model expects.

SEED = 0
"""The sample that is checked. ``hwsw verify --all`` checks more."""


def _has_circuits(case: Case) -> bool:
    return case.index == 0 and bool(case.plug_in.circuits)


def _can_simulate(case: Case) -> bool:
    """Simulation needs the extra ``rtl``."""
    return _has_circuits(case) and tools.command_of("pyosys") is not None


def of_circuit(style: CircuitStyle) -> str:
    """A circuit in a sentence."""
    return f"the circuit of style {style.style!r}" + (f" (task {style.task})" if style.task else "")


@rule(_has_circuits)
def circuits_belong_to_styles_on_an_fpga(case: Case) -> None:
    """Each circuit derives from ``CircuitStyle``, is of a style of the planner on an FPGA, and none is there twice."""
    of_planning = {("", style.style) for style in case.styles if style.component_type == "fpga"}
    of_tasks = {(style.task, style.style) for style in case.task_styles if style.component_type == "fpga"}
    seen: set[tuple[str, str]] = set()
    for style in case.plug_in.circuits:
        require(isinstance(style, CircuitStyle), f"{style!r} does not derive from CircuitStyle")
        key = (style.task, style.style)
        sound = style.planner == case.planner.name and key in of_planning | of_tasks
        require(sound, f"{of_circuit(style)} is of no style of planner {case.planner.name} on an FPGA")
        require(key not in seen, f"{of_circuit(style)} is registered twice")
        seen.add(key)


@rule(_has_circuits)
def circuits_and_expectations_are_sound(case: Case) -> None:
    """A sample is the same for a seed. Files are there; phases, kinds and values have room; events are in order."""
    for style in case.plug_in.circuits:
        job, text = style.sample(SEED), of_circuit(style)
        circuit, expected = style.circuit(job), style.expected(job)
        _circuit_is_sound(circuit, text)
        _expectation_is_sound(circuit, expected, text)
        again = style.circuit(style.sample(SEED))
        same = digest_of_circuit(again) == digest_of_circuit(circuit)
        sound = same and again.stream.hex_text() == circuit.stream.hex_text()
        require(sound, f"the sample of {text} differs from run to run")


def _circuit_is_sound(circuit: Circuit, text: str) -> None:
    missing = [source.name for source in circuit.sources if not source.is_file()]
    require(not missing, f"{text} names Verilog that is not there: {names(missing)}")
    require(0 < circuit.event_bits <= 64, f"events of {text} have {circuit.event_bits} bits, not 1 to 64")
    for what, listed, most in (("phases", circuit.phases, MOST_KINDS - 1), ("kinds", circuit.kinds, MOST_KINDS)):
        sound = 0 < len(listed) <= most and len(set(listed)) == len(listed)
        require(sound, f"{text} has {len(listed)} {what}: accepted are 1 to {most}, each with a name of its own")
    images = {value for value in circuit.parameters.values() if isinstance(value, str)}
    require(images == set(circuit.images), f"{text} has images {names(circuit.images)}, its parameters {names(images)}")


def _expectation_is_sound(circuit: Circuit, expected: Expected, text: str) -> None:
    events = expected.events
    lengths = {len(events.cycle), len(events.kind), len(events.value)}
    require(lengths != {0} and len(lengths) == 1, f"the model expects no event of {text}, or arrays of several lengths")
    types = [str(array.dtype) for array in (events.cycle, events.kind, events.value)]
    require(types == ["int64", "uint8", "uint64"], f"events of {text} are {names(types)}, not int64, uint8, uint64")
    sound = bool((np.diff(events.cycle) > 0).all()) and events.cycle[0] >= 0
    require(sound, f"the model expects events of {text} out of order, or two at one cycle")
    require(int(events.kind.max()) < len(circuit.kinds), f"the model expects a kind that {text} has not")
    require(int(events.value.max()) < 2**circuit.event_bits, f"the model expects a value that {text} has no bits for")
    strange = set(expected.cycles) - set(circuit.phases)
    require(not strange, f"the model counts cycles of {names(strange)}, which are no phases of {text}")


@rule(_can_simulate)
def circuits_report_what_the_model_expects(case: Case) -> None:
    """Simulated natively, a sample of each circuit reports every event at its cycle."""
    for style in case.plug_in.circuits:
        verified = verify(style, style.sample(SEED))
        require(verified.first is None, f"{of_circuit(style)} differs from the model: {verified.first}")


RULES = tuple(each for each in list(globals().values()) if isinstance(each, Rule))
"""Every rule, in the order in which they are written."""
