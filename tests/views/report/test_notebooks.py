"""What a notebook and a prompt show of studies, results, traces and the rest is small, bounded and escaped."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from report_samples import a_fleet, a_fleet_result, a_hopeless_study, a_mission_result, a_result, a_study

import codesign
from codesign.ground.figures import Status
from codesign.planners.reproduction import Finding, Reproduction, Use, row
from codesign.views.report import Cell, Table, comparison_table, front_table
from codesign.views.report.notebooks import MOST_COLUMNS, MOST_ROWS, notebook_html
from codesign.views.report.wording import left, words
from codesign.views.trace.reader import Channel, Trace

EVIL = "<script>alert(1)</script>\x1b[31m"


class Elements(HTMLParser):
    """The names of all elements, which must nest."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.names: list[str] = []
        self.open: list[str] = []
        self.feed(html)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.names.append(tag)
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def a_reproduction(rows: int = 500) -> Reproduction:
    each = row("Table 1", EVIL, 2, 1, status=Status.PUBLISHED, source="a paper", use=Use.HELD_OUT)
    return Reproduction(EVIL * 100, (each,) * rows, (), (Finding(EVIL, {EVIL: EVIL}),))


def shown() -> list[Any]:
    table = Table(EVIL, left(*[EVIL] * 40), tuple(words(*[EVIL * 100] * 40) for _ in range(3000)), (EVIL,) * 90)
    many = replace(a_study(), platform=EVIL * 1000, workload=EVIL)
    return [
        table,
        many,
        a_hopeless_study(),
        a_result(platform=EVIL * 1000),
        a_mission_result(),
        a_fleet_result(a_fleet()),
        comparison_table([("a", a_result()), (EVIL, a_mission_result())]),
        a_reproduction(),
    ]


@pytest.mark.parametrize("thing", shown(), ids=lambda thing: type(thing).__name__)
def test_a_notebook_shows_a_small_escaped_table(thing: Any) -> None:
    html = thing._repr_html_()
    assert "script" not in Elements(html).names
    assert "\x1b" not in html
    assert html.count("<tr>") <= 2 * (MOST_ROWS + 1)
    assert len(html) < 900 * MOST_COLUMNS * MOST_ROWS


@pytest.mark.parametrize("thing", shown(), ids=lambda thing: type(thing).__name__)
def test_a_prompt_shows_one_line(thing: Any) -> None:
    assert len(repr(thing)) < 500
    assert len(repr(thing).splitlines()) == 1


def test_records_of_figures_are_cut() -> None:
    mission = a_mission_result().mission
    assert mission is not None
    assert len(repr(mission)) <= 1003
    assert len(repr(a_result())) < 300


def test_a_trace_and_specs_are_one_line() -> None:
    channels = [Channel(f"/{number}", "schema", "MapRecord", "map", 2) for number in range(1000)]
    assert repr(Trace(Path("run.mcap"), channels=channels)) == "Trace(run.mcap: 1,000 channels, 2,000 messages)"
    assert repr(Trace(Path("run.mcap"), fault="cut")).endswith("0 messages, not complete)")
    assert repr(codesign.load_workload("labyrinth")) == "Workload('labyrinth')"


def test_what_is_left_out_is_said() -> None:
    rows = tuple((Cell(str(number), number),) for number in range(1234))
    html = Table("numbers", left("number"), rows)._repr_html_()
    assert "the first 20 of 1,234 rows" in html
    study = a_study()
    assert front_table(study).rows[0][0].text in notebook_html(study)
    assert len(front_table(study, 1).rows) == 1 < len(study.front)
    assert notebook_html(object()).startswith("<pre>&lt;object")
