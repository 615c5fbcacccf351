"""Design points: values put into the trees of a platform and a workload, which the same models then validate.

A variant of a workload is a merge of its section into the tree. What no edit touched goes into a model as it was
validated before. A fault of a value is reported where the value comes from (``Document.origins``).
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from codesign.ground.errors import Fault, SpecError, choose_hint, clip, show
from codesign.ground.memo import Same
from codesign.ground.models import SpecModel, TaskParameters
from codesign.inputs.document import REMOVED, Document, KeyPath, Origin, dotted, put
from codesign.inputs.faults import Teller
from codesign.inputs.platform import Platform, no_such, state_behind
from codesign.inputs.roles import ROLES
from codesign.inputs.workload import BASE, PLACE_KEYS, Workload, tasks_of

ENTRIES = (*Workload.entries, *Platform.entries)
"""Sections of named entries. An axis names the entry and a key in it."""

PLATFORM_AXIS = "platform"
"""The axis over platforms: names of shipped ones, or files."""

VARIANT_AXIS = "workload.variant"
PROBLEM, SCENARIO = "workload.problem", "workload.scenario"
"""Axes that move the problem or the scenario of the workload: the whole of it, or a key inside."""

FIXED_FIELDS = ("type", "between", "beside")
"""Fields of components and links that no axis moves: what they are and what they join is the platform itself."""

VARIED = ("planner", "mapping", "scenario")
"""Sections that a variant has in the place of the workload's."""

_NO_AXIS = "no axis: write TASK.PARAMETER, COMPONENT.FIELD or LINK.FIELD"


def moves(axis: str, section: str) -> bool:
    """True if an axis moves a section of the workload, the whole or a key inside: ``workload.problem.map.seed``."""
    return axis == section or axis.startswith(f"{section}.")


def entry_of(path: KeyPath) -> KeyPath:
    """The path of the task, component, link or section around a path."""
    return path[: 2 if path and path[0] in ENTRIES else 1]


