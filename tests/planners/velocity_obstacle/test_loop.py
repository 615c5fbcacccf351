"""The closed loop of robots: late decisions against the reference, gaps along the motion, limits, who is missing."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import reference_robots
from avoidance_scenes import assert_same_run, scenes
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from codesign.planners.velocity_obstacle.plan import Avoidance, AvoidParameters, RobotsProblem, avoid, generate, quality
from codesign.planners.velocity_obstacle.plan import reference as plain
from codesign.planners.velocity_obstacle.plan.arithmetic import fixed
from codesign.planners.velocity_obstacle.plan.kernels import pair_gaps
from codesign.planners.velocity_obstacle.plan.loop import Loop
from codesign.planners.velocity_obstacle.plan.parameters import Gains, Responsibility
from codesign.planners.velocity_obstacle.plan.planner import MOST_TRIED, arrival_steps, run_gaps

# Late decisions


def flown(problem: RobotsProblem, parameters: AvoidParameters, unit: int) -> Avoidance:
    """A run whose updates hold the robots for a time step for every ``unit`` candidates of the slowest robot."""
    loop = Loop(problem, parameters)
    while not loop.over:
        loop.decide()
        held = int(loop.checks.max()) // unit
        if loop.departure is None and held:
            loop.hold(held)
        if loop.departure is None:
            loop.act()
    return loop.plan()


@settings(max_examples=examples(25))
@given(scenes(updates=40), st.sampled_from([1, 3, 20, 200, 10**6]))
def test_late_decisions_are_those_of_the_reference_state_by_state(
    scene: tuple[RobotsProblem, AvoidParameters], unit: int
) -> None:
    problem, parameters = scene
    run = flown(problem, parameters, unit)
    history = reference_robots.run(
        fixed(problem, parameters),
        problem,
        parameters,
        lambda choices: max(choice.checks for choice in choices) // unit,
    )
    assert (run.departure is not None) == history.overflow
    assert_same_run(run, history)
    if unit == 10**6:
        assert run.in_step
        assert run.digest == avoid(problem, parameters).digest


@settings(max_examples=25)
@given(scenes(updates=30), st.integers(1, 9))
def test_while_robots_decide_they_keep_their_velocity_and_then_take_the_new_one_in_a_step(
    scene: tuple[RobotsProblem, AvoidParameters], unit: int
) -> None:
    run = flown(*scene, unit)
    ends = {int(time): row for row, time in enumerate(run.times)}
    for update in range(run.updates):
        row = ends[int(run.begins[update])]
        held = int(run.checks[update].max()) // unit
        if held:
            assert np.array_equal(run.velocities[row + 1], run.velocities[row])
            assert run.times[row + 1] - run.times[row] == held
            row += 1
        assert run.times[row + 1] - run.times[row] == 1
    assert run.times[-1] == run.begins[-1] + 1 + int(run.checks[-1].max()) // unit


def test_a_robot_that_leaves_its_words_while_it_decides_ends_the_run_in_that_step() -> None:
    problem = RobotsProblem(
        np.array([[20.0, 150.0], [20.0, 50.0]]), np.array([[280.0, 150.0], [280.0, 50.0]]), 5.0, 6.0, 24.0
    )
    loop = Loop(problem, AvoidParameters())
    for _ in range(20):
        loop.decide()
        loop.act()
    before = loop.plan()
    loop.decide()
    loop.hold(10**6)
    assert loop.over
    departure = loop.departure
    assert departure is not None
    numbers = fixed(problem, AvoidParameters())
    x, vx = before.positions[-1, departure.robot, 0], before.velocities[-1, departure.robot, 0]
    moved = plain.pos_vel_update(numbers, (0, 0), (int(vx), 0), (0, 0))[0][0]
    steps = departure.steps - before.times[-1]
    assert x + (steps - 1) * moved < 2**15 <= x + steps * moved
    assert departure.seconds == pytest.approx(departure.steps * 0.1)
    assert departure.place[0] >= departure.reach
    assert loop.plan().digest == before.digest


# Gaps


def sampled(run: Avoidance, problem: RobotsProblem, each: int = 400) -> float:
    """The least distance of two robots at many moments of every leg, by equation 2b itself."""
    share = np.linspace(0.0, 1.0, each)[:, None, None]
    least = math.inf
    for leg, steps in enumerate(np.diff(run.times)):
        begin, drift = run.cells[leg], run.speeds[leg] * steps * run.step
        places = begin + drift * share + (run.cells[leg + 1] - begin - drift) * share**2
        for one, other in combinations(range(problem.count), 2):
            least = min(least, float(np.hypot(*(places[:, one] - places[:, other]).T).min()))
    return least


@settings(max_examples=20)
@given(scenes(updates=25), st.sampled_from([2, 30, 10**6]))
def test_the_least_gap_of_a_run_is_that_of_dense_sampling(
    scene: tuple[RobotsProblem, AvoidParameters], unit: int
) -> None:
    problem, parameters = scene
    run = flown(problem, parameters, unit)
    exact, dense = float(run_gaps(run).min()), sampled(run, problem)
    assert exact <= dense + 1e-9
    # Between two of the samples a pair moves by no more than this.
    longest = max(int(np.diff(run.times).max(initial=1)), 1) * run.step
    assert dense - exact <= 2.0 * (problem.speed + problem.acceleration * run.step) * longest / 399


coordinate = st.floats(-50.0, 50.0)
vector = st.tuples(coordinate, coordinate)


@settings(max_examples=examples(300))
@given(vector, vector, vector, st.floats(0.01, 2.0))
def test_the_least_distance_along_a_parabola_is_never_above_any_moment_of_it(
    begin: tuple[float, float], velocity: tuple[float, float], end: tuple[float, float], seconds: float
) -> None:
    cells = np.zeros((2, 2, 2))
    speeds = np.zeros((2, 2, 2))
    cells[0, 1], cells[1, 1], speeds[0, 1] = begin, end, velocity
    found = float(pair_gaps(cells, speeds, np.array([seconds]))[0])
    share = np.linspace(0.0, 1.0, 20_001)[:, None]
    drift = speeds[0, 1] * seconds
    places = cells[0, 1] + drift * share + (cells[1, 1] - cells[0, 1] - drift) * share**2
    dense = float(np.hypot(*places.T).min())
    assert found <= dense + 1e-9
    fastest = np.hypot(*drift) + 2.0 * np.hypot(*(cells[1, 1] - cells[0, 1] - drift))
    assert dense - found <= fastest / 20_000 + 1e-9


def test_gaps_are_measured_along_the_parabola_and_not_straight_between_updates() -> None:
    """A robot that drives to and fro within a step ends where it began, and has been elsewhere."""
    cells = np.array([[[0.0, 0.0], [0.0, 10.0]], [[0.0, 0.0], [0.0, 10.0]]])
    speeds = np.array([[[0.0, 8.0], [0.0, 0.0]], [[0.0, -8.0], [0.0, 0.0]]])
    assert pair_gaps(cells, speeds, np.array([1.0])) == pytest.approx([8.0])
    straight = np.array([[[0.0, 0.0], [10.0, 1.0]], [[10.0, 0.0], [0.0, 1.0]]])
    steady = np.array([[[10.0, 0.0], [-10.0, 0.0]]] * 2)
    assert pair_gaps(straight, steady, np.array([1.0])) == pytest.approx([1.0])


def test_an_overlap_between_updates_is_a_collision() -> None:
    problem = generate("circle", 4, seed=535)
    run = avoid(problem, AvoidParameters(margin=0.0, responsibility=Responsibility.FULL))
    figures = quality(problem, run)
    assert figures.collisions == 4
    assert figures.closest_approach == pytest.approx(sampled(run, problem) - 10.0, abs=1e-4)
    assert figures.closest_approach < 0.0


# Limits of the robots


@st.composite
def accepted_gains(draw: Any) -> Gains:
    proportional = draw(st.floats(0.05, 1.0))
    most = math.sqrt(proportional) - proportional
    return Gains(proportional=proportional, derivative=draw(st.floats(0.0, 1.0)) * most)


@settings(max_examples=40)
@given(accepted_gains(), st.sampled_from(["circle", "crossing", "random"]), st.integers(0, 500), st.integers(1, 700))
def test_with_gains_that_are_accepted_no_robot_exceeds_speed_or_acceleration(
    gains: Gains, arrangement: str, seed: int, unit: int
) -> None:
    problem = generate(arrangement, 4, seed=seed, arena=(100.0, 100.0), radius=3.0)
    parameters = AvoidParameters(gains=gains, updates=150)
    run = flown(problem, parameters, unit)
    # Each product of the PID control is rounded by half a unit of an acceleration or a velocity.
    units = 8 * 2.0**-run.formats.velocity
    assert np.hypot(*np.moveaxis(run.speeds, 2, 0)).max() <= problem.speed + units
    changes = np.hypot(*np.moveaxis(np.diff(run.speeds, axis=0), 2, 0))
    assert changes.max() <= problem.acceleration * parameters.step + units


@pytest.mark.parametrize(
    "gains",
    [
        {"proportional": 1.0, "integral": 0.05},
        {"proportional": 0.5, "integral": 0.05, "derivative": 0.1},
        {"proportional": 1.2},
        {"proportional": 1.0, "derivative": 0.2},
        {"proportional": 2.0, "integral": 1.0, "derivative": 1.0},
    ],
)
def test_gains_that_are_refused_do_exceed_a_limit(gains: dict[str, float]) -> None:
    with pytest.raises(ValidationError):
        Gains(**gains)
    over = []
    forced = AvoidParameters().model_copy(update={"gains": Gains.model_construct(**gains)})
    for arrangement in ("circle", "crossing", "random"):
        problem = generate(arrangement, 8)
        run = avoid(problem, forced)
        over.append(np.hypot(*np.moveaxis(run.speeds, 2, 0)).max() / problem.speed)
        changes = np.hypot(*np.moveaxis(np.diff(run.speeds, axis=0), 2, 0)).max()
        over.append(changes / (problem.acceleration * forced.step))
    assert max(over) > 1.01


@pytest.mark.parametrize(
    ("gains", "place", "said"),
    [
        ({"proportional": 1.5}, "proportional", "from 0 to 1"),
        ({"proportional": -0.1}, "proportional", "from 0 to 1"),
        ({"integral": 0.1}, "integral", "0, or leave it out"),
        ({"derivative": 0.01}, "derivative", "from 0 to 0 "),
        ({"proportional": 0.5, "derivative": 0.21}, "derivative", "from 0 to 0.2071"),
        ({"proportional": 0.5, "derivative": 1e300}, "derivative", "from 0 to 0.2071"),
    ],
)
def test_gains_beyond_a_robots_limits_are_refused_with_place_range_and_remedy(
    gains: dict[str, float], place: str, said: str
) -> None:
    with pytest.raises(ValidationError) as raised:
        AvoidParameters.model_validate({"gains": gains})
    (error,) = raised.value.errors()
    what, hint, _ = error["ctx"]["error"].args
    assert f"{gains[place]:g}" in what
    assert hint.startswith(said)
    assert error["loc"] == ("gains", place)


@settings(max_examples=examples(100))
@given(st.integers(0, 100))
def test_the_greatest_gain_that_is_named_is_accepted(hundredths: int) -> None:
    """What a refusal says is accepted: also on the bound, as 0.09 is for 0.81."""
    proportional = hundredths / 100
    with pytest.raises(ValidationError) as raised:
        Gains(proportional=proportional, derivative=0.3)
    (error,) = raised.value.errors()
    named = float(error["ctx"]["error"].args[1].split()[3])
    assert Gains(proportional=proportional, derivative=named).derivative == named
    with pytest.raises(ValidationError):
        Gains(proportional=proportional, derivative=named + 1.1e-4)


def test_all_gains_beyond_a_limit_are_told_at_once() -> None:
    with pytest.raises(ValidationError) as raised:
        Gains(proportional=1.5, integral=0.1, derivative=0.3)
    assert [error["loc"] for error in raised.value.errors()] == [("proportional",), ("integral",), ("derivative",)]


# What is missing


@pytest.mark.parametrize(
    ("arrangement", "seed", "why"),
    [
        ("random", 1035, "the position of robot 5 left its words of 16 bits"),
        ("random", 2060, "the position of robot 7 left its words of 16 bits"),
        ("crossing", 1045, "after 1,500 updates 7 of 8 robots have arrived: robot 1 "),
        ("random", 2222, "after 1,500 updates 7 of 8 robots have arrived: robot 0 "),
    ],
)
def test_a_robot_that_does_not_arrive_is_a_result_with_its_reason_and_a_remedy_that_was_tried(
    arrangement: str, seed: int, why: str
) -> None:
    problem = generate(arrangement, 8, seed=seed)
    figures = quality(problem, avoid(problem, AvoidParameters()))
    assert figures.robots_arrived < 8
    assert figures.shortfall is not None
    assert figures.shortfall.startswith(why)
    assert figures.remedy == "turn: 135: with that all robots arrive, as tried without a clock"
    mended = quality(problem, avoid(problem, AvoidParameters(turn=135.0)))
    assert (mended.robots_arrived, mended.shortfall, mended.remedy) == (8, None, None)


@settings(max_examples=25)
@given(st.sampled_from(["circle", "crossing", "random"]), st.integers(2, 12), st.integers(0, 3000), st.integers(1, 500))
def test_a_shortfall_is_told_exactly_where_a_robot_did_not_arrive(
    arrangement: str, count: int, seed: int, updates: int
) -> None:
    problem, parameters = generate(arrangement, count, seed=seed), AvoidParameters(updates=updates)
    run = avoid(problem, parameters)
    figures = quality(problem, run)
    missing = [robot for robot, step in enumerate(arrival_steps(run)) if step is None]
    assert (figures.shortfall is not None) == bool(missing)
    for robot in missing[:3]:
        assert f"robot {robot} " in (figures.shortfall or "")
    if figures.remedy is not None:
        changes = dict(one.split(": ") for one in figures.remedy.split(": with that")[0].split(", "))
        checked = AvoidParameters.model_validate(
            parameters.model_dump()
            | {name: type(getattr(AvoidParameters(range=20.0), name))(value) for name, value in changes.items()}
        )
        assert quality(problem, avoid(problem, checked)).robots_arrived == count


def test_what_would_take_long_to_try_is_not_tried() -> None:
    problem, parameters = generate("random", 64, seed=1), AvoidParameters(updates=5000)
    assert MOST_TRIED < 64**2 * 5000
    figures = quality(problem, avoid(problem, parameters))
    assert figures.shortfall is not None
    assert "and " in figures.shortfall
    assert figures.remedy is None
