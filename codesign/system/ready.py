"""From a bound system to a machine at time 0: what ``check`` tries, and what ``run`` goes on from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from codesign.errors import CodesignError, Fault, SpecError
from codesign.records import Listener
from codesign.spec import fault
from codesign.system.bind import System
from codesign.system.build import Machine, build
from codesign.system.outcome import fitted_fields
from codesign.system.refusals import refused
from codesign.system.result import Reason

if TYPE_CHECKING:
    from codesign.components import Granularity

MAX_BYTES = 4 * 2**30
"""Most memory that the field of one run may need, by an estimate."""

# Assumed: the field of a stage, that of the stage before, its planes and the block under way; distances and labels.
_WORDS_AT_ONCE = 4
_BYTES_A_CELL = 64


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
    system: System, listeners: Sequence[Listener] = (), granularity: Granularity | None = None
) -> Ready:
    """Fit the system and, where it fits, build its machine.

    ``granularity``: run-ahead by default. Nothing is simulated, and no record is made.

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
    faults = _memory_faults(system)
    if faults:
        raise SpecError(faults)
    return Ready(fields, (), build(system, listeners, granularity or Granularity.RUN_AHEAD))


def _memory_faults(system: System) -> list[Fault]:
    """What this computer has no memory for: a field of long words on a large map."""
    precisions = getattr(system.planning, "precisions", None)
    if not precisions or not hasattr(system.problem, "free"):
        return []
    words = max(precisions) // 64 + 1
    needed = system.problem.free.size * (_WORDS_AT_ONCE * 8 * words + _BYTES_A_CELL)
    if needed <= MAX_BYTES:
        return []
    text = (
        f"{system.problem.free.size:,} cells at {max(precisions)} bits would need about"
        f" {needed / 2**30:.1f} GiB of memory, more than {MAX_BYTES // 2**30}"
    )
    path = ("mapping", system.planner.planning_task, "schedule")
    return [
        fault(system.workload, path, text, "end the schedule at a lower precision, or take a smaller map")
    ]
