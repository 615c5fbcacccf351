"""The planner of Dubey et al. (2013): kernel against reference, equation 4 by geometry, whole runs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import reference_robots
from avoidance_scenes import assert_same_run, scenes
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.planners.job import Job
from codesign.planners.velocity_obstacle.paper import agreement
from codesign.planners.velocity_obstacle.paper.agreement import Verdict, bounds, compare
from codesign.planners.velocity_obstacle.plan import AvoidParameters, RobotsProblem, avoid, generate, quality
from codesign.planners.velocity_obstacle.plan import reference as plain
from codesign.planners.velocity_obstacle.plan.arithmetic import double, fixed
from codesign.planners.velocity_obstacle.plan.parameters import Detection, Responsibility
from codesign.planners.velocity_obstacle.plan.planner import PLANNER
from codesign.planners.velocity_obstacle.plan.reference import BRAKE, STAY, RobotState


@settings(max_examples=25)
@given(scenes())
def test_kernel_is_the_reference_bit_for_bit(scene: tuple[RobotsProblem, AvoidParameters]) -> None:
    problem, parameters = scene
    history = reference_robots.run(fixed(problem, parameters), problem, parameters)
    run = avoid(problem, parameters)
    assert (run.departure is not None) == history.overflow
    assert_same_run(run, history)


vectors = st.tuples(st.integers(-(2**24), 2**24), st.integers(-(2**24), 2**24))


@settings(max_examples=examples(300))
@given(vectors, vectors, st.integers(1, 2**23), st.booleans())
def test_compiled_detection_is_equation_4_with_nine_products(
    position: tuple[int, int], velocity: tuple[int, int], radius: int, approaching: bool
) -> None:
    from codesign.planners.velocity_obstacle.plan.kernels import on_course

    (x, y), (vx, vy) = position, velocity
    dot, v2 = x * vx + y * vy, vx * vx + vy * vy
    course = (x * x + y * y) * v2 - dot * dot < radius**2 * v2
    wanted = course and (dot < 0 or not approaching)
    args = (np.int64(value) for value in (x, y, vx, vy, radius**2))
    assert bool(on_course(*args, approaching)) == wanted


def test_compiled_detection_at_the_very_threshold() -> None:
    """Robots that pass at exactly the radius are safe; one unit less is not. Sides of 100 bits, differing by one."""
    from codesign.planners.velocity_obstacle.plan.kernels import on_course

    for radius in (3, 2**16, 2**23 - 1):
        x, vx = -(2**24), 2**24
        assert not on_course(np.int64(x), np.int64(radius), np.int64(vx), np.int64(0), np.int64(radius**2), True)
        assert on_course(np.int64(x), np.int64(radius - 1), np.int64(vx), np.int64(0), np.int64(radius**2), True)


finite = st.floats(-100.0, 100.0).filter(lambda value: abs(value) > 1e-3)


@settings(max_examples=examples(200))
@given(finite, finite, finite, finite)
def test_detection_agrees_with_the_least_distance_along_the_way(x: float, y: float, vx: float, vy: float) -> None:
    """The sampled way of the other robot, relative to this one, comes within the radius only if a course is told."""
    problem, parameters = generate("circle", 2, radius=5.0), AvoidParameters(margin=0.0)
    numbers = double(problem, parameters)
    closest_time = max(0.0, -(x * vx + y * vy) / (vx * vx + vy * vy))
    closest = math.hypot(x + vx * closest_time, y + vy * closest_time)
    told = plain.coll_detect(numbers, (x, y), (vx, vy), Detection.APPROACHING)
    if closest_time > 0.0 and abs(closest - 10.0) > 1e-6:
        assert told == (closest < 10.0)
    if closest_time == 0.0:
        assert not told or math.isclose(x * vx + y * vy, 0.0, abs_tol=1e-9)


def test_published_detection_stops_robots_that_part() -> None:
    numbers = double(generate("circle", 2, radius=5.0), AvoidParameters(margin=0.0))
    away = (30.0, 0.0), (1.0, 0.0)
    assert plain.coll_detect(numbers, *away, Detection.PUBLISHED)
    assert not plain.coll_detect(numbers, *away, Detection.APPROACHING)


@settings(max_examples=60)
@given(st.floats(-math.pi, math.pi), st.floats(5.0, 140.0), st.sampled_from([16, 64, 128]))
def test_direction_to_the_target_is_the_nearest_of_the_array(angle: float, far: float, count: int) -> None:
    problem = generate("circle", 2)
    parameters = AvoidParameters(directions=count, width=24)
    target = 150.0 + far * math.cos(angle), 150.0 + far * math.sin(angle)
    chosen = plain.to_goal(double(problem, parameters), RobotState((150.0, 150.0), target))
    sector = 2.0 * math.pi / count
    off = (angle - chosen * sector + math.pi) % (2.0 * math.pi) - math.pi
    assert abs(off) <= sector / 2.0 + 1e-9


def test_candidates_rotate_both_ways_and_name_each_velocity_once() -> None:
    numbers = double(generate("circle", 2), AvoidParameters(directions=16, speeds=3))
    order = list(plain.candidates(numbers, 5))
    assert order[:4] == [5, 6, 4, 7]
    assert sorted(order) == list(range(48))


def test_without_rounding_the_update_is_constant_acceleration() -> None:
    numbers = double(generate("circle", 2), AvoidParameters(time_step="250 ms"))
    position, velocity = plain.pos_vel_update(numbers, (1.0, 2.0), (3.0, -4.0), (8.0, 16.0))
    assert velocity == pytest.approx((5.0, 0.0))
    assert position == pytest.approx((1.0 + 0.75 + 0.25, 2.0 - 1.0 + 0.5))


@settings(max_examples=25)
@given(scenes(updates=25), st.integers(0, 4))
def test_fixed_point_and_doubles_choose_alike_within_the_bound(
    scene: tuple[RobotsProblem, AvoidParameters], offset: int
) -> None:
    problem, parameters = scene
    numbers = fixed(problem, parameters)
    formats = numbers.formats
    assert formats is not None
    limits = bounds(problem, parameters, formats)
    robots = reference_robots.start(numbers, problem)
    for update in range(parameters.updates):
        if update % 5 == offset:
            for index in range(problem.count):
                verdict, rounded, exact = compare(problem, parameters, robots, index)
                assert verdict is not Verdict.BEYOND_BOUND
                if verdict is Verdict.SAME:
                    pairs = zip(rounded.velocity, exact.velocity, strict=True)
                    apart = [numbers.to_speed(own) - other for own, other in pairs]
                    # A brake is cut to the unit below, beside what a candidate is rounded by.
                    allowed = limits.velocity + 2.0 * 2.0**-formats.velocity
                    assert math.hypot(*apart) <= allowed
        if reference_robots.update(numbers, robots, parameters)[1]:
            return


def test_the_bound_is_not_so_wide_that_nothing_leaves_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where one side has a radius half a cell larger, some choice is told to be beyond rounding."""
    problem, parameters = generate("circle", 4, arena=(80.0, 80.0)), AvoidParameters()

    def larger(*arguments: Any) -> Any:
        exact = double(*arguments)
        return replace(exact, radius_squared=(math.sqrt(exact.radius_squared) + 0.5) ** 2)

    monkeypatch.setattr(agreement, "double", larger)
    numbers = fixed(problem, parameters)
    robots = reference_robots.start(numbers, problem)
    seen = set()
    for _ in range(40):
        seen |= {agreement.compare(problem, parameters, robots, index)[0] for index in range(problem.count)}
        reference_robots.update(numbers, robots, parameters)
    assert Verdict.BEYOND_BOUND in seen


