"""The state machine beside an external memory, against a search that counts its accesses one by one."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import simpy
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign import maps
from codesign.components import (
    BlockRam,
    ClockDomain,
    ExternalMemory,
    Fpga,
    Granularity,
    PreemptedError,
    Scan,
    VgaDisplay,
)
from codesign.components.display import SVGA_65
from codesign.ground.errors import RunError
from codesign.ground.figures import Status
from codesign.inputs.library import load_part
from codesign.planners.breadth_first.plan.parameters import MemoryPlace, SearchParameters
from codesign.planners.breadth_first.plan.planner import PLANNER
from codesign.planners.breadth_first.plan.search import NEIGHBOURS
from codesign.planners.breadth_first.styles import ARCHITECTURES, StateMachine, external
from codesign.planners.external_memory import ExternalMemoryLaw
from codesign.planners.interface import Problem
from codesign.planners.job import Job

MACHINE = StateMachine()
SRAM = ExternalMemoryLaw("sram", 100_000_000, 32, 64 * 2**20, 3, name="sram")
DRAM = ExternalMemoryLaw(
    "dram", 100_000_000, 16, 2**28, 3, row_words=512, row_cycles=5, refresh_share=0.02, name="dram"
)


def a_problem(seed: int, rows: int = 12, columns: int = 15, density: float = 0.3) -> Problem:
    free = maps.random_obstacles(rows, columns, density=density, seed=seed).free.copy()
    free[0, 0] = free[-1, -1] = True
    return Problem(free, ((rows - 1, columns - 1),), ((0, 0),))


def phases(problem: Problem, parameters: SearchParameters, **options: Any) -> dict[str, int]:
    found: dict[str, int] = {}
    for step in MACHINE.work(Job(problem, parameters, **options)):
        found[step.phase] = found.get(step.phase, 0) + int(step.cycles.sum())
    return found


def accesses(problem: Problem, everything: bool) -> tuple[int, int]:
    """(random accesses, runs of the queue) of state BF, counted while searching once more."""
    random = runs = pops = pushes = 0

    def push(cell: tuple[int, int]) -> None:
        nonlocal pushes, runs
        queue.append(cell)
        pushes += 1
        runs += pushes % 16 == 0

    queue: deque[tuple[int, int]] = deque()
    seen = {problem.starts[0]}
    push(problem.starts[0])
    while queue:
        runs += pops % 16 == 0
        pops += 1
        row, column = queue.popleft()
        if (row, column) in problem.goals:
            break
        random += 4 * everything
        for down, right in NEIGHBOURS:
            cell = row + down, column + right
            inside = 0 <= cell[0] < problem.rows and 0 <= cell[1] < problem.columns
            if inside and problem.free[cell] and cell not in seen:
                seen.add(cell)
                push(cell)
                random += 1 + everything
    return random, runs


@settings(max_examples=80)
@given(st.integers(0, 500), st.sampled_from(["block_ram", "process_external", "external"]), st.integers(1, 9))
def test_the_search_waits_for_every_access(seed: int, place: str, latency: int) -> None:
    problem = a_problem(seed)
    parameters = SearchParameters(memory=place, display="none")  # type: ignore[arg-type]
    inside = SearchParameters(memory=MemoryPlace.BLOCK_RAM)
    memory = replace(SRAM, latency_cycles=latency)
    near, far = phases(problem, inside), phases(problem, parameters, external=memory)
    random, runs = accesses(problem, place == "external")
    # 4 + 4 bits of address are a byte: 16 entries are 4 words, the first after the latency.
    assert external.entry_bits(problem, parameters) == 8
    assert far["bf"] - near["bf"] == random * latency + runs * (latency + 3)
    plan = PLANNER.plan(Job(problem, parameters))
    each = 2 if place == "external" else 1
    assert far.get("path", 0) - near.get("path", 0) == latency * each * len(plan.path) * plan.reached
    # Clearing 180 bytes, 4 a word, hides behind the circuit's own cell a cycle.
    assert far["init"] == near["init"]


@pytest.mark.parametrize("place", ["process_external", "external"])
@pytest.mark.parametrize("memory", [SRAM, DRAM])
def test_detail_moves_no_cycle(place: str, memory: ExternalMemoryLaw) -> None:
    problem, parameters = a_problem(3), SearchParameters(memory=place)  # type: ignore[arg-type]
    fine = phases(problem, parameters, external=memory)
    assert fine == phases(problem, parameters, external=memory, detail=False)
    plan = PLANNER.plan(Job(problem, parameters))
    waits = external.search(plan, problem, parameters, memory)
    still = external.search(plan, problem, parameters, replace(memory, refresh_share=0.0))
    assert int(waits.cycles.sum()) == memory.refreshed(int(still.cycles.sum()))
    assert waits.words.tolist() == still.words.tolist()
    assert phases(problem, parameters, external=replace(memory, latency_cycles=2))["bf"] < fine["bf"]


def test_a_narrow_memory_makes_the_clearing_slow() -> None:
    problem = a_problem(1)
    narrow = replace(SRAM, width=4, latency_cycles=1)
    parameters = SearchParameters(memory=MemoryPlace.EXTERNAL)
    # A byte is two words of 4 bits, the first after a latency of one cycle. No state of its own follows.
    assert phases(problem, parameters, external=narrow)["init"] == 2 * problem.free.size
    wide = phases(problem, parameters, external=replace(narrow, width=8))
    assert phases(problem, parameters, external=narrow)["bf"] > wide["bf"]


def test_the_process_memory_moves_out_and_the_map_fits() -> None:
    """512 × 512 cells: 512 block RAMs inside, of which the cells alone take 32; the part has 136."""
    part = load_part("XC2VP30-6")
    problem = Problem(np.ones((512, 512), np.bool_), ((511, 511),), ((0, 0),))
    parameters = SearchParameters(display="none")  # type: ignore[arg-type]
    alone, beside = (MACHINE.demand(Job(problem, parameters, part=part, external=memory)) for memory in (None, SRAM))
    budget = part.resources["block_rams"].value
    assert beside.total("block_rams") == 32 <= budget < alone.total("block_rams")
    assert beside.levers == {}
    bound = next(one for one in beside.bounds if one.name == "bits of sram")
    # A byte for each direction, three for each queue entry of 18 bits.
    assert bound.figure.value == (1 + 3) * 8 * 512 * 512 <= bound.limit
    everything = parameters.model_copy(update={"memory": MemoryPlace.EXTERNAL})
    outside = MACHINE.demand(Job(problem, everything, part=part, external=SRAM))
    assert outside.total("block_rams") == 0
    assert next(one for one in outside.bounds if one.name == "bits of sram").figure.value == 5 * 8 * 512 * 512
    assert all(item.figure.status is Status.ASSUMED for item in beside.items if "memory" in item.name)
    # A static RAM needs less of a controller than a dynamic one.
    assert beside.total("lut4") < MACHINE.demand(Job(problem, parameters, part=part, external=DRAM)).total("lut4")


def test_a_memory_too_small_says_what_would_do() -> None:
    problem, part = a_problem(2), load_part("XC2VP30-6")
    small = replace(SRAM, capacity=2000)
    bound = MACHINE.demand(Job(problem, SearchParameters(), part=part, external=small)).bounds[-1]
    assert bound.figure.value == 2 * 8 * 256 > bound.limit == 2000
    assert [lever.parameter for lever in bound.levers] == ["sram.capacity", "search.queue_words"]
    short = SearchParameters(queue_words=64)
    assert MACHINE.demand(Job(problem, short, part=part, external=small)).bounds[-1].figure.value == 8 * 256 + 8 * 64


def test_the_design_runs_no_faster_than_the_memory() -> None:
    problem, part, parameters = a_problem(2), load_part("XC2VP30-6"), SearchParameters()
    alone = MACHINE.clock_limit(Job(problem, parameters, part=part))
    slow = MACHINE.clock_limit(Job(problem, parameters, part=part, external=SRAM))
    assert (slow.value, slow.status) == (100e6, Status.ASSUMED)
    assert slow.interval == (100e6, alone.interval[1])
    assert MACHINE.clock_limit(Job(problem, parameters, part=part, external=replace(SRAM, hz=200_000_000))) == alone


def test_only_the_state_machine_knows_an_external_memory() -> None:
    knowing = [style.style for style in ARCHITECTURES if style.supports_external]
    assert knowing == ["state_machine"]


def beside_a_display(micro_architecture: str, shown: bool) -> tuple[dict[str, int], BlockRam]:
    environment = simpy.Environment()
    clock = ClockDomain(150_000_000)
    problem = a_problem(7, 60, 60, 0.2)
    parameters = SearchParameters(micro_architecture=micro_architecture, display="none")  # type: ignore[arg-type]
    memory = MACHINE.memory(Job(problem, parameters))
    assert memory is not None
    ram = BlockRam(environment, "fpga.block_ram", clock, depth=16_384, width=memory.width)
    if shown:
        scan = replace(SVGA_65, window=(60, 60))
        VgaDisplay(environment, "screen", ClockDomain(65_000_000), scan, memory=ram)
    fpga = Fpga(environment, "fpga", clock, (), ram)
    environment.process(fpga.execute(MACHINE.work(Job(problem, parameters)), Granularity.RUN_AHEAD))
    environment.run()
    return {phase: use.cycles for phase, use in fpga.phases.items()}, ram


@pytest.mark.parametrize("micro_architecture", ["three_cycles", "pipelined"])
def test_the_papers_display_slows_a_search_on_both_ports_only(micro_architecture: str) -> None:
    """VGA scan against search: with 3 cycles a neighbour a port is left; pipelined, none is, and state BF waits."""
    alone, _ = beside_a_display(micro_architecture, shown=False)
    shown, ram = beside_a_display(micro_architecture, shown=True)
    assert ram.claims is not None
    assert {key: shown[key] for key in ("init", "path")} == {key: alone[key] for key in ("init", "path")}
    first, last = alone["init"], alone["init"] + shown["bf"]
    lost = shown["bf"] - alone["bf"]
    if micro_architecture == "pipelined":
        assert lost == ram.claims.between(first, last) > 0
    else:
        assert lost == 0


# ---------------------------------------------------------------------- the memory beside the FPGA, simulated


def beside_a_memory(
    granularity: Granularity, parameters: SearchParameters, scan: Scan | None, interrupted: int | None = None
) -> tuple[Fpga, ExternalMemory, list[tuple[str, int, int]]]:
    environment = simpy.Environment()
    memory = ExternalMemory(environment, "sram", SRAM)
    told: list[tuple[str, int, int]] = []

    def hear(record: Any) -> None:
        told.append((record.task, record.time, record.end))

    fpga = Fpga(environment, "fpga", ClockDomain(75_000_000), (hear,))
    fpga.use(memory)
    if scan is not None:
        VgaDisplay(environment, "screen", ClockDomain(25_000_000), scan, memory=memory)

    def search() -> Generator[simpy.Event, Any, None]:
        try:
            yield from fpga.execute(MACHINE.work(Job(a_problem(3), parameters, external=SRAM)), granularity)
        except PreemptedError:
            told.append(("preempted", 0, 0))

    process = environment.process(search())

    def interrupt(at: int) -> Generator[simpy.Event, Any, None]:
        yield environment.timeout(at)
        process.interrupt()

    if interrupted is not None:
        environment.process(interrupt(interrupted))
    environment.run()
    return fpga, memory, told


@pytest.mark.parametrize("place", ["process_external", "external"])
def test_the_memory_is_as_busy_as_the_search_waits(place: str) -> None:
    problem, parameters = a_problem(3), SearchParameters(memory=place)  # type: ignore[arg-type]
    fpga, memory, _ = beside_a_memory(Granularity.RUN_AHEAD, parameters, None)
    assert {phase: use.cycles for phase, use in fpga.phases.items()} == phases(problem, parameters, external=SRAM)
    assert memory.clock is fpga.clock
    plan = PLANNER.plan(Job(problem, parameters))
    traffic = [
        external.init(problem, parameters, SRAM)[1],
        external.search(plan, problem, parameters, SRAM),
        external.path(plan, parameters, SRAM)[1],
    ]
    assert memory.accesses["design"] == sum(int(one.words.sum()) for one in traffic)
    cycles = sum(int(one.cycles.sum()) for one in traffic)
    assert memory.busy == pytest.approx(fpga.clock.edge(cycles), abs=3)
    # By hand: a word an access, four a run.
    random, runs = accesses(problem, place == "external")
    assert int(traffic[1].words.sum()) == random + 4 * runs


@settings(max_examples=25)
@given(st.integers(1, 6), st.integers(1, 4), st.integers(0, 30), st.sampled_from(["process_external", "external"]))
def test_a_display_on_the_external_memory_stalls_the_search(columns: int, rows: int, blank: int, place: str) -> None:
    """75 MHz beside 25-MHz pixels: a line begins with latency and words, in which the design stands still."""
    parameters = SearchParameters(memory=place)  # type: ignore[arg-type]
    scan = Scan(columns, rows, columns + blank + 1, rows + 2)
    runs = [beside_a_memory(granularity, parameters, scan) for granularity in Granularity]
    (visit, memory, told), (ahead, other, other_told) = runs
    assert (visit.phases, visit.busy, told) == (ahead.phases, ahead.busy, other_told)
    assert (memory.busy, memory.accesses) == (other.busy, other.accesses)
    assert memory.claims is not None
    alone = phases(a_problem(3), parameters, external=SRAM)
    begin = 0
    for phase, use in visit.phases.items():
        assert use.cycles - alone[phase] == memory.claims.between(begin, begin + use.cycles)
        begin += use.cycles
    assert memory.busy <= memory.now


@pytest.mark.parametrize("granularity", Granularity)
def test_interrupted_the_traffic_of_the_units_done_is_booked(granularity: Granularity) -> None:
    problem, parameters = a_problem(3), SearchParameters(memory=MemoryPlace.PROCESS_EXTERNAL)
    at = ClockDomain(75_000_000).edge(1000)
    _, memory, told = beside_a_memory(granularity, parameters, None, interrupted=at)
    assert told[-1][0] == "preempted"
    plan = PLANNER.plan(Job(problem, parameters))
    traffic = external.search(plan, problem, parameters, SRAM)
    ends = 181 + np.cumsum(MACHINE.expansion_cycles(plan, parameters, traffic))
    done = int(np.searchsorted(ends, 1000, side="right"))
    assert 0 < done < len(ends)
    assert memory.accesses["design"] == int(traffic.words[:done].sum())
    assert memory.busy == int(traffic.cycles[:done].sum()) * 10**12 // 75_000_000


def test_designs_and_displays_are_attached_in_order() -> None:
    environment = simpy.Environment()
    memory = ExternalMemory(environment, "sram", SRAM)
    with pytest.raises(RunError, match="sram: a design at 150000000 Hz beside a memory at 100000000 Hz"):
        Fpga(environment, "fast", ClockDomain(150_000_000)).use(memory)
    fpga = Fpga(environment, "fpga", ClockDomain(100_000_000))
    fpga.use(memory)
    with pytest.raises(RunError, match="too late, or is the second"):
        fpga.use(memory)
    with pytest.raises(RunError, match="a read beside a design"):
        next(memory.read(1, sequential=True))
    shown = ExternalMemory(environment, "shown", SRAM)
    VgaDisplay(environment, "screen", ClockDomain(25_000_000), Scan(8, 2, 20, 4), memory=shown)
    with pytest.raises(RunError, match="too late, or is the second"):
        fpga.use(shown)


def test_two_displays_that_stall_one_step_are_refused() -> None:
    environment = simpy.Environment()
    clock = ClockDomain(100_000_000)
    ram = BlockRam(environment, "ram", clock, depth=1024, width=1)
    fpga = Fpga(environment, "fpga", clock, (), ram)
    memory = ExternalMemory(environment, "sram", SRAM)
    fpga.use(memory)
    for index, one in enumerate((ram, memory)):
        VgaDisplay(environment, f"screen {index}", ClockDomain(25_000_000), Scan(8, 2, 20, 4), memory=one)
    parameters = SearchParameters(micro_architecture="pipelined", display="none")  # type: ignore[arg-type]
    environment.process(fpga.execute(MACHINE.work(Job(a_problem(3), parameters, external=SRAM))))
    with pytest.raises(RunError, match="two displays stall phase 'bf'"):
        environment.run()
