"""Ways, motions and the robot: exact traversal, limits that are kept, and cells that are never entered."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
import simpy
from hypothesis import example, given, settings
from hypothesis import strategies as st

from codesign.components.motion import (
    SECOND,
    DifferentialDrive,
    Kinematics,
    Motion,
    OmnidirectionalDrive,
    PointDrive,
)
from codesign.components.path import NEAR, STANDING_ROOM, Polyline, authority, cell_of, join
from codesign.components.robot import MobileRobot
from codesign.errors import InputError, RunError
from codesign.mission import Appearing, Moving, World
from codesign.mission.obstacles import rectangle

SIDE = 12
# Quarters of a cell: points on borders and on corners are as frequent as others.
quarters = st.integers(-1, 4 * SIDE - 3).map(lambda number: number / 4)
anywhere = st.floats(-0.4, SIDE - 0.6)
points = st.tuples(quarters, quarters) | st.tuples(anywhere, anywhere)
ways = st.lists(points, min_size=1, max_size=7).map(Polyline)
maps = st.tuples(st.integers(0, 2**32), st.sampled_from([0.0, 0.1, 0.3])).map(
    lambda drawn: np.random.default_rng(drawn[0]).random((SIDE, SIDE)) >= drawn[1]
)
kinematics = st.sampled_from(
    [
        PointDrive(0.5),
        OmnidirectionalDrive(0.5, 0.3),
        OmnidirectionalDrive(1.5, 4.0),
        DifferentialDrive(0.5, 0.4, 1.5),
    ]
)


def exact_cells(way: Polyline) -> list[tuple[int, int]]:
    """The cells of a polyline in rational arithmetic: those of its vertices, and of the middles between borders."""
    half = Fraction(1, 2)
    found: list[tuple[int, int]] = []
    for begin, end in zip(way.points[:-1].tolist(), way.points[1:].tolist(), strict=True):
        start = [Fraction(value) for value in begin]
        moved = [Fraction(value) - first for value, first in zip(end, start, strict=True)]
        shares = {Fraction(0), Fraction(1)}
        for first, move in zip(start, moved, strict=True):
            for border in range(-2, SIDE + 2):
                if move and 0 < (share := (border + half - first) / move) < 1:
                    shares.add(share)
        ordered = sorted(shares)
        middles = [(one + other) / 2 for one, other in pairwise(ordered)]
        for share in [Fraction(0), *middles, Fraction(1)]:
            row, column = (
                math.floor(first + share * move + half) for first, move in zip(start, moved, strict=True)
            )
            if not found or found[-1] != (row, column):
                found.append((row, column))
    return found or [cell_of(way.points[0].tolist())]


@given(st.lists(st.tuples(quarters, quarters), min_size=1, max_size=7).map(Polyline))
@settings(max_examples=200, deadline=None)
def test_a_way_enters_the_cells_of_exact_arithmetic(way: Polyline) -> None:
    entry, cells = way.crossings
    assert [tuple(cell) for cell in cells[:, :2].tolist()] == exact_cells(way)
    assert (np.diff(entry) >= 0.0).all()
    for arc, (row, column, *beside) in zip(entry.tolist(), cells.tolist(), strict=True):
        y, x = way.point_at(arc)
        assert max(abs(y - row), abs(x - column)) <= 0.5 + 1e-9, "entered at its border"
        assert {(row, column)} == {tuple(beside[:2]), tuple(beside[2:])} or (
            abs(abs(y - row) - 0.5) < 1e-9 and abs(abs(x - column) - 0.5) < 1e-9
        ), "only a corner has cells beside it"


@given(ways)
@settings(max_examples=100, deadline=None)
def test_cells_of_a_way_touch_and_a_diagonal_has_both_cells_beside_it(way: Polyline) -> None:
    _, cells = way.crossings
    assert tuple(cells[-1, :2]) == cell_of(way.points[-1].tolist())
    for before, here in zip(cells[:-1, :2], cells[1:], strict=True):
        moved = np.abs(here[:2] - before)
        assert moved.max() == 1
        if moved.min() == 1:
            beside = {tuple(here[2:4].tolist()), tuple(here[4:6].tolist())}
            assert beside == {(int(here[0]), int(before[1])), (int(before[0]), int(here[1]))}


def test_authority_ends_before_the_first_cell_that_is_not_known_free() -> None:
    known = np.ones((5, 9), np.bool_)
    straight = Polyline([(2, 0), (2, 8)])
    assert authority(straight, known) == 8.0
    known[2, 5] = False
    assert authority(straight, known) == pytest.approx(4.5 - STANDING_ROOM)
    assert authority(straight, known, start=2.0) == pytest.approx(4.5 - STANDING_ROOM)
    assert authority(straight, known, start=5.2) == 8.0, "its own cell counts as free"
    assert authority(straight, known, start=4.4999) == 4.4999, "never behind the robot"
    assert authority(Polyline([(2, 0), (2, -4)]), known) == pytest.approx(0.5 - STANDING_ROOM), (
        "outside is closed"
    )


@pytest.mark.parametrize("closed", [(2, 3), (3, 2)])
def test_authority_cuts_no_corner(closed: tuple[int, int]) -> None:
    known = np.ones((5, 5), np.bool_)
    diagonal = Polyline([(1, 1), (4, 4)])
    assert authority(diagonal, known) == diagonal.length
    known[closed] = False
    assert authority(diagonal, known) == pytest.approx(1.5 * math.sqrt(2) - STANDING_ROOM)


@pytest.mark.parametrize("points", [[], [[1, 2, 3]], [[0, 0], [0, math.nan]]])
def test_what_is_no_way_is_refused(points: list[list[float]]) -> None:
    with pytest.raises(InputError, match="n × 2 finite numbers"):
        Polyline(np.array(points))


def test_points_that_repeat_are_left_out() -> None:
    way = Polyline([(1, 1), (1, 1), (1, 3), (1, 3), (2, 3)])
    assert way.points.tolist() == [[1, 1], [1, 3], [2, 3]]
    assert way.arcs.tolist() == [0, 2, 3]
    assert way.cut(1.0).points.tolist() == [[1, 2], [1, 3], [2, 3]]
    assert way.cut(2.0).points.tolist() == [[1, 3], [2, 3]]


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_points_closer_than_arc_lengths_can_tell_are_left_out() -> None:
    """Else a segment of no length is a bend of which nobody can tell how fast it may be driven."""
    way = Polyline([(0, 0), (0, 1), (1e-160, 1), (1, 1)])
    assert way.points.tolist() == [[0, 0], [0, 1], [1, 1]]
    assert way.arcs.tolist() == [0, 1, 2]
    straight = Polyline([(0, -0.25), (0, 0), (0, 1e-160), (0, 1)])
    drive = DifferentialDrive(0.5, 0.4, 1.5)
    motion, plain = (
        Motion.drive(each, drive, 9.0) for each in (straight, Polyline([(0, -0.25), (0, 0), (0, 1)]))
    )
    assert motion is not None
    assert plain is not None
    assert (motion.end, motion.duration) == (plain.end, plain.duration)


def test_join_goes_on_along_the_way() -> None:
    way = Polyline([(1, 1), (1, 5), (5, 5)])
    assert join(way, (1.0, 2.5)).points.tolist() == [[1, 2.5], [1, 5], [5, 5]]
    assert join(way, (1.0, 5.0)).points.tolist() == [[1, 5], [5, 5]]
    assert join(way, (1.0 + NEAR / 2, 3.0)).points.tolist() == [[1 + NEAR / 2, 3], [1, 5], [5, 5]]
    twice = Polyline([(1, 1), (1, 5), (3, 5), (3, 3), (1, 3), (0, 3)])
    assert join(twice, (1.0, 3.0)).points.tolist() == [[1, 3], [0, 3]], "the later of two passes"


def test_join_from_beside_the_way_looks_ahead_but_not_through_a_wall() -> None:
    way = Polyline([(1, 0), (1, 8)])
    assert join(way, (2.0, 3.0), lookahead=1.5).points.tolist() == [[2, 3], [1, 4.5], [1, 8]]
    free = np.ones((4, 9), np.bool_)
    free[1, 4] = False
    around = Polyline([(1, 0), (1, 3), (3, 3), (3, 8)])
    assert join(around, (1.0, 5.0), free, lookahead=0.0).points.tolist() == [[1, 5], [3, 5], [3, 8]]
    assert join(Polyline([(1, 1)]), (1.0, 3.0)).points.tolist() == [[1, 3], [1, 1]]


def sampled(motion: Motion, count: int = 400) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (s), arcs and speeds over the whole motion and a little after it."""
    times = np.unique(np.linspace(0, motion.duration * 1.05 + 10, count).astype(np.int64))
    states = np.array([motion.at(int(time)) for time in times])
    return times / SECOND, states[:, 0], states[:, 1]


