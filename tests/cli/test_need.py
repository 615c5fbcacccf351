"""--need on run, compare, explore and report; --axis and --condition on explore."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from click.testing import Result

import codesign

Run = Callable[..., Result]
Specs = tuple[Path, Path]


def test_a_run_that_meets_its_needs_says_how_sure_that_is(hwsw: Run, specs: Specs) -> None:
    done = hwsw("run", *specs, "--need", "time < 10 s", "--need", "slices < 99 %")
    assert done.exit_code == 0, done.output
    assert "is feasible: worst plan time " in done.stdout
    assert " where less than 10 s is asked for; " in done.stdout
    assert "need plan_time_worst_s < 10 s   met (proved)" in done.stdout
    assert "need slices < 99 %              met" in done.stdout


def test_a_need_that_is_missed_is_a_reason_and_an_exit_code(hwsw: Run, specs: Specs) -> None:
    done = hwsw("run", *specs, "--need", "time < 1 us", "--need", "power <= 100 W")
    assert done.exit_code == 3
    assert "fits, but misses what is asked for (worst plan time below: " in done.stdout.splitlines()[0]
    assert "need plan_time_worst_s < 1 us   missed (at every value)" in done.stdout
    assert "need power <= 100 W             met (proved)" in done.stdout
    assert "Why it is not feasible" in done.stdout
    as_json = hwsw("run", *specs, "--need", "time < 1 us", "--json")
    assert as_json.exit_code == 3
    document = json.loads(as_json.stdout)
    assert [reason["kind"] for reason in document["reasons"]] == ["constraint"]
    assert document["task"] is not None
    assert document["feasible"] is False


def test_a_need_that_an_assumed_figure_decides_names_where_it_flips(hwsw: Run) -> None:
    # The search on the arm rests on an assumed cost of 88 ns a cell, 44 to 176.
    run = ("run", "zynq", "breadth-first", "--set", "search.component=arm", "--set", "search.style=software")
    seconds = json.loads(hwsw(*run, "--json").stdout)["task"]["plan_time_worst_s"]
    done = hwsw(*run, "--need", f"time < {seconds * 1.2e6:.3f} us")
    assert done.exit_code == 0, done.output
    assert "met, flips at arm." in done.stdout
    done = hwsw(*run, "--need", f"time < {seconds * 0.8e6:.3f} us")
    assert done.exit_code == 3
    assert "missed, flips at arm." in done.stdout


def test_compare_says_which_design_meets_a_need(hwsw: Run) -> None:
    designs = ("virtex2pro:breadth-first", "pc-3400mhz:floor-plan")
    needs = ("--need", "block_rams < 10 %", "--need", "slices < 1 %", "--need", "time < 100 s")
    done = hwsw("compare", *designs, *needs)
    assert done.exit_code == 0, done.output
    for need, missed in (("block_rams < 10 %", "missed (at every value)"), ("slices < 1 %", "missed, flips at state")):
        (row,) = (line for line in done.stdout.splitlines() if line.startswith(f"need {need}"))
        assert missed in row
        assert "met (proved)" in row
    none = hwsw("compare", *designs, "--need", "time < 1 ps")
    assert none.exit_code == 3


@pytest.mark.parametrize("command", ["run", "compare", "explore"])
def test_needs_are_checked_before_any_work(hwsw: Run, specs: Specs, command: str) -> None:
    names = (f"{specs[0]}:{specs[1]}",) if command == "compare" else specs
    needs = ("--need", "slices < 0.8", "--need", "tme < 1 s")
    done = hwsw(command, *names, *needs)
    assert done.exit_code == 2
    assert "--need 'slices < 0.8': '0.8': a count is a whole number\n  hint: write 80 %" in done.stderr
    assert "--need 'tme < 1 s': 'tme' is no figure\n  hint: did you mean time?" in done.stderr


def test_explore_takes_axes_conditions_and_needs(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    done = hwsw(
        "explore", *specs, "--axis", "relax.iterations=2..6*3", "--axis", "fpga.clock=50MHz..100MHz:50MHz",
        "--condition", "workload.problem.map.seed=1..2", "--need", "slices < 99 %", "--workers", "1",
        "--store", tmp_path / "s.sqlite", "--json",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    study = json.loads(done.stdout)
    assert study["axes"]["relax.iterations"] == [2, 6]
    assert study["axes"]["fpga.clock"] == ["50 MHz", "100 MHz"]
    assert study["conditions"] == {"workload.problem.map.seed": [1, 2]}
    assert study["constraints"][-1]["below"] == 0.99
    report = hwsw("report", tmp_path / "s.sqlite", "--need", "slices < 1 %", "--json")
    assert report.exit_code == 3, report.output
    judged = json.loads(report.stdout)
    assert judged["counts"]["feasible"] == 0 < study["counts"]["feasible"]
    clash = hwsw("report", tmp_path / "s.sqlite", "--need", "slices > 99 %")
    assert clash.exit_code == 2
    assert "--need 'slices > 99 %': nothing is within this and slices < 99 %" in clash.stderr


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--axis", "relax.iterations=2,two"), "--axis relax.iterations[1]: 'two' is not a whole number"),
        (("--axis", "relax.iterations=2,2"), "--axis relax.iterations[1]: 2 is listed twice"),
        (("--axis", "relax.iteration=2"), "--axis relax.iteration: unknown key\n  hint: did you mean iterations?"),
        (("--axis", "fpga.clock=10..20"), "--axis fpga.clock[0]: 10 has no unit"),
        (("--axis", "nothing"), "--axis: 'nothing' is no setting"),
        (("--axis", "relax.iterations=2", "--axis", "relax.iterations=3"), "relax.iterations is set twice"),
        (("--axis", "relax.iterations=2", "--set", "relax.iterations=3"), "set by --set and by --axis"),
        (("--axis", "platform=zynq"), "--axis platform: PLATFORM is named too"),
        (("--condition", "platform=zynq"), "--condition platform: a platform is a decision"),
        (("--axis", "relax.iterations=2", "--condition", "relax.iterations=2"), "sets the same thing as axis"),
    ],
)  # fmt: skip
def test_mistakes_in_axes_are_reported_as_in_a_file(
    hwsw: Run, specs: Specs, options: tuple[str, ...], told: str
) -> None:
    done = hwsw("explore", *specs, *options)
    assert done.exit_code == 2, done.output
    assert told in done.stderr


FIGURES = """
  figures: {cost: slices * 1 ms + time, delay: {expression: energy_j * time, unit: mJ s}}
