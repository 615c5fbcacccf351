"""The steps from a map to what is planned on: unknown cells, inflation, downsampling, cropping."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.errors import MapError
from codesign.ground.models import Frame
from codesign.maps import Crop, OccupancyGrid, Radius, Steps, Unknown
from codesign.maps.survey import picture

masks = st.tuples(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32 - 1), st.floats(0, 1)).map(
    lambda drawn: np.random.default_rng(drawn[2]).random(drawn[:2]) < drawn[3]
)


def inflated(free: NDArray[np.bool_], radius: float) -> NDArray[np.bool_]:
    """By its definition, cell by cell; the outside is a ring of obstacles, and the rest of it lies farther away."""
    padded = np.pad(free, 1)
    walls = np.argwhere(~padded)
    result = np.zeros(padded.shape, bool)
    for cell in np.argwhere(padded):
        result[tuple(cell)] = min(math.dist(cell, wall) for wall in walls) > radius + 1e-9
    return result[1:-1, 1:-1]


@settings(max_examples=60, deadline=None)
@given(masks, st.sampled_from([0.0, 0.5, 1.0, 1.4, 1.5, 2.0, 3.7]))
def test_inflation_by_its_definition(free: NDArray[np.bool_], radius: float) -> None:
    assert (maps.inflate(OccupancyGrid(free), radius).free == inflated(free, radius)).all()


@settings(max_examples=60, deadline=None)
@given(masks, st.integers(1, 4))
def test_a_coarse_cell_is_free_where_all_its_cells_are(free: NDArray[np.bool_], factor: int) -> None:
    coarse = maps.downsample(OccupancyGrid(free, 0.5, (1.0, 2.0, 0.3)), factor)
    assert coarse.shape == (math.ceil(free.shape[0] / factor), math.ceil(free.shape[1] / factor))
    for row, column in np.ndindex(coarse.shape):
        inside = free[row * factor : (row + 1) * factor, column * factor : (column + 1) * factor]
        assert coarse.free[row, column] == (inside.shape == (factor, factor) and inside.all())


@settings(max_examples=60, deadline=None)
@given(masks, st.integers(1, 4), st.floats(-3, 3))
def test_steps_keep_the_frame(free: NDArray[np.bool_], factor: int, yaw: float) -> None:
    """A free coarse cell, and a cell of what cropping leaves, lie in metres where they lay before."""
    grid = OccupancyGrid(free, 0.5, (-7.0, 2.0, yaw))
    coarse = maps.downsample(grid, factor)
    part = maps.window(coarse, Crop.FREE)
    left = maps.cropped(coarse, part)
    assert grid.frame is not None
    assert coarse.frame is not None
    assert left.frame is not None
    assert int(left.free.sum()) == int(coarse.free.sum())
    for row, column in np.argwhere(left.free):
        middle = left.frame.point(row, column)
        there = row + part.row, column + part.column
        assert coarse.frame.point(*there) == pytest.approx(middle)
        assert coarse.frame.cell(*middle) == there
        fine = grid.frame.cell(*middle)
        assert (fine[0] // factor, fine[1] // factor) == there


def test_the_order_inflates_before_downsampling() -> None:
    """A radius below the side of a coarse cell still keeps the robot away from the obstacle beside it."""
    free = np.ones((9, 12), bool)
    free[4, 5] = False
    steps = Steps(inflate=Radius(0.1, "m"), downsample=3)
    prepared = maps.prepare(OccupancyGrid(free, 0.1), steps)
    assert prepared.resolution == pytest.approx(0.3)
    # Column 6 of the fine map, beside the obstacle, is blocked: so is the coarse cell that holds it.
    assert not prepared.free[1, 2]
    late = maps.inflate(maps.downsample(OccupancyGrid(free, 0.1), 3), 0.1 / 0.3)
    assert late.free[1, 2]


def test_unknown_cells() -> None:
    unknown = np.array([[False, True, False]])
    grid = OccupancyGrid(np.array([[True, False, False]]), unknown=unknown)
    assert maps.prepare(grid, Steps()).free.tolist() == [[True, False, False]]
    assert maps.prepare(grid, Steps(unknown=Unknown.FREE)).free.tolist() == [[True, True, False]]


def test_reachable_keeps_what_is_joined_across_corners() -> None:
    rows = ["#####...", "#.#.####", "##.#####", "########"]
    free = np.array([[cell == "." for cell in row] for row in rows])
    grid = OccupancyGrid(free)
    joined = maps.window(grid, Crop.REACHABLE, [(1, 1)])
    assert (joined.corner, joined.rows, joined.columns) == ((1, 1), 2, 3)
    assert maps.window(grid, Crop.FREE).columns == 7
    assert maps.window(grid, Crop.NONE) == maps.Window(0, 0, 4, 8)
    assert maps.window(OccupancyGrid(np.zeros((2, 3), bool)), Crop.FREE) == maps.Window(0, 0, 2, 3)


@pytest.mark.parametrize(
    ("steps", "key", "what"),
    [
        (Steps(inflate=Radius(0.3, "m")), "inflate", "does not say how large a cell is"),
        (Steps(resolution=0.1), "resolution", "the map itself says 0.05 m a cell"),
    ],
)
def test_steps_that_cannot_be(steps: Steps, key: str, what: str) -> None:
    resolution = 0.05 if key == "resolution" else None
    with pytest.raises(MapError, match=what) as caught:
        maps.prepare(OccupancyGrid(np.ones((2, 2), bool), resolution), steps)
    assert caught.value.where == key


def test_points_on_a_side_belong_to_the_right_and_upper_cell() -> None:
    frame = Frame(rows=4, resolution=0.05, origin=(0.0, 0.0, 0.0))
    assert [frame.cell(column * 0.05, 0.0)[1] for column in range(40)] == list(range(40))
    assert frame.cell(0.0, 0.05) == (2, 0)
    assert Frame(2, 1.0, (1.0, 1.0, math.pi / 2)).cell(0.5, 2.5) == (1, 1)


def write_pgm(path: Path, pixels: NDArray[np.int_]) -> None:
    path.write_bytes(b"P5\n%d %d\n255\n" % pixels.shape[::-1] + pixels.astype(np.uint8).tobytes())


def test_a_bare_image_with_the_greys_of_map_server(tmp_path: Path) -> None:
    pixels = np.array([[254, 205, 205], [254, 0, 239]])
    write_pgm(tmp_path / "floor.pgm", pixels)
    grid = maps.read_map(tmp_path / "floor.pgm")
    assert grid.free.tolist() == [[True, False, False], [True, False, True]]
    assert grid.unknown is not None
    assert int(grid.unknown.sum()) == 2
    assert maps.yaml_beside(tmp_path / "floor.pgm") is None
    (tmp_path / "a.yaml").write_text("kind: workload\n")
    (tmp_path / "b.yaml").write_text(
        "image: floor.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    assert maps.yaml_beside(tmp_path / "floor.pgm") == tmp_path / "b.yaml"
    first, second = maps.read_prepared(tmp_path / "floor.pgm", Steps()).remarks
    assert "2 pixels of grey 205 taken as unknown; name b.yaml in its place" in first
    assert second == "2 of 6 cells are unknown, and count as blocked (unknown: blocked)"
    free = maps.read_prepared(tmp_path / "floor.pgm", Steps(unknown=Unknown.FREE))
    assert free.free.tolist() == [[True, True, True], [True, False, True]]


def test_a_picture_with_all_greys_has_no_unknown_cells(tmp_path: Path) -> None:
    write_pgm(tmp_path / "ramp.pgm", np.arange(256).reshape(16, 16))
    grid = maps.read_map(tmp_path / "ramp.pgm")
    assert (grid.unknown, int(grid.free.sum()), grid.remarks) == (None, 128, ())


def test_the_picture_leaves_unknown_rims_out(tmp_path: Path) -> None:
    pixels = np.full((20, 30), 205)
    pixels[6:9, 10:14] = 254
    pixels[6, 10] = 0
    write_pgm(tmp_path / "slam.pgm", pixels)
    grid = maps.read_prepared(tmp_path / "slam.pgm", Steps())
    whole = maps.window(grid, Crop.NONE, ())
    head, *rows, tail = picture(grid, whole)
    assert head.strip() == "column 10 to 13"
    assert [row.split()[0] for row in rows] == ["6", "8"]
    assert tail.endswith("; all cells around are unknown")
    # A place that is asked for is in the picture.
    assert picture(grid, whole, (2, 20))[0].strip() == "column 10 to 20"
