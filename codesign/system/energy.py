"""Energy of a run: what each FPGA, processor, memory and link drew, busy or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from codesign import components
from codesign.ground.figures import Figure, Status
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.components import FpgaComponent, MemoryComponent, ProcessorComponent
from codesign.system.bind import System
from codesign.system.results.result import Energy, Power


class Spender(Protocol):
    """The machine whose run takes energy: one, or many side by side with arrays for numbers."""

    @property
    def system(self) -> System:
        """The bound system."""

    @property
    def now(self) -> Any:
        """Picoseconds since the start."""

    @property
    def by_name(self) -> Mapping[str, Any]:
        """The components, each with its ``busy``, ps."""

    @property
    def links(self) -> Mapping[str, Any]:
        """The links, alike."""

    def watts(self, name: str) -> tuple[Any, Any]:
        """The draw of a processor, memory or link, W: while it works, and while it does not."""


def board_powers(system: System, designs: Mapping[str, Power]) -> dict[str, Power]:
    """The power of every FPGA that the platform declares, by name.

    ``designs``: of those with a task, as the laws of the tasks' styles give it. An FPGA without a task draws the static
    power of its part for as long as the run takes, as a board that is switched on does.
    """
    nothing = Figure(0, "W", Status.ASSUMED, "no task is on it")
    return {
        name: designs.get(name) or Power(static=spec.chip.static_power, dynamic=nothing)
        for name, spec in system.platform.of(FpgaComponent).items()
    }


def idle_boards(system: System) -> tuple[str, ...]:
    """The FPGAs that no task is placed on."""
    used = set(system.placement.places.values())
    return tuple(name for name in system.platform.of(FpgaComponent) if name not in used)


def energy(machine: Spender, boards: Mapping[str, Power], others: Sequence[components.Component] = ()) -> Energy:
    """The energy of a run; see ``joules``. ``boards``: the power of each FPGA; see ``board_powers``."""
    drawn = joules(machine, {name: watts_of(power) for name, power in boards.items()}, others)
    return energy_of(machine.system, drawn)


def energy_of(system: System, drawn: Mapping[str, float]) -> Energy:
    """The record of the parts of an energy that ``joules`` gives."""
    return Energy(**drawn, not_declared=_not_declared(system))


def watts_of(power: Power) -> tuple[float, float]:
    """Static and dynamic power, W."""
    return power.static.value, power.dynamic.value


def joules(
    machine: Spender, boards: Mapping[str, tuple[Any, Any]], others: Sequence[components.Component] = ()
) -> dict[str, Any]:
    """Static power over the whole time and dynamic power over the busy time; all others by their own figures.

    The same operations in the same order for one machine, where all is a number, and for many side by side, where all
    are arrays.

    Args:
        machine: after the run.
        boards: static and dynamic power of each FPGA, W.
        others: FPGAs like the planning one, beside the platform's.

    Returns:
        The parts of an ``Energy`` by name, J.
    """
    span, system = machine.now / PICOSECONDS_PER_SECOND, machine.system
    drawn = {name: _of_board(watts, machine.by_name[name], span) for name, watts in boards.items()}
    alike = sum(_of_board(boards[system.component], each, span) for each in others)
    processors: Any = 0.0
    memories: Any = 0.0
    for name in system.platform.of(ProcessorComponent):
        processors = processors + _joules(machine.watts(name), machine.by_name[name], span)
    for name, memory in system.platform.of(MemoryComponent).items():
        if memory.power is not None:
            memories = memories + _joules(machine.watts(name), machine.by_name[name], span)
    links = sum(
        _joules(machine.watts(name), machine.links[name], span)
        for name, spec in system.platform.links.items()
        if spec.power is not None
    )
    fpga = sum(drawn.values()) + alike
    return {
        "fpga_j": fpga,
        "idle_fpgas_j": sum(drawn[name] for name in idle_boards(system)),
        "processors_j": processors,
        "links_j": links,
        "memories_j": memories,
        "energy_j": fpga + processors + links + memories,
    }


def _of_board(watts: tuple[Any, Any], fpga: Any, span: Any) -> Any:
    static, dynamic = watts
    return static * span + dynamic * fpga.busy / PICOSECONDS_PER_SECOND


def _joules(watts: tuple[Any, Any], component: Any, span: Any) -> Any:
    busy = component.busy / PICOSECONDS_PER_SECOND
    while_busy, while_idle = watts
    return while_busy * busy + while_idle * (span - busy)


def _not_declared(system: System) -> dict[str, tuple[str, ...]]:
    """Links and memories without a figure of power."""
    kinds: dict[str, Mapping[str, Any]] = {
        "links": system.platform.links,
        "memories": system.platform.of(MemoryComponent),
    }
    missing = {
        kind: tuple(name for name, spec in of_kind.items() if spec.power is None) for kind, of_kind in kinds.items()
    }
    return {kind: names for kind, names in missing.items() if names}