"""


def with_figures(specs: Specs, folder: Path, name: str, figures: str = FIGURES) -> Path:
    """The workload with derived figures."""
    tree = yaml.safe_load(specs[1].read_text())
    tree["name"] = name
    tree.setdefault("explore", {})["figures"] = yaml.safe_load(figures)["figures"]
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(tree, sort_keys=False))
    return path


def test_needs_may_name_derived_figures(hwsw: Run, specs: Specs, tmp_path: Path) -> None:
    path = with_figures(specs, specs[1].parent, "derived")
    done = hwsw("run", specs[0], path, "--need", "cost < 1000 s", "--need", "delay < 1 mJ s")
    assert done.exit_code == 0, done.output
    assert "need cost < 1,000 s" in done.stdout.replace("1000", "1,000")
    assert "met (proved)" in done.stdout
    missed = hwsw("run", specs[0], path, "--need", "delay < 1 pJ s")
    assert missed.exit_code == 3
    assert "missed (at every value)" in missed.stdout
    wrong = hwsw("run", specs[0], path, "--need", "delai < 1 mJ s")
    assert wrong.exit_code == 2
    assert "did you mean delay" in wrong.stderr


def test_compare_takes_the_derived_figures_of_its_workloads(hwsw: Run, tmp_path: Path) -> None:
    tree = dict(codesign.load_workload("breadth-first").document.tree)
    grid = {"generate": "empty", "rows": 9, "columns": 9}
    tree["problem"] = {"map": grid, "goals": [[1, 1]], "starts": [[7, 7]]}
    source = tmp_path / "plain.yaml"
    source.write_text(json.dumps(tree, default=float))
    path = with_figures((source, source), tmp_path, "derived")
    designs = ("pc-3400mhz:floor-plan", f"virtex2pro:{path}")
    done = hwsw("compare", *designs, "--need", "delay < 1 mJ s")
    assert done.exit_code == 0, done.output
    (row,) = (line for line in done.stdout.splitlines() if line.startswith("need delay"))
    assert row.count("met") + row.count("missed") == 2
    other = with_figures((source, source), tmp_path, "other", "figures: {delay: energy_j * time * 2}")
    clash = hwsw("compare", *designs, f"virtex2pro:{other}", "--need", "delay < 1 mJ s")
    assert clash.exit_code == 2
    assert "two workloads have a figure delay" in clash.stderr
