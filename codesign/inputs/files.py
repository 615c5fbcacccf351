"""The folders of the shipped platforms, parts and workloads, and the ways to name a spec: by name or by path."""

from __future__ import annotations

import functools
import math
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from codesign.ground.errors import Fault, InputError, SpecError, choose_hint, clip, show
from codesign.inputs.document import Document, KeyPath, Mark, Origin, dotted
from codesign.inputs.yaml_tree import MAX_DEPTH, MAX_FAULTS, MAX_NODES, parse_document, read_document

Source = str | Path | Mapping[str, Any] | Document
"""The forms of a spec that a user names or gives: a shipped name, a path, YAML text (of several lines), or a dict; or
its document, read before."""


_OTHER = {"platforms": "workloads", "workloads": "platforms"}
_SWAPPED = "are the two files swapped? the platform comes first"


def data_folder(name: str) -> Path:
    """The folder of shipped data, ``platforms`` or ``workloads``: the checkout's, or else the wheel's."""
    return _data_folder(name, __file__)


@functools.cache
def _data_folder(name: str, module: str) -> Path:
    package = Path(module).resolve().parent.parent
    checkout = package.parent
    return (checkout if (checkout / "pyproject.toml").is_file() else package) / name


def shipped_names(folder: str) -> list[str]:
    """Names of the YAML files of a folder of shipped data, sorted."""
    return sorted(path.stem for path in data_folder(folder).glob("*.yaml"))


def is_path(source: str | Path) -> bool:
    """True if a user's word for a spec is a path: it has a separator or ends in .yaml or .yml."""
    if isinstance(source, Path):
        return True
    return "/" in source or os.sep in source or source.endswith((".yaml", ".yml"))


def find_spec(source: Any, folder: str) -> tuple[Path, str]:
    """The file that a user means by a name or a path, on the command line and in files; and its name in messages.

    Args:
        source: a shipped name (``virtex4-pci``) or a path; anything else is refused.
        folder: ``platforms`` or ``workloads``.

    Raises:
        InputError: no such name; with the nearest one and the list.
    """
    kind, other = folder.removesuffix("s"), _OTHER[folder]
    if not isinstance(source, str | Path):
        hint = f"write the name of a shipped {kind}, or a file: ./mine.yaml"
        raise InputError(f"{show(source)} names no {kind}", hint=hint)
    if is_path(source):
        return Path(source), str(source)
    names = shipped_names(folder)
    if str(source) not in names:
        if str(source) in shipped_names(other):
            what = f"{source} is a {other.removesuffix('s')}, and a {kind} is asked for"
            raise InputError(what, hint=_SWAPPED)
        hint = f"{choose_hint(clip(str(source), 60), names)}; or name a file, such as ./mine.yaml"
        raise InputError(f"there is no shipped {kind} {clip(str(source))!r}", hint=hint)
    path = data_folder(folder) / f"{source}.yaml"
    return path, shown(path)


def read_spec(source: Source, folder: str) -> Document:
    """The document of a spec: of a file, of YAML text, or of a dict.

    Args:
        source: a shipped name (``virtex4-pci``), a path (with a separator or ``.yaml``), YAML text (with a line break),
            or a dict. Paths inside a text or a dict are relative to the current folder.
        folder: ``platforms`` or ``workloads``.

    Raises:
        InputError: no such name. SpecError: the file, text or dict cannot be read, or is of the other kind.
    """
    kind, other = folder.removesuffix("s"), _OTHER[folder].removesuffix("s")
    document = document_of(source, kind, lambda name: find_spec(name, folder))
    # All its other keys would be faults too.
    if isinstance(document.tree, dict) and document.tree.get("kind") == other:
        raise SpecError([document.fault(("kind",), f"this is a {other}, and a {kind} is asked for", _SWAPPED)])
    return document


def document_of(source: Source, kind: str, find: Callable[[str | Path], tuple[Path, str]]) -> Document:
    """The document of a source: of a file, of YAML text, or of a dict.

    ``find``: the file that a user means by a word, and its name in messages. ``kind``: what it is, for messages.

    Raises:
        SpecError: it cannot be read.
    """
    if isinstance(source, Document):
        return source
    if isinstance(source, Mapping):
        return document_from(source, f"{kind} dict")
    if isinstance(source, str) and "\n" in source:
        return parse_document(source.encode("utf-8", "surrogateescape"), f"{kind} text", Path())
    return read_document(*find(source))