@dataclass(frozen=True)
class Movable:
    """The parts of a platform and a workload that axes may move.

    - ``platform``: its components and links; None where it is not known yet.
    - ``mapping``: the workload's, raw, with one of its variants put in. ``tasks``: the tasks that it may place.
    """

    platform: Platform | None
    mapping: Mapping[str, Any]
    tasks: Mapping[str, type[TaskParameters]]

    @classmethod
    def of(cls, platform: Platform | None, document: Document) -> Movable:
        """The movable parts of a platform and the document of a workload."""
        mapping, models = document.tree.get("mapping"), document.context.get("tasks")
        return cls(platform, mapping if isinstance(mapping, dict) else {}, tasks_of(document.tree, models))

    def section(self, name: str) -> str | None:
        """The section of a task, component, link or role; None where there is none of that name."""
        if name in self.mapping:
            return "mapping"
        if self.platform is not None and self._named(name) in self.platform.components:
            return "components"
        if self.platform is not None and self._named(name) in self.platform.links:
            return "links"
        return "mapping" if name in self.tasks else None

    def path(self, axis: str) -> KeyPath:
        """The path, in the tree of platform or workload, that a sound axis moves."""
        head, *keys = axis.split(".")
        if head == "workload":
            return tuple(keys)
        section = self.section(head)
        return (str(section), head if section == "mapping" else self._named(head), *keys)

    def _named(self, name: str) -> str:
        return self._filled.get(name, name)

    @functools.cached_property
    def _filled(self) -> Mapping[str, str]:
        return {} if self.platform is None else self.platform.filled

    def keys(self, name: str) -> tuple[str, ...] | None:
        """The keys that an axis may move of a task, component or link; None if it may be anything."""
        section = self.section(name)
        if section == "mapping":
            model = self.tasks.get(name)
            return None if model is None else _movable_keys(model)
        entries: Mapping[str, SpecModel] = getattr(self.platform, str(section))
        return _movable_keys(type(entries[self._named(name)]))

    def is_shared_across(self, axis: str) -> bool:
        """True if runs that differ in a parameter that an axis moves share most of their work."""
        name, *keys = axis.split(".")
        model = self.tasks.get(name) if keys and self.section(name) == "mapping" else None
        return model is not None and keys[0] in model.shared_across

    def refusal(self, axis: str) -> tuple[str, str] | None:
        """The fault of an axis of a task, component or link, whatever its values; and the remedy."""
        name, *keys = axis.split(".")
        section = self.section(name)
        if axis == PLATFORM_AXIS:
            return "only an exploration has an axis over platforms", "name the platform in its own place"
        if section is None:
            return self._nothing_named(name, axis)
        accepted = self.keys(name)
        if keys and (accepted is None or keys[0] in accepted):
            return None
        if not keys:
            own = [key for key in accepted or () if key not in PLACE_KEYS] or accepted or PLACE_KEYS
            return _NO_AXIS, f"name what to set of {name}: {', '.join(f'{name}.{key}' for key in own)}"
        what = "unknown key"
        if section != "mapping" and keys[0] in FIXED_FIELDS:
            what = f"{keys[0]} of {name} is no axis: it stands in the platform"
        return what, choose_hint(clip(keys[0], 60), accepted or ())

    def _nothing_named(self, name: str, axis: str) -> tuple[str, str]:
        sections = (VARIANT_AXIS, PROBLEM, SCENARIO)
        if name == "workload":
            return f"an axis moves no {clip(axis)!r}", choose_hint(clip(axis), sections)
        if name in ROLES and self.platform is not None:
            return no_such(name, self.platform, "", ())
        names = {*self.mapping, *self.tasks, *sections}
        names |= {*self.platform.components, *self.platform.links} if self.platform else set()
        return f"there is no task, component or link {clip(name)!r}", choose_hint(clip(name, 60), names)

    def unplaced(self, name: str, axes: Mapping[str, Any]) -> tuple[str, str] | None:
        """The fault of axes that move a task which nothing places; and the remedy."""
        if self.section(name) != "mapping" or name in self.mapping or f"{name}.component" in axes:
            return None
        return f"the mapping does not place task {name}", f"set {name}.component too"

    def edits(self, axis: str, value: Any) -> dict[KeyPath, Any]:
        """The edits that put a value in the place of an axis: a parameter removes its alternatives."""
        path = self.path(axis)
        model = self.tasks.get(str(path[1])) if path[0] == "mapping" else None
        others = model.alternatives.get(str(path[2]), ()) if model is not None else ()
        return {**{(*path[:2], other): REMOVED for other in others}, path: value}


@functools.cache
def _movable_keys(model: type[SpecModel]) -> tuple[str, ...]:
    """The keys that an axis may move of a task, component or link with a model: of a task, its place keys too."""
    if issubclass(model, TaskParameters):
        return (*PLACE_KEYS, *model.model_fields)
    return tuple(key for key in model.model_fields if key not in FIXED_FIELDS)


def with_variant(document: Document, name: str, keys: tuple[str, ...] = VARIED) -> Document:
    """The document of a workload with a variant put in; ``keys``: the keys of the variant that are put in."""
    raw = {key: value for key, value in document.tree["variants"][name].items() if key in keys}
    edits: dict[KeyPath, Any] = {(key,): raw[key] for key in ("planner", "mapping") if raw.get(key) is not None}
    changes, base = raw.get("scenario"), document.tree.get("scenario")
    if isinstance(changes, dict):
        # A scenario of another type takes over nothing: its keys mean something else.
        same = isinstance(base, dict) and changes.get("type", base.get("type")) == base.get("type")
        edits |= _changes(base, changes, ("scenario",)) if same else {("scenario",): changes}
    elif changes is not None:
        edits["scenario",] = changes
    return put(document, edits, lambda path: Origin(("variants", name, *path), document))


def _changes(base: Mapping[str, Any], changes: Mapping[str, Any], path: KeyPath) -> dict[KeyPath, Any]:
    """The edits that merge ``changes`` into ``base``, mapping by mapping, key by key."""
    edits: dict[KeyPath, Any] = {}
    for key, value in changes.items():
        inner = base.get(key)
        both = isinstance(inner, dict) and isinstance(value, dict)
        edits |= _changes(inner, value, (*path, key)) if both else {(*path, key): value}  # type: ignore[arg-type]
    return edits


