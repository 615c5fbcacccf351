"""docs/confidence.md: its commands print what it shows, and its Python is run."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable

import pytest
from click.testing import Result
from places import ROOT

PAGE = ROOT / "docs" / "confidence.md"
EXAMPLES = re.findall(r"```sh\n(.*?)\n```\n\n```text\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def words(line: str) -> str:
    return " ".join(line.split())


@pytest.mark.parametrize(("command", "shown"), EXAMPLES)
def test_commands_print_what_the_page_shows(
    hwsw: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, command: str, shown: str
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    program, *arguments = shlex.split(command)
    assert program == "hwsw"
    printed = [words(line) for line in hwsw(*arguments).stdout.splitlines()]
    assert len(shown.splitlines()) > 3
    for line in shown.splitlines():
        assert line == "..." or words(line) in printed
