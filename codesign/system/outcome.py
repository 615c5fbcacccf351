"""The fields of a ``Result`` that a bound system and its run give."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from codesign import components
from codesign.ground.figures import Figure
from codesign.ground.memo import Memo
from codesign.ground.models import TaskParameters
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs import Platform, Workload
from codesign.inputs.components import DisplayComponent, FpgaComponent, ProcessorComponent
from codesign.inputs.document import dotted, leaves
from codesign.inputs.edit import PROBLEM, moves
from codesign.maps import OccupancyGrid
from codesign.planners.interface import Quality
from codesign.planners.job import lever_texts
from codesign.system.bind import Design, System
from codesign.system.build import Machine
from codesign.system.chain import Answer
from codesign.system.energy import board_powers, energy, idle_boards
from codesign.system.fit import TellLevers, fit_design
from codesign.system.problem_map import length_error
from codesign.system.results.mission import LinkUse
from codesign.system.results.result import DisplayUse, Power, Provenance, Reason, Times

# The provenance of what is simulated or explored.


def provenance_of(platforms: Iterable[Platform], workload: Workload, grid: OccupancyGrid | None) -> Provenance:
    """The digests of the specs and of the map, and the seeds of the workload that no axis moves."""
    platforms = tuple(platforms)
    axes = workload.explore.every_axis if workload.explore else {}
    several = any(moves(axis, PROBLEM) for axis in axes)
    return Provenance(
        platform_digests={platform.name: platform.digest() for platform in platforms},
        calibration_digests={
            f"{platform.name}.{component}": digest
            for platform in platforms
            for component, digest in platform.calibrations.items()
        },
        workload_digest=workload.digest(),
        map_digest=None if grid is None or several else grid.digest,
        seeds={
            path: seed
            for path, seed in _seeds(workload.model_dump(mode="json", exclude={"explore", "variants"}))
            if not any(moves(f"workload.{path}", axis) for axis in axes)
        },
    )


def _seeds(tree: dict[str, Any]) -> Iterator[tuple[str, int]]:
    for path, value in leaves(tree):
        if str(path[-1] if path else "").endswith("seed") and isinstance(value, int):
            yield dotted(path), value


def head_fields(system: System) -> dict[str, Any]:
    """The names, places and parameters of a run."""
    parameters = {name: _used_parameters(system, model) for name, model in system.parameters.items()}
    return {
        "platform": system.platform.name,
        "workload": system.workload.name,
        "planner": system.planner.name,
        "style": system.architecture.style,
        "component": system.component,
        "places": dict(system.placement.places),
        "roles": system.platform.filled,
        "external_memory": None if system.external is None else system.external.name,
        "part": None if system.part is None else system.part.full_name,
        "parameters": parameters,
        "notes": system.notes,
        "found": system.found,
        "blocks": system.planning.block_count(system.problem.rows, system.problem.columns),
    }


def _used_parameters(system: System, parameters: TaskParameters) -> dict[str, Any]:
    """The parameters of a task but those that this design does not use."""
    exclude = set(parameters.unused(system.external is not None))
    return parameters.model_dump(mode="json", exclude=exclude)


@dataclass(frozen=True)
class SystemFit:
    """A design's use of its parts.

    - ``fields``: of a result. ``reasons``: why it does not fit; empty where it does.
    - ``boards``: the power of every FPGA of the platform, by name.
    """

    fields: dict[str, Any]
    reasons: tuple[Reason, ...]
    boards: dict[str, Power]


def fit_system(system: System, tell: TellLevers = lever_texts) -> SystemFit:
    """Hold the design against its parts. ``tell`` puts the levers of its planning task into words.

    The resources and the clock of a result are of the FPGA that plans; where none does, of the last one that has
    a design.
    """
    specs, designs = system.platform.of(FpgaComponent), system.designs
    planning = designs.pop(system.component, None) or Design(system.architecture, system.job)
    held = {
        name: fit_design(name, specs[name], design, int(specs[name].clock.value)) for name, design in designs.items()
    }
    own = specs.get(system.component)
    held[system.component] = fit_design(system.component, own, planning, system.clock, tell)
    fields: dict[str, Any] = {} if own is not None else {"processor": _processor_figures(system)}
    powers = {name: each.power for name, each in held.items() if each.power is not None}
    for name, power in powers.items():
        fields |= {"resources": held[name].part.resources, "clock": held[name].part.clock, "power": power}
    boards = board_powers(system, powers)
    *apart, last = held.values()
    fields |= {
        "notes": system.notes + sum((each.notes for each in apart), ()) + last.notes,
        "bounds": sum((each.part.bounds for each in (last, *apart)), ()),
        "idle_fpgas": {name: boards[name].static for name in idle_boards(system)},
    }
    return SystemFit(fields, sum((each.part.reasons for each in (last, *apart)), ()), boards)


def _processor_figures(system: System) -> dict[str, Figure]:
    """The figures on which time and energy of a processor rest."""
    spec = system.platform.of(ProcessorComponent)[system.component]
    figures = {f"cost of {kernel}": cost.per(PICOSECONDS_PER_SECOND, "s") for kernel, cost in spec.costs.items()}
    return figures | {"power busy": spec.power.busy, "power idle": spec.power.idle}


def plan_fields(machine: Machine, answer: Answer, memo: Memo | None) -> dict[str, Any]:
    """Times, cycles and quality of a first plan."""
    figures, quality = machine.system.planner.figures(answer.plan), quality_of(machine.system, answer, memo)
    lengths = machine.system.problem.optimal_lengths
    if lengths and isinstance(quality, Quality):
        mean, error = sum(lengths) / len(lengths), length_error(machine.system.problem)
        quality = replace(quality, optimal_length_mean=mean, optimal_length_error=error)
    return {"time": times_until(answer), "cycles": machine.cycles(), **figures, "quality": quality}


def times_until(answer: Answer) -> Times:
    """The times of what was done, until an answer."""
    return Times(
        map_loaded_s=answer.loaded / PICOSECONDS_PER_SECOND,
        planned_s=answer.planned / PICOSECONDS_PER_SECOND,
        first_plan_s=answer.answered / PICOSECONDS_PER_SECOND,
    )


def quality_of(system: System, answer: Answer, memo: Memo | None) -> Any:
    """The planner's judgement of an answer: computed once for each problem and plan."""
    planner = system.planner
    key = ("quality", planner.name, answer.problem.digest, planner.identity(answer.plan))
    return (Memo() if memo is None else memo).get(key, lambda: planner.quality(answer.problem, answer.plan))


