"""What is wrong with the axes of a workload, as far as it can be told on loading; the rest: ``pairing``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from codesign.errors import Fault, choose_hint, clip, show
from codesign.inputs.design_point import SCENARIO, alternatives, moves, substitute
from codesign.inputs.exploration import MAX_AXES, MAX_POINTS, MAX_VALUES
from codesign.inputs.faults import translate
from codesign.inputs.tasks import SCENARIO_TASKS, PlacedTask
from codesign.inputs.variants import BASE, VARIANT_AXIS, merged, no_variant, parts_present, sound_scenario
from codesign.inputs.workload import PLACE_KEYS, RawParameters, map_task
from codesign.inputs.yaml_tree import Document, KeyPath
from codesign.models import TaskParameters

Models = Mapping[str, type[TaskParameters]]


@dataclass(frozen=True)
class _Form:
    """What the axes move in one of the variants explored, raw: ``name`` is empty where there is no such axis."""

    name: str
    planner: str
    mapping: dict[str, Any]
    models: Models
    scenario: dict[str, Any]
    own_scenario: dict[str, Any]

    def knows(self, task: str, key: str) -> bool:
        """Whether the mapping places a task, or may: one at its default place is moved by what it takes."""
        if task in self.mapping:
            return isinstance(self.mapping[task], dict)
        return task in self.models and key in (*PLACE_KEYS, *self.models[task].model_fields)

    def told(self, what: str) -> str:
        return f"{what} in variant {self.name}" if self.name else what


def axis_faults(document: Document, context: Mapping[str, Any]) -> list[Fault]:
    """What is wrong with the axes of a workload that move its tasks, its scenario, or choose among its variants.

    Each value is tried in its place, in each of the variants explored. A value that only clashes with another key is
    left to the design points if another axis moves the same task.
    """
    tree = document.tree if isinstance(document.tree, dict) else {}
    explore = tree.get("explore")
    axes = explore.get("axes") if isinstance(explore, dict) else None
    if not isinstance(axes, dict) or len(axes) > MAX_AXES:
        return []
    axes = {axis: values for axis, values in axes.items() if _readable(axis, values)}
    faults = _variant_axis_faults(document, tree, axes)
    forms = list(_forms(tree, axes, context))
    if math.prod(len(values) for values in axes.values()) > MAX_POINTS:
        # Too many points, which is told elsewhere: then not each value in each variant too.
        forms = forms[:1]
    for axis in axes:
        if axis == VARIANT_AXIS:
            continue
        if moves(axis, SCENARIO):
            found = _shared(document, axis, axes) or [
                fault for form in forms for fault in _scenario_axis_faults(document, axis, axes, form)
            ]
        else:
            found = _task_faults(document, axis, axes, forms)
        faults += dict.fromkeys(found)
    return faults


def _readable(axis: Any, values: Any) -> bool:
    return isinstance(axis, str) and "." in axis and isinstance(values, list) and len(values) <= MAX_VALUES


def _variant_axis_faults(document: Document, tree: dict[str, Any], axes: dict[str, Any]) -> list[Fault]:
    if VARIANT_AXIS not in axes:
        return []
    place: KeyPath = ("explore", "axes", VARIANT_AXIS)
    variants = tree.get("variants")
    if not isinstance(variants, dict) or not variants:
        hint = "add variants: {NAME: {planner: ..., mapping: {...}}}"
        return [document.fault(place, "the workload has no variants", hint, at_key=True)]
    return [
        document.fault((*place, index), *no_variant(name, variants))
        for index, name in enumerate(axes[VARIANT_AXIS])
        if name != BASE and (not isinstance(name, str) or name not in variants)
    ]


def _forms(tree: dict[str, Any], axes: dict[str, Any], context: Mapping[str, Any]) -> Iterator[_Form]:
    """The workload itself; or where an axis chooses among its variants, each of those, as far as they are sound."""
    variants = tree.get("variants")
    names = axes.get(VARIANT_AXIS, [""])
    for name in names:
        own: Any = {}
        if name not in ("", BASE):
            own = variants.get(name) if isinstance(variants, dict) and isinstance(name, str) else None
        if not isinstance(own, dict):
            continue
        planner, mapping = own.get("planner", tree.get("planner")), own.get("mapping", tree.get("mapping"))
        changes = own.get("scenario", {})
        if not isinstance(planner, str) or not isinstance(mapping, dict) or not isinstance(changes, dict):
            continue
        scenario = merged(tree.get("scenario"), changes)
        models = (context.get("tasks") or {}).get(planner, {})
        yield _Form(name, planner, mapping, {**_placed_tasks(tree, scenario), **models}, scenario, changes)


def _placed_tasks(tree: dict[str, Any], scenario: dict[str, Any]) -> Models:
    kind, extra = scenario.get("type"), tree.get("tasks")
    names = SCENARIO_TASKS.get(kind, ()) if isinstance(kind, str) else ()
    more = [task.get("name") for task in extra if isinstance(task, dict)] if isinstance(extra, list) else []
    return dict.fromkeys((*names, *(name for name in more if isinstance(name, str))), PlacedTask)


def _shared(
    document: Document, axis: str, axes: Mapping[str, Any], model: type[TaskParameters] = RawParameters
) -> list[Fault]:
    """A fault where an axis before this one sets the same thing."""
    for other in axes:
        if other == axis:
            return []
        if _collide(other, axis, model):
            what = f"sets the same thing as axis {other}"
            return [document.fault(("explore", "axes", axis), what, "keep one of them", at_key=True)]
    return []


def _collide(first: str, second: str, model: type[TaskParameters]) -> bool:
    """Whether two axes move the same key, one a key inside the other's, or alternatives of each other."""
    task, *keys = first.split(".")
    other_task, *other_keys = second.split(".")
    if task != other_task or not keys or not other_keys:
        return False
    shared = min(len(keys), len(other_keys))
    replaced = alternatives(model).get(keys[0], ())
    return keys[:shared] == other_keys[:shared] or other_keys[0] in replaced


