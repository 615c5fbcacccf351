"""Design points: values put in the place of what the files declare; checks of platform against workload."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from codesign.errors import Fault, SpecError, choose_hint
from codesign.spec.base import Spec, declared_in, placed
from codesign.spec.components import COMPONENTS
from codesign.spec.exploration import MAX_AXES, MAX_VALUES
from codesign.spec.marks import Document, KeyPath, dotted
from codesign.spec.platform import Platform
from codesign.spec.problem import FileMap
from codesign.spec.scalars import clip, show
from codesign.spec.validate import translate
from codesign.spec.workload import PLACE_KEYS, RawParameters, TaskMapping, Workload, map_task

S = TypeVar("S", bound=Spec)

_PROBLEM = "workload.problem"
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
        elif model is not RawParameters and keys[0] not in (*PLACE_KEYS, *model.model_fields):
            hint = choose_hint(clip(keys[0], 60), (*PLACE_KEYS, *model.model_fields))
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
        elif _moves_problem(axis):
            faults += _problem_axis_faults(workload, axis)
        else:
            hint = choose_hint(clip(target, 60), (*workload.mapping, *platform.components, _PROBLEM))
            what = f"there is no task or component {clip(target)!r}"
            faults.append(document.fault(("explore", "axes", axis), what, hint, at_key=True))
    if faults:
        raise SpecError(faults)


def _no_component(name: str, platform: Platform) -> tuple[str, str]:
    what = f"platform {platform.name} has no component {clip(name)!r}"
    return what, choose_hint(clip(name, 60), platform.components)


def _moves_problem(axis: str) -> bool:
    """Whether an axis moves the workload's problem, the whole of it or a key inside: ``workload.problem.map.seed``."""
    return axis == _PROBLEM or axis.startswith(f"{_PROBLEM}.")


def _problem_axis_faults(workload: Workload, axis: str) -> list[Fault]:
    document = workload.document
    faults: list[Fault] = []
    for index, value in enumerate(document.tree["explore"]["axes"][axis]):
        place = ("explore", "axes", axis, index)
        raw = substitute({"problem": document.tree["problem"]}, {_problem_keys(axis): value})
        if raw is None:
            return [
                document.fault(place[:-1], "is not a mapping", "write it out in the problem", at_key=True)
            ]
        try:
            problem = type(workload.problem).model_validate(raw["problem"], context={"document": document})
            if isinstance(getattr(problem, "map", None), FileMap):
                # Points are kept by what the axes say, and a file may say something else the next time.
                hint = "generate the maps of this axis, or explore one workload for each file"
                faults.append(document.fault(place, "a map in a file cannot be moved by an axis", hint))
        except ValidationError as error:
            faults += _placed_faults(error, document, raw["problem"], _problem_keys(axis)[1:], place, True)
    return faults


def _problem_keys(axis: str) -> KeyPath:
    return tuple(axis.split(".")[1:])


def _with_problem(workload: Workload, values: Mapping[str, Any], where: str) -> Workload:
    """The workload with the values of the axes that move its problem."""
    if not values:
        return workload
    document = workload.document
    raw = substitute(
        {"problem": document.tree["problem"]}, {_problem_keys(axis): each for axis, each in values.items()}
    )
    axes = ", ".join(values)
    if raw is None:
        raise SpecError([Fault(f"{where}{axes}", 0, 0, "", "is not inside a mapping", "set the whole of it")])
    sources = {_problem_keys(axis): f"{where}{axis}" for axis in values}
    try:
        problem = type(workload.problem).model_validate(raw["problem"], context={"document": document})
    except ValidationError as error:
        point = Document(f"{where}{axes}", document.folder, raw["problem"])
        raise SpecError(translate(error, point, raw["problem"], lambda path: path)) from None
    made = workload.model_copy(update={"problem": problem})
    moved = {**document.moved, **sources}
    made._document = dataclasses.replace(document, tree={**document.tree, **raw}, moved=moved)
    return made


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
    made: list[BaseModel] = []
    for index, value in enumerate(document.tree["explore"]["axes"][axis]):
        place = ("explore", "axes", axis, index)
        tried = substitute(raw, {keys: value})
        if tried is None:
            return [
                document.fault(place[:-1], f"{keys[0]} is not a mapping", "write it out there", at_key=True)
            ]
        try:
            component = model.model_validate(tried, context={"document": platform.document})
        except ValidationError as error:
            faults += _placed_faults(error, document, tried, keys, place, alone)
        else:
            # Two ways to write one value, such as 100 MHz and 100000 kHz, are one point.
            if component in made:
                what = f"{show(value)} says the same as a value before it"
                faults.append(document.fault(place, what, "list each value once"))
            made.append(component)
    return faults


