"""The published tables on the command line."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest
from click.testing import Result

Run = Callable[..., Result]


AUTHORS = {
    "harmonic": "Girau",
    "breadth_first": "Vacariu",
    "wavefront": "Möller",
    "velocity_obstacle": "Dubey",
    "relaxation": "Saudi",
}


@pytest.mark.parametrize(
    "planners",
    [
        pytest.param(("harmonic", "breadth_first", "wavefront", "velocity_obstacle"), id="four"),
        pytest.param((), id="all", marks=pytest.mark.slow),
    ],
)
def test_reproduce_runs_the_papers_asked_for_and_keeps_to_its_schema(
    hwsw: Run, planners: tuple[str, ...], tmp_path: Path
) -> None:
    """Each room's own tests run its paper; the relaxation alone takes longer than the other four."""
    result = hwsw("reproduce", *planners, "--quick", "--json", "--csv", tmp_path / "rows.csv")
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout, parse_constant=pytest.fail)
    jsonschema.validate(printed, json.loads(hwsw("schema", "reproduction").stdout))
    tables = [row["table"] for row in printed["rows"]]
    for planner, author in AUTHORS.items():
        asked_for = not planners or planner in planners
        assert any(table.startswith(author) for table in tables) == asked_for, author
    with (tmp_path / "rows.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(printed["rows"])
    for row, expected in zip(rows, printed["rows"], strict=True):
        assert expected["table"].endswith(row["table"])
        assert row["quantity"] == expected["quantity"]
        assert (float(row["error"]) if row["error"] else None) == expected["error"]
