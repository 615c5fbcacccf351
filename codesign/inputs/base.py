"""A loaded spec: frozen, picklable, with the places of its keys, a digest, and its own raw text tree."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self, TypeVar, cast

from pydantic import BaseModel, PrivateAttr

from codesign.errors import Fault
from codesign.figures import Figure
from codesign.inputs.fields import DECLARED
from codesign.inputs.yaml_tree import Document, KeyPath
from codesign.models import SpecModel

_NO_DOCUMENT = Document("", Path(), {})

_NOT_IDENTITY = frozenset({"source", "description", "explore"})
"""Keys that change no result: where a figure is from, prose, and which other points are explored."""


class Spec(SpecModel):
    """A platform or a workload, loaded."""

    _document: Document = PrivateAttr(default=_NO_DOCUMENT)

    @property
    def document(self) -> Document:
        """The file behind the spec: its raw tree and the places of its keys."""
        return self._document

    def with_document(self, document: Document) -> Self:
        """The spec with its file; figures in short form get the file's name and their line as source."""
        made = placed(self, lambda path: declared_in(document, path))
        made._document = document
        return made

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

    ``path`` is the way to the key: ``("problem", "goals", 0)``.
    """
    return spec.document.fault(path, what, hint)


def _without(content: Any, keys: frozenset[str]) -> Any:
    if isinstance(content, dict):
        return {key: _without(value, keys) for key, value in content.items() if key not in keys}
    if isinstance(content, list):
        return [_without(value, keys) for value in content]
    return content


def declared_in(document: Document, path: KeyPath) -> str:
    """The source of a figure in short form: its file, without folders, and its line."""
    return f"{DECLARED} in {Path(document.file).name}:{document.value_mark(path)[0]}"


V = TypeVar("V")


def placed(value: V, source: Callable[[KeyPath], str], path: KeyPath = ()) -> V:
    """The value with ``source(path)`` as the source of each figure in short form inside it."""
    return cast("V", _placed(value, source, path))


def _placed(value: Any, source: Callable[[KeyPath], str], path: KeyPath) -> Any:
    if isinstance(value, Figure):
        return dataclasses.replace(value, source=source(path)) if value.source == DECLARED else value
    if isinstance(value, BaseModel):
        fields = {name: getattr(value, name) for name in type(value).model_fields}
        update = _changes(fields, source, path)
        return value.model_copy(update=update) if update else value
    if isinstance(value, dict):
        return value | _changes(value, source, path)
    return value


def _changes(fields: dict[str, Any], source: Callable[[KeyPath], str], path: KeyPath) -> dict[str, Any]:
    made = {name: _placed(field, source, (*path, name)) for name, field in fields.items()}
    return {name: field for name, field in made.items() if field is not fields[name]}
