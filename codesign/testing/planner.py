"""Rules of a planner on any problem: its answers, and the flows between its tasks."""

from __future__ import annotations

import pickle
from dataclasses import replace

from codesign.ground.errors import InputError
from codesign.planners.interface import COMMAND, LOAD, POSE
from codesign.planners.quality import Quality, RobotsQuality
from codesign.system.place import sound_flows
from codesign.testing.case import Case, Rule, names, require, rule


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
    require(
        [replace(flow, bits=1) for flow in after] == [replace(flow, bits=1) for flow in before],
        "flows_after gives other flows than flows",
    )
    for planned, flow in zip(after, before, strict=True):
        require(
            0 < planned.bits <= flow.bits,
            f"flow {flow.name!r} has {planned.bits} bits after the plan, at most {flow.bits} before",
        )


@rule()
def a_pose_goes_to_the_task_that_answers(case: Case) -> None:
    """The answering task makes a decision, at a cost on every type of component that plans."""
    flows = case.planner.flows(case.job)
    asked = [(flow.sender, flow.receiver) for flow in flows if flow.name == POSE]
    require(
        asked in ([], [(LOAD, case.answer)]),
        f"flow 'pose' goes {asked}; it leads from 'load' to the answering task {case.answer!r}",
    )
    if asked and case.plug_in.planner is not None:
        planning = {style.component_type for style in case.styles}
        answering = {style.component_type for style in case.task_styles if style.task == case.answer}
        require(
            planning <= answering,
            f"task {case.answer!r} has no style on {names(planning - answering)}, where the planner has one",
        )


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


RULES: tuple[Rule, ...] = (
    same_answer_twice,
    another_problem_another_answer,
    asking_changes_nothing,
    map_work_is_counted_in_kernels,
    flows_lead_from_the_map_to_the_answer,
    flows_after_a_plan_differ_in_size_only,
    a_pose_goes_to_the_task_that_answers,
    quality_is_a_record,
    plans_and_parameters_cross_a_process_pool,
)
