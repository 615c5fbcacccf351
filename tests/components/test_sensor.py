"""Range sensors: the kernel is its plain twin, nothing is seen through a wall, and everything in the open is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_sensor import cast_reference
from scipy import ndimage

from codesign.components.sensor import RadiusSensor, RangeScan, RaySensor, Sensor
from codesign.ground.errors import InputError

SIDE = 14


@st.composite
def scenes(draw: st.DrawFn) -> tuple[np.ndarray, tuple[float, float]]:
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    shape = (draw(st.integers(1, SIDE)), draw(st.integers(1, SIDE)))
    free = random.random(shape) >= draw(st.sampled_from([0.0, 0.05, 0.3, 0.5]))
    position = [random.uniform(-0.5, side - 0.5001) for side in shape]
    rounded = [round(value * part) / part for value in position for part in [draw(st.sampled_from([1, 2, 7]))]]
    inside = [min(max(value, -0.5), side - 0.51) for value, side in zip(rounded, shape, strict=True)]
    row, column = (math.floor(value + 0.5) for value in inside)
    free[row, column] = True
    return free, (inside[0], inside[1])


reaches = st.sampled_from([0.3, 1.0, 2.5, 4.0, 30.0])
counts = st.sampled_from([1, 4, 7, 8, 16, 180])


def as_set(cells: np.ndarray) -> set[tuple[int, int]]:
    return {(int(row), int(column)) for row, column in cells}


@given(scenes(), reaches, counts)
@settings(max_examples=examples(200))
def test_the_kernel_casts_as_its_reference(
    scene: tuple[np.ndarray, tuple[float, float]], reach: float, rays: int
) -> None:
    free, position = scene
    sensor = RaySensor(reach, rays)
    scan, expected = sensor.scan(free, position), cast_reference(free, position, reach, sensor.directions)
    assert scan.free.tolist() == expected.free.tolist()
    assert scan.blocked.tolist() == expected.blocked.tolist()
    assert scan.cells == len(as_set(scan.free) | as_set(scan.blocked))


@given(scenes(), reaches, counts)
@settings(max_examples=examples(200))
def test_what_is_seen_is_true_and_in_range_and_behind_no_wall(
    scene: tuple[np.ndarray, tuple[float, float]], reach: float, rays: int
) -> None:
    free, position = scene
    cell = tuple(math.floor(value + 0.5) for value in position)
    for sensor in (RaySensor(reach, rays), RadiusSensor(reach)):
        scan = sensor.scan(free, position)
        assert free[scan.free[:, 0], scan.free[:, 1]].all()
        assert not free[scan.blocked[:, 0], scan.blocked[:, 1]].any()
        gaps = np.maximum(np.abs(np.concatenate((scan.free, scan.blocked)) - position) - 0.5, 0)
        assert (np.hypot(gaps[:, 0], gaps[:, 1]) <= reach + 1e-9).all()
    scan = RaySensor(reach, rays).scan(free, position)
    # A wall parts what is not joined by sides: also one whose cells touch at corners only.
    labels, _ = ndimage.label(free)
    assert {labels[seen] for seen in as_set(scan.free)} == {labels[cell]}
    room = ndimage.binary_dilation(labels == labels[cell])
    assert room[scan.blocked[:, 0], scan.blocked[:, 1]].all()


def crossed(
    shape: tuple[int, int], position: tuple[float, float], direction: list[float], reach: float
) -> list[tuple[int, int]]:
    """The cells that a ray crosses, nearest first, each found alone: where the ray enters its square, and leaves it."""
    found = []
    for cell in np.ndindex(*shape):
        near, far = 0.0, math.inf
        for middle, start, part in zip(cell, position, direction, strict=True):
            if part == 0.0:
                if abs(middle - start) > 0.5:
                    far = -1.0
                continue
            sides = sorted(((middle - 0.5 - start) / part, (middle + 0.5 - start) / part))
            near, far = max(near, sides[0]), min(far, sides[1])
        if near < far and near <= reach:
            found.append((near, (cell[0], cell[1])))
    return [cell for _, cell in sorted(found)]


@given(scenes(), st.sampled_from([1.7, 4.1, 30.3]), st.sampled_from([1, 4, 7, 16, 40]))
@settings(max_examples=80)
def test_a_ray_sees_the_cells_that_it_crosses_up_to_the_first_blocked(
    scene: tuple[np.ndarray, tuple[float, float]], reach: float, rays: int
) -> None:
    free, near = scene
    # Off all borders and corners, so that which cells a ray crosses is beyond doubt.
    cell = [math.floor(value + 0.5) for value in near]
    offsets = (0.0137, 0.0071)
    position = tuple(part + 0.9 * (value - part) + off for value, part, off in zip(near, cell, offsets, strict=True))
    sensor = RaySensor(reach, rays)
    seen_free, seen_blocked = set(), set()
    for direction in sensor.directions.tolist():
        for crossing in crossed(free.shape, position, direction, reach):
            if not free[crossing]:
                seen_blocked.add(crossing)
                break
            seen_free.add(crossing)
    scan = sensor.scan(free, position)
    assert as_set(scan.free) == seen_free
    assert as_set(scan.blocked) == seen_blocked


def test_a_ray_along_a_border_stays_in_the_cells_of_the_border() -> None:
    scan = RaySensor(20.0, 4).scan(np.ones((5, 5), np.bool_), (2.5, 2.5))
    assert as_set(scan.free) == {(3, column) for column in range(5)} | {(row, 3) for row in range(5)}


def test_nothing_leaks_between_walls_that_touch_at_a_corner() -> None:
    free = np.ones((9, 9), np.bool_)
    free[np.arange(9), 8 - np.arange(9)] = False
    scan = RaySensor(20.0, 360).scan(free, (1.0, 1.0))
    assert all(row + column <= 8 for row, column in as_set(scan.free) | as_set(scan.blocked))
    assert as_set(scan.blocked) == {(row, 8 - row) for row in range(9)}


def test_a_corner_of_one_obstacle_hides_nothing() -> None:
    free = np.ones((5, 5), np.bool_)
    free[1, 2] = False
    scan = RaySensor(20.0, 8).scan(free, (1.0, 1.0))
    assert {(2, 2), (3, 3), (4, 4)} <= as_set(scan.free)


def test_in_the_open_many_rays_see_the_whole_disc() -> None:
    free = np.ones((41, 41), np.bool_)
    middle = (20.0, 20.0)
    rays, disc = RaySensor(10.0, 2000).scan(free, middle), RadiusSensor(10.0).scan(free, middle)
    assert as_set(disc.free) <= as_set(rays.free)
    assert len(disc.free) == sum(row**2 + column**2 <= 100 for row in range(-10, 11) for column in range(-10, 11))
    assert not len(rays.blocked)


def test_a_radius_knows_what_lies_behind_walls() -> None:
    free = np.ones((1, 6), np.bool_)
    free[0, 2] = False
    assert RadiusSensor(4.0).scan(free, (0.0, 0.0)).free.tolist() == [[0, 0], [0, 1], [0, 3], [0, 4]]
    assert RaySensor(4.0, 4).scan(free, (0.0, 0.0)).free.tolist() == [[0, 0], [0, 1]]


def test_a_ray_sees_as_far_as_it_reaches() -> None:
    free = np.ones((1, 9), np.bool_)
    assert len(RaySensor(2.4, 1).scan(free, (0.0, 0.0)).free) == 3
    assert len(RaySensor(2.5, 1).scan(free, (0.0, 0.0)).free) == 4, "it touches the next cell"
    assert len(RaySensor(2.4, 1).scan(free, (0.0, 0.2)).free) == 4


@pytest.mark.parametrize("sensor", [RaySensor(0.0, 8), RadiusSensor(0.0)])
def test_a_range_of_0_sees_nothing(sensor: Sensor) -> None:
    scan: RangeScan = sensor.scan(np.ones((3, 3), np.bool_), (1.0, 1.0))
    assert scan.cells == 0


def test_the_size_of_a_scan() -> None:
    assert RaySensor(4.0, 180).bits == 180 * 16
    assert RadiusSensor(1.0).bits == 5
    assert RadiusSensor(10.0).bits == 317, "Gauss' circle problem, N(10)"


@pytest.mark.parametrize("position", [(-0.6, 1.0), (1.0, 2.5), (3.0, 0.0)])
@pytest.mark.parametrize("sensor", [RaySensor(2.0, 8), RadiusSensor(2.0)])
def test_a_position_outside_of_the_map_is_refused(sensor: Sensor, position: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="outside of the map"):
        sensor.scan(np.ones((3, 3), np.bool_), position)


@pytest.mark.parametrize("reach", [-1.0, math.inf, math.nan])
def test_a_range_that_cannot_be_is_refused(reach: float) -> None:
    with pytest.raises(InputError, match=r"sensor\.range"):
        RadiusSensor(reach)
    with pytest.raises(InputError, match=r"sensor\.range"):
        RaySensor(reach, 4)
    with pytest.raises(InputError, match="0 rays"):
        RaySensor(1.0, 0)
