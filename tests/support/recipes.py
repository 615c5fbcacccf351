"""Toys in a copy of the tree: each adds what a row of docs/architecture.md says, in the files that it names alone."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from levels import ROOMS
from places import ROOT

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def copy_tree(folder: Path) -> None:
    """Copy the tree into a folder. Compiled modules and kernels come along, valid as long as their sources."""
    for name in ("codesign", "docs", "platforms", "workloads", "tests"):
        shutil.copytree(ROOT / name, folder / name, ignore=_not_compiled if name == "codesign" else _COMPILED)
    shutil.copy(ROOT / "pyproject.toml", folder)


_COMPILED = shutil.ignore_patterns("__pycache__")


def _not_compiled(folder: str, names: list[str]) -> list[str]:
    """The names in a folder of compiled files that others write at this moment: they may be gone the next."""
    inside = Path(folder).name == "__pycache__"
    return [name for name in names if inside and Path(name).suffix not in {".nbi", ".nbc", ".pyc"}]


def python_in(folder: Path, *arguments: str) -> str:
    """What Python prints in a copy of the tree."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


class Recipe:
    """The files that a row of the page names, in a copy of the tree. A folder that has a copy already keeps it."""

    def __init__(self, folder: Path, row: str) -> None:
        self.folder = folder
        (cells,) = re.findall(rf"^\| {re.escape(row)} \| (.*?) \|", PAGE, re.MULTILINE)
        named = re.findall(r"`([^`]*(?:\.\w+|/))`", cells)
        self.named = {name.replace("ROOM", room) for name in named for room in ROOMS}
        if (folder / "codesign").exists():
            return
        copy_tree(folder)

    def edit(self, name: str, *changes: tuple[str, str]) -> None:
        """Put text in front of the only place of a mark in a named file; at its end for an empty mark."""
        assert name in self.named, f"the row does not name {name}"
        path = next(path for path in (self.folder / name, self.folder / "codesign" / name) if path.exists())
        text = path.read_text(encoding="utf-8")
        for mark, added in changes:
            assert not mark or text.count(mark) == 1, f"{name} has {text.count(mark)} times {mark!r}"
            text = text.replace(mark, added + mark) if mark else text + added
        path.write_text(text, encoding="utf-8")

    def write(self, name: str, text: str) -> None:
        """Write a new file beside a named one or into a named folder, of the root of the tree or of the package."""
        folder = name.rpartition("/")[0] + "/"
        assert any(each.startswith(folder) for each in self.named), f"the row does not name {folder}"
        base = self.folder if (self.folder / folder).is_dir() else self.folder / "codesign"
        (base / name).write_text(text, encoding="utf-8")

    def python(self, *arguments: str) -> str:
        """What Python prints in the copy."""
        return python_in(self.folder, *arguments)
