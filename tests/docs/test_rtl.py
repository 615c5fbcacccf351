"""docs/rtl.md: its commands have the output that the page shows, and its table names every option."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable

import pytest
from click.testing import Result
from places import ROOT
from rtl_tools import needs

from codesign.cli import requests
from codesign.cli.request import command_of
from codesign.hardware.rtl.design import PREFIX

Run = Callable[..., Result]

PAGE = (ROOT / "docs" / "rtl.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^```console\n\$ hwsw (.*?)\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


def without_digest(text: str) -> list[str]:
    """The lines; the digest of a top moves with every change of the Verilog."""
    return [line.rstrip() for line in re.sub(rf"{PREFIX}[0-9a-f]{{12}}", "TOP", text).splitlines()]


@pytest.mark.slow
@pytest.mark.parametrize(("command", "output"), COMMANDS)
def test_a_command_has_the_output_of_the_page(hwsw: Run, command: str, output: str) -> None:
    needs("cxxrtl")
    result = hwsw(*shlex.split(command))
    assert result.exit_code == 0, result.output
    assert without_digest(result.stdout) == without_digest(output)


def test_the_table_names_every_option() -> None:
    rows = re.findall(r"^\| (`--.*?) \|", PAGE, re.MULTILINE)
    named = {name for row in rows for name in re.findall(r"--[a-z]+", row)}
    command = command_of("verify", requests.COMMANDS)
    options = {name for parameter in command.params for name in parameter.opts if name.startswith("--")}
    assert named == options - {"--set", "--point", "--debug"}
