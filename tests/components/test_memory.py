"""External memories: closed-form costs, users that queue, and a display that is served first."""

from __future__ import annotations

import pickle
from collections.abc import Generator
from dataclasses import replace
from fractions import Fraction
from math import ceil
from typing import Any

import numpy as np
import pytest
import simpy
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.components import ClockDomain, ExternalMemory, Scan, VgaDisplay
from codesign.ground.errors import InputError, RunError
from codesign.ground.records import Record, TaskRecord
from codesign.planners.external_memory import ExternalMemoryLaw

SRAM = ExternalMemoryLaw("sram", 100_000_000, 32, 8 * 2**20, 2)
DRAM = ExternalMemoryLaw("dram", 100_000_000, 16, 8 * 2**26, 3, row_words=512, row_cycles=5, refresh_share=0.02)


def test_costs_by_hand() -> None:
    assert [SRAM.random_cycles(n) for n in (0, 1, 10)] == [0, 2, 20]
    # The first word after its latency, then one a cycle.
    assert [SRAM.sequential_cycles(n) for n in (0, 1, 10)] == [0, 2, 11]
    assert replace(SRAM, burst_words=4).sequential_cycles(10) == 3 * 1 + 10
    assert replace(SRAM, latency_cycles=0).random_cycles(7) == 7
    still = replace(DRAM, refresh_share=0.0)
    assert still.random_cycles(10) == 10 * (3 + 5)
    # 1,000 words are two rows: two openings, two latencies.
    assert still.sequential_cycles(1000) == 1000 + 2 * (2 + 5)
    assert replace(still, burst_words=8).sequential_cycles(1000) == 1000 + 125 * 2 + 2 * 5
    # Of every 50 cycles one refreshes.
    assert DRAM.random_cycles(49) == ceil(Fraction(49 * 8 * 50, 49))
    assert SRAM.words == 262_144


@given(st.integers(1, 3000), st.integers(1, 200), st.integers(1, 100), st.integers(0, 9), st.integers(1, 6))
def test_a_run_is_the_sum_of_its_bursts(words: int, row: int, burst: int, open_row: int, latency: int) -> None:
    law = ExternalMemoryLaw("dram", 10**8, 16, 2**20, latency, row_words=row, row_cycles=open_row, burst_words=burst)
    cycles, at = 0, 0
    while at < words:
        end = min(words, at + burst, (at // row + 1) * row)
        cycles += (open_row if at % row == 0 else 0) + latency + end - at - 1
        at = end
    assert law.run_cycles(words) == cycles


@given(st.lists(st.integers(0, 50), min_size=1, max_size=30), st.floats(0, 0.9))
def test_refreshing_falls_into_units_and_adds_up(cycles: list[int], share: float) -> None:
    law = replace(DRAM, refresh_share=share)
    units = law.refreshed_units(np.array(cycles, np.int64))
    assert int(units.sum()) == law.refreshed(sum(cycles))
    assert (units >= cycles).all()
    assert law.refreshed(1000) == pytest.approx(1000 / (1 - share), rel=2e-2, abs=1)


@given(st.integers(1, 5000))
def test_a_better_memory_is_never_slower(words: int) -> None:
    for law in (SRAM, DRAM):
        better = [replace(law, latency_cycles=law.latency_cycles - 1), replace(law, refresh_share=0.0)]
        better += [replace(law, row_cycles=0)] if law.row_cycles else []
        for other in better:
            assert other.sequential_cycles(words) <= law.sequential_cycles(words)
            assert other.random_cycles(words) <= law.random_cycles(words)
        assert law.sequential_cycles(words) <= law.random_cycles(words)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"hz": 0}, "hz"),
        ({"width": 0}, "width"),
        ({"latency_cycles": -1}, "latency_cycles"),
        ({"row_words": 0}, "row_words"),
        ({"refresh_share": 1.0}, "refresh_share"),
        ({"capacity": 0}, "capacity"),
    ],
)
def test_a_memory_that_cannot_be_is_refused(change: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError, match=f"memory.{key}") as caught:
        replace(DRAM, **change)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_users_queue_and_begin_at_an_edge() -> None:
    environment = simpy.Environment()
    heard: list[Record] = []

    def hear(record: Record) -> None:
        heard.append(record)

    memory = ExternalMemory(environment, "sram", SRAM, (hear,))

    def late(delay: int, work: Generator[simpy.Event, Any, int]) -> Generator[simpy.Event, Any, int]:
        yield environment.timeout(delay)
        return (yield from work)

    environment.process(late(3, memory.read(10, sequential=True, task="queue")))
    environment.process(late(5, memory.write(4, sequential=False, task="map")))
    last = environment.process(late(200_001, memory.read(1, sequential=False)))
    environment.run()
    assert heard == [
        TaskRecord(10_000, "sram", "queue", 120_000, 11),
        TaskRecord(120_000, "sram", "map", 200_000, 8),
        TaskRecord(210_000, "sram", "read", 230_000, 2),
    ]
    assert last.value == 230_000
    assert memory.accesses == {"read": 11, "write": 4, "design": 0}
    assert memory.queued == (10_000 - 3) + (120_000 - 5) + (210_000 - 200_001)
    assert memory.busy == (11 + 8 + 2) * 10_000
    use = memory.utilisation()
    assert (use.busy, use.span) == (210_000, 230_000)
    with pytest.raises(RunError, match="sram: a read of 0 words"):
        next(memory.read(0, sequential=True))


