"""A document as JSON, and back: what a store of explored points keeps of each spec, with the place of every key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from codesign.inputs.document import Document, KeyPath, Mark, Origin
from codesign.inputs.plain_tree import document_from


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
        origins={
            _path(path): (int(number), Origin(_path(origin))) for path, number, origin in kept["chosen"]
        },
    )


def _marks(entries: Any) -> dict[KeyPath, Mark]:
    return {_path(path): (int(line), int(column)) for path, line, column in entries}


def _path(steps: Any) -> KeyPath:
    return tuple(step if isinstance(step, int) else str(step) for step in steps)
