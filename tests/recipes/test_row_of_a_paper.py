"""A row of a paper is an entry in its sheet, and a measure: reproductions, findings, pages and fidelity then see it."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

from codesign.planners.papers import Case, Paper, Runs, Words
from codesign.planners.reproduction import Reproduction
from codesign.planners.wavefront.paper.measures import PAPER
from codesign.views.report.reproduction_page import reproduction_html

ROW = "a row of a paper"
"""The row of docs/architecture.md that this holds."""

ENTRY = """\
parts:
  - rows:
      - place: Table 9
        what: nodes of the toy
        published: 60
        measure: toy
        status: measured
        use: held out
        source: counted, {side} a side
        note: "{words}"
        circuit: {name: toy nodes, measure: toy}
"""
FINDING = """\
findings:
  - says: A toy has more nodes than the paper says.
    measure: toy
    figures: {nodes: "{value}"}
"""


def toy(runs: Runs, case: Case) -> Words:  # type: ignore[type-arg]
    """The nodes of the toy."""
    return {"value": 64, "words": "a quick run" if runs.quick else "a run", "holds": case.side > 0}


@pytest.fixture
def paper(tmp_path: Path) -> Paper:
    sheet = PAPER.path.read_text(encoding="utf-8")
    sheet = sheet.replace("parts:\n", ENTRY, 1).replace("findings:\n", FINDING, 1)
    (tmp_path / "rows.yaml").write_text(sheet, encoding="utf-8")
    made = Paper(tmp_path / "rows.yaml", PAPER.printed, PAPER.runs, PAPER.settings)
    made.measures |= PAPER.measures
    made.measure(toy)
    return made


def test_reproductions_and_their_page_have_the_row_and_the_finding(paper: Paper) -> None:
    runs = PAPER.runs(True, lambda _line: None, PAPER.settings())
    (row,) = paper.rows(runs, {"Table 9"})
    assert (row.quantity, row.published, row.modelled, row.note) == ("nodes of the toy", 60, 64, "a quick run")
    assert row.source == "counted, 256 a side"
    first = next(paper.findings(runs))
    assert (first.statement, first.figures) == ("A toy has more nodes than the paper says.", {"nodes": "64"})
    page = reproduction_html([Reproduction(paper.sheet.paper, (row,), (), (first,))])
    assert "nodes of the toy" in page
    assert first.statement in page


def test_fidelity_has_the_row_with_what_circuits_count(paper: Paper, monkeypatch: pytest.MonkeyPatch) -> None:
    claims = import_module("codesign.hardware.fidelity.claims")
    monkeypatch.setattr(claims, "PAPERS", (paper,))
    monkeypatch.setitem(claims.MEASURES, "toy", lambda _points, _case: claims.Counted(64, 66, "counted"))
    monkeypatch.setattr(paper, "row", lambda *_: None)
    claim = next(each for each in claims.claims([]) if each.name == "toy nodes")
    assert (claim.name, claim.place, claim.published) == ("toy nodes", "Möller and Paschke 1998, Table 9", 60)
    assert claim.error == pytest.approx(0.1)
    assert claim.how == "counted"
