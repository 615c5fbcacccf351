"""Motions keep the limits of their drive."""

from __future__ import annotations

import math

import numpy as np
import pytest
from drives_and_ways import circle, kinematics, ways
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.components.path import NEAR, Polyline
from codesign.components.robot import SECOND, DifferentialDrive, Kinematics, Motion, OmnidirectionalDrive, PointDrive
from codesign.ground.errors import InputError


def sampled(motion: Motion, count: int = 400) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (s), arcs and speeds over the whole motion and a little after it."""
    times = np.unique(np.linspace(0, motion.duration * 1.05 + 10, count).astype(np.int64))
    states = np.array([motion.at(int(time)) for time in times])
    return times / SECOND, states[:, 0], states[:, 1]


@given(ways, kinematics, st.floats(0.0, 60.0))
@settings(max_examples=examples(150))
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
@settings(max_examples=examples(100))
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


@given(
    st.integers(10, 200),
    st.floats(0.5, 20.0),
    st.sampled_from([OmnidirectionalDrive(0.5, 0.3), OmnidirectionalDrive(2.5, 4.0)]),
    st.sampled_from([SECOND // 25, SECOND // 10, SECOND // 2]),
)
@settings(max_examples=examples(100))
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


@given(ways, kinematics, st.floats(0.0, 1.0))
@settings(max_examples=examples(100))
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
    motion = Motion.drive(Polyline([(0, 0), (0, 10), (-10, 10)]), DifferentialDrive(2.0, 1.0, math.pi / 4), math.inf)
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