def shown(path: Path) -> str:
    """The path as seen from the current folder where it lies below it, else whole."""
    try:
        return str(path.relative_to(Path.cwd()))
    except (ValueError, OSError):
        return str(path)


_STARTERS = {"my-platform.yaml": ("platforms", "virtex4-pci"), "my-workload.yaml": ("workloads", "labyrinth")}


def parse_value(text: str, where: str) -> Any:
    """A value typed on the command line, by the rules of a spec file: ``6``, ``[36, 66]``, ``100 MHz``.

    Raises:
        InputError: no YAML value; ``where`` says where it was typed.
    """
    if not text.strip():
        raise InputError("no value", where, "write one, as in a YAML file")
    try:
        document = parse_document(text.encode("utf-8", "surrogateescape"), where, Path())
    except SpecError as error:
        first = error.faults[0]
        raise InputError(first.what, where, first.hint) from None
    for first in document.faults:
        raise InputError(first.what, where, first.hint)
    return document.tree


@dataclass(frozen=True)
class ShippedFile:
    """A file that ships: its kind (``platform``, ``part``, ``workload`` or ``map``), a name of it, and its path."""

    kind: str
    name: str
    path: Path

    def __str__(self) -> str:
        return f"{self.kind}:{self.name}"


def shipped_files() -> list[ShippedFile]:
    """Every shipped file under each of its names. A map has its file name too."""
    platforms, workloads = data_folder("platforms"), data_folder("workloads")
    kinds = {
        "platform": platforms.glob("*.yaml"),
        "part": (platforms / "parts").glob("*.yaml"),
        "host": (platforms / "hosts").glob("*.yaml"),
        "workload": workloads.glob("*.yaml"),
        "map": (workloads / "maps").iterdir(),
    }
    files = [ShippedFile(kind, path.stem, path) for kind, paths in kinds.items() for path in sorted(paths)]
    # An image is named after its description where it has one.
    described = {each.path.with_suffix("") for each in files if each.path.suffix == ".yaml"}
    named = [each for each in files if each.path.suffix == ".yaml" or each.path.with_suffix("") not in described]
    return named + [ShippedFile("map", each.path.name, each.path) for each in files if each.kind == "map"]


def find_map(name: str) -> Path:
    """The map that a user means: a file, or else a shipped map of that name, with or without its suffix.

    A name that is neither is a path that does not exist.
    """
    path = Path(name)
    if path.exists():
        return path
    return shipped_maps().get(name, path)


def shipped_maps() -> dict[str, Path]:
    """The path of every shipped map, under its name and its file name."""
    return {each.name: each.path for each in shipped_files() if each.kind == "map"}


def find_shipped(name: str) -> Path:
    """The shipped file of a name, or of ``KIND:NAME`` where files of several kinds have the name.

    A part is found by its name with a speed grade too.

    Raises:
        InputError: no file has this name, with the nearest one; or several have it.
    """
    files = shipped_files()
    ungraded = name.rpartition("-")[0].removeprefix("part:")
    matches = [each for each in files if name in (each.name, str(each))]
    matches = matches or [each for each in files if each.kind == "part" and each.name == ungraded]
    if not matches:
        hint = choose_hint(clip(name, 60), {each.name for each in files})
        raise InputError(f"no shipped file is named {clip(name)!r}", hint=hint)
    if len({each.path for each in matches}) > 1:
        choices = ", ".join(sorted({str(each) for each in matches}))
        raise InputError(f"several shipped files are named {clip(name)!r}", hint=f"write one of {choices}")
    return matches[0].path


def starting_files() -> dict[str, str]:
    """A platform and a workload to run and change, by file name: the shipped ones under a new name."""
    return {file: renamed(folder, name, Path(file).stem) for file, (folder, name) in _STARTERS.items()}


def renamed(folder: str, source: str, new: str) -> str:
    """The text of a file of ``platforms`` or ``workloads`` (see ``find_spec``) under a new name."""
    text = find_spec(source, folder)[0].read_text(encoding="utf-8")
    return re.sub(r"^name:.*$", f"name: {new}", text, count=1, flags=re.M)


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
