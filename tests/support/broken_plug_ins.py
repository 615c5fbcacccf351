"""Plug-ins that each break one rule of the contract, made of breadth-first search."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from codesign.planners.breadth_first.plug_in import PLUG_IN as INSTALLED
from codesign.planners.circuits import Events, Expected, Image
from codesign.planners.styles import Step
from codesign.plugin import Flow, Job, Lever, Line, MapWork, PlugIn, Problem, Status

# Circuits are simulated, which takes seconds: only the rules that concern them get some.
(CIRCUIT,) = INSTALLED.circuits
PLUG_IN = replace(INSTALLED, circuits=())
PLANNER: Any = PLUG_IN.planner
COUNTER = count()
ONE_CYCLE = np.ones(1, np.int64)


def altered(thing: Any, members: dict[str, Any]) -> Any:
    """A copy of a planner or style with other members."""
    other = copy.copy(thing)
    other.__class__ = type("Altered", (type(thing),), members)
    return other


def planner(**members: Any) -> PlugIn:
    return replace(PLUG_IN, planner=altered(PLANNER, members))


def styles(**members: Any) -> PlugIn:
    """The plug-in with other members in its styles: ``original`` is the style that each is made of."""
    changed = [altered(style, {**members, "original": style}) for style in PLUG_IN.styles]
    return replace(PLUG_IN, styles=tuple(changed))


def tasks(**members: Any) -> PlugIn:
    changed = [altered(style, {**members, "original": style}) for style in PLUG_IN.task_styles]
    return replace(PLUG_IN, task_styles=tuple(changed))


def circuits(**members: Any) -> PlugIn:
    """The plug-in with a circuit of other members: ``original`` is the circuit that it is made of."""
    return replace(PLUG_IN, circuits=(altered(CIRCUIT, {**members, "original": CIRCUIT}),))


def circuit(**members: Any) -> PlugIn:
    """Other members of what is built."""
    return circuits(circuit=lambda self, job: replace(self.original.circuit(job), **members))


def expected(change: Callable[[Expected], Expected]) -> PlugIn:
    """``change`` is given what the model expects."""
    return circuits(expected=lambda self, job: change(self.original.expected(job)))


def events(change: Callable[[Events], Events]) -> PlugIn:
    """``change`` is given the events that the model expects."""
    return expected(lambda model: replace(model, events=change(model.events)))


def flows(change: Callable[[tuple[Flow, ...]], tuple[Flow, ...]]) -> PlugIn:
    return planner(flows=lambda self, job: change(PLANNER.flows(job)))


def demand(change: Callable[[Any, Any], Any]) -> PlugIn:
    """``change`` is given the demand, and ``inside``."""
    return styles(demand=lambda self, job: change(self.original.demand(job), job.inside))


def work_longer(when: Callable[[Job[Any, Any]], bool], phase: str = "more", **more: Any) -> PlugIn:
    """``work`` takes a cycle more of a phase where its job is such."""

    def longer(self: Any, job: Job[Any, Any]) -> Any:
        if when(job):
            yield Step(phase, ONE_CYCLE)
        return (yield from self.original.work(job))

    return replace(styles(work=longer), **more)


def without_map(self: Any, job: Job[Any, Any]) -> Any:
    """The work without the cells of its map."""
    work = self.original.work(job)
    while True:
        try:
            step = next(work)
        except StopIteration as end:
            return end.value
        if step.kernel != "breadth_first_map_cell":
            yield step


def work_elsewhere(when: Callable[[Job[Any, Any]], bool]) -> PlugIn:
    """``work`` ends in the plan of another problem where its job is such."""

    def another(self: Any, job: Job[Any, Any]) -> Any:
        plan = yield from self.original.work(job)
        if when(job):
            return PLANNER.plan(replace(job, problem=replace(job.problem, starts=job.problem.starts[1:])))
        return plan

    return styles(work=another)


def quality(**figures: Any) -> PlugIn:
    return planner(quality=lambda self, problem, plan: replace(PLANNER.quality(problem, plan), **figures))


def meddling(self: Any, problem: Problem, plan: Any) -> Any:
    object.__setattr__(problem, "resolution", 9.0)
    return PLANNER.quality(problem, plan)


def moving_the_goal(self: Any, problem: Problem, plan: Any) -> Any:
    found = PLANNER.quality(problem, plan)
    object.__setattr__(plan, "goal", (0, 0))
    return found


def unpicklable(self: Any, job: Job[Any, Any]) -> Any:
    plan = copy.copy(PLANNER.plan(job))
    object.__setattr__(plan, "local", lambda: 0)
    return plan


def straight(self: Any, problem: Problem, plan: Any, start: Any) -> Any:
    return np.array([start, problem.goals[0]], np.float64), True


def only_goals(self: Any, job: Job[Any, Any]) -> Any:
    cells = np.zeros_like(job.problem.free)
    cells[tuple(np.array(job.problem.goals).T)] = True
    return cells


def task_elsewhere(self: Any, job: Job[Any, Any]) -> Any:
    yield from self.original.steps(job)
    return np.array([job.position, job.position], np.float64), True


def clock_in_mhz(self: Any, job: Job[Any, Any]) -> Any:
    return replace(self.original.clock_limit(job), unit="MHz")


def raising(self: Any, *arguments: Any) -> Any:
    raise KeyError("left")


def plus(kind: str, amount: int, status: Any = Status.ASSUMED) -> tuple[Line, ...]:
    return (Line.item("more", kind, amount, status, "counted by hand"),)


STRAIGHT = planner(path_from=straight, trajectory=straight)

RULE_BREAKERS: list[tuple[str, str, PlugIn]] = [
    ("plug_in_holds_parts_of_one_planner", "of planner 'another'", styles(planner="another")),
    ("plug_in_holds_parts_of_one_planner", "one name", replace(PLUG_IN, styles=PLUG_IN.styles * 2)),
    ("plug_in_holds_parts_of_one_planner", "no style", PlugIn(planner=PLANNER)),
    ("planner_names_its_planning_task", "none of the tasks", planner(planning_task="dream")),
    ("planner_names_its_planning_task", "full stop", planner(description="It plans.")),
    ("planner_members_have_their_types", "number of bytes", planner(memory=lambda *_: -1)),
    ("planner_members_have_their_types", "list of texts", planner(memory_levers=lambda *_: "smaller")),
    ("planner_members_have_their_types", "boolean", planner(answers_no_way=None)),
    ("planner_members_have_their_types", "refuses", planner(check=lambda *_: ("starts", "too few"))),
    ("planner_members_have_their_types", "hint", planner(check_drive=lambda *_: "no")),
    ("planner_members_have_their_types", "number of fields", planner(fields_a_stage=0.5)),
    ("planner_members_have_their_types", "horizon", planner(horizon=lambda *_: 0.0)),
    ("planner_members_have_their_types", "KeyError is raised in", planner(memory=raising)),
    ("style_members_have_their_types", "runs on none of", styles(component_type="toaster")),
    ("style_members_have_their_types", "boolean", styles(supports_external=None)),
    ("style_members_have_their_types", "gives dict", styles(memory=lambda *_: {})),
    ("policies_have_what_they_take", "first policy", planner(policies=("continue", "restart"))),
    ("policies_have_what_they_take", "none of", planner(policies=("restart", "pray"))),
    ("policies_have_what_they_take", "come together", planner(policies=("restart", "lower_bound"))),
    ("policies_have_what_they_take", "needs a start", planner(policies=("restart", "continue"))),
    ("figures_and_field_fit_a_result", "colour", planner(figures=lambda *_: {"colour": 1})),
    ("figures_and_field_fit_a_result", "float64", planner(field_of=lambda *_: ("x", "m", ONE_CYCLE))),
    ("same_answer_twice", "identity", planner(identity=lambda *_: f"{next(COUNTER)}")),
    ("same_answer_twice", "figures", planner(figures=lambda *_: {"details": {"n": next(COUNTER)}})),
    ("another_problem_another_answer", "one identity", planner(identity=lambda *_: "same")),
    ("asking_changes_nothing", "of the problem", planner(quality=meddling)),
    ("asking_changes_nothing", "a plan changes", planner(quality=moving_the_goal)),
    (
        "map_work_is_counted_in_kernels",
        "give an integer of 0 or more",
        planner(map_work=lambda self, job: (MapWork("fill", "kernel", -1),)),
    ),
    (
        "map_work_is_counted_in_kernels",
        "give it a name and a kernel",
        planner(map_work=lambda self, job: (MapWork("", "kernel", 1),)),
    ),
    (
        "flows_lead_from_the_map_to_the_answer",
        "has 0 bits",
        flows(lambda found: tuple(replace(flow, bits=0) for flow in found)),
    ),
    (
        "flows_lead_from_the_map_to_the_answer",
        "no task",
        flows(lambda found: (*found, Flow("dream", "search", "x", 1))),
    ),
    ("flows_lead_from_the_map_to_the_answer", "circle", flows(lambda found: (*found, Flow("track", "search", "x", 1)))),
    ("flows_lead_from_the_map_to_the_answer", "nothing flows from", flows(lambda found: found[1:])),
    ("flows_lead_from_the_map_to_the_answer", "exactly one", flows(lambda found: found[:2])),
    ("flows_lead_from_the_map_to_the_answer", "never start", flows(lambda found: (found[0], found[2]))),
    (
        "flows_after_a_plan_differ_in_size_only",
        "other flows",
        planner(flows_after=lambda self, job: PLANNER.flows(job)[:1]),
    ),
    (
        "flows_after_a_plan_differ_in_size_only",
        "at most",
        planner(flows_after=lambda self, job: tuple(replace(flow, bits=10**6) for flow in PLANNER.flows(job))),
    ),
    (
        "a_pose_goes_to_the_task_that_answers",
        "answering task",
        flows(lambda found: (*found, Flow("load", "search", "pose", 8))),
    ),
    (
        "a_pose_goes_to_the_task_that_answers",
        "no style on fpga",
        replace(
            flows(lambda found: (*found, Flow("load", "track", "pose", 8))),
            task_styles=tuple(each for each in PLUG_IN.task_styles if each.component_type == "processor"),
        ),
    ),
    ("quality_is_a_record", "gives dict", planner(quality=lambda *_: {})),
    ("plans_and_parameters_cross_a_process_pool", "cannot be pickled", planner(plan=unpicklable)),
    ("reachable_cells_lead_to_a_goal", "leaves the cell out", planner(reachable=only_goals)),
    (
        "reachable_cells_lead_to_a_goal",
        "an obstacle",
        planner(reachable=lambda self, job: np.ones_like(job.problem.free)),
    ),
    ("quality_is_of_this_problem", "planned_cells", quality(planned_cells=10**6)),
    ("quality_is_of_this_problem", "cannot be", quality(path_length_ratio_mean=0.5)),
    ("quality_is_of_this_problem", "cannot be", quality(clearance_least=0.0)),
    ("quality_is_of_this_problem", "starts of", quality(starts=99)),
    ("trajectories_stay_in_free_space", "leaves free space", STRAIGHT),
    ("trajectories_stay_in_free_space", "quality counts", quality(starts_arrived=1)),
    ("paths_from_any_position_keep_to_free_cells", "leaves free space", STRAIGHT),
    (
        "paths_from_any_position_keep_to_free_cells",
        "begins at",
        planner(path_from=lambda self, problem, *_: (np.array(problem.goals, np.float64), True)),
    ),
    ("no_path_from_where_no_robot_can_be", "no robot can be", STRAIGHT),
    ("work_drained_ends_in_the_plan", "another plan", work_elsewhere(lambda job: True)),
    (
        "work_drained_ends_in_the_plan",
        "less than one cycle",
        styles(work=lambda self, *given, **more: (yield Step("search", 0 * ONE_CYCLE))),
    ),
    ("coarse_steps_cost_the_same", "without detail", work_longer(lambda job: not job.detail)),
    ("coarse_steps_cost_the_same", "another plan", work_elsewhere(lambda job: not job.detail)),
    ("styles_on_a_processor_list_their_kernels", "leaves out", styles(kernels=lambda *_: ("other",))),
    ("styles_on_a_processor_list_their_kernels", "are for processors", styles(kernel="cell")),
    ("styles_on_a_processor_list_their_kernels", "processor needs one", tasks(kernel="")),
    ("programs_pay_for_their_map", "does not pay for the 768 cells", styles(work=without_map)),
    (
        "work_leaves_out_the_answer_where_it_is_placed_elsewhere",
        "by default",
        work_longer(lambda job: job.inside is not None),
    ),
    (
        "work_leaves_out_the_answer_where_it_is_placed_elsewhere",
        "adds phases more",
        work_longer(lambda job: not job.does("track")),
    ),
    (
        "work_leaves_out_the_answer_where_it_is_placed_elsewhere",
        "'bf': ",
        work_longer(lambda job: not job.does("track"), "bf"),
    ),
    ("designs_are_accepted", "rubber", styles(designs=lambda self, job: (({"rubber": 1},),))),
    ("demand_names_resources_of_a_part", "'rubber'", demand(lambda found, _: replace(found, items=plus("rubber", 1)))),
    (
        "demand_names_resources_of_a_part",
        "asks for -1",
        demand(lambda found, _: replace(found, items=plus("slices", -1))),
    ),
    (
        "demand_names_resources_of_a_part",
        "status 'guessed'",
        demand(lambda found, _: replace(found, items=plus("slices", 1, "guessed"))),
    ),
    (
        "demand_names_resources_of_a_part",
        "levers",
        demand(lambda found, _: replace(found, levers={"rubber": (Lever("search", "less"),)})),
    ),
    (
        "demand_names_resources_of_a_part",
        "on a processor",
        demand(lambda found, _: replace(found, items=plus("slices", 1))),
    ),
    (
        "what_is_done_elsewhere_takes_nothing_of_the_part",
        "elsewhere",
        demand(
            lambda found, inside: (
                replace(found, items=plus("slices", 1)) if "track" not in (inside or ["track"]) else found
            )
        ),
    ),
    (
        "what_is_done_elsewhere_takes_nothing_of_the_part",
        "asks for more of more",
        demand(
            lambda found, inside: replace(found, items=plus("slices", 1 if "track" in (inside or ["track"]) else 2))
        ),
    ),
    ("clock_limit_and_power_have_units_and_sources", "'MHz'", styles(clock_limit=clock_in_mhz)),
    (
        "clock_limit_and_power_have_units_and_sources",
        "on a processor",
        replace(PLUG_IN, styles=(altered(PLUG_IN.styles[1], {"power": lambda self, *_: (None, None)}),)),
    ),
    (
        "an_external_memory_changes_no_plan",
        "beside an external memory",
        work_elsewhere(lambda job: job.external is not None),
    ),
    (
        "going_on_from_the_own_answer_is_no_slower_and_as_good",
        "from its own answer",
        work_longer(lambda job: job.start is not None, planner=altered(PLANNER, {"start_of": lambda self, plan: plan})),
    ),
    ("a_lower_bound_can_be_made_and_taken", "there is none", planner(policies=("restart", "lower_bound"))),
    ("tasks_by_themselves_are_those_of_the_planner", "another path", tasks(steps=task_elsewhere)),
    (
        "tasks_by_themselves_are_those_of_the_planner",
        "less than one cycle",
        tasks(again=lambda *_: (step for step in [Step("track", 0 * ONE_CYCLE)])),
    ),
    ("circuits_belong_to_styles_on_an_fpga", "no style of planner", circuits(style="another")),
    ("circuits_belong_to_styles_on_an_fpga", "twice", replace(PLUG_IN, circuits=(CIRCUIT,) * 2)),
    (
        "circuits_and_expectations_are_sound",
        "from run to run",
        circuits(sample=lambda self, seed: self.original.sample(next(COUNTER))),
    ),
    ("circuits_and_expectations_are_sound", "not there", circuit(sources=(Path("nowhere.v"),))),
    ("circuits_and_expectations_are_sound", "has 0 kinds", circuit(kinds=())),
    ("circuits_and_expectations_are_sound", "bits", circuit(event_bits=65)),
    ("circuits_and_expectations_are_sound", "has images", circuit(images={"map.hex": Image(1, [0])})),
    (
        "circuits_and_expectations_are_sound",
        "out of order",
        events(lambda model: replace(model, cycle=model.cycle[::-1].copy())),
    ),
    ("circuits_and_expectations_are_sound", "no phases", expected(lambda model: replace(model, cycles={"dream": 1}))),
    (
        "circuits_report_what_the_model_expects",
        "differs from the model: cycle",
        events(lambda model: replace(model, cycle=model.cycle + 1)),
    ),
]
"""The rule, words of the sentence that reports it, and the plug-in that breaks it."""
