"""Run-ahead against visit by visit: the same records, times and order, whatever else happens."""

from __future__ import annotations

import pickle
from collections.abc import Generator
from typing import Any

import numpy as np
import pytest
import simpy
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.components import ClockDomain, Fpga, Granularity, PhaseUse, PreemptedError
from codesign.ground.errors import RunError
from codesign.ground.records import Record, TaskRecord
from codesign.planners.styles import Step

CLOCK = ClockDomain(150_000_000)


def step(cycles: list[int], phase: str = "relax") -> Step:
    array = np.array(cycles, dtype=np.int64)

    def record(begin: int, end: int, source: str) -> TaskRecord:
        return TaskRecord(time=begin, source=source, task=phase, end=end, cycles=int(array.sum()))

    return Step(phase, array, record)


def steps_of(batches: list[list[int]]) -> Generator[Step, None, str]:
    for index, cycles in enumerate(batches):
        yield step(cycles, f"phase {index % 2}")
    return "plan"


def run(
    granularity: Granularity, batches: list[list[int]], delays: list[int], second: list[list[int]], late: int
) -> tuple[list[tuple[int, Any]], dict[str, PhaseUse], int, Any]:
    """Two FPGAs and a ticking neighbour; everything that anybody says, in the order in which it was said."""
    environment = simpy.Environment()
    said: list[tuple[int, Any]] = []

    def hear(record: Record) -> None:
        said.append((int(environment.now), record))

    def neighbour() -> Generator[simpy.Event, Any, None]:
        for delay in delays:
            yield environment.timeout(delay)
            said.append((int(environment.now), "tick"))

    first_fpga = Fpga(environment, "first", CLOCK, (hear,))
    other = Fpga(environment, "second", ClockDomain(100_000_000), (hear,))

    def begin_late() -> Generator[simpy.Event, Any, Any]:
        yield environment.timeout(late)
        result = yield from other.execute(steps_of(second), granularity)
        said.append((int(environment.now), result))

    environment.process(begin_late())
    process = environment.process(first_fpga.execute(steps_of(batches), granularity))
    environment.process(neighbour())
    environment.run()
    return said, first_fpga.phases, first_fpga.busy, process.value


# Three cycles of 150 MHz are two of 100 MHz are 20 ns: all three often meet, so ties are common.
batches = st.lists(st.lists(st.sampled_from([1, 2, 3, 3, 6]), max_size=6), max_size=4)
delays = st.lists(st.sampled_from([0, 1, 6667, 10_000, 10_000, 20_000, 20_000, 30_000, 40_000]), max_size=12)


@settings(max_examples=examples(150))
@given(batches, delays, batches, st.sampled_from([0, 1, 10_000, 20_000]))
def test_run_ahead_equals_visit_by_visit(
    first: list[list[int]], ticks: list[int], second: list[list[int]], late: int
) -> None:
    assert run(Granularity.RUN_AHEAD, first, ticks, second, late) == run(Granularity.VISIT, first, ticks, second, late)


@pytest.mark.parametrize("granularity", Granularity)
def test_at_a_tie_the_order_is_that_of_scheduling(granularity: Granularity) -> None:
    """The neighbour's second tick is scheduled at 10 ns, the FPGA's last unit at 20 ns; both end at 40 ns."""
    said, *_ = run(granularity, [[3, 3]], [10_000, 30_000], [], 0)
    assert [(time, what if isinstance(what, str) else "record") for time, what in said] == [
        (0, "plan"),
        (10_000, "tick"),
        (40_000, "tick"),
        (40_000, "record"),
    ]


def test_run_ahead_makes_one_event_a_step_when_nobody_else_acts() -> None:
    made: dict[Granularity, int] = {}
    for granularity in Granularity:
        environment = simpy.Environment()
        fpga = Fpga(environment, "fpga", CLOCK)
        process = environment.process(fpga.execute(steps_of([[3] * 1000, [4] * 1000]), granularity))
        made[granularity] = 0
        while environment.peek() != float("inf"):
            environment.step()
            made[granularity] += 1
        assert process.value == "plan"
        assert environment.now == CLOCK.edge(7000)
        assert isinstance(environment.now, int)
    assert made[Granularity.RUN_AHEAD] < 10
    assert made[Granularity.VISIT] >= 2000


