"""A power says of what it is, wherever it is printed: of an FPGA, of a processor, or of a board at its plug."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import pytest
from click.testing import Result
from report_samples import a_fleet_result, a_result

from codesign.ground.figures import FIGURES
from codesign.views.report import Table, result_tables

OF = re.compile(r"\b(FPGAs?|processors?|plug|boards?|parts?|components?|robots?|links?|memor)")
RUNS = (
    "run virtex2pro breadth-first -v",
    "run pc-3400mhz floor-plan -v",
    "advise house --goal 0.0,-0.5 --rate 3kHz --boards raspberry-pi-4 --on host",
)


def heads(table: Table) -> Iterator[str]:
    yield from (column.name for column in table.columns)
    yield from (row[0].text for row in table.rows if row)


def bare(texts: Iterator[str]) -> list[str]:
    """The headings and labels with a power of nothing."""
    return [text for text in texts if re.search(r"\bpower\b", text) and not OF.search(text)]


def test_no_heading_and_no_row_has_a_power_of_nothing() -> None:
    for result in (a_result(), a_fleet_result()):
        assert bare(text for table in result_tables(result) for text in heads(table)) == []


def test_no_declared_figure_is_a_power_of_nothing() -> None:
    assert bare(figure.label for figure in FIGURES.values()) == []
    assert bare(iter(["static power", "power at plug", "FPGA power"])) == ["static power"]


@pytest.mark.parametrize("command", RUNS)
def test_no_line_that_a_command_prints_begins_with_a_power_of_nothing(
    hwsw: Callable[..., Result], command: str
) -> None:
    printed = hwsw(*command.split()).stdout
    cells = [re.split(r"  +", line.strip()) for line in printed.splitlines()]
    named = [cell for row in cells for cell in row if re.fullmatch(r"[\w ]*\bpower\b[\w ]*", cell)]
    assert named
    assert bare(text for text in named if text != "Clock and power") == []
