"""docs/reference: the pages are those that the code makes, and every key says what it is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from codesign.ground.figures import FIGURES
from codesign.inputs.components import COMPONENTS
from codesign.inputs.links import LINKS
from codesign.inputs.map_spec import MAPS
from codesign.inputs.scenario import SCENARIOS
from codesign.system import catalog
from docs.make_reference.boards import PAGE, boards_page
from docs.make_reference.docstrings import markdown, signature_text
from docs.make_reference.pages import FOLDER, SHIPPED, pages

PAGES = pages()
SPOKEN = ("platform.md", "workload.md", "part.md", "host.md", "calibration.md", "prices.md", "result.md", "cli.md")


def test_the_committed_pages_are_those_that_the_code_makes() -> None:
    assert {page.name for page in FOLDER.iterdir()} == set(PAGES)
    for name, text in PAGES.items():
        committed = (FOLDER / name).read_text(encoding="utf-8")
        assert committed == text, f"{name} is out of date: run `make docs`"


def test_the_tables_of_boards_are_those_of_the_files() -> None:
    assert PAGE.read_text(encoding="utf-8") == boards_page(), "boards.md is out of date: run `make docs`"


@pytest.mark.parametrize("name", SPOKEN)
def test_every_key_says_what_it_is(name: str) -> None:
    silent = [line for line in PAGES[name].splitlines() if line.startswith("| `") and line.endswith("|  |")]
    assert not silent


def test_every_kind_has_its_section() -> None:
    for kind in (*COMPONENTS, *LINKS):
        assert f"### `type: {kind}`\n" in PAGES["platform.md"]
    for scenario in SCENARIOS:
        assert f"### `type: {scenario}`\n" in PAGES["workload.md"]
    for generator in MAPS:
        assert f"### `generate: {generator}`\n" in PAGES["workload.md"]
    for figure in FIGURES:
        assert f"| `{figure}` |" in PAGES["workload.md"]
    for planner, tasks in catalog.task_models().items():
        for task, model in tasks.items():
            if planner in SHIPPED and model.model_fields:
                assert f"### Task `{task}` of planner `{planner}`\n" in PAGES["workload.md"]


@pytest.mark.parametrize(
    "row",
    [
        "| `errors.timeout` | time | `1 ms` | Wait before it is sent again. |",
        "| `errors.late.share` | number, at least 0 and below 1 | required | Share of the messages that come late. |",
        "| `cores` | whole number, from 1 to 1,024 | `1` | How many tasks it runs at once. On each core, control runs"
        " before planning. |",
        "| `radius` | figure (length) | `0 m` | Radius of its outline; 0 m is a point. |",
    ],
)
def test_a_row_has_type_bounds_default_and_meaning(row: str) -> None:
    assert row in PAGES["platform.md"].splitlines()


@pytest.mark.parametrize(
    ("page", "target"),
    [
        (name, target)
        for name, text in PAGES.items()
        for target in sorted(set(re.findall(r"\]\(((?!http)[^)]+)\)", text)))
    ],
)
def test_links_lead_somewhere(page: str, target: str) -> None:
    file, _, anchor = target.partition("#")
    place = (FOLDER / file).resolve() if file else FOLDER / page
    assert place.is_file()
    titles = re.findall(r"^#+ (.+)$", place.read_text(encoding="utf-8"), re.M)
    anchors = {re.sub(r"[^\w\- ]", "", title).lower().replace(" ", "-") for title in titles}
    assert not anchor or anchor in anchors


def test_a_docstring_becomes_markdown() -> None:
    text = """What it does, with ``code``.

    Args:
        rows: how many,
            at least 1.
        columns: the same.

    Raises:
        SpecError: one thing. TraceError: another.

    >>> 1 + 1
    2
    """
    assert markdown(text) == (
        "What it does, with `code`.\n\nArguments:\n\n- rows: how many, at least 1.\n- columns: the same.\n\n"
        "Raises:\n\n- SpecError: one thing.\n- TraceError: another.\n\n```python\n>>> 1 + 1\n2\n```"
    )


def test_a_signature_is_written_as_it_is_called() -> None:
    def area(rows: int, /, columns: int = 2, *, path: Path | None = None) -> float:
        raise NotImplementedError

    assert signature_text("area", area) == (
        "area(rows: int, /, columns: int = 2, *, path: Path | None = None) -> float"
    )