def no_variant(name: Any, variants: Mapping[str, Any]) -> tuple[str, str]:
    """The fault of the name of a variant that is none, and the remedy."""
    is_text = isinstance(name, str)
    what = f"there is no variant {clip(name)!r}" if is_text else f"{show(name)} names no variant"
    return what, choose_hint(clip(str(name), 60), (BASE, *variants))


def choose_variant(workload: Workload, name: Any, by: str = "") -> Workload:
    """The workload with a variant in the place of what it does itself; one that was chosen has no variants left.

    Args:
        workload: with variants, none of them chosen.
        name: of one of them, or ``base``.
        by: what stands before the axis where a fault is reported.

    Raises:
        SpecError: no such variant; or it clashes with what was put into the workload before.
    """
    spec, document = _chosen(workload, name, by)
    chosen, faults = spec.edited(document, {"variants": {}, "explore": workload.explore}, document.fault)
    if chosen is None:
        raise SpecError(faults)
    return chosen


@functools.lru_cache(maxsize=128)
def _kept_variant(key: Same[Workload], name: str) -> tuple[Document, Workload | None]:
    """A workload with a variant put in, as a document and, where it is sound, as a model; made once."""
    workload = key.it
    document = with_variant(workload.document, name)
    fixed: dict[str, Any] = {"variants": {}, "explore": None}
    return document, workload.edited(document, fixed, document.fault)[0]


def _chosen(workload: Workload, name: Any, by: str) -> tuple[Workload, Document]:
    """The document of a workload with a variant put in, and the spec that edits of it start from."""
    place = f"{by}{VARIANT_AXIS}"
    if not workload.variants:
        hint = "give it a section variants: {NAME: {planner: ..., mapping: {...}}}"
        raise SpecError([Fault(place, 0, 0, "", f"workload {workload.name} has no variants", hint)])
    if name == BASE:
        return workload, workload.document
    if not isinstance(name, str) or name not in workload.variants:
        raise SpecError([Fault(place, 0, 0, "", *no_variant(name, workload.variants))])
    document, variant = _kept_variant(Same(workload), name)
    return variant or workload, document


def design_point(
    platform: Platform, workload: Workload, values: Mapping[str, Any], by: str = "point: "
) -> tuple[Platform, Workload]:
    """One design point: platform and workload with a raw value put in the place of each axis.

    The workload of a point has no ``explore``. Nothing is read again but a part that was not read before.

    Args:
        platform: and ``workload``: loaded specs.
        values: by axis, ``TASK.PARAMETER``, ``COMPONENT.FIELD``, ``LINK.FIELD``, ``workload.variant``, or a key of
            ``workload.problem`` or ``workload.scenario``, as YAML would give them. The variant comes first.
        by: what stands before the axis where a fault of its value is reported, now or later: the files hold no such
            value.

    Raises:
        SpecError: an axis that is none, or a value that is not accepted, alone or together with the others.
    """
    fixed: dict[str, Any] = {"explore": None}
    moved: dict[KeyPath, str] = {}
    spec, document, parts = workload, workload.document, platform.document
    if VARIANT_AXIS in values:
        (spec, document), fixed["variants"] = _chosen(workload, values[VARIANT_AXIS], by), {}
    axes = {axis: value for axis, value in values.items() if axis != VARIANT_AXIS}

    def origin(path: KeyPath) -> Origin:
        return Origin((f"{by}{moved[path]}",))

    sections = [axis for axis in axes if moves(axis, PROBLEM) or moves(axis, SCENARIO)]
    moved |= {tuple(axis.split(".")[1:]): axis for axis in sections}
    document = put(document, {path: axes[axis] for path, axis in moved.items()}, origin)
    # The scenario decides which tasks there are.
    movable = Movable.of(platform, document)
    faults: list[Fault] = []
    of_workload: dict[KeyPath, Any] = {}
    of_platform: dict[KeyPath, Any] = {}
    for axis in (axis for axis in axes if axis not in sections):
        refusal = movable.refusal(axis) or movable.unplaced(axis.partition(".")[0], axes)
        if refusal is not None:
            faults.append(Fault(f"{by}{clip(axis)}", 0, 0, "", *refusal))
            continue
        edits = movable.edits(axis, axes[axis])
        moved |= dict.fromkeys(edits, axis)
        (of_workload if next(iter(edits))[0] == "mapping" else of_platform).update(edits)
    document, parts = put(document, of_workload, origin), put(parts, of_platform, origin)
    faults += [*document.faults, *parts.faults]
    point, wrong = spec.edited(document, fixed, _teller(document, moved, by))
    moved_platform, more = _kept_platform(_Moved(platform, of_platform, parts, moved, by))
    if faults or wrong or more or point is None or moved_platform is None:
        raise SpecError([*faults, *wrong, *more])
    return moved_platform, point


