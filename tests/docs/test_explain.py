"""docs/explain.md: its commands print what it shows, and its Python is run."""

from __future__ import annotations

import doctest
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

PAGE = ROOT / "docs" / "explain.md"
TEXT = PAGE.read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```sh\n(.*?)\n```\n\n```text\n(.*?)```", TEXT, re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the workload of the page."""
    block = re.search(r"^```yaml\n(# rooms\.yaml\n.*?)^```", TEXT, re.MULTILINE | re.DOTALL)
    assert block is not None
    (tmp_path / "rooms.yaml").write_text(block[1], encoding="utf-8")
    return tmp_path


def test_commands_print_what_the_page_shows(
    hwsw: Callable[..., Result], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    assert hwsw("explore", "virtex4-pci", folder / "rooms.yaml", "--workers", 1, "-q").exit_code == 0
    assert len(EXAMPLES) == 3
    for command, shown in EXAMPLES:
        program, *arguments = shlex.split(command)
        assert program == "hwsw"
        printed = [" ".join(line.split()) for line in hwsw(*arguments).stdout.splitlines()]
        for line in shown.splitlines():
            assert line == "..." or " ".join(line.split()) in printed
    again = re.search(r"^hwsw (run .*)$", TEXT, re.MULTILINE)
    assert again is not None
    assert hwsw(*shlex.split(again[1])).exit_code == 0
    assert (folder / "thirteen.mcap").is_file()
    assert (folder / "thirteen.html").is_file()


def test_the_python_of_the_page_is_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    failed, tried = doctest.testfile(str(PAGE), module_relative=False)
    assert (failed, tried > 8) == (0, True)
