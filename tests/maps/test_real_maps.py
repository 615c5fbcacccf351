"""The friction that had a figure: a SLAM map as it is saved, on a small FPGA, with all planners."""

from __future__ import annotations

from pathlib import Path

import pytest
from places import SHARED

import codesign
from codesign import maps
from codesign.maps import Crop, Steps
from codesign.system.scenarios import bind

SLAM = SHARED / "maps" / "ros" / "turtlebot3"
MOVINGAI = SHARED / "maps" / "movingai"
needs_slam = pytest.mark.skipif(not SLAM.exists(), reason="the ROS maps do not lie beside the repository")
needs_movingai = pytest.mark.skipif(not MOVINGAI.exists(), reason="the MovingAI maps do not lie beside the repository")

MAPPINGS = {
    "harmonic": (
        "relax: {component: fpga, block: [24, 24], iterations: 8, schedule: {first: 15, step: 8, last: 39}, "
        "pockets: filled}"
    ),
    "wavefront": "propagate: {component: fpga, style: tiled, tile: [32, 32], stop: whole_map}",
    "breadth_first": "search: {component: fpga}",
}


@needs_slam
def test_a_bare_slam_map_no_longer_counts_unknown_as_free() -> None:
    bare, described = maps.read_map(SLAM / "map.pgm"), maps.read_map(SLAM / "map.yaml")
    assert (bare.free == described.free).all()
    assert int(bare.free.sum()) == 7939
    first, second = maps.read_prepared(SLAM / "map.pgm", Steps()).remarks
    assert "138,722 pixels of grey 205 taken as unknown; name map.yaml in its place" in first
    assert second.startswith("138,722 of 147,456 cells are unknown, and count as blocked")


@needs_slam
def test_cropping_a_slam_map() -> None:
    grid = maps.read_map(SLAM / "map.yaml")
    part = maps.window(grid, Crop.FREE)
    assert (grid.shape, part.corner, part.rows, part.columns) == ((384, 384), (132, 143), 102, 109)
    # By hand, from the file: 0.05 m a cell, the lower left corner at (-10, -10) m.
    origin = maps.cropped(grid, part).origin
    assert origin == pytest.approx((-10 + 143 * 0.05, -10 + (384 - 132 - 102) * 0.05, 0.0))


@needs_slam
@pytest.mark.parametrize("planner", MAPPINGS)
def test_a_cropped_slam_map_fits_a_small_fpga(tmp_path: Path, planner: str) -> None:
    path = tmp_path / "slam.yaml"
    results = {}
    for crop in ("none", "free"):
        path.write_text(
            f"kind: workload\nname: slam\nplanner: {planner}\nproblem:\n"
            f"  map: {{file: {SLAM / 'map.yaml'}, crop: {crop}}}\n"
            "  goals: [{x: 0.525 m, y: -0.475 m}]\n"
            f"mapping:\n  {MAPPINGS[planner]}\n"
        )
        workload = codesign.load_workload(path)
        results[crop] = codesign.simulate(codesign.load_platform("arty-a7"), workload)
    whole, cropped = results["none"], results["free"]
    assert cropped.feasible, cropped.reasons
    assert cropped.time is not None
    assert cropped.time.first_plan_s < 0.04
    if planner != "wavefront":
        assert not whole.feasible
        return
    # Tiles are worked off one after another, so the whole map fits too, and takes its time.
    assert whole.time is not None
    assert whole.time.first_plan_s > 10 * cropped.time.first_plan_s
    assert whole.quality == cropped.quality


@needs_slam
def test_a_pocket_of_a_slam_map_costs_the_whole_schedule(tmp_path: Path) -> None:
    # A circuit does not know reachability: a free pocket stays a local maximum, so no stage is the last one.
    path = tmp_path / "slam.yaml"
    planned = {}
    for pockets in ("kept", "filled"):
        path.write_text(
            "kind: workload\nname: slam\nplanner: harmonic\nproblem:\n"
            f"  map: {{file: {SLAM / 'map.yaml'}, crop: free}}\n"
            "  goals: [{x: 0.525 m, y: -0.475 m}]\n"
            f"mapping:\n  {MAPPINGS['harmonic'].replace('filled', pockets)}\n"
        )
        result = codesign.simulate(codesign.load_platform("arty-a7"), codesign.load_workload(path))
        assert result.time is not None
        planned[pockets] = result.time.planned_s
    assert planned["kept"] > 2 * planned["filled"]


@needs_movingai
@pytest.mark.parametrize(
    ("map_file", "scen"),
    [
        ("dao/arena.map", "dao/arena.map.scen"),
        ("mapf/room-64-64-16.map", "mapf/scen-random/room-64-64-16-random-1.scen"),
        ("mapf/warehouse-10-20-10-2-1.map", "mapf/scen-random/warehouse-10-20-10-2-1-random-2.scen"),
    ],
)
def test_the_lengths_of_movingai_are_ours(tmp_path: Path, map_file: str, scen: str) -> None:
    for line in (2, 40, 100):
        (tmp_path / "w.yaml").write_text(
            "kind: workload\nname: w\nplanner: breadth_first\nproblem:\n"
            f"  map: {{file: {MOVINGAI / map_file}, crop: reachable}}\n"
            f"  goals: {{scen: {MOVINGAI / scen}, line: {line}}}\nmapping: {{search: {{component: fpga}}}}\n"
        )
        system = bind(codesign.load_platform("virtex2pro"), codesign.load_workload(tmp_path / "w.yaml"))
        assert system.notes == ()
        problem = system.problem
        length = maps.distance_octile(problem.free, problem.goals)[problem.starts[0]]
        assert length == pytest.approx(problem.optimal_lengths[0], abs=0.005)
