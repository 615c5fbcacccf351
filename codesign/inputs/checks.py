"""Workload files read and checked: the faults of their variants and axes, by themselves and together with a platform.

An axis is checked by the points with that one axis moved, in each of the variants explored for which it exists.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from codesign.ground.errors import Fault, InputError, SpecError, UnsuitedError, clip, show
from codesign.ground.models import TaskParameters
from codesign.inputs.axes import MAX_VALUES, in_circle, listed, refusals, with_listed_axes
from codesign.inputs.base import validated
from codesign.inputs.document import Document, KeyPath, Origin, put
from codesign.inputs.edit import (
    ENTRIES,
    PLATFORM_AXIS,
    PROBLEM,
    SCENARIO,
    VARIANT_AXIS,
    VARIED,
    Movable,
    choose_variant,
    entry_of,
    moves,
    no_variant,
    with_variant,
)
from codesign.inputs.exploration import MAX_AXES, MAX_POINTS, overlap
from codesign.inputs.faults import Keep, Teller, validate
from codesign.inputs.files import Source, find_spec, is_path, read_spec, shipped_names
from codesign.inputs.platform import Platform, load_platform, no_such
from codesign.inputs.roles import ROLES
from codesign.inputs.workload import BASE, MAX_VARIANTS, ProblemModels, TaskModels, Workload
from codesign.inputs.yaml_tree import MAX_FAULTS

# The axis ``platform`` of an exploration: names of shipped platforms, and files beside the workload.

_PLACE: KeyPath = ("explore", "axes", PLATFORM_AXIS)


def platform_axis_faults(document: Document, values: Sequence[Any]) -> list[Fault]:
    """Values of the axis that name no shipped platform and no file. The files themselves are not read."""
    faults = []
    for index, value in enumerate(values):
        refusal = _refusal(value, document.folder)
        if refusal is not None:
            faults.append(document.fault((*_PLACE, index), *refusal))
    return faults


def _refusal(value: Any, folder: Path) -> tuple[str, str | None] | None:
    try:
        path, _ = find_spec(value, "platforms")
    except InputError as wrong:
        return wrong.what, wrong.hint
    if (folder / path).is_file():
        return None
    return f"there is no file {show(value)}", "the path is relative to this workload file"


def platforms_of(workload: Workload) -> dict[str, Platform]:
    """The platforms that the workload's exploration chooses from, by value of the axis; empty without that axis.

    Raises:
        SpecError: every fault of the files, at its place; or a value that names no platform.
    """
    values = workload.explore.axes.get(PLATFORM_AXIS, ()) if workload.explore else ()
    faults = platform_axis_faults(workload.document, values)
    if faults:
        raise SpecError(faults)
    folder = workload.document.folder
    sources = [folder / value if is_path(value) else value for value in values]
    return dict(zip(values, load_platforms(sources), strict=True))


def load_platforms(sources: Iterable[Any]) -> list[Platform]:
    """Several platforms, by name or file.

    Raises:
        InputError: a value that names no platform. SpecError: every fault of every file.
    """
    platforms, faults = [], list[Fault]()
    for source in sources:
        find_spec(source, "platforms")
        try:
            platforms.append(load_platform(source))
        except SpecError as wrong:
            faults += wrong.faults
    if faults:
        raise SpecError(faults)
    return platforms


def conditions_of(document: Document, axis: str, axes: Mapping[str, Any]) -> dict[str, tuple[Any, ...]]:
    """The other axes that an axis depends on, with the values for which it exists, as far as they can be read."""
    explore = document.tree.get("explore")
    when = explore.get("when") if isinstance(explore, dict) else None
    if not isinstance(when, dict) or axis not in when:
        return {}
    if not all(isinstance(each, dict) for each in when.values()) or in_circle(axes, when):
        return {}
    chosen = {other: listed(raw, axes[other]) for other, raw in when[axis].items() if other in axes}
    return {other: values for other, values in chosen.items() if values}


def is_unsound(document: Document, axis: str, axes: Mapping[str, Any]) -> bool:
    """True if what an axis depends on is at fault: it may not exist where the axis does not fit."""
    explore = document.tree.get("explore")
    when = explore.get("when") if isinstance(explore, dict) else None
    if not isinstance(when, dict) or axis not in when:
        return False
    lists = {name: values if isinstance(values, list) else [] for name, values in axes.items()}
    mappings = isinstance(when[axis], dict) and all(isinstance(each, dict) for each in when.values())
    if not mappings or in_circle(axes, when):
        return True
    chosen = {other: listed(raw, lists.get(other, ())) for other, raw in when[axis].items()}
    return any(name == axis for name, _ in refusals(lists, {axis: chosen}))


def settings_of(document: Document, axis: str, axes: Mapping[str, Any]) -> dict[str, Any]:
    """The first values of other axes for which an axis exists, without platform and variant."""
    settings: dict[str, Any] = {}
    for other, values in conditions_of(document, axis, axes).items():
        settings |= settings_of(document, other, axes)
        if other not in (VARIANT_AXIS, PLATFORM_AXIS):
            settings[other] = values[0]
    return settings


def edits_of(movable: Movable, values: Mapping[str, Any]) -> dict[KeyPath, Any]:
    """The edits that put values in the places of axes, of those axes that move the same section as the last one."""
    *_, last = values
    section = movable.path(last)[0]
    edits: dict[KeyPath, Any] = {}
    for axis, value in values.items():
        edits |= movable.edits(axis, value) if movable.path(axis)[0] == section else {}
    return edits


MAX_WORK = 4_000_000
"""Values of a file, times the points that are made to check its axes; what is beyond is left to the points."""

_KEEP_ONE = "keep one of them"


@dataclass(frozen=True)
class _Form:
    """The document that points are made of: a platform; or a workload, as it is or with one of its variants put in.

    - ``name``: the variant's name; empty if it is no variant.
    - ``spec``: the spec of ``document``; None, with all ``faults`` of it, if it is not sound.
    """

    name: str
    document: Document
    spec: Workload | Platform | None
    faults: tuple[Fault, ...] = ()

    def validated(
        self, document: Document, tell: Teller, keep: Keep | None = None
    ) -> tuple[Workload | Platform | None, list[Fault]]:
        """The document, edited, as a model, or every fault of it."""
        if isinstance(self.spec, Platform):
            return validated(Platform, self.spec, document, {}, tell, keep)
        fixed: dict[str, Any] = {"explore": None, "variants": {}}
        return validated(Workload, self.spec, document, fixed, tell, keep)


@dataclass(frozen=True)
class _Trial:
    """One of the axes of a workload, moved alone: what is wrong is reported at its values in ``document``."""

    document: Document
    axes: Mapping[str, Any]
    axis: str
    values: list[Any]

    @property
    def place(self) -> KeyPath:
        """The path of the axis."""
        return _place(self.document, self.axis)

    def alone(self, movable: Movable) -> bool:
        """True if no other axis moves the same task, component, link or section."""
        own = entry_of(movable.path(self.axis))
        return not any(other != self.axis and entry_of(movable.path(other)) == own for other in self.axes)

    def at_axis(self, what: str, hint: str | None) -> Fault:
        """A fault of the axis, whatever its values."""
        return self.document.fault(self.place, what, hint, at_key=True)

    def point(self, document: Document, movable: Movable, index: int, value: Any) -> Document:
        """The document with a value put in its place."""
        origin = Origin((*self.place, index), self.document)
        values = settings_of(self.document, self.axis, self.axes) | {self.axis: value}
        return put(document, edits_of(movable, values), lambda _path: origin)

    def faults(self, form: _Form, movable: Movable) -> list[Fault]:
        """The faults of each value in its place; a clash with a key counts only if no other axis moves that key."""
        moved, seen, faults = movable.path(self.axis), list[str](), list[Fault]()
        alone = self.alone(movable) and (moved[0] != "mapping" or moved[1] in movable.mapping)

        def keep(path: KeyPath, unknown: bool) -> bool:
            inside = path[: len(moved)] == moved
            return inside or (unknown and path == moved[: len(path)]) or alone

        for index, value in enumerate(self.values):
            place = (*self.place, index)
            point = self.point(form.document, movable, index, value)
            blocked = point.faults[len(form.document.faults) :]
            if blocked:
                return [] if form.spec is None else [self.at_axis(_marked(blocked[0].what, form), blocked[0].hint)]
            spec, wrong = form.validated(point, self._teller(form, point, moved, place), keep)
            faults += wrong
            if spec is None:
                continue
            entry = getattr(spec, str(moved[0]))
            text = repr(entry[moved[1]] if moved[0] in ENTRIES else entry)
            if text in seen and value not in self.values[:index]:
                what = f"{show(value)} says the same as a value before it"
                faults.append(self.document.fault(place, what, "list each value once"))
            seen.append(text)
        return faults

    def _teller(self, form: _Form, point: Document, moved: KeyPath, place: KeyPath) -> Teller:
        def tell(path: KeyPath, what: str, hint: str | None = None, *, at_key: bool = False) -> Fault | None:
            fault = point.fault(path, what, hint, at_key=at_key)
            if fault in form.faults:
                return None
            if at_key and path == moved[: len(path)]:
                return self.at_axis(_marked(what, form), hint)
            return fault if path[: len(moved)] == moved else self.document.fault(place, what, hint)

        return tell


def _place(document: Document, axis: str) -> KeyPath:
    """The path of an axis: among the decisions, or among the conditions."""
    explore = document.tree.get("explore") or {}
    return ("explore", "axes" if axis in (explore.get("axes") or {}) else "conditions", axis)


def _listed(explore: Any, section: str) -> dict[str, Any]:
    """The decisions (``axes``) or the ``conditions`` of a raw section ``explore``, as far as they can be read."""
    axes = explore.get(section) if isinstance(explore, dict) else None
    axes = axes if isinstance(axes, dict) and len(axes) <= MAX_AXES else {}
    return {
        axis: values
        for axis, values in axes.items()
        if isinstance(axis, str) and ("." in axis or axis == PLATFORM_AXIS)
        if isinstance(values, list) and len(values) <= MAX_VALUES
    }


def _marked(what: str, form: _Form) -> str:
    return f"{what} in variant {form.name}" if form.name else what


def workload_faults(document: Document) -> list[Fault]:
    """The faults of the variants of a workload, and of its axes, as far as that needs no platform."""
    tree = document.tree if isinstance(document.tree, dict) else {}
    variants, explore = tree.get("variants"), tree.get("explore")
    variants = variants if isinstance(variants, dict) and len(variants) <= MAX_VARIANTS else {}
    decisions, conditions = _listed(explore, "axes"), _listed(explore, "conditions")
    # A condition that sets what a decision sets is a fault of its own.
    clear = {axis: each for axis, each in conditions.items() if not any(overlap(axis, one) for one in decisions)}
    axes = {**decisions, **clear}
    if not variants and not axes:
        return []
    base = _base(document)
    faults = platform_axis_faults(document, axes.pop(PLATFORM_AXIS, ()))
    forms = {BASE: base}
    for name, raw in variants.items():
        if len(faults) > MAX_FAULTS:
            break  # None of what follows would be shown.
        if name != BASE and isinstance(raw, dict):
            forms[name], wrong = _variant_form(base, name)
            faults += wrong
    for axis, kind in ((PLATFORM_AXIS, "platform"), (VARIANT_AXIS, "variant")):
        if axis in conditions:
            place, what = ("explore", "conditions", axis), f"a {kind} is a decision, not a condition"
            faults.append(document.fault(place, what, "list it in axes", at_key=True))
    if VARIANT_AXIS in decisions:
        faults += _variant_axis_faults(document, axes[VARIANT_AXIS], variants)
    explored = [name for name in axes.get(VARIANT_AXIS, [BASE]) if isinstance(name, str) and name in forms]
    if math.prod(len(values) for values in axes.values()) > MAX_POINTS:
        # Too many points, which is reported elsewhere: then not each value in each variant too.
        explored = explored[:1]
    return faults + _axis_faults([forms[name] for name in explored], document, axes)


def _base(document: Document) -> _Form:
    """The workload itself, without its variants and its exploration."""
    workload, faults = _Form("", document, None).validated(document, document.fault)
    return _Form("", document, workload, tuple(faults))


def _variant_form(base: _Form, name: str) -> tuple[_Form, list[Fault]]:
    """A variant put into the workload, and what is wrong with it.

    A clash with a key of the workload is reported of the variant, which brought it in.
    """
    document = base.document
    raw, place = document.tree["variants"][name], ("variants", name)
    refusal = _planner_refusal(document.tree, raw, document.context)
    edited = with_variant(document, name, VARIED if refusal is None else ("scenario",))
    form_faults: list[Fault] = []

    def tell(path: KeyPath, what: str, hint: str | None = None, *, at_key: bool = False) -> Fault | None:
        fault = edited.fault(path, what, hint, at_key=at_key)
        form_faults.append(fault)
        if edited.origin(path) is not None:
            return fault
        if fault in base.faults:
            return None
        given = [key for key in reversed(VARIED) if key in raw]
        return document.fault((*place, *(path if path and path[0] in raw else given[:1])), what, hint)

    if base.spec is None and len(document.values) * len(document.tree["variants"]) > MAX_WORK:
        return _Form(name, edited, None), []
    workload, faults = base.validated(edited, tell)
    if refusal is not None:
        workload, faults = None, [document.fault((*place, "planner"), *refusal), *faults]
    return _Form(name, edited, workload, tuple(form_faults)), faults


def _planner_refusal(
    tree: Mapping[str, Any], raw: Mapping[str, Any], context: Mapping[str, Any]
) -> tuple[str, str] | None:
    """The reason for which a variant's planner cannot take the workload's problem or its mapping, and the remedy."""
    planner, base, problems = raw.get("planner"), tree.get("planner"), context.get("problems") or {}
    if not isinstance(planner, str) or not isinstance(base, str) or planner == base:
        return None
    if planner not in (context.get("tasks") or [planner]):
        return None
    if problems.get(planner) is not problems.get(base):
        what = f"the problem of {clip(planner)} is of another kind than that of {clip(base)}"
        return what, "choose a planner of the same kind, or make a workload of its own"
    if "mapping" not in raw:
        what = f"the workload maps the tasks of {clip(base)}, not those of {clip(planner)}"
        return what, "give the variant a mapping of its own"
    return None


def _variant_axis_faults(document: Document, names: list[Any], variants: Mapping[str, Any]) -> list[Fault]:
    place: KeyPath = ("explore", "axes", VARIANT_AXIS)
    if not variants:
        hint = "add variants: {NAME: {planner: ..., mapping: {...}}}"
        return [document.fault(place, "the workload has no variants", hint, at_key=True)]
    return [
        document.fault((*place, index), *no_variant(name, variants))
        for index, name in enumerate(names)
        if name != BASE and (not isinstance(name, str) or name not in variants)
    ]


def _axis_faults(forms: list[_Form], document: Document, axes: Mapping[str, list[Any]]) -> list[Fault]:
    """The faults of the axes that move a task or the scenario, in each of the forms explored."""
    work = len(document.values) * len(forms) * len(axes)
    most = max(1, MAX_WORK // max(1, work))
    faults: list[Fault] = []
    for axis, values in axes.items():
        if axis == VARIANT_AXIS or moves(axis, PROBLEM):
            continue
        movables = [Movable.of(None, form.document) for form in forms]
        if not moves(axis, SCENARIO) and not any(_places(movable, axis) for movable in movables):
            continue
        trial = _Trial(document, axes, axis, values[:most])
        shared = next(filter(None, (_shared(axis, axes, movable) for movable in movables)), None)
        if shared is not None:
            faults.append(trial.at_axis(f"sets the same thing as axis {shared}", _KEEP_ONE))
            continue
        names = conditions_of(document, axis, axes).get(VARIANT_AXIS)
        of_forms = [
            _form_faults(trial, form, movable)
            for form, movable in zip(forms, movables, strict=True)
            if names is None or (form.name or BASE) in names
        ]
        if not (is_unsound(document, axis, axes) and any(not each for each in of_forms)):
            faults += dict.fromkeys(fault for each in of_forms for fault in each)
    return faults


def _places(movable: Movable, axis: str) -> bool:
    """True if an axis moves a task of the mapping, or one at its default place, which is moved by what it takes."""
    task, key = axis.split(".")[:2]
    if task in movable.mapping:
        return isinstance(movable.mapping[task], dict)
    return task in movable.tasks and key in (movable.keys(task) or ())


def _shared(axis: str, axes: Mapping[str, Any], movable: Movable) -> str | None:
    """The axis before this one that sets the same thing: the same key, one inside the other's, or an alternative."""
    path = movable.path(axis)
    alternatives: tuple[str, ...] = ()
    if path[0] == "mapping" and len(path) > len(entry_of(path)):
        alternatives = movable.tasks.get(str(path[1]), TaskParameters).alternatives.get(str(path[2]), ())
    for other in axes:
        if other == axis:
            return None
        other_path = movable.path(other)
        shared = min(len(path), len(other_path))
        beside = entry_of(other_path) == entry_of(path) and len(other_path) > len(entry_of(path))
        if path[:shared] == other_path[:shared] or (alternatives and beside and other_path[2] in alternatives):
            return other
    return None


