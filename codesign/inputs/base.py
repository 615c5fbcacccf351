"""A loaded spec: frozen, picklable, with its document (the raw tree and the places of its keys) and a digest.

An edited document is validated again where it was edited; the rest of the spec stays as it is.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar, cast

from pydantic import BaseModel, PrivateAttr, ValidationError

from codesign.ground.errors import Fault, SpecError
from codesign.ground.figures import Figure
from codesign.ground.models import SpecModel
from codesign.inputs.document import Document, KeyPath
from codesign.inputs.faults import Keep, Teller, context_of, translate
from codesign.inputs.fields import DECLARED

_NO_DOCUMENT = Document("", Path(), {})

CHOSEN = "chosen for this design point"
"""Source of a figure in short form that a design point brings."""

_NOT_IDENTITY = frozenset({"source", "description", "explore"})
"""Keys that change no result: where a figure is from, prose, and which other points are explored."""


class Spec(SpecModel):
    """A platform or a workload, loaded. Its ``repr`` is its name; ``model_dump`` gives all of it."""

    alone: ClassVar[tuple[str, ...]] = ()
    """Sections that are sound by themselves, as long as the rest of the spec stays."""

    entries: ClassVar[Mapping[str, bool]] = {}
    """Sections of named entries, each sound by itself; True if an edit may add and remove entries."""

    # A factory, as pydantic copies a default for each model.
    _document: Document = PrivateAttr(default_factory=lambda: _NO_DOCUMENT)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.__dict__.get('name', '')!r})"

    @property
    def document(self) -> Document:
        """The file behind the spec: its raw tree and the places of its keys."""
        # Pydantic's own access to a private attribute takes ten times as long.
        private = self.__pydantic_private__
        assert private is not None, "set by pydantic"
        document: Document = private["_document"]
        return document

    def with_document(self, document: Document, before: Self | None = None) -> Self:
        """The spec with its file; figures in short form get the file's name and their line as source.

        Args:
            document: the file.
            before: the spec before its document was edited; what it shares with this one has its sources.
        """
        spec = cast("Self", with_sources(self, document, (), before))
        spec._document = document
        return spec

    def edited(
        self, document: Document, fixed: Mapping[str, Any], tell: Teller, keep: Keep | None = None
    ) -> tuple[Self | None, list[Fault]]:
        """The spec with its document edited, or every fault of it: see ``validated``."""
        if document is self.document:
            return (self.model_copy(update=dict(fixed)) if fixed else self), []
        return validated(type(self), self, document, fixed, tell, keep)

    def validated_alone(self, section: str, name: str, raw: Any, document: Document) -> SpecModel:
        """One of the sections ``alone`` (its ``name`` is empty) or a named entry, from its raw form.

        Raises:
            TypeError, ValueError, KeyError, ValidationError, SpecError: it has a fault.
        """
        raise NotImplementedError

    def digest(self) -> str:
        """SHA-256, hex, of all that can change a result.

        Canonical JSON of the spec without descriptions, sources of figures and the ``explore`` section: a
        comment or an axis more leaves it as it is.
        """
        content = _without(self._identity(), _NOT_IDENTITY)
        text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()

    def _identity(self) -> dict[str, Any]:
        return self.model_dump(mode="json")


def fault(spec: Spec, path: KeyPath, what: str, hint: str | None = None) -> Fault:
    """A fault at a key of a loaded spec, or at what is around the key where it is not written out.

    ``path`` leads to the key: ``("problem", "goals", 0)``.
    """
    return spec.document.fault(path, what, hint)


S = TypeVar("S", bound=Spec)


def validated(
    model: type[S], spec: S | None, document: Document, fixed: Mapping[str, Any], tell: Teller, keep: Keep | None = None
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
        entries = {name: _unless_edited(entry, before.get(name), model.get(name)) for name, entry in raw.items()}
        return {name: raw[name] if entry is None else entry for name, entry in entries.items()}
    return raw


def _by_entries(spec: S, document: Document, fixed: Mapping[str, Any]) -> S | None:
    """The spec with only the sections and entries validated that were edited; None where that is not enough.

    Where another section was edited, or one of these has a fault, the whole document is validated.
    """
    changes, tree, tree_before = dict(fixed), document.tree, spec.document.tree
    if not tree.keys() <= tree_before.keys():
        return None
    for key, before in tree_before.items():
        raw = tree.get(key)
        if raw is before or key in fixed:
            continue
        changed = _section(spec, key, raw, before, document)
        if changed is None:
            return None
        changes[key] = with_sources(changed, document, (key,), getattr(spec, key))
    edited = spec.model_copy(update=changes)
    edited._document = document
    return edited


def _section(spec: Spec, key: str, raw: Any, before: Any, document: Document) -> Any:
    """An edited section, validated by itself; None where that is not enough."""
    with contextlib.suppress(TypeError, ValueError, KeyError, ValidationError, SpecError):
        if key in spec.alone:
            return spec.validated_alone(key, "", raw, document)
        if key in spec.entries and isinstance(raw, dict) and raw and (spec.entries[key] or raw.keys() == before.keys()):
            validated_before = getattr(spec, key)
            return {
                name: validated_before[name]
                if name in validated_before and entry is before.get(name)
                else spec.validated_alone(key, name, entry, document)
                for name, entry in raw.items()
            }
    return None


def _without(content: Any, keys: frozenset[str]) -> Any:
    if isinstance(content, dict):
        return {key: _without(value, keys) for key, value in content.items() if key not in keys}
    if isinstance(content, list):
        return [_without(value, keys) for value in content]
    return content


def _declared_in(document: Document, path: KeyPath) -> str:
    """The source of a figure in short form: its file, without folders, and its line; or that it was chosen."""
    origin = document.origin(path)
    if origin is not None and origin.document is None:
        return CHOSEN
    line, _ = document.value_mark(path)
    return f"{DECLARED} in {_file_name(document.file)}" + (f":{line}" if line else "")


@functools.lru_cache(maxsize=64)
def _file_name(file: str) -> str:
    return Path(file).name


def with_sources(value: Any, document: Document, path: KeyPath, before: Any = None) -> Any:
    """The value at a path of a document, with a source for each figure in short form; ``before`` has its sources."""
    if value is before:
        return value
    if isinstance(value, Figure):
        if value.source != DECLARED:
            return value
        return replace(value, source=_declared_in(document, path))
    is_model, changes = isinstance(value, BaseModel), {}
    fields_before = (before.__dict__ if is_model else before) if type(before) is type(value) else {}
    for name, inner in (value.__dict__ if is_model else value).items():
        if isinstance(inner, Figure | BaseModel | dict):
            sourced = with_sources(inner, document, (*path, name), fields_before.get(name))
            if sourced is not inner:
                changes[name] = sourced
    if not changes:
        return value
    return value.model_copy(update=changes) if is_model else value | changes
