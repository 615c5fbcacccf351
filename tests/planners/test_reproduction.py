"""What a published figure was used for: said at every row, and never of a figure that the paper does not give."""

from __future__ import annotations

from pathlib import Path

import pytest

from codesign.ground.errors import InputError, SpecError
from codesign.ground.figures import Status
from codesign.hardware.fidelity.claims import MEASURES, PAPERS
from codesign.planners.papers import Paper, Runs, printed, read_sheet
from codesign.planners.relaxation.paper.measures import PAPER as RELAXATION
from codesign.planners.reproduction import Printed, Settings, Use, row, silent
from codesign.planners.velocity_obstacle.paper.measures import PAPER, RobotsRuns
from codesign.planners.velocity_obstacle.published import VelocityObstacleSettings

EVERY = (*PAPERS, RELAXATION)
SHEET = """\
paper: Nobody 2026, A toy
quick: A quick run.
tables:
  Times:
    columns: [side, microseconds]
    rows:
      - [10, 2.5]
      - [20, 10.5]
parts:
  - place: Table 1
    each: Times
    measure: law
    status: calibrated
    source: a law of {side} cells
    rows:
      - what: time, {side}×{side}
        published: "{microseconds}"
        over: 1000000
        unit: s
        use: fitted
        note: "{words}"
findings:
  - says: It holds.
    measure: law
    figures: {first: "{words}"}
"""


def named_measures(paper: Paper) -> set[str]:
    """The measures that a sheet names."""
    rows = {entry.measure for part in paper.sheet.parts for entry in part.entries if entry.measure}
    cases = {part.each for part in paper.sheet.parts if part.each and part.each not in paper.tables}
    return rows | cases | {each.measure for each in (*paper.sheet.findings, *paper.sheet.plots)}


@pytest.mark.parametrize("paper", EVERY, ids=lambda paper: paper.path.parent.parent.name)
def test_rows_name_the_measures_that_are_there_and_no_measure_is_idle(paper: Paper) -> None:
    assert named_measures(paper) == set(paper.measures)


def test_what_circuits_have_names_the_measures_of_fidelity() -> None:
    entries = [entry for paper in EVERY for part in paper.sheet.parts for entry in part.entries]
    assert {each.circuit.measure for each in entries if each.circuit} == set(MEASURES)


def toy(folder: Path, text: str = SHEET) -> Paper:
    """A paper of one table."""
    (folder / "rows.yaml").write_text(text, encoding="utf-8")
    paper = Paper(folder / "rows.yaml", Printed("Nobody 2026", {}, {}), Runs, Settings)

    def law(_runs: object, case: object) -> dict[str, object]:
        return {"value": vars(case).get("side", 0) / 5e6, "words": "by the law"}

    paper.measure(law)
    return paper


def test_a_row_of_a_table_is_compared_with_its_measure(tmp_path: Path) -> None:
    rows = toy(tmp_path)().rows
    assert [(each.quantity, each.published, each.modelled) for each in rows] == [
        ("time, 10×10", 2.5 / 1e6, 10 / 5e6),
        ("time, 20×20", 10.5 / 1e6, 20 / 5e6),
    ]
    assert (rows[0].source, rows[0].note, rows[0].use) == ("a law of 10 cells", "by the law", Use.FITTED)
    assert toy(tmp_path)(quick=True).note == "A quick run."
    assert printed("3", 10, {}) == "3"


@pytest.mark.parametrize(
    ("old", "new", "place", "told"),
    [
        ("        use: fitted\n", "", "16:9", "there is no use"),
        ("[20, 10.5]", "[20]", "8:9", "1 values for 2 columns"),
        ("quick: A quick run.", "quik: A", "2:1", "quik"),
        ("published: ", "printed: ", "17:9", "printed"),
        ("says: It holds.", "says: [1]", "23:11", "says"),
        ("paper: Nobody", "paper: &a Nobody", "1:8", "anchor"),
    ],
)
def test_a_fault_of_a_sheet_has_its_place(tmp_path: Path, old: str, new: str, place: str, told: str) -> None:
    file = tmp_path / "rows.yaml"
    assert SHEET.count(old) == 1
    file.write_text(SHEET.replace(old, new), encoding="utf-8")
    with pytest.raises(SpecError) as caught:
        read_sheet(file)
    assert f"{file}:{place}" in str(caught.value)
    assert told in str(caught.value)


def test_a_measure_that_is_not_there_is_told_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no measure is named 'lax'[\s\S]*did you mean law"):
        toy(tmp_path, SHEET.replace("measure: law", "measure: lax"))()


def test_a_figure_that_is_not_published_has_nothing_to_hold_out() -> None:
    for published, use in ((None, Use.HELD_OUT), (None, Use.FITTED), (None, Use.KNOWN), (3.0, Use.NOTHING)):
        with pytest.raises(ValueError, match="published"):
            row("T", "q", published, 1.0, status=Status.MEASURED, source="s", use=use)
    assert row("T", "q", "-", 1.0, status=Status.MEASURED, source="s", use=Use.NOTHING).use is Use.NOTHING


def test_figures_that_a_rule_was_chosen_in_view_of_are_not_held_out() -> None:
    runs = RobotsRuns(True, silent, VelocityObstacleSettings())
    vars(runs)["single"] = {}
    places = {"Section III", "Section VI", "Table III"}
    uses = {row.quantity: row.use for row in PAPER.rows(runs, places)}
    assert [uses[f"hybrid, {robots} robots, on XC3S500E"] for robots in (2, 4, 8)] == [
        Use.FITTED,
        Use.KNOWN,
        Use.HELD_OUT,
    ]
    assert uses["power, 8 robots, hybrid"] is Use.NOTHING
    assert {use for name, use in uses.items() if name.startswith("cycles of")} == {Use.HELD_OUT}
