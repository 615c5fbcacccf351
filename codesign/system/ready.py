"""From a bound system to a machine at time 0: what ``check`` tries, and what ``run`` goes on from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from codesign import components
from codesign.ground.errors import CodesignError, SpecError
from codesign.ground.records import Listener
from codesign.inputs import fault
from codesign.planners.job import lever_texts
from codesign.system.assemble import refused
from codesign.system.bind import System
from codesign.system.build import Machine, build
from codesign.system.fit import TellLevers
from codesign.system.memory import refusal
from codesign.system.outcome import SystemFit, fit_system


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
