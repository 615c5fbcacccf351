"""The robot: contacts, stops, and cells that are never entered."""

from __future__ import annotations

import math

import numpy as np
import pytest
import simpy
from drives_and_ways import OPEN, SIDE, a_robot, circle, kinematics, maps, ways
from examples import examples
from hypothesis import example, given, settings
from hypothesis import strategies as st

from codesign.components import MobileRobot
from codesign.components.path import NEAR, Polyline, authority, cell_of, join
from codesign.components.robot import SECOND, DifferentialDrive, Kinematics, Motion, OmnidirectionalDrive, PointDrive
from codesign.ground.errors import InputError, RunError
from codesign.system.scenarios.drive.world import Appearing, Moving, World
from codesign.system.scenarios.drive.world.obstacles import rectangle


def test_metres_become_cells() -> None:
    robot = a_robot(PointDrive(0.5), (2.0, 2.0), resolution=0.1)
    assert robot.command(0, Polyline([(2, 2), (2, 9)]), 7.0) is None
    robot.advance(SECOND, OPEN)
    assert robot.position == pytest.approx((2.0, 7.0))
    assert (robot.speed, robot.distance) == pytest.approx((5.0, 5.0))
    assert robot.distance_metres == pytest.approx(0.5)
    robot.advance(3 * SECOND, OPEN)
    assert (robot.position, robot.speed, robot.cell) == ((2.0, 9.0), 0.0, (2, 9))
    assert (robot.moving, robot.standing) == (14 * SECOND // 10, 16 * SECOND // 10)


def test_a_contact_is_told_with_its_time_place_and_speed() -> None:
    blocked = OPEN.copy()
    blocked[2, 6] = True
    robot = a_robot(PointDrive(2.0), (2.0, 2.0))
    robot.command(0, Polyline([(2, 2), (2, 9)]), 7.0)
    assert robot.advance(SECOND, blocked) is None
    contact = robot.advance(5 * SECOND, blocked)
    assert contact is not None
    assert robot.contacts == [contact]
    assert contact.time / SECOND == pytest.approx(3.5 / 2, abs=1e-6)
    assert contact.position == robot.position == (2.0, pytest.approx(5.5, abs=2 * NEAR))
    assert (contact.cell, contact.speed, robot.cell, robot.speed) == ((2, 6), 2.0, (2, 5), 0.0)
    assert robot.moving == contact.time
    # Told to drive on, it stays where it is, and that is no new contact.
    robot.command(5 * SECOND, join(Polyline([(2, 2), (2, 9)]), robot.position), 7.0)
    robot.advance(6 * SECOND, blocked)
    assert robot.cell == (2, 5)
    assert len(robot.contacts) == 1
    # The obstacle goes, and so does the robot.
    robot.command(6 * SECOND, join(Polyline([(2, 2), (2, 9)]), robot.position), 7.0)
    robot.advance(9 * SECOND, OPEN)
    assert robot.position == (2.0, 9.0)


@pytest.mark.parametrize("closed", [(2, 3), (3, 2)])
def test_a_robot_cuts_no_corner(closed: tuple[int, int]) -> None:
    blocked = OPEN.copy()
    blocked[closed] = True
    robot = a_robot(PointDrive(1.0), (1.0, 1.0))
    robot.command(0, Polyline([(1, 1), (4, 4)]), math.inf)
    contact = robot.advance(9 * SECOND, blocked)
    assert contact is not None
    assert (contact.cell, robot.cell) == (closed, (2, 2))


def test_turning_on_a_border_it_has_not_entered_the_cell_ahead() -> None:
    """(4.5, 2) is of cell (5, 2); the robot turns there, then drives towards smaller rows."""
    blocked = OPEN.copy()
    blocked[4, 2] = True
    robot = a_robot(DifferentialDrive(1.0, 1.0, 1.0), (4.5, 2.0))
    robot.command(0, Polyline([(4.5, 2), (0, 2)]), 4.0)
    for time in (1, SECOND, 9 * SECOND):
        robot.advance(time, blocked)
    assert (robot.position, robot.cell) == ((4.5, 2.0), (5, 2))
    [contact] = robot.contacts
    assert contact.time / SECOND == pytest.approx(math.pi / 2), "when it has turned"


def test_a_stop_takes_the_braking_distance_and_counts_once() -> None:
    robot = a_robot(OmnidirectionalDrive(2.0, 1.0), (5.0, 0.0))
    robot.command(0, Polyline([(5, 0), (5, 11)]), 11.0)
    robot.advance(3 * SECOND, OPEN)
    assert (robot.arc, robot.speed) == pytest.approx((4.0, 2.0))
    assert robot.stop(3 * SECOND) == 5 * SECOND
    robot.advance(4 * SECOND, OPEN)
    assert robot.stop(4 * SECOND) == 5 * SECOND
    assert robot.safety_stops == 1, "one braking"
    robot.advance(10 * SECOND, OPEN)
    assert robot.position == pytest.approx((5.0, 4.0 + 2.0**2 / 2))
    robot.stop(10 * SECOND)
    assert robot.safety_stops == 1
    assert robot.moving == 5 * SECOND
    robot.command(10 * SECOND, Polyline([robot.position, (5, 11)]), 5.0)
    robot.advance(11 * SECOND, OPEN)
    robot.stop(11 * SECOND)
    assert robot.safety_stops == 2, "a command came in between"


def test_a_way_that_cannot_be_taken_over_makes_the_robot_brake_within_its_old_authority() -> None:
    robot = a_robot(OmnidirectionalDrive(2.0, 1.0), (5.0, 0.0))
    robot.command(0, Polyline([(5, 0), (5, 9)]), 9.0)
    robot.advance(3 * SECOND, OPEN)
    turned = Polyline([robot.position, (0.0, robot.position[1])])
    assert robot.command(3 * SECOND, turned, turned.length) == 5 * SECOND
    robot.advance(4 * SECOND, OPEN)
    assert robot.position == pytest.approx((5.0, 5.5)), "still on the old way"
    robot.advance(5 * SECOND, OPEN)
    assert robot.position == pytest.approx((5.0, 6.0))
    assert robot.position[1] <= 9.0
    turned = Polyline([robot.position, (0.0, 6.0)])
    assert robot.command(5 * SECOND, turned, turned.length) is None
    robot.advance(20 * SECOND, OPEN)
    assert robot.position == pytest.approx((0.0, 6.0))


def test_a_command_again_and_again_along_one_way_loses_no_time() -> None:
    for limits in (PointDrive(2.0), OmnidirectionalDrive(2.0, 1.0), DifferentialDrive(2.0, 1.0, math.pi / 4)):
        way = Polyline([(1, 1), (1, 4), (1.1, 6), (4, 8), (9, 8), (9, 2)])
        once, often = a_robot(limits, (1.0, 1.0)), a_robot(limits, (1.0, 1.0))
        once.command(0, way, way.length)
        for time in range(0, 60 * SECOND, SECOND // 10):
            often.advance(time, OPEN)
            left = join(way, often.position)
            assert often.command(time, left, left.length) is None
            once.advance(time, OPEN)
            assert often.position == pytest.approx(once.position, abs=1e-4)
        assert often.position == pytest.approx((9.0, 2.0), abs=1e-4)


def test_misuse_is_refused() -> None:
    robot = a_robot(PointDrive(2.0), (2.0, 2.0))
    robot.advance(10, OPEN)
    with pytest.raises(RunError, match="cannot go back to 5 ps"):
        robot.advance(5, OPEN)
    with pytest.raises(RunError, match="advance it first"):
        robot.stop(20)
    with pytest.raises(RunError, match="advance it first"):
        robot.command(20, Polyline([(2, 2)]), 0.0)
    with pytest.raises(InputError, match="begin it at the position of the robot"):
        robot.command(10, Polyline([(2, 3), (2, 4)]), 1.0)
    with pytest.raises(InputError, match=r"robot\.resolution"):
        a_robot(PointDrive(2.0), (2.0, 2.0), resolution=0.0)


def test_it_is_busy_while_it_moves() -> None:
    environment = simpy.Environment()
    robot = MobileRobot(environment, "robot", kinematics=PointDrive(1.0), resolution=1.0, position=(1.0, 1.0))
    robot.command(0, Polyline([(1, 1), (1, 4)]), 3.0)
    environment.run(until=2 * SECOND)
    assert robot.busy == 2 * SECOND
    robot.advance(2 * SECOND, OPEN)
    environment.run(until=9 * SECOND)
    assert robot.busy == 3 * SECOND
    robot.advance(9 * SECOND, OPEN)
    assert robot.busy == robot.moving == 3 * SECOND


@given(ways, kinematics, maps, st.lists(st.integers(1, 40 * SECOND), max_size=12), st.floats(0.0, 30.0))
@settings(max_examples=examples(150))
def test_many_steps_and_one_step_end_alike(
    way: Polyline, limits: Kinematics, free: np.ndarray, times: list[int], allowed: float
) -> None:
    blocked = ~free
    robots = []
    for moments in ([], sorted(times)):
        robot = a_robot(limits, way.point_at(0.0))
        robot.command(0, way, allowed)
        for moment in [*moments, 40 * SECOND]:
            robot.advance(moment, blocked)
        robots.append(robot)
    one, many = robots
    assert many.position == pytest.approx(one.position, abs=1e-9)
    assert (many.speed, many.heading) == pytest.approx((one.speed, one.heading), abs=1e-9)
    assert many.distance == pytest.approx(one.distance, abs=1e-9)
    assert (many.moving, many.standing) == (one.moving, one.standing)
    assert many.contacts == one.contacts
    assert many.log == one.log


@given(st.integers(0, 2**32), kinematics, st.sampled_from([0.0, 0.4, 0.8, 1.3]), st.sampled_from([0.0, 0.5]))
@settings(max_examples=examples(60))
@example(0, PointDrive(0.5), 0.0, 0.0)
def test_the_robot_is_never_in_a_blocked_cell(seed: int, limits: Kinematics, radius: float, margin: float) -> None:
    """Random walls, obstacles that appear, vanish and move, and a robot that is sent anywhere, without authority."""
    random = np.random.default_rng(seed)
    free = random.random((SIDE, SIDE)) >= 0.1
    start = (int(random.integers(3, SIDE - 3)), int(random.integers(3, SIDE - 3)))
    free[start[0] - 2 : start[0] + 3, start[1] - 2 : start[1] + 3] = True

    def a_time() -> int:
        return int(random.integers(0, 20 * SECOND))

    appearing = [
        Appearing(at, rectangle(*random.integers(0, SIDE - 2, 2).tolist(), 2, 2), at + 1 + a_time())
        for at in (a_time() for _ in range(12))
    ]
    moving = [
        Moving((1, 2), tuple(map(tuple, random.integers(0, SIDE - 2, (3, 2)).tolist())), 2.0, a_time())
        for _ in range(3)
    ]
    world = World(free, appearing=appearing, moving=moving, radius_cells=radius, margin_cells=margin)
    robot = a_robot(limits, (float(start[0]), float(start[1])))
    now = 0
    while now < 30 * SECOND:
        robot.advance(now, world.blocked_for_robot)
        assert not world.blocked_for_robot[robot.cell]
        if world.next_change(now) == now:
            world.advance(now, robot.position)
            assert not world.blocked_for_robot[robot.cell], "nothing comes over the robot"
        chance = random.random()
        if chance < 0.3:
            bends = random.uniform(-0.5, SIDE - 0.5, (3, 2)).round(int(random.integers(0, 4)))
            way = Polyline(np.concatenate(([robot.position], bends)))
            robot.command(now, way, way.length)
        elif chance < 0.35:
            robot.stop(now)
        step = now + int(random.integers(1, SECOND))
        change = world.next_change(now + 1)
        now = step if change is None else min(step, change)
    for _, row, column in robot.log:
        assert free[cell_of((row, column))], "it never entered a wall in between"
    assert robot.moving + robot.standing == robot.time


@given(st.integers(0, 2**32), kinematics)
@settings(max_examples=80)
def test_within_its_authority_a_robot_touches_nothing_and_always_stands_there(seed: int, limits: Kinematics) -> None:
    """Authority only over cells that are free, renewed at random: no contact, and no braking past it."""
    random = np.random.default_rng(seed)
    free = random.random((SIDE, SIDE)) >= 0.15
    start = (5.0, 5.0)
    free[5, 5] = True
    robot = a_robot(limits, start)
    now = 0
    for _ in range(60):
        now += int(random.integers(1, SECOND))
        robot.advance(now, ~free)
        assert robot.arc <= robot.authority
        if random.random() < 0.5:
            bends = random.uniform(-0.5, SIDE - 0.5, (2, 2))
            way = Polyline(np.concatenate(([robot.position], bends)))
            end = robot.authority
            refused = robot.command(now, way, authority(way, free))
            assert refused is None or robot.authority <= end + 1e-9
    robot.advance(now + 100 * SECOND, ~free)
    assert robot.speed == 0.0
    assert robot.contacts == []


def test_a_bend_is_driven_as_fast_when_its_way_is_given_anew_at_every_turn() -> None:
    limits, period, radius = OmnidirectionalDrive(2.5, 4.0), SECOND // 10, 0.75
    way = Polyline(circle(100, radius).points[:76] + 5.0)
    once = Motion.drive(way, limits, way.length)
    assert once is not None
    robot = a_robot(limits, way.point_at(0.0))
    robot.command(0, way, way.length)
    for turn in range(1, once.duration // period + 1):
        robot.advance(turn * period, OPEN)
        assert (robot.distance, robot.speed) == pytest.approx(once.at(turn * period), abs=1e-3)
        assert robot.speed**2 / radius <= limits.acceleration * 1.05
        ahead = join(way, robot.position)
        assert robot.command(turn * period, ahead, ahead.length) is None