@given(ways, kinematics, st.floats(0.0, 60.0))
@settings(max_examples=150, deadline=None)
def test_a_motion_keeps_its_limits_and_stands_at_its_authority(
    way: Polyline, limits: Kinematics, allowed: float
) -> None:
    motion = Motion.drive(way, limits, allowed)
    assert motion is not None
    assert motion.end == pytest.approx(min(allowed, way.length), abs=NEAR)
    assert motion.end <= min(allowed, way.length)
    times, arcs, speeds = sampled(motion)
    assert (arcs[-1], speeds[-1]) == (motion.end, 0.0)
    assert (np.diff(arcs) >= 0.0).all()
    assert speeds.max() <= limits.speed * (1 + 1e-9)
    # The arc is the integral of the speed: between two times it lies between what their least and most allow.
    assert (np.diff(arcs) <= limits.speed * np.diff(times) * (1 + 1e-9) + 1e-9).all()
    if not isinstance(limits, PointDrive):
        allowed_change = limits.acceleration * np.diff(times) * (1 + 1e-6) + 1e-6
        assert (np.abs(np.diff(speeds)) <= allowed_change).all()
        means = (speeds[1:] + speeds[:-1]) / 2
        bound = limits.acceleration * np.diff(times) ** 2 + 1e-9
        assert (np.abs(np.diff(arcs) - means * np.diff(times)) <= bound).all()


