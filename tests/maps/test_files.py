"""Map files that change under a running process."""

from __future__ import annotations

from pathlib import Path

from codesign import maps
from codesign.system.catalog import load_workload
from codesign.system.problem_map import load_grid

WORKLOAD = """\
kind: workload
name: changing
planner: harmonic
problem:
  map: {file: map.yaml}
  goals: [[0, 0]]
mapping:
  relax: {component: fpga, block: [1, 2], iterations: 4, schedule: [7]}
"""
YAML = "image: map.pgm\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


def write_map(folder: Path, pixels: bytes) -> Path:
    (folder / "map.pgm").write_bytes(b"P5\n%d 1\n255\n" % len(pixels) + pixels)
    (folder / "map.yaml").write_text(YAML)
    return folder / "map.yaml"


def test_an_image_that_changed_is_read_again_though_its_yaml_did_not(tmp_path: Path) -> None:
    """A process that lives on must plan on the map that is there, not on the one it once read."""
    path = write_map(tmp_path, b"\xff\xff")
    (tmp_path / "w.yaml").write_text(WORKLOAD)
    workload = load_workload(tmp_path / "w.yaml")
    assert load_grid(workload).free.tolist() == [[True, True]]
    assert load_grid(workload) is load_grid(workload)
    (tmp_path / "map.pgm").write_bytes(b"P5\n3 1\n255\n\xff\x00\xff")
    assert load_grid(workload).free.tolist() == [[True, False, True]]
    assert maps.map_files(path) == (path, tmp_path / "map.pgm")


def test_the_stamp_of_a_map_that_cannot_be_read(tmp_path: Path) -> None:
    """Reading tells what is wrong; the stamp only has to stand still."""
    absent = tmp_path / "absent.yaml"
    assert maps.map_stamp(absent) == ((str(absent), -1, -1),)
    (tmp_path / "broken.yaml").write_text("image: [")
    assert len(maps.map_stamp(tmp_path / "broken.yaml")) == 1