def test_an_interrupted_user_frees_the_memory() -> None:
    environment = simpy.Environment()
    memory = ExternalMemory(environment, "sram", SRAM)

    def given_up() -> Generator[simpy.Event, Any, None]:
        try:
            yield from memory.read(1000, sequential=True)
        except simpy.Interrupt:
            return

    process = environment.process(given_up())
    later = environment.process(memory.write(1, sequential=False))

    def interrupt() -> Generator[simpy.Event, Any, None]:
        yield environment.timeout(55_000)
        process.interrupt()

    environment.process(interrupt())
    environment.run()
    assert later.value == 80_000
    assert memory.accesses == {"read": 0, "write": 1, "design": 0}
    assert memory.busy == 55_000 + 20_000


def test_what_is_allotted_fits() -> None:
    memory = ExternalMemory(simpy.Environment(), "sram", replace(SRAM, capacity=100))
    memory.allocate("map", 33)
    assert memory.bits_left == 36
    with pytest.raises(RunError, match="queue needs 64 bits, 36 of 100 are left"):
        memory.allocate("queue", 37)
    with pytest.raises(RunError, match="once for each name"):
        memory.allocate("map", 1)


@settings(max_examples=examples(100))
@given(
    st.lists(st.tuples(st.integers(0, 300_000), st.integers(1, 12), st.booleans()), min_size=1, max_size=6),
    st.integers(1, 8),
    st.integers(2, 6),
    st.integers(10, 14),
)
def test_a_display_is_served_first_cycle_by_cycle(
    uses: list[tuple[int, int, bool]], columns: int, rows: int, total: int
) -> None:
    """Against a walk over the cycles: the first of every line are the display's, the rest the users' in turn."""
    environment = simpy.Environment()
    memory = ExternalMemory(environment, "sram", SRAM)
    scan = Scan(columns, rows, total, rows + 2)
    display = VgaDisplay(environment, "screen", ClockDomain(100_000_000), scan, memory=memory)
    ends: list[int] = []

    def use(at: int, words: int, sequential: bool) -> Generator[simpy.Event, Any, None]:
        yield environment.timeout(at)
        ends.append((yield from memory.read(words, sequential=sequential)))

    for one in uses:
        environment.process(use(*one))
    environment.run()
    burst = columns + 1
    taken = [line * total + k for line in range(900) if line % (rows + 2) < rows for k in range(burst)]
    is_taken = set(taken)
    free_from, walked, served = 0, [], 0
    for at, words, sequential in sorted(uses, key=lambda use: use[0]):
        cycle = max(free_from, -(-at // 10_000))
        left = words + 1 if sequential else 2 * words
        while left:
            left -= cycle not in is_taken
            cycle += 1
        walked.append(cycle * 10_000)
        served += words
        free_from = cycle
    assert ends == walked
    assert memory.accesses == {"read": served, "write": 0, "design": 0}
    assert display.port_cycles == sum(cycle < memory.now // 10_000 for cycle in taken)
    assert memory.busy <= memory.now
    assert display.starved == 0


def test_a_display_on_a_slow_memory_starves() -> None:
    """A line of 8 words lasts 10 pixels; with 4 cycles of latency only 7 words come in 10 cycles."""
    environment = simpy.Environment()
    memory = ExternalMemory(environment, "sram", replace(SRAM, latency_cycles=4))
    display = VgaDisplay(environment, "screen", ClockDomain(100_000_000), Scan(8, 4, 10, 8), memory=memory)
    environment.run(until=10_000 * 80)
    assert display.frames == 1
    assert display.starved == 4 * (8 - 7)
    assert display.port_cycles == 4 * 10
    assert display.port_share == 0.5
    assert memory.busy == 40 * 10_000
    again = simpy.Environment()
    quick = ExternalMemory(again, "quick", replace(SRAM, latency_cycles=3))
    served = VgaDisplay(again, "other", ClockDomain(100_000_000), Scan(8, 4, 10, 8), memory=quick)
    again.run(until=10_000 * 80)
    assert (served.starved, served.port_cycles) == (0, 40)
