"""The example of docs/extending.md, written to a folder, found through its entry points, and run."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable, Generator, Iterator
from importlib import import_module, invalidate_caches
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import Result
from places import ROOT

from codesign import maps
from codesign.inputs import load_part, load_platform
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Step
from codesign.system import catalog
from codesign.testing import RULES, PlugInContract, cases_of

Run = Callable[..., Result]

PAGE = ROOT / "docs" / "extending.md"
PAGES = (PAGE, ROOT / "docs" / "circuits.md")
BLOCK = re.compile(r"^```(?:yaml|python|toml|verilog)\n(?:#|//) (\S+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def forget() -> None:
    """What the catalog has found so far."""
    for each in vars(catalog).values():
        if hasattr(each, "cache_clear"):
            each.cache_clear()


@pytest.fixture
def example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The files of both pages in a folder, installed as pip would leave it: on the path, beside its dist-info."""
    blocks = [block for page in PAGES for block in BLOCK.findall(page.read_text(encoding="utf-8"))]
    files = dict(blocks)
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    project = tomllib.loads(files["pyproject.toml"])["project"]
    installed = tmp_path / f"{project['name']}-{project['version']}.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text(f"Name: {project['name']}\nVersion: {project['version']}\n")
    points = [
        f"[{group}]\n" + "".join(f"{name} = {value}\n" for name, value in found.items())
        for group, found in project["entry-points"].items()
    ]
    (installed / "entry_points.txt").write_text("\n".join(points))
    monkeypatch.syspath_prepend(tmp_path)
    invalidate_caches()
    forget()
    yield tmp_path
    forget()
    for name in [name for name in sys.modules if name.split(".")[0] in ("flood", "test_flood")]:
        del sys.modules[name]


