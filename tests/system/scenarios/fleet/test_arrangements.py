"""Up to 64 robots: groups that cross in ranks, a range of sight, and what it does for crowds."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import reference_robots
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.inputs.library import load_part
from codesign.planners.velocity_obstacle.paper.measures import Verdict, compare
from codesign.planners.velocity_obstacle.plan import AvoidParameters, RobotsProblem, avoid, generate, quality, reference
from codesign.planners.velocity_obstacle.plan.arithmetic import double, fixed
from codesign.planners.velocity_obstacle.plan.avoid import fault_of, least_range
from codesign.planners.velocity_obstacle.plan.kernels import on_course
from codesign.planners.velocity_obstacle.plan.parameters import Detection, Detector, Unit
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles.resources import DETECT, UPDATE, items, module_cycles
from codesign.planners.velocity_obstacle.styles.timing import update_costs


@pytest.mark.parametrize("arrangement", ["circle", "crossing", "random"])
@pytest.mark.parametrize("count", [2, 3, 8, 31, 33, 34, 48, 63, 64])
@pytest.mark.parametrize("seed", [0, 7])
def test_every_arrangement_places_2_to_64_robots(arrangement: str, count: int, seed: int) -> None:
    problem = generate(arrangement, count, seed=seed)
    assert problem.count == count  # RobotsProblem itself refuses robots that touch or stand outside
    assert generate(arrangement, count, seed=seed).digest == problem.digest


def test_groups_of_one_rank_start_where_they_did() -> None:
    count, radius, side = 32, 5.0, 300.0
    problem = generate("crossing", count)
    random = np.random.Generator(np.random.PCG64(0))
    late = random.uniform(0.0, side / 10.0, count // 2)
    lanes = side * (0.15 + 0.7 * (np.arange(count // 2) + 0.5) / (count // 2))
    assert np.array_equal(problem.positions[:16], np.column_stack([2.0 * radius + late, lanes]))
    assert np.array_equal(problem.targets[16:], np.column_stack([lanes, np.full(16, side - 2.0 * radius)]))


def test_groups_of_several_ranks_keep_their_order() -> None:
    problem = generate("crossing", 64, seed=3)
    first, second = problem.positions[:16], problem.positions[16:32]
    assert np.allclose(second - first, [15.0, 0.0])
    ways = problem.targets - problem.positions
    assert (np.abs(ways).min(axis=1) < 1e-9).all()
    assert (ways.sum(axis=1) > 200.0).all()


@given(
    x=st.integers(-(2**15), 2**15),
    y=st.integers(-(2**15), 2**15),
    vx=st.integers(-(2**15), 2**15),
    vy=st.integers(-(2**15), 2**15),
    radius=st.integers(1, 2**12),
    farther=st.integers(0, 2**14),
)
@settings(max_examples=examples(200))
def test_beyond_the_range_nobody_is_on_a_course(x: int, y: int, vx: int, vy: int, radius: int, farther: int) -> None:
    square = (radius + farther) ** 2
    open_course = bool(on_course(x, y, vx, vy, radius**2, True))
    assert bool(on_course(x, y, vx, vy, radius**2, True, square)) == (open_course and x * x + y * y <= square)


@pytest.mark.parametrize(("count", "arrangement"), [(8, "circle"), (16, "random")])
@pytest.mark.parametrize("turn", [45.0, 135.0, 180.0])
def test_the_compiled_run_with_a_range_is_the_plain_one(count: int, arrangement: str, turn: float) -> None:
    problem = generate(arrangement, count, seed=2)
    parameters = AvoidParameters(range=20.0, turn=turn, updates=120)
    run = avoid(problem, parameters)
    plain = reference_robots.run(fixed(problem, parameters), problem, parameters)
    assert np.array_equal(run.positions, np.array(plain.positions))
    choices = [[choice.candidate for choice in update] for update in plain.choices]
    assert np.array_equal(run.candidates, np.array(choices))
    assert run.digest != avoid(problem, AvoidParameters(updates=120)).digest


def test_a_range_over_the_whole_map_is_none() -> None:
    problem = generate("circle", 8)
    whole, none = (avoid(problem, AvoidParameters(range=reach)) for reach in (600.0, None))
    assert whole.digest == none.digest


def test_fixed_point_and_doubles_differ_near_thresholds_only() -> None:
    problem = generate("random", 12, seed=5)
    parameters = AvoidParameters(range=20.0)
    numbers = fixed(problem, parameters)
    robots = reference_robots.start(numbers, problem)
    verdicts = []
    for _ in range(120):
        verdicts += [compare(problem, parameters, robots, index)[0] for index in range(problem.count)]
        reference_robots.update(numbers, robots, parameters)
    assert Verdict.BEYOND_BOUND not in verdicts
    assert verdicts.count(Verdict.SAME) > 0.95 * len(verdicts)


def test_a_range_in_which_robots_cannot_brake_is_refused() -> None:
    problem = generate("circle", 4)
    least = least_range(problem, AvoidParameters())
    assert least == pytest.approx(2 * 5 + 1 + 2 * 6 * 0.1 + 6**2 / 24)
    assert fault_of(problem, AvoidParameters(range=least)) is None
    fault = fault_of(problem, AvoidParameters(range=least - 0.1))
    assert fault is not None
    assert fault[0] == "range"
    assert f"{least:.4g} cells" in fault[1]


@given(seed=st.integers(0, 10_000))
@settings(max_examples=10)
def test_two_robots_head_on_never_touch_at_the_least_range(seed: int) -> None:
    angle = 2.0 * math.pi * seed / 10_000
    reach = np.array([math.cos(angle), math.sin(angle)]) * 60.0
    ends = np.array([150.0 + reach, 150.0 - reach])
    problem = RobotsProblem(ends, ends[::-1], 5.0, 6.0, 24.0)
    parameters = AvoidParameters(range=least_range(problem, AvoidParameters()))
    assert quality(problem, avoid(problem, parameters)).collisions == 0


@pytest.mark.parametrize(("turn", "steps"), [(180.0, 64), (177.0, 63), (135.0, 49), (45.0, 17)])
def test_no_direction_farther_from_the_target_than_the_turn_is_tried(turn: float, steps: int) -> None:
    parameters = AvoidParameters(turn=turn)
    numbers = fixed(generate("circle", 2), parameters)
    tried = [candidate % 64 for candidate in reference.candidates(numbers, 10)]
    assert len(tried) == steps * parameters.speeds
    assert len(set(tried)) == parameters.turns == steps
    assert all(min((one - 10) % 64, (10 - one) % 64) * 360.0 / 64.0 <= turn for one in tried)


@pytest.mark.parametrize("seed", range(4))
def test_with_a_range_and_a_turn_nobody_flees_and_crowds_arrive(seed: int) -> None:
    """Where targets are wide enough apart to drive between; published, one in three of these arrives."""
    parameters = AvoidParameters(range=20.0, turn=135.0)
    for arrangement, count in (("circle", 48), ("random", 64)):
        problem = generate(arrangement, count, seed=seed)
        told = quality(problem, avoid(problem, parameters))
        assert (told.robots_arrived, told.collisions) == (count, 0)


@pytest.mark.parametrize("seed", [0, 1, 4])
def test_64_robots_arrive_with_a_range_and_do_not_without(seed: int) -> None:
    problem = generate("random", 64, seed=seed)
    open_run = quality(problem, avoid(problem, AvoidParameters(updates=1000)))
    ranged = quality(problem, avoid(problem, AvoidParameters(range=20.0)))
    assert open_run.robots_arrived < 50
    assert (ranged.robots_arrived, ranged.collisions) == (64, 0)


def test_a_range_costs_a_comparison_and_the_products_that_are_not_there_yet() -> None:
    without, with_range = AvoidParameters(), AvoidParameters(range=20.0)
    assert update_costs(Style.PIPELINED, 8, without) == update_costs(Style.PIPELINED, 8, with_range)
    crossed = module_cycles(DETECT, Unit.SERIAL, Detector.CROSS_PRODUCT, approaching=True)
    both = module_cycles(DETECT, Unit.SERIAL, Detector.CROSS_PRODUCT, approaching=True, ranged=True)
    assert both == crossed + 2
    assert module_cycles(UPDATE, Unit.SERIAL, ranged=True) == 7
    part = load_part("XC3S500E-4")
    lut4 = [
        sum(item.amount for item in items(Style.PIPELINED, 8, one, part) if item.resource == "lut4")
        for one in (without, with_range)
    ]
    # About a LUT for each bit of |r|², as synthesis counts it.
    assert 16 <= lut4[1] - lut4[0] <= 2 * 16 + 3


def test_the_constants_of_both_arithmetics_mean_the_same_range() -> None:
    problem, parameters = generate("circle", 4), AvoidParameters(range=20.3)
    exact, rounded = double(problem, parameters), fixed(problem, parameters)
    assert rounded.formats is not None
    unit = 2.0**-rounded.formats.position
    assert 0.0 <= math.sqrt(rounded.range_squared) * unit - math.sqrt(exact.range_squared) < unit
    assert dataclasses.replace(exact, range_squared=None).range_squared is None
    assert not reference.coll_detect(exact, (20.4, 0.0), (-1.0, 0.0), Detection.APPROACHING)
    assert reference.coll_detect(exact, (20.2, 0.0), (-1.0, 0.0), Detection.APPROACHING)
