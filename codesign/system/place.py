"""Placement: which component does each task, and what crosses the links between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from codesign.errors import Fault, InputError, choose_hint
from codesign.inputs import Platform, Workload, fault
from codesign.inputs.components import ProcessorComponent, RobotComponent
from codesign.inputs.scenario import Drive
from codesign.inputs.tasks import SCENARIO_TASKS
from codesign.planners.interface import COMMAND, LOAD, LOWER_BOUND, POSE, Planner, Problem
from codesign.planners.job import Job
from codesign.planners.styles import Architecture, TaskStyle
from codesign.planners.task_graph import Flow, TaskGraph
from codesign.system import catalog
from codesign.system.flows import sound_flows

SENSE, MOVE, DISPLAY, DETECT = "sense", "move", "display", "detect"

COMMAND_BITS = 96
"""How far to go on which way at most how fast, three words of 32 bits: assumed."""

SEEN, SEEN_BITS = "seen", 96
"""The flow from who keeps the map to who commands: where the robot was, and how fast, three words of 32 bits (assumed),
and every cell that changed since the last one that arrived."""

FRAME_BITS = 64
"""A robot's position to be drawn, two words of 32 bits: assumed."""

RENDER_KERNEL = "render_robot"
"""What a processor's cost of drawing one robot is called; without it what arrives is shown at once."""

_OPTIONAL = frozenset({LOWER_BOUND, DISPLAY})
"""Tasks that are done only where they are mapped."""


@dataclass(frozen=True, eq=False)
class Placement:
    """Where the tasks of a workload are done.

    - ``places``: the component of each task that is done.
    - ``graph``: those tasks, and what flows between them in one turn.
    - ``inside``: the planner's tasks that the planning component does by itself.
    - ``styles``: how the other tasks of the planner are done, and those inside that are asked for again and again.
    """

    places: Mapping[str, str]
    graph: TaskGraph
    inside: frozenset[str]
    styles: Mapping[str, TaskStyle]


def asker_of(platform: Platform, component: str) -> str:
    """Who wants the plan: the first processor that is not the planning ``component``, or else that itself."""
    others = [
        name
        for name, spec in platform.components.items()
        if isinstance(spec, ProcessorComponent) and name != component
    ]
    return others[0] if others else component


def robot_of(platform: Platform, workload: Workload) -> str | None:
    """The robot of a drive, None where the platform has none or several and the scenario names none."""
    wanted = workload.scenario.robot if isinstance(workload.scenario, Drive) else None
    robots = [name for name, spec in platform.components.items() if isinstance(spec, RobotComponent)]
    if wanted is not None:
        return wanted if wanted in robots else None
    return robots[0] if len(robots) == 1 else None


def place(
    platform: Platform, workload: Workload, planner: Planner, architecture: Architecture, problem: Problem
) -> tuple[Placement | None, list[Fault]]:
    """The placement that workload and defaults come to, or every fault of it.

    Raises:
        InputError: the planner lists flows that cannot be.
    """
    faults = _robot_faults(platform, workload)
    if faults:
        return None, faults
    places = _places(platform, workload, planner)
    faults = _type_faults(platform, workload, places)
    planning = places[planner.planning_task]
    inside = frozenset(task for task in planner.tasks if places.get(task) == planning)
    styles, style_faults = _styles(platform, workload, planner, places, inside)
    faults += style_faults
    undone = _undone_faults(workload, places)
    if undone:
        return None, [*faults, *undone]
    flows = _flows(platform, workload, planner, problem, places)
    try:
        graph = TaskGraph(tuple(places), flows)
    except InputError as wrong:
        return None, [*faults, fault(workload, ("tasks",), wrong.what, wrong.hint)]
    faults += _way_faults(platform, graph, places)
    job = Job(problem, workload.mapping[planner.planning_task].parameters)
    needed = [(planning, kernel, f"style {architecture.style}") for kernel in architecture.kernels(job)]
    again = isinstance(workload.scenario, Drive) and any(flow.name == POSE for flow in graph.flows)
    needed += [
        (places[task], kernel, f"task {task}")
        for task, style in styles.items()
        if task not in inside or (again and task != DETECT)
        for kernel in style.kernels(job)
    ]
    needed += [(places[task.name], task.kernel, f"task {task.name}") for task in workload.tasks]
    faults += _cost_faults(platform, needed)
    return (None if faults else Placement(places, graph, inside, styles)), faults


