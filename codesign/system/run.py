"""Run one bound system: the host sends the map, the planner works on its clock, the answer comes back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from codesign.errors import InputError, choose_hint
from codesign.memo import Memo
from codesign.records import Listener, SummaryRecord
from codesign.spec import Platform, Workload
from codesign.system.bind import System, bind
from codesign.system.build import Machine, build
from codesign.system.chain import Answer
from codesign.system.ledger import Ledger
from codesign.system.levers import with_levers
from codesign.system.outcome import drive_fields, fitted, head_fields, plan_fields, use_fields
from codesign.system.result import Power, Result

if TYPE_CHECKING:
    from codesign.maps import OccupancyGrid

MAX_BYTES = 4 * 2**30
"""Most memory that the field of one run may need, by an estimate."""

# Assumed: the field of a stage, that of the stage before, its planes and the block under way; distances and labels.
_WORDS_AT_ONCE = 4
_BYTES_A_CELL = 64


def simulate(
    platform: Platform,
    workload: Workload,
    *,
    listeners: Sequence[Listener] = (),
    granularity: str = "run_ahead",
    memo: Memo | None = None,
    grid: OccupancyGrid | None = None,
    levers: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Simulate one design point; see ``codesign.simulate``.

    ``listeners`` take the records of the run. ``memo`` shares the functional work of design points that have it in
    common; the figures are the same with and without. ``grid``: the workload's map, where it was read already.
    ``levers``: run a mission's levers too; ``progress``: see ``with_levers``.

    Raises:
        SpecError: platform, workload and map do not belong together.
    """
    system = bind(platform, workload, grid=grid)
    complete = None
    if levers:
        memo = Memo() if memo is None else memo
        run = partial(simulate, memo=memo, grid=grid)
        complete = partial(with_levers, system=system, run=run, progress=progress)
    return simulate_system(system, listeners=listeners, granularity=granularity, memo=memo, complete=complete)


def simulate_system(
    system: System,
    *,
    listeners: Sequence[Listener] = (),
    granularity: str = "run_ahead",
    memo: Memo | None = None,
    complete: Callable[[Result], Result] | None = None,
) -> Result:
    """Simulate a bound system: fit it, and where it fits, run it. ``complete`` adds to the result before it is told.

    Raises:
        InputError: an unknown granularity, or a run that would need more than ``MAX_BYTES`` of memory.
    """
    from codesign.components import Granularity

    if granularity not in list(Granularity):
        raise InputError(
            f"granularity {granularity!r} is unknown",
            "granularity",
            choose_hint(granularity, list(Granularity)),
        )
    head = head_fields(system)
    held = fitted(system)
    head |= held.fields
    if held.reasons:
        return Result(**head, feasible=False, reasons=held.reasons)
    _check_memory(system)
    machine = build(system, listeners, Granularity(granularity))
    result = Result(**head, feasible=True, **_run(machine, held.boards, memo))
    if complete is not None:
        result = complete(result)
    for component in machine.components:
        component.report_end()
    if listeners:
        machine.tell(SummaryRecord(machine.now, "run", result.model_dump(mode="json")))
    return result


def _check_memory(system: System) -> None:
    """Refuse what this machine would be ended for: a field of long words on a large map.

    Raises:
        InputError: with the size.
    """
    precisions = getattr(system.planning, "precisions", None)
    if not precisions or not hasattr(system.problem, "free"):
        return
    words = max(precisions) // 64 + 1
    needed = system.problem.free.size * (_WORDS_AT_ONCE * 8 * words + _BYTES_A_CELL)
    if needed > MAX_BYTES:
        raise InputError(
            f"{system.problem.free.size:,} cells at {max(precisions)} bits would need about"
            f" {needed / 2**30:.1f} GiB of memory, more than {MAX_BYTES // 2**30}",
            f"mapping.{system.planner.planning_task}",
            "end the schedule at a lower precision, or take a smaller map",
        )


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

    flight = fly(machine, memo=memo)
    problem = machine.system.problem
    ended = flight.ends[-1] if len(flight.ends) else flight.loaded
    answer = Answer(problem, flight.plan, flight.loaded, ended, ended, Ledger())
    fields = plan_fields(machine, answer, memo) | use_fields(machine, boards, flight.fpgas[1:])
    return {**fields, "fleet": flight.figures}
