"""The command line as its user meets it: output, exit codes, and what bad input gets."""

from __future__ import annotations

import contextlib
import csv
import json
import os
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from codesign.inputs import list_platforms, list_workloads

Run = Callable[..., Result]
Specs = tuple[Path, Path]


@pytest.mark.parametrize("platform", list_platforms())
def test_every_shipped_platform_is_sound(hwsw: Run, platform: str) -> None:
    result = hwsw("check", platform)
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("workload", list_workloads())
def test_every_shipped_workload_fits_some_platform(hwsw: Run, workload: str) -> None:
    results = [hwsw("check", platform, workload) for platform in list_platforms()]
    assert any(result.exit_code == 0 for result in results), results[0].output


def test_list_names_what_ships(hwsw: Run) -> None:
    found = json.loads(hwsw("list", "--json").output)
    assert {"virtex2-pci", "virtex4-pci"} <= set(found["platforms"])
    assert "labyrinth" in found["workloads"]
    assert {"XC4VLX160-12", "XC2V6000-4", "XC3S500E-4"} <= set(found["parts"])
    assert "harmonic.bit_serial" in found["styles"]


@pytest.mark.parametrize("kind", ["platform", "workload", "part", "result"])
def test_schema_is_json_schema(hwsw: Run, kind: str) -> None:
    schema = json.loads(hwsw("schema", kind).output)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert schema["type"] == "object"
    assert schema["properties"]


