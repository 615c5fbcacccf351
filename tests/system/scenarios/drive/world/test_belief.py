"""What the robot believes: incremental maps are those made anew, and every exploration ends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from codesign.components.sensor import NOTHING, RadiusSensor, RangeScan, RaySensor, Sensor
from codesign.ground.errors import InputError
from codesign.system.scenarios.drive.world import Belief, Frontiers, Inflation
from codesign.system.scenarios.drive.world.belief import BLOCKED, FREE, UNKNOWN

SIDE = 12
radii = st.sampled_from([0.0, 0.5, 0.8, 1.2])
sensors = st.sampled_from([RaySensor(3.0, 8), RaySensor(5.0, 40), RadiusSensor(2.5), RadiusSensor(0.0)])


def a_map(seed: int, share: float = 0.2) -> np.ndarray:
    return np.random.default_rng(seed).random((SIDE, SIDE)) >= share


@given(st.integers(0, 2**32), radii, sensors, st.booleans())
@settings(max_examples=examples(100))
def test_belief_after_scans_is_belief_made_anew(seed: int, radius: float, sensor: Sensor, knows: bool) -> None:
    """The true map changes all the time, so cells change between all three states but back to unknown."""
    random = np.random.default_rng(seed)
    known = a_map(seed) if knows else None
    unknown = random.random((SIDE, SIDE)) < 0.3 if knows else None
    belief = Belief(SIDE, SIDE, known, unknown=unknown, radius_cells=radius)
    expected = belief.cells.copy()
    for turn in range(6):
        free = a_map(seed + turn)
        position = tuple(random.uniform(-0.5, SIDE - 0.51, 2).tolist())
        cell = tuple(math.floor(part + 0.5) for part in position)
        free[cell] = True
        scan = sensor.scan(free, position)
        before = expected.copy()
        expected[scan.free[:, 0], scan.free[:, 1]] = FREE
        expected[scan.blocked[:, 0], scan.blocked[:, 1]] = BLOCKED
        update = belief.update(scan)
        np.testing.assert_array_equal(belief.cells, expected)
        changed = {tuple(each) for each in np.argwhere(before != expected).tolist()}
        assert {tuple(each) for each in update.changed.tolist()} == changed
        assert bool(update) == bool(changed)
        assert (expected[update.newly_free[:, 0], update.newly_free[:, 1]] == FREE).all()
        assert (expected[update.newly_blocked[:, 0], update.newly_blocked[:, 1]] == BLOCKED).all()
        planning = ~Inflation(expected == BLOCKED, radius).blocked
        safe = ~Inflation(expected != FREE, radius).blocked
        np.testing.assert_array_equal(belief.planning_free(), planning)
        np.testing.assert_array_equal(belief.known_free(), safe)
        np.testing.assert_array_equal(belief.blocked_for_robot, ~planning)
        assert not (safe & ~planning).any(), "what is known free is free for planning"
        planning[cell] = safe[cell] = True
        np.testing.assert_array_equal(belief.planning_free(cell), planning)
        np.testing.assert_array_equal(belief.known_free(cell), safe)
        assert belief.known_share == (expected != UNKNOWN).mean()


def test_what_is_known_free_is_truly_free_for_the_robot() -> None:
    for seed in range(20):
        free = a_map(seed)
        free[5, 5] = True
        belief = Belief(SIDE, SIDE, radius_cells=0.8)
        belief.update(RaySensor(6.0, 60).scan(free, (5.0, 5.0)))
        assert not (belief.known_free() & Inflation(~free, 0.8).blocked).any()


def test_a_copy_is_handed_out_and_cells_cannot_be_written() -> None:
    belief = Belief(3, 3, np.ones((3, 3), np.bool_))
    belief.planning_free()[1, 1] = False
    belief.known_free()[1, 1] = False
    assert belief.planning_free().all()
    assert belief.known_free().all()
    with pytest.raises(ValueError, match="read-only"):
        belief.cells[0, 0] = 0


def test_a_known_map_of_another_size_is_refused() -> None:
    with pytest.raises(InputError, match="3 × 4 cells"):
        Belief(3, 4, np.ones((3, 3), np.bool_))


def test_nothing_known_is_all_open_to_planning_and_closed_to_driving() -> None:
    belief = Belief(4, 4)
    assert belief.planning_free().all()
    assert belief.known_free((1, 1)).sum() == 1
    assert not belief.update(NOTHING)


@given(st.integers(0, 2**32), st.sampled_from([0.1, 0.4]))
@settings(max_examples=examples(100))
def test_frontier_cells_by_their_definition(seed: int, share: float) -> None:
    random = np.random.default_rng(seed)
    belief = Belief(SIDE, SIDE, a_map(seed), unknown=random.random((SIDE, SIDE)) < share)
    robot = (int(random.integers(SIDE)), int(random.integers(SIDE)))
    free = belief.cells == FREE
    free[robot] = True
    labels, _ = ndimage.label(free)
    expected = [
        (row, column)
        for row, column in np.argwhere(labels == labels[robot]).tolist()
        if any(
            0 <= row + down < SIDE
            and 0 <= column + along < SIDE
            and belief.cells[row + down, column + along] == UNKNOWN
            and (row + down, column + along) != robot
            for down, along in ((0, 1), (0, -1), (1, 0), (-1, 0))
        )
    ]
    assert Frontiers(belief).goals(robot) == expected


@given(st.integers(0, 2**32), radii, sensors)
@settings(max_examples=examples(60))
def test_every_exploration_ends_and_has_seen_what_can_be_seen(seed: int, radius: float, sensor: Sensor) -> None:
    """A robot that is put on the nearest frontier again and again: it ends, never in a wall."""
    free = a_map(seed, 0.1)
    middle = SIDE // 2
    free[middle - 2 : middle + 3, middle - 2 : middle + 3] = True
    blocked = Inflation(~free, radius).blocked
    belief = Belief(SIDE, SIDE, radius_cells=radius)
    frontiers = Frontiers(belief)
    robot = (middle, middle)
    for _ in range(2 * SIDE * SIDE):
        belief.update(sensor.scan(free, robot))
        frontiers.looked(robot)
        goals = frontiers.goals(robot)
        if not goals:
            break
        robot = min(goals, key=lambda goal: math.dist(goal, robot))
        assert not blocked[robot]
    else:
        raise AssertionError("the exploration did not end")
    if frontiers.barren == 0:
        labels, _ = ndimage.label(~blocked)
        room = labels == labels[middle, middle]
        assert belief.known_free(robot)[room].all(), "all that can be reached is known"
    elif isinstance(sensor, RadiusSensor) and sensor.range_cells > radius + 2.0:
        raise AssertionError("a disc that covers the next cells leaves nothing barren")


def test_a_barren_frontier_is_no_goal_again() -> None:
    belief = Belief(1, 5)
    seen = np.array([[0, 0], [0, 1]])
    belief.update(RangeScan(seen, np.zeros((0, 2), np.int64)))
    frontiers = Frontiers(belief)
    assert frontiers.goals((0, 0)) == [(0, 1)]
    assert not frontiers.looked((0, 0)), "not on the frontier"
    assert frontiers.looked((0, 1))
    assert (frontiers.goals((0, 0)), frontiers.barren) == ([], 1)
