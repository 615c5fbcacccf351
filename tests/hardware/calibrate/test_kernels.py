"""The compiled twins of a host's work, by which it is timed, come to what the simulation's own code comes to."""

from __future__ import annotations

import math

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.components.path import Polyline, authority
from codesign.components.sensor import RaySensor
from codesign.hardware.calibrate.host_costs import FOLLOWING, OCCUPANCY, all_probes
from codesign.hardware.calibrate.kernels import authority_ahead, enter_scan, follow, measure_ranges
from codesign.planners.interface import COMMAND, LOAD
from codesign.system.scenarios.drive.tasks import KERNELS
from codesign.system.scenarios.drive.world.belief import Belief
from codesign.system.scenarios.drive.world.inflation import footprint

SIDE = 24


def a_map(seed: int, share: float) -> np.ndarray:
    free: np.ndarray = np.random.Generator(np.random.PCG64(seed)).random((SIDE, SIDE + 5)) >= share
    return free


@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.05, 0.3]), st.sampled_from([0.3, 0.9, 1.7]))
@settings(max_examples=examples(60))
def test_scans_make_the_same_belief(seed: int, share: float, radius: float) -> None:
    """Over three scans of a map that changes between them; the robot is nowhere that a corner is hit."""
    random = np.random.Generator(np.random.PCG64(seed))
    sensor = RaySensor(9.3, 37)
    rows, columns = a_map(0, 0.0).shape
    belief = Belief(rows, columns, radius_cells=radius)
    cells, seen = np.zeros((rows, columns), np.int8), np.full((rows, columns), -1, np.int32)
    stamps = footprint(radius)
    obstacles = np.zeros((rows, columns), np.int32)
    risks = np.zeros((rows, columns), np.int32)
    for down, along in stamps:
        ones = np.ones((rows, columns), np.int32)
        moved = np.zeros_like(ones)
        moved[max(down, 0) : rows + min(down, 0), max(along, 0) : columns + min(along, 0)] = 1
        risks += moved
    outside = belief.planning_free() == 0
    for turn in range(3):
        free = a_map(seed + turn, share)
        y, x = random.uniform(5, SIDE - 5, 2)
        free[math.floor(y + 0.5), math.floor(x + 0.5)] = True
        scan = sensor.scan(free, (y, x))
        belief.update(scan)
        ranges = measure_ranges(free, y, x, sensor.range_cells, sensor.directions)
        limit = sensor.range_cells
        number = enter_scan(cells, obstacles, risks, seen, turn, y, x, limit, ranges, sensor.directions, stamps)
        assert number == scan.cells
        assert (cells == belief.cells).all()
        assert ((obstacles > 0) | outside == ~belief.planning_free()).all()
        assert ((risks > 0) | outside == ~belief.known_free()).all()


@given(st.integers(0, 10_000), st.floats(0.0, 0.999))
@settings(max_examples=examples(150))
def test_commands_give_the_same_authority(seed: int, part: float) -> None:
    """On a way of straight and diagonal steps and of some at any angle, from anywhere on it."""
    random = np.random.Generator(np.random.PCG64(seed))
    steps = random.integers(0, 2, (14, 2)).astype(float)
    steps[steps.sum(axis=1) == 0] = 1.0
    if seed % 3 == 0:
        steps += random.uniform(0.01, 0.4, steps.shape)
    way = Polyline(np.concatenate((np.array([[2.0, 2.0]]), 2.0 + np.cumsum(steps, axis=0))))
    free = a_map(seed, 0.08)
    start = part * way.length
    y, x = way.point_at(start)
    free[math.floor(y + 0.5), math.floor(x + 0.5)] = True
    lookahead = 6.5
    expected = min(authority(way, free, start=start) - start, lookahead)
    risks = (~free).astype(np.int32)
    assert authority_ahead(way.points, risks, y, x, lookahead) == pytest.approx(expected, abs=1e-7)


def test_a_way_followed_is_a_command_from_each_of_its_points() -> None:
    points, risks = np.array([[2.0, 2.0], [2.0, 3.0], [3.0, 4.0]]), np.zeros((9, 9), np.int32)
    # From the first 1 + sqrt 2 cells, from the second sqrt 2, from the last none.
    assert follow(points, risks, 5.0) == pytest.approx(1 + 2 * math.sqrt(2))
    assert follow(points, risks, 0.5) == pytest.approx(1.0)


def test_the_kernels_that_a_drive_charges_for_are_measured() -> None:
    assert {KERNELS[LOAD], KERNELS[COMMAND]} == {OCCUPANCY, FOLLOWING} <= set(all_probes())
