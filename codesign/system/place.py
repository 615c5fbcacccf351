"""Placement: the component of each task, the flows between them, and the external memory of the planning task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from codesign.ground.errors import Fault, InputError, choose_hint
from codesign.inputs import Platform, Workload, fault
from codesign.inputs.components import PLANNING_TYPES, MemoryComponent, ProcessorComponent
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.planners.interface import COMMAND, LOAD, LOWER_BOUND, POSE, Planner
from codesign.planners.job import Flow, Job, TaskGraph
from codesign.planners.styles import TaskStyle
from codesign.system import catalog
from codesign.system.assemble import memory_law
from codesign.system.messages import Routes
from codesign.system.scenario import Draft

DISPLAY, DETECT = "display", "detect"

RENDER_KERNEL = "render_robot"
"""The kernel of drawing one robot."""

_OPTIONAL = frozenset({LOWER_BOUND, DISPLAY})
"""Tasks that are done only where they are mapped."""


@dataclass(frozen=True, eq=False)
class Placement:
    """The places of the tasks of a workload.

    - ``places``: the component of each task that is done.
    - ``graph``: those tasks, and what flows between them in one turn.
    - ``inside``: the planner's tasks that the planning component does by itself.
    - ``styles``: how the other tasks of the planner are done, and those inside that are asked for again and again.
    """

    places: Mapping[str, str]
    graph: TaskGraph
    inside: frozenset[str]
    styles: Mapping[str, TaskStyle]


def _asker(platform: Platform, component: str) -> str:
    """The component that asks for the plan: the first processor besides the planning ``component``, or else that."""
    others = [name for name in platform.of(ProcessorComponent) if name != component]
    return others[0] if others else component


def place(draft: Draft) -> tuple[Placement | None, list[Fault]]:
    """The placement by workload and defaults, or every fault of it.

    Raises:
        InputError: the planner lists flows that cannot be.
    """
    platform, workload, planner = draft.platform, draft.workload, draft.planner
    places = _places(draft)
    faults = _type_faults(draft, places)
    planning = places[planner.planning_task]
    inside = frozenset(task for task in planner.tasks if places.get(task) == planning)
    styles, style_faults = _styles(draft, places, inside)
    faults += style_faults
    undone = _undone_faults(workload, places)
    if undone:
        return None, [*faults, *undone]
    flows = _flows(draft, places)
    try:
        graph = TaskGraph(tuple(places), flows)
    except InputError as wrong:
        return None, [*faults, fault(workload, ("tasks",), wrong.what, wrong.hint)]
    faults += _link_faults(platform, graph, places)
    job, architecture = draft.job, draft.architecture
    needed = [(planning, kernel, f"style {architecture.style}") for kernel in architecture.kernels(job)]
    again = draft.scenario.asks_again and any(flow.name == POSE for flow in graph.flows)
    needed += [
        (places[task], kernel, f"task {task}")
        for task, style in styles.items()
        if task not in inside or (again and task != DETECT)
        for kernel in style.kernels(job)
    ]
    needed += [(places[task.name], task.kernel, f"task {task.name}") for task in workload.tasks]
    beside = draft.scenario.kernels(draft, places)
    needed += [(places[task], kernel, f"task {task}") for task, kernel in beside.items() if task in places]
    needed += [(places[LOAD], work.kernel, work.what) for work in planner.map_work(draft.job) if work.units]
    faults += _cost_faults(platform, needed)
    return (None if faults else Placement(places, graph, inside, styles)), faults


def _places(draft: Draft) -> dict[str, str]:
    """The component of every task that is done, in the order in which data flow."""
    workload, planner = draft.workload, draft.planner
    mapping = {task: mapped.component for task, mapped in workload.mapping.items()}
    planning = mapping[planner.planning_task]
    asker = _asker(draft.platform, planning)
    extra = [task.name for task in workload.tasks]
    default = {task: asker for task in (LOAD, COMMAND, *extra)}
    default |= draft.scenario.places(draft)
    tasks = workload.scenario.tasks
    planned = tasks.index(LOAD) + 1
    ordered = (*tasks[:planned], *planner.tasks, *tasks[planned:], *extra)
    return {
        task: mapping.get(task, default.get(task, planning))
        for task in ordered
        if task in mapping or task not in _OPTIONAL
    }


def _flows(draft: Draft, places: Mapping[str, str]) -> tuple[Flow, ...]:
    planned = sound_flows(draft.planner, draft.job)
    flows = [flow for flow in planned if {flow.sender, flow.receiver} <= set(places)]
    flows += draft.scenario.flows(draft, places, tuple(flows))
    for task in draft.workload.tasks:
        flows += [Flow(sender, task.name, task.name, bits) for sender, bits in task.after.items()]
    return tuple(flows)


def _undone_faults(workload: Workload, places: Mapping[str, str]) -> list[Fault]:
    """Tasks of the user that come after a task that nothing does."""
    faults = []
    for index, task in enumerate(workload.tasks):
        for name in task.after:
            if name in places:
                continue
            text, hint = f"there is no task {name!r}", choose_hint(name, set(places) - {task.name})
            if name in _OPTIONAL:
                text = f"task {name} is done only where it is mapped"
                hint = f"add {name}: {{component: NAME}} to the mapping"
            place = ("tasks", index, "after", name)
            faults.append(workload.document.fault(place, text, hint, at_key=True))
    return faults


def _type_faults(draft: Draft, places: Mapping[str, str]) -> list[Fault]:
    """Tasks on components that cannot do them."""
    platform, workload = draft.platform, draft.workload
    accepted = {DISPLAY: ("processor", "display"), **draft.scenario.component_types}
    accepted |= {task.name: ("processor",) for task in workload.tasks}
    faults = []
    for task, component in places.items():
        types = accepted.get(task)
        kind = platform.components[component].type
        if kind in (PLANNING_TYPES if types is None else types):
            continue
        wanted = " or ".join(types or PLANNING_TYPES)
        path: tuple[str, ...] = ("mapping", task, "component") if task in workload.mapping else ("mapping",)
        text = f"task {task} is on {component}, which is {a_type(kind)}"
        faults.append(fault(workload, path, text, f"place it on a component of type {wanted}"))
    return faults


def a_type(kind: str) -> str:
    """A type of component with its article.

    >>> a_type("fpga"), a_type("robot")
    ('an fpga', 'a robot')
    """
    return f"an {kind}" if kind == "fpga" else f"a {kind}"


def _styles(
    draft: Draft, places: Mapping[str, str], inside: frozenset[str]
) -> tuple[dict[str, TaskStyle], list[Fault]]:
    """The style of each task of the planner that is done apart, or again at each turn."""
    platform, workload, planner = draft.platform, draft.workload, draft.planner
    styles, faults = {}, []
    for task in planner.tasks:
        if task in {planner.planning_task, LOAD} or task not in places:
            continue
        mapped = workload.mapping.get(task)
        kind = platform.components[places[task]].type
        possible = {
            name: style for (of, name), style in catalog.task_styles_of(planner.name, task).items() if of == kind
        }
        wanted = None if mapped is None or task in inside else mapped.style
        chosen = possible.get(wanted) if wanted is not None else next(iter(possible.values()), None)
        if chosen is not None:
            styles[task] = chosen
        elif task not in inside:
            text = f"task {task} cannot be done on {places[task]} while {planner.planning_task} is done elsewhere"
            if wanted is not None:
                text = f"task {task} has no style {wanted!r} on a component of type {kind}"
            hint = choose_hint(wanted, possible) if wanted and possible else f"place it beside {planner.planning_task}"
            path = ("mapping", task) if mapped is not None else ("mapping",)
            faults.append(fault(workload, path, text, hint))
    return styles, faults


def _link_faults(platform: Platform, graph: TaskGraph, places: Mapping[str, str]) -> list[Fault]:
    """Flows between components that no links join."""
    routes, faults, reported = Routes(platform), [], set[frozenset[str]]()
    for flow in graph.flows:
        ends = places[flow.sender], places[flow.receiver]
        if routes.joined(*ends) or frozenset(ends) in reported:
            continue
        reported.add(frozenset(ends))
        text = (
            f"no link joins {ends[0]}, which does {flow.sender}, and {ends[1]}, which does {flow.receiver}:"
            f" {flow.name!r} cannot be sent"
        )
        faults.append(
            fault(platform, ("links",), text, f"add a link with between: [{ends[0]}, {ends[1]}] under links:")
        )
    return faults


def _cost_faults(platform: Platform, needed: Sequence[tuple[str, str, str]]) -> list[Fault]:
    """Kernels that their processor has no cost of. ``needed``: component, kernel, and what is counted in it."""
    missing: dict[tuple[str, str], str] = {}
    for name, kernel, user in needed:
        kernels_there = platform.components[name].kernels
        if kernels_there is not None and kernel and kernel not in kernels_there:
            missing.setdefault((name, kernel), user)
    faults = []
    for name, user in dict.fromkeys((name, user) for (name, _), user in missing.items()):
        kernels = [kernel for (at, kernel), of in missing.items() if (at, of) == (name, user)]
        what = f"kernel {kernels[0]}" if len(kernels) == 1 else f"kernels {', '.join(kernels)}"
        text = f"{name} has no cost of {what}, which {user} is counted in"
        hint = (
            f"add {', '.join(f'{kernel}: TIME' for kernel in kernels)} to the costs of {name} (0 s where another cost"
            " holds it), or map the task to another component or style"
        )
        faults.append(fault(platform, ("components", name, "costs"), text, hint))
    return faults


def map_work_notes(draft: Draft, placement: Placement) -> tuple[str, ...]:
    """A note for work on the map whose time does not count: the component that sends the map is no processor."""
    name = placement.places[LOAD]
    spec = draft.platform.components[name]
    if spec.kernels is not None:
        return ()
    done = dict.fromkeys(work.what for work in draft.planner.map_work(draft.job) if work.units)
    return tuple(
        f"{what}: {name}, which sends the map, is {a_type(spec.type)}; the time of that is not counted" for what in done
    )


def sound_flows(planner: Planner, job: Job[Any, Any]) -> tuple[Flow, ...]:
    """``planner.flows`` of a job.

    Raises:
        InputError: they are not what ``Planner.flows`` promises: the plug-in is at fault, not the workload.
    """
    flows: Any = planner.flows(job)
    wrong = _flow_fault(planner, flows)
    if wrong is not None:
        where = f"{type(planner).__module__}.{type(planner).__qualname__}.flows"
        raise InputError(
            f"planner plug-in {planner.name}: {wrong}", where, "mend or uninstall the package that registers it"
        )
    return tuple(flows)


def _flow_fault(planner: Planner, flows: Any) -> str | None:
    if not isinstance(flows, tuple | list) or not all(isinstance(flow, Flow) for flow in flows):
        return f"flows gives {type(flows).__name__}, not a tuple of Flow"
    tasks, seen = tuple(dict.fromkeys((LOAD, *planner.tasks, COMMAND))), set()
    for flow in flows:
        path = f"{flow.name!r} from {flow.sender!r} to {flow.receiver!r}"
        strange = [task for task in (flow.sender, flow.receiver) if task not in tasks]
        if strange:
            return f"flow {path} names {strange[0]!r}, which is no task: accepted are {', '.join(tasks)}"
        if type(flow.bits) is not int or flow.bits <= 0:
            return f"flow {path} has {flow.bits!r} bits: give an integer above 0"
        if (flow.sender, flow.receiver, flow.name) in seen:
            return f"flow {path} is listed twice"
        seen.add((flow.sender, flow.receiver, flow.name))
    try:
        TaskGraph(tasks, tuple(flows))
    except InputError as circle:
        return circle.what
    return None


def external_of(draft: Draft) -> ExternalMemoryLaw | None:
    """The law of the accesses to the planning task's external memory; None where it asks for none."""
    name = draft.workload.mapping[draft.planner.planning_task].external_memory
    spec = draft.platform.of(MemoryComponent).get(name or "")
    return None if spec is None else memory_law(str(name), spec)


def memory_faults(draft: Draft) -> list[Fault]:
    """External memories that are no memories, that are beside another FPGA, or that the task has no use for."""
    platform, workload, architecture = draft.platform, draft.workload, draft.architecture
    planning = draft.planner.planning_task
    memories = platform.of(MemoryComponent)
    faults = []
    for task, mapped in workload.mapping.items():
        name, path = mapped.external_memory, ("mapping", task, "external_memory")
        if name is None:
            continue
        spec = memories.get(name)
        if spec is None:
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