@given(ways, st.sampled_from([OmnidirectionalDrive(1.5, 4.0), DifferentialDrive(0.5, 0.4, 1.5)]))
@settings(max_examples=100, deadline=None)
def test_corners_are_taken_as_slowly_as_they_need(
    way: Polyline, limits: OmnidirectionalDrive | DifferentialDrive
) -> None:
    period = SECOND // 5
    motion = Motion.drive(way, limits, way.length, control_period=period)
    assert motion is not None
    for index in range(1, len(way.arcs) - 1):
        change = math.remainder(float(way.headings[index] - way.headings[index - 1]), 2 * math.pi)
        _, speed = motion.at(motion.time_at(float(way.arcs[index])))
        if isinstance(limits, OmnidirectionalDrive):
            assert 2 * speed * math.sin(abs(change) / 2) <= limits.acceleration * 0.2 + 1e-6
        elif abs(change) > limits.smooth:
            assert speed <= 1e-5


def circle(count: int, radius: float) -> Polyline:
    """Twice around, ``count`` points a turn."""
    angle = np.arange(2 * count) * (2 * math.pi / count)
    return Polyline(radius * np.column_stack((np.sin(angle), np.cos(angle))))


@given(
    st.integers(10, 200),
    st.floats(0.5, 20.0),
    st.sampled_from([OmnidirectionalDrive(0.5, 0.3), OmnidirectionalDrive(2.5, 4.0)]),
    st.sampled_from([SECOND // 25, SECOND // 10, SECOND // 2]),
)
@settings(max_examples=100, deadline=None)
def test_a_bend_in_many_small_corners_is_taken_as_slowly_as_its_radius_needs(
    count: int, radius: float, limits: OmnidirectionalDrive, period: int
) -> None:
    way = circle(count, radius)
    motion = Motion.drive(way, limits, way.length, control_period=period)
    assert motion is not None
    speeds = np.array([motion.at(motion.time_at(float(arc)))[1] for arc in way.arcs])
    assert speeds.max() ** 2 / radius <= limits.acceleration * 1.05
    if 2 * math.pi * radius / count < 0.05 * limits.speed * (period / SECOND):
        # Finely cut, it is not taken more slowly than that either.
        reachable = min(limits.speed, math.sqrt(0.9 * limits.acceleration * radius))
        assert speeds.max() >= min(reachable, math.sqrt(limits.acceleration * way.length) * 0.9)


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


@given(ways, kinematics, st.floats(0.0, 1.0))
@settings(max_examples=100, deadline=None)
def test_the_time_of_an_arc_is_the_first_at_which_it_is_reached(
    way: Polyline, limits: Kinematics, share: float
) -> None:
    motion = Motion.drive(way, limits, way.length)
    assert motion is not None
    arc = motion.end * share
    time = motion.time_at(arc)
    assert motion.at(time)[0] >= arc - 1e-9
    assert time == 0 or motion.at(time - 2)[0] <= arc + 1e-12


def duration(limits: Kinematics, *points: tuple[float, float], heading: float = 0.0) -> float:
    motion = Motion.drive(Polyline(points), limits, math.inf, heading=heading)
    assert motion is not None
    return motion.duration / SECOND


def test_durations_in_closed_form() -> None:
    assert duration(PointDrive(2.0), (0, 0), (3, 4), (3, 10)) == pytest.approx(5.5)
    trapezoid = OmnidirectionalDrive(2.0, 1.0)
    assert duration(trapezoid, (0, 0), (0, 10)) == pytest.approx(10 / 2 + 2 / 1)
    assert duration(trapezoid, (0, 0), (0, 1), (0, 3), (0, 10)) == pytest.approx(10 / 2 + 2 / 1)
    assert duration(trapezoid, (0, 0), (0, 1)) == pytest.approx(2 * math.sqrt(1 / 1))
    wheels = DifferentialDrive(2.0, 1.0, math.pi / 4)
    assert duration(wheels, (0, 0), (0, 10)) == pytest.approx(7)
    assert duration(wheels, (0, 0), (0, 10), heading=math.pi) == pytest.approx(7 + 4), "turns about first"
    assert duration(wheels, (0, 0), (0, 10), (10, 10)) == pytest.approx(7 + 2 + 7)


def test_a_turn_on_the_spot_turns_evenly_the_short_way_round() -> None:
    motion = Motion.drive(
        Polyline([(0, 0), (0, 10), (-10, 10)]), DifferentialDrive(2.0, 1.0, math.pi / 4), math.inf
    )
    assert motion is not None
    assert [motion.heading_at(time * SECOND) for time in (0, 8, 10, 20)] == pytest.approx(
        [0.0, -math.pi / 4, -math.pi / 2, -math.pi / 2]
    )
    assert motion.at(8 * SECOND) == (10.0, 0.0)


def test_a_speed_that_a_way_cannot_take_over_is_refused() -> None:
    limits = OmnidirectionalDrive(2.0, 1.0)
    straight, back = Polyline([(0, 0), (0, 10)]), Polyline([(0, 0), (0, -10)])
    assert Motion.drive(straight, limits, 10.0, speed=2.0) is not None
    assert Motion.drive(straight, limits, 2.0, speed=2.0) is not None, "exactly the braking distance"
    assert Motion.drive(straight, limits, 1.99, speed=2.0) is None
    assert Motion.drive(straight, limits, 0.0, speed=1.0) is None
    assert Motion.drive(back, limits, 10.0, speed=2.0) is None
    assert Motion.drive(back, limits, 10.0, speed=0.04) is not None, "2 v ≤ acceleration × control period"
    assert Motion.drive(back, PointDrive(2.0), 10.0, speed=2.0) is not None


@pytest.mark.parametrize("build", [PointDrive, lambda speed: OmnidirectionalDrive(1.0, speed)])
def test_limits_that_cannot_be_are_refused(build: type[PointDrive]) -> None:
    for value in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="finite number above 0"):
            build(value)


def a_robot(limits: Kinematics, position: tuple[float, float], resolution: float = 1.0) -> MobileRobot:
    return MobileRobot(
        simpy.Environment(), "robot", kinematics=limits, resolution=resolution, position=position
    )


OPEN = np.zeros((SIDE, SIDE), np.bool_)


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
    for limits in (
        PointDrive(2.0),
        OmnidirectionalDrive(2.0, 1.0),
        DifferentialDrive(2.0, 1.0, math.pi / 4),
    ):
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
@settings(max_examples=150, deadline=None)
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


@given(
    st.integers(0, 2**32),
    kinematics,
    st.sampled_from([0.0, 0.4, 0.8, 1.3]),
    st.sampled_from([0.0, 0.5]),
)
@settings(max_examples=60, deadline=None)
@example(0, PointDrive(0.5), 0.0, 0.0)
def test_the_robot_is_never_in_a_blocked_cell(
    seed: int, limits: Kinematics, radius: float, margin: float
) -> None:
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
@settings(max_examples=80, deadline=None)
def test_within_its_authority_a_robot_touches_nothing_and_always_stands_there(
    seed: int, limits: Kinematics
) -> None:
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
