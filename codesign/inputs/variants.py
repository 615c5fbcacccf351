"""Variants of a workload: other planners, mappings and settings of the scenario, one of which may be chosen."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from codesign.errors import Fault, SpecError, choose_hint, clip, show
from codesign.inputs.faults import translate
from codesign.inputs.scenario import Scenario
from codesign.inputs.yaml_tree import Document, KeyPath, Mark
from codesign.models import SpecModel

if TYPE_CHECKING:
    from codesign.inputs.workload import Workload

BASE = "base"
"""The name under which the workload itself stands beside its variants."""

VARIANT_AXIS = "workload.variant"
MAX_VARIANTS = 64

NO_SCENARIO = {"type": "plan_once"}
"""What a workload without a scenario has."""


class _StagedScenario(SpecModel):
    """A scenario under its key, to be validated by itself."""

    scenario: Scenario


def sound_scenario(raw: Any, document: Document) -> Scenario:
    """The scenario of a raw one.

    Raises:
        ValidationError: with locations inside ``{"scenario": raw}``.
    """
    return _StagedScenario.model_validate({"scenario": raw}, context={"document": document}).scenario


@dataclass(frozen=True)
class ChosenDocument(Document):
    """The document of a workload with a variant put in: ``chosen`` says where in the file a section stands."""

    chosen: dict[KeyPath, KeyPath] = field(default_factory=dict)

    def value_mark(self, path: KeyPath) -> Mark:
        """The place of the value at ``path``, in the variant where it is from there."""
        return super().value_mark(self._place(path))

    def key_mark(self, path: KeyPath) -> Mark:
        """The place of the key at ``path``, in the variant where it is from there."""
        return super().key_mark(self._place(path))

    def fault(self, path: KeyPath, what: str, hint: str | None = None, *, at_key: bool = False) -> Fault:
        """A fault at a value or key, in the variant where it is from there."""
        if not any(path[: len(moved)] == moved for moved in self.moved):
            path = self._place(path)
        return super().fault(path, what, hint, at_key=at_key)

    def _place(self, path: KeyPath) -> KeyPath:
        for length in range(len(path), 0, -1):
            if path[:length] in self.chosen:
                return (*self.chosen[path[:length]], *path[length:])
        return path


def merged(base: Any, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The raw scenario ``base`` (None: the default one) with ``changes``, mapping by mapping, key by key.

    A scenario of another type takes over nothing: its keys mean something else.

    >>> merged({"type": "drive", "replan": {"policy": "restart", "trigger": "change"}}, {"replan": {"policy": "x"}})
    {'type': 'drive', 'replan': {'policy': 'x', 'trigger': 'change'}}
    """
    known = base if isinstance(base, dict) else NO_SCENARIO
    if changes.get("type", known.get("type")) != known.get("type"):
        return dict(changes)
    return _merged(known, changes)


def _merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    made = dict(base)
    for key, value in changes.items():
        inner = made.get(key)
        made[key] = _merged(inner, value) if isinstance(inner, dict) and isinstance(value, dict) else value
    return made


def parts_present(raw: Any, path: KeyPath, *, keep_last: bool = False) -> KeyPath:
    """As much of ``path`` as stands in ``raw``; ``keep_last``: and the next step, where it is the last.

    >>> parts_present({"a": {"b": 1}}, ("a", "c", "d")), parts_present({"a": {}}, ("a", "c"), keep_last=True)
    (('a',), ('a', 'c'))
    """
    for length, step in enumerate(path):
        there = (isinstance(raw, dict) and step in raw) or (
            isinstance(raw, list) and isinstance(step, int) and step < len(raw)
        )
        if not there:
            return path if keep_last and length == len(path) - 1 else path[:length]
        raw = raw[step]
    return path


def choose_variant(workload: Workload, name: Any, where: str) -> Workload:
    """The workload with a variant in the place of what it does itself; one that was chosen has no variants left.

    Args:
        workload: with variants, none of them chosen.
        name: of one of them, or ``base``.
        where: what stands before the axis where a fault is told.

    Raises:
        SpecError: no such variant; or it clashes with what was put into the scenario before.
    """
    place = f"{where}{VARIANT_AXIS}"
    if not workload.variants:
        hint = "give it a section variants: {NAME: {planner: ..., mapping: {...}}}"
        raise SpecError([Fault(place, 0, 0, "", f"workload {workload.name} has no variants", hint)])
    if name == BASE:
        return workload.model_copy(update={"variants": {}})
    if not isinstance(name, str) or name not in workload.variants:
        raise SpecError([Fault(place, 0, 0, "", *no_variant(name, workload.variants))])
    variant, document = workload.variants[name], workload.document
    raw = document.tree["variants"][name]
    update: dict[str, Any] = {"variants": {}}
    tree = dict(document.tree)
    chosen: dict[KeyPath, KeyPath] = {}
    if variant.planner is not None:
        update["planner"], tree["planner"] = variant.planner, variant.planner
        chosen[("planner",)] = ("variants", name, "planner")
    if variant.mapping is not None:
        update["mapping"], tree["mapping"] = variant.mapping, raw["mapping"]
        chosen[("mapping",)] = ("variants", name, "mapping")
    if variant.scenario is not None:
        tree["scenario"] = merged(tree.get("scenario"), raw["scenario"])
        update["scenario"] = _scenario(tree["scenario"], document, place)
        inside = ("variants", name, "scenario")
        if variant.scenario.type != workload.scenario.type:
            chosen[("scenario",)] = inside
        chosen |= {("scenario", *path): (*inside, *path) for path in _leaves(raw["scenario"])}
    made = workload.model_copy(update=update)
    fields = {each.name: getattr(document, each.name) for each in dataclasses.fields(Document)}
    moved = {path: source for path, source in document.moved.items() if not _replaced(path, chosen)}
    made._document = ChosenDocument(**{**fields, "tree": tree, "moved": moved}, chosen=chosen)
    return made


def no_variant(name: Any, variants: Mapping[str, Any]) -> tuple[str, str]:
    """What is wrong with the name of a variant that is none, and the remedy."""
    what = (
        f"there is no variant {clip(name)!r}" if isinstance(name, str) else f"{show(name)} names no variant"
    )
    return what, choose_hint(clip(str(name), 60), (BASE, *variants))


def _scenario(raw: Any, document: Document, place: str) -> Scenario:
    try:
        return sound_scenario(raw, document)
    except ValidationError as error:
        told = Document(place, document.folder, {"scenario": raw})
        raise SpecError(translate(error, told)) from None


def _leaves(raw: Any, path: KeyPath = ()) -> Iterator[KeyPath]:
    """The ways to what is no mapping inside ``raw``, and to its empty mappings."""
    if isinstance(raw, dict) and raw:
        for key, value in raw.items():
            yield from _leaves(value, (*path, key))
    else:
        yield path


def _replaced(path: KeyPath, chosen: Mapping[KeyPath, KeyPath]) -> bool:
    return any(path[: len(begin)] == begin for begin in chosen)
