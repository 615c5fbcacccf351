"""A file as a tree with the place of every key, and edits of the tree that remember who put what where."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from codesign.ground.errors import Fault, clip

KeyPath = tuple[str | int, ...]
"""The path to a node: mapping keys and list indices from the root."""

Mark = tuple[int, int]
"""Line and column, from 1."""

REMOVED: Any = object()
"""Put at a path, it removes the key there."""


@dataclass(frozen=True)
class Origin:
    """The origin of a value that was put into a tree.

    - ``path``: its key in ``document``; without a document, what the user set, in words: ``("--set relax.block",)``.
    """

    path: KeyPath
    document: Document | None = None


@dataclass(frozen=True)
class Document:
    """One file, read; or the tree that edits made of it.

    - ``file``: as the user would name it. ``folder``: relative paths in the file start there.
    - ``tree``: dicts with text keys, lists, and scalars (text, int, float, bool, None).
    - ``keys``, ``values``: the place of each key and of each value of the file, by its path; the root is ``()``.
    - ``faults``: what could not be taken as it stands, with the rest of the file intact.
    - ``spoilt``: places where the tree holds something else than what the file means.
    - ``origins``: where the values come from that edits put into the tree, or removed from it, by path; numbered in the
      order of the edits.
    - ``context``: what validators need besides the file, such as the models of the parameters of tasks.
    """

    file: str
    folder: Path
    tree: Any
    keys: dict[KeyPath, Mark] = field(default_factory=dict)
    values: dict[KeyPath, Mark] = field(default_factory=dict)
    faults: tuple[Fault, ...] = ()
    spoilt: frozenset[Mark] = frozenset()
    origins: Mapping[KeyPath, tuple[int, Origin]] = field(default_factory=dict)
    context: Mapping[str, Any] = field(default_factory=dict)

    def origin(self, path: KeyPath) -> Origin | None:
        """The origin of the value at ``path``; None if it stands in the file itself."""
        if not self.origins:
            return None
        around = [length for length in range(len(path) + 1) if path[:length] in self.origins]
        if not around:
            return None
        last = max(around, key=lambda length: self.origins[path[:length]][0])
        origin = self.origins[path[:last]][1]
        return Origin((*origin.path, *path[last:]), origin.document)

    def value_mark(self, path: KeyPath) -> Mark:
        """The place of the value at ``path``, or of what is around it; (0, 0) where nothing has a place."""
        origin = self.origin(path)
        if origin is not None:
            return origin.document.value_mark(origin.path) if origin.document else (0, 0)
        while path and path not in self.values:
            path = path[:-1]
        return self.values.get(path, (0, 0))

    def key_mark(self, path: KeyPath) -> Mark:
        """The place of the key at ``path``; the place of its value if the key has none."""
        return self.keys.get(path) or self.value_mark(path)

    def fault(self, path: KeyPath, what: str, hint: str | None = None, *, at_key: bool = False) -> Fault:
        """A fault at a value (or, ``at_key``, at its key), reported at the place that the value comes from."""
        origin = self.origin(path)
        if origin is not None and origin.document is not None:
            return origin.document.fault(origin.path, what, hint, at_key=at_key)
        if origin is not None:
            return Fault(dotted(origin.path), 0, 0, "", what, hint)
        line, column = self.key_mark(path) if at_key else self.value_mark(path)
        return Fault(self.file, line, column, dotted(path), what, hint)


def put(document: Document, edits: Mapping[KeyPath, Any], by: Callable[[KeyPath], Origin]) -> Document:
    """The document with values put into its tree; the document itself stays as it is.

    A mapping on a path that is not written out begins empty. A path that leads through something else is left out, and
    is one of the ``faults`` of the new document.

    Args:
        document: what is edited. What no edit touches, the new tree shares with it.
        edits: the values by path, put in that order; ``REMOVED`` removes a key.
        by: where the value at a path comes from. Faults of the value are reported there.
    """
    if not edits:
        return document
    tree, origins, faults = dict(document.tree or {}), dict(document.origins), list(document.faults)
    number = 1 + max((number for number, _ in origins.values()), default=-1)
    copies = {id(tree)}
    for path, value in edits.items():
        origin = by(path)
        mapping, blocked = _mapping_at(tree, path[:-1], copies)
        if blocked:
            what, hint = f"{dotted(blocked)} is not a mapping", "set the whole of it"
            faults.append(Document("", Path(), None, origins={path: (0, origin)}).fault(path, what, hint))
            continue
        if value is REMOVED:
            mapping.pop(path[-1], None)
        else:
            mapping[path[-1]] = value
        origins[path] = number, origin
        number += 1
    places = document.keys, document.values
    return Document(
        document.file, document.folder, tree, *places, tuple(faults), document.spoilt, origins, document.context
    )


def _mapping_at(tree: Any, path: KeyPath, copies: set[int]) -> tuple[Any, KeyPath]:
    """The mapping at a path, for editing; or the first part of the path that holds something else.

    Each mapping on the path is copied. ``copies`` are the identities of those that were copied for these edits before.
    """
    mapping = tree
    for length, step in enumerate(path, 1):
        inner = mapping.get(step)
        if id(inner) not in copies:
            if inner is not None and not isinstance(inner, dict):
                return None, path[:length]
            inner = mapping[step] = dict(inner or {})
            copies.add(id(inner))
        mapping = inner
    return mapping, ()


def leaves(tree: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """Each value inside ``tree`` that is no mapping, and each empty mapping, with its path.

    >>> list(leaves({"a": {"b": 1}, "c": {}}))
    [(('a', 'b'), 1), (('c',), {})]
    """
    if isinstance(tree, dict) and tree:
        for key, value in tree.items():
            yield from leaves(value, (*path, key))
    else:
        yield path, tree


def dotted(path: KeyPath) -> str:
    """The path of a key as users write it.

    >>> dotted(("problem", "goals", 0))
    'problem.goals[0]'
    """
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else clip(step)
    return text
