"""Design points: values put in the place of what the files declare; checks of platform against workload."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from codesign.errors import Fault, SpecError, choose_hint
from codesign.spec.base import placed
from codesign.spec.exploration import MAX_AXES, MAX_VALUES
from codesign.spec.marks import Document, KeyPath
from codesign.spec.platform import COMPONENTS, Platform
from codesign.spec.scalars import clip
from codesign.spec.validate import translate
from codesign.spec.workload import RawParameters, TaskMapping, Workload, map_task

_MAPPING_KEYS = ("component", "style")
_CHOSEN = "chosen for this design point"


def axis_faults(document: Document, context: Mapping[str, Any]) -> list[Fault]:
    """What is wrong with the axes of a workload that move tasks, each value tried in its place.

    A value that only clashes with another key is left to the design points if another axis moves the task.
    """
    tree = document.tree if isinstance(document.tree, dict) else {}
    mapping, explore = tree.get("mapping"), tree.get("explore")
    axes = explore.get("axes") if isinstance(explore, dict) else None
    if not isinstance(mapping, dict) or not isinstance(axes, dict) or len(axes) > MAX_AXES:
        return []
    planner = tree.get("planner")
    models = (context.get("tasks") or {}).get(planner, {}) if isinstance(planner, str) else {}
    faults: list[Fault] = []
    for axis, values in axes.items():
        task, *keys = axis.split(".")
        raw, model = mapping.get(task), models.get(task, RawParameters)
        if not keys or not isinstance(raw, dict) or not isinstance(values, list) or len(values) > MAX_VALUES:
            continue
        rival = next((other for other in axes if other != axis and _collide(other, axis, model)), None)
        if rival is not None and list(axes).index(rival) < list(axes).index(axis):
            what = f"sets the same thing as axis {rival}"
            faults.append(document.fault(("explore", "axes", axis), what, "keep one of them", at_key=True))
        elif model is not RawParameters and keys[0] not in (*_MAPPING_KEYS, *model.model_fields):
            hint = choose_hint(clip(keys[0], 60), (*_MAPPING_KEYS, *model.model_fields))
            what = f"task {task} has no parameter {clip(keys[0])!r}"
            faults.append(document.fault(("explore", "axes", axis), what, hint, at_key=True))
        else:
            alone = not any(other != axis and other.startswith(f"{task}.") for other in axes)
            faults += _task_axis_faults(document, axis, raw, model, alone)
    return faults


def _collide(first: str, second: str, model: type[BaseModel]) -> bool:
    """Whether two axes move the same key, one a key inside the other's, or alternatives of each other."""
    task, *keys = first.split(".")
    other_task, *other_keys = second.split(".")
    if task != other_task or not keys or not other_keys:
        return False
    shared = min(len(keys), len(other_keys))
    replaced = _alternatives(model).get(keys[0], ())
    return keys[:shared] == other_keys[:shared] or other_keys[0] in replaced


def _alternatives(model: type[BaseModel]) -> Mapping[str, tuple[str, ...]]:
    found: Mapping[str, tuple[str, ...]] = getattr(model, "alternatives", {})
    return found


def _task_axis_faults(
    document: Document, axis: str, raw: dict[str, Any], model: type[BaseModel], alone: bool
) -> list[Fault]:
    keys = tuple(axis.split(".")[1:])
    base_is_sound = _sound(raw, model, document)
    faults: list[Fault] = []
    for index, value in enumerate(document.tree["explore"]["axes"][axis]):
        place = ("explore", "axes", axis, index)
        tried = substitute(raw, {keys: value}, model)
        if tried is None and not base_is_sound:
            return []
        if tried is None:
            what = f"{'.'.join(keys[:-1])} is not a mapping in the mapping of the task"
            return [document.fault(place[:-1], what, "write it out there as a mapping first", at_key=True)]
        try:
            map_task(tried, model, document)
        except ValidationError as error:
            faults += _placed_faults(error, document, tried, keys, place, base_is_sound and alone)
    return faults


