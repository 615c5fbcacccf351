"""The circuits of Dubey et al. (2013): their power, their steps and the records of an update."""

from __future__ import annotations

from typing import Any

import pytest

from codesign.ground.figures import Status
from codesign.ground.memo import Memo
from codesign.ground.models import Part
from codesign.inputs import load_part
from codesign.planners.job import Job
from codesign.planners.velocity_obstacle import published, styles
from codesign.planners.velocity_obstacle.plan import AvoidParameters, RobotsProblem, generate
from codesign.planners.velocity_obstacle.plan.parameters import Detection, Detector
from codesign.planners.velocity_obstacle.plan.planner import PLANNER
from codesign.planners.velocity_obstacle.styles import ARCHITECTURES, Style
from codesign.planners.velocity_obstacle.styles.timing import PHASES, run_cycles

CIRCUITS = {circuit.style: circuit for circuit in ARCHITECTURES}


@pytest.fixture(scope="module")
def part() -> Part:
    return load_part("XC3S500E-4")


@pytest.fixture(scope="module")
def problem() -> RobotsProblem:
    return generate("circle", 3, arena=(90.0, 90.0), seed=2)


def drained(steps: Any) -> tuple[list[Any], Any]:
    found = []
    while True:
        try:
            found.append(next(steps))
        except StopIteration as done:
            return found, done.value


# Power


def test_power_is_fitted_to_2_and_4_robots_and_holds_for_8() -> None:
    law = styles.power_fit()
    assert law.form == "√n"
    assert all(abs(law.power(style, n) / mw - 1) < 0.02 for style, n, mw in styles.rows((2, 4)))
    assert styles.power_miss() == pytest.approx(0.031, abs=0.001)
    assert all(law.residual <= styles.fit_power(form).residual for form in styles.FORMS)


def test_intervals_of_power_hold_every_row(part: Part) -> None:
    for style, listed in published.TABLE_III.items():
        for robots, milliwatts in listed.items():
            demand = CIRCUITS[style].demand(Job(generate("circle", robots), AvoidParameters(), part=part))
            static, dynamic = CIRCUITS[style].power(demand, published.CLOCK, part)
            low, high = dynamic.interval
            assert low <= milliwatts / 1e3 - static.value <= high
            assert dynamic.status is Status.CALIBRATED


def test_dynamic_power_follows_the_clock_and_another_part_is_assumed(part: Part) -> None:
    circuit = CIRCUITS["pipelined"]
    demand = circuit.demand(Job(generate("circle", 4), AvoidParameters(), part=part))
    slow, fast = (circuit.power(demand, clock, part)[1].value for clock in (25_000_000, 50_000_000))
    assert fast == pytest.approx(2 * slow)
    other = circuit.power(demand, 50_000_000, load_part("XC2VP30-6"))[1]
    assert other.status is Status.ASSUMED


# Work


@pytest.mark.parametrize("style", list(CIRCUITS))
def test_coarse_and_fine_steps_cost_the_same(style: str, problem: RobotsProblem) -> None:
    circuit, parameters, memo = CIRCUITS[style], AvoidParameters(), Memo()
    plan = PLANNER.plan(Job(problem, parameters))
    told = []
    for detail in (True, False, False):
        steps, drawn = drained(circuit.work(Job(problem, parameters, memo=memo, detail=detail)))
        assert PLANNER.identity(drawn) == PLANNER.identity(plan)
        assert all(int(step.cycles.min()) >= 1 for step in steps if len(step.cycles))
        sums: dict[str, int] = {}
        for step in steps:
            sums[step.phase] = sums.get(step.phase, 0) + int(step.cycles.sum())
        told.append(sums)
    assert memo.hits == 1
    assert told[0] == told[1] == told[2]
    assert set(told[0]) == set(PHASES)
    cycles = run_cycles(Style(style), plan, parameters)
    assert sum(told[0].values()) == int(cycles.each.sum())


def test_an_update_takes_as_long_as_its_slowest_robot(problem: RobotsProblem) -> None:
    parameters = AvoidParameters()
    plan = PLANNER.plan(Job(problem, parameters))
    cycles = run_cycles(Style.PIPELINED, plan, parameters)
    assert (cycles.each >= cycles.costs.of_robot(plan.checks, plan.trials).max(axis=1)).all()
    assert (cycles.trials[:, None] * cycles.costs.trial <= cycles.each[:, None]).all()


def test_units_change_cycles_and_no_choice(problem: RobotsProblem) -> None:
    memo = Memo()
    found = set()
    for update, detect, detector in ((None, None, "published"), (2, 1, "published"), (1, 2, "cross_product")):
        parameters = AvoidParameters(update_units=update, detect_units=detect, detector=Detector(detector))
        steps, plan = drained(CIRCUITS["hybrid"].work(Job(problem, parameters, memo=memo, detail=False)))
        found.add(PLANNER.identity(plan))
        assert steps
    assert len(found) == 1
    assert (memo.misses, memo.hits) == (1, 2)
    other = AvoidParameters(detection=Detection.PUBLISHED, margin=0.0)
    drained(CIRCUITS["hybrid"].work(Job(problem, other, memo=memo, detail=False)))
    assert memo.misses == 2


def test_records_tell_every_phase_of_an_update(problem: RobotsProblem) -> None:
    steps, plan = drained(CIRCUITS["sequential"].work(Job(problem, AvoidParameters())))
    stories = [step.record(0, int(step.cycles.sum()), "fpga") for step in steps]
    assert [story.task for story in stories[: len(PHASES)]] == list(PHASES)
    assert all(story.cycles == story.end for story in stories)
    assert sum(story.task == "pid" for story in stories) == plan.updates
