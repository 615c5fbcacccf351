"""Processors: tasks cost what is declared, the urgent preempt, and nothing is lost on the way."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import pytest
import simpy
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.components import ClockDomain, PreemptedError, Processor
from codesign.ground.errors import InputError, RunError
from codesign.ground.records import Record, TaskRecord

CLOCK = ClockDomain(33_000_000)
Work = Generator[simpy.Event, Any, Any]


def later(environment: simpy.Environment, at: int, work: Work) -> simpy.Process:
    def wait() -> Work:
        yield environment.timeout(at)
        return (yield from work)

    return environment.process(wait())


def one_core(cores: int = 1) -> tuple[simpy.Environment, Processor, list[Record]]:
    environment = simpy.Environment()
    heard: list[Record] = []
    return (
        environment,
        Processor(environment, "host", CLOCK, {"step": 1, "free": 0}, [heard.append], cores=cores),
        heard,
    )


def test_equals_queue_and_cost_what_is_declared() -> None:
    environment = simpy.Environment()
    heard: list[Record] = []
    processor = Processor(environment, "unit", CLOCK, {"update": 42_088}, (heard.append,))
    environment.process(processor.execute("update", 100))
    later(environment, 100_000, processor.execute("update", 0, task="nothing"))
    environment.run()
    duration = 100 * 42_088
    assert heard == [
        TaskRecord(0, "unit", "update", duration, -(-duration * 33_000_000 // 10**12)),
        TaskRecord(duration, "unit", "nothing", duration, 0),
    ]
    assert processor.busy == processor.core_busy == duration
    assert processor.waited == duration - 100_000


def test_a_kernel_without_cost_is_refused_by_name() -> None:
    processor = Processor(simpy.Environment(), "host", CLOCK, {"update": 1})
    with pytest.raises(RunError, match=r"host.costs: no cost is given for kernel 'updat'\n.*did you mean update"):
        processor.duration("updat", 1)
    with pytest.raises(RunError, match="-1 units"):
        processor.duration("update", -1)
    with pytest.raises(InputError, match=r"host\.cores: 0 cores"):
        Processor(simpy.Environment(), "host", CLOCK, {}, cores=0)


def test_an_urgent_task_preempts_and_the_other_goes_on_without_loss() -> None:
    environment, processor, heard = one_core()
    plan = environment.process(processor.execute("step", 100, "plan", priority=5))
    # Asked for before the preemption, of the priority of what is preempted: it comes after it all the same.
    equal = later(environment, 10, processor.execute("step", 7, "equal", priority=5))
    control = later(environment, 30, processor.execute("step", 20, "control", priority=0))
    again = later(environment, 40, processor.execute("step", 20, "again", priority=0))
    environment.run()
    assert (control.value, again.value, plan.value, equal.value) == (50, 70, 140, 147)
    assert [(r.task, r.time, r.end, r.outcome) for r in heard if isinstance(r, TaskRecord)] == [
        ("plan", 0, 30, "preempted"),
        ("control", 30, 50, "ended"),
        ("again", 50, 70, "ended"),
        ("plan", 70, 140, "ended"),
        ("equal", 140, 147, "ended"),
    ]
    assert processor.busy == 147
    assert processor.waited == 40 + 10 + 130


def test_a_task_that_ends_when_an_urgent_one_comes_has_ended() -> None:
    environment, processor, _ = one_core()
    control = later(environment, 100, processor.execute("step", 50, priority=0))
    plan = environment.process(processor.execute("step", 100, priority=1))
    environment.run()
    assert (plan.value, control.value) == (100, 150)


def test_a_task_without_duration_takes_no_time_and_waits_its_turn() -> None:
    environment, processor, heard = one_core()
    first = environment.process(processor.execute("free", 10**6))
    environment.process(processor.execute("step", 9, priority=1))
    urgent = later(environment, 4, processor.execute("free", 3, "urgent", priority=0))
    waits = later(environment, 4, processor.execute("step", 0, "waits", priority=1))
    environment.run()
    assert (first.value, urgent.value, waits.value, processor.busy) == (0, 4, 9, 9)
    assert [r.time for r in heard] == [0, 0, 4, 4, 9]


def test_cores_run_side_by_side_and_the_least_urgent_is_preempted() -> None:
    environment, processor, _ = one_core(cores=2)
    low = environment.process(processor.execute("step", 100, priority=2))
    middle = environment.process(processor.execute("step", 100, priority=1))
    urgent = later(environment, 50, processor.execute("step", 25, priority=0))
    environment.run()
    assert (urgent.value, middle.value, low.value) == (75, 100, 125)
    assert (processor.busy, processor.core_busy, processor.waited) == (125, 225, 25)


def test_an_interruption_tells_what_was_done_and_frees_the_core() -> None:
    environment = simpy.Environment()
    heard: list[Record] = []
    processor = Processor(environment, "host", CLOCK, {"step": 40_000}, (heard.append,))
    caught: list[PreemptedError] = []

    def work(priority: int) -> Work:
        try:
            yield from processor.execute("step", 10, "plan", priority)
        except PreemptedError as error:
            caught.append(error)

    running = environment.process(work(0))
    waiting = environment.process(work(1))
    other = environment.process(processor.execute("step", 1, priority=2))

    def outside() -> Work:
        yield environment.timeout(100_000)
        waiting.interrupt("enough")
        running.interrupt("obstacle")

    environment.process(outside())
    environment.run()
    # 100 ns: two units of 40 ns, and 3.3 cycles of 33 MHz.
    assert [error.args for error in caught] == [("enough", 100_000, None, 0, 0), ("obstacle", 100_000, "plan", 2, 3)]
    assert other.value == 140_000
    tasks = [record for record in heard if isinstance(record, TaskRecord)]
    assert [(task.time, task.end, task.cycles, task.outcome) for task in tasks] == [
        (0, 100_000, 4, "broken off"),
        (100_000, 140_000, 2, "ended"),
    ]
    assert processor.busy == 140_000


def test_a_task_interrupted_at_its_very_end_has_done_all_its_units() -> None:
    environment, processor, heard = one_core()
    caught: list[PreemptedError] = []
    processes: list[simpy.Process] = []

    def outside() -> Work:
        yield environment.timeout(100)
        processes[0].interrupt("late")

    def work() -> Work:
        try:
            yield from processor.execute("step", 100, "plan")
        except PreemptedError as error:
            caught.append(error)

    environment.process(outside())
    processes.append(environment.process(work()))
    environment.run()
    assert (caught[0].units, caught[0].phase) == (100, "plan")
    assert heard == [TaskRecord(0, "host", "plan", 100, 1)]


def test_an_interruption_and_a_preemption_at_one_moment_hit_once() -> None:
    """The controller gives up the plan and has its own task run: nothing hits the planner after it left."""
    environment, processor, _ = one_core()
    hits: list[object] = []

    def planning() -> Work:
        try:
            yield from processor.execute("step", 100, priority=1)
        except PreemptedError as error:
            hits.append(error.cause)
        yield environment.timeout(1_000)
        return "unharmed"

    plan = environment.process(planning())

    def controller() -> Work:
        yield environment.timeout(10)
        plan.interrupt("replan")
        yield from processor.execute("step", 5, priority=0)
        return environment.now

    control = environment.process(controller())
    environment.run()
    assert (plan.value, control.value, hits) == ("unharmed", 15, ["replan"])


tasks = st.lists(st.tuples(st.integers(0, 60), st.integers(1, 25), st.integers(0, 2)), max_size=8)


@settings(max_examples=examples(200))
@given(tasks, st.integers(1, 3))
def test_it_equals_a_picosecond_by_picosecond_schedule(asked: list[tuple[int, int, int]], cores: int) -> None:
    environment, processor, heard = one_core(cores)
    asked = sorted(asked, key=lambda task: task[0])
    for index, (at, units, priority) in enumerate(asked):
        later(environment, at, processor.execute("step", units, str(index), priority))
    environment.run()
    told = [r for r in heard if isinstance(r, TaskRecord)]
    ends = {int(r.task): r.end for r in told if r.outcome == "ended"}

    left = {index: units for index, (_, units, _) in enumerate(asked)}
    expected: dict[int, int] = {}
    busy = core_busy = time = 0
    while left:
        ready = sorted((i for i in left if asked[i][0] <= time), key=lambda i: (asked[i][2], i))
        # The records of this picosecond are those of the tasks that are on a core, and of no other.
        assert sorted(int(r.task) for r in told if r.time <= time < r.end) == sorted(ready[:cores])
        for index in ready[:cores]:
            left[index] -= 1
        busy += bool(ready)
        core_busy += len(ready[:cores])
        time += 1
        for index in ready[:cores]:
            if not left[index]:
                expected[index] = time
                del left[index]
    assert ends == expected
    assert (processor.busy, processor.core_busy) == (busy, core_busy)
    assert processor.waited == sum(expected[i] - at - units for i, (at, units, _) in enumerate(asked))
    for index, (_, units, _) in enumerate(asked):
        assert sum(r.cycles for r in told if r.task == str(index)) == CLOCK.cycle_at_or_after(units)
