"""``python -m docs.make_site [FOLDER]``: the pages of ``docs`` as a site that needs no network; ``make site`` runs it.

Sphinx builds it from a copy of the pages. Pages stay as a forge shows them: what only a site has is put into the copy,
which is the first page (the README, then the sections of ``docs/index.md``), the tree of contents, the notebook as a
page, and the public names of the package from their docstrings. Its search shows pages that explain before the
reference (``search_scores.js``). Sphinx, myst-parser and furo are the extra ``docs``.
"""

from __future__ import annotations

import base64
import importlib
import json
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import codesign

DOCS = Path(__file__).parent
ROOT = DOCS.parent
# Sphinx has pages of these names itself.
TAKEN = {"search", "genindex", "py-modindex"}
FRONT_PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
MODULES = {
    "codesign": "simulate, explore, explain, open a trace",
    "codesign.ground.figures": "the figures of results",
    "codesign.views.report": "tables, pictures and pages",
    "codesign.study": "studies, stores, executors",
    "codesign.system.verdicts": "how sure a result is",
    "codesign.views.trace": "traces, written and read",
    "codesign.ground.records": "what components say while they run",
    "codesign.maps": "occupancy grids",
    "codesign.views.bags": "ROS 2 bags",
    "codesign.plugin": "what the author of a planner imports",
    "codesign.testing": "the tests that a planner has to pass",
}
SETTINGS: dict[str, Any] = {
    "project": "hwsw codesign",
    "release": codesign.__version__,
    "extensions": ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "docs.make_site"],
    "myst_heading_anchors": 4,
    "root_doc": "index",
    "source_suffix": {".md": "markdown"},
    "html_theme": "furo",
    "html_title": "hwsw codesign",
    "html_copy_source": False,
    # A page that is opened as a file may not read another one, which summaries of what is found need.
    "html_show_search_summary": False,
    "html_search_scorer": str(DOCS / "search_scores.js"),
    "autodoc_member_order": "bysource",
    "autodoc_typehints_format": "short",
    "autodoc_preserve_defaults": True,
    "python_maximum_signature_line_length": 100,
    "napoleon_numpy_docstring": False,
    # Modules hand names on: a type is then found at two places.
    "suppress_warnings": ["ref.python"],
    "toc_object_entries_show_parents": "hide",
}


def build(site: Path, source: Path | None = None) -> str:
    """Build the site into ``site``, and give the warnings, a line each: none where all is well.

    ``source``: the folder to copy the pages to, which is not there yet.

    Raises:
        ImportError: the extra ``docs`` is not installed.
    """
    import io

    from sphinx.application import Sphinx
    from sphinx.util.docutils import docutils_namespace, patch_docutils

    warnings = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, patch_docutils(), docutils_namespace():
        pages = source or Path(folder) / "pages"
        stage(pages)
        trees = Path(folder) / "trees"
        sphinx = Sphinx(pages, None, site, trees, "html", SETTINGS, status=None, warning=warnings, freshenv=True)
        sphinx.build(force_all=True)
    return re.sub(r"\x1b\[[0-9;]*m", "", warnings.getvalue())


def setup(sphinx: Any) -> dict[str, bool]:
    """What Sphinx calls: the drawings of the pages are plain text to it."""
    from pygments.lexers.special import TextLexer

    for drawing in ("picture", "room", "csv"):
        sphinx.add_lexer(drawing, TextLexer)
    return {"parallel_read_safe": True}


