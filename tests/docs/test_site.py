"""The pages as a site: it is built without a warning, no link of it is dead, and it asks nothing from outside."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from places import ROOT

from docs.make_site import MODULES, build, contents, notebook_page

# Those that myst-parser and Sphinx's own extensions give each other.
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::PendingDeprecationWarning"),
]

ASKING = {"script": "src", "link": "href", "img": "src", "iframe": "src", "source": "src", "video": "src"}


class Page(HTMLParser):
    """The links of a page, its anchors, and what a browser would load for it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.loaded: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors.update({given.get("id", ""), given.get("name", "")} - {""})
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag in ASKING and ASKING[tag] in given:
            self.loaded.append(given[ASKING[tag]])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built without a warning."""
    for module in ("sphinx", "myst_parser", "furo"):
        pytest.importorskip(module, reason="the site was not built: pip install 'hwsw-codesign[docs]'")
    folder = tmp_path_factory.mktemp("site")
    assert build(folder) == ""
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    return {path: Page(path.read_text(encoding="utf-8")) for path in site.glob("**/*.html")}


def test_every_page_is_built_and_in_the_contents(site: Path) -> None:
    sidebar = (site / "index.html").read_text(encoding="utf-8").partition('class="sidebar-tree"')[2]
    listed = set(re.findall(r'class="reference internal" href="([\w./]+)\.html"', sidebar))
    docs = ROOT / "docs"
    for page in docs.glob("**/*.md"):
        name = page.relative_to(docs).with_suffix("").as_posix()
        assert (site / f"{name}.html").is_file()
        assert name in listed | {"index"}, f"{name} is in no section of docs/index.md"
    assert 'id="search-results"' in (site / "search.html").read_text(encoding="utf-8")
    assert {"CONTRIBUTING", "CHANGELOG", "tour"} <= listed


def inner_links(pages: dict[Path, Page]) -> Iterator[tuple[Path, str, Path, str]]:
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if not parts.scheme:
                target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
                yield path, link, target, unquote(parts.fragment)


def test_no_link_is_dead(pages: dict[Path, Page]) -> None:
    dead = [
        f"{path.name}: {link}"
        for path, link, target, anchor in inner_links(pages)
        if not target.exists() or (anchor and target in pages and anchor not in pages[target].anchors)
    ]
    assert dead == []
    assert len(list(inner_links(pages))) > 1000


def test_nothing_is_asked_from_outside(site: Path, pages: dict[Path, Page]) -> None:
    for path, page in pages.items():
        assert [each for each in page.loaded if re.match(r"\w+:(?<!data:)|//", each)] == [], path
    for sheet in site.glob("**/*.css"):
        asked = re.findall(r"(?:url\(|@import)\s*[\"']?((?:https?:)?//[^)\"']+)", sheet.read_text(encoding="utf-8"))
        assert asked == [], sheet


def test_names_come_from_docstrings_and_are_found(site: Path) -> None:
    text = (site / "reference" / "codesign.html").read_text(encoding="utf-8")
    assert 'id="codesign.simulate"' in text
    assert "Raises" in text
    assert "codesign.views.report.front_picture" in (site / "searchindex.js").read_text(encoding="utf-8") or (
        site / "reference" / "codesign.views.report.html"
    ).read_text(encoding="utf-8").count('id="codesign.views.report.front_picture"')


def test_modules_that_pages_import_from_are_in_the_reference() -> None:
    for page in ("python", "extending"):
        text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
        imported = set(re.findall(r"(?:from|import) (codesign(?:\.\w+)?) ?(?:import|$)", text, re.MULTILINE))
        assert imported
        assert imported <= set(MODULES)


def test_the_contents_follow_the_sections_of_the_index() -> None:
    index = "# Pages\n## One\n[a](a.md) [b](b.md#x)\n## Two\n[b](b.md) [c](d/c.md)\n"
    assert list(contents(index)) == [
        *("```{toctree}", ":hidden:", ":caption: One", "a.md", "b.md", "```", ""),
        *("```{toctree}", ":hidden:", ":caption: Two", "d/c.md", "```", ""),
    ]


def test_the_notebook_becomes_a_page() -> None:
    notebook = json.loads((ROOT / "docs" / "tour.ipynb").read_text(encoding="utf-8"))
    blocks = list(notebook_page(notebook))
    assert blocks[0].startswith("# ")
    assert sum("data:image/png" in block for block in blocks) >= 4
    assert sum(block.startswith("```python") for block in blocks) == sum(
        cell["cell_type"] == "code" for cell in notebook["cells"]
    )


def test_it_opens_on_the_readme_and_finds_guides_first(site: Path) -> None:
    front = (site / "index.html").read_text(encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert re.search(r"<h1>(.*?)<", front)[1] == readme.splitlines()[0].removeprefix("# ")  # type: ignore[index]
    assert front.index('id="install-and-first-run"') < front.index('id="the-pages"') < front.index('id="decide"')
    # Sphinx's script takes this scorer in place of its own.
    assert 'page.startsWith("reference/") || kind === "object"' in "".join(
        path.read_text(encoding="utf-8") for path in site.glob("_static/*.js")
    )
