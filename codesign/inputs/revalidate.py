"""An edited document as a model: what no edit touched is taken over as it was validated before."""

from __future__ import annotations

import contextlib
import functools
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from codesign.errors import Fault, SpecError
from codesign.inputs.base import Spec, with_sources
from codesign.inputs.calibration_file import calibration_state
from codesign.inputs.components import COMPONENTS
from codesign.inputs.document import Document, KeyPath
from codesign.inputs.faults import Keep, Teller, context_of, translate
from codesign.inputs.host_file import host_state
from codesign.inputs.links import LINKS
from codesign.inputs.part_file import PARTS, name_and_grade
from codesign.inputs.workload import RawParameters, Workload, map_task, problem_model
from codesign.models import SpecModel

S = TypeVar("S", bound=Spec)

ENTRIES = ("mapping", "components", "links")
"""Sections of named entries. An axis names the entry and a key in it."""


def validated(
    model: type[S],
    spec: S | None,
    document: Document,
    fixed: Mapping[str, Any],
    tell: Teller,
    keep: Keep | None = None,
) -> tuple[S | None, list[Fault]]:
    """An edited document as a model, or every fault of it.

    Args:
        model: of the document.
        spec: the document before the edits, validated; what they left as it was is not validated again. None: all is.
        document: the edited document.
        fixed: fields that do not come from the document.
        tell: makes the faults. ``keep``: says which are made.
    """
    tree = document.tree
    fields = {key: raw for key, raw in tree.items() if key not in fixed}
    if spec is not None:
        edited_spec = _by_entries(spec, document, fixed)
        if edited_spec is not None:
            return edited_spec, []
        before = spec.document.tree
        for key, validated_before in dict(spec).items():
            fields[key] = _unless_edited(tree.get(key), before.get(key), validated_before)
    try:
        whole = model.model_validate({**fields, **fixed}, context=context_of(document))
    except ValidationError as error:
        return None, translate(error, document, tell, keep)
    return whole.with_document(document, spec), []


def _unless_edited(raw: Any, before: Any, model: Any) -> Any:
    """The ``model`` that a raw section was validated to, entry by entry; or what is raw, where an edit put it there."""
    if raw is before:
        return model
    if isinstance(raw, dict) and isinstance(before, dict) and isinstance(model, dict):
        entries = {
            name: _unless_edited(entry, before.get(name), model.get(name)) for name, entry in raw.items()
        }
        return {name: raw[name] if entry is None else entry for name, entry in entries.items()}
    return raw


def _by_entries(spec: S, document: Document, fixed: Mapping[str, Any]) -> S | None:
    """The spec with only the problem and the entries validated that were edited; None where that is not enough.

    The problem and each task, component and link are sound by themselves, as long as planner and scenario stay. Where
    something else was edited, or one of these has a fault, the whole document is validated.
    """
    changes, tree, tree_before = dict(fixed), document.tree, spec.document.tree
    if not tree.keys() <= tree_before.keys():
        return None
    for key, before in tree_before.items():
        raw = tree.get(key)
        if raw is before or key in fixed:
            continue
        validated_before = getattr(spec, key)
        if key == "problem":
            changes[key] = _alone(spec, key, "", raw, document)
        elif key in ENTRIES and isinstance(raw, dict) and raw:
            changes[key] = {
                name: validated_before[name]
                if name in validated_before and entry is before.get(name)
                else _alone(spec, key, name, entry, document)
                for name, entry in raw.items()
            }
            if None in changes[key].values() or (key != "mapping" and raw.keys() != before.keys()):
                return None
        else:
            return None
        if changes[key] is None:
            return None
        changes[key] = with_sources(changes[key], document, (key,), validated_before)
    edited = spec.model_copy(update=changes)
    edited._document = document
    return edited


def _alone(spec: Spec, section: str, name: str, raw: Any, document: Document) -> SpecModel | None:
    """A problem, task, component or link, validated by itself; None where it has a fault.

    A component or link of the same content is validated once.
    """
    with contextlib.suppress(TypeError, ValueError, KeyError, ValidationError, SpecError):
        if isinstance(spec, Workload):
            if section == "problem":
                model = problem_model(spec.planner, document.context)
                return model.model_validate(raw, context=context_of(document))
            models = spec.task_models
            return map_task(raw, RawParameters if models is None else models[name], document)
        return _of_content(section, json.dumps(raw), document.folder, _state(raw, document.folder))
    return None


def files_of(document: Document, edited: Iterable[KeyPath]) -> tuple[object, ...]:
    """When the files were changed that the edited components of a platform name."""
    components, states = document.tree.get("components"), []
    for name in dict.fromkeys(path[1] for path in edited if path[0] == "components"):
        raw = components.get(name) if isinstance(components, dict) else None
        with contextlib.suppress(TypeError, ValueError, KeyError, SpecError):
            states.append(_state(raw, document.folder) if isinstance(raw, dict) else ())
    return tuple(states)


def _state(raw: Mapping[str, Any], folder: Path) -> tuple[object, ...]:
    """When the files that a component names were changed."""
    part, host, calibration = raw.get("part"), raw.get("host"), raw.get("calibration")
    parts = PARTS.state([name_and_grade(part)[0]], (folder / "parts",)) if isinstance(part, str) else ()
    hosts = host_state(host, (folder / "hosts",)) if isinstance(host, str) else ()
    return (*parts, *hosts, *(calibration_state(calibration, folder) if isinstance(calibration, str) else ()))


@functools.lru_cache(maxsize=1024)
def _of_content(section: str, text: str, folder: Path, _files: object) -> SpecModel:
    entry = json.loads(text)
    model: type[SpecModel] = (LINKS if section == "links" else COMPONENTS)[entry["type"]]
    return model.model_validate(entry, context={"document": Document("", folder, entry)})