def scenario_faults(workload: Workload, planner: Planner) -> list[Fault]:
    """A scenario that is not for the planner."""
    scenario = workload.scenario
    wanted = "drive" if planner.problem_model is None else "fleet"
    if scenario.type in {"plan_once", wanted}:
        return []
    text = f"scenario {scenario.type} is not for planner {planner.name}"
    return [fault(workload, ("scenario", "type"), text, f"scenario {wanted}, or another planner")]


def _robot_faults(platform: Platform, workload: Workload) -> list[Fault]:
    """A drive that no robot of the platform can do, or several."""
    scenario = workload.scenario
    if not isinstance(scenario, Drive) or robot_of(platform, workload) is not None:
        return []
    robots = [name for name, spec in platform.components.items() if isinstance(spec, RobotComponent)]
    if scenario.robot is not None:
        text = f"platform {platform.name} has no robot {scenario.robot!r}"
        return [fault(workload, ("scenario", "robot"), text, choose_hint(scenario.robot, robots))]
    text = f"a drive needs a robot, and platform {platform.name} has {len(robots) or 'none'}"
    hint = (
        f"set robot to one of {', '.join(robots)}"
        if robots
        else "give the platform a component of type robot"
    )
    return [fault(workload, ("scenario",), text, hint)]


def _places(platform: Platform, workload: Workload, planner: Planner) -> dict[str, str]:
    """Every task that is done, with its component, in the order in which data flow."""
    mapping = {task: mapped.component for task, mapped in workload.mapping.items()}
    planning = mapping[planner.planning_task]
    asker = asker_of(platform, planning)
    robot = robot_of(platform, workload)
    scenario = SCENARIO_TASKS[workload.scenario.type]
    extra = [task.name for task in workload.tasks]
    ahead = [task for task in scenario if task in {SENSE, LOAD}]
    behind = [task for task in scenario if task not in ahead]
    places: dict[str, str] = {}
    for task in (*ahead, *planner.tasks, *behind, *extra):
        default = planning
        if task in {LOAD, COMMAND} or task in extra:
            default = asker
        elif task in {SENSE, MOVE}:
            default = robot or asker
        if task in mapping or task not in _OPTIONAL:
            places[task] = mapping.get(task, default)
    return places


def _flows(
    platform: Platform, workload: Workload, planner: Planner, problem: Problem, places: Mapping[str, str]
) -> tuple[Flow, ...]:
    parameters = workload.mapping[planner.planning_task].parameters
    declared = sound_flows(planner, Job(problem, parameters))
    flows = [flow for flow in declared if {flow.sender, flow.receiver} <= set(places)]
    if SENSE in places:
        flows.append(Flow(SENSE, LOAD, "scan", scan_bits(platform, workload, problem)))
        flows.append(Flow(COMMAND, MOVE, "command", COMMAND_BITS))
        if places[LOAD] != places[COMMAND]:
            flows.append(Flow(LOAD, COMMAND, SEEN, SEEN_BITS))
    if DISPLAY in places and MOVE in places:
        flows.append(Flow(COMMAND, DISPLAY, "frame", FRAME_BITS))
    elif DISPLAY in places:
        # Of a fleet the display is sent what the planner answers, by the first robot's board itself.
        flows += [replace(flow, receiver=DISPLAY) for flow in flows if flow.receiver == COMMAND]
    for task in workload.tasks:
        flows += [Flow(sender, task.name, task.name, bits) for sender, bits in task.after.items()]
    return tuple(flows)