def _form_faults(trial: _Trial, form: _Form, movable: Movable) -> list[Fault]:
    """The faults of an axis of a task or of the scenario in one of the forms explored."""
    task, *keys = trial.axis.split(".")
    if moves(trial.axis, SCENARIO):
        own = trial.document.tree["variants"][form.name].get("scenario") if form.name else None
        if own and _holds(own, keys[1:]):
            what = f"variant {form.name} sets {'.'.join(keys)} itself"
            return [trial.at_axis(what, "leave it to one of the two")]
    elif not _places(movable, trial.axis):
        what = f"variant {form.name} maps no task {task}"
        hint = f"give the axis the variants that have {task}: when: {{{VARIANT_AXIS}: [...]}}"
        return [trial.at_axis(what, hint)]
    return trial.faults(form, movable)


def _holds(tree: Any, keys: list[str]) -> bool:
    for key in keys:
        if not isinstance(tree, dict) or key not in tree:
            return False
        tree = tree[key]
    return True


def cross_check(platform: Platform, workload: Workload, *, explored: bool = False) -> None:
    """Check that tasks are mapped to components of the platform, and the axes that move platform or problem.

    ``explored``: only what the exploration runs counts; without, the workload itself does too, and its axes of roles do
    not: they may be meant for another platform.

    Raises:
        UnsuitedError: every fault, at its place in the workload.
    """
    axes = workload.explore.every_axis if workload.explore else {}
    listed = [name for name in axes.get(VARIANT_AXIS, ()) if name == BASE or name in workload.variants]
    specs = [] if explored and listed else [workload]
    specs += [choose_variant(workload, name) for name in listed]
    faults = [fault for spec in specs for fault in _unmapped(platform, spec)]
    movables = [Movable.of(platform, spec.document) for spec in specs]
    for axis, values in axes.items():
        of_role = axis.partition(".")[0] in ROLES
        if axis in (VARIANT_AXIS, PLATFORM_AXIS) or moves(axis, SCENARIO) or (of_role and not explored):
            continue
        trial = _Trial(workload.document, axes, axis, list(values))
        if moves(axis, PROBLEM):
            faults += trial.faults(_Form("", workload.document, workload), movables[0])
        else:
            faults += _against_platform(trial, platform, movables)
    if faults:
        raise UnsuitedError(dict.fromkeys(faults))