# Whole runs


@pytest.mark.parametrize("robots", [2, 4, 8])
@pytest.mark.parametrize("arrangement", ["circle", "crossing", "random"])
def test_robots_arrive_and_never_touch(robots: int, arrangement: str) -> None:
    for seed in range(4):
        problem = generate(arrangement, robots, seed=seed)
        run = avoid(problem, AvoidParameters())
        figures = quality(problem, run)
        assert figures.collisions == 0
        assert figures.closest_approach > 0.0
        assert figures.robots_arrived == robots
        assert figures.path_length_ratio_mean is not None
        assert figures.path_length_ratio_mean >= 1.0


def test_a_run_on_the_circle_takes_about_the_updates_of_the_paper() -> None:
    for robots in (2, 4, 8):
        assert 400 <= avoid(generate("circle", robots), AvoidParameters()).updates <= 500


def test_no_step_passes_speed_or_acceleration() -> None:
    problem, parameters = generate("crossing", 6, seed=2), AvoidParameters(updates=300)
    run = avoid(problem, parameters)
    velocities = np.ldexp(run.velocities.astype(float), -run.formats.velocity)
    unit = 2.0**-run.formats.velocity
    assert np.hypot(*np.moveaxis(velocities, 2, 0)).max() <= problem.speed + 2 * unit
    changes = np.hypot(*np.moveaxis(np.diff(velocities, axis=0), 2, 0))
    assert changes.max() <= problem.acceleration * parameters.step + 2 * unit


def test_alone_on_its_way_a_robot_goes_straight() -> None:
    problem = RobotsProblem(
        np.array([[20.0, 50.0], [20.0, 250.0]]), np.array([[280.0, 50.0], [280.0, 250.0]]), 5.0, 6.0, 24.0
    )
    figures = quality(problem, avoid(problem, AvoidParameters()))
    assert figures.path_length_ratio_worst == pytest.approx(1.0, abs=1e-4)
    # 257 cells at 0.6 cells an update, less the rounding of 38.4 units to 38, and the start at a tenth of it.
    assert 428 <= (figures.time_to_targets_s or 0.0) / 0.1 <= 440


def test_equation_4_alone_leads_to_collisions_somewhere() -> None:
    rule = AvoidParameters(detection=Detection.PUBLISHED, responsibility=Responsibility.FULL, margin=0.0)
    runs = [(problem, avoid(problem, rule)) for problem in (generate("circle", 4, seed=seed) for seed in range(12))]
    assert sum(quality(*run).collisions for run in runs) > 0
    assert any((run.candidates == BRAKE).any() for _, run in runs)


def test_planner_plug_in() -> None:
    problem, parameters = generate("circle", 3, seed=4), AvoidParameters()
    assert PLANNER.check(Job(problem, parameters)) is None
    plan = PLANNER.plan(Job(problem, parameters))
    assert PLANNER.identity(plan) == PLANNER.identity(avoid(problem, parameters))
    assert PLANNER.identity(plan) != PLANNER.identity(avoid(generate("circle", 3, seed=5), parameters))
    details = PLANNER.figures(plan)["details"]
    assert details["decisions"] == int((plan.candidates != STAY).sum())
    assert details["trials"] >= details["decisions"] - details["decisions_without_safe_velocity"]
    way, arrived = PLANNER.trajectory(problem, plan, 1)
    assert arrived
    assert way[0] == pytest.approx(problem.positions[1][::-1] - 0.5, abs=0.01)
    assert problem.free[tuple(np.floor(way[-1] + 0.5).astype(int))]