def stage(folder: Path) -> None:
    """Copy the pages into ``folder``, which is not there yet, and add what only a site has."""
    if clashes := sorted(TAKEN & {page.stem for page in DOCS.glob("*.md")}):
        raise ValueError(f"a site has pages of its own named {', '.join(clashes)}: rename those of docs")
    shutil.copytree(DOCS, folder, ignore=shutil.ignore_patterns("*.py", "__pycache__", "make_reference"))
    for page in folder.glob("*.md"):
        _write(page, page.read_text(encoding="utf-8").replace("](../", "]("))
    for name in FRONT_PAGES:
        _write(folder / name, (ROOT / name).read_text(encoding="utf-8").replace("](docs/", "]("))
    for page in folder.glob("**/*.md"):
        text = page.read_text(encoding="utf-8").replace("](tour.ipynb)", "](tour.md)")
        text = text.replace("](README.md", "](index.md")
        # What is a file on a forge is a page here.
        _write(page, re.sub(r"\[([\w/]+)\.(?:md|ipynb)\]\(", r"[\1](", text))
    readme, index = folder / "README.md", folder / "index.md"
    listed = index.read_text(encoding="utf-8")
    _write(index, "\n".join((front_page(readme.read_text(encoding="utf-8"), listed), *contents(listed))))
    readme.unlink()
    notebook = json.loads((folder / "tour.ipynb").read_text(encoding="utf-8"))
    _write(folder / "tour.md", "\n\n".join(notebook_page(notebook)))
    _stage_names(folder / "reference")


def _write(page: Path, text: str) -> None:
    page.write_text(text, encoding="utf-8")


def front_page(readme: str, index: str) -> str:
    """The first page of a site: the README, and after it the index of all pages, whose headings go a level down."""
    return "\n".join((readme, re.sub(r"^#", "##", index, flags=re.MULTILINE)))


def contents(index: str) -> Iterator[str]:
    """The tree of contents of a site: each section of the index has the pages that it is the first to link to."""
    seen = {"index.md", "README.md"}
    for section in re.split(r"^## ", index, flags=re.MULTILINE)[1:]:
        pages = dict.fromkeys(re.findall(r"\]\(([\w/]+\.md)[)#]", section))
        new = [page for page in pages if page not in seen]
        seen.update(new)
        yield from ("```{toctree}", ":hidden:", f":caption: {section.splitlines()[0]}", *new, "```", "")


def notebook_page(notebook: dict[str, Any]) -> Iterator[str]:
    """The cells of a notebook as blocks of a page, with what they print and show."""
    first, *rest = ["".join(cell["source"]) for cell in notebook["cells"]]
    yield first
    yield "This page is a notebook: {download}`tour.ipynb`."
    for cell, source in zip(notebook["cells"][1:], rest, strict=True):
        if cell["cell_type"] == "markdown":
            yield source
            continue
        yield f"```python\n{source}\n```"
        for output in cell["outputs"]:
            yield _output_block(output)


def _output_block(output: dict[str, Any]) -> str:
    shown = {kind: "".join(text) for kind, text in output.get("data", {}).items()}
    if "image/png" in shown:
        data = base64.b64encode(base64.b64decode(shown["image/png"])).decode()
        return f'```{{raw}} html\n<img alt="What the cell shows" src="data:image/png;base64,{data}">\n```'
    if "text/html" in shown:
        return f"````{{raw}} html\n{shown['text/html']}\n````"
    return f"```text\n{shown.get('text/plain') or ''.join(output['text'])}\n```"


def _stage_names(folder: Path) -> None:
    """Pages of the public names, which autodoc fills, in place of the one page that a forge shows."""
    rows = [f"| [`{module}`]({module}.md) | {what} |" for module, what in MODULES.items()]
    tree = ["```{toctree}", ":hidden:", *MODULES, "```"]
    _write(folder / "python.md", "\n".join(["# Python", "", "| module | what it has |", "|---|---|", *rows, "", *tree]))
    for module in MODULES:
        chosen = hasattr(importlib.import_module(module), "__all__")
        options = [":members:", *[":imported-members:"] * chosen]
        names = ["```{eval-rst}", f".. automodule:: {module}", *(f"   {each}" for each in options), "```"]
        _write(folder / f"{module}.md", "\n".join([f"# {module}", "", *names, ""]))


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "out" / "site"
    problems = build(target)
    print(problems or f"The site: {target / 'index.html'}", end="" if problems else "\n")
    sys.exit(bool(problems))
