"""Small helps for the command line: values typed there, and files to start from."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from codesign.errors import InputError, SpecError
from codesign.spec.locate import data_folder
from codesign.spec.marks import parse_document

_STARTERS = {
    "my-platform.yaml": ("platforms", "virtex4-pci"),
    "my-workload.yaml": ("workloads", "labyrinth"),
}


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


def starting_files() -> dict[str, str]:
    """A platform and a workload to run and change, by file name: the shipped ones under a new name."""
    texts = {}
    for file, (folder, name) in _STARTERS.items():
        text = (data_folder(folder) / f"{name}.yaml").read_text(encoding="utf-8")
        texts[file] = re.sub(
            rf"^name: {name}$", f"name: {file.removesuffix('.yaml')}", text, count=1, flags=re.M
        )
    return texts