def _task_faults(document: Document, axis: str, axes: dict[str, Any], forms: list[_Form]) -> list[Fault]:
    """What is wrong with an axis that moves a task; nothing where it moves none."""
    task, *keys = axis.split(".")
    place: KeyPath = ("explore", "axes", axis)
    having = [form for form in forms if form.knows(task, keys[0])]
    if not having:
        return []
    for form in having:
        found = _shared(document, axis, axes, form.models.get(task, RawParameters))
        if found:
            return found
    faults = []
    for form in forms:
        model = form.models.get(task, RawParameters)
        if form not in having:
            what = f"variant {form.name} maps no task {task}"
            hint = (
                f"explore {task} in a workload without that variant, or set it in the variants that have it"
            )
            faults.append(document.fault(place, what, hint, at_key=True))
        elif model is not RawParameters and keys[0] not in (*PLACE_KEYS, *model.model_fields):
            hint = choose_hint(clip(keys[0], 60), (*PLACE_KEYS, *model.model_fields))
            what = form.told(f"task {task} has no parameter {clip(keys[0])!r}")
            faults.append(document.fault(place, what, hint, at_key=True))
        else:
            alone = not any(other != axis and other.startswith(f"{task}.") for other in axes)
            faults += _task_axis_faults(document, axis, form, model, alone)
    return faults


def _task_axis_faults(
    document: Document, axis: str, form: _Form, model: type[TaskParameters], alone: bool
) -> list[Fault]:
    task, *rest = axis.split(".")
    keys, raw = tuple(rest), form.mapping.get(task, {})
    base_is_sound = _sound(raw, model, document)
    faults: list[Fault] = []
    for index, value in enumerate(document.tree["explore"]["axes"][axis]):
        place: KeyPath = ("explore", "axes", axis, index)
        tried = substitute(raw, {keys: value}, model)
        if tried is None and not base_is_sound:
            return []
        if tried is None:
            what = form.told(f"{'.'.join(keys[:-1])} is not a mapping in the mapping of the task")
            return [document.fault(place[:-1], what, "write it out there as a mapping first", at_key=True)]
        try:
            map_task(tried, model, document)
        except ValidationError as error:
            faults += placed_faults(error, document, tried, keys, place, base_is_sound and alone)
    return faults


def _sound(raw: Any, model: type[TaskParameters], document: Document) -> bool:
    try:
        map_task(raw, model, document)
    except ValidationError:
        return False
    return True


def placed_faults(
    error: ValidationError, document: Document, tree: Any, keys: KeyPath, place: KeyPath, with_clashes: bool
) -> list[Fault]:
    """Faults of a substituted value, at the value; those of other keys only ``with_clashes``."""

    def to_document(path: KeyPath) -> KeyPath | None:
        if path[: len(keys)] == keys:
            return (*place, *path[len(keys) :])
        return place if with_clashes else None

    return translate(error, document, tree, to_document)


def _scenario_axis_faults(document: Document, axis: str, axes: dict[str, Any], form: _Form) -> list[Fault]:
    """What is wrong with an axis that moves the scenario, or a key inside, in one of the variants explored."""
    keys = tuple(axis.split(".")[2:])
    place: KeyPath = ("explore", "axes", axis)
    if form.own_scenario and parts_present(form.own_scenario, keys) == keys:
        what = f"variant {form.name} sets {'.'.join(axis.split('.')[1:])} itself"
        return [document.fault(place, what, "leave it to one of the two", at_key=True)]
    try:
        sound_scenario(form.scenario, document)
    except ValidationError:
        return []
    alone = not any(other != axis and moves(other, SCENARIO) for other in axes)
    faults: list[Fault] = []
    made: list[Any] = []
    for index, value in enumerate(axes[axis]):
        tried = substitute({"scenario": form.scenario}, {("scenario", *keys): value}, create=True)
        if tried is None:
            what = f"{'.'.join(axis.split('.')[1:-1])} is not a mapping"
            return [document.fault(place, what, "set the whole of it", at_key=True)]
        try:
            scenario = sound_scenario(tried["scenario"], document)
        except ValidationError as error:
            unknown = _unknown_key(error, keys)
            if unknown is not None:
                return [document.fault(place, form.told(unknown[0]), unknown[1], at_key=True)]
            faults += placed_faults(error, document, tried, ("scenario", *keys), (*place, index), alone)
        else:
            faults += repeated(document, (*place, index), value, scenario, made)
    return faults


def _unknown_key(error: ValidationError, keys: KeyPath) -> tuple[str, str] | None:
    """What is wrong where the axis names a key that there is none of, whatever its values; and the remedy."""
    for line in error.errors(include_url=False):
        key = line["loc"][1:]
        if line["type"] == "unknown_key" and key and keys[: len(key)] == key:
            what = f"{'.'.join(map(str, ('scenario', *key[:-1])))} has no {clip(str(key[-1]))!r}"
            return what, choose_hint(clip(str(key[-1]), 60), line["ctx"]["accepted"])
    return None


def repeated(document: Document, place: KeyPath, value: Any, model: Any, before: list[Any]) -> list[Fault]:
    """A fault where a value says the same as one before it: ways to write one value, such as 1 s and 1000 ms."""
    if model in before:
        return [
            document.fault(place, f"{show(value)} says the same as a value before it", "list each value once")
        ]
    before.append(model)
    return []
