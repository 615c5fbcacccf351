"""From a bound system to a machine at time 0: what ``check`` tries, and what ``run`` goes on from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from codesign.errors import CodesignError, SpecError
from codesign.records import Listener
from codesign.spec import fault
from codesign.system.bind import System
from codesign.system.build import Machine, build
from codesign.system.memory import refusal
from codesign.system.outcome import fitted_fields
from codesign.system.refusals import refused
from codesign.system.result import Reason

if TYPE_CHECKING:
    from codesign.components import Granularity


@dataclass(frozen=True, eq=False)
class Ready:
    """A system that nothing keeps from being simulated.

    ``fields``: what the design takes of its part, as fields of a result. ``reasons``: why it does not fit; empty: it
    fits. ``machine``: its components at time 0; None where it does not fit.
    """

    fields: dict[str, Any]
    reasons: tuple[Reason, ...]
    machine: Machine | None


def ready(
    system: System,
    listeners: Sequence[Listener] = (),
    granularity: Granularity | None = None,
    *,
    memory: int | None = None,
    keeping: bool = False,
) -> Ready:
    """Fit the system and, where it fits, build its machine.

    ``granularity``: run-ahead by default. ``memory``: bytes that the run may take, by an estimate; by default half of
    what the machine has free. ``keeping``: a listener keeps all records in memory. Nothing is simulated, and no record
    is made.

    Raises:
        SpecError: a law, a component or the memory of this computer refuses the design point; at its place in a file.
    """
    from codesign.components import Granularity

    task = system.planner.planning_task
    mapped = system.workload.mapping[task]
    try:
        fields, reasons = fitted_fields(system)
    except SpecError:
        raise
    except CodesignError as wrong:
        raise SpecError([refused(system.workload, ("mapping", task), mapped.parameters, wrong)]) from wrong
    if reasons:
        return Ready(fields, reasons, None)
    too_much = refusal(system, memory, listening=bool(listeners), keeping=keeping)
    if too_much is not None:
        raise SpecError([fault(system.workload, ("mapping", task), *too_much)])
    return Ready(fields, (), build(system, listeners, granularity or Granularity.RUN_AHEAD))
