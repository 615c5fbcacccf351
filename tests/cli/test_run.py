"""One run: its results and its trace, the settings of the command line, and what bad input gets."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Run = Callable[..., Result]
Specs = tuple[Path, Path]


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("fpga.clock=600 MHz", "--set fpga.clock: 600 MHz is above the 300 MHz limit of part XC2V6000-4\n"),
        ("relax.block=12x18", "--set relax.block: '12x18' is not a list\n  hint: write [12, 18]\n"),
        ("relax.blocks=[23, 2]", "--set relax.blocks: 23 × 2 equal blocks do not part a map of 24 × 36 cells: "),
        ("relax.component=hots", "--set relax.component: platform small-board has no component 'hots'\n"),
        ("relax.itrations=1", "--set relax.itrations: unknown key\n  hint: did you mean iterations?"),
        ("relax.iterations=010", "--set relax.iterations: 010 has a leading zero\n"),
    ],
)
def test_faults_of_a_setting_are_not_blamed_on_a_file(
    hwsw: Run, specs: tuple[Path, Path], setting: str, told: str
) -> None:
    result = hwsw("run", *specs, "--set", setting)
    assert result.exit_code == 2
    assert result.stderr.startswith(told)
    assert "rooms.yaml" not in result.stderr


def test_an_axis_set_twice_is_refused(hwsw: Run, specs: tuple[Path, Path]) -> None:
    twice = ("--set", "relax.iterations=1", "--set", "relax.iterations=4")
    for words in (("run", *specs), ("compare",)):
        result = hwsw(*words, *twice)
        assert result.exit_code == 2
        assert "relax.iterations is set twice" in result.stderr


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


def test_run_that_does_not_fit_exits_with_3_and_leaves_no_trace(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    result = hwsw(
        "run",
        *specs,
        "--set",
        "fpga.part=XC3S500E-4",
        "--set",
        "fpga.clock=50 MHz",
        "--set",
        "relax.block=[24, 36]",
        "--trace",
        tmp_path / "no.mcap",
    )
    assert result.exit_code == 3
    assert "slices" in result.output
    assert not (tmp_path / "no.mcap").exists()


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


@pytest.mark.slow
@pytest.mark.parametrize("specs", [("virtex2pro", "warehouse"), ("nexys2-serial", "robots-64")])
def test_the_page_of_a_shipped_mission_shows_its_course_and_can_be_mailed(
    hwsw: Run, tmp_path: Path, specs: tuple[str, str]
) -> None:
    page = tmp_path / "page.html"
    result = hwsw("run", *specs, "--no-levers", "--html", page)
    assert result.exit_code == 0, result.output
    html = page.read_text(encoding="utf-8")
    assert '<canvas id="stage"' in html
    assert len(html.encode()) < 1_000_000
