"""The tables of Dubey et al. (2013): platform, rows, runs and findings."""

from __future__ import annotations

import pytest
from findings_page import check_figures, check_statements, figures

from codesign.inputs import load_platform
from codesign.planners.reproduction import Reproduction, Use
from codesign.planners.velocity_obstacle import published
from codesign.planners.velocity_obstacle.paper.measures import PAPER


def test_the_platform_is_the_board_of_the_paper() -> None:
    platform = load_platform("nexys2")
    component = platform.components["fpga"]
    assert component.clock.value == published.CLOCK
    assert component.part.startswith(published.PART)


@pytest.fixture(scope="module")
def reproduction() -> Reproduction:
    return PAPER(quick=True)


def test_every_row_of_the_paper_is_there(reproduction: Reproduction) -> None:
    tables = [row.table for row in reproduction.rows]
    assert (tables.count("Table I"), tables.count("Table II"), tables.count("Table III")) == (9, 9, 9)
    held_out = [
        row
        for row in reproduction.rows
        if row.use is Use.HELD_OUT and row.table == "Table III" and row.error is not None
    ]
    assert len(held_out) == 2
    known = [row.quantity for row in reproduction.rows if row.use is Use.KNOWN]
    runs = [f"{robots} robots, full run: updates" for robots in (2, 4, 8)]
    assert known == ["hybrid, 4 robots, on XC3S500E", *runs]
    assert all(abs(row.error or 1.0) < 0.04 for row in held_out)
    assert all(row.error == 0 for row in reproduction.rows if row.table == "Table II")
    fits = {row.quantity: (row.published, row.modelled) for row in reproduction.rows if "on XC3S500E" in row.quantity}
    assert all(said == found for said, found in fits.values())
    assert len(fits) == 3


def test_runs_of_the_reproduction_have_no_collision(reproduction: Reproduction) -> None:
    rows = {row.quantity: row.modelled for row in reproduction.rows}
    for robots in (2, 4, 8):
        assert rows[f"{robots} robots, full run: collisions"] == 0
        assert rows[f"{robots} robots, full run: robots that arrived"] == robots
        assert 400 <= rows[f"{robots} robots, full run: updates"] <= 500
    share = rows["same velocity chosen in fixed point and in doubles"]
    assert isinstance(share, float)
    assert share > 90.0


def test_findings_are_made_from_the_data(reproduction: Reproduction) -> None:
    check_statements(reproduction)
    same = ["A power law", "The sequential", "The pipelined", "The LUTs", "The hybrid", "Six products"]
    check_figures(reproduction, [*same, "Table II", "The serial port", "Reconfiguring"])
    assert figures(reproduction, "Equation 4")["and a margin of one cell: collisions"] == "0"
    assert figures(reproduction, "Where 16 bits")["beyond the bound"] == "0"
    assert reproduction.note.startswith("A quick run")
    assert {plot.name for plot in reproduction.figures} == {"dubey2013-cycles", "dubey2013-power", "dubey2013-ways"}
