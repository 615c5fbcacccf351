"""Run one bound system: the host sends the map, the planner works on its clock, the answer comes back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from codesign.errors import InputError, choose_hint
from codesign.inputs import Platform, Workload
from codesign.memo import Memo
from codesign.records import Listener, SummaryRecord
from codesign.results.ledger import Ledger
from codesign.results.result import Power, Result
from codesign.system.bind import System, bind
from codesign.system.build import Machine
from codesign.system.chain import Answer
from codesign.system.levers import LeverProgress, with_levers
from codesign.system.outcome import drive_fields, head_fields, plan_fields, use_fields
from codesign.system.progress import ProgressOfMission
from codesign.system.ready import ready

if TYPE_CHECKING:
    from codesign.maps import OccupancyGrid


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
    workload's map, where it was read already. ``memory``: bytes that the run may take, by an estimate; by default half
    of what the machine has free. ``levers``: run a mission's levers too; ``lever_progress``: see ``with_levers``.

    Raises:
        SpecError: platform, workload and map do not belong together, or see ``ready``. InputError: see
            ``simulate_system``.
    """
    system = bind(platform, workload, grid=grid)
    complete = None
    if levers:
        memo = Memo() if memo is None else memo
        run = partial(simulate, memo=memo, grid=grid, memory=memory)
        complete = partial(with_levers, system=system, run=run, progress=lever_progress)
    return simulate_system(
        system,
        listeners=listeners,
        granularity=granularity,
        memo=memo,
        progress=progress,
        memory=memory,
        keeping=keeping,
        complete=complete,
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
) -> Result:
    """Simulate a bound system: fit it, and where it fits, run it. ``complete`` adds to the result before it is told.

    Raises:
        SpecError: see ``ready``. InputError: an unknown granularity.
    """
    from codesign.components import Granularity

    if granularity not in list(Granularity):
        raise InputError(
            f"granularity {granularity!r} is unknown",
            "granularity",
            choose_hint(granularity, list(Granularity)),
        )
    prepared = ready(system, listeners, Granularity(granularity), memory=memory, keeping=keeping)
    head, machine = head_fields(system) | prepared.held.fields, prepared.machine
    if machine is None:
        return Result(**head, feasible=False, reasons=prepared.held.reasons)
    machine.progress = progress
    result = Result(**head, feasible=True, **_run(machine, prepared.held.boards, memo))
    if complete is not None:
        result = complete(result)
    for component in machine.components:
        component.report_end()
    if listeners:
        machine.tell(SummaryRecord(machine.now, "run", result.model_dump(mode="json")))
    return result


def _run(machine: Machine, boards: Mapping[str, Power], memo: Memo | None) -> dict[str, Any]:
    """Let the machine do what its scenario says; the fields that this gives a result."""
    run = {"plan_once": _plan_once, "drive": _drive, "fleet": _fleet}[machine.system.workload.scenario.type]
    return run(machine, boards, memo)


def _plan_once(machine: Machine, boards: Mapping[str, Power], memo: Memo | None) -> dict[str, Any]:
    from codesign.system.scenarios.plan_once import plan_once

    answer = plan_once(machine, memo)
    return plan_fields(machine, answer, memo) | use_fields(machine, boards)


def _drive(machine: Machine, boards: Mapping[str, Power], memo: Memo | None) -> dict[str, Any]:
    from codesign.system.scenarios.drive import drive
    from codesign.system.scenarios.drive.summary import mission_of

    done = drive(machine, memo)
    fields = drive_fields(machine, done.log.first, done.log.last, memo)
    return {**fields, **use_fields(machine, boards), "mission": mission_of(machine, done, boards, memo)}


def _fleet(machine: Machine, boards: Mapping[str, Power], memo: Memo | None) -> dict[str, Any]:
    from codesign.system.scenarios.fleet import fly

    flight = fly(machine)
    problem = machine.system.problem
    ended = flight.ends[-1] if len(flight.ends) else flight.loaded
    answer = Answer(problem, flight.plan, flight.loaded, ended, ended, Ledger())
    fields = plan_fields(machine, answer, memo) | use_fields(machine, boards, flight.fpgas[1:])
    return {**fields, "fleet": flight.figures}
