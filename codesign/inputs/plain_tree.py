"""A dict from Python as the document of a spec, under the rules and bounds that a YAML file is read by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from codesign.errors import Fault, SpecError, clip
from codesign.inputs.document import Document, KeyPath, dotted
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
        fault = Fault(
            self.file, 0, 0, dotted(path[:4]), what, "a spec holds a few hundred values, a few deep"
        )
        raise SpecError([*self.faults, fault])