def test_run_prints_json_and_writes_a_trace(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    result = hwsw("run", *specs, "--json", "--trace", tmp_path / "run.mcap", "--html", tmp_path / "run.html")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["schema_version"] == 2
    assert told["feasible"] is True
    info = json.loads(hwsw("trace", "info", tmp_path / "run.mcap", "--json").output)
    assert info["complete"] is True
    assert info["metadata"]["run"]["workload"] == "two-rooms"
    shown = hwsw("trace", "show", tmp_path / "run.mcap").output
    assert f"stage {len(told['stages']) - 1}" in shown
    assert "<img" in (tmp_path / "run.html").read_text(encoding="utf-8")
    assert not list(tmp_path.glob("*.part"))


def test_run_sets_axes_from_the_command_line(hwsw: Run, specs: Specs) -> None:
    one = json.loads(hwsw("run", *specs, "--json", "--set", "relax.iterations=1").stdout)
    four = json.loads(hwsw("run", *specs, "--json", "--set", "relax.block=[24, 36]").stdout)
    assert one["parameters"]["relax"]["iterations"] == 1
    assert four["blocks"] == 1
    assert one["quality"] == four["quality"]


def test_run_that_does_not_fit_exits_with_3_and_leaves_no_trace(
    hwsw: Run, specs: Specs, tmp_path: Path
) -> None:
    result = hwsw(
        "run",
        *specs,
        "--set",
        "fpga.part=XC3S500E-4",
        "--set",
        "fpga.clock=50 MHz",
        "--trace",
        tmp_path / "no.mcap",
    )
    assert result.exit_code == 3
    assert "slices" in result.output
    assert not (tmp_path / "no.mcap").exists()


def test_explore_lists_feasible_and_infeasible_points_with_all_figures(
    hwsw: Run, specs: Specs, tmp_path: Path
) -> None:
    result = hwsw(
        "explore",
        *specs,
        "--json",
        "--workers",
        1,
        "--csv",
        tmp_path / "p.csv",
        "--html",
        tmp_path / "p.html",
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
    assert "96 from the store" in again.stderr
    report = hwsw("report", "small-board-two-rooms.sqlite", "--json")
    assert report.stdout == first.stdout


def test_explore_with_nothing_feasible_exits_with_3(hwsw: Run, specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").replace("[XC2V6000-4, XC3S500E-4]", "[XC3S500E-4]")
    text = text.replace("[[12, 18], [24, 36], [6, 9]]", "[[24, 36]]")
    specs[1].write_text(text, encoding="utf-8")
    result = hwsw("explore", *specs, "--workers", 1)
    assert result.exit_code == 3
    assert "0 feasible" in result.output


def test_interrupted_exploration_keeps_its_points_and_goes_on(specs: Specs, tmp_path: Path) -> None:
    if os.name == "nt":
        pytest.skip("SIGINT is sent to a process group here")
    many = ", ".join(str(value) for value in range(1, 17))
    text = (
        specs[1]
        .read_text(encoding="utf-8")
        .replace("relax.iterations: [1, 4]", f"relax.iterations: [{many}]")
    )
    specs[1].write_text(text, encoding="utf-8")
    store = tmp_path / "points.sqlite"
    command = [
        sys.executable,
        "-m",
        "codesign",
        "explore",
        *map(str, specs),
        "--store",
        str(store),
        "--workers",
        "2",
    ]
    running = subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        assert running.stderr is not None
        for line in running.stderr:
            if not line.startswith("0/"):
                break
        os.killpg(running.pid, signal.SIGINT)
        _, errors = running.communicate(timeout=60)
    finally:
        if running.poll() is None:
            os.killpg(running.pid, signal.SIGKILL)
    assert running.returncode == 130, errors
    assert "Traceback" not in errors
    kept = _kept(store)
    assert 0 < kept < 768
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert f"{kept} from the store" in done.stderr
    assert _kept(store) == 768


def _kept(store: Path) -> int:
    with contextlib.closing(sqlite3.connect(f"file:{store}?mode=ro", uri=True)) as connection:
        (count,) = connection.execute("select count(*) from point").fetchone()
    return int(count)


BAD: dict[str, tuple[str, str, str]] = {
    "iterations": ("iterations: 4", "iterations: 0", "relax.iterations"),
    "decreasing": ("schedule: {first: 7, step: 8, last: 63}}", "schedule: [31, 15]}", "15 follows 31"),
    "empty schedule": ("schedule: {first: 7, step: 8, last: 63}}", "schedule: []}", "an empty schedule"),
    "precision": ("last: 63}}", "last: 1024}}", "1023"),
    "no goal": ("goals: [[2, 2]]", "goals: []", "goals"),
    "huge": ("rows: 24, columns: 36", "rows: 100000, columns: 100000", "too large"),
    "infinite": ("seed: 3}", "seed: .inf}", "seed"),
    "misspelt": ("iterations: 4,", "iteratoins: 4,", "did you mean iterations"),
    "termination": ("iterations: 4,", "iterations: 4, termination: sond,", "sound"),
    "both": ("block: [12, 18], iter", "block: [12, 18], blocks: [2, 2], iter", "exactly one"),
    "planner": ("planner: harmonic", "planner: harmonik", "harmonic"),
    "map": ("generate: rooms", "generate: roms", "rooms"),
    "component": ("relax: {component: fpga", "relax: {component: fgpa", "fpga"),
    "octal": ("seed: 3}", "seed: 010}", "010"),
    "bomb": ("name: two-rooms", "name: &a [x, x]\nother: [*a, *a]", "anchor"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_workloads_get_a_place_and_a_remedy(hwsw: Run, specs: Specs, name: str) -> None:
    old, new, words = BAD[name]
    text = specs[1].read_text(encoding="utf-8")
    assert old in text
    specs[1].write_text(text.replace(old, new), encoding="utf-8")
    result = hwsw("run", *specs)
    assert result.exit_code == 2, result.output
    assert words in result.output
    assert f"{specs[1].name}:" in result.output
    assert "hint:" in result.output
    assert not result.stdout


def test_all_faults_are_told_at_once(hwsw: Run, specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8")
    text = text.replace("iterations: 4", "iterations: 0").replace("goals: [[2, 2]]", "goal: [[2, 2]]")
    specs[1].write_text(text.replace("part: [XC2V6000-4", "part: [XC2V6000-9"), encoding="utf-8")
    result = hwsw("check", *specs, "--json")
    assert result.exit_code == 2
    faults = json.loads(result.stdout)
    keys = {fault["key"] for fault in faults}
    assert {"mapping.relax.iterations", "problem.goal"} <= keys


def test_unknown_names_get_the_nearest(hwsw: Run) -> None:
    result = hwsw("run", "virtex4-pcy", "labyrinth")
    assert result.exit_code == 2
    assert "virtex4-pci" in result.output
    assert hwsw("run", "virtex4-pci", "missing.yaml").exit_code == 2
    assert hwsw("trace", "info", __file__).exit_code in (1, 2)
    assert hwsw("explode").exit_code == 2


def test_init_writes_files_that_run_and_overwrites_nothing(hwsw: Run, tmp_path: Path) -> None:
    assert hwsw("init", tmp_path / "mine").exit_code == 0
    files = sorted((tmp_path / "mine").iterdir())
    assert len(files) == 2
    assert hwsw("check", *files).exit_code == 0
    again = hwsw("init", tmp_path / "mine")
    assert again.exit_code == 2
    assert "is there already" in again.output
