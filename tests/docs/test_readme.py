"""The README's files and commands, as a newcomer types them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

from docs.make_gallery import gallery

README = (ROOT / "README.md").read_text(encoding="utf-8")
FILES = re.findall(r"```yaml\n# (\S+)\n(.*?)```", README, re.DOTALL)
COMMANDS = [
    line.split("#")[0].strip()
    for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    for line in block.splitlines()
    if line.startswith("hwsw")
]
QUESTION, *ANSWERS = re.findall(r"^\$ (hwsw .+)\n((?:.+\n)+?)(?=\$|```)", README, re.MULTILINE)
FIRST_SCREEN = README.partition("## Install")[0]
DEMO = re.findall(r"^\t\$\(BIN\)/(hwsw .+)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
TRADE = ("Pareto front", "design space", "trade-off", "latency", "worst case", "uncertainty", "metric")
"""Words of the field, by which somebody searches for a tool like this one."""


def test_the_readme_has_files_and_commands() -> None:
    assert [name for name, _ in FILES] == ["board.yaml", "rooms.yaml"]
    assert [command.split()[1] for command in COMMANDS] == ["check", "run", "trace", "explore"]
    assert sum(text.count("\n") for _, text in FILES) <= 20


def test_files_and_commands_work_in_order(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    for name, text in FILES:
        (tmp_path / name).write_text(text, encoding="utf-8")
    for command in COMMANDS:
        program, *arguments = shlex.split(command)
        assert program == "hwsw"
        result = hwsw(*arguments)
        assert result.exit_code == 0, f"{command}\n{result.output}"
    assert (tmp_path / "front.html").stat().st_size > 10_000


def test_the_first_commands_answer_as_it_shows(hwsw: Callable[..., Result]) -> None:
    assert [command.split()[1] for command, _ in ANSWERS] == ["run", "explain"]
    for command, answer in ANSWERS:
        assert hwsw(*command.split()[1:]).stdout == answer


def test_it_begins_with_a_question_that_is_answered(hwsw: Callable[..., Result]) -> None:
    command, answer = QUESTION
    assert README.index(command) < 300
    result = hwsw(*shlex.split(command)[1:])
    assert result.exit_code == 0
    assert answer.split() == " ".join(result.stdout.splitlines()[:2]).split()
    assert "on its fpga" in result.stdout.splitlines()[1].partition(";")[0]
    assert len(FIRST_SCREEN.splitlines()) <= 50


def test_the_first_screen_says_what_is_not_covered() -> None:
    _, said, what = FIRST_SCREEN.partition("**What it does not cover.**")
    assert said
    for word in ("arms", "three dimensions", "gpu", "graded costs", "not held against drives"):
        assert word in what.lower().replace("\n", " "), word


@pytest.mark.parametrize("word", TRADE)
def test_who_searches_for_a_word_of_the_field_finds_it(word: str) -> None:
    """On the first screen, on the list of pages, and on a page of its subject."""
    pages = {path.name: path.read_text(encoding="utf-8").lower() for path in (ROOT / "docs").glob("*.md")}
    pages = {name: " ".join(text.split()) for name, text in pages.items()}
    assert word.lower() in " ".join(FIRST_SCREEN.lower().split())
    assert f"- **{word.lower()}**" in pages["glossary.md"]
    assert word.lower() in pages["index.md"]
    assert any(word.lower() in pages[name] for name in ("exploration.md", "advise.md", "confidence.md"))


def test_the_demo_begins_with_the_question_and_shows_what_works(hwsw: Callable[..., Result]) -> None:
    asked = shlex.split(QUESTION[0])[:-2]
    assert shlex.split(DEMO[0])[: len(asked)] == asked
    assert "arrive=0" not in "".join(DEMO)
    second = shlex.split(DEMO[1].partition(" --trace")[0])
    answered = hwsw(*second[1:])
    assert answered.exit_code == 0
    assert "is feasible" in answered.stdout


def test_the_table_is_that_of_the_comparison(hwsw: Callable[..., Result]) -> None:
    assert "`hwsw compare`" in README
    assert shown_figures() == printed_figures(hwsw("compare").stdout)


def shown_figures() -> list[list[str]]:
    """The README's table of results, a row for each planner."""
    table = [line.strip("|").split(" | ") for line in README.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in row[1:]] for row in table[1:]]


def printed_figures(text: str) -> list[list[str]]:
    """The same figures as ``hwsw compare`` prints them, without multiples and intervals, a row for each design."""
    lines = dict(re.split(r"  +", line.strip(), maxsplit=1) for line in text.splitlines() if "  " in line)
    figures = ["part", "worst plan time", "slices", "energy", "starts that arrive", "path length ratio"]
    columns = [re.split(r"  +", re.sub(r" \([^)]*\)", "", lines[figure])) for figure in figures]
    rows = [list(row) for row in zip(*columns, strict=True)]
    rows[-1][0] = "a host of 3.4 GHz"  # a host has no part
    return rows


def test_it_takes_two_screens_and_begins_with_a_picture() -> None:
    assert README.count("\n") <= 105
    (picture,) = re.findall(r"\]\(docs/(pictures/\S+\.png)\)", FIRST_SCREEN)
    page = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    (shown,) = (each for each in gallery(page) if each.file == picture)
    assert shown.own
    assert shown.commands == (QUESTION[0],)


@pytest.mark.parametrize("target", re.findall(r"\]\(((?!http)[^)]+)\)", README))
def test_links_lead_somewhere(target: str) -> None:
    assert (ROOT / target).exists()


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"make ([a-z-]+)", README):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
