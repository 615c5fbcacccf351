"""A loaded spec: frozen, picklable, with its document (the raw tree and the places of its keys) and a digest."""

from __future__ import annotations

import functools
import hashlib
import json
from pathlib import Path
from typing import Any, Self, cast

from pydantic import BaseModel, PrivateAttr

from codesign.ground.errors import Fault
from codesign.ground.figures import Figure
from codesign.ground.models import SpecModel
from codesign.inputs.document import Document, KeyPath
from codesign.inputs.fields import DECLARED

_NO_DOCUMENT = Document("", Path(), {})

CHOSEN = "chosen for this design point"
"""Source of a figure in short form that a design point brings."""

_NOT_IDENTITY = frozenset({"source", "description", "explore"})
"""Keys that change no result: where a figure is from, prose, and which other points are explored."""


class Spec(SpecModel):
    """A platform or a workload, loaded. Its ``repr`` is its name; ``model_dump`` gives all of it."""

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
        source = _declared_in(document, path)
        return Figure(value.value, value.unit, value.status, source, value.low, value.high)
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
