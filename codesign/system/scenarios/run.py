"""The run of a bound system, from a machine at time 0, and the check of files: each alone, and each pair."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from codesign import components
from codesign import inputs as spec
from codesign.ground.errors import CodesignError, Fault, InputError, SpecError, choose_hint
from codesign.ground.late import load
from codesign.ground.memo import Memo
from codesign.ground.records import Listener, SummaryRecord
from codesign.inputs import Platform, Workload, fault
from codesign.inputs.edit import VARIANT_AXIS, choose_variant
from codesign.maps import OccupancyGrid
from codesign.planners.job import lever_texts
from codesign.system.assemble import platform_faults, refused
from codesign.system.bind import System, bind_to, plannable
from codesign.system.build import Machine, build
from codesign.system.fit import TellLevers
from codesign.system.inspect import load_any, own_names
from codesign.system.memory import refusal
from codesign.system.outcome import SystemFit, fit_system, head_fields
from codesign.system.problem_map import map_notes
from codesign.system.results.result import Result
from codesign.system.scenario import LeverProgress, ProgressOfMission
from codesign.system.scenarios.scenario import Scenario
from codesign.system.trials import Trials


@dataclass(frozen=True, eq=False)
class Ready:
    """A system that nothing keeps from being simulated.

    ``held``: what the design takes of its part, and why it does not fit where it does not. ``machine``: its components
    at time 0; None where it does not fit.
    """

    held: SystemFit
    machine: Machine | None


def ready(
    system: System,
    listeners: Sequence[Listener] = (),
    granularity: components.Granularity | None = None,
    *,
    memory: int | None = None,
    keeping: bool = False,
    tell: TellLevers = lever_texts,
) -> Ready:
    """Fit the system and, where it fits, build its machine.

    ``tell`` puts the levers of a design that does not fit into words.

    ``granularity``: run-ahead by default. ``memory``: bytes that the run may take, by an estimate; by default half of
    what the machine has free. ``keeping``: a listener keeps all records in memory. Nothing is simulated, and no record
    is made.

    Raises:
        SpecError: a law, a component or the memory of this computer refuses the design point; at its place in a file.
    """

    task = system.planner.planning_task
    mapped = system.workload.mapping[task]
    try:
        held = fit_system(system, tell)
    except SpecError:
        raise
    except CodesignError as wrong:
        raise SpecError([refused(system.workload, ("mapping", task), mapped.parameters, wrong)]) from wrong
    if held.reasons:
        return Ready(held, None)
    too_much = refusal(system, memory, listening=bool(listeners), keeping=keeping)
    if too_much is not None:
        raise SpecError([fault(system.workload, ("mapping", task), *too_much)])
    return Ready(held, build(system, listeners, granularity or components.Granularity.RUN_AHEAD))


# Run a design point: bind, fit, build, and let its scenario run the machine.

SCENARIOS: Mapping[str, str] = {
    "plan_once": "codesign.system.scenarios.plan_once:PlanOnceScenario",
    "drive": "codesign.system.scenarios.drive.scenario:DriveScenario",
    "fleet": "codesign.system.scenarios.fleet.scenario:FleetScenario",
}
"""The class of every scenario by its type, loaded when it is first needed. Their models are ``inputs.scenario``'s."""


def scenario_of(workload: Workload) -> Scenario:
    """The scenario that a workload names."""
    return _scenario(workload.scenario.type)


@cache
def _scenario(name: str) -> Scenario:
    scenario: Scenario = load(SCENARIOS[name])()
    return scenario


def bind(platform: Platform, workload: Workload, *, grid: OccupancyGrid | None = None) -> System:
    """Join platform and workload; see ``system.bind``.

    ``grid``: the workload's map, where it was read already.

    Raises:
        SpecError: every fault between them. InputError: the planner plug-in lists flows that cannot be.
    """
    return bind_to(platform, workload, scenario_of(workload), grid=grid)


def outlook(workload: Workload) -> str | None:
    """A warning that a run may take long, for before it begins; None where it takes no longer than usual."""
    return scenario_of(workload).outlook(workload)


def simulate(
    platform: Platform,
    workload: Workload,
    *,
    listeners: Sequence[Listener] = (),
    granularity: str = "run_ahead",
    memo: Memo | None = None,
    grid: OccupancyGrid | None = None,
    progress: ProgressOfMission | None = None,
    memory: int | None = None,
    keeping: bool = False,
    levers: bool = False,
    lever_progress: LeverProgress | None = None,
) -> Result:
    """Simulate one design point; see ``codesign.simulate``.

    ``listeners`` take the records of the run; ``keeping``: one of them keeps all in memory. ``memo`` shares the
    functional work of design points that have it in common; the figures are the same with and without. ``grid``: the
    workload's map, if it was read already. ``memory``: bytes that the run may take, by an estimate; by default half
    of what the machine has free. ``levers``: run a mission's levers too, and try levers for a design that does not
    fit or serve; ``lever_progress``: see ``Scenario.with_levers``.

    Raises:
        SpecError: platform, workload and map do not belong together, or see ``ready``. InputError: see
            ``simulate_system``.
    """
    system = bind(platform, workload, grid=grid)
    complete, tell = None, lever_texts
    if levers:
        tell = Trials(system).levers
        memo = Memo() if memo is None else memo
        run = partial(simulate, memo=memo, grid=grid, memory=memory)

        def complete(result: Result) -> Result:
            return scenario_of(workload).with_levers(result, system, run, lever_progress)

    return simulate_system(
        system,
        listeners=listeners,
        granularity=granularity,
        memo=memo,
        progress=progress,
        memory=memory,
        keeping=keeping,
        complete=complete,
        tell=tell,
    )


