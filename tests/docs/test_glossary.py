"""docs/glossary.md: one sentence a word, in the order of the alphabet, and no word that is not used elsewhere."""

from __future__ import annotations

import re
from functools import cache

import pytest
from places import ROOT

from codesign.ground.figures import RESOURCES, Status

GLOSSARY = ROOT / "docs" / "glossary.md"
TEXT = GLOSSARY.read_text(encoding="utf-8")
ENTRIES = dict(re.findall(r"^- \*\*(.+?)\*\*: (.+)$", TEXT, re.MULTILINE))


@cache
def used_elsewhere() -> str:
    """All pages and all code but the glossary, without marks that stand between the letters of a word."""
    pages = [ROOT / "README.md", *(path for path in (ROOT / "docs").glob("*.md") if path != GLOSSARY)]
    texts = [path.read_text(encoding="utf-8") for path in (*pages, *(ROOT / "codesign").rglob("*.py"))]
    return " ".join(re.sub(r"[_\-\s]+", " ", "\n".join(texts)).lower().split())


def test_every_line_of_the_list_is_an_entry() -> None:
    assert TEXT.count("\n- ") == len(ENTRIES) > 80


def test_entries_stand_in_the_order_of_the_alphabet() -> None:
    names = [name.lower() for name in ENTRIES]
    assert names == sorted(names)


@pytest.mark.parametrize("name", ENTRIES)
def test_an_entry_is_one_sentence(name: str) -> None:
    said = ENTRIES[name]
    assert said.endswith(".")
    assert not re.search(r"\. [A-Z]", said)
    assert said[0].isupper()


@pytest.mark.parametrize("name", ENTRIES)
def test_a_word_is_used_elsewhere(name: str) -> None:
    word = name.lower().replace("-", " ")
    plural = {"axis": "axes"}.get(word, f"{word.removesuffix('um') + 'a' if word.endswith('imum') else word + 's'}")
    assert re.search(rf"\b({re.escape(word)}|{re.escape(plural)})\b", used_elsewhere())


def test_statuses_and_resources_are_explained() -> None:
    kinds = {kind.replace("_", " ").rstrip("s") for kind in RESOURCES} - {"lut4", "multiplier"}
    named = {name.lower().replace("-", " ") for name in ENTRIES}
    assert {*Status, *kinds, "lut"} <= named
