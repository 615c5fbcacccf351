"""Laws of the wavefront styles: against the clocked circuits, the paper's figures, and the four parts."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign import maps
from codesign.ground.errors import InputError
from codesign.ground.memo import Memo
from codesign.ground.records import TaskRecord
from codesign.inputs import load_platform
from codesign.inputs.library import load_part
from codesign.planners.breadth_first.styles.resources import block_rams
from codesign.planners.interface import Problem
from codesign.planners.job import Demand, Job
from codesign.planners.measured import ResourceRow, resource_rows
from codesign.planners.styles import Architecture, Step
from codesign.planners.wavefront import published
from codesign.planners.wavefront.paper import measures as reference
from codesign.planners.wavefront.paper.measures import PAPER
from codesign.planners.wavefront.plan import longest_distance, register_bits
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.plan.planner import PLANNER
from codesign.planners.wavefront.styles import ARCHITECTURES, AdderComparator, DelayLine, Software, Tiled, resources
from codesign.planners.wavefront.styles.resources import ArrayLayout
from codesign.planners.wavefront.styles.software import SEED_CELLS
from codesign.planners.wavefront.styles.tile import PIECES, TileLayout, lut4

PARTS = {"XC4VLX160-12": 91, "XC2V6000-4": 64, "XC2VP30-6": 41, "XC3S500E-4": 23}


def rooms(side: int = 40, starts: tuple[tuple[int, int], ...] | None = None) -> Problem:
    free = maps.rooms(side, side, room=(9, 9), door=2, seed=1).free
    end = maps.nearest_free(free, (side - 1, side - 1))
    assert end is not None
    return Problem(free, ((0, 0),), (end,) if starts is None else starts)


def run(
    style: Architecture, problem: Problem, detail: bool = True, **raw: Any
) -> tuple[dict[str, int], list[Step], Any]:
    steps = []
    work = style.work(Job(problem, PropagateParameters(**raw), detail=detail))
    while True:
        try:
            steps.append(next(work))
        except StopIteration as done:
            phases: dict[str, int] = {}
            for step in steps:
                phases[step.phase] = phases.get(step.phase, 0) + int(step.cycles.sum())
            return phases, steps, done.value


@given(st.integers(0, 10**6), st.floats(0, 0.45))
@settings(max_examples=40)
def test_cycles_are_those_of_the_clocked_circuits(seed: int, density: float) -> None:
    rng = np.random.default_rng(seed)
    free = rng.random((11, 14)) >= density
    free[0, 0] = True
    reached = np.argwhere(reference.dijkstra(free, [(0, 0)]) >= 0)
    start = tuple(int(part) for part in reached[rng.integers(len(reached))])
    problem = Problem(free, ((0, 0),), (start,))
    _, line_cycles = reference.delay_line_circuit(free, [(0, 0)], start)
    _, adder_cycles, _ = reference.adder_circuit(free, [(0, 0)])
    assert run(DelayLine(), problem)[0]["propagate"] == line_cycles
    # Before the updates a cycle sets sources to 0 and all others to infinity.
    assert run(AdderComparator(), problem)[0]["propagate"] == adder_cycles + 1
    if not free.all():
        obstacles = [tuple(cell) for cell in np.argwhere(~free).tolist()]
        _, obstacle_cycles, _ = reference.adder_circuit(np.ones_like(free), obstacles)
        assert run(AdderComparator(), problem, paths="safe")[0]["propagate_obstacles"] == obstacle_cycles + 1


def test_the_paper_s_cycles_and_times() -> None:
    empty = Problem(np.ones((256, 256), bool), ((0, 0),), ((255, 255),))
    phases = run(DelayLine(), empty, paths="safe")[0]
    assert phases["propagate"] == 3 * 255 + 1
    # The paper says 768: three cycles for each of 256 nodes, where the diagonal has 255 steps.
    assert phases["propagate_obstacles"] == 766
    shortest, safe = (PAPER.sheet.published(place) for place in ("Shortest Paths", "Safe Paths"))
    waves = (shortest["time at 20 MHz"], shortest["cycle of the stop"])
    clear = (safe["time of the obstacle map at 20 MHz"], safe["cycles of the obstacle map"])
    assert pytest.approx(waves[0], rel=0.005) == waves[1] / published.CLOCK
    assert pytest.approx(clear[0], rel=0.02) == clear[1] / published.CLOCK


def measured_rows() -> list[ResourceRow]:
    return [row for style in ("delay_line", "adder_comparator") for row in resource_rows("wavefront", style)]


def test_flip_flops_and_memories_of_every_synthesis_are_exact() -> None:
    part = load_part("XC4VLX160-12")
    for row in measured_rows():
        layout = ArrayLayout.of_row(row.variables)
        for piece in (resources.NODES, resources.TRACKER, resources.CONTROL):
            assert resources.flip_flops(piece, layout) == row.count(piece, "flip_flops"), (piece, layout)
        sets, shapes = layout.memories
        rams = sets * sum(block_rams(words, width, part) for words, width in shapes)
        assert rams == row.count(resources.MEMORIES, "block_rams"), layout


def test_flip_flops_and_memories_of_every_tiled_array_are_exact() -> None:
    part = load_part("XC4VLX160-12")
    for row in resource_rows("wavefront", "tiled"):
        layout = TileLayout.of_row(row.variables)
        flip_flops, rams = layout.flip_flops(row.family), layout.rams(part)
        for piece in PIECES:
            if piece != resources.TRACKER or layout.array.tracked:
                assert flip_flops.get(piece, 0) == row.count(piece, "flip_flops"), (piece, layout)
            assert rams.get(piece, 0) == row.count(piece, "block_rams"), (piece, layout)


def test_luts_of_tiled_arrays_that_were_held_out_are_predicted() -> None:
    errors: dict[str, list[float]] = {}
    for row in resource_rows("wavefront", "tiled"):
        if resources.LAWS.held_out(row.variables):
            luts = lut4(TileLayout.of_row(row.variables), (row.family, True))
            law = sum(line.amount for line in luts.values())
            counted = sum(row.count(piece, "lut4") for piece in PIECES)
            errors.setdefault(row.family, []).append(abs(law / counted - 1))
    assert errors
    for family, values in errors.items():
        assert max(values) < 0.10, family
        assert sum(values) / len(values) < 0.05, family


def test_luts_of_arrays_that_were_held_out_are_predicted() -> None:
    errors: dict[str, list[float]] = {}
    for row in measured_rows():
        if not resources.LAWS.held_out(row.variables):
            continue
        layout = ArrayLayout.of_row(row.variables)
        pieces = (resources.NODES, resources.READ_OUT, resources.TRACKER, resources.CONTROL)
        counted = sum(row.count(piece, "lut4") for piece in pieces)
        law = sum(resources.lut4(piece, layout, row.family) for piece in pieces)
        errors.setdefault(row.family, []).append(abs(law / counted - 1))
    assert errors
    for family, values in errors.items():
        assert max(values) < 0.10, family
        assert sum(values) / len(values) < 0.05, family


def test_a_node_saves_luts_and_no_flip_flops() -> None:
    line = ArrayLayout((256, 256), register_bits(published.STOP_POTENTIAL))
    adders = replace(line, adders=True)
    assert line.bits == 11
    # Figure 2 names three flip-flops, F and the register; Z is one more.
    assert line.node_flip_flops == 3 + 1 + 11 + 1
    assert adders.node_flip_flops == 13
    few, many = (resources.lut4(resources.NODES, each, "ecp5") / each.nodes for each in (line, adders))
    assert few == 5
    assert many / few == pytest.approx(59, rel=0.05)


@pytest.mark.parametrize(("name", "side"), PARTS.items())
def test_largest_arrays_of_the_four_parts(name: str, side: int) -> None:
    part = load_part(name)

    def short(length: int) -> set[str]:
        problem = Problem(np.ones((length, length), bool), ((0, 0),), ((length - 1, length - 1),))
        demand = DelayLine().demand(Job(problem, PropagateParameters(register_bits=11), part=part))
        return {kind for kind, budget in part.resources.items() if demand.total(kind) > budget.value}

    assert not short(side)
    assert "slices" in short(side + 1)


@pytest.mark.parametrize("style", [DelayLine(), AdderComparator(), Tiled()])
def test_a_register_that_is_too_narrow_says_how_many_bits(style: Architecture) -> None:
    problem, part = rooms(), load_part("XC4VLX160-12")
    largest = style.largest_potential(Job(problem, PropagateParameters()))  # type: ignore[attr-defined]
    needed = register_bits(largest)
    for bits in (needed - 1, needed, needed + 3):
        (bound,) = style.demand(Job(problem, PropagateParameters(register_bits=bits), part=part)).bounds
        assert (bound.figure.value, bound.limit) == (needed, bits)
        texts = [lever.advice for lever in bound.levers]
        assert any(f"at least {needed} bits" in text for text in texts) == (bits < needed)


@pytest.mark.parametrize("name", PARTS)
@pytest.mark.parametrize("paths", ["shortest", "safe"])
def test_the_tile_that_a_lever_names_fits(name: str, paths: str) -> None:
    problem, part = rooms(128), load_part(name)
    demand = DelayLine().demand(Job(problem, PropagateParameters(paths=paths), part=part))
    levers = {lever.parameter: lever.advice for lever in demand.levers["slices"]}
    bits = DelayLine().bits(Job(problem, PropagateParameters(paths=paths)))

    def tiled(side: int) -> Demand:
        raw = PropagateParameters(paths=paths, tile=(side, side), register_bits=bits)
        return Tiled().demand(Job(problem, raw, part=part))

    if (name, paths) == ("XC3S500E-4", "safe"):
        # Two potentials for each of 16,384 cells are 32 block RAMs; the part has 20.
        assert "no tile fits" in levers["propagate.style"]
        assert all(tiled(side).levers["block_rams"] for side in (8, 16, 20))
        return
    side = int(levers["propagate.tile"].split("[")[1].split(",")[0])
    assert all(tiled(side).total(kind) <= budget.value for kind, budget in part.resources.items())
    assert not tiled(side).levers
    assert tiled(side + 1).levers


def test_only_a_chip_made_for_it_holds_256_nodes_a_side() -> None:
    problem = rooms(256)
    chip = load_part("WAVE256-20")
    assert not DelayLine().demand(Job(problem, PropagateParameters(register_bits=11), part=chip)).levers
    assert AdderComparator().demand(Job(problem, PropagateParameters(register_bits=11), part=chip)).levers["slices"]
    for name in PARTS:
        assert DelayLine().demand(Job(problem, PropagateParameters(), part=load_part(name))).levers["slices"]


@pytest.mark.parametrize("style", ARCHITECTURES, ids=lambda style: style.style)
@pytest.mark.parametrize(
    "raw",
    [
        {},
        {"paths": "safe", "course": "complete", "tile": (13, 16)},
        {"stop": "whole_map", "tile": (8, 40), "delays": (5, 7), "penalty": {"distance": 2, "delay": 3}},
        {"corner_cutting": False, "steps": 4, "tile": (9, 9)},
    ],
)
def test_coarse_steps_cost_the_same_and_end_in_the_plan(style: Architecture, raw: dict[str, Any]) -> None:
    problem = rooms()
    fine, steps, plan = run(style, problem, detail=True, **raw)
    coarse, few, same = run(style, problem, detail=False, **raw)
    assert fine == coarse
    assert len(few) <= len(steps)
    expected = PLANNER.plan(Job(problem, style.settled(PropagateParameters(**raw))))
    assert PLANNER.identity(plan) == PLANNER.identity(same) == PLANNER.identity(expected)
    for step in steps:
        record = step.record(10, 20, "fpga")
        assert isinstance(record, TaskRecord)
        assert (record.task, record.cycles) == (step.phase, int(step.cycles.sum()))


def test_a_wave_without_stop_runs_until_no_node_waits_for_it() -> None:
    problem = rooms(starts=())
    # The tree that detects silence ends the wave: the width of the counter does not matter.
    for bits in (None, 9, 12):
        phases, _, plan = run(DelayLine(), problem, stop="whole_map", register_bits=bits)
        assert phases["propagate"] == plan.largest_potential + 1


def test_a_chain_is_read_out_after_every_wave() -> None:
    problem = rooms()
    for style in (DelayLine(), AdderComparator()):
        addressed, chain = (run(style, problem, paths="safe", read_out=each)[0] for each in ("addressed", "chain"))
        assert chain.pop("read_out") == 2 * problem.free.size
        assert chain == addressed
    tiled = run(Tiled(), problem, read_out="chain")[0]
    assert tiled == run(Tiled(), problem)[0]


def test_shared_elements_change_cycles_and_no_bit() -> None:
    problem = rooms()
    whole, _, plan = run(DelayLine(), problem, paths="safe")
    shared, _, same = run(DelayLine(), problem, paths="safe", element_cells=8)
    assert PLANNER.identity(plan) == PLANNER.identity(same)
    for phase in ("propagate", "propagate_obstacles"):
        assert shared[phase] == 8 * whole[phase]
    assert (whole["load"], shared["load"]) == (1 + 1600 // 32, 1 + 8 * math.ceil(200 / 32) + 1)
    assert whole["track"] == shared["track"] == 2 + 10


def test_tiles_pay_for_their_exchange() -> None:
    problem = rooms(64)
    whole = run(DelayLine(), problem)[0]
    costs = {side: run(Tiled(), problem, tile=(side, side))[0] for side in (8, 16, 32, 64)}
    for side, phases in costs.items():
        # A level of comparators for each power of two of columns, the tiles, three stages; rows and those around, twice
        # in and once out.
        scan = int(math.log2(side)) + (64 // side) ** 2 + 3
        visits, rest = divmod(phases["exchange"] - scan, 3 * side + 7 + scan)
        assert rest == 0
        assert visits >= (1 if side == 64 else 2)
        assert phases["propagate"] >= whole["propagate"] - 1
    totals = [sum(phases.values()) for phases in costs.values()]
    assert totals == sorted(totals, reverse=True)


@pytest.mark.parametrize(("side", "paths"), list(product((8, 16, 31), ("shortest", "safe"))))
def test_words_of_a_column_memory_fit_its_block_rams(side: int, paths: str) -> None:
    problem, raw = rooms(256), {"tile": (side, side), "paths": paths, "register_bits": 11}
    part = load_part("XC4VLX160-12")
    memory = Tiled().memory(Job(problem, PropagateParameters(**raw)))
    assert memory.width == 12
    assert sum(memory.words.values()) <= 1024
    items = Tiled().demand(Job(problem, PropagateParameters(**raw), part=part)).items
    (rams,) = [item.amount for item in items if (item.name, item.resource) == ("column memories", "block_rams")]
    words = math.ceil(256 / side) ** 2 * side
    # p^d of safe paths is in memories of its own.
    assert rams == side * block_rams(words, 12, part) * (2 if paths == "safe" else 1)
    assert DelayLine().memory(Job(problem, PropagateParameters(**raw))) is None


def test_software_pays_for_the_nodes_that_the_wave_reaches() -> None:
    problem = rooms()
    phases, _, plan = run(Software(), problem, paths="safe", course="complete")
    obstacles, away = int((~problem.free).sum()), plan.obstacle_potentials.max() + 1
    assert phases["propagate"] == int((plan.potentials >= 0).sum()) + 1600 + plan.largest_potential + 1
    assert phases["propagate_obstacles"] == 2 * 1600 + SEED_CELLS * obstacles + away
    assert phases["track"] == len(plan.tracker.follow(problem.starts[0])) - 1 + 1600
    with pytest.raises(InputError):
        Software().clock_limit(Job(problem, PropagateParameters()))
    with pytest.raises(InputError):
        Software().power(Software().demand(Job(problem, PropagateParameters())), 1, load_part("XC2V6000-4"))


def test_the_adder_array_has_the_slower_clock() -> None:
    problem, part = rooms(), load_part("XC2V6000-4")
    line = DelayLine().clock_limit(Job(problem, PropagateParameters(), part=part))
    adder = AdderComparator().clock_limit(Job(problem, PropagateParameters(), part=part))
    assert adder.value < line.value
    for figure in (line, adder):
        assert figure.interval[0] <= figure.value <= figure.interval[1]
        assert figure.status == "assumed"


def test_safe_paths_and_longer_lines_are_paid_for() -> None:
    problem, part = rooms(), load_part("XC4VLX160-12")

    def flip_flops(**raw: Any) -> int:
        return (
            DelayLine().demand(Job(problem, PropagateParameters(register_bits=9, **raw), part=part)).total("flip_flops")
        )

    # The tracker and the word of the read-out have p^d too, and P: of two cells, and in the word.
    second = register_bits(longest_distance((40, 40)))
    assert flip_flops(paths="safe") - flip_flops() == 1600 * second + 2 * second
    assert flip_flops(delays=(5, 7)) - flip_flops() == 1600 * 4
    assert flip_flops(penalty={"distance": 2, "delay": 3}) - flip_flops() == 1600 * 4 + 3


def test_power_goes_with_slices_and_clock() -> None:
    problem, part = rooms(), load_part("XC4VLX160-12")
    demand = DelayLine().demand(Job(problem, PropagateParameters(), part=part))
    static, slow = DelayLine().power(demand, 20_000_000, part)
    _, fast = DelayLine().power(demand, 40_000_000, part)
    assert static == part.static_power
    assert fast.value == pytest.approx(2 * slow.value)
    assert slow.interval[0] < slow.value < slow.interval[1]


def test_design_points_share_their_waves() -> None:
    memo = Memo()
    problem = rooms()
    for tile in ((8, 8), (16, 16)):
        list(Tiled().work(Job(problem, PropagateParameters(tile=tile), memo=memo, detail=False)))
    assert memo.misses == 1  # the plan; the process keeps the visits of each tile
    list(Tiled().work(Job(problem, PropagateParameters(tile=(8, 8), register_bits=12), memo=memo, detail=False)))
    assert memo.misses == 1


def test_the_platform_s_pentium_is_the_fitted_one() -> None:
    from codesign.planners.wavefront.paper.measures import SAMPLES, make_sample, unit_seconds

    samples = tuple(make_sample(name) for name in SAMPLES)
    cost = load_platform("wavefront-array").components["host"].costs["wavefront_cell"]
    assert cost.value / 1e12 == pytest.approx(unit_seconds(samples), rel=1e-3)
    least = published.SOFTWARE_SECONDS / min(one.reached for one in samples)
    assert cost.interval[0] / 1e12 < published.SOFTWARE_SECONDS / 256**2
    assert cost.interval[1] / 1e12 >= least