def scan_bits(platform: Platform, workload: Workload, problem: Problem) -> int:
    """Bits of one scan of the drive's robot."""
    from codesign.system.assemble import sensor_of

    robot = robot_of(platform, workload)
    assert robot is not None, "a drive has a robot"
    spec = platform.components[robot]
    assert isinstance(spec, RobotComponent), "robot_of names robots"
    return max(1, int(sensor_of(spec.sensor, resolution_of(workload, problem)).bits))


def resolution_of(workload: Workload, problem: Problem) -> float:
    """Metres a cell of a drive: what the scenario says, or else the map; 1 where neither does."""
    chosen = workload.scenario.resolution if isinstance(workload.scenario, Drive) else None
    return chosen or problem.resolution or 1.0


def _undone_faults(workload: Workload, places: Mapping[str, str]) -> list[Fault]:
    """Tasks of the user that come after one that nothing does."""
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


def _type_faults(platform: Platform, workload: Workload, places: Mapping[str, str]) -> list[Fault]:
    """Tasks on components that cannot do them."""
    accepted = {SENSE: ("robot",), MOVE: ("robot",), DISPLAY: ("processor", "display")}
    accepted |= {task.name: ("processor",) for task in workload.tasks}
    faults = []
    for task, component in places.items():
        types = accepted.get(task)
        kind = platform.components[component].type
        if (types is None and kind in {"fpga", "processor"}) or (types is not None and kind in types):
            continue
        wanted = " or ".join(types or ("fpga", "processor"))
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
    platform: Platform,
    workload: Workload,
    planner: Planner,
    places: Mapping[str, str],
    inside: frozenset[str],
) -> tuple[dict[str, TaskStyle], list[Fault]]:
    """The style of each task of the planner that is done apart, or again at each turn."""
    styles, faults = {}, []
    for task in planner.tasks:
        if task in {planner.planning_task, LOAD} or task not in places:
            continue
        mapped = workload.mapping.get(task)
        kind = platform.components[places[task]].type
        found = {
            name: style
            for (of, name), style in catalog.task_styles_of(planner.name, task).items()
            if of == kind
        }
        wanted = None if mapped is None or task in inside else mapped.style
        chosen = found.get(wanted) if wanted is not None else next(iter(found.values()), None)
        if chosen is not None:
            styles[task] = chosen
        elif task not in inside:
            text = f"task {task} cannot be done on {places[task]} while {planner.planning_task} is done elsewhere"
            if wanted is not None:
                text = f"task {task} has no style {wanted!r} on a component of type {kind}"
            hint = (
                choose_hint(wanted, found) if wanted and found else f"place it beside {planner.planning_task}"
            )
            path = ("mapping", task) if mapped is not None else ("mapping",)
            faults.append(fault(workload, path, text, hint))
    return styles, faults


def _way_faults(platform: Platform, graph: TaskGraph, places: Mapping[str, str]) -> list[Fault]:
    """Flows between components that no links join."""
    from codesign.system.routes import Routes

    routes, faults, told = Routes(platform), [], set[frozenset[str]]()
    for flow in graph.flows:
        ends = places[flow.sender], places[flow.receiver]
        if routes.joined(*ends) or frozenset(ends) in told:
            continue
        told.add(frozenset(ends))
        text = (
            f"no link joins {ends[0]}, which does {flow.sender}, and {ends[1]}, which does {flow.receiver}:"
            f" {flow.name!r} cannot be sent"
        )
        faults.append(
            fault(platform, ("links",), text, f"add a link with between: [{ends[0]}, {ends[1]}] under links:")
        )
    return faults


def _cost_faults(platform: Platform, needed: Sequence[tuple[str, str, str]]) -> list[Fault]:
    """Kernels (component, kernel, who is counted in it) that their processor has no cost of."""
    faults, told = [], set()
    for name, kernel, user in needed:
        component = platform.components[name]
        if not isinstance(component, ProcessorComponent) or not kernel or kernel in component.costs:
            continue
        if (name, kernel) not in told:
            text = f"{name} has no cost of kernel {kernel}, which {user} is counted in"
            hint = f"add {kernel}: TIME to the costs of {name}, or map the task to another component or style"
            faults.append(fault(platform, ("components", name, "costs"), text, hint))
        told.add((name, kernel))
    return faults
