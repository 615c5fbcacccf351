"""Pockets are filled by the processor that sends the map: a flood, in the kernels of breadth-first search."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from places import ROOT

import codesign
from codesign import maps
from codesign.ground.errors import SpecError
from codesign.ground.records import Record, TaskRecord
from codesign.planners.harmonic.plan.planner import FILL
from codesign.system.results.result import Result
from codesign.system.scenarios import simulate

COSTS = {"breadth_first_cell": 7_000, "breadth_first_map_cell": 300, "breadth_first_wall_cell": 11_000}
"""Picoseconds."""

MAP = {"generate": "random", "rows": 24, "columns": 36, "density": 0.35, "seed": 3}
GOAL = (1, 2)


def ran(
    folder: Path, costs: dict[str, int], pockets: str = "filled", *, load: str = "host", **problem: Any
) -> tuple[Result, list[Record]]:
    """A run on an FPGA beside a host, and its records."""
    platform = yaml.safe_load((ROOT / "platforms" / "cmod-a7-35t.yaml").read_text())
    host = {"harmonic_node_update": "1 ns", "harmonic_decision": "70 ns"}
    host |= {kernel: f"{picoseconds} ps" for kernel, picoseconds in costs.items()}
    platform["components"]["host"] = {
        "type": "processor",
        "clock": "1 GHz",
        "costs": host,
        "power": {"busy": "4 W", "idle": "2 W"},
    }
    relax = {"component": "fpga", "block": [12, 12], "iterations": 40, "schedule": [15, 31]}
    workload = {
        "kind": "workload",
        "name": "pockets",
        "planner": "harmonic",
        "problem": {"map": MAP, "goals": [list(GOAL)], **problem},
        "mapping": {"relax": {**relax, "pockets": pockets}, "load": {"component": load}},
    }
    paths = folder / "cmod-a7-35t.yaml", folder / "pockets.yaml"
    for path, document in zip(paths, (platform, workload), strict=True):
        path.write_text(yaml.safe_dump(document, sort_keys=False))
    records: list[Record] = []
    loaded = codesign.load_platform(paths[0]), codesign.load_workload(paths[1])
    return simulate(*loaded, listeners=(records.append,)), records


def flood() -> tuple[int, int, int]:
    """Cells of the map, popped ones, and popped ones beside a wall: counted one by one."""
    free = maps.random_obstacles(24, 36, density=0.35, seed=3).free
    popped, queue, walls = {GOAL}, [GOAL], 0
    for row, column in queue:
        sides = [(row - 1, column), (row, column + 1), (row + 1, column), (row, column - 1)]
        inside = [(r, c) for r, c in sides if 0 <= r < 24 and 0 <= c < 36 and free[r, c]]
        walls += len(inside) < 4
        queue += (new := [cell for cell in inside if cell not in popped])
        popped |= set(new)
    return free.size, len(popped), walls


def of_fill(result: Result) -> float:
    """Seconds of the filling among the terms of the first plan."""
    assert result.terms is not None
    (plan,) = result.terms.plans("first_plan_s")
    return sum(term.seconds for term in plan if term.what == FILL)


def test_a_filled_pocket_costs_a_flood_before_the_map_is_sent(tmp_path: Path) -> None:
    result, records = ran(tmp_path, COSTS)
    cells, popped, walls = flood()
    expected = cells * 300 + popped * 7_000 + walls * 11_000
    filled = [each for each in records if isinstance(each, TaskRecord) and each.task == FILL]
    assert sum(each.end - each.time for each in filled) == expected
    sent = min(each.time for each in records if each.source == "uart")
    assert filled[0].time == 0
    assert filled[-1].end == expected == sent
    assert of_fill(result) == pytest.approx(expected * 1e-12, rel=1e-12)


def test_pockets_that_are_kept_cost_nothing(tmp_path: Path) -> None:
    (kept, records), (without, _) = ran(tmp_path, COSTS, "kept"), ran(tmp_path, {}, "kept")
    assert of_fill(kept) == 0
    assert not any(isinstance(each, TaskRecord) and each.task == FILL for each in records)
    assert kept.time == without.time
    assert kept.notes == without.notes


def test_the_flood_adds_its_time_and_nothing_else(tmp_path: Path) -> None:
    (charged, _), (free, _) = ran(tmp_path, COSTS), ran(tmp_path, dict.fromkeys(COSTS, 0))
    assert charged.time is not None
    assert free.time is not None
    assert charged.quality == free.quality
    assert charged.cycles == free.cycles
    difference = charged.time.first_plan_s - free.time.first_plan_s
    assert difference == pytest.approx(of_fill(charged), abs=1e-8)


@pytest.mark.parametrize("left_out", sorted(COSTS))
def test_a_sender_without_a_cost_is_refused(tmp_path: Path, left_out: str) -> None:
    costs = {kernel: cost for kernel, cost in COSTS.items() if kernel != left_out}
    with pytest.raises(SpecError, match=f"host has no cost of kernel {left_out}, which fill pockets is counted in"):
        ran(tmp_path, costs)


def test_a_sender_that_is_an_fpga_leaves_a_note(tmp_path: Path) -> None:
    notes = [note for note in ran(tmp_path, COSTS, load="fpga")[0].notes if FILL in note]
    assert notes == ["fill pockets: fpga, which sends the map, is an fpga; the time of that is not counted"]


def test_every_plan_of_a_replan_fills_again(tmp_path: Path) -> None:
    free = maps.random_obstacles(24, 36, density=0.35, seed=3).free
    reached = maps.reachable(free, [GOAL])
    blocked = max((int(r), int(c)) for r, c in zip(*reached.nonzero(), strict=True))
    change = {"blocked": [list(blocked)]}
    _, records = ran(tmp_path, COSTS, starts=[list(GOAL)], task="replan", change=change)
    filled = [each for each in records if isinstance(each, TaskRecord) and each.task == FILL]
    # Map, loop and walls of each plan.
    assert len(filled) == 6