def _unmapped(platform: Platform, workload: Workload) -> list[Fault]:
    return [
        workload.document.fault(("mapping", task, "component"), *_no_component(mapped.component, platform))
        for task, mapped in workload.mapping.items()
        if platform.named(mapped.component) not in platform.components
    ]


def _no_component(name: Any, platform: Platform) -> tuple[str, str]:
    return no_such(str(name), platform, "component", platform.components)


def _against_platform(trial: _Trial, platform: Platform, movables: list[Movable]) -> list[Fault]:
    """The faults of an axis of a task, component or link on the platform that is known."""
    name, key = trial.axis.split(".", 1)
    # A variant may have a task that the others lack.
    movable = next((each for each in movables if name in each.mapping), movables[0])
    movable = next((each for each in movables if each.refusal(trial.axis) is None), movable)
    refusal = movable.refusal(trial.axis) or movable.unplaced(name, trial.axes)
    if refusal is not None:
        return [trial.at_axis(*refusal)]
    if movable.section(name) != "mapping":
        shared = _shared(trial.axis, trial.axes, movable)
        if shared is not None:
            return [trial.at_axis(f"sets the same thing as axis {shared}", _KEEP_ONE)]
        return trial.faults(_Form("", platform.document, platform), movable)
    return [
        trial.document.fault((*trial.place, index), *_no_component(value, platform))
        for index, value in enumerate(trial.values)
        if key == "component" and (not isinstance(value, str) or platform.named(value) not in platform.components)
    ]


def load_workload(source: Source, tasks: TaskModels | None = None, problems: ProblemModels | None = None) -> Workload:
    """The workload with a shipped name (``labyrinth``), or in a file, in YAML text or in a dict.

    Args:
        source: see ``read_spec``.
        tasks: the models that parameters are checked against. Without, they are taken as they stand.
        problems: the models of problems other than a map with goals and starts.

    Raises:
        InputError: no shipped workload of that name.
        SpecError: all the faults of the file.
    """
    document = replace(with_listed_axes(read_spec(source, "workloads")), context={"tasks": tasks, "problems": problems})
    return validate(Workload, document, workload_faults).with_document(document)


def list_workloads() -> list[str]:
    """Names of the shipped workloads."""
    return shipped_names("workloads")
