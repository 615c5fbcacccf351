"""Version, digests, seeds and date: in JSON, CSV, pages and traces; and what does not depend on the date."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

import codesign
from codesign.ground.figures import FIGURES
from codesign.ground.files import date_of_writing
from codesign.study import load_study
from codesign.system.problem_map import grid_of

Run = Callable[..., Result]
Specs = tuple[Path, Path]
EPOCH = "1000000000"
DAY = "2001-09-09"


@pytest.fixture(autouse=True)
def _date(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", EPOCH)


@pytest.mark.parametrize("epoch", ["", "soon", "-1", "9" * 12, "9" * 40])
def test_a_faulty_epoch_is_no_date(monkeypatch: pytest.MonkeyPatch, epoch: str) -> None:
    assert date_of_writing() == DAY
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    assert len(date_of_writing()) == len(DAY)
    assert date_of_writing() != DAY


def test_a_result_says_what_it_was_made_of() -> None:
    platform, workload = codesign.load_platform("zynq"), codesign.load_workload("wavefront-tiles")
    result = codesign.simulate(platform, workload)
    grid, provenance = grid_of(workload), result.provenance
    assert grid is not None
    assert provenance is not None
    assert provenance.codesign == codesign.__version__
    assert provenance.platform_digests == {"zynq": platform.digest()}
    assert (provenance.workload_digest, provenance.map_digest) == (workload.digest(), grid.digest)
    assert provenance.seeds == {"problem.map.seed": 1}
    # A date is of what is written: two results are equal on any day.
    assert provenance.date is None
    assert result == codesign.simulate(platform, workload)


def test_a_study_does_not_name_a_seed_that_an_axis_moves() -> None:
    workload = {
        "kind": "workload", "name": "small", "planner": "breadth_first",
        "problem": {
            "map": {"generate": "random", "rows": 9, "columns": 9, "density": 0.1, "seed": 2},
            "goals": [[0, 0]], "starts": {"count": 2, "seed": 1},
        },
        "mapping": {"search": {"component": "host", "style": "software"}},
        "explore": {"axes": {"platform": ["pc-3400mhz"]}, "conditions": {"workload.problem.map.seed": [2, 3]}},
    }  # fmt: skip
    study = codesign.explore(None, workload, workers=1)
    assert study.provenance is not None
    assert study.provenance.seeds == {"problem.starts.seed": 1}


def test_text_of_a_result_is_short() -> None:
    result = codesign.simulate("zynq", "wavefront-tiles")
    assert str(result) == repr(result)
    assert len(str(result)) < 200


def test_json_has_date_intervals_and_fit(hwsw: Run) -> None:
    document = json.loads(hwsw("run", "zynq", "wavefront-tiles", "--json").stdout)
    assert document["provenance"]["date"] == DAY
    low, high = document["intervals"]["plan_time_worst_s"]
    assert low <= document["task"]["plan_time_worst_s"] <= high
    assert document["fit"]["fits"] in {"yes", "no", "uncertain"}
    both = json.loads(hwsw("compare", "zynq:wavefront-tiles", "pc-3400mhz:floor-plan", "--json").stdout)
    assert both["zynq:wavefront-tiles"]["provenance"]["date"] == DAY
    assert both["pc-3400mhz:floor-plan"]["fit"] is None


def test_a_frame_has_the_ends_of_each_interval() -> None:
    pytest.importorskip("pandas")
    result = codesign.simulate("zynq", "wavefront-tiles")
    rows = result.frame().set_index("figure")
    ends = result.interval(FIGURES["plan_time_worst_s"])
    assert tuple(rows.loc["plan_time_worst_s", ["low", "high"]]) == ends
    assert rows.loc["slices", ["low", "high"]].isna().all()


def test_page_and_trace_name_version_digests_and_date(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    done = hwsw("run", *specs, "--html", tmp_path / "p.html", "--trace", tmp_path / "t.mcap")
    assert done.exit_code == 0, done.output
    digest = codesign.load_workload(specs[1]).digest()
    page = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert f"hwsw {codesign.__version__}; platform small-board " in page
    assert f"workload {digest[:12]}; map " in page
    assert f"date {DAY}</p>" in page
    info = hwsw("trace", "info", tmp_path / "t.mcap").stdout.split()
    assert {digest, DAY, "run.map_digest", "problem.map.seed=3", "problem.starts.seed=1"} <= set(info)


def test_a_study_carries_it_and_its_points_do_not(
    hwsw: Run, specs: Specs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    explore = (
        "explore", *specs, "--axis", "relax.iterations=1,4", "--set", "relax.block=[12, 18]", "--workers", "1",
        "--set", "relax.termination=sound", "--set", "fpga.part=XC2V6000-4", "--set", "fpga.clock=50 MHz",
        "--set", "relax.schedule=[15, 63]",
    )  # fmt: skip
    files = "--store", tmp_path / "s.sqlite", "--csv", tmp_path / "s.csv", "--html", tmp_path / "s.html"
    document = json.loads(hwsw(*explore, *files, "--json").stdout)
    assert document["provenance"]["date"] == DAY
    assert {point["result"]["provenance"] for point in document["points"]} == {None}
    study = load_study(tmp_path / "s.sqlite")
    assert study.provenance is not None
    assert study.provenance.date is None
    assert study.provenance.stamped().model_dump(mode="json") == document["provenance"]
    rows = list(csv.DictReader((tmp_path / "s.csv").open(encoding="utf-8")))
    assert list(rows[0])[-6:] == ["codesign", "platform_digest", "workload_digest", "map_digest", "seeds", "date"]
    assert {row["platform_digest"] for row in rows} == {*document["provenance"]["platform_digests"].values()}
    assert {row["date"] for row in rows} == {DAY}
    for row in rows:
        ends = float(row["plan_time_worst_s_low"]), float(row["plan_time_worst_s_high"])
        assert ends[0] <= float(row["plan_time_worst_s"]) <= ends[1]
    assert f"date {DAY}</p>" in (tmp_path / "s.html").read_text(encoding="utf-8")
    # Neither the stored study nor its equality depends on the day.
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1200000000")
    assert load_study(tmp_path / "s.sqlite") == study
    hwsw(*explore, "--store", tmp_path / "later.sqlite")
    assert load_study(tmp_path / "later.sqlite") == study


def test_over_maps_no_digest_of_one_map_is_given() -> None:
    study = codesign.explore(
        "pc-3400mhz",
        {
            "kind": "workload", "name": "sizes", "planner": "breadth_first",
            "problem": {
                "map": {"generate": "random", "rows": 10, "columns": 10, "density": 0.1, "seed": 2},
                "goals": [[0, 0]], "starts": [[9, 9]],
            },
            "mapping": {"search": {"component": "host", "style": "software"}},
            "explore": {"axes": {"workload.problem.map.seed": [2, 3]}},
        },
    )  # fmt: skip
    assert study.provenance is not None
    assert study.provenance.map_digest is None
    assert study.provenance.workload_digest is not None