def override(
    platform: Platform, workload: Workload, values: Mapping[str, Any], where: str = "point: "
) -> tuple[Platform, Workload]:
    """One design point: platform and workload with a raw value put in the place of each axis.

    The workload of a point has no ``explore``. Nothing is read again but a part that was not read before.

    Args:
        platform: and ``workload``: loaded specs.
        values: by axis, ``TASK.PARAMETER``, ``COMPONENT.FIELD`` or ``workload.problem``, as YAML would give them.
        where: what stands before the axis where a fault of its value is told, now or later: the files hold no such
            value.

    Raises:
        SpecError: an axis that is none, or a value that is not accepted, alone or together with the others.
    """
    workload = _with_problem(
        workload, {axis: each for axis, each in values.items() if _moves_problem(axis)}, where
    )
    values = {axis: each for axis, each in values.items() if not _moves_problem(axis)}
    faults: list[Fault] = []
    tasks: dict[str, tuple[dict[str, Any], TaskMapping]] = {}
    components: dict[str, tuple[dict[str, Any], BaseModel]] = {}
    moved: dict[KeyPath, str] = {}
    for target, given in _by_target(values).items():
        is_task = target in workload.mapping
        if not (is_task or target in platform.components) or () in given:
            axis = dotted((target, *next(iter(given))))
            hint = choose_hint(clip(target, 60), (*workload.mapping, *platform.components))
            what = "no axis: write TASK.PARAMETER or COMPONENT.FIELD"
            if is_task or target in platform.components:
                keys = workload.mapping[target].parameters if is_task else platform.components[target]
                accepted = [key for key in type(keys).model_fields if key != "type"]
                hint = f"name what to set of {target}: {', '.join(f'{target}.{key}' for key in accepted)}"
            faults.append(Fault(f"{where}{axis}", 0, 0, "", what, hint))
            continue
        model = (workload.task_models or {}).get(target, RawParameters)
        declared = _raw(workload, "mapping") if is_task else _raw(platform, "components")
        raw = substitute(declared[target], given, model if is_task else None)
        if raw is None:
            axis = dotted((target, *max(given, key=len)))
            what, hint = f"{axis.rpartition('.')[0]} is not a mapping", "set the whole of it"
            faults.append(Fault(f"{where}{axis}", 0, 0, "", what, hint))
            continue
        moved |= _sources(where, target, given, model)
        try:
            if is_task:
                tasks[target] = raw, map_task(raw, model, workload.document)
            else:
                components[target] = raw, _moved_component(platform, target, raw, given)
        except ValidationError as error:
            faults += _point_faults(error, where, target, given, raw, moved)
    if faults:
        raise SpecError(faults)
    point = workload.model_copy(update={"explore": None})
    return _with(platform, "components", components, moved), _with(point, "mapping", tasks, moved)


def _sources(where: str, target: str, given: Iterable[KeyPath], model: type[BaseModel]) -> dict[KeyPath, str]:
    """Where the values of a task or component come from that a design point brings, or drives out."""
    made: dict[KeyPath, str] = {}
    for keys in given:
        source = f"{where}{dotted((target, *keys))}"
        for driven_out in _alternatives(model).get(str(keys[0]), ()):
            made[target, driven_out] = source
        made[target, *keys] = source
    return made


def _by_target(values: Mapping[str, Any]) -> dict[str, dict[KeyPath, Any]]:
    """Values by task or component, then by the path of the key inside it."""
    made: dict[str, dict[KeyPath, Any]] = {}
    for axis, value in values.items():
        target, *keys = axis.split(".")
        made.setdefault(target, {})[tuple(keys)] = value
    return made


def _raw(spec: Spec, section: str) -> dict[str, Any]:
    raw: dict[str, Any] = spec.document.tree[section]
    return raw


def _moved_component(
    platform: Platform, name: str, raw: dict[str, Any], given: Iterable[KeyPath]
) -> BaseModel:
    """A component from its raw mapping, ``given`` the keys in it that the design point brought."""
    document, moved = platform.document, set(given)

    def source(path: KeyPath) -> str:
        if any(path[: len(keys)] == keys for keys in moved):
            return _CHOSEN
        return declared_in(document, ("components", name, *path))

    model = COMPONENTS[platform.components[name].type]
    return placed(model.model_validate(raw, context={"document": document}), source)


def _with(
    spec: S, field: str, entries: Mapping[str, tuple[dict[str, Any], Any]], sources: Mapping[KeyPath, str]
) -> S:
    """The spec with some entries of a field replaced, in its raw tree too."""
    if not entries:
        return spec
    tree = spec.document.tree
    raw = {**tree[field], **{name: entry for name, (entry, _made) in entries.items()}}
    made = {**getattr(spec, field), **{name: entry for name, (_raw, entry) in entries.items()}}
    new = {(field, *path): source for path, source in sources.items() if path[0] in entries}
    # The last that moved a value is the first to be asked: it goes to the end.
    moved = {path: source for path, source in spec.document.moved.items() if path not in new} | new
    changed = spec.model_copy(update={field: made})
    changed._document = dataclasses.replace(spec.document, tree={**tree, field: raw}, moved=moved)
    return changed


def _point_faults(
    error: ValidationError,
    where: str,
    target: str,
    given: Iterable[KeyPath],
    raw: Any,
    sources: dict[KeyPath, str],
) -> list[Fault]:
    """Faults of a design point, each under the axis that brought the value in; a clash under all of them."""
    axes = ", ".join(dotted((target, *keys)) for keys in given)
    document = Document(f"{where}{axes}", Path(), raw, moved=sources)
    return translate(error, document, raw, lambda path: (target, *path))
