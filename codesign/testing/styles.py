"""Rules of architecture styles and task styles: their steps end in the plan, and their laws are sound."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from codesign.ground.errors import InputError
from codesign.ground.figures import RESOURCES, Figure, Status
from codesign.ground.memo import Memo
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.planners.interface import LOWER_BOUND
from codesign.planners.job import Demand
from codesign.planners.styles import Architecture, TaskStyle
from codesign.testing.case import Case, Rule, Run, drained, names, of, on_maps, require, rule

CLOCK = 50_000_000
"""Hz at which power is asked for."""

EXTERNAL = ExternalMemoryLaw("sram", 100_000_000, 32, 2**26, 2)
"""A memory beside the FPGA, for styles that can use one."""


def _steps_are_sound(run: Run, style: Architecture | TaskStyle) -> None:
    for step in run.steps:
        require(step.phase, f"a step of {of(style)} has no phase")
        whole = step.cycles.dtype == np.int64 and step.cycles.ndim == 1
        require(whole, f"cycles of {of(style)} in phase {step.phase!r} are no line of int64")
        require(
            not len(step.cycles) or step.cycles.min() >= 1,
            f"a step of {of(style)} in phase {step.phase!r} takes less than one cycle",
        )


def _demand_is_sound(demand: Demand, style: Architecture | TaskStyle) -> None:
    require(isinstance(demand, Demand), f"demand of {of(style)} gives {type(demand).__name__}")
    for item in demand.items:
        require(
            item.resource in RESOURCES,
            f"item {item.name!r} of {of(style)} asks for {item.resource!r}: accepted are {', '.join(RESOURCES)}",
        )
        require(
            item.amount == item.figure.value >= 0,
            f"item {item.name!r} of {of(style)} asks for {item.figure.value!r} {item.resource}",
        )
    for line in (*demand.items, *demand.bounds):
        require(line.name and line.figure.source, f"a line of the demand of {of(style)} has no name or no source")
        sound = isinstance(line.figure.status, Status)
        require(sound, f"{line.name!r} in the demand of {of(style)} has status {line.figure.status!r}")
    strange = set(demand.levers) - set(RESOURCES)
    require(not strange, f"levers of {of(style)} are for {names(strange)}: accepted are {', '.join(RESOURCES)}")
    require(
        style.component_type != "processor" or not demand.items,
        f"{of(style)} runs on a processor and asks for resources of a part",
    )


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
        require(
            style.notes(replace(case.job, parameters=settled)) == (),
            f"{of(style)} has notes on its own settled parameters",
        )
        plan = planner.plan(replace(case.job, parameters=settled))
        run = case.work(style)
        _steps_are_sound(run, style)
        require(
            planner.identity(run.result) == planner.identity(plan),
            f"work of {of(style)}, drained, ends in another plan than Planner.plan",
        )
        require(
            planner.figures(run.result) == planner.figures(plan),
            f"work of {of(style)}, drained, ends in other figures than Planner.plan",
        )


@rule(on_maps)
def designs_are_accepted(case: Case) -> None:
    """Each design that a style proposes is a sound set of parameters for its planner and for the problem."""
    planner = case.planner
    model = planner.tasks[planner.planning_task]
    for style in case.styles:
        for design in (design for chain in style.designs(case.job_on(style, parameters=None)) for design in chain):
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
            require(
                coarse.phases == fine.phases,
                f"{of(style)} takes {coarse.phases} cycles {what}, {fine.phases} with detail",
            )
            same = planner.identity(coarse.result) == planner.identity(fine.result)
            require(same, f"{of(style)} ends in another plan {what}")
            require(
                planner.figures(coarse.result) == planner.figures(fine.result),
                f"{of(style)} ends in other figures {what}",
            )


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
        require(
            (task.component_type == "processor") == bool(task.kernel),
            f"{of(task)} has kernel {task.kernel!r}: a processor needs one, and nothing else has one",
        )


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
        require(
            case.work(style, inside=everything).phases == whole.phases,
            f"{of(style)} takes other cycles with every task inside than by default",
        )
        for detail in (True, False):
            run = case.work(style, inside=case.answer_elsewhere, detail=detail)
            gone = set(whole.phases) - set(run.phases)
            require(
                len(gone) <= (0 if case.answer == case.planner.planning_task else 1),
                f"{of(style)} leaves out phases {names(gone)} where {case.answer!r} alone is done elsewhere",
            )
            read_out = set(run.phases) - set(whole.phases)
            require(
                len(read_out) <= len(gone) and read_out <= {[*run.phases][-1]},
                f"{of(style)} adds phases {names(read_out)} where {case.answer!r} is done elsewhere, not one that"
                " reads the plan out in place of the answer",
            )
            kept = {phase: cycles for phase, cycles in whole.phases.items() if phase not in gone}
            same = {phase: cycles for phase, cycles in run.phases.items() if phase not in read_out}
            require(same == kept, f"{of(style)} takes {same} where {case.answer!r} is done elsewhere, not {kept}")
            require(
                case.same(run.result) == case.same(whole.result),
                f"{of(style)} ends in another plan where the answer is elsewhere",
            )


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
        require(
            [bound.figure.value for bound in left.bounds] == [bound.figure.value for bound in whole.bounds],
            f"bounds of {of(style)} change where {case.answer!r} is elsewhere",
        )
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
        require(
            warm.cycles <= cold.cycles,
            f"{of(style)} takes {warm.cycles} cycles from its own answer, {cold.cycles} from nothing",
        )
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
            require(
                np.array_equal(run.result[0], points) and run.result[1] == arrived,
                f"{of(style)} gives another path than Planner.path_from",
            )


RULES: tuple[Rule, ...] = (
    work_drained_ends_in_the_plan,
    coarse_steps_cost_the_same,
    styles_on_a_processor_list_their_kernels,
    programs_pay_for_their_map,
    work_leaves_out_the_answer_where_it_is_placed_elsewhere,
    demand_names_resources_of_a_part,
    what_is_done_elsewhere_takes_nothing_of_the_part,
    clock_limit_and_power_have_units_and_sources,
    an_external_memory_changes_no_plan,
    going_on_from_the_own_answer_is_no_slower_and_as_good,
    a_lower_bound_can_be_made_and_taken,
    tasks_by_themselves_are_those_of_the_planner,
)
