"""docs/advise.md: its worked question has the output that the page shows, and its table names every option."""

from __future__ import annotations

import re
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

from codesign.cli.request import command_of
from codesign.cli.requests import COMMANDS

Run = Callable[..., Result]

PAGE = ROOT / "docs" / "advise.md"
QUESTION = re.compile(r"^```console\n\$ hwsw (.*?)\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.mark.slow
def test_the_worked_question_has_the_output_of_the_page(
    hwsw: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv(
        "SOURCE_DATE_EPOCH", "1795478400"
    )  # the page is of 24 November 2026, as the age of its prices is
    command, output = QUESTION.findall(PAGE.read_text(encoding="utf-8"))[0]
    words = shlex.split(command)
    (tmp_path / words[1]).parent.mkdir(parents=True)
    shutil.copy(ROOT / words[1], tmp_path / words[1])
    result = hwsw(*words)
    assert result.exit_code == 0, result.output
    lines = [line.rstrip() for line in result.stdout.splitlines()]
    assert lines == output.splitlines()


def test_the_table_names_every_option() -> None:
    named = set(re.findall(r"^\| `(--[a-z]+)`", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    command = command_of("advise", COMMANDS)
    options = {name for parameter in command.params for name in parameter.opts if name.startswith("--")}
    assert named == options - {"--json"}
