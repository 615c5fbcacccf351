"""docs/synthesis.md shows what its command prints."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable

import pytest
from click.testing import Result
from places import ROOT

PAGE = (ROOT / "docs" / "synthesis.md").read_text(encoding="utf-8")


def test_the_table_of_the_page_is_that_of_its_command(hwsw: Callable[..., Result]) -> None:
    pytest.importorskip("pyosys")
    shown = re.search(r"```sh\nhwsw (synth .*)\n```\n\n```text\n(.*?)\.\.\.\n```", PAGE, re.DOTALL)
    assert shown is not None
    command, table = shown.groups()
    done = hwsw(*shlex.split(command))
    assert done.exit_code == 0, done.output
    assert table in done.output
