"""Whether a platform and a workload go together: the places of tasks, and the axes that move platform or problem."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from codesign.errors import Fault, SpecError, choose_hint, clip
from codesign.inputs.axes import placed_faults, repeated
from codesign.inputs.components import COMPONENTS
from codesign.inputs.design_point import PLACED_FIELDS, PROBLEM, SCENARIO, moves, substitute, unplaced
from codesign.inputs.links import LINKS
from codesign.inputs.platform import Platform
from codesign.inputs.problem import FileMap, ProblemSpec
from codesign.inputs.variants import BASE, VARIANT_AXIS
from codesign.inputs.workload import PLACE_KEYS, Workload
from codesign.inputs.yaml_tree import Document, KeyPath
from codesign.models import SpecModel


def cross_check(platform: Platform, workload: Workload, *, explored: bool = False) -> None:
    """Check that tasks are mapped to components of the platform, and the axes that move platform or problem.

    ``explored``: only what the exploration runs counts; without, the workload itself does too.

    Raises:
        SpecError: every fault, at its place in the workload.
    """
    faults: list[Fault] = []
    document = workload.document
    axes = workload.explore.axes if workload.explore else {}
    listed = [name for name in axes.get(VARIANT_AXIS, ()) if isinstance(name, str)]
    mappings = {name: workload.variants[name].mapping for name in listed if name in workload.variants}
    faults += _unmapped(platform, document, workload.mapping, ()) if not (explored and mappings) else []
    if explored and mappings and (BASE in listed or None in mappings.values()):
        faults += _unmapped(platform, document, workload.mapping, ())
    for name, mapping in mappings.items():
        faults += _unmapped(platform, document, mapping or {}, ("variants", name))
    tasks = {*workload.mapping, *(task for mapping in mappings.values() for task in mapping or ())}
    known = _known_tasks(workload, listed)
    for axis, values in axes.items():
        faults += _axis_against(platform, workload, axis, values, tasks, known)
    if faults:
        raise SpecError(faults)


def _known_tasks(workload: Workload, listed: Iterable[str]) -> dict[str, set[str]]:
    """The tasks that the workload or one of the variants listed may place, each with the keys of its mapping."""
    ways = [(workload.planner, workload.scenario)]
    for variant in (workload.variants[name] for name in listed if name in workload.variants):
        ways.append((variant.planner or workload.planner, variant.scenario or workload.scenario))
    known: dict[str, set[str]] = {}
    for planner, scenario in ways:
        for task, model in (workload.models_of(planner, scenario) or {}).items():
            known.setdefault(task, set(PLACE_KEYS)).update(model.model_fields)
    return known


def _unmapped(
    platform: Platform, document: Document, mapping: Mapping[str, Any], path: KeyPath
) -> list[Fault]:
    return [
        document.fault((*path, "mapping", task, "component"), *_no_component(mapped.component, platform))
        for task, mapped in mapping.items()
        if mapped.component not in platform.components
    ]


def _axis_against(
    platform: Platform,
    workload: Workload,
    axis: str,
    values: tuple[Any, ...],
    tasks: set[str],
    known: Mapping[str, set[str]],
) -> list[Fault]:
    """What is wrong with one axis where the platform and the problem stand.

    ``tasks``: those that a mapping places. ``known``: those that may be placed, with the keys of each.
    """
    document, place = workload.document, ("explore", "axes", axis)
    target = axis.partition(".")[0]
    if axis == VARIANT_AXIS or moves(axis, SCENARIO):
        return []
    if moves(axis, PROBLEM):
        return _problem_axis_faults(workload, axis)
    on_platform = target in platform.components or target in platform.links
    if target in tasks or (target in known and not on_platform):
        return _task_axis_faults(platform, workload, axis, values, None if target in tasks else known[target])
    if on_platform:
        axes = workload.explore.axes if workload.explore else {}
        alone = not any(other != axis and other.startswith(f"{target}.") for other in axes)
        return _platform_axis_faults(platform, document, axis, alone)
    what, hint = f"an axis moves no {clip(axis)!r}", choose_hint(axis, (VARIANT_AXIS, PROBLEM, SCENARIO))
    if target != "workload":
        words = {*tasks, *known, *platform.components, *platform.links, VARIANT_AXIS, PROBLEM, SCENARIO}
        what = f"there is no task, component or link {clip(target)!r}"
        hint = choose_hint(clip(target, 60), words)
    return [document.fault(place, what, hint, at_key=True)]


def _task_axis_faults(
    platform: Platform, workload: Workload, axis: str, values: tuple[Any, ...], keys: set[str] | None
) -> list[Fault]:
    """What is wrong with an axis that moves a task; ``keys``: what it may move of one that no mapping places."""
    document, place = workload.document, ("explore", "axes", axis)
    task, key = axis.split(".", 1)
    head = key.partition(".")[0]
    if keys is not None and head not in keys:
        what = f"task {task} has no parameter {clip(head)!r}"
        return [document.fault(place, what, choose_hint(clip(head, 60), keys), at_key=True)]
    if keys is not None and workload.explore and f"{task}.component" not in workload.explore.axes:
        return [document.fault(place, *unplaced(task), at_key=True)]
    return [
        document.fault((*place, index), *_no_component(value, platform))
        for index, value in enumerate(values)
        if key == "component" and value not in platform.components
    ]


def _no_component(name: str, platform: Platform) -> tuple[str, str]:
    what = f"platform {platform.name} has no component {clip(name)!r}"
    return what, choose_hint(clip(name, 60), platform.components)


def _problem_axis_faults(workload: Workload, axis: str) -> list[Fault]:
    document = workload.document
    keys = tuple(axis.split(".")[1:])
    faults: list[Fault] = []
    for index, value in enumerate(document.tree["explore"]["axes"][axis]):
        place = ("explore", "axes", axis, index)
        raw = substitute({"problem": document.tree["problem"]}, {keys: value})
        if raw is None:
            return [
                document.fault(place[:-1], "is not a mapping", "write it out in the problem", at_key=True)
            ]
        try:
            problem = type(workload.problem).model_validate(raw["problem"], context={"document": document})
            if isinstance(problem, ProblemSpec) and isinstance(problem.map, FileMap):
                # Points are kept by what the axes say, and a file may say something else the next time.
                hint = "generate the maps of this axis, or explore one workload for each file"
                faults.append(document.fault(place, "a map in a file cannot be moved by an axis", hint))
        except ValidationError as error:
            faults += placed_faults(error, document, raw["problem"], keys[1:], place, True)
    return faults


def _platform_axis_faults(platform: Platform, document: Document, axis: str, alone: bool) -> list[Fault]:
    """What is wrong with an axis that moves a component or a link."""
    name, *rest = axis.split(".")
    keys = tuple(rest)
    place: KeyPath = ("explore", "axes", axis)
    is_link = name in platform.links
    raw = platform.document.tree["links" if is_link else "components"][name]
    model: type[SpecModel] = (
        LINKS[platform.links[name].type] if is_link else COMPONENTS[platform.components[name].type]
    )
    fields = [field for field in model.model_fields if field not in PLACED_FIELDS]
    if keys[0] not in fields:
        what = f"{'link' if is_link else 'component'} {name} has no {clip(keys[0])!r}"
        if keys[0] in model.model_fields:
            what = f"{keys[0]} of {name} is no axis: it stands in the platform"
        return [document.fault(place, what, choose_hint(clip(keys[0], 60), fields), at_key=True)]
    faults: list[Fault] = []
    made: list[BaseModel] = []
    for index, value in enumerate(document.tree["explore"]["axes"][axis]):
        tried = substitute(raw, {keys: value}, create=True)
        if tried is None:
            return [document.fault(place, f"{keys[0]} is not a mapping", "write it out there", at_key=True)]
        try:
            moved = model.model_validate(tried, context={"document": platform.document})
        except ValidationError as error:
            faults += placed_faults(error, document, tried, keys, (*place, index), alone)
        else:
            faults += repeated(document, (*place, index), value, moved, made)
    return faults