def _sound(raw: Any, model: type[BaseModel], document: Document) -> bool:
    try:
        map_task(raw, model, document)
    except ValidationError:
        return False
    return True


def _placed_faults(
    error: ValidationError, document: Document, tree: Any, keys: KeyPath, place: KeyPath, with_clashes: bool
) -> list[Fault]:
    """Faults of a substituted value, at the value; those of other keys only ``with_clashes``."""

    def to_document(path: KeyPath) -> KeyPath | None:
        if path[: len(keys)] == keys:
            return (*place, *path[len(keys) :])
        return place if with_clashes else None

    return translate(error, document, tree, to_document)


def substitute(
    raw: Mapping[str, Any], values: Mapping[KeyPath, Any], model: type[BaseModel] | None = None
) -> dict[str, Any] | None:
    """A copy of a raw mapping with values put at paths of keys; None where a path leads through no mapping.

    A key that goes in drives out those that ``model.alternatives`` says it stands for.
    """
    made = dict(raw)
    for keys, value in values.items():
        if len(keys) == 1:
            made[str(keys[0])] = value
        else:
            inner = made.get(str(keys[0]))
            changed = substitute(inner, {keys[1:]: value}) if isinstance(inner, dict) else None
            if changed is None:
                return None
            made[str(keys[0])] = changed
        for driven_out in _alternatives(model).get(str(keys[0]), ()) if model else ():
            made.pop(driven_out, None)
    return made


def cross_check(platform: Platform, workload: Workload) -> None:
    """Check that tasks are mapped to components of the platform, and the axes that move components.

    Raises:
        SpecError: every fault, at its place in the workload.
    """
    faults: list[Fault] = []
    document = workload.document
    for task, mapped in workload.mapping.items():
        if mapped.component not in platform.components:
            path = ("mapping", task, "component")
            faults.append(document.fault(path, *_no_component(mapped.component, platform)))
    axes = workload.explore.axes if workload.explore else {}
    for axis, values in axes.items():
        target, key = axis.split(".", 1)
        if target in workload.mapping:
            if key == "component":
                faults += [
                    document.fault(("explore", "axes", axis, index), *_no_component(value, platform))
                    for index, value in enumerate(values)
                    if value not in platform.components
                ]
        elif target in platform.components:
            alone = not any(other != axis and other.startswith(f"{target}.") for other in axes)
            faults += _component_axis_faults(platform, document, axis, alone)
        else:
            hint = choose_hint(clip(target, 60), (*workload.mapping, *platform.components))
            what = f"there is no task or component {clip(target)!r}"
            faults.append(document.fault(("explore", "axes", axis), what, hint, at_key=True))
    if faults:
        raise SpecError(faults)


def _no_component(name: str, platform: Platform) -> tuple[str, str]:
    what = f"platform {platform.name} has no component {clip(name)!r}"
    return what, choose_hint(clip(name, 60), platform.components)


def _component_axis_faults(platform: Platform, document: Document, axis: str, alone: bool) -> list[Fault]:
    name, *rest = axis.split(".")
    keys = tuple(rest)
    raw = platform.document.tree["components"][name]
    model = COMPONENTS[platform.components[name].type]
    fields = [field for field in model.model_fields if field != "type"]
    if keys[0] not in fields:
        what = f"component {name} has no {clip(keys[0])!r}"
        hint = choose_hint(clip(keys[0], 60), fields)
        return [document.fault(("explore", "axes", axis), what, hint, at_key=True)]
    faults: list[Fault] = []
    for index, value in enumerate(document.tree["explore"]["axes"][axis]):
        place = ("explore", "axes", axis, index)
        tried = substitute(raw, {keys: value})
        if tried is None:
            return [
                document.fault(place[:-1], f"{keys[0]} is not a mapping", "write it out there", at_key=True)
            ]
        try:
            model.model_validate(tried, context={"document": platform.document})
        except ValidationError as error:
            faults += _placed_faults(error, document, tried, keys, place, alone)
    return faults


