"""Energy of a run: what each FPGA, processor, memory and link drew, busy or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from codesign.figures import Figure, Status
from codesign.inputs.components import FpgaComponent, MemoryComponent, ProcessorComponent
from codesign.results.result import Energy, Power
from codesign.system.bind import System
from codesign.units import PICOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from codesign.components import Component
    from codesign.system.build import Machine


def board_powers(system: System, designs: Mapping[str, Power]) -> dict[str, Power]:
    """The power of every FPGA that the platform declares, by name.

    ``designs``: of those with a task, as the laws of the tasks' styles give it. An FPGA without a task draws the static
    power of its part for as long as the run takes, as a board that is switched on does.
    """
    nothing = Figure(0, "W", Status.ASSUMED, "no task is on it")
    return {
        name: designs.get(name) or Power(static=spec.chip.static_power, dynamic=nothing)
        for name, spec in system.platform.components.items()
        if isinstance(spec, FpgaComponent)
    }


def idle_boards(system: System) -> tuple[str, ...]:
    """The FPGAs that no task is placed on."""
    used = set(system.placement.places.values())
    return tuple(
        name
        for name, spec in system.platform.components.items()
        if isinstance(spec, FpgaComponent) and name not in used
    )


def energy(machine: Machine, boards: Mapping[str, Power], others: Sequence[Component] = ()) -> Energy:
    """Static power over the whole time and dynamic power over the busy time; all others by their own figures.

    Args:
        machine: after the run.
        boards: the power of each FPGA; see ``board_powers``.
        others: FPGAs like the planning one, beside the platform's.
    """
    span, system = machine.now / PICOSECONDS_PER_SECOND, machine.system
    drawn = {name: _of_board(power, machine.by_name[name], span) for name, power in boards.items()}
    alike = sum(_of_board(boards[system.component], each, span) for each in others)
    parts = {ProcessorComponent: 0.0, MemoryComponent: 0.0}
    for name, component in system.platform.components.items():
        for kind in parts:
            if isinstance(component, kind) and component.power is not None:
                parts[kind] += _joules(component.power, machine.by_name[name], span)
    links = sum(
        _joules(spec.power, machine.links[name], span)
        for name, spec in system.platform.links.items()
        if spec.power is not None
    )
    processors, memories = parts[ProcessorComponent], parts[MemoryComponent]
    fpga = sum(drawn.values()) + alike
    return Energy(
        fpga_j=fpga,
        idle_fpgas_j=sum(drawn[name] for name in idle_boards(system)),
        processors_j=processors,
        links_j=links,
        memories_j=memories,
        energy_j=fpga + processors + links + memories,
        not_declared=_not_declared(system),
    )


def _of_board(power: Power, fpga: Component, span: float) -> float:
    return power.static.value * span + power.dynamic.value * fpga.busy / PICOSECONDS_PER_SECOND


def _joules(power: Any, component: Component, span: float) -> float:
    busy = component.busy / PICOSECONDS_PER_SECOND
    return float(power.busy.value * busy + power.idle.value * (span - busy))


def _not_declared(system: System) -> dict[str, tuple[str, ...]]:
    """Links and memories without a figure of power."""
    components, links = system.platform.components, system.platform.links
    memories = {name: spec for name, spec in components.items() if isinstance(spec, MemoryComponent)}
    missing = {
        kind: tuple(name for name, spec in of_kind.items() if spec.power is None)
        for kind, of_kind in (("links", links), ("memories", memories))
    }
    return {kind: names for kind, names in missing.items() if names}
