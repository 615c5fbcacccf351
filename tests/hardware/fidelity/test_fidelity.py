"""Laws against circuits and papers: every row is compared, every mismatch has a reason, and the page is up to date."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from click.testing import Result
from places import ROOT
from rtl_tools import needs

import codesign.hardware.fidelity
from codesign.ground.figures import Figure, Status
from codesign.hardware.fidelity import (
    REASONS,
    SAMPLES,
    Fidelity,
    Spread,
    asked,
    idle,
    measure,
    mismatches,
    reason_of,
    spreads,
)
from codesign.hardware.fidelity.points import TOTAL, Point, known_of, rooms, rows_of
from codesign.hardware.rtl.verify import verify_all
from codesign.views.report.fidelity_page import fidelity_page, fidelity_picture

COMMAND = "hwsw fidelity -o docs/fidelity.md --picture docs/fidelity.svg"
PAGE, PICTURE = ROOT / "docs" / "fidelity.md", ROOT / "docs" / "fidelity.svg"
Run = Callable[..., Result]


@pytest.mark.parametrize("room", rooms())
def test_every_row_has_its_design(room: str) -> None:
    rows = list(rows_of(room))
    assert rows
    lost = [row.variables for row in rows if known_of(room, row) is None]
    assert not lost


def test_the_committed_page_and_picture_are_those_of_the_rows(result: Fidelity) -> None:
    assert PAGE.read_text(encoding="utf-8") == fidelity_page(result, range(SAMPLES), COMMAND, PICTURE.name)
    locked = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    drawn_by = {f"matplotlib=={matplotlib.__version__}", f"numpy=={np.__version__}"}
    if not drawn_by <= {*locked}:
        pytest.skip("another version of matplotlib or NumPy draws another picture")
    # Processors round the last digits of a place differently.
    (words, places), (drawn, points) = map(taken_apart, (PICTURE.read_bytes(), fidelity_picture(result)))
    assert words == drawn
    np.testing.assert_allclose(points, places, rtol=0, atol=1e-5)


def taken_apart(svg: bytes) -> tuple[list[str], list[float]]:
    """The text of a picture around its decimal numbers, and these."""
    parts = re.split(r"(-?\d+\.\d+)", svg.decode())
    return parts[::2], list(map(float, parts[1::2]))


def test_every_mismatch_has_a_reason_and_every_reason_a_mismatch(result: Fidelity) -> None:
    assert [each.key for each in result.mismatches if reason_of(each) is None] == []
    assert [each.what for each in idle(result.mismatches)] == []


def test_no_two_reasons_explain_the_same() -> None:
    assert len({reason.what for reason in REASONS}) == len(REASONS)


def test_a_cause_that_nothing_shows_is_a_likely_one_with_its_experiment() -> None:
    for reason in REASONS:
        assert reason.experiment
        assert reason.words.startswith("Likely: ") != bool(reason.shown)
        for name in re.findall(r"(?:docs|codesign)/[\w/.]+", reason.shown):
            assert list(ROOT.glob(name.replace("ROOM", "*"))), name


@pytest.mark.parametrize("planner", ["breadth_first", "velocity_obstacle"])
def test_some_circuits_of_the_page_equal_the_model(planner: str) -> None:
    needs("cxxrtl")
    few = [each for each in asked(range(1)) if each.style.planner == planner]
    assert all(style.equal for style in verify_all(few))


@pytest.mark.slow
def test_all_circuits_of_the_page_equal_the_model(result: Fidelity) -> None:
    needs("cxxrtl")
    run = measure(range(SAMPLES))
    assert fidelity_page(run, range(SAMPLES), COMMAND) == fidelity_page(result, range(SAMPLES), COMMAND)


def point(predicted: float, measured: float, **others: Any) -> Point:
    """A row of the adder of a toy."""
    figure = Figure(predicted, "1", Status.CALIBRATED, "toy", predicted * 0.95, predicted * 1.05)
    values: dict[str, Any] = {
        "planner": "toy",
        "style": "plain",
        "family": "ecp5",
        "part": "LFE5U-85F-8",
        "design": "2 × 2",
        "variables": {},
        "line": "adder",
        "quantity": "lut4",
        "held": False,
        "present": True,
        "note": "1 seed; a path",
    }
    return Point(predicted=figure, measured=measured, **{**values, **others})


@pytest.mark.parametrize(
    ("rows", "beyond"),
    [
        pytest.param([point(104, 100), point(97, 100)], False, id="near"),
        pytest.param([point(104, 100), point(89, 100)], True, id="one far"),
        pytest.param([point(106, 100), point(106, 100)], True, id="mean"),
        pytest.param([point(150, 100), point(101, 100, held=True)], False, id="held out decides"),
        pytest.param([point(5, 5, quantity="block_rams")], False, id="exact"),
        pytest.param([point(101, 100, quantity="block_rams")], True, id="one block RAM"),
    ],
)
def test_a_term_is_beyond_its_tolerance(rows: list[Point], beyond: bool) -> None:
    (spread,) = spreads(rows, by_family=True)
    assert isinstance(spread, Spread)
    assert spread.beyond == beyond


def keys(*rows: Point) -> set[str]:
    every = {each.key for each in mismatches(rows, (), ())}
    return {key for key in every if not key.startswith("never")}


def test_a_line_a_clock_outside_and_a_wide_clock_are_mismatches() -> None:
    clock = point(100, 103, line="", quantity="clock", without=0.02)
    assert keys(clock) == set()
    assert keys(replace(clock, measured=110)) == {"clock/outside/toy/plain/LFE5U-85F-8"}
    assert keys(replace(clock, without=None)) == {"clock/alone/toy/plain/LFE5U-85F-8"}
    wide = replace(clock, predicted=Figure(100, "Hz", Status.ASSUMED, "toy", 80, 120))
    assert keys(wide) == {"clock/wide/toy/plain/LFE5U-85F-8"}
    assert keys(point(200, 100)) == {"resources/toy/plain/adder/lut4"}
    assert keys(point(200, 100, line=TOTAL)) == set()


def test_the_command_writes_page_and_picture(
    hwsw: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, without_circuits: Callable[..., Any]
) -> None:
    def run(points: list[Any], *_: Any) -> Any:
        return without_circuits(points)

    monkeypatch.setattr(codesign.hardware.fidelity, "verify_all", run)
    page, picture = tmp_path / "page.md", tmp_path / "picture.svg"
    done = hwsw("fidelity", "--quick", "-o", page, "--picture", picture)
    assert done.exit_code == 0, done.output
    assert "](picture.svg)" in page.read_text(encoding="utf-8")
    assert picture.read_bytes().startswith(b"<?xml")
    printed = json.loads(hwsw("fidelity", "--quick", "--json").stdout)
    assert set(printed) == {"cycles", "rows", "papers", "mismatches"}
    assert len(printed["cycles"]) == len(asked(range(1)))


def test_one_file_for_page_and_picture_is_refused(hwsw: Run, tmp_path: Path) -> None:
    done = hwsw("fidelity", "-o", tmp_path / "a", "--picture", tmp_path / "a")
    assert done.exit_code == 2
    assert "--picture" in done.output
