"""Every shipped workload on the platform that it was made for, and the memory beside the chip."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from examples import THOROUGH
from places import ROOT
from shipped_pairs import MISSIONS, PLATFORMS, SHORT, short_study

import codesign
from codesign.ground.units import format_time
from codesign.inputs import list_workloads

Run = Callable[..., Result]


def test_every_workload_has_its_platform() -> None:
    assert set(PLATFORMS) == set(list_workloads())


def kind_of(name: str) -> tuple[str, str]:
    workload = codesign.load_workload(name)
    return workload.planner, workload.scenario.type


FIRST_OF_ITS_KIND = {kind_of(name): name for name in reversed(PLATFORMS)}.values()


@pytest.mark.parametrize(
    ("workload", "limit"),
    [
        *(pytest.param(name, (), id=name) for name in PLATFORMS if name not in MISSIONS[1:]),
        *(pytest.param(name, SHORT, id=f"{name}-short") for name in MISSIONS[1:]),
        *(pytest.param(name, (), id=name, marks=pytest.mark.slow) for name in MISSIONS[1:]),
    ],
)
def test_every_workload_runs_traces_and_reports(
    hwsw: Run, tmp_path: Path, workload: str, limit: tuple[str, ...]
) -> None:
    """Without the levers of missions, each a mission of its own: one more test runs those.

    One workload of each kind writes its page.
    """
    platform, trace, page = PLATFORMS[workload], tmp_path / "run.mcap", tmp_path / "run.html"
    drawn = ("--html", page) if THOROUGH or workload in FIRST_OF_ITS_KIND else ()
    result = hwsw("run", platform, workload, "--no-levers", "--json", "--trace", trace, *drawn, *limit)
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["time"]["first_plan_s"] >= told["time"]["planned_s"] > 0
    assert told["quality"] is not None
    assert told["energy"]["energy_j"] > 0
    if workload in MISSIONS:
        mission = told["mission"]
        assert mission["reached"] is not bool(limit), mission["ended"]
        assert mission["replans"] > 0
        assert mission["contacts"] == 0
    shown = hwsw("trace", "show", trace, "--json", "--limit", 100_000)
    assert shown.exit_code == 0
    told_of = {json.loads(line)["what"].split()[0] for line in shown.stdout.splitlines()}
    assert {"map", "trajectory"} <= told_of
    assert not drawn or page.stat().st_size > 3000


@pytest.mark.parametrize(
    "workload", [MISSIONS[0], *(pytest.param(name, marks=pytest.mark.slow) for name in MISSIONS[1:])]
)
def test_the_levers_of_every_mission_are_run(hwsw: Run, workload: str) -> None:
    mission = json.loads(hwsw("run", PLATFORMS[workload], workload, "--json").stdout)["mission"]
    assert any(lever["mission_time_s"] is not None for lever in mission["levers"])
    assert mission["bottleneck"]["text"]


# More robots are no other study.
@pytest.mark.parametrize(
    "workload",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name in ("robots-8", "robots-64")))
        for name in PLATFORMS
        if name not in ("labyrinth", "wavefront-rooms")
    ],
)
def test_every_exploration_starts_and_ends(hwsw: Run, tmp_path: Path, workload: str) -> None:
    """With one value of each axis, so that it is quick: every axis is bound, computed and reported."""
    file = short_study(workload, tmp_path)
    if file is None:
        pytest.skip("nothing to explore")
    values = codesign.load_workload(file).explore.axes.values()
    result = hwsw("explore", PLATFORMS[workload], file, "--workers", 1, "--json", "--store", tmp_path / "s.sqlite")
    assert result.exit_code in (0, 3), result.output
    points = json.loads(result.stdout)["points"]
    assert len(points) == max(map(len, values))
    assert all(point["result"] is not None for point in points)


def test_a_map_beside_the_chip_keeps_its_memory_busy_at_a_lower_clock(hwsw: Run) -> None:
    name = PLATFORMS["breadth-first-external"]
    told = json.loads(hwsw("run", name, "breadth-first-external", "--json").stdout)
    assert told["external_memory"] == "dimm"
    assert {use["resource"]: use["demand"] for use in told["resources"]}["block_rams"] == 0
    assert told["utilisation"]["dimm"] > 0.5
    assert told["clock"]["hz"] == told["clock"]["limit"]["value"] == 100_000_000
    shown = hwsw("run", name, "breadth-first-external", "-v").stdout
    assert re.search(r"^external memory +dimm$", shown, re.MULTILINE)
    assert "external_cycles" not in shown
    assert "external_cycles" in hwsw("run", "virtex2pro", "breadth-first-large", "-v").stdout


def test_the_page_tells_what_a_memory_beside_the_chip_costs(hwsw: Run) -> None:
    page = (ROOT / "docs" / "breadth_first.md").read_text(encoding="utf-8")
    lines = re.findall(r"^\| .*? \| `(virtex2pro\S*)`, (\d+) MHz \| (.*) \|$", page, re.MULTILINE)
    places = [{}, {}, *({"memory": place, "external_memory": "dimm"} for place in ("process_external", "external"))]
    for (platform, clock, cells), placed in zip(lines, places, strict=True):
        keys = {"micro_architecture": "pipelined", "display": "none", **placed}
        settings = [part for key, value in keys.items() for part in ("--set", f"search.{key}={value}")]
        told = json.loads(hwsw("run", platform, "breadth-first", *settings, "--json").stdout)
        rams = {use["resource"]: use["demand"] for use in told["resources"]}["block_rams"]
        busy = told["utilisation"]["dimm"]
        figures = (
            f"{rams}",
            f"{sum(told['cycles'].values()):,}",
            format_time(round(told["time"]["first_plan_s"] * 1e12)),
            f"{told['energy']['energy_j'] * 1e3:#.3g} mJ",
            f"{busy:.0%}".replace("%", " %") if busy else "",
        )
        assert told["clock"]["hz"] == int(clock) * 10**6
        assert tuple(cell.strip() for cell in f"{cells} ".split(" | ")) == figures
