"""The external memory that a planning task asks for: found on the platform, or refused."""

from __future__ import annotations

from codesign.errors import Fault, choose_hint
from codesign.inputs import Platform, Workload, fault
from codesign.inputs.components import MemoryComponent
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.planners.styles import Architecture
from codesign.system import catalog
from codesign.system.assemble import memory_law


def external_of(platform: Platform, workload: Workload) -> ExternalMemoryLaw | None:
    """What the accesses of the planning task's external memory cost; None where it asks for none."""
    name = workload.mapping[catalog.planner(workload.planner).planning_task].external_memory
    spec = None if name is None else platform.components[name]
    return memory_law(str(name), spec) if isinstance(spec, MemoryComponent) else None


def memory_faults(platform: Platform, workload: Workload, architecture: Architecture) -> list[Fault]:
    """Memories that are none, that hang on another FPGA, or that the task can do nothing with."""
    planning = catalog.planner(workload.planner).planning_task
    memories = {name for name, spec in platform.components.items() if isinstance(spec, MemoryComponent)}
    faults = []
    for task, mapped in workload.mapping.items():
        name, path = mapped.external_memory, ("mapping", task, "external_memory")
        if name is None:
            continue
        spec = platform.components.get(name)
        if not isinstance(spec, MemoryComponent):
            text = f"platform {platform.name} has no memory {name!r}"
            hint = choose_hint(name, memories) if memories else "give the platform a component of type memory"
            faults.append(fault(workload, path, text, hint))
        elif spec.beside != mapped.component:
            text = f"memory {name} hangs on {spec.beside}, task {task} is on {mapped.component}"
            faults.append(fault(workload, path, text, f"place the task on {spec.beside}"))
        elif task != planning or not architecture.supports_external:
            user = f"style {architecture.style}" if task == planning else f"task {task}"
            text = f"{user} keeps everything in block RAM and has no use for an external memory"
            faults.append(fault(workload, path, text, "leave external_memory out, or take another style"))
    return faults
