"""Run a design point: bind, fit, build, and let its scenario run the machine."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial

from codesign import components
from codesign.ground.errors import InputError, choose_hint
from codesign.ground.memo import Memo
from codesign.ground.records import Listener, SummaryRecord
from codesign.inputs import Platform, Workload
from codesign.maps import OccupancyGrid
from codesign.planners.job import lever_texts
from codesign.system.bind import System, bind_to
from codesign.system.fit import TellLevers
from codesign.system.outcome import head_fields
from codesign.system.ready import ready
from codesign.system.results.result import Result
from codesign.system.scenario import LeverProgress, ProgressOfMission
from codesign.system.scenarios.scenario import Scenario
from codesign.system.trials import Trials

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
    scenario: Scenario = pkgutil.resolve_name(SCENARIOS[name])()
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
        raise InputError(
            f"granularity {granularity!r} is unknown",
            "granularity",
            choose_hint(granularity, list(components.Granularity)),
        )
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
