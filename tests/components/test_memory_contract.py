"""Memories and displays keep what every component promises."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
import simpy

import tests.components.test_contract as contract
from codesign.components import BlockRam, Component, ExternalMemory, Scan, VgaDisplay
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.records import Listener

SCAN = Scan(4, 2, 6, 3)
SRAM = ExternalMemoryLaw("sram", contract.CLOCK.hz, 32, 2**20, 3)


def a_memory(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[contract.Work]]:
    memory = ExternalMemory(environment, "unit", SRAM, listeners)
    return memory, [memory.read(5, sequential=True), memory.write(2, sequential=False)]


def a_memory_on_show(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[contract.Work]]:
    memory = ExternalMemory(environment, "unit", SRAM, listeners)
    VgaDisplay(environment, "screen", contract.CLOCK, Scan(4, 2, 9, 3), memory=memory)
    return memory, [memory.read(5, sequential=True), memory.write(2, sequential=False)]


def a_block_ram_on_show(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[contract.Work]]:
    ram = BlockRam(environment, "unit", contract.CLOCK, depth=64, width=1, listeners=listeners)
    VgaDisplay(environment, "screen", contract.CLOCK, SCAN, memory=ram)

    def use() -> contract.Work:
        yield environment.timeout(contract.CLOCK.edge(20))
        ram.stream(3, 5, 1)
        ram.stream(9, 6, 2)

    return ram, [use()]


def a_display(
    environment: simpy.Environment, listeners: Sequence[Listener]
) -> tuple[Component, list[contract.Work]]:
    display = VgaDisplay(environment, "unit", contract.CLOCK, SCAN, listeners=listeners)

    def nothing() -> contract.Work:
        yield environment.timeout(contract.CLOCK.edge(20))

    return display, [nothing()]


BUILDS = [a_memory, a_memory_on_show, a_block_ram_on_show, a_display]
every = pytest.mark.parametrize("build", BUILDS)
Build = Callable[[simpy.Environment, Sequence[Listener]], tuple[Component, list[contract.Work]]]


@every
def test_it_is_busy_some_of_the_time_and_never_more(build: Build) -> None:
    contract.test_it_is_busy_some_of_the_time_and_never_more(build)


@every
def test_it_emits_its_utilisation_last(build: Build) -> None:
    contract.test_it_emits_its_utilisation_last_and_its_times_are_integers(build)


@every
def test_it_is_deterministic_and_the_same_with_and_without_listeners(build: Build) -> None:
    contract.test_it_is_deterministic_and_the_same_with_and_without_listeners(build)


@every
def test_no_record_is_built_when_nobody_listens(build: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    contract.test_no_record_is_built_when_nobody_listens(build, monkeypatch)


def test_a_block_ram_on_show_is_busy_with_both() -> None:
    """A pixel a cycle: 4 of 6 in two of three lines; the design drives a port in 3 to 7, both in 9 to 14."""
    ram, _ = contract.simulate(a_block_ram_on_show)
    assert isinstance(ram, BlockRam)
    passed = ram.clock.cycles_by(ram.now)
    shown = {cycle for cycle in range(passed) if cycle % 18 // 6 < 2 and cycle % 6 < 4}
    design = {*range(3, 8), *range(9, 15)}
    assert ram.busy == pytest.approx(len(shown | design) * 10**12 / ram.clock.hz, abs=4)
    # Both ports are driven in 9 to 14: in the cycles that the display takes, the design's stand still.
    lost = len(set(range(9, 15)) & shown)
    assert ram.accesses == [5 + 6 - lost, 6 - lost + len(shown)]
