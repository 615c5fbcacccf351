"""Laws of breadth-first search: cycles from the search itself, block RAMs of the RTL, bounds, levers, software."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from codesign import maps
from codesign.ground.errors import InputError
from codesign.ground.figures import Status
from codesign.ground.memo import Memo
from codesign.ground.models import Part
from codesign.inputs.library import load_part
from codesign.planners.breadth_first.plan import search
from codesign.planners.breadth_first.plan.parameters import Address, MemoryPlace, SearchParameters, VgaController
from codesign.planners.breadth_first.plan.planner import PLANNER
from codesign.planners.breadth_first.plan.search import NEIGHBOURS
from codesign.planners.breadth_first.styles import ARCHITECTURES, StateMachine, resources, timing
from codesign.planners.breadth_first.styles.software import (
    JAVA_BYTES_A_CELL_HIGH,
    JAVA_BYTES_A_CELL_LOW,
    JAVA_HEAP,
    heap_bound,
    wall_cells,
)
from codesign.planners.breadth_first.styles.timing import pushes_of_each_pop
from codesign.planners.interface import Problem
from codesign.planners.job import Demand, Job, Line
from codesign.planners.measured import ResourceRow, resource_rows

MACHINE = StateMachine()
BY_STYLE = {style.style: style for style in ARCHITECTURES}


@pytest.fixture(scope="module")
def part() -> Part:
    return load_part("XC2VP30-6")


@pytest.fixture(scope="module")
def problem() -> Problem:
    free = maps.random_obstacles(40, 50, density=0.25, seed=2).free.copy()
    free[0, 0] = free[39, 49] = True
    return Problem(free, ((39, 49),), ((0, 0),))


def empty(rows: int, columns: int) -> Problem:
    return Problem(np.ones((rows, columns), np.bool_), ((rows - 1, columns - 1),), ((0, 0),))


def drained(steps: Any) -> tuple[dict[str, int], list[Any], Any]:
    phases: dict[str, int] = {}
    recorded = []
    while True:
        try:
            step = next(steps)
        except StopIteration as done:
            return phases, recorded, done.value
        phases[step.phase] = phases.get(step.phase, 0) + int(step.cycles.sum())
        recorded.append(step)


def bound(demand: Demand, name: str) -> Line:
    return next(bound for bound in demand.bounds if bound.name == name)


@pytest.mark.parametrize(("micro_architecture", "b"), [("three_cycles", 14), ("two_cycles", 9), ("pipelined", 6)])
def test_cycles_are_the_law(problem: Problem, micro_architecture: str, b: int) -> None:
    parameters = SearchParameters(micro_architecture=micro_architecture)  # type: ignore[arg-type]
    phases, _, plan = drained(MACHINE.work(Job(problem, parameters)))
    assert plan.reached
    constant = 4 if micro_architecture == "pipelined" else 2
    law = problem.free.size + b * (plan.popped_cells - 1) + 2 * (plan.path_steps + 1) + constant
    assert sum(phases.values()) == law
    assert list(phases) == ["init", "bf", "path"]


def test_a_corridor_by_hand() -> None:
    # 8 cells: Init 8; 7 expansions of 14 and the pop of the goal; 8 path cells of 2, and the start is seen.
    phases, _, _ = drained(MACHINE.work(Job(empty(1, 8), SearchParameters())))
    assert phases == {"init": 8, "bf": 7 * 14 + 1, "path": 17}


def test_without_a_way_every_cell_is_expanded_and_nothing_marked() -> None:
    free = np.ones((3, 5), np.bool_)
    free[:, 2] = False
    phases, _, plan = drained(MACHINE.work(Job(Problem(free, ((0, 4),), ((0, 0),)), SearchParameters())))
    assert not plan.reached
    assert phases == {"init": 15, "bf": 6 * 14 + 1}


@pytest.mark.parametrize("place", ["process_external", "external"])
def test_external_memory_costs_its_accesses(problem: Problem, place: str) -> None:
    inside = SearchParameters(display=VgaController.NONE)
    outside = SearchParameters(display=VgaController.NONE, memory=place, external_cycles=20)  # type: ignore[arg-type]
    near, _, plan = drained(MACHINE.work(Job(problem, inside)))
    far, _, _ = drained(MACHINE.work(Job(problem, outside)))
    # The pushes of the goal's ring that the search never got to expand are pushes all the same.
    pushed, popped = plan.pushed_cells - 1, plan.popped_cells - 1
    accesses = {"process_external": popped + 2 * pushed + 2, "external": 5 * popped + 3 * pushed + 2}[place]
    a_path_cell = {"process_external": 1, "external": 2}[place]
    assert far["bf"] - near["bf"] == 20 * accesses
    assert far["path"] - near["path"] == 20 * a_path_cell * len(plan.path)
    assert far["init"] == near["init"]


def test_pushes_belong_to_the_pop_that_made_them(problem: Problem) -> None:
    plan = search(problem.free, (0, 0), (39, 49))
    visited = {(0, 0)}
    expected = []
    for row, column in plan.order.tolist():
        around = [(row + down, column + right) for down, right in NEIGHBOURS]
        new = [
            cell
            for cell in around
            if 0 <= cell[0] < 40 and 0 <= cell[1] < 50 and problem.free[cell] and cell not in visited
        ]
        visited |= set(new)
        expected.append(len(new))
    expected[-1] = 0  # the goal is popped, not expanded
    assert pushes_of_each_pop(plan).tolist() == expected


@pytest.mark.parametrize("style", list(BY_STYLE))
@pytest.mark.parametrize("memory", ["block_ram", "process_external"])
def test_coarse_steps_cost_the_same_and_are_shared(problem: Problem, style: str, memory: str) -> None:
    parameters = SearchParameters(memory=memory)  # type: ignore[arg-type]
    memo = Memo()
    fine, recorded, plan = drained(BY_STYLE[style].work(Job(problem, parameters, detail=True)))
    first, _, _ = drained(BY_STYLE[style].work(Job(problem, parameters, memo=memo, detail=False)))
    second, _, again = drained(BY_STYLE[style].work(Job(problem, parameters, memo=memo, detail=False)))
    assert fine == first == second
    assert memo.hits == 1
    assert PLANNER.identity(plan) == PLANNER.identity(again) == PLANNER.identity(PLANNER.plan(Job(problem, parameters)))
    assert all(int(step.cycles.min()) >= 1 for step in recorded)
    records = [step.record(10, 20, "fpga") for step in recorded]
    assert sum(record.cycles for record in records) == sum(fine.values())
    assert [record.task for record in records] == [step.phase for step in recorded]


def test_large_searches_come_in_batches() -> None:
    _, recorded, plan = drained(MACHINE.work(Job(empty(300, 300), SearchParameters())))
    units = [len(step.cycles) for step in recorded if step.phase == "bf"]
    assert units == [1 << 16, plan.popped_cells - (1 << 16)]


@pytest.mark.parametrize(("side", "count"), [(30, 3), (100, 18), (256, 80), (257, 320)])
def test_block_rams_are_those_of_the_rtl(part: Part, side: int, count: int) -> None:
    demand = MACHINE.demand(Job(empty(side, side), SearchParameters(), part=part))
    assert demand.total("block_rams") == count


def test_a_display_takes_logic_and_a_copy_memories(part: Part) -> None:
    large = MACHINE.demand(Job(empty(100, 100), SearchParameters(display=VgaController.NONE), part=part))
    assert large.total("lut4") < 271, "an earlier design"
    with_display = MACHINE.demand(Job(empty(100, 100), SearchParameters(), part=part))
    assert with_display.total("lut4") > large.total("lut4")
    assert with_display.total("block_rams") == large.total("block_rams")
    copied = MACHINE.demand(Job(empty(100, 100), SearchParameters(display=VgaController.COPY), part=part))
    # A copy of the cells and one of the directions: the screen shows both.
    assert copied.total("block_rams") == large.total("block_rams") + 4


def test_linear_addresses_take_fewer_memories_over_a_power_of_two(part: Part) -> None:
    totals = [resources.block_ram_total(130, 130, SearchParameters(address=address), part) for address in Address]
    assert totals == [80, 38]
    beside, after = (timing.init_cycles((130, 130), SearchParameters(address=address)) for address in Address)
    assert after - beside == 129


def test_a_map_larger_than_the_part_says_what_would_mend_it(part: Part) -> None:
    demand = MACHINE.demand(Job(empty(300, 300), SearchParameters(), part=part))
    budget = part.resources["block_rams"].value
    assert demand.total("block_rams") > budget
    levers = {lever.parameter: lever.advice for lever in reversed(demand.levers["block_rams"])}
    assert levers["problem.map"].startswith("at most 256 × 256")
    assert levers["search.memory"] == "process_external: 32 block RAMs"
    # 32 for the cells, 32 for the directions: 72 are left, and 65,536 words of 18 bits take 64.
    assert levers["search.queue_words"].startswith("at most 65,536 words")
    mended = SearchParameters(queue_words=65_536)
    assert MACHINE.demand(Job(empty(300, 300), mended, part=part)).total("block_rams") <= budget
    assert MACHINE.demand(Job(empty(256, 256), SearchParameters(), part=part)).levers == {}


def test_a_queue_too_short_is_refused_with_the_words_it_needs(part: Part, problem: Problem) -> None:
    depth = PLANNER.plan(Job(problem, SearchParameters())).queue_depth
    short = bound(
        MACHINE.demand(Job(problem, SearchParameters(queue_words=depth - 1), part=part)), "words of the queue"
    )
    assert short.figure.value > short.limit
    assert f"at least {depth}" in short.levers[0].advice
    enough = bound(MACHINE.demand(Job(problem, SearchParameters(queue_words=depth), part=part)), "words of the queue")
    assert enough.figure.value <= enough.limit


@pytest.mark.parametrize(
    ("micro_architecture", "display", "fits"),
    [
        ("three_cycles", "shared", True),
        ("two_cycles", "shared", True),
        ("pipelined", "shared", False),
        ("pipelined", "copy", True),
        ("pipelined", "none", True),
    ],
)
def test_two_ports_are_shared(part: Part, problem: Problem, micro_architecture: str, display: str, fits: bool) -> None:
    parameters = SearchParameters(micro_architecture=micro_architecture, display=display)  # type: ignore[arg-type]
    ports = bound(MACHINE.demand(Job(problem, parameters, part=part)), "ports of the cells' block RAM")
    assert (ports.figure.value <= ports.limit) == fits
    # A display is a component of its own: its address is in the bound, not in the steps.
    most = max(step.ram_addresses for step in drained(MACHINE.work(Job(problem, parameters)))[1])
    assert most + (display == "shared") == ports.figure.value


def test_a_display_cannot_share_an_external_memory(part: Part, problem: Problem) -> None:
    ports = bound(
        MACHINE.demand(Job(problem, SearchParameters(memory=MemoryPlace.EXTERNAL), part=part)),
        "ports of the cells' block RAM",
    )
    assert ports.figure.value > ports.limit
    assert [lever.parameter for lever in ports.levers] == ["search.display", "search.memory"]


def test_a_map_larger_than_the_screen(part: Part) -> None:
    demand = MACHINE.demand(Job(empty(601, 401), SearchParameters(memory=MemoryPlace.PROCESS_EXTERNAL), part=part))
    for name in ("rows on the screen", "columns on the screen"):
        assert bound(demand, name).figure.value > bound(demand, name).limit
    alone = SearchParameters(memory=MemoryPlace.EXTERNAL, display=VgaController.NONE)
    assert MACHINE.demand(Job(empty(601, 401), alone, part=part)).bounds == ()
    assert MACHINE.memory(Job(empty(601, 401), alone)) is None


def test_clock_is_the_published_one_or_that_of_the_block_ram(part: Part, problem: Problem) -> None:
    limit = MACHINE.clock_limit(Job(problem, SearchParameters(), part=part))
    assert (limit.value, limit.status) == (185e6, Status.PUBLISHED)
    slow = part.model_copy(update={"block_ram_clock": load_part("XC3S500E-4").block_ram_clock})
    assert MACHINE.clock_limit(Job(problem, SearchParameters(), part=slow)).status is Status.PUBLISHED
    other = MACHINE.clock_limit(Job(problem, SearchParameters(), part=load_part("XC3S500E-4")))
    assert (other.value, other.status) == (185e6, Status.ASSUMED)


def test_power_grows_with_clock_and_memory(part: Part) -> None:
    small, large = (MACHINE.demand(Job(empty(side, side), SearchParameters(), part=part)) for side in (30, 100))
    static, dynamic = MACHINE.power(large, 120_000_000, part)
    assert static == part.static_power
    assert MACHINE.power(large, 240_000_000, part)[1].value == pytest.approx(2 * dynamic.value)
    assert MACHINE.power(small, 120_000_000, part)[1].value < dynamic.value
    assert dynamic.interval[0] < dynamic.value < dynamic.interval[1]


def test_software_counts_popped_cells(problem: Problem) -> None:
    popped = PLANNER.plan(Job(problem, SearchParameters())).popped_cells
    for style, kernel in (("software", "breadth_first_cell"), ("software_java", "breadth_first_java_cell")):
        phases, _, _ = drained(BY_STYLE[style].work(Job(problem, SearchParameters())))
        walls = wall_cells(problem.free, PLANNER.plan(Job(problem, SearchParameters())))
        expected = popped + (walls if style == "software" else 0)
        assert phases == {"init": problem.free.size, "bf": expected}
        assert BY_STYLE[style].kernel == kernel


def test_java_meets_its_wall_between_100_and_200() -> None:
    assert heap_bound(100 * 100).figure.value <= JAVA_HEAP < heap_bound(200 * 200).figure.value
    assert pytest.approx(1677.7, abs=0.1) == JAVA_BYTES_A_CELL_LOW
    assert pytest.approx(6710.9, abs=0.1) == JAVA_BYTES_A_CELL_HIGH
    java, compiled = BY_STYLE["software_java"], BY_STYLE["software"]
    wall = java.demand(Job(empty(200, 200), SearchParameters(), part=None)).bounds  # type: ignore[arg-type]
    assert [bound.name for bound in wall] == ["heap of the Java program"]
    assert compiled.demand(Job(empty(200, 200), SearchParameters(), part=None)).bounds == ()  # type: ignore[arg-type]


@pytest.mark.parametrize("style", ["software", "software_java"])
def test_software_has_no_law_of_clock_or_power(problem: Problem, style: str, part: Part) -> None:
    with pytest.raises(InputError):
        BY_STYLE[style].clock_limit(Job(problem, SearchParameters(), part=part))
    with pytest.raises(InputError):
        BY_STYLE[style].power(Demand(()), 1, part)


def test_address_bits_of_odd_sizes() -> None:
    assert resources.address_bits(1, 1) == 2
    assert resources.address_bits(33, 64) == 12


PARTS_OF_ROWS = {
    "xc2v": "XC2V6000-4",
    "xc2vp": "XC2VP30-6",
    "xc3se": "XC3S500E-4",
    "xc4v": "XC4VLX160-10",
    "xc7": "XC7Z020-1",
    "ecp5": "LFE5U-85F-8",
    "gowin": "GW2A-18-7",
}
ROWS = resource_rows("breadth_first", "state_machine")
RESOURCES = "block_rams", "lut4", "flip_flops"


def of_row(row: ResourceRow) -> SearchParameters:
    cycles = {each: micro for micro, each in timing.EXPANSION_CYCLES.items()}
    return SearchParameters(
        micro_architecture=cycles[row.variables["CYCLES"]],
        address=list(Address)[row.variables["LINEAR"]],
        display=list(VgaController)[row.variables.get("SHOWN", 0)],
        queue_words=row.variables["QUEUE_WORDS"],
    )


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.family}-{row.digest[:6]}")
def test_demand_is_what_synthesis_counts(row: ResourceRow) -> None:
    shape = row.variables["ROWS"], row.variables["COLUMNS"]
    demand = MACHINE.demand(Job(empty(*shape), of_row(row), part=load_part(PARTS_OF_ROWS[row.family])))
    counts = {resource: sum(row.count(piece, resource) for piece in row.pieces) for resource in RESOURCES}
    assert demand.total("block_rams") == counts["block_rams"]
    assert demand.total("lut4") == pytest.approx(counts["lut4"], rel=0.1)
    assert demand.total("flip_flops") == pytest.approx(counts["flip_flops"], rel=0.1)


@pytest.mark.parametrize("family", sorted({row.family for row in ROWS}))
def test_sizes_held_out_are_met(family: str) -> None:
    for piece in ("state machine", "display"):
        for resource in ("lut4", "flip_flops"):
            line = resources.LAWS.fit(piece, resource, ROWS[0].variables, family)
            assert line.held_out
            assert line.mean < 0.05
            assert line.worst < 0.1
