"""An exploration on the command line: every point with its figures, kept, and gone on with."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from codesign.ground.errors import StoreError
from codesign.study import load_study

Run = Callable[..., Result]


Specs = tuple[Path, Path]


def test_explore_lists_feasible_and_infeasible_points_with_all_figures(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    result = hwsw(
        "explore", *specs, "--json", "--workers", 1, "--csv", tmp_path / "p.csv", "--html", tmp_path / "p.html"
    )
    assert result.exit_code == 0, result.output
    study = json.loads(result.stdout)
    points = study["points"]
    assert len(points) == 3 * 2 * 2 * 2 * 2 * 2
    feasible = [point["result"] for point in points if point["result"]["feasible"]]
    infeasible = [point["result"] for point in points if not point["result"]["feasible"]]
    assert feasible
    assert infeasible
    for figures in feasible:
        assert figures["time"]["first_plan_s"] > 0
        assert figures["quality"]["reachable_cells"] > 0
        assert figures["energy"]["energy_j"] > 0
    for figures in infeasible:
        assert figures["reasons"]
        assert figures["resources"]
        assert figures["time"] is None
    assert study["front"]
    with (tmp_path / "p.csv").open(encoding="utf-8", newline="") as file:
        assert len(list(csv.reader(file))) == len(points) + 1
    # Fields of all partitions, I and schedules that end at one precision are the same under sound termination.
    sound = [figures for figures in feasible if figures["parameters"]["relax"]["termination"] == "sound"]
    qualities = {(figures["precision"], json.dumps(figures["quality"])) for figures in sound}
    assert len(sound) > 2 * len(qualities)
    assert len({precision for precision, _ in qualities}) == len(qualities) > 1


def test_explore_again_computes_nothing_and_says_the_same(hwsw: Run, specs: Specs) -> None:
    first = hwsw("explore", *specs, "--json", "--workers", 1)
    again = hwsw("explore", *specs, "--json", "--workers", 1)
    assert first.stdout == again.stdout
    assert first.stderr == again.stderr == ""
    with pytest.MonkeyPatch.context() as patched:
        for compute in ("Pricer.begin", "PointByPoint.begin"):
            patched.setattr(f"codesign.study.evaluation.{compute}", None)
        assert hwsw("explore", *specs, "--workers", 1).exit_code == 0
    report = hwsw("report", "small-board-two-rooms.sqlite", "--json")
    assert report.stdout == first.stdout


def test_explore_with_nothing_feasible_exits_with_3(hwsw: Run, specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").replace("[XC2V6000-4, XC3S500E-4]", "[XC3S500E-4]")
    text = text.replace("[[12, 18], [24, 36], [6, 9]]", "[[24, 36]]")
    specs[1].write_text(text, encoding="utf-8")
    result = hwsw("explore", *specs, "--workers", 1)
    assert result.exit_code == 3
    assert "0 feasible" in result.output


def test_interrupted_exploration_keeps_its_points_and_goes_on(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    if os.name == "nt":
        pytest.skip("SIGINT is sent to a process group here")
    many = ", ".join(str(value) for value in range(1, 7))
    text = specs[1].read_text(encoding="utf-8").replace("relax.iterations: [1, 4]", f"relax.iterations: [{many}]")
    specs[1].write_text(text, encoding="utf-8")
    store = tmp_path / "points.sqlite"
    words = ["explore", *map(str, specs), "--store", str(store), "--workers"]
    command = [sys.executable, "-m", "codesign", *words, "2"]
    running = subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        while running.poll() is None and not _kept(store):
            time.sleep(0.05)
        os.killpg(running.pid, signal.SIGINT)
        _, errors = running.communicate(timeout=60)
    finally:
        if running.poll() is None:
            os.killpg(running.pid, signal.SIGKILL)
    assert running.returncode == 130, errors
    assert "Traceback" not in errors
    kept = _kept(store)
    assert 0 < kept < 288
    done = hwsw(*words, 1)
    assert done.exit_code == 0, done.output
    assert _kept(store) == 288


def _kept(store: Path) -> int:
    """The points in a store; 0 where there is none yet."""
    try:
        study = load_study(store)
    except StoreError:
        return 0
    return sum(point.state == "done" for point in study.points)


CONDITIONS = """
kind: workload
name: rooms
planner: harmonic
problem:
  map: {generate: rooms, rows: 20, columns: 30, room: [8, 8], seed: 1}
  goals: [[4, 10]]
mapping:
  relax: {component: fpga, block: [10, 15], iterations: 6, schedule: {first: 7, step: 8, last: 63}}
explore:
  axes: {relax.block: [[20, 30], [10, 15]]}
  conditions: {workload.problem.map.seed: [5, 6, 7]}
  aggregate: {default: mean}
  objectives: [first_plan_s, slices]
"""


def test_conditions_are_shown_together_and_each_by_itself(hwsw: Run, tmp_path: Path) -> None:
    workload, store = tmp_path / "rooms.yaml", tmp_path / "rooms.sqlite"
    workload.write_text(CONDITIONS, encoding="utf-8")
    whole = hwsw("explore", "virtex4-pci", workload, "--store", store, "--workers", 1)
    assert whole.exit_code == 0, whole.output
    assert "2 designs × 3 conditions = 6 points, compared by the mean over the conditions" in whole.stdout
    assert "Spread over 3 conditions" in whole.stdout
    listed = json.loads(hwsw("report", store, "--json").stdout)
    assert (listed["counts"]["points"], listed["counts"]["designs"]) == (6, 2)
    by_value = hwsw("report", store, "--condition", "workload.problem.map.seed=6", "--json")
    alone = json.loads(by_value.stdout)
    assert [point["axes"]["workload.problem.map.seed"] for point in alone["points"]] == [6, 6]
    assert alone["points"][0]["figures"] == listed["points"][1]["figures"]
    respelt = hwsw("report", store, "--condition", "workload.problem.map.seed=6.0", "--json")
    assert respelt.stdout == by_value.stdout


@pytest.mark.parametrize(
    ("condition", "told"),
    [
        ("workload.problem.map.sed=5", "did you mean workload.problem.map.seed?"),
        ("workload.problem.map.seed=9", "has no value 9\n  hint: did you mean 7? accepted: 5, 6, 7\n"),
        # Among numbers, a number is a value, never a place in the list.
        ("workload.problem.map.seed=1", "has no value 1\n  hint: did you mean 5? accepted: 5, 6, 7\n"),
        ("seed", "write AXIS=VALUE, as in --condition"),
    ],
)
def test_a_condition_that_there_is_not_is_refused(hwsw: Run, tmp_path: Path, condition: str, told: str) -> None:
    workload, store = tmp_path / "rooms.yaml", tmp_path / "rooms.sqlite"
    workload.write_text(CONDITIONS, encoding="utf-8")
    assert hwsw("explore", "virtex4-pci", workload, "--store", store, "--workers", 1).exit_code == 0
    refused = hwsw("report", store, "--condition", condition)
    assert refused.exit_code == 2
    assert told in refused.output
