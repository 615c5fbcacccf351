"""Fleets whose decisions take longer than their time step: planner and timing in step, on one clock."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reference_robots
from avoidance_scenes import assert_same_run
from examples import examples
from fleet_specs import SECOND, STEP, Ground
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.components import ClockDomain
from codesign.ground.records import MissionRecord, PositionsRecord, Record, TaskRecord
from codesign.planners.velocity_obstacle.plan import AvoidParameters, RobotsProblem, avoid, generate, quality
from codesign.planners.velocity_obstacle.plan.arithmetic import fixed
from codesign.planners.velocity_obstacle.plan.reference import Choice
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles.timing import update_costs
from codesign.system.scenarios.run import simulate_system

CLOCKS = st.sampled_from([300, 700, 1000, 2600, 8000, 50_000_000])
QUIETLY: dict[str, Any] = {"deadline": None}


@pytest.fixture
def ground(tmp_path: Path) -> Ground:
    return Ground(tmp_path)


class Clockwork:
    """The time of each update by hand: how many time steps robots that made these choices drive on."""

    def __init__(self, problem: RobotsProblem, parameters: AvoidParameters, hz: int) -> None:
        self.costs = update_costs(Style.PIPELINED, problem.count, parameters)
        self.clock, self.now, self.ends, self.late = ClockDomain(hz), 0, list[int](), 0

    def held(self, choices: Sequence[Choice]) -> int:
        cycles = max(sum(self.costs.phases(one.checks, one.trials).values()) for one in choices)
        decided = self.clock.edge(self.clock.cycle_at_or_after(self.now) + cycles)
        steps = -(-(decided - self.now) // STEP) if decided - self.now > STEP else 0
        self.now += (steps + 1) * STEP
        self.ends.append(self.now)
        self.late += steps > 0
        return steps


@settings(max_examples=20, **QUIETLY)
@given(CLOCKS, st.integers(2, 6), st.sampled_from(["circle", "crossing", "random"]), st.integers(0, 99))
def test_a_fleet_in_real_time_is_the_reference_whose_decisions_act_when_their_cycles_are_over(
    ground: Ground, hz: int, count: int, arrangement: str, seed: int
) -> None:
    settings: dict[str, Any] = {"count": count, "arrangement": arrangement, "seed": seed}
    flight = ground.fly(clock=f"{hz} Hz", scenario="pace: real_time", parameters="updates: 25", **settings)
    problem, parameters = generate(arrangement, count, seed=seed), AvoidParameters(updates=25)
    by_hand = Clockwork(problem, parameters, hz)
    history = reference_robots.run(fixed(problem, parameters), problem, parameters, by_hand.held)
    assert_same_run(flight.plan, history)
    assert list(flight.ends) == by_hand.ends
    assert flight.figures.missed_updates == by_hand.late
    assert flight.figures.robots_s == flight.figures.span_s == by_hand.now / SECOND
    if not by_hand.late:
        assert flight.plan.digest == avoid(problem, parameters).digest


@settings(max_examples=examples(8), **QUIETLY)
@given(st.sampled_from([4000, 20_000, 50_000_000]), st.sampled_from(["real_time", "free_running"]), st.integers(0, 50))
def test_all_figures_of_a_fleet_are_on_the_clock_of_its_trace(ground: Ground, hz: int, pace: str, seed: int) -> None:
    records: list[Record] = []
    machine = ground.machine(
        clock=f"{hz} Hz", scenario=f"pace: {pace}", parameters="updates: 900", seed=seed, listeners=(records.append,)
    )
    result = simulate_system(machine.system, listeners=(records.append,))
    fleet, worth = result.fleet, result.quality
    assert fleet is not None
    assert result.time is not None
    arrivals = [one.time for one in records if isinstance(one, MissionRecord) and one.event == "goal_reached"]
    loaded = round(result.time.map_loaded_s * SECOND)
    assert worth.robots_arrived == len(arrivals)
    assert fleet.arrived_s == ((max(arrivals) - loaded) / SECOND if arrivals else None)
    poses = [one for one in records if isinstance(one, PositionsRecord)]
    assert [one.time for one in poses] == sorted(one.time for one in poses)
    assert poses[-1].time == loaded + round(fleet.span_s * SECOND)
    assert len(poses) == 1 + fleet.updates + (fleet.missed_updates if pace == "real_time" else 0)
    if pace == "real_time":
        assert fleet.robots_s == fleet.span_s
        assert fleet.arrived_s is None or worth.time_to_targets_s == pytest.approx(fleet.arrived_s)
        # The clock alone says how long a robot drives: no pair of poses is farther apart than its speed allows.
        for before, after in pairwise(poses):
            far = np.hypot(*(after.positions - before.positions).T).max()
            assert far <= 6.0 * (after.time - before.time) / 1e12 + 0.1
    else:
        assert fleet.robots_s == fleet.updates * STEP / SECOND


def test_no_robot_changes_its_velocity_before_the_last_of_them_has_decided(ground: Ground) -> None:
    records: list[Record] = []
    flight = ground.fly(
        clock="900 Hz", scenario="pace: real_time", parameters="updates: 60", listeners=(records.append,)
    )
    assert flight.figures.missed_updates > 20
    tasks = [one for one in records if isinstance(one, TaskRecord) and one.task == "avoid"]
    decided = [max(one.end for one in tasks[update * 4 : update * 4 + 4]) for update in range(60)]
    plan, update = flight.plan, -1
    begins = set(plan.begins.tolist())
    for row in range(len(plan.times) - 1):
        update += int(plan.times[row]) in begins
        if not np.array_equal(plan.velocities[row], plan.velocities[row + 1]):
            acted = int(plan.times[row]) * STEP
            in_step = decided[update] - int(plan.begins[update]) * STEP <= STEP
            assert acted >= decided[update] or in_step


def test_a_slower_clock_brings_robots_to_their_targets_no_earlier_on_average(ground: Ground) -> None:
    spent = []
    for hz in (50_000_000, 4000, 1000):
        arrived = []
        for arrangement in ("circle", "crossing", "random"):
            for seed in range(2):
                figures = ground.fly(
                    clock=f"{hz} Hz",
                    scenario="pace: real_time",
                    parameters="updates: 900",
                    arrangement=arrangement,
                    seed=seed,
                ).figures
                assert figures.completed
                assert figures.arrived_s is not None
                arrived.append(figures.arrived_s)
        spent.append(float(np.mean(arrived)))
    assert spent == sorted(spent)


def test_late_decisions_collide_where_those_in_step_do_not(ground: Ground) -> None:
    """Robots that drive on while they decide run into each other, and figures and trace agree on it."""
    records: list[Record] = []
    settings: dict[str, Any] = {
        "count": 8,
        "arrangement": "crossing",
        "seed": 1,
        "scenario": "pace: real_time",
        "parameters": "updates: 900",
    }
    quick = simulate_system(ground.machine(clock="50 MHz", **settings).system).quality
    slow = simulate_system(ground.machine(clock="400 Hz", **settings).system, listeners=(records.append,)).quality
    assert (quick.collisions, quick.shortfall) == (0, None)
    touched = {
        one.text.split(" touch")[0] for one in records if isinstance(one, MissionRecord) and one.event == "contact"
    }
    assert slow.collisions == len(touched) > 0
    assert slow.time_to_targets_s > quick.time_to_targets_s
    assert slow.closest_approach < 0.0 < quick.closest_approach


def test_robots_that_decide_late_and_are_left_behind_are_told_that_decisions_in_step_mend_it(ground: Ground) -> None:
    settings: dict[str, Any] = {"arrangement": "random", "seed": 4, "scenario": "pace: real_time"}
    late, in_step = (
        simulate_system(ground.machine(clock=clock, parameters="updates: 900", **settings).system).quality
        for clock in ("140 Hz", "50 MHz")
    )
    assert late.shortfall is not None
    assert late.remedy.startswith("decisions within their time steps: ")
    assert in_step.shortfall is None


def test_late_decisions_are_the_same_at_every_granularity(ground: Ground) -> None:
    told = []
    for granularity in ("run_ahead", "visit"):
        records: list[Record] = []
        flight = ground.fly(
            clock="2 kHz", scenario="pace: real_time", count=5, listeners=(records.append,), granularity=granularity
        )
        told.append(([repr(vars(one)) for one in records], flight.figures, flight.plan.digest))
    assert told[0] == told[1]


def test_the_quality_of_a_fleet_is_that_of_its_own_run(ground: Ground) -> None:
    machine = ground.machine(clock="1500 Hz", count=5, scenario="pace: real_time", parameters="updates: 200")
    from codesign.system.scenarios.fleet.scenario import fly

    problem: Any = machine.system.problem
    plan = fly(machine).plan
    assert not plan.in_step
    again = simulate_system(machine.system)
    assert again.quality == quality(problem, plan)
