"""The circuit of a design point of platform and workload."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from codesign.ground.errors import UnsuitedError, choose_hint
from codesign.ground.models import Part
from codesign.inputs import Platform, Workload, fault
from codesign.inputs.components import FpgaComponent
from codesign.planners.circuits import CircuitStyle
from codesign.planners.job import Job
from codesign.system import System, catalog
from codesign.system.outcome import fit_system
from codesign.system.scenarios import bind


@dataclass(frozen=True, eq=False)
class Placed:
    """A circuit on an FPGA of a platform.

    ``style``, ``job``: its circuit and what that is asked about. ``component``: the FPGA; ``clock``: in Hz.
    """

    style: CircuitStyle
    job: Job[Any, Any]
    system: System
    component: str
    clock: int

    @property
    def part(self) -> Part:
        """The chip."""
        return self.job.chip


def placed(platform: Platform, workload: Workload) -> Placed:
    """The circuit of a design point: of its planning task, or else of the first task on an FPGA.

    Raises:
        SpecError: platform and workload do not belong together, or no task is on an FPGA with a style that has a
            circuit.
    """
    system = bind(platform, workload)
    candidates = on_fpgas(system)
    circuits = catalog.circuits()
    for task, style, component in candidates:
        circuit = circuits.get((system.planner.name, style, task))
        spec = platform.of(FpgaComponent).get(component)
        if circuit is not None and spec is not None:
            job = job_of(system, task, spec)
            return Placed(circuit, job, system, component, int(spec.clock.value))
    planning = system.planner.planning_task
    if not candidates:
        text = f"task {planning} is on {system.component}, a processor: it has no circuit"
        hint = "place the task on an FPGA, or name another platform"
        raise UnsuitedError([fault(workload, ("mapping", planning, "component"), text, hint)])
    task, style, _ = candidates[0]
    text = f"style {style!r} of task {task or planning} has no circuit in Verilog"
    with_circuit = [name for owner, name, of in circuits if (owner, of) == (system.planner.name, task)]
    if with_circuit:
        hint = choose_hint(style, with_circuit)
    elif any((owner, of) == (system.planner.name, "") for owner, _, of in circuits):
        hint = f"task {task} alone is not built: place {planning} on the FPGA too, whose circuit does both"
    else:
        hint = "no style of this planner has one"
    raise UnsuitedError([fault(workload, ("mapping", task or planning, "style"), text, hint)])


def on_fpgas(system: System) -> list[tuple[str, str, str]]:
    """Task ("" for the planning task), style and component of every task of the planner that is on an FPGA."""
    return [(design.task, design.style.style, name) for name, design in system.designs.items()]


def job_of(system: System, task: str, spec: FpgaComponent) -> Job[Any, Any]:
    """The job of a task on an FPGA: if it is placed by itself, with the plan."""
    if not task:
        return system.job
    return replace(system.job, part=spec.chip, plan=system.planner.plan(system.job))


def refuse_what_does_not_fit(design: Placed) -> None:
    """Refuse a design that is not feasible on its part.

    Raises:
        UnsuitedError: it does not fit; each reason is one fault.
    """
    reasons = fit_system(design.system).reasons
    path = ("mapping", design.system.planner.planning_task)
    faults = [
        fault(
            design.system.workload,
            path,
            f"the design does not fit {design.part.name}: it needs {reason.demand:,.0f} {reason.unit or reason.name}"
            f" ({reason.name}), and the part has {reason.limit:,.0f}",
            "; ".join(reason.levers) or "hwsw run shows what it needs",
        )
        for reason in reasons
    ]
    if faults:
        raise UnsuitedError(faults)
