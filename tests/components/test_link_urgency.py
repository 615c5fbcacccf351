"""Control goes before plans, plans before side tasks, also when all are asked for in the same picosecond."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import simpy
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from link_runs import TIMED, Ask, Make, Work, run
from mission_specs import Ground

from codesign.components.channel import Turns
from codesign.ground.errors import RunError
from codesign.ground.records import MessageRecord, Record
from codesign.system.build import CONTROL, PLANNING, SIDE
from codesign.system.scenarios.drive.mission import drive
from codesign.views.trace import MemoryListener

EDGE = 30_304
"""ps, a little more than a cycle of the bus of ``link_runs``: where a message waits for its edge."""

asks = st.builds(
    Ask,
    at=st.integers(0, 60).map(lambda step: step * 100_000),
    sender=st.sampled_from("abc"),
    bits=st.integers(1, 900),
    priority=st.sampled_from([CONTROL, PLANNING]),
)
side = st.builds(replace, asks, priority=st.just(SIDE))


@pytest.mark.parametrize("make", TIMED)
@settings(max_examples=60)
@given(urgent=asks, others=st.lists(side, max_size=6), place=st.integers(0, 6))
def test_side_messages_delay_another_by_what_is_on_the_wire_at_most(
    make: Make, urgent: Ask, others: list[Ask], place: int
) -> None:
    """``place``: where among the others its sender is started, which must not matter."""
    alone = run(make, [urgent]).deliveries[0].time
    place = min(place, len(others))
    seen = run(make, [*others[:place], urgent, *others[place:]])
    delay = seen.deliveries[place].time - alone
    longest = max((seen.link.duration(ask.bits) for ask in others if ask.at < urgent.at), default=0)
    if "bursts" in make.__name__:
        longest = min(longest, seen.link.duration(4 * 32))
    assert 0 <= delay <= longest + (EDGE if longest else 0)


@pytest.mark.parametrize("make", TIMED)
@settings(max_examples=60)
@given(wanted=st.lists(asks, min_size=1, max_size=4), other=side, busy=st.booleans(), data=st.data())
def test_messages_of_one_picosecond_go_by_their_urgency(
    make: Make, wanted: list[Ask], other: Ask, busy: bool, data: st.DataObject
) -> None:
    """All of one sender, so that all share a line; ``busy``: a control message is on the wire when they come."""
    first = [Ask(0, "a", 640)] if busy else []
    at = 100_000 if busy else 0
    wanted = data.draw(st.permutations([replace(ask, at=at, sender="a") for ask in [*wanted, other]]))
    seen = run(make, [*first, *wanted])
    ends = sorted(range(len(wanted)), key=lambda index: seen.deliveries[index + len(first)].time)
    assert ends == sorted(range(len(wanted)), key=lambda index: (wanted[index].priority, index))


@settings(max_examples=examples(100))
@given(asked=st.lists(st.tuples(st.integers(0, 3), st.sampled_from([CONTROL, PLANNING, SIDE])), max_size=8))
def test_turns_on_what_serves_one_at_a_time_go_by_urgency(asked: list[tuple[int, int]]) -> None:
    environment = simpy.Environment()
    turns = Turns(environment, "fpga")
    served: list[tuple[int, int]] = []

    def user(index: int, at: int, priority: int) -> Work:
        yield environment.timeout(at)
        with turns.turn(priority) as turn:
            yield turn
            served.append((environment.now, index))
            yield environment.timeout(2)

    for index, (at, priority) in enumerate(asked):
        environment.process(user(index, at, priority))
    environment.run()
    expected: list[tuple[int, int]] = []
    left, now = set(range(len(asked))), 0
    while left:
        now = max(now, min(asked[index][0] for index in left))
        ready = [index for index in left if asked[index][0] <= now]
        chosen = min(ready, key=lambda index: (asked[index][1], asked[index][0], index))
        expected.append((now, chosen))
        left.remove(chosen)
        now += 2
    assert served == expected


def test_a_turn_that_nobody_waits_for_any_more_is_not_taken() -> None:
    environment = simpy.Environment()
    turns = Turns(environment, "fpga")
    had: list[int] = []

    def user(priority: int, spent: int) -> Work:
        with turns.turn(priority) as turn:
            try:
                yield turn
            except simpy.Interrupt:
                return
            had.append(priority)
            yield environment.timeout(spent)

    environment.process(user(CONTROL, 10))
    given_up = environment.process(user(PLANNING, 10))
    environment.process(user(SIDE, 10))
    environment.run(until=5)
    given_up.interrupt()
    environment.run()
    assert had == [CONTROL, SIDE]


def test_a_priority_below_the_most_urgent_is_refused() -> None:
    with pytest.raises(RunError, match="priority -1"):
        run(TIMED[0], [Ask(0, "a", 8, priority=-1)])
    with pytest.raises(RunError, match="priority -1"), Turns(simpy.Environment(), "fpga").turn(-1):
        pass


SHARED: dict[str, Any] = {
    "components": {
        "logger": {
            "type": "processor",
            "clock": "1 GHz",
            "costs": {"log_line": "1 us", "render_robot": "0 s"},
            "power": {"busy": "1 W", "idle": "1 W"},
        }
    },
    "links": {"pci": {"between": ["host", "fpga", "logger"]}},
}
"""One bus for plans and logs."""

LOGGING = {
    "tasks": [
        {"name": "log", "after": {"load": 4000}, "kernel": "log_line"},
        {"name": "note", "after": {"search": 4000, "track": 4000}, "kernel": "log_line"},
    ],
    "mapping": {"log": {"component": "logger"}, "note": {"component": "logger"}},
}


@settings(max_examples=examples(8), derandomize=True)
@given(
    arbitration=st.sampled_from(["message", "burst"]),
    granularity=st.sampled_from(["run_ahead", "visit"]),
    busy=st.sampled_from(["finish", "restart"]),
)
def test_a_log_message_delays_no_plan_of_a_drive(tmp_path: Path, arbitration: str, granularity: str, busy: str) -> None:
    """Logs are asked for where a plan's messages are: after the map was kept, and after the planner's tasks."""
    platform = [SHARED, {"links": {"pci": {"arbitration": arbitration}}}]
    wanted = {"known": "none", "replan": {"trigger": "change", "when_busy": busy}, "limit": "6 s"}
    ground = Ground(tmp_path)
    runs = [
        ground.watched(platform=platform, workload=extra, granularity=granularity, **wanted)[1]
        for extra in ({}, LOGGING)
    ]
    plans = [
        [(each.name, each.time, each.begin, each.end) for each in of(records, "map", "directions", "path")]
        for records in runs
    ]
    assert plans[0] == plans[1]
    assert len(plans[0]) > 10
    assert of(runs[1], "log")
    assert of(runs[1], "note")


def of(records: list[Record], *names: str) -> list[MessageRecord]:
    return [record for record in records if isinstance(record, MessageRecord) and record.name in names]


def test_a_frame_for_the_display_is_a_side_message(tmp_path: Path) -> None:
    """What only shows where the robot is yields to the control loop and to plans."""
    listener = MemoryListener()
    mapped = {"display": {"component": "logger"}}
    machine = Ground(tmp_path).machine(platform=SHARED, mapping=mapped, listeners=[listener], known="none", limit="3 s")
    asked: dict[str, set[int]] = {}
    for link in machine.links.values():

        def spied(*args: Any, send: Any = link.send, **more: Any) -> Any:
            asked.setdefault(args[2], set()).add(args[4])
            return send(*args, **more)

        link.send = spied  # type: ignore[method-assign]
    drive(machine)
    assert asked["frame"] == {SIDE}
    assert asked["map"] == {PLANNING}
    assert asked["scan"] == asked["command"] == {CONTROL}
