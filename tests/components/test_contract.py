"""What every component promises, whatever it does: a new component adds one entry to ``COMPONENTS``."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import fields
from types import NoneType
from typing import Any

import numpy as np
import pytest
import simpy

from codesign.components import (
    Arbitration,
    BlockRam,
    Bus,
    ClockDomain,
    Component,
    Fpga,
    LinkErrors,
    Processor,
    Serial,
    choose_shape,
)
from codesign.errors import RunError
from codesign.planners.styles import Step
from codesign.records import Listener, Record, TaskRecord

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


def a_bus_in_bursts(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[Work]]:
    bus = Bus(
        environment,
        "unit",
        CLOCK,
        width=32,
        setup_cycles=3,
        burst_words=4,
        arbitration=Arbitration.BURST,
        listeners=listeners,
    )
    return bus, [bus.send(sender, "pc", "map", bits) for sender, bits in (("host", 1000), ("fpga", 999))]


def a_serial_line(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[Work]]:
    errors = LinkErrors(bit_error_rate=0.01, checksum_bits=8, retries=2, timeout=1_000, drop=0.1, seed=3)
    line = Serial(environment, "unit", baud=921_600, errors=errors, listeners=listeners)
    return line, [line.send("host", "fpga", "way", bits) for bits in (80, 8, 33, 160)]


def an_urgent_task(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[Work]]:
    processor = Processor(environment, "unit", CLOCK, {"update": 42_088}, listeners)
    return processor, [processor.execute("update", 100, priority=1), processor.execute("update", 7)]


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


COMPONENTS: list[Build] = [
    an_fpga,
    a_bus,
    a_bus_in_bursts,
    a_serial_line,
    a_processor,
    an_urgent_task,
    a_block_ram,
]


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
    component.report_end()
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
        assert all(
            type(getattr(record, field.name)) in (int, str, bool, NoneType) for field in fields(record)
        )
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
