"""Design points: values put in the place of what the files declare."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from codesign.errors import Fault, SpecError, choose_hint, clip
from codesign.inputs.base import Spec, declared_in, placed
from codesign.inputs.components import COMPONENTS
from codesign.inputs.faults import translate
from codesign.inputs.links import LINKS
from codesign.inputs.platform import Platform
from codesign.inputs.scenario import Scenario
from codesign.inputs.variants import NO_SCENARIO, VARIANT_AXIS, choose_variant, sound_scenario
from codesign.inputs.workload import PLACE_KEYS, RawParameters, Workload, map_task, stray_task
from codesign.inputs.yaml_tree import Document, KeyPath, dotted
from codesign.models import SpecModel, TaskParameters

S = TypeVar("S", bound=Spec)

PROBLEM, SCENARIO = "workload.problem", "workload.scenario"
"""Axes that move the problem or the scenario of the workload: the whole of it, or a key inside."""

PLACED_FIELDS = frozenset({"type", "between", "beside"})
"""Fields of components and links that no axis moves: what they are and what they join is the platform itself."""

_CHOSEN = "chosen for this design point"
_NO_AXIS = "no axis: write TASK.PARAMETER, COMPONENT.FIELD or LINK.FIELD"


def moves(axis: str, section: str) -> bool:
    """Whether an axis moves a section of the workload, the whole or a key inside: ``workload.problem.map.seed``."""
    return axis == section or axis.startswith(f"{section}.")


def unplaced(task: str) -> tuple[str, str]:
    """What is wrong with an axis that moves a task that nothing places, and the remedy."""
    return f"the mapping does not place task {task}", f"set {task}.component too"


def alternatives(model: type[BaseModel]) -> Mapping[str, tuple[str, ...]]:
    """Of each parameter, those that it stands for in another way."""
    return model.alternatives if issubclass(model, TaskParameters) else {}


def substitute(
    raw: Mapping[str, Any],
    values: Mapping[KeyPath, Any],
    model: type[BaseModel] | None = None,
    *,
    create: bool = False,
) -> dict[str, Any] | None:
    """A copy of a raw mapping with values put at paths of keys; None where a path leads through no mapping.

    A key that goes in drives out those that ``model.alternatives`` says it stands for. ``create``: a mapping on the
    way that is not written out begins empty.
    """
    made = dict(raw)
    for keys, value in values.items():
        if len(keys) == 1:
            made[str(keys[0])] = value
        else:
            inner = made.get(str(keys[0]))
            inner = {} if inner is None and create else inner
            changed = substitute(inner, {keys[1:]: value}, create=create) if isinstance(inner, dict) else None
            if changed is None:
                return None
            made[str(keys[0])] = changed
        for driven_out in alternatives(model).get(str(keys[0]), ()) if model else ():
            made.pop(driven_out, None)
    return made


def _with_scenario(workload: Workload, values: Mapping[str, Any], where: str) -> Workload:
    """The workload with the values of the axes that move its scenario."""

    def made(raw: Any) -> Scenario:
        scenario = sound_scenario(raw, workload.document)
        stray = stray_task(workload.mapping, scenario, workload.scenario)
        if stray is not None:
            hint = "move the scenario in a variant with a mapping of its own"
            raise SpecError([Fault(f"{where}{', '.join(values)}", 0, 0, "", stray, hint)])
        return scenario

    raw = workload.document.tree.get("scenario") or NO_SCENARIO
    return _with_section(workload, "scenario", raw, made, values, where)


def _with_problem(workload: Workload, values: Mapping[str, Any], where: str) -> Workload:
    """The workload with the values of the axes that move its problem."""
    document = workload.document

    def made(raw: Any) -> Any:
        return type(workload.problem).model_validate(raw, context={"document": document})

    return _with_section(workload, "problem", document.tree["problem"], made, values, where)


def _with_section(
    workload: Workload,
    section: str,
    raw: Any,
    make: Callable[[Any], Any],
    values: Mapping[str, Any],
    where: str,
) -> Workload:
    """The workload with a section of it made anew, from its raw form with the values of axes put in."""
    document = workload.document
    given: dict[KeyPath, Any] = {tuple(axis.split(".")[1:]): value for axis, value in values.items()}
    moved: dict[KeyPath, str] = {tuple(axis.split(".")[1:]): f"{where}{axis}" for axis in values}
    tree = substitute({section: raw}, given, create=section == "scenario")
    if tree is None:
        place = f"{where}{', '.join(values)}"
        raise SpecError([Fault(place, 0, 0, "", "is not inside a mapping", "set the whole of it")])
    try:
        made = make(tree[section])
    except ValidationError as error:
        point = Document(f"{where}{', '.join(values)}", document.folder, tree, moved=moved)
        if section == "scenario":
            raise SpecError(translate(error, point)) from None
        raise SpecError(translate(error, point, tree[section], lambda path: (section, *path))) from None
    changed = workload.model_copy(update={section: made})
    changed._document = dataclasses.replace(
        document, tree={**document.tree, **tree}, moved={**document.moved, **moved}
    )
    return changed


def override(
    platform: Platform, workload: Workload, values: Mapping[str, Any], where: str = "point: "
) -> tuple[Platform, Workload]:
    """One design point: platform and workload with a raw value put in the place of each axis.

    The workload of a point has no ``explore``. Nothing is read again but a part that was not read before.

    Args:
        platform: and ``workload``: loaded specs.
        values: by axis, ``TASK.PARAMETER``, ``COMPONENT.FIELD``, ``LINK.FIELD``, ``workload.variant``, or a key of
            ``workload.problem`` or ``workload.scenario``, as YAML would give them. The variant comes first.
        where: what stands before the axis where a fault of its value is told, now or later: the files hold no such
            value.

    Raises:
        SpecError: an axis that is none, or a value that is not accepted, alone or together with the others.
    """
    values = dict(values)
    if VARIANT_AXIS in values:
        workload = choose_variant(workload, values.pop(VARIANT_AXIS), where)
    for begin, put_in in ((SCENARIO, _with_scenario), (PROBLEM, _with_problem)):
        inside = {axis: values.pop(axis) for axis in list(values) if moves(axis, begin)}
        workload = put_in(workload, inside, where) if inside else workload
    faults: list[Fault] = []
    entries: dict[str, dict[str, tuple[dict[str, Any], Any]]] = {"mapping": {}, "components": {}, "links": {}}
    moved: dict[KeyPath, str] = {}
    for target, given in _by_target(values).items():
        section = _section_of(platform, workload, target)
        wrong = _refused_axis(platform, workload, section, target, given, where)
        if section is None or wrong is not None:
            faults += [wrong] if wrong is not None else []
            continue
        is_task = section == "mapping"
        model = (workload.task_models or {}).get(target, RawParameters) if is_task else RawParameters
        # A task that the mapping leaves at its default place begins empty.
        declared = _raw(workload if is_task else platform, section).get(target, {})
        raw = substitute(declared, given, model if is_task else None, create=not is_task)
        if raw is None:
            axis = dotted((target, *max(given, key=len)))
            what, hint = f"{axis.rpartition('.')[0]} is not a mapping", "set the whole of it"
            faults.append(Fault(f"{where}{axis}", 0, 0, "", what, hint))
            continue
        moved |= _sources(where, target, given, model)
        try:
            made: Any = (
                map_task(raw, model, workload.document)
                if is_task
                else _moved_entry(platform, section, target, raw, given)
            )
            entries[section][target] = raw, made
        except ValidationError as error:
            faults += _point_faults(error, where, target, given, raw, moved)
    if faults:
        raise SpecError(faults)
    point = _with(workload.model_copy(update={"explore": None}), "mapping", entries["mapping"], moved)
    platform = _with(platform, "components", entries["components"], moved)
    return _with(platform, "links", entries["links"], moved), point


def pin(
    platform: Platform, workload: Workload, values: Mapping[str, Any], where: str = "point: "
) -> tuple[Platform, Workload]:
    """The specs with values put in, and their exploration kept without the axes that these values settle.

    Where variants are explored, a value in mapping or scenario stays as an axis of one value: each variant brings its
    own, and what is settled holds in all of them.

    Raises:
        SpecError: as ``override``, of any variant explored too.
    """
    moved, point = override(platform, workload, values, where)
    section = workload.explore
    if section is not None:
        variants = () if VARIANT_AXIS in values else section.axes.get(VARIANT_AXIS, ())
        for name in variants:
            override(platform, workload, {VARIANT_AXIS: name, **values}, f"variant {name}: {where}")
        held = {
            axis: (value,)
            for axis, value in values.items()
            if variants
            and (
                moves(axis, SCENARIO) or _section_of(platform, workload, axis.partition(".")[0]) == "mapping"
            )
        }
        axes = {axis: listed for axis, listed in section.axes.items() if axis not in values}
        # Those settled come first: an axis may move a key inside of one of them.
        section = section.model_copy(update={"axes": held | axes})
    return moved, point.model_copy(update={"explore": section})


def has_axis(platform: Platform, workload: Workload, axis: str) -> bool:
    """Whether an axis names what platform or workload have: planners share names of tasks, not those of parameters."""
    if axis == VARIANT_AXIS:
        return bool(workload.variants)
    if moves(axis, PROBLEM) or moves(axis, SCENARIO):
        spec = workload.problem if moves(axis, PROBLEM) else workload.scenario
        keys = axis.split(".")[2:]
        return not keys or keys[0] in type(spec).model_fields
    target, _, keys_ = axis.partition(".")
    return keys_.partition(".")[0] in _keys_of(platform, workload, target)


def _section_of(platform: Platform, workload: Workload, target: str) -> str | None:
    """The section in which the first word of an axis stands."""
    if target in workload.mapping:
        return "mapping"
    if target in platform.components:
        return "components"
    if target in platform.links:
        return "links"
    return "mapping" if target in (workload.task_models or {}) else None


def _keys_of(platform: Platform, workload: Workload, target: str) -> tuple[str, ...]:
    """What an axis may move of a task, component or link; nothing of what is none."""
    section = _section_of(platform, workload, target)
    if section is None:
        return ()
    if target in workload.mapping:
        return (*PLACE_KEYS, *type(workload.mapping[target].parameters).model_fields)
    if section == "mapping":
        return (*PLACE_KEYS, *(workload.task_models or {})[target].model_fields)
    entry = getattr(platform, section)[target]
    return tuple(key for key in type(entry).model_fields if key not in PLACED_FIELDS)


def _refused_axis(
    platform: Platform,
    workload: Workload,
    section: str | None,
    target: str,
    given: Mapping[KeyPath, Any],
    where: str,
) -> Fault | None:
    """What is wrong with the axes that move ``target``, whatever their values."""
    axis = dotted((target, *next(iter(given))))
    keys = _keys_of(platform, workload, target)
    if section is None:
        tasks = {*workload.mapping, *(workload.task_models or {})}
        known = {*tasks, *platform.components, *platform.links, "workload"}
        return Fault(f"{where}{axis}", 0, 0, "", _NO_AXIS, choose_hint(clip(target, 60), known))
    if () in given:
        own = [key for key in keys if key not in PLACE_KEYS] or keys
        names = ", ".join(f"{target}.{key}" for key in own)
        return Fault(f"{where}{axis}", 0, 0, "", _NO_AXIS, f"name what to set of {target}: {names}")
    if section == "mapping" and target not in workload.mapping and ("component",) not in given:
        return Fault(f"{where}{axis}", 0, 0, "", *unplaced(target))
    for path in given:
        if section != "mapping" and path[0] in PLACED_FIELDS:
            what = f"{path[0]} of {target} is no axis: it stands in the platform"
            names = ", ".join(f"{target}.{key}" for key in keys)
            return Fault(f"{where}{dotted((target, *path))}", 0, 0, "", what, f"accepted: {names}")
    return None


def _sources(where: str, target: str, given: Iterable[KeyPath], model: type[BaseModel]) -> dict[KeyPath, str]:
    """Where the values of a task or component come from that a design point brings, or drives out."""
    made: dict[KeyPath, str] = {}
    for keys in given:
        source = f"{where}{dotted((target, *keys))}"
        for driven_out in alternatives(model).get(str(keys[0]), ()):
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


def _moved_entry(
    platform: Platform, section: str, name: str, raw: dict[str, Any], given: Iterable[KeyPath]
) -> BaseModel:
    """A component or link from its raw mapping, ``given`` the keys in it that the design point brought."""
    document, moved = platform.document, set(given)

    def source(path: KeyPath) -> str:
        if any(path[: len(keys)] == keys for keys in moved):
            return _CHOSEN
        return declared_in(document, (section, name, *path))

    models: Mapping[str, type[SpecModel]] = LINKS if section == "links" else COMPONENTS
    model = models[getattr(platform, section)[name].type]
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
