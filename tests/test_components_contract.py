"""What every component promises, whatever it does: a new component adds one entry to ``COMPONENTS``."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
import simpy

from codesign.architectures.interface import Step
from codesign.components import BlockRam, Bus, ClockDomain, Component, Fpga, Processor, choose_shape
from codesign.errors import InputError, RunError
from codesign.records import Listener, MessageRecord, Record, TaskRecord

CLOCK = ClockDomain(33_000_000)
Work = Generator[simpy.Event, Any, Any]
Build = Callable[[simpy.Environment, Sequence[Listener]], tuple[Component, list[Work]]]


def an_fpga(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    fpga = Fpga(environment, "unit", CLOCK, listeners)

    def steps() -> Generator[Step, None, None]:
        yield Step(
            "relax",
            np.array([3, 4, 5]),
            lambda begin, end, source: TaskRecord(begin, source, "relax", end, 12),
        )

    return fpga, [fpga.execute(steps())]


def a_bus(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    bus = Bus(environment, "unit", CLOCK, width=32, setup_cycles=3, burst_words=4, listeners=listeners)
    return bus, [
        bus.send("host", "fpga", name, bits) for name, bits in (("map", 1000), ("goals", 1), ("go", 33))
    ]


def a_processor(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[Work]]:
    processor = Processor(environment, "unit", CLOCK, {"update": 42_088}, listeners)
    return processor, [processor.execute("update", 100), processor.execute("update", 0, task="nothing")]


def a_block_ram(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[Work]]:
    ram = BlockRam(environment, "unit", CLOCK, depth=1024, width=18, listeners=listeners)

    def use() -> Work:
        yield environment.timeout(CLOCK.edge(20))
        ram.stream(0, 12)

    return ram, [use()]


COMPONENTS: list[Build] = [an_fpga, a_bus, a_processor, a_block_ram]


def simulate(build: Build, listeners: Sequence[Listener] = ()) -> tuple[Component, list[int]]:
    """Run the component's work, one piece every 100 ns, then leave it idle for a while."""
    environment = simpy.Environment()
    component, works = build(environment, listeners)
    moments: list[int] = []

    def drive() -> Work:
        for work in works:
            environment.process(work)
            yield environment.timeout(100_000)

    environment.process(drive())
    while environment.peek() != float("inf"):
        environment.step()
        assert type(environment.now) is int
        moments.append(environment.now)
        assert 0 <= component.busy <= component.now
    environment.run(until=environment.now + 5)
    component.report_utilisation()
    return component, moments


@pytest.mark.parametrize("build", COMPONENTS)
def test_it_is_busy_some_of_the_time_and_never_more(build: Build) -> None:
    component, moments = simulate(build)
    assert component.name == "unit"
    assert 0 < component.busy < component.now
    assert moments == sorted(moments)
    use = component.utilisation()
    assert (use.busy, use.span, use.time) == (component.busy, component.now, component.now)


@pytest.mark.parametrize("build", COMPONENTS)
def test_it_emits_its_utilisation_last_and_its_times_are_integers(build: Build) -> None:
    heard: list[Record] = []
    component, _ = simulate(build, (heard.append,))
    assert heard[-1] == component.utilisation()
    for record in heard:
        assert record.source == "unit"
        assert all(type(getattr(record, field.name)) in (int, str) for field in fields(record))
        assert 0 <= record.time <= component.now


@pytest.mark.parametrize("build", COMPONENTS)
def test_it_is_deterministic_and_the_same_with_and_without_listeners(build: Build) -> None:
    first: list[Record] = []
    again: list[Record] = []
    third: list[Record] = []
    watched, moments = simulate(build, (first.append, third.append))
    simulate(build, (again.append,))
    alone, moments_alone = simulate(build)
    assert first == again == third
    assert moments == moments_alone
    assert (watched.busy, watched.now) == (alone.busy, alone.now)


