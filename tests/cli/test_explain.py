"""``hwsw explain``, and ``hwsw run --point``."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import jsonschema
import pytest
from click.testing import Result

Run = Callable[..., Result]
Specs = tuple[Path, Path]

STORE = "small-board-two-rooms.sqlite"


CONDITIONS = """\
kind: workload
name: small
planner: breadth_first
problem:
  map: {generate: random, rows: 9, columns: 9, density: 0.1, seed: 2}
  goals: [[0, 0]]
  starts: {count: 2, seed: 1}
mapping: {search: {component: host, style: software}}
variants:
  software: {}
  wave: {planner: wavefront, mapping: {propagate: {component: fabric, style: tiled, tile: [8, 8]}}}
explore:
  axes: {workload.variant: [software, wave], platform: [pc-3400mhz, zynq]}
  conditions: {workload.problem.starts.seed: [1, 2, 3]}
  constraints: [time < 1 ps]
"""


@pytest.fixture
def store(hwsw: Run, specs: Specs) -> str:
    """A file of twelve points, four of them out."""
    text = specs[1].read_text(encoding="utf-8").partition("explore:")[0] + (
        "explore:\n  axes:\n    relax.block: [[12, 18], [24, 36]]\n    relax.iterations: [1, 4]\n"
        "    fpga.clock: [50 MHz, 100 MHz, 200 MHz]\n"
    )
    specs[1].write_text(text, encoding="utf-8")
    assert hwsw("explore", *specs, "--workers", 1, "-q").exit_code == 0
    return STORE


def out_of(store: str) -> int:
    from codesign.study import load_study

    return next(point.index for point in load_study(store).points if not point.feasible)


def test_a_feasible_design_is_explained_from_the_file(hwsw: Run, store: str) -> None:
    done = hwsw("explain", store, 0)
    assert done.exit_code == 0, done.output
    assert done.stdout.startswith("design 0 of two-rooms on small-board is ")
    titles = ["The design", "Why this time", "Why this energy", "Neighbours: one axis differs", "How sure"]
    places = [done.stdout.index(f"\n{title}\n") for title in (*titles, "Which axis moves which objective")]
    assert places == sorted(places)
    assert "fpga.clock (assumed 50 MHz)" in done.stdout
    assert hwsw("explain", store, 0, "-q").stdout == done.stdout.splitlines()[0] + "\n"
    assert len(hwsw("explain", store, 0, "-v").stdout) > len(done.stdout)


def test_a_design_that_is_out_names_the_lever_that_mends_it(hwsw: Run, store: str) -> None:
    done = hwsw("explain", store, out_of(store))
    assert done.exit_code == 3, done.output
    assert " is out: clock 200 MHz against " in done.stdout
    assert "makes it feasible." in done.stdout.splitlines()[0]
    assert "\nWhy it is out\n" in done.stdout
    assert "\nEach lever by itself\n" in done.stdout


def test_a_missed_constraint_and_a_reason_in_several_conditions_are_said_once(hwsw: Run, tmp_path: Path) -> None:
    (tmp_path / "conditions.yaml").write_text(CONDITIONS, encoding="utf-8")
    done = hwsw("explore", "conditions.yaml", "--store", "c.sqlite", "--workers", "1", "-q")
    assert done.exit_code in (0, 3), done.output
    missed = hwsw("explain", "c.sqlite", 0, "-q").stdout
    assert " is out: worst plan time " in missed
    assert ", not below 1 ps and" not in missed
    assert ", not below 1 ps" in missed
    refused = hwsw("explain", "c.sqlite", 2, "-q").stdout
    assert refused.count("has no fabric") == 1, refused


def test_the_json_is_what_its_schema_says(hwsw: Run, store: str, specs: Specs) -> None:
    schema = json.loads(hwsw("schema", "explanation").stdout)
    texts = [hwsw("explain", store, index, "--json").stdout for index in (0, out_of(store))]
    texts.append(hwsw("explain", *specs, "--json").stdout)
    for text in texts:
        document = json.loads(text, parse_constant=pytest.fail)
        jsonschema.validate(document, schema, jsonschema.Draft202012Validator)
        assert "result" not in document
    assert json.loads(texts[-1])["index"] is None


def test_a_run_is_explained_with_its_steps(hwsw: Run, specs: Specs) -> None:
    done = hwsw("explain", *specs, "--set", "relax.iterations=1", "-v")
    assert done.exit_code == 0, done.output
    assert "\nSteps to the next value\n" in done.stdout
    assert "relax.iterations 1 → 2" in " ".join(done.stdout.split())


def test_a_point_runs_again_from_the_file_alone(hwsw: Run, store: str, specs: Specs, tmp_path: Path) -> None:
    settings = ("--set", "relax.block=[12, 18]", "--set", "relax.iterations=1", "--set", "fpga.clock=100 MHz")
    alone = json.loads(hwsw("run", *specs, *settings, "--json").stdout)
    for file in specs:
        file.unlink()
    again = hwsw("run", store, "--point", 1, "--trace", "one.mcap", "--html", "one.html", "--json")
    assert again.exit_code == 0, again.output
    assert json.loads(again.stdout) == alone
    assert (tmp_path / "one.mcap").stat().st_size > 1000
    assert "run small-board-two-rooms.sqlite --point 1" in (tmp_path / "one.html").read_text(encoding="utf-8")
    assert hwsw("run", store, "--point", out_of(store), "-q").exit_code == 3


def test_a_point_of_other_code_has_a_note(hwsw: Run, store: str) -> None:
    with closing(sqlite3.connect(store)) as database:
        (text,) = database.execute("SELECT definition FROM study").fetchone()
    definition = json.loads(text)
    assert set(definition["identity"]) == {"platform", "workload", "map", "files", "code"}
    assert hwsw("run", store, "--point", 0, "-q").stderr == ""
    from codesign.study import load_study

    specs = load_study(store).specs
    assert specs is not None
    assert specs.note == ""
    object.__setattr__(specs, "identity", {**specs.identity, "code": "older"})
    assert "other code" in specs.note


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (("explain", STORE, "12"), 2, "the study has points 0 to 11; the nearest is 11"),
        (("explain", STORE, "--", "-1"), 2, "the nearest is 0"),
        (("explain", STORE, "9" * 40), 2, "there is no design 9999"),
        (("explain", STORE, "first"), 2, "'first' is no index of a design"),
        (("explain", "board.yaml", "3"), 1, "is not a file of explored points"),
        (("explain", ".", "3"), 2, ".: no such file"),
        (("explain", "none.sqlite", "3"), 2, "none.sqlite: no such file"),
        (("explain", STORE, "0", "--set", "fpga.clock=1 MHz"), 2, "the axes of a design are those of the study"),
        (("explain", "board.yaml", "rooms.yaml", "--condition", "a.b=1"), 2, "a run has no conditions"),
        (("explain", STORE, "0", "--condition", "a.b=1"), 2, "there is no condition a.b"),
        (("run", STORE, "--point", "12"), 2, "the nearest is 11"),
        (("run", "board.yaml", "--point", "1"), 1, "is not a file of explored points"),
        (("run", "board.yaml", "rooms.yaml", "--point", "1"), 2, "name the file of hwsw explore alone"),
        (("run", STORE), 2, "name a platform and a workload"),
    ],
)
def test_faults_say_what_to_write(hwsw: Run, store: str, words: tuple[str, ...], code: int, says: str) -> None:
    done = hwsw(*words)
    assert (done.exit_code, done.stdout) == (code, "")
    assert says in done.stderr
    assert Path(store).is_file()