@pytest.mark.skipif(find_spec("hatchling") is None, reason="the build backend of the page is not installed")
def test_the_package_of_the_page_is_installed_by_pip_and_found(example: Path) -> None:
    """The files as a reader has them, without what the fixture adds; found by no path but that of its installation."""
    folder, site = example / "as-read", example / "site"
    for name, text in (block for page in PAGES for block in BLOCK.findall(page.read_text(encoding="utf-8"))):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--target", site]
    done = subprocess.run([*pip, folder], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (site / "flood" / "styles.py").is_file()
    path = os.pathsep.join([str(site), *(each for each in sys.path if each and each != str(example))])
    listed = subprocess.run(
        [sys.executable, "-m", "codesign", "list"],
        cwd=site, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "steps to the goal, flooded from it" in listed.stdout, listed.stderr
    assert listed.returncode == 0


def run(hwsw: Run, example: Path, *more: object) -> Any:
    result = hwsw("run", example / "field-robot.yaml", example / "rooms.yaml", "--json", "--no-levers", *more)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def drained(work: Generator[Step, None, Any]) -> tuple[Any, int]:
    """What the steps end in, and their cycles."""
    cycles = 0
    while True:
        try:
            cycles += int(next(work).cycles.sum())
        except StopIteration as done:
            return done.value, cycles


def test_planner_and_styles_are_found_and_the_specs_are_sound(hwsw: Run, example: Path) -> None:
    assert not catalog.broken()
    assert set(catalog.styles_of("flood")) == {"array", "software"}
    result = hwsw("check", example / "field-robot.yaml", example / "rooms.yaml")
    assert result.exit_code == 0, result.output
    assert "steps to the goal, flooded from it" in hwsw("list").output
    (example / "rooms.yaml").write_text((example / "rooms.yaml").read_text().replace("bits: 12", "bits: 99"))
    assert "mapping.flood.bits" in hwsw("check", example / "rooms.yaml").output


def test_the_plan_is_the_same_in_every_style_and_takes_the_cycles_of_its_law(hwsw: Run, example: Path) -> None:
    planner, styles = catalog.planner("flood"), catalog.styles_of("flood")
    free = maps.rooms(32, 48, room=(15, 15), door=4, seed=1, extra_doors=0.3).free
    problem = Problem(free, ((26, 40),), ((5, 5),))
    exact = maps.distance_steps(free, problem.goals)
    parameters = planner.tasks["flood"]()
    plan = planner.plan(Job(problem, parameters))
    assert np.array_equal(plan.steps, exact)
    for style in styles.values():
        made, cycles = drained(style.work(Job(problem, parameters)))
        assert planner.identity(made) == planner.identity(plan)
        way = int(exact[5, 5])
        # The array loads a row a cycle; the program reads every cell.
        assert cycles == (32 + exact.max() + way if style.style == "array" else free.size + (exact >= 0).sum())
    told = run(hwsw, example)
    assert told["feasible"]
    assert told["quality"]["share_reaching_goal"] == 1.0
    # On the FPGA the way is not tracked; the counts go to the computer, which tracks it.
    busy = told["time"]["planned_s"] - told["time"]["map_loaded_s"]
    assert round(busy * 1e12) >= (32 + int(exact.max())) * 10_000
    few = run(hwsw, example, "--set", "flood.bits=5", "--set", "workload.problem.arrive=0")
    assert few["quality"]["share_reaching_goal"] < 1.0
    assert few["quality"]["wrong_cells"] == int((exact >= 31).sum())


def test_the_test_on_the_page_passes_and_reports_a_wrong_planner(
    example: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    check = import_module("test_flood").test_flood_keeps_the_contract
    check()
    monkeypatch.setattr("flood.planner.CELL_BITS", 0)
    with pytest.raises(AssertionError) as wrong:
        check()
    text = str(wrong.value)
    for index in (0, 1):
        assert f"- flows_lead_from_the_map_to_the_answer (flood-{index}): " in text
        assert f"- flows_after_a_plan_differ_in_size_only (flood-{index}): " in text
    assert "flow 'map' from 'load' to 'flood' has 0 bits: give an integer above 0" in text


def test_the_class_on_the_page_checks_the_same(example: Path) -> None:
    (block,) = re.findall(r"^```python\n(class TestFlood.*?)^```", PAGE.read_text("utf-8"), re.M | re.S)
    names: dict[str, Any] = {"PlugInContract": PlugInContract, "PLUG_IN": import_module("flood.styles").PLUG_IN}
    exec(block, names)
    suite = names["TestFlood"]
    cases = [case for plug_in in suite.plug_ins for case in cases_of(plug_in)]
    assert [case.parameters.bits for case in cases] == [12, 5]
    for case in cases:
        for rule in RULES:
            if rule.applies(case):
                suite().test_contract(rule, case)


def test_the_example_is_explored(hwsw: Run, example: Path) -> None:
    result = hwsw(
        "explore",
        example / "field-robot.yaml",
        example / "rooms.yaml",
        "--workers",
        1,
        "--json",
        "--store",
        example / "s.sqlite",
    )
    assert result.exit_code == 0, result.output
    points = json.loads(result.stdout)["points"]
    assert len(points) == 4
    assert all(point["result"] is not None for point in points)


def test_the_example_drives(hwsw: Run, example: Path) -> None:
    """A planner of one's own takes part in missions: its way is tracked on the computer, plan after plan."""
    file = example / "rooms.yaml"
    scenario = "scenario: {type: drive, known: none, resolution: 0.2 m}\nmapping:"
    file.write_text(file.read_text().replace("mapping:", scenario))
    told = run(hwsw, example)
    mission = told["mission"]
    assert told["places"]["flood"] == "fpga"
    assert told["places"]["track"] == "computer"
    assert mission["reached"], mission["ended"]
    assert mission["replans"] > 0
    assert mission["contacts"] == 0
    assert told["links"]["line"]["delivered"] >= 2 * mission["plans"]  # the map there, the counts back


def test_a_part_of_lut6_is_counted_in_lut4_from_below(example: Path) -> None:
    chip = load_platform(example / "field-robot.yaml").components["fpga"].chip
    assert chip.full_name == "XC7S50-1"
    slices, lut4 = chip.resources["slices"], chip.resources["lut4"]
    assert (slices.value, slices.interval) == (2 * 8150, (2 * 8150, 4 * 8150))
    assert (lut4.value, lut4.interval) == (32600, (32600, 2 * 32600))
    assert {slices.status, lut4.status} == {"assumed"}
    assert chip.resources["flip_flops"].status == "published"
    assert chip.dynamic_power.value == pytest.approx(0.088e-12 / 2)
    old = load_part("XC2V6000-4").resources
    assert (old["lut4"].value, old["lut4"].status) == (67584, "published")


@pytest.mark.parametrize(("found", "what"), [(0, "neither lut4 nor lut6"), (2, "both lut4 and lut6")])
def test_a_part_has_one_make_of_lut(hwsw: Run, example: Path, found: int, what: str) -> None:
    file = example / "parts" / "XC7S50.yaml"
    line = next(line for line in file.read_text().splitlines() if "lut6" in line)
    both = f"{line}\n{line.replace('lut6', 'lut4')}"
    file.write_text(file.read_text().replace(line, both if found else ""))
    result = hwsw("check", example / "field-robot.yaml")
    assert result.exit_code == 2
    assert what in result.output


def test_the_circuit_on_its_page_reports_what_the_model_expects(example: Path) -> None:
    pytest.importorskip("pyosys")
    from codesign.hardware.rtl.verify import verify
    from codesign.testing import check_plug_in

    plug_in = import_module("flood.plug_in").PLUG_IN
    check_plug_in(plug_in)
    (circuit,) = plug_in.circuits
    verified = [verify(circuit, circuit.sample(seed)) for seed in (1, 3, 5)]
    assert [each.first for each in verified] == [None, None, None]
    assert sum(each.events for each in verified) > 10


def test_a_law_that_is_off_by_a_cycle_is_seen(example: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pyosys")
    from codesign.hardware.rtl.verify import verify

    (circuit,) = import_module("flood.plug_in").PLUG_IN.circuits
    styles = import_module("flood.styles")
    right = styles.step
    monkeypatch.setattr(styles, "step", lambda phase, cycles: right(phase, cycles + (phase == "load")))
    assert verify(circuit, circuit.sample(0)).first is not None
