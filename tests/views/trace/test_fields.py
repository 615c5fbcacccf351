"""The field that a plan left is in its trace: told once, with the values that the planner holds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import Result

import codesign
from codesign import maps
from codesign.ground.records import FieldRecord, MapRecord, StageRecord
from codesign.planners.breadth_first.plan import search
from codesign.planners.breadth_first.plan.planner import distances
from codesign.system.scenarios import simulate
from codesign.views.trace import MemoryListener

PLATFORM = """\
kind: platform
name: board
components:
  fpga: {type: fpga, part: XC4VLX160-12, clock: 50 MHz}
  host:
    type: processor
    clock: 1 GHz
    costs:
      relaxation_node_update: 10 ns
      relaxation_map_cell: 0 s
      relaxation_diagonal: 0 s
      relaxation_check_cell: 10 ns
      harmonic_decision: 1 us
    power: {busy: 20 W, idle: 5 W}
links:
  pci: {type: bus, between: [host, fpga], width: 32, clock: 33 MHz, setup_cycles: 8, burst_words: 16}
"""

MAPPINGS = {
    "harmonic": "relax: {component: fpga, block: [24, 32], iterations: 6, schedule: [15, 31]}",
    "breadth_first": "search: {component: fpga}",
    "wavefront": "propagate: {component: fpga, style: tiled, tile: [8, 8]}",
    "relaxation": "relax: {component: host, method: sor, omega: 1.8}",
}

WORKLOAD = """\
kind: workload
name: rooms
planner: {planner}
problem:
  map: {{generate: rooms, rows: 24, columns: 32, room: [11, 15], door: 3, seed: 5}}
  goals: [[2, 2]]
  starts: [[20, 28]]
mapping:
  {mapping}
"""


def files(folder: Path, planner: str) -> tuple[Path, Path]:
    board, rooms = folder / "board.yaml", folder / "rooms.yaml"
    board.write_text(PLATFORM, encoding="utf-8")
    rooms.write_text(WORKLOAD.format(planner=planner, mapping=MAPPINGS[planner]), encoding="utf-8")
    return board, rooms


@pytest.mark.parametrize("planner", MAPPINGS)
def test_a_plan_tells_its_field_once(tmp_path: Path, planner: str) -> None:
    board, rooms = files(tmp_path, planner)
    listener = MemoryListener()
    simulate(codesign.load_platform(board), codesign.load_workload(rooms), listeners=(listener,))
    records: list[Any] = listener.records
    (drawn,) = (record for record in records if isinstance(record, MapRecord))
    fields = [record for record in records if isinstance(record, FieldRecord)]
    stages = [record for record in records if isinstance(record, StageRecord)]
    # What a stage ends in is told with the stage.
    assert (len(fields), bool(stages)) == ((0, True) if planner in {"harmonic", "relaxation"} else (1, False))
    values = stages[-1].potential if stages else fields[0].values
    assert values.shape == drawn.free.shape
    assert values.dtype == np.float64
    from_goals = maps.distance_steps(drawn.free, [(2, 2)])
    if planner == "breadth_first":
        found = np.isfinite(values)
        assert (fields[0].name, fields[0].unit) == ("distance", "steps")
        assert values[2, 2] == from_goals[20, 28] >= values[found].max() - 1
        assert np.array_equal(values[found], maps.distance_steps(drawn.free, [(20, 28)])[found])
        assert found.sum() == search(drawn.free, (20, 28), (2, 2)).pushed_cells
    elif planner == "wavefront":
        found = np.isfinite(values)
        assert fields[0].name == "potential"
        assert values[2, 2] == 0
        assert values[20, 28] == values[found].max()
        assert (values[found] <= 2 * from_goals[found]).all()
    else:
        assert values[2, 2] == values.max() == 1.0
        assert (values[~drawn.free] == 0.0).all()


@pytest.mark.parametrize("seed", range(4))
def test_distances_are_those_of_the_search(seed: int) -> None:
    random = np.random.Generator(np.random.PCG64(seed))
    free = random.random((17, 23)) > 0.3
    start, goal = (tuple(int(value) for value in cell) for cell in random.permutation(np.argwhere(free))[:2])
    found = search(free, start, goal)  # type: ignore[arg-type]
    values = distances(found)
    exact = maps.distance_steps(free, [start]).astype(float)
    came = np.isfinite(values)
    assert came.sum() == found.pushed_cells
    assert np.array_equal(values[came], exact[came])
    if found.reached:
        assert values[goal] == found.path_steps
    else:
        assert np.array_equal(came, exact >= 0)


def test_a_start_on_its_goal_is_no_step_away() -> None:
    values = distances(search(np.ones((2, 2), np.bool_), (0, 1), (0, 1)))
    assert values[0, 1] == 0.0
    assert values.tolist() == [[np.inf, 0.0], [np.inf, np.inf]]


@pytest.mark.parametrize("planner", MAPPINGS)
def test_show_reads_what_was_told(hwsw: Callable[..., Result], tmp_path: Path, planner: str) -> None:
    board, rooms = files(tmp_path, planner)
    trace = tmp_path / "run.mcap"
    ran = hwsw("run", board, rooms, "--no-levers", "--trace", trace, "--html", tmp_path / "run.html")
    assert ran.exit_code == 0, ran.output
    shown = hwsw("trace", "show", trace)
    assert shown.exit_code == 0, shown.output
    name = {"breadth_first": "distance"}.get(planner, "potential")
    if planner in {"breadth_first", "wavefront"}:
        assert name in shown.output
    assert hwsw("trace", "info", trace).exit_code == 0
