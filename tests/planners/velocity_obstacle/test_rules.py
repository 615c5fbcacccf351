"""The rules that docs/velocity_obstacle.md lists one by one, each on its own."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import reference_robots
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.planners.velocity_obstacle.plan import AvoidParameters, RobotsProblem, avoid, generate
from codesign.planners.velocity_obstacle.plan import reference as plain
from codesign.planners.velocity_obstacle.plan.arithmetic import HEADROOM, Arithmetic, double, fixed, quantise
from codesign.planners.velocity_obstacle.plan.loop import Loop
from codesign.planners.velocity_obstacle.plan.parameters import Detection, Gains
from codesign.planners.velocity_obstacle.plan.reference import BRAKE, STAY, RobotState

PROBLEM = generate("circle", 4)


def numbers_of(**changes: Any) -> Arithmetic:
    return fixed(PROBLEM, AvoidParameters(**changes))


@pytest.mark.parametrize("turn", [180.0, 135.0, 45.0])
@pytest.mark.parametrize("heading", [0, 10, 63])
def test_rotation_goes_both_ways_growing_angles_first_and_then_to_the_next_lower_speed(
    turn: float, heading: int
) -> None:
    numbers = numbers_of(turn=turn, speeds=5)
    order = [divmod(candidate, 64) for candidate in plain.candidates(numbers, heading)]
    rotations = [0, *(sign * step for step in range(1, 33) for sign in (1, -1))]
    kept = [one for one in rotations if abs(one) * 360.0 / 64.0 <= turn and one != -32]
    assert order == [(speed, (heading + one) % 64) for speed in range(5) for one in kept]
    speeds = [math.hypot(*numbers.velocities[speed][heading]) for speed in range(5)]
    assert speeds == sorted(speeds, reverse=True)
    angle = [math.atan2(y, x) for x, y in (numbers.velocities[0][k] for k in (0, 1))]
    assert angle[0] == 0.0 < angle[1]


def test_a_target_half_way_between_two_directions_belongs_to_the_one_nearer_to_an_axis() -> None:
    numbers = numbers_of()
    for k, (cosine, sine) in enumerate(numbers.bounds):
        mirrored = {
            (cosine, sine): k,
            (sine, cosine): 16 - k,
            (-sine, cosine): 16 + k,
            (-cosine, sine): 32 - k,
            (-cosine, -sine): 32 + k,
            (cosine, -sine): -k % 64,
        }
        for target, direction in mirrored.items():
            assert plain.to_goal(numbers, RobotState((0, 0), target)) == direction


def test_a_robot_sees_the_others_one_step_later_at_their_present_velocities(monkeypatch: pytest.MonkeyPatch) -> None:
    numbers, parameters, seen = numbers_of(), AvoidParameters(), []

    def noted(numbers: Any, position: Any, velocity: Any, detection: Any) -> bool:
        seen.append((position, velocity))
        return False

    monkeypatch.setattr(plain, "coll_detect", noted)
    now, far = (1000, 0), (6000, 0)
    robots = [RobotState((0, 0), (9000, 0), now), RobotState(far, (0, 0), (-8000, 400))]
    choice = plain.choose(numbers, robots, 0, parameters)
    there = plain.pos_vel_update(numbers, far, (-8000, 400), (0, 0))
    change = tuple(
        numbers.rescale((wanted - own) * numbers.inverse_step, "change_inverse_step")
        for wanted, own in zip(numbers.velocities[choice.candidate // 64][choice.candidate % 64], now, strict=True)
    )
    (px, py), (vx, vy) = plain.pos_vel_update(numbers, (0, 0), now, change)
    own = 2 * vx - now[0], 2 * vy - now[1]
    wanted = (px - there[0][0], py - there[0][1]), (own[0] + 8000, own[1] - 400)
    assert seen == [wanted]


def test_thresholds_belong_to_the_side_that_is_told() -> None:
    numbers = double(PROBLEM, AvoidParameters(margin=0.0, range=40.0, tolerance=3.0))
    for detection in Detection:
        # Past each other at exactly the combined radius of 10 cells, and just below.
        assert not plain.coll_detect(numbers, (-20.0, 10.0), (1.0, 0.0), detection)
        assert plain.coll_detect(numbers, (-20.0, 9.999), (1.0, 0.0), detection)
        assert plain.coll_detect(numbers, (-40.0, 0.0), (1.0, 0.0), detection)
        assert not plain.coll_detect(numbers, (-40.001, 0.0), (1.0, 0.0), detection)
    side_by_side = (0.0, 9.0), (1.0, 0.0)
    assert plain.coll_detect(numbers, *side_by_side, Detection.PUBLISHED)
    assert not plain.coll_detect(numbers, *side_by_side, Detection.APPROACHING)
    assert reference_robots.target_check(numbers, RobotState((0.0, 0.0), (3.0, 0.0)))
    assert not reference_robots.target_check(numbers, RobotState((0.0, 0.0), (3.001, 0.0)))


@settings(max_examples=examples(100))
@given(st.tuples(st.integers(-25_000, 25_000), st.integers(-25_000, 25_000)))
def test_braking_is_of_each_axis_by_itself_and_no_more_than_a_step_allows(velocity: tuple[int, int]) -> None:
    numbers = numbers_of()
    slower = plain.brake(numbers, velocity)
    for before, after in zip(velocity, slower, strict=True):
        assert abs(after) == max(0, abs(before) - numbers.brake)
        assert before * after >= 0
    change = [after - before for before, after in zip(velocity, slower, strict=True)]
    assert change[0] ** 2 + change[1] ** 2 <= numbers.change_squared


def test_a_robot_that_has_arrived_stays_so_brakes_and_rests() -> None:
    run = avoid(generate("random", 6, seed=3), AvoidParameters())
    for robot in range(6):
        stays = np.flatnonzero(run.candidates[:, robot] == STAY)
        assert np.array_equal(stays, np.arange(stays[0], run.updates))
        speeds = np.abs(run.velocities[stays[0] :, robot])
        assert (np.diff(speeds, axis=0) <= 0).all()
        assert not speeds[-1].any()
    assert not run.checks[run.candidates == STAY].any()


@settings(max_examples=examples(100))
@given(st.floats(0.5, 12.0), st.floats(3.0, 20.0), st.floats(5.0, 60.0), st.floats(0.0, 5.0), st.integers(18, 24))
def test_limits_are_rounded_to_the_safe_side_and_other_constants_to_nearest(
    radius: float, speed: float, acceleration: float, margin: float, width: int
) -> None:
    ends = np.array([[50.0, 50.0], [250.0, 250.0]])
    problem = RobotsProblem(ends, ends[::-1], radius, speed, acceleration)
    parameters = AvoidParameters(width=width, margin=margin, range=200.0)
    exact, rounded = double(problem, parameters), fixed(problem, parameters)
    formats = rounded.formats
    assert formats is not None
    place, pace, push = (2.0**bits for bits in (formats.position, formats.velocity, formats.acceleration))
    for square, limit in ((rounded.radius_squared, 2.0 * radius + margin), (rounded.range_squared, 200.0)):
        assert 0 <= math.isqrt(square) - limit * place < 1
    change = math.isqrt(rounded.change_squared)
    assert 0 <= acceleration * parameters.step * pace - change < 1
    assert 0 <= change / math.sqrt(2.0) - rounded.brake < 1
    assert 0 <= acceleration * push - rounded.acceleration < 1
    assert 0 <= speed * pace - rounded.speed < 1
    for own, other in (
        (rounded.step, exact.step * 2.0**formats.step),
        (math.isqrt(rounded.tolerance_squared), parameters.tolerance * place),
    ):
        assert abs(own - other) <= 0.5
    for own_level, other_level in zip(rounded.velocities, exact.velocities, strict=True):
        difference = np.array(own_level) - np.array(other_level) * pace
        assert np.abs(difference).max() <= 0.5 + 1e-6


def test_a_product_is_rounded_to_nearest_halves_up() -> None:
    numbers = numbers_of()
    assert numbers.shifts is not None
    bits = numbers.shifts.velocity_step
    for value in range(-5 << bits >> 1, 5 << bits >> 1, max(1, 1 << bits >> 3)):
        assert numbers.rescale(value, "velocity_step") == math.floor(value / 2.0**bits + 0.5)
    assert [quantise(half, 0) for half in (-1.5, -0.5, 0.5, 1.5)] == [-1, 0, 1, 2]


@settings(max_examples=examples(100))
@given(st.floats(1.0, 3.0), st.floats(60.0, 4000.0))
def test_words_hold_a_thirty_second_more_than_the_limits_and_positions_a_power_of_two(
    speed: float, side: float
) -> None:
    assert HEADROOM == 1.0 + 1.0 / 32.0
    ends = np.array([[10.0, 10.0], [40.0, 40.0]])
    problem = RobotsProblem(ends, ends[::-1], 2.0, speed, 24.0, (side, 50.0))
    formats = fixed(problem, AvoidParameters(width=20)).formats
    assert formats is not None
    for bits, most in ((formats.velocity, speed), (formats.acceleration, 24.0)):
        reach = 2.0 ** (19 - bits)
        assert reach > HEADROOM * most - 2.0**-bits
        assert reach <= 2.0 * HEADROOM * most
    reach = 2.0 ** (19 - formats.position)
    assert reach / 2.0 <= side <= reach


def test_a_robot_may_leave_the_arena_up_to_its_words() -> None:
    run = avoid(generate("random", 8, seed=1035), AvoidParameters())
    assert run.departure is not None
    assert run.departure.reach == 512.0
    assert run.cells.max() > 500.0
    assert run.cells.max() < 512.0


def test_a_trial_whose_position_leaves_its_word_is_refused() -> None:
    numbers, parameters = numbers_of(), AvoidParameters()
    edge = 2**15 - 1
    robot, other = RobotState((edge - 3, 0), (edge, 0)), RobotState((0, 0), (0, 0))
    choice = plain.choose(numbers, [robot, other], 0, parameters)
    assert choice.candidate != BRAKE
    assert choice.trials > 1, "the way to the target is refused"
    assert reference_robots.update(numbers, [robot, other], parameters)[1] is False
    assert robot.position[0] <= edge


def test_a_robot_that_its_velocity_takes_out_of_its_words_ends_the_run_whatever_it_decides() -> None:
    loop = Loop(PROBLEM, AvoidParameters())
    loop.position[2] = 2**15 - 1, 0
    loop.velocity[2] = 24_000, 0
    loop.decide()
    assert loop.over
    assert loop.departure is not None
    assert (loop.departure.robot, loop.departure.what, loop.departure.update) == (2, "position", 1)


def test_the_sum_stops_at_the_greatest_speed_and_the_acceleration_of_an_axis_at_the_greatest() -> None:
    gains = Gains.model_construct(proportional=2.0, integral=1.0, derivative=1.0)
    numbers = fixed(PROBLEM, AvoidParameters().model_copy(update={"gains": gains}))
    robot = RobotState((0, 0), (0, 0))
    sums, drives = [], []
    for _ in range(6):
        acceleration, robot.error_sum, robot.last_error = plain.pid(numbers, robot, (12_000, -12_000))
        sums.append(robot.error_sum)
        drives.append(acceleration)
    assert sums[0] == (12_000, -12_000)
    assert sums[-1] == (numbers.speed, -numbers.speed)
    assert all(abs(one[0]) <= abs(two[0]) for one, two in pairwise(sums))
    assert all(drive == (numbers.acceleration, -numbers.acceleration) for drive in drives)
