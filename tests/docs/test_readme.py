"""The README's files and commands, as a newcomer types them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
FILES = re.findall(r"```yaml\n# (\S+)\n(.*?)```", README, re.DOTALL)
COMMANDS = [
    line.split("#")[0].strip()
    for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    for line in block.splitlines()
    if line.startswith("hwsw")
]
ANSWERS = re.findall(r"^\$ (hwsw .+)\n(.+)$", README, re.MULTILINE)


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
        assert hwsw(*command.split()[1:]).stdout == f"{answer}\n"


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


def test_it_takes_one_screen_and_a_half_and_has_a_picture() -> None:
    assert README.count("\n") <= 90
    assert "](docs/pictures/front.png)" in README


@pytest.mark.parametrize("target", re.findall(r"\]\(((?!http)[^)]+)\)", README))
def test_links_lead_somewhere(target: str) -> None:
    assert (ROOT / target).exists()


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"make ([a-z-]+)", README):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
