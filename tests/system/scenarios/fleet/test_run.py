"""Fleets: times in closed form, conservation of frames, watchdogs, and the same bytes at every granularity."""

from __future__ import annotations

import pickle
from bisect import bisect_right
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fleet_specs import ERRORS, IDEAL, SECOND, STEP, Ground, planned, serial
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.velocity_obstacle_pace import LineLaw
from codesign.components import ClockDomain
from codesign.ground.records import MessageRecord, MissionRecord, PositionsRecord, Record, TaskRecord
from codesign.planners.velocity_obstacle.plan import AvoidParameters, avoid, generate, quality
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles.timing import run_cycles, update_costs
from codesign.system.scenarios.fleet.scenario import ARRIVED, fly


@pytest.fixture
def ground(tmp_path: Path) -> Ground:
    return Ground(tmp_path)


def test_without_a_line_updates_take_their_slowest_robots_cycles_and_nothing_else(ground: Ground) -> None:
    plan, parameters = planned(updates=1500)
    flight = ground.fly(parameters="updates: 1500")
    clock = ClockDomain(50_000_000)
    cycles = np.cumsum(run_cycles(Style.PIPELINED, plan, parameters).each)
    assert flight.loaded == 0
    assert flight.ends == tuple(clock.edge(int(cycle)) for cycle in cycles)
    assert flight.plan.digest == plan.digest
    figures = flight.figures
    assert (figures.ended, figures.completed, figures.updates) == (ARRIVED, True, plan.updates)
    assert figures.pace == "fpga"
    assert figures.shares == {"fpga": 1.0, "line": 0.0, "time_step": 0.0}
    assert figures.updates_a_second == pytest.approx(plan.updates * 1e12 / flight.ends[-1])
    assert figures.reachable_a_second == pytest.approx(figures.updates_a_second)


def test_each_robot_computes_on_an_fpga_of_its_own_for_its_own_cycles(ground: Ground) -> None:
    machine = ground.machine(count=6)
    flight = fly(machine)
    plan, _ = planned(6)
    cycles = update_costs(Style.PIPELINED, 6, machine.system.planning).of_robot(plan.checks, plan.trials)
    assert cycles.shape == (plan.updates, 6)
    assert len({fpga.name for fpga in flight.fpgas}) == 6
    assert [fpga.busy for fpga in flight.fpgas] == [int(amount) * 20_000 for amount in cycles.sum(axis=0)]
    assert flight.figures.fpga_busy_s == int(cycles.sum()) * 20_000 / SECOND
    assert sum(machine.cycles().values()) == int(cycles[:, 0].sum())


def test_in_real_time_updates_keep_to_the_time_step(ground: Ground) -> None:
    flight = ground.fly(link=serial(115_200), scenario="pace: real_time", parameters="updates: 30")
    load = flight.loaded
    assert flight.ends == tuple(load + STEP * (update + 1) for update in range(30))
    assert load == 4 * 4 * 16 * 10 * 10**12 // (8 * 115_200) + 1  # starts and targets, x and y, rounded up
    figures = flight.figures
    assert (figures.missed_updates, figures.pace, figures.updates_a_second) == (0, "time_step", 10.0)
    assert figures.frames is not None
    assert (figures.frames.made, figures.frames.shown, figures.frames.late) == (30, 30, 0)


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"scenario": "pace: real_time, limit: 2 s"}, "the limit of 2 s of simulated time was reached"),
        ({"scenario": "pace: real_time, events: 300"}, "the limit of 300 events was reached"),
        ({"link": serial(9600, more=", outages: [{begin: 0 s}]")}, "link down"),
        ({"parameters": "updates: 7"}, "after 7 updates 0 of 4 robots have arrived"),
    ],
)
def test_a_fleet_always_ends_with_a_reason_and_its_trace_reaches_up_to_there(
    ground: Ground, settings: dict[str, Any], text: str
) -> None:
    records: list[Record] = []
    flight = ground.fly(listeners=(records.append,), **settings)
    assert text in flight.figures.ended
    assert not flight.figures.completed
    assert flight.figures.updates == flight.plan.updates == len(flight.ends)
    assert flight.events <= 300 or "events" not in str(settings)
    positions = [record for record in records if isinstance(record, PositionsRecord)]
    assert [record.update for record in positions] == list(range(flight.plan.updates + 1))
    missions = [record for record in records if isinstance(record, MissionRecord)]
    assert (missions[-1].event, missions[-1].text) == ("ended", flight.figures.ended)


def test_the_trace_holds_the_planners_run(ground: Ground) -> None:
    records: list[Record] = []
    flight = ground.fly(listeners=(records.append,), parameters="updates: 1500", link=serial(115_200))
    plan, _ = planned(updates=1500)
    positions = [record for record in records if isinstance(record, PositionsRecord)]
    assert [record.time for record in positions] == [0, *flight.ends]
    for record in positions:
        assert np.array_equal(record.positions, plan.cells[record.update, :, ::-1] - 0.5)
    events = [record.event for record in records if isinstance(record, MissionRecord)]
    assert events.count("goal_reached") == 4
    assert events[-1] == "ended"
    messages = [record for record in records if isinstance(record, MessageRecord)]
    assert len(messages) == plan.updates + 1
    assert all(one.time <= other.time for one, other in pairwise(messages))