def use_fields(
    machine: Machine, boards: Mapping[str, Power], others: Sequence[components.Component] = ()
) -> dict[str, Any]:
    """Energy, utilisation, links and displays up to now. ``boards``, ``others``: see ``energy``."""
    return {
        "energy": energy(machine, boards, others),
        "utilisation": {
            # A run may take no time, as on a host with costs of 0: then no component is busy.
            component.name: component.busy / max(machine.now, 1)
            for component in machine.all_components
        },
        "links": {
            name: link_use(link, machine.now, machine.messages.ignored(name)) for name, link in machine.links.items()
        },
        "displays": {name: display_use(machine.by_name[name]) for name in machine.system.platform.of(DisplayComponent)},
    }


def display_use(display: components.VgaDisplay) -> DisplayUse:
    """The account of a display up to now."""
    return DisplayUse(frames=display.frames, starved_words=display.starved, port_share=display.port_share)


def link_use(link: Any, now: int, ignored: dict[str, int]) -> LinkUse:
    """The account of a link's messages; ``ignored``: damage that did no harm, by message."""
    return LinkUse(
        sent=link.sent,
        delivered=link.delivered,
        dropped=dict(sorted(link.dropped.items())),
        in_flight=link.in_flight,
        retransmissions=link.retransmissions,
        undetected=link.undetected,
        ignored_damage=ignored,
        late=link.late,
        bits=link.bits,
        utilisation=link.busy / max(now, 1),
        queued_s=link.queued / 1e12,
    )