def override(platform: Platform, workload: Workload, values: Mapping[str, Any]) -> tuple[Platform, Workload]:
    """One design point: platform and workload with a raw value put in the place of each axis.

    Nothing is read again but a part that was not read before.

    Args:
        platform: and ``workload``: loaded specs.
        values: by axis, ``TASK.PARAMETER`` or ``COMPONENT.FIELD``, as YAML would give them.

    Raises:
        SpecError: an axis that is none, or a value that is not accepted, alone or together with the others.
    """
    faults: list[Fault] = []
    by_target: dict[str, dict[KeyPath, Any]] = {}
    for axis, value in values.items():
        target, *keys = axis.split(".")
        if not keys or (target not in workload.mapping and target not in platform.components):
            hint = choose_hint(clip(target, 60), (*workload.mapping, *platform.components))
            what = "no axis: write TASK.PARAMETER or COMPONENT.FIELD"
            faults.append(Fault(workload.document.file, 0, 0, clip(axis), what, hint))
        else:
            by_target.setdefault(target, {})[tuple(keys)] = value
    tasks: dict[str, TaskMapping] = {}
    components: dict[str, BaseModel] = {}
    raw_tasks, raw_components = _raw(workload, "mapping"), _raw(platform, "components")
    for target, given in by_target.items():
        try:
            if target in workload.mapping:
                model = (workload.task_models or {}).get(target, RawParameters)
                raw_tasks[target] = _substituted(raw_tasks[target], given, model)
                tasks[target] = map_task(raw_tasks[target], model, workload.document)
            else:
                kind = COMPONENTS[platform.components[target].type]
                raw_components[target] = _substituted(raw_components[target], given)
                made = kind.model_validate(raw_components[target], context={"document": platform.document})
                components[target] = placed(made, lambda _path: _CHOSEN)
        except ValidationError as error:
            tree = (raw_tasks if target in workload.mapping else raw_components)[target]
            faults += _point_faults(error, workload, target, given, tree)
        except KeyError as missing:
            what = f"{missing.args[0]} is not a mapping"
            faults.append(Fault(workload.document.file, 0, 0, target, what, "set the whole of it"))
    if faults:
        raise SpecError(faults)
    return (
        _changed(platform, "components", platform.components | components, raw_components)
        if components
        else platform,
        _changed(workload, "mapping", workload.mapping | tasks, raw_tasks) if tasks else workload,
    )


def _raw(spec: Platform | Workload, key: str) -> dict[str, Any]:
    return dict(spec.document.tree[key])


def _substituted(
    raw: Mapping[str, Any], values: Mapping[KeyPath, Any], model: type[BaseModel] | None = None
) -> dict[str, Any]:
    made = substitute(raw, values, model)
    if made is None:
        raise KeyError(", ".join(".".join(map(str, keys[:-1])) for keys in values if len(keys) > 1))
    return made


def _changed(spec: Any, field: str, value: Any, raw: dict[str, Any]) -> Any:
    made = spec.model_copy(update={field: value})
    made._document = dataclasses.replace(spec.document, tree={**spec.document.tree, field: raw})
    return made


def _point_faults(
    error: ValidationError, workload: Workload, target: str, given: Iterable[KeyPath], tree: Any
) -> list[Fault]:
    """Faults of a design point, each under the axis that brought the value in, where one did."""
    document = Document(workload.document.file, workload.document.folder, tree)
    axes = {keys: ".".join((target, *map(str, keys))) for keys in given}

    def to_axis(path: KeyPath) -> KeyPath:
        for keys, axis in axes.items():
            if path[: len(keys)] == keys:
                return (axis, *path[len(keys) :])
        return (target, *path)

    return translate(error, document, tree, to_axis)