@pytest.mark.parametrize(("count", "each"), [(8, 8), (9, 1)])
def test_beyond_eight_robots_the_trace_shows_only_whom_the_others_wait_for(
    ground: Ground, count: int, each: int
) -> None:
    records: list[Record] = []
    flight = ground.fly(listeners=(records.append,), count=count, parameters="updates: 10")
    tasks = [record for record in records if isinstance(record, TaskRecord) and record.task == "avoid"]
    assert len(tasks) == 10 * each
    last = {record.end for record in tasks}
    assert set(flight.ends) <= last


def test_contacts_are_told_as_they_come(ground: Ground) -> None:
    records: list[Record] = []
    loose = "updates: 600, detection: published, responsibility: full, margin: 0.0"
    machine = ground.machine(listeners=(records.append,), count=8, arrangement="crossing", seed=6, parameters=loose)
    flight = fly(machine)
    touched = {
        record.text.split(" touch")[0]
        for record in records
        if isinstance(record, MissionRecord) and record.event == "contact"
    }
    problem: Any = machine.system.problem
    assert len(touched) == quality(problem, flight.plan).collisions > 0


@pytest.mark.parametrize("pace", ["free_running", "real_time"])
@pytest.mark.parametrize("link", [IDEAL, serial(115_200), serial(2_000_000, 3, ERRORS)])
def test_run_ahead_is_visit_by_visit_to_the_byte(ground: Ground, link: str, pace: str) -> None:
    told = []
    for granularity in ("run_ahead", "visit", "run_ahead"):
        records: list[Record] = []
        machine = ground.machine(
            link=link,
            count=6,
            scenario=f"pace: {pace}",
            granularity=granularity,
            listeners=(records.append,),
            costs="render_robot: 20 us",
        )
        flight = fly(machine)
        figures = flight.figures.model_dump()
        told.append((pickle.dumps([repr(vars(one)) for one in records]), figures, machine.cycles(), flight.ends))
    assert told[0] == told[1] == told[2]


def test_watching_changes_nothing(ground: Ground) -> None:
    silent, watched = (ground.fly(link=serial(115_200), listeners=listeners) for listeners in ((), ([].append,)))
    assert silent.figures == watched.figures
    assert silent.ends == watched.ends


@pytest.mark.parametrize("fifo", [1, 16, 64])
def test_a_faster_line_or_clock_is_never_slower(ground: Ground, fifo: int) -> None:
    def ends(baud: int, mhz: int) -> int:
        return ground.fly(link=serial(baud, fifo), clock=f"{mhz} MHz", count=8, parameters="updates: 30").ends[-1]

    lines = [ends(baud, 5) for baud in (9600, 115_200, 1_000_000, 4_000_000, 40_000_000)]
    clocks = [ends(4_000_000, mhz) for mhz in (1, 5, 10, 20, 40)]
    assert lines == sorted(lines, reverse=True)
    assert clocks == sorted(clocks, reverse=True)
    assert bisect_right(lines[::-1], lines[0]) == len(lines)


def test_a_robot_that_leaves_its_words_ends_the_fleet_there(ground: Ground) -> None:
    """The fleet's run up to that update stands, with the reason, as the planner's run without a clock does."""
    problem, parameters = generate("circle", 32, seed=1), AvoidParameters(range=30.0, width=16)
    plan = avoid(problem, parameters)
    flight = ground.fly(count=32, seed=1, parameters="range: 30.0")
    assert flight.figures.ended == str(plan.departure)
    assert not flight.figures.completed
    assert flight.plan.digest == plan.digest
    assert 100 < flight.figures.updates < 1500
    assert f"in update {flight.figures.updates + 1} " in flight.figures.ended
    assert np.abs(flight.plan.positions).max() < 2**15


def test_free_running_robots_wait_out_an_outage(ground: Ground) -> None:
    whole, cut = (
        ground.fly(link=serial(115_200, more=more), count=8)
        for more in ("", ", outages: [{begin: 40 ms, end: 240 ms}]")
    )
    longest = max(np.diff(cut.ends))
    assert 190 * 10**9 < longest < 210 * 10**9
    assert cut.figures.frames is not None
    assert cut.ends[-1] - whole.ends[-1] == pytest.approx(200 * 10**9, rel=0.05)


@given(
    count=st.sampled_from([4, 8, 16]),
    baud=st.sampled_from([115_200, 3_000_000, 12_000_000, 50_000_000]),
    fifo=st.sampled_from([1, 16, 64]),
)
@settings(max_examples=15)
def test_the_rate_that_fpga_and_line_allow_is_a_bound_in_the_long_run(
    ground: Ground, count: int, baud: int, fifo: int
) -> None:
    """Up to what fits the FIFO at the end, which nobody waits for."""
    figures = ground.fly(link=serial(baud, fifo), count=count, arrangement="random").figures
    spared = 2 + fifo // LineLaw(baud).characters(count)
    assert figures.updates - spared <= figures.span_s * figures.reachable_a_second * (1 + 1e-9)


def test_a_short_fifo_and_uneven_decisions_keep_a_fleet_below_that_bound(ground: Ground) -> None:
    short, whole, endless = (
        ground.fly(link=serial(10_000_000, fifo), count=32, arrangement="random").figures for fifo in (1, 128, 10_000)
    )
    bound = short.reachable_a_second
    assert short.reachable_a_second == whole.reachable_a_second == endless.reachable_a_second
    assert short.updates_a_second < 0.8 * bound
    assert short.updates_a_second < whole.updates_a_second < 0.99 * bound
