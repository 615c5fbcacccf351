"""A document as JSON, and back: what a store of explored points keeps of each spec, with the place of every key."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from codesign.ground.errors import Fault, SpecError, clip
from codesign.inputs.document import Document, KeyPath, Mark, Origin, dotted
from codesign.inputs.yaml_tree import MAX_DEPTH, MAX_FAULTS, MAX_NODES


def document_from(tree: Mapping[str, Any], file: str) -> Document:
    """A copy of a tree of mappings, lists, tuples and scalars, as a document without places.

    Paths in the tree are relative to the current folder.

    Args:
        tree: keys are text; scalars are text, int, float, bool and None.
        file: how faults name the tree.

    Raises:
        SpecError: the tree is too large, too deep, or contains itself. Faults in single values are kept in
            ``Document.faults``.
    """
    copier = _Copier(file)
    plain = copier.copy(tree, ())
    return replace(Document(file, Path(), plain), faults=tuple(copier.faults))


class _Copier:
    """Copies a tree node by node; what is none of the accepted types becomes a fault, and None in the copy."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.faults: list[Fault] = []
        self._nodes = 0

    def copy(self, value: Any, path: KeyPath) -> Any:
        self._nodes += 1
        if self._nodes > MAX_NODES:
            self._stop(path, f"more than {MAX_NODES:,} values")
        if len(path) > MAX_DEPTH:
            self._stop(path, f"nested more than {MAX_DEPTH} deep")
        if isinstance(value, Mapping):
            return {key: self.copy(inner, (*path, key)) for key, inner in self._items(value, path)}
        if isinstance(value, list | tuple):
            return [self.copy(inner, (*path, index)) for index, inner in enumerate(value)]
        if value is None or isinstance(value, str | bool | int):
            return value
        if isinstance(value, float) and math.isfinite(value):
            return float(value)
        what = f"{clip(repr(value))} is " + ("not finite" if isinstance(value, float) else "no plain value")
        self._refuse(path, what, "write a text, a whole number, a finite number, true, false or None")
        return None

    def _items(self, mapping: Mapping[Any, Any], path: KeyPath) -> list[tuple[str, Any]]:
        for key in mapping:
            if not isinstance(key, str):
                self._refuse(path, f"key {clip(repr(key))} is not text", "write it as a text")
        return [(key, value) for key, value in mapping.items() if isinstance(key, str)]

    def _refuse(self, path: KeyPath, what: str, hint: str) -> None:
        self.faults.append(Fault(self.file, 0, 0, dotted(path), what, hint))
        if len(self.faults) >= MAX_FAULTS:
            raise SpecError(self.faults)

    def _stop(self, path: KeyPath, what: str) -> None:
        fault = Fault(self.file, 0, 0, dotted(path[:4]), what, "a spec holds a few hundred values, a few deep")
        raise SpecError([*self.faults, fault])


def kept_document(document: Document) -> dict[str, Any]:
    """The document as JSON has it. Its folder is absolute, so that maps and parts are found from anywhere."""
    chosen = [
        [list(path), number, list(origin.path)]
        for path, (number, origin) in document.origins.items()
        if origin.document is None
    ]
    return {
        "file": document.file,
        "folder": str(document.folder.absolute()),
        "tree": document.tree,
        "keys": [[list(path), *mark] for path, mark in document.keys.items()],
        "values": [[list(path), *mark] for path, mark in document.values.items()],
        "chosen": chosen,
    }


def read_kept(kept: Mapping[str, Any]) -> Document:
    """The document that ``kept_document`` wrote.

    Raises:
        ValueError, KeyError, TypeError, AttributeError: it is no such document. SpecError: its tree is out of bounds.
    """
    document = document_from(kept["tree"], str(kept["file"]))
    return replace(
        document,
        folder=Path(str(kept["folder"])),
        keys=_marks(kept["keys"]),
        values=_marks(kept["values"]),
        origins={_path(path): (int(number), Origin(_path(origin))) for path, number, origin in kept["chosen"]},
    )


def _marks(entries: Any) -> dict[KeyPath, Mark]:
    return {_path(path): (int(line), int(column)) for path, line, column in entries}


def _path(steps: Any) -> KeyPath:
    return tuple(step if isinstance(step, int) else str(step) for step in steps)