def simulate_system(
    system: System,
    *,
    listeners: Sequence[Listener] = (),
    granularity: str = "run_ahead",
    memo: Memo | None = None,
    progress: ProgressOfMission | None = None,
    memory: int | None = None,
    keeping: bool = False,
    complete: Callable[[Result], Result] | None = None,
    tell: TellLevers = lever_texts,
) -> Result:
    """Simulate a bound system: fit it, and where it fits, run it.

    ``complete`` adds to the result before listeners get it. ``tell`` puts the levers of a design that does not fit into
    words.

    Raises:
        SpecError: see ``ready``. InputError: an unknown granularity.
    """

    if granularity not in list(components.Granularity):
        hint = choose_hint(granularity, list(components.Granularity))
        raise InputError(f"granularity {granularity!r} is unknown", "granularity", hint)
    prepared = ready(system, listeners, components.Granularity(granularity), memory=memory, keeping=keeping, tell=tell)
    head, machine = head_fields(system) | prepared.held.fields, prepared.machine
    if machine is None:
        return Result(**head, feasible=False, reasons=prepared.held.reasons)
    fields = scenario_of(system.workload).run(machine, prepared.held.boards, memo, progress)
    result = Result(**{**head, "feasible": True, **fields})
    if complete is not None:
        result = complete(result)
    for component in machine.all_components:
        component.report_end()
    if listeners:
        machine.tell(SummaryRecord(machine.now, "run", result.model_dump(mode="json")))
    return result


def check_files(
    sources: Sequence[str | Path],
    settings: Mapping[str, Any] | None = None,
    memory: int | None = None,
    tell: Callable[[str], None] | None = None,
) -> list[Fault]:
    """Every fault of the named files, and of each platform with each workload among them, in file order.

    A source is a shipped name or a path; its content gives its kind. A platform and a workload are bound and
    built as ``simulate`` does it, so that both refuse the same; ``memory`` as there. Each variant of a workload is
    checked too, unless ``settings``, raw values by axis that are put into both, choose one. Files of one kind are
    checked as far as that is possible without the other kind. ``tell`` takes each note (``Architecture.notes``) of
    designs without a fault.

    Raises:
        InputError: settings, and no platform and workload to put them into.
    """
    faults: list[Fault] = []
    platforms: list[Platform] = []
    workloads: list[Workload] = []
    own = own_names(sources)
    for source in sources:
        try:
            loaded = load_any(source, own)
        except SpecError as wrong:
            faults += wrong.faults
        except CodesignError as wrong:
            faults.append(Fault(str(source), 0, 0, "", wrong.what, wrong.hint))
        else:
            if isinstance(loaded, Platform):
                platforms.append(loaded)
            elif isinstance(loaded, Workload):
                workloads.append(loaded)
    if settings and not faults and not (platforms and workloads):
        raise InputError("settings go into a platform and a workload", "--set", "name one of each")
    pairs = list(itertools.product(workloads, platforms))
    notes: dict[str, None] = {}
    checks = [_faults_of_pair(platform, workload, settings or {}, memory, notes) for workload, platform in pairs]
    if not pairs:
        checks += [iter(platform_faults(platform)) for platform in platforms]
        checks += [_faults_of_workload(workload, notes) for workload in workloads]
    for found in itertools.chain.from_iterable(checks):
        faults += [found] if found not in faults else []
    if tell is not None:
        for note in notes:
            tell(note)
    return faults


def _faults_of_pair(
    platform: Platform, workload: Workload, settings: Mapping[str, Any], memory: int | None, notes: dict[str, None]
) -> Iterator[Fault]:
    """Each fault that keeps the workload, or a variant of it, from being simulated on the platform.

    ``notes`` gets the notes of the points without a fault as keys.
    """
    for point in _points_checked(workload, settings):
        # The axes are those of the variants explored: they are held against the first point alone.
        put_in = spec.pin if point == settings else spec.design_point
        try:
            system = bind(*put_in(platform, workload, point, "--set ") if point else (platform, workload))
            ready(system, memory=memory)
        except SpecError as wrong:
            yield from wrong.faults
        else:
            notes |= dict.fromkeys(system.notes)


def _faults_of_workload(workload: Workload, notes: dict[str, None]) -> Iterator[Fault]:
    """The faults of a workload and its variants that are known without a platform. ``notes``: as above, of its map."""
    try:
        spec.platforms_of(workload)
    except SpecError as wrong:
        yield from wrong.faults
    for each in (workload, *(choose_variant(workload, name, "") for name in workload.variants)):
        problem, faults = plannable(each, scenario_of(each))
        yield from faults
        if problem is not None:
            notes |= dict.fromkeys(map_notes(each, None))


def _points_checked(workload: Workload, settings: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The points of a workload to be checked: the settings, with each variant unless they choose one."""
    if VARIANT_AXIS in settings:
        return [dict(settings)]
    return [dict(settings), *({**settings, VARIANT_AXIS: name} for name in workload.variants)]