@pytest.mark.parametrize("build", COMPONENTS)
def test_no_record_is_built_when_nobody_listens(build: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("a record was emitted")

    monkeypatch.setattr(Component, "emit", refuse)
    simulate(build)


def test_bus_messages_queue_and_each_begins_at_an_edge() -> None:
    heard: list[Record] = []
    bus, _ = simulate(a_bus, (heard.append,))
    assert isinstance(bus, Bus)
    messages = [record for record in heard if isinstance(record, MessageRecord)]
    # 1000 bits: 32 words, 8 bursts of 3 + 4 cycles; 1 bit: 1 burst of 3 + 1; 33 bits: 2 words, 3 + 2.
    assert [bus.cycles(message.bits) for message in messages] == [56, 4, 5]
    assert [message.name for message in messages] == ["map", "goals", "go"]
    assert [(message.begin, message.end) for message in messages] == [
        (0, CLOCK.edge(56)),
        (CLOCK.edge(56), CLOCK.edge(60)),
        (CLOCK.edge(60), CLOCK.edge(65)),
    ]
    assert bus.busy == CLOCK.edge(65)
    assert bus.queued == sum(message.begin - message.time for message in messages)
    assert (bus.messages, bus.bits) == (3, 1034)


def test_an_interrupted_message_frees_the_bus() -> None:
    environment = simpy.Environment()
    bus = Bus(environment, "pci", CLOCK, width=32, setup_cycles=0, burst_words=16)

    def given_up() -> Work:
        try:
            yield from bus.send("host", "fpga", "map", 32_000)
        except simpy.Interrupt:
            return

    process = environment.process(given_up())
    later = environment.process(bus.send("host", "fpga", "again", 32))

    def interrupt() -> Work:
        yield environment.timeout(CLOCK.edge(10))
        process.interrupt()

    environment.process(interrupt())
    environment.run()
    assert later.value == CLOCK.edge(11)
    assert bus.busy == CLOCK.edge(11)
    assert bus.messages == 1


@pytest.mark.parametrize("bits", [0, -8])
def test_an_empty_message_is_refused(bits: int) -> None:
    bus = Bus(simpy.Environment(), "pci", CLOCK, width=32, setup_cycles=0, burst_words=16)
    with pytest.raises(RunError, match=f"pci: a message of {bits} bits"):
        next(bus.send("host", "fpga", "map", bits))


@pytest.mark.parametrize(("key", "value"), [("width", 0), ("setup_cycles", -1), ("burst_words", 0)])
def test_a_bus_that_cannot_be_is_refused(key: str, value: int) -> None:
    numbers = {"width": 32, "setup_cycles": 0, "burst_words": 16, key: value}
    with pytest.raises(InputError, match=rf"pci.{key}: {key} of {value}"):
        Bus(simpy.Environment(), "pci", CLOCK, **numbers)


def test_processor_tasks_queue_and_cost_what_is_declared() -> None:
    heard: list[Record] = []
    processor, _ = simulate(a_processor, (heard.append,))
    tasks = [record for record in heard if isinstance(record, TaskRecord)]
    duration = 100 * 42_088
    assert tasks == [
        TaskRecord(0, "unit", "update", duration, -(-duration * 33_000_000 // 10**12)),
        TaskRecord(duration, "unit", "nothing", duration, 0),
    ]
    assert processor.busy == duration


def test_a_kernel_without_cost_is_refused_by_name() -> None:
    processor = Processor(simpy.Environment(), "host", CLOCK, {"update": 1})
    with pytest.raises(
        RunError, match=r"host.costs: no cost is given for kernel 'updat'\n.*did you mean update"
    ):
        processor.duration("updat", 1)
    with pytest.raises(RunError, match="-1 units"):
        processor.duration("update", -1)


def ram_at_the_end_of_time() -> BlockRam:
    environment = simpy.Environment()
    environment.run(until=10**9)
    return BlockRam(environment, "ram", CLOCK, depth=1024, width=18)


def test_block_ram_refuses_the_third_access_of_a_cycle() -> None:
    ram = ram_at_the_end_of_time()
    assert (ram.access(7), ram.access(7)) == (0, 1)
    with pytest.raises(RunError, match="3 accesses in cycle 7, the block RAM has 2 ports"):
        ram.access(7)
    assert ram.access(8) == 0
    assert ram.accesses == [2, 1]
    assert ram.busy == CLOCK.edge(9) - CLOCK.edge(7)


def test_block_ram_streams_leave_the_ports_they_do_not_use() -> None:
    ram = ram_at_the_end_of_time()
    ram.stream(3, 10, addresses=1)
    assert ram.access(12) == 1
    with pytest.raises(RunError, match="ports"):
        ram.access(12)
    with pytest.raises(RunError, match="3 accesses in cycle 13"):
        ram.stream(13, 4, addresses=3)
    with pytest.raises(RunError, match="out of order"):
        ram.access(5)
    with pytest.raises(RunError, match="before they happen"):
        ram.access(10**9)
    ram.stream(13, 1, addresses=2)
    assert ram.accesses == [11, 2]
    assert ram.busy == CLOCK.edge(14) - CLOCK.edge(3)


def test_block_ram_words_run_out_at_the_published_limit() -> None:
    """Section 5.4: 4 blocks with p = 255 fill the 1024 words exactly; a fifth does not fit."""
    ram = ram_at_the_end_of_time()
    for block in range(4):
        assert ram.allocate(f"block {block}", 256) == range(256 * block, 256 * block + 256)
    assert ram.words_left == 0
    with pytest.raises(RunError, match="block 4 needs 256 words, 0 of 1024 are left"):
        ram.allocate("block 4", 256)
    with pytest.raises(RunError, match="once for each name"):
        ram.allocate("block 0", 1)


def test_the_deepest_shape_that_is_wide_enough_is_chosen() -> None:
    shapes = [(16384, 1), (8192, 2), (4096, 4), (2048, 9), (1024, 18), (512, 36)]
    assert [choose_shape(shapes, width) for width in (1, 3, 18, 19)] == [
        (16384, 1),
        (4096, 4),
        (1024, 18),
        (512, 36),
    ]
    with pytest.raises(RunError, match=r"no shape of the block RAM is 37 bits wide\n.*36"):
        choose_shape(shapes, 37)
