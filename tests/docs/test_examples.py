"""Every example of a docstring and of a page runs and shows what it says."""

from __future__ import annotations

import doctest
import re
from importlib import import_module
from pathlib import Path

import pytest
from places import ROOT

PROMPT = re.compile(r"^\s*>>> ", re.MULTILINE)
MODULES = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for folder in ("codesign", "benchmarks")
    for path in (ROOT / folder).rglob("*.py")
    if PROMPT.search(path.read_text(encoding="utf-8"))
)
PAGES = sorted(path for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")] if PROMPT.search(path.read_text("utf-8")))
NEED = {"python.md": "pandas", "exploration.md": "pandas"}
FOLDER = {"explain.md": "the study that its commands make: test_explain.py"}


def test_there_are_examples() -> None:
    assert len(MODULES) > 90
    assert len(PAGES) > 7


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = doctest.testmod(import_module(name))
    assert done.attempted > 0
    assert done.failed == 0


@pytest.mark.parametrize("page", [page for page in PAGES if page.name not in FOLDER], ids=lambda page: page.name)
def test_pages(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if page.name in NEED:
        pytest.importorskip(NEED[page.name])
    monkeypatch.chdir(tmp_path)
    done = doctest.testfile(str(page), module_relative=False)
    assert done.attempted > 0
    assert done.failed == 0
