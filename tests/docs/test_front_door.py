"""CONTRIBUTING.md and docs/index.md: every page is listed, every link and folder is there, every make target exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from places import ROOT

CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
INDEX = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
PAGES = [ROOT / "CONTRIBUTING.md", *(ROOT / "docs" / f"{name}.md" for name in ("index", "architecture", "glossary"))]
LINK = re.compile(r"\]\(((?!http)[^)#]+)[^)]*\)")
LINKS = [(page, target) for page in PAGES for target in LINK.findall(page.read_text(encoding="utf-8"))]


def headings() -> list[str]:
    return re.findall(r"^## (.+)$", CONTRIBUTING, re.MULTILINE)


@pytest.mark.parametrize(("page", "target"), LINKS, ids=lambda value: getattr(value, "name", value))
def test_links_lead_somewhere(page: Path, target: str) -> None:
    assert (page.parent / target).exists()


def test_the_index_lists_every_page() -> None:
    listed = set(LINK.findall(INDEX))
    docs = ROOT / "docs"
    pages = {page.relative_to(docs).as_posix() for page in docs.glob("**/*.md")}
    assert listed >= pages - {"index.md"}


def test_contributing_has_what_a_newcomer_looks_for() -> None:
    assert headings() == [
        "Set-up",
        "Layout",
        "The rule of layers",
        "How to add something",
        "Checks",
        "Commits",
        "Words",
    ]


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"`?\bmake ([a-z-]+)(?=`|  )", CONTRIBUTING))
    assert {"demo", "test", "test-all", "lint", "bench"} <= targets
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


@pytest.mark.parametrize("folder", sorted(set(re.findall(r"`([\w./]+/)`", CONTRIBUTING))))
def test_folders_exist(folder: str) -> None:
    assert (ROOT / folder).is_dir()


def test_the_order_of_a_room_is_that_of_the_layers() -> None:
    from levels import ROOM_ORDER

    (said,) = re.findall(r"order is (`published`.*?), and imports go to the left", CONTRIBUTING)
    names = re.findall(r"`(\w+)`", said)
    assert names[:-1] == [name for name in ROOM_ORDER if name in names]
    assert names[-1] == "plug_in"


def test_the_subject_that_is_shown_is_short_enough() -> None:
    (shown,) = re.findall(r"characters: `(.+)`", CONTRIBUTING)
    assert len(shown) <= 72
