"""Files that platforms refer to by name: parts and hosts, beside the platform file or shipped."""

from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import ValidationInfo

from codesign.ground.errors import Fault, InputError, choose_hint, clip
from codesign.inputs.base import Spec
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.files import data_folder, shown
from codesign.inputs.yaml_tree import read_document

F = TypeVar("F", bound=Spec)

FOLDERS = ("parts", "hosts")
"""The folders beside a platform file, and in the folder of shipped platforms, that have such files."""


class Library(Generic[F]):
    """The files of one kind. Folders are searched in the order given, the shipped one last.

    Args:
        kind: what one of them is, such as ``part``; its folder is named ``parts``.
        model: that the files are validated against.
    """

    def __init__(self, kind: str, model: type[F]) -> None:
        self.kind = kind
        self.model = model
        self._read = functools.lru_cache(maxsize=256)(self._read_afresh)

    @property
    def shipped(self) -> Path:
        """The folder of the shipped files."""
        return data_folder("platforms") / f"{self.kind}s"

    def beside(self, info: ValidationInfo) -> tuple[Path, ...]:
        """The folder beside the file that is being validated."""
        document = (info.context or {}).get("document")
        return (document.folder / f"{self.kind}s",) if document else ()

    def names(self, folders: Sequence[Path] = ()) -> dict[str, Path]:
        """The path of each file, by its name without ``.yaml``."""
        paths: dict[str, Path] = {}
        for folder in (*folders, self.shipped):
            # No folder, no files.
            with contextlib.suppress(OSError):
                found = [name for name in os.listdir(folder) if name.endswith(".yaml")]
                paths |= {stem: folder / name for name in found if (stem := name.removesuffix(".yaml")) not in paths}
        return paths

    def find(self, name: str, folders: Sequence[Path] = ()) -> F:
        """The file of that name.

        Raises:
            InputError: no such file; with the nearest one and the list.
            SpecError: a faulty file.
        """
        paths = self.names(folders)
        if name not in paths:
            raise InputError(f"there is no {self.kind} {clip(name)!r}", hint=choose_hint(clip(name, 60), paths))
        return self.load(paths[name])

    def load(self, path: Path) -> F:
        """A file; read once a process as long as it does not change.

        Raises:
            SpecError: all the faults of the file.
        """
        try:
            state = path.stat()
        except OSError:
            return self._read(path, 0, 0)
        return self._read(path, state.st_mtime_ns, state.st_size)

    def state(self, names: Sequence[str], folders: Sequence[Path] = ()) -> tuple[tuple[int, int], ...]:
        """The times of change and the sizes of the files of these names: what is kept of them holds for this alone."""
        states = []
        for folder in (*folders, self.shipped):
            for name in names:
                with contextlib.suppress(OSError, ValueError):
                    state = os.stat(f"{folder}/{name}.yaml")
                    states.append((state.st_mtime_ns, state.st_size))
        return tuple(states)

    def _read_afresh(self, path: Path, _modified: int, _size: int) -> F:
        document = read_document(path, shown(path))
        return validate(self.model, document, also=self._name_fault).with_document(document)

    def _name_fault(self, document: Document) -> list[Fault]:
        """They are found by the names of their files, so the two have to agree."""
        name = document.tree.get("name") if isinstance(document.tree, dict) else None
        expected = Path(document.file).stem
        if not isinstance(name, str) or name == expected:
            return []
        hint = f"give file and {self.kind} the same name"
        return [document.fault(("name",), f"{clip(name)!r} in file {expected}.yaml", hint)]
