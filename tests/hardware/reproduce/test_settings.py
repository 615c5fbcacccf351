"""The settings of the papers' runs: declared by each room, checked, and marked on what comes out."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest
from click.testing import Result

from codesign.ground.errors import SpecError
from codesign.planners.reproduction import Reproduction, Settings, Use, row
from codesign.planners.velocity_obstacle.published import VelocityObstacleSettings
from codesign.planners.wavefront.paper.measures import SAMPLES
from codesign.planners.wavefront.published import SampleName
from codesign.system import catalog
from codesign.system.inspect import paper_settings, settings_by_paper

Run = Callable[..., Result]
PAPERS = tuple(catalog.papers())


def test_every_paper_declares_settings_that_are_published_by_default() -> None:
    for name in PAPERS:
        model = catalog.paper_settings(name)
        assert model.model_fields, name
        assert model().moved() == {}
    for each in paper_settings(PAPERS):
        assert "published rows: " in each.meaning
        assert each.accepted


def test_the_maps_of_the_wavefront_are_those_of_its_paper() -> None:
    assert get_args(SampleName) == tuple(SAMPLES)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"seed": 3}, "--set seed: there is no such setting\n  hint: did you mean seeds? accepted: labyrinth_seeds"),
        ({"seeds": 0}, "--set seeds: 0 is out of bounds\n  hint: it must be at least 1"),
        ({"seeds": "two"}, "--set seeds: 'two' is not a whole number"),
        ({"sor_omegas": [3]}, "--set sor_omegas[0]: 3 is out of bounds"),
        ({"maze_seeds": []}, "--set maze_seeds: "),
    ],
)  # fmt: skip
def test_mistakes(values: dict[str, object], told: str) -> None:
    with pytest.raises(SpecError) as caught:
        settings_by_paper(PAPERS, values)
    assert told in str(caught.value)


def test_a_value_is_of_the_papers_that_have_it() -> None:
    moved = settings_by_paper(PAPERS, {"seeds": 2})
    assert moved["velocity_obstacle"] == VelocityObstacleSettings(seeds=2)
    assert moved["harmonic"].moved() == {}


def test_only_moved_settings_mark_the_rows() -> None:
    source = row("Table 1", "slices", 2, 2, status="published", source="a law", use=Use.HELD_OUT, note="as it is")  # type: ignore[arg-type]
    plain = Reproduction("A paper 2000", (source,), (), ())
    assert plain.with_settings(Settings()) is plain
    marked = plain.with_settings(VelocityObstacleSettings(seeds=2))
    assert (marked.settings, marked.rows[0].note) == ("seeds=2", "as it is; not as published: seeds=2")
    assert marked.rows[0].modelled == source.modelled


def test_the_command_lists_and_moves_settings(hwsw: Run, tmp_path: Path) -> None:
    listed = hwsw("reproduce", "--settings")
    assert listed.exit_code == 0
    assert all(name in listed.stdout for name in ("labyrinth_seeds", "sor_omegas", "whole number, from 1 to 1,000"))
    wrong = hwsw("reproduce", "velocity_obstacle", "--set", "maps=3")
    assert wrong.exit_code == 2
    assert "--set maps: there is no such setting\n  hint: accepted: seeds" in wrong.stderr
    file = tmp_path / "rows.csv"
    done = hwsw("reproduce", "velocity_obstacle", "--quick", "--set", "seeds=1", "--csv", file)
    assert done.exit_code == 0, done.output
    assert "not as published: seeds=1" in done.stdout.splitlines()[1]
    rows = list(csv.DictReader(file.open(encoding="utf-8")))
    assert all(each["note"].endswith("not as published: seeds=1") for each in rows)
    assert list(rows[0])[-2:] == ["codesign", "date"]
    document = json.loads(hwsw("reproduce", "velocity_obstacle", "--quick", "--json").stdout)
    assert (document["settings"], document["codesign"]) == ("", "0.1.0")
    assert document["date"] == rows[0]["date"]
    assert not any("not as published" in each["note"] for each in document["rows"])
