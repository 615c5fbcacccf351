"""From what a platform file declares to the components that run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

from pydantic import BaseModel

from codesign import components
from codesign.ground.errors import CodesignError, Fault
from codesign.ground.figures import Figure
from codesign.ground.memo import Same
from codesign.ground.records import Listener
from codesign.inputs import Platform, Workload, fault
from codesign.inputs.components import (
    AnyComponent,
    Component,
    DisplayComponent,
    FpgaComponent,
    MemoryComponent,
    ProcessorComponent,
    RobotComponent,
    Sensor,
)
from codesign.inputs.links import AnyLink
from codesign.laws.acts import UNDISTURBED
from codesign.planners.external_memory import ExternalMemoryLaw


def component_of(
    environment: components.Environment,
    name: str,
    spec: Component,
    by_name: Mapping[str, components.Component],
    listeners: Sequence[Listener],
) -> components.Component | None:
    """The component that ``spec`` declares, beside one of ``by_name``; None: a robot, which its scenario builds.

    An FPGA has no block RAM here, and a display beside it a copy of its own: both depend on the planner.

    Raises:
        CodesignError: the component refuses a value of ``spec``; see ``refused``.
    """
    if spec.of_scenario:
        return None
    build = _BUILD.get(type(spec))
    assert build is not None, f"{type(spec).__name__} needs a maker in _BUILD"
    return build(environment, name, spec, by_name, listeners)


def _fpga(
    environment: components.Environment, name: str, spec: FpgaComponent, _by_name: Any, listeners: Sequence[Listener]
) -> components.Component:

    return components.Fpga(environment, name, components.ClockDomain(spec.law.whole(spec).rate()), listeners, None)


def _memory(
    environment: components.Environment, name: str, spec: MemoryComponent, _by_name: Any, listeners: Sequence[Listener]
) -> components.Component:

    return components.ExternalMemory(environment, name, memory_law(name, spec), listeners)


def _display(
    environment: components.Environment,
    name: str,
    spec: DisplayComponent,
    by_name: Mapping[str, components.Component],
    listeners: Sequence[Listener],
) -> components.Component:

    beside = by_name[spec.beside]
    memory = beside if isinstance(beside, components.ExternalMemory) else None
    return display_of(environment, name, spec, memory, None, listeners)


def _processor(
    environment: components.Environment,
    name: str,
    spec: ProcessorComponent,
    _by_name: Any,
    listeners: Sequence[Listener],
) -> components.Component:
    """The processor that ``spec`` declares."""

    costs = {kernel: int(cost.value) for kernel, cost in spec.costs.items()}
    clock = components.ClockDomain(int(spec.clock.value))
    pace = UNDISTURBED if spec.pace is None else int(spec.pace.value)
    return components.Processor(environment, name, clock, costs, listeners, cores=spec.cores, pace=pace)


_BUILD: Mapping[type[AnyComponent], Callable[..., components.Component]] = {
    FpgaComponent: _fpga,
    MemoryComponent: _memory,
    DisplayComponent: _display,
    ProcessorComponent: _processor,
}


def memory_law(name: str, spec: MemoryComponent) -> ExternalMemoryLaw:
    """The law of the cycles of accesses to an external memory."""
    return ExternalMemoryLaw(
        technology=spec.technology,
        hz=int(spec.clock.value),
        width=int(spec.width.value),
        capacity=int(spec.capacity.value),
        latency_cycles=int(spec.latency_cycles.value),
        row_words=None if spec.row_words is None else int(spec.row_words.value),
        row_cycles=0 if spec.row_cycles is None else int(spec.row_cycles.value),
        refresh_share=spec.refresh_share,
        name=name,
    )


def display_of(
    environment: components.Environment,
    name: str,
    spec: DisplayComponent,
    memory: Any,
    window: tuple[int, int] | None,
    listeners: Sequence[Listener],
) -> components.VgaDisplay:
    """The display that ``spec`` declares.

    ``memory`` is what it reads from, None a copy of its own; ``window``: rows and columns of the picture there, of
    which it shows what the screen has room for, None all that is seen.
    """

    columns, rows = int(spec.columns.value), int(spec.rows.value)
    scan = components.Scan(
        columns=columns,
        rows=rows,
        window=None if window is None else (min(rows, window[0]), min(columns, window[1])),
        total_columns=int(spec.total_columns.value),
        total_rows=int(spec.total_rows.value),
        pixels_a_word=int(spec.pixels_a_word.value),
    )
    clock = components.ClockDomain(int(spec.pixel_clock.value))
    return components.VgaDisplay(environment, name, clock, scan, memory=memory, listeners=listeners)


def link_of(
    environment: components.Environment, name: str, spec: AnyLink, listeners: Sequence[Listener]
) -> components.Link:
    """The link that ``spec`` declares."""

    kind: type[components.Link] = getattr(components, spec.simulated)
    declared = {key: getattr(spec, key) for key in kind.options}
    options: dict[str, Any] = {
        key: int(value.value) if isinstance(value, Figure) else value for key, value in declared.items()
    }
    return kind(
        environment,
        name,
        spec.law.whole(spec),
        between=spec.between,
        errors=_errors(spec),
        outages=[(outage.begin, outage.end) for outage in spec.outages],
        listeners=listeners,
        **options,
    )


def _errors(spec: AnyLink) -> components.LinkErrors | None:

    if spec.errors is None:
        return None
    declared = spec.errors.model_dump(exclude={"late"})
    late = spec.errors.late
    return components.LinkErrors(
        **declared, late_share=late.share if late else 0.0, late_delay=late.delay if late else 0
    )


def kinematics_of(spec: RobotComponent) -> components.Kinematics:
    """The motion of the robot, in metres and seconds."""

    declared = {key: float(value.value) for key, value in spec.kinematics if isinstance(value, Figure)}
    drives: dict[str, type[Any]] = {
        "point": components.PointDrive,
        "omnidirectional": components.OmnidirectionalDrive,
        "differential": components.DifferentialDrive,
    }
    drive: components.Kinematics = drives[spec.kinematics.type](**declared)
    return drive


def sensor_of(spec: Sensor, resolution: float) -> Any:
    """The sensor that ``spec`` declares, its range in cells of ``resolution`` metres."""

    reach = float(spec.range.value) / resolution
    return components.RaySensor(reach, spec.beams, resolution) if spec.beams else components.RadiusSensor(reach)


def refused(spec: Platform | Workload, path: Sequence[str], section: BaseModel, wrong: CodesignError) -> Fault:
    """The fault of a spec that a component or a law refused.

    Args:
        spec: the file that is at fault.
        path: of the section that was refused.
        section: its model. Where ``wrong.where`` ends in one of its keys, the fault lies at that key.
        wrong: what a component or a law raised.
    """
    key = (wrong.where or "").rpartition(".")[2]
    at_key = key in type(section).model_fields
    return fault(spec, (*path, key) if at_key else tuple(path), wrong.what, wrong.hint)


def platform_faults(platform: Platform) -> tuple[Fault, ...]:
    """The faults of components and links of a platform that no workload could build; sought once for each object.

    Each is built once and thrown away. The share of a display in an FPGA's block RAM depends on the planner and on the
    map: ``ready`` finds those faults. A robot is built by its scenario.
    """
    return _faults_of(Same(platform))


@lru_cache(maxsize=64)
def _faults_of(key: Same[Platform]) -> tuple[Fault, ...]:

    platform = key.it

    environment = components.Environment()
    displays = platform.of(DisplayComponent)
    built: dict[str, components.Component] = {}
    faults: list[Fault] = []
    for name in building_order(platform):
        spec = platform.components[name]
        if name in displays and displays[name].beside not in built:
            continue
        try:
            component = component_of(environment, name, spec, built, ())
        except CodesignError as wrong:
            faults.append(refused(platform, ("components", name), spec, wrong))
        else:
            built |= {} if component is None else {name: component}
    for name, link in platform.links.items():
        try:
            link_of(environment, name, link, ())
        except CodesignError as wrong:
            faults.append(refused(platform, ("links", name), link, wrong))
    return tuple(faults)


def building_order(platform: Platform) -> list[str]:
    """The names of the components in the order to build them: FPGAs and hosts, then memories, then displays."""
    order = {"memory": 1, "display": 2}
    return sorted(platform.components, key=lambda name: order.get(platform.components[name].type, 0))