def test_work_begins_at_the_next_edge_and_is_booked_by_phase() -> None:
    environment = simpy.Environment()
    heard: list[Record] = []
    fpga = Fpga(environment, "fpga", CLOCK, (heard.append,))

    def late() -> Generator[simpy.Event, Any, None]:
        yield environment.timeout(1)
        yield from fpga.execute(iter_steps())

    def iter_steps() -> Generator[Step, None, None]:
        yield step([2, 3], "load")
        yield Step("quiet", np.array([4]))
        yield step([], "nothing")
        yield step([5], "load")

    environment.process(late())
    environment.run()
    assert [(type(record), record.time) for record in heard] == [
        (TaskRecord, CLOCK.edge(1)),
        (TaskRecord, CLOCK.edge(10)),
        (TaskRecord, CLOCK.edge(10)),
    ]
    assert fpga.phases["load"] == PhaseUse(10, CLOCK.edge(6) - CLOCK.edge(1) + CLOCK.edge(15) - CLOCK.edge(10))
    assert fpga.phases["quiet"] == PhaseUse(4, CLOCK.edge(10) - CLOCK.edge(6))
    assert fpga.busy == CLOCK.edge(15) - CLOCK.edge(1)
    assert sum(use.busy for use in fpga.phases.values()) == fpga.busy


@pytest.mark.parametrize("granularity", Granularity)
@given(cycles=st.lists(st.integers(1, 5), min_size=1, max_size=8), at=st.integers(0, 300_000), announced=st.booleans())
@settings(max_examples=60)
def test_an_interruption_tells_how_many_units_are_done(
    granularity: Granularity, cycles: list[int], at: int, announced: bool
) -> None:
    environment = simpy.Environment()
    heard: list[Record] = []
    fpga = Fpga(environment, "fpga", CLOCK, (heard.append,))
    caught: list[PreemptedError] = []

    def work() -> Generator[simpy.Event, Any, None]:
        try:
            yield from fpga.execute(steps_of([cycles]), granularity)
        except PreemptedError as preempted:
            caught.append(preempted)

    process = environment.process(work())
    if announced:
        # Somebody else's event in the queue: the obstacle is known to the simulation before it appears.
        environment.process(obstacle(environment, process, at))
    elif at:
        # An event from outside the simulation: run-ahead has already passed this moment.
        environment.run(until=at)
        if process.is_alive:
            process.interrupt("obstacle")
    environment.run()
    ends = [CLOCK.edge(int(end)) for end in np.cumsum(cycles)]
    for preempted in caught:
        assert preempted.cause == "obstacle"
        assert preempted.time == at
        assert preempted.units == sum(end <= at for end in ends)
        assert preempted.cycles == CLOCK.cycles_by(at)
        assert fpga.busy == at
        (told,) = heard
        assert isinstance(told, TaskRecord)
        assert told.end == at or preempted.units == len(cycles)
        outcome = "ended" if preempted.units == len(cycles) else "broken off"
        cut = sum(cycles) if outcome == "ended" else preempted.cycles
        assert (told.time, told.cycles, told.outcome) == (0, cut, outcome)
    if announced or at:
        assert bool(caught) == (at <= ends[-1])
    # The FPGA is free again.
    environment.process(fpga.execute(steps_of([[1]]), granularity))
    environment.run()


def obstacle(environment: simpy.Environment, process: simpy.Process, at: int) -> Generator[simpy.Event, Any, None]:
    yield environment.timeout(at)
    if process.is_alive:
        process.interrupt("obstacle")


def test_an_interruption_before_the_first_edge() -> None:
    environment = simpy.Environment()
    fpga = Fpga(environment, "fpga", CLOCK)

    def late() -> Generator[simpy.Event, Any, PreemptedError]:
        yield environment.timeout(2)
        try:
            yield from fpga.execute(steps_of([[1]]))
        except PreemptedError as preempted:
            return preempted
        raise AssertionError("not interrupted")

    process = environment.process(late())
    environment.process(obstacle(environment, process, 5))
    environment.run()
    assert (process.value.phase, process.value.units, process.value.cycles) == (None, 0, 0)
    assert fpga.busy == 0
    copy = pickle.loads(pickle.dumps(process.value))
    assert copy.args == process.value.args


def test_two_tasks_at_once_are_refused() -> None:
    environment = simpy.Environment()
    fpga = Fpga(environment, "fpga", CLOCK)
    environment.process(fpga.execute(steps_of([[5]])))
    environment.process(fpga.execute(steps_of([[5]])))
    with pytest.raises(RunError, match="was given work while it was working"):
        environment.run()


@pytest.mark.parametrize("cycles", [[0], [3, -1], [2**62, 2**62]])
def test_units_without_a_length_are_refused(cycles: list[int]) -> None:
    environment = simpy.Environment()
    environment.process(Fpga(environment, "fpga", CLOCK).execute(steps_of([cycles])))
    with pytest.raises(RunError, match="cycles"):
        environment.run()


def test_a_hundred_thousand_units_beyond_64_bit_picoseconds() -> None:
    """Edges pass 2^63 ps after some hours of simulated time; the arithmetic must not wrap."""
    environment = simpy.Environment()
    fpga = Fpga(environment, "fpga", ClockDomain(1))
    environment.process(fpga.execute(steps_of([[1000] * 100_000])))
    environment.run()
    assert environment.now == 10**8 * 10**12