class _Moved:
    """An edited platform as the key of what is kept of it: by the text of the edits, and the state of its files.

    ``parts``: its document after the edits. ``moved``: the axis of each path. ``by``: see ``design_point``.
    """

    def __init__(
        self, platform: Platform, edits: Mapping[KeyPath, Any], parts: Document, moved: Mapping[KeyPath, str], by: str
    ) -> None:
        self.platform, self.parts, self.moved, self.by = platform, parts, moved, by
        own = repr([(path, moved[path], value) for path, value in edits.items()])
        self._key = Same(platform), by, own, _files_behind(parts, edits)

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Moved) and self._key == other._key


def _files_behind(document: Document, edited: Iterable[KeyPath]) -> tuple[object, ...]:
    """The states of the files that the edited components of a platform name; a state moves when its file is changed."""
    components, states = document.tree.get("components"), []
    for name in dict.fromkeys(path[1] for path in edited if path[0] == "components"):
        raw = components.get(name) if isinstance(components, dict) else None
        with contextlib.suppress(TypeError, ValueError, KeyError, SpecError):
            states.append(state_behind(raw, document.folder) if isinstance(raw, dict) else ())
    return tuple(states)


@functools.lru_cache(maxsize=64)
def _kept_platform(key: _Moved) -> tuple[Platform | None, tuple[Fault, ...]]:
    """An edited platform, or every fault of it; the points of a study that share it have one object of it."""
    spec, faults = key.platform.edited(key.parts, {}, _teller(key.parts, key.moved, key.by))
    return spec, tuple(faults)


def _teller(document: Document, moved: Mapping[KeyPath, str], by: str) -> Teller:
    """A teller of the faults of a point: at the axis that brought the value; a clash, at all axes of its entry."""

    def tell(path: KeyPath, what: str, hint: str | None = None, *, at_key: bool = False) -> Fault:
        if document.origin(path) is not None:
            return document.fault(path, what, hint, at_key=at_key)
        beside = [axis for other, axis in moved.items() if entry_of(other) == entry_of(path)]
        axes = ", ".join(dict.fromkeys(beside or moved.values())) or VARIANT_AXIS
        return Fault(f"{by}{axes}", 0, 0, dotted(path[1:] if entry_of(path) != path[:1] else path), what, hint)

    return tell


def on_platform(platform: Platform, workload: Workload) -> Workload:
    """The workload with components in the place of the roles that its mapping names."""
    mapping = {
        task: mapped.model_copy(update={"component": platform.named(mapped.component)})
        for task, mapped in workload.mapping.items()
        if mapped.component in platform.filled
    }
    return workload.model_copy(update={"mapping": {**workload.mapping, **mapping}}) if mapping else workload


def has_axis(platform: Platform, workload: Workload, axis: str) -> bool:
    """True if an axis names what platform or workload have. Planners share names of tasks, but not the parameters."""
    if axis == VARIANT_AXIS:
        return bool(workload.variants)
    if moves(axis, PROBLEM) or moves(axis, SCENARIO):
        spec = workload.problem if moves(axis, PROBLEM) else workload.scenario
        keys = axis.split(".")[2:]
        return not keys or keys[0] in type(spec).model_fields
    movable = Movable.of(platform, workload.document)
    return movable.refusal(axis) is None
