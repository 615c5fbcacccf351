"""Each kind of component with some work to do: a new component adds one entry to ``COMPONENTS``."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from typing import Any

import numpy as np
import simpy

from codesign.components import (
    Arbitration,
    BlockRam,
    Bus,
    ClockDomain,
    Component,
    ExternalMemory,
    Fpga,
    LinkErrors,
    Processor,
    Scan,
    Serial,
    VgaDisplay,
)
from codesign.ground.records import Listener, TaskRecord
from codesign.laws.acts import BusLaw, SerialLaw
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.planners.styles import Step

CLOCK = ClockDomain(33_000_000)
LAW = BusLaw(CLOCK.hz, width=32, burst_words=4, setup_cycles=3)
Work = Generator[simpy.Event, Any, Any]
Build = Callable[[simpy.Environment, Sequence[Listener]], tuple[Component, list[Work]]]


def an_fpga(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    fpga = Fpga(environment, "unit", CLOCK, listeners)

    def steps() -> Generator[Step, None, None]:
        yield Step("relax", np.array([3, 4, 5]), lambda begin, end, source: TaskRecord(begin, source, "relax", end, 12))

    return fpga, [fpga.execute(steps())]


def a_bus(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    bus = Bus(environment, "unit", LAW, listeners=listeners)
    return bus, [bus.send("host", "fpga", name, bits) for name, bits in (("map", 1000), ("goals", 1), ("go", 33))]


def a_bus_in_bursts(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    bus = Bus(environment, "unit", LAW, arbitration=Arbitration.BURST, listeners=listeners)
    return bus, [bus.send(sender, "pc", "map", bits) for sender, bits in (("host", 1000), ("fpga", 999))]


def a_serial_line(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    errors = LinkErrors(bit_error_rate=0.01, checksum_bits=8, retries=2, timeout=1_000, drop=0.1, seed=3)
    line = Serial(environment, "unit", SerialLaw(921_600), errors=errors, listeners=listeners)
    return line, [line.send("host", "fpga", "way", bits) for bits in (80, 8, 33, 160)]


def an_urgent_task(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    processor = Processor(environment, "unit", CLOCK, {"update": 42_088}, listeners)
    return processor, [processor.execute("update", 100, priority=1), processor.execute("update", 7)]


def a_processor(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    processor = Processor(environment, "unit", CLOCK, {"update": 42_088}, listeners)
    return processor, [processor.execute("update", 100), processor.execute("update", 0, task="nothing")]


def a_block_ram(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    ram = BlockRam(environment, "unit", CLOCK, depth=1024, width=18, listeners=listeners)

    def use() -> Work:
        yield environment.timeout(CLOCK.edge(20))
        ram.stream(0, 12)

    return ram, [use()]


SCAN = Scan(4, 2, 6, 3)
SRAM = ExternalMemoryLaw("sram", CLOCK.hz, 32, 2**20, 3)


def a_memory(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    memory = ExternalMemory(environment, "unit", SRAM, listeners)
    return memory, [memory.read(5, sequential=True), memory.write(2, sequential=False)]


def a_memory_on_show(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    memory = ExternalMemory(environment, "unit", SRAM, listeners)
    VgaDisplay(environment, "screen", CLOCK, Scan(4, 2, 9, 3), memory=memory)
    return memory, [memory.read(5, sequential=True), memory.write(2, sequential=False)]


def a_block_ram_on_show(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    ram = BlockRam(environment, "unit", CLOCK, depth=64, width=1, listeners=listeners)
    VgaDisplay(environment, "screen", CLOCK, SCAN, memory=ram)

    def use() -> Work:
        yield environment.timeout(CLOCK.edge(20))
        ram.stream(3, 5, 1)
        ram.stream(9, 6, 2)

    return ram, [use()]


def a_display(environment: simpy.Environment, listeners: Sequence[Listener]) -> tuple[Component, list[Work]]:
    display = VgaDisplay(environment, "unit", CLOCK, SCAN, listeners=listeners)

    def nothing() -> Work:
        yield environment.timeout(CLOCK.edge(20))

    return display, [nothing()]


COMPONENTS: list[Build] = [
    an_fpga,
    a_bus,
    a_bus_in_bursts,
    a_serial_line,
    a_processor,
    an_urgent_task,
    a_block_ram,
    a_memory,
    a_memory_on_show,
    a_block_ram_on_show,
    a_display,
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
