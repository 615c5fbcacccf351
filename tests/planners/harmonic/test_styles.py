"""Laws of harmonic control: exact on the published tables, monotone, and with levers that really mend what is short."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.ground.errors import InputError
from codesign.ground.figures import RESOURCES, Figure, Status
from codesign.ground.models import Part
from codesign.planners.counted import counted_activity
from codesign.planners.harmonic import published
from codesign.planners.harmonic.plan.parameters import MAX_PRECISION, RelaxParameters
from codesign.planners.harmonic.styles import ARCHITECTURES, resources, timing
from codesign.planners.harmonic.styles.designs import block_designs
from codesign.planners.harmonic.styles.resources import Machine
from codesign.planners.interface import Problem
from codesign.planners.job import Job

BIT_SERIAL, SOFTWARE, SOFTWARE_LIMBS = ARCHITECTURES

BUDGETS = {"XC2V6000": (33_792, 67_584, 144), "XC4VLX160": (67_584, 135_168, 288), "XC3S500E": (4_656, 9_312, 20)}


def part(name: str, ram_clock: float = 500e6) -> Part:
    slices, cells, rams = BUDGETS[name]
    budget = {"slices": slices, "lut4": cells, "flip_flops": cells, "block_rams": rams, "multipliers": 20}
    return Part(
        name=name,
        family="Virtex-II",
        speed_grade="-4",
        resources={kind: Figure(count, "1", Status.PUBLISHED, "datasheet") for kind, count in budget.items()},
        block_ram_shapes=((2048, 9), (1024, 18), (512, 36)),
        block_ram_clock=Figure(ram_clock, "Hz", Status.PUBLISHED, "datasheet"),
        static_power=Figure(1.0, "W", Status.ASSUMED, "guess", 0.5, 2.0),
        dynamic_power=Figure(1.5e-12, "W", Status.ASSUMED, "guess", 1e-12, 3e-12),
    )


def problem(rows: int, columns: int) -> Problem:
    return Problem(np.ones((rows, columns), np.bool_), ((0, 0),), ((1, 1),))


def parameters(block: tuple[int, int], last: int) -> RelaxParameters:
    return RelaxParameters(block=block, iterations=6, schedule=(last,))


sides = st.integers(1, 120)
precisions = st.integers(1, 1023)
families = st.sampled_from(["Virtex-II", "ECP5", "GW2A"])


def test_node_array_is_exact_on_tables_1_and_3_and_within_half_a_percent_on_table_2() -> None:
    for table in (published.NODE, published.CLUSTER):
        assert resources.NODE_FLIP_FLOPS * table.nodes == table.flip_flops
        assert resources.NODE_LUT4 * table.nodes == pytest.approx(table.lut4, rel=0.006)
        assert resources.NODE_SLICES * table.nodes == pytest.approx(table.slices, rel=0.005)
    demand = BIT_SERIAL.demand(Job(problem(96, 192), parameters((48, 96), 63), part=part("XC4VLX160")))
    array = {
        kind: sum(
            item.amount for item in demand.items if item.resource == kind and item.name in {"nodes", "array control"}
        )
        for kind in ("slices", "lut4", "flip_flops")
    }
    assert array == {"slices": 59_914, "lut4": 101_396, "flip_flops": 50_699}


def test_whole_design_of_section_5_4() -> None:
    demand = BIT_SERIAL.demand(Job(problem(72, 132), parameters((36, 66), 255), part=part("XC2V6000")))
    assert demand.total("block_rams") == 132 + 12
    assert demand.total("slices") / 33_792 == pytest.approx(0.994, abs=0.0005)
    assert {item.name: item.amount for item in demand.items if item.resource == "slices"}["decision"] == 3 * 255 + 682
    assert not demand.levers
    (depth,) = demand.bounds
    assert (depth.figure.value, depth.limit) == (1024, 1024)


@pytest.mark.parametrize(("last", "fits"), [(63, True), (64, False)])
def test_sixteen_blocks_hold_63_bits_and_a_flag_but_not_64(last: int, fits: bool) -> None:
    demand = BIT_SERIAL.demand(Job(problem(192, 384), parameters((48, 96), last), part=part("XC4VLX160")))
    (depth,) = demand.bounds
    assert (depth.figure.value <= depth.limit) is fits
    assert demand.total("slices") <= 67_584


def test_largest_published_block_misses_the_largest_virtex_4_by_six_block_rams() -> None:
    assert resources.totals(Machine(54, 108, 100), "Virtex-4")["block_rams"] == 342


@given(
    rows=sides,
    columns=sides,
    last=precisions,
    more=st.integers(1, 40),
    which=st.integers(0, 2),
    family=st.sampled_from(["Virtex-II", "ECP5", "GW2A"]),
)
def test_demand_never_falls_as_block_or_precision_grows(
    rows: int, columns: int, last: int, more: int, which: int, family: str
) -> None:
    grown = (rows + more * (which == 0), columns + more * (which == 1), last + more * (which == 2))
    small, large = (resources.totals(Machine(*each), family) for each in ((rows, columns, last), grown))
    assert small.keys() == large.keys() <= set(RESOURCES)
    assert all(large[kind] >= small[kind] for kind in small)


def test_a_decision_made_elsewhere_leaves_its_slices_to_the_block() -> None:
    chip, apart = part("XC3S500E"), frozenset({"relax", "detect"})
    task, chosen = problem(30, 30), parameters((15, 15), 255)
    whole = BIT_SERIAL.demand(Job(task, chosen, part=chip))
    left = BIT_SERIAL.demand(Job(task, chosen, part=chip, inside=apart))
    assert whole.total("slices") - left.total("slices") == 3 * 255 + 682
    assert whole.total("slices") > chip.resources["slices"].value >= left.total("slices")
    (advice,) = [lever.advice for lever in whole.levers["slices"] if lever.parameter == "decide.component"]
    assert advice == "another component: 1,447 slices of the decision module are spared"
    assert left.levers == {}
    # Without it a larger block fits, and the levers count on that.
    sides_of = {}
    for name, inside in (("whole", None), ("left", apart)):
        demand = BIT_SERIAL.demand(Job(problem(60, 60), parameters((60, 60), 255), part=chip, inside=inside))
        advice = {lever.parameter: lever.advice for lever in demand.levers["slices"]}
        assert not {"decide.component", "relax.schedule"} & set(advice)
        sides_of[name] = re.match(r"at most (\d+) × \d+", advice["relax.block"])[1]  # type: ignore[index]
    assert sides_of == {"whole": "13", "left": "15"}


@given(rows=sides, columns=sides)
def test_every_node_and_border_node_has_a_place_in_some_block_ram(rows: int, columns: int) -> None:
    assert resources.cluster_count(rows, columns) * resources.RAM_WIDTH >= rows * columns
    assert resources.border_rams(rows, columns) * resources.RAM_WIDTH >= resources.border_nodes(rows, columns)


@given(blocks=st.integers(1, 1024), last=precisions)
def test_largest_precision_is_the_edge_of_the_word_depth(blocks: int, last: int) -> None:
    edge = resources.largest_precision(blocks, 1024)
    assert (resources.words(blocks, last) <= 1024) is (last <= edge)


@given(blocks=st.integers(1, 1024), digit_bits=st.sampled_from([1, 2, 4, 8]))
def test_a_precision_that_fits_is_one_that_a_plan_can_have(blocks: int, digit_bits: int) -> None:
    last = resources.largest_precision(blocks, 1024, digit_bits)
    if last >= 1:
        RelaxParameters(blocks=(1, 1), iterations=6, schedule=(last,), digit_bits=digit_bits)
        assert resources.words(blocks, last, digit_bits) <= 1024
        assert last == MAX_PRECISION or resources.words(blocks, last + 1, digit_bits) > 1024


def test_a_lever_with_digits_names_no_precision_beyond_1023() -> None:
    chosen = RelaxParameters(block=(30, 30), iterations=6, schedule=(63,), digit_bits=8)
    demand = BIT_SERIAL.demand(Job(problem(30, 30), chosen, part=part("XC2V6000")))
    advice = " ".join(lever.advice for remedies in demand.levers.values() for lever in remedies)
    named = [int(number) for number in re.findall(r"precision up to (\d+)", advice)]
    assert named
    assert max(named) <= MAX_PRECISION


@pytest.mark.parametrize("stages", [1, 4])
def test_designs_that_are_worth_a_try_fit_their_part(stages: int) -> None:
    """A part that is full with one stage of the precision has no room for the schedule that leads to it."""
    chip = part("XC3S500E").model_copy(update={"family": "ECP5"})
    full = resources.totals(Machine(12, 12, 63, down=1, across=1, stages=stages), "ECP5")
    budget = {kind: replace(chip.resources[kind], value=amount) for kind, amount in full.items()}
    chip = chip.model_copy(update={"resources": budget})
    chains = block_designs((12, 12), chip, decision=True)
    designs = [RelaxParameters.model_validate(design) for chain in chains for design in chain]
    whole = [design.precisions for design in designs if design.block == (12, 12)]
    assert ((15, 31, 47, 63) in whole) is (stages == 4)
    assert all(BIT_SERIAL.demand(Job(problem(12, 12), each, part=chip)).levers == {} for each in designs)


def test_a_part_without_wide_block_ram_holds_no_word() -> None:
    narrow = part("XC2V6000").model_copy(update={"block_ram_shapes": ((2048, 9),)})
    (depth,) = BIT_SERIAL.demand(Job(problem(36, 66), parameters((36, 66), 7), part=narrow)).bounds
    assert depth.limit == 0
    assert depth.figure.value == 8


@settings(max_examples=60)
@given(name=st.sampled_from(sorted(BUDGETS)), rows=sides, columns=sides, last=precisions, map_scale=st.integers(1, 4))
def test_levers_mend_what_they_say(name: str, rows: int, columns: int, last: int, map_scale: int) -> None:
    chip = part(name)
    shape = rows * map_scale, columns * map_scale
    demand = BIT_SERIAL.demand(Job(problem(*shape), parameters((rows, columns), last), part=chip))
    short = {kind for kind in RESOURCES if demand.total(kind) > chip.resources[kind].value}
    assert set(demand.levers) == short
    for kind, remedies in demand.levers.items():
        for lever in remedies:
            if match := re.match(r"at most (\d+) × (\d+)", lever.advice):
                assert resources.fits(Machine(int(match[1]), int(match[2]), last), chip)
            if match := re.match(r"end at (\d+) bits", lever.advice):
                assert (
                    resources.totals(Machine(rows, columns, int(match[1])), chip.family)[kind]
                    <= chip.resources[kind].value
                )
                assert (
                    resources.totals(Machine(rows, columns, int(match[1]) + 1), chip.family)[kind]
                    > chip.resources[kind].value
                )
    (depth,) = demand.bounds
    for lever in depth.levers:
        assert depth.figure.value > depth.limit
        if match := re.match(r"end at (\d+) bits", lever.advice):
            assert resources.words(map_scale**2, int(match[1])) <= depth.limit
        if match := re.match(r"(\d+) × (\d+)", lever.advice):
            block = int(match[1]), int(match[2])
            assert block[0] <= shape[0]
            assert block[1] <= shape[1]
            assert resources.fits(Machine(*block, last), chip)
            allowed = re.search(r"precision up to (\d+)", lever.advice)
            held = int(allowed[1]) if allowed else last
            assert resources.words(resources.block_count(shape, block), held) <= depth.limit


@given(rows=sides, columns=sides, last=precisions, name=st.sampled_from(sorted(BUDGETS)))
def test_no_larger_block_of_the_same_proportions_fits(rows: int, columns: int, last: int, name: str) -> None:
    chip = part(name)
    largest = resources.largest_block(Machine(rows, columns, last), chip)
    taller = 1 if largest is None else largest[0] + 1
    if taller <= rows:
        assert not resources.fits(Machine(taller, max(1, taller * columns // rows), last), chip)


def test_published_clocks_are_met_and_the_held_out_one_lies_in_the_interval() -> None:
    fit = timing.clock_fit()
    assert fit.form == "N^(1/4)"
    for point in timing.POINTS:
        assert fit.clock(point.nodes) == pytest.approx(point.clock, rel=0.002)
    limit = timing.clock_limit(36, 66, part("XC2V6000"))
    low, high = limit.interval
    assert low < published.ESTIMATED_CLOCK < high
    assert timing.clock_miss() == pytest.approx(0.113, abs=0.001)
    assert limit.status is Status.CALIBRATED


def test_block_ram_bounds_the_clock_of_small_blocks() -> None:
    slow = part("XC3S500E", ram_clock=230e6)
    limit = timing.clock_limit(3, 6, slow)
    assert limit.value == 230e6
    assert limit.interval[1] <= 230e6
    assert "block RAM" in limit.source


@given(rows=sides, columns=sides)
def test_clock_falls_as_the_block_grows(rows: int, columns: int) -> None:
    small, large = (
        timing.clock_limit(rows, columns, part("XC2V6000")),
        timing.clock_limit(rows + 1, columns, part("XC2V6000")),
    )
    assert large.value <= small.value
    assert small.interval[0] <= small.value <= small.interval[1]


def test_or_tree_has_a_register_for_288_nodes_or_for_a_cluster_and_16_of_them() -> None:
    shapes = (1, 1), (12, 24), (12, 25), (48, 96)
    assert [timing.or_tree_stages(*shape) for shape in shapes] == [1, 1, 2, 2]
    assert [timing.or_tree_stages(*shape, 1) for shape in shapes] == [2, 2, 3, 3]
    assert timing.dropped_pass_cycles(6, 12) == 3
    assert timing.dropped_pass_cycles(6, 12, 1) == 7


@given(last=precisions)
def test_speed_up_at_any_precision_follows_from_100_microseconds(last: int) -> None:
    hardware = timing.iteration_cycles(last) / 150e6
    assert 100e-6 / hardware == pytest.approx(15_000 / (last + 2))


def test_levers_name_resources_as_the_tables_do() -> None:
    demand = BIT_SERIAL.demand(Job(problem(96, 96), parameters((96, 96), 63), part=part("XC3S500E")))
    advice = {kind: demand.levers[kind][-1].advice for kind in ("lut4", "flip_flops", "block_rams")}
    for kind, word in (("lut4", "LUT4"), ("flip_flops", "flip-flops"), ("block_rams", "block RAMs")):
        assert advice[kind] == f"take one with at least {demand.total(kind):,} {word}"


def test_software_has_no_clock_and_no_power_law() -> None:
    task, chosen = problem(6, 8), parameters((3, 4), 9)
    with pytest.raises(InputError):
        SOFTWARE.clock_limit(Job(task, chosen))
    with pytest.raises(InputError):
        SOFTWARE.power(SOFTWARE.demand(Job(task, chosen)), 1, part("XC2V6000"))


def test_power_carries_the_intervals_of_the_part() -> None:
    chip = part("XC2V6000")
    demand = BIT_SERIAL.demand(Job(problem(72, 132), parameters((36, 66), 255), part=chip))
    static, dynamic = BIT_SERIAL.power(demand, 150_000_000, chip)
    assert static == chip.static_power
    activity = counted_activity("harmonic", "bit_serial")
    assert activity is not None
    typical, (least, most) = demand.total("slices") * 150e6 * 1.5e-12, activity.interval
    assert dynamic.value == pytest.approx(typical * activity.value)
    assert dynamic.interval == pytest.approx((typical / 1.5 * least, typical * 2 * most))
    assert dynamic.status is Status.ASSUMED


def test_every_item_says_how_it_is_known() -> None:
    demand = BIT_SERIAL.demand(Job(problem(72, 132), parameters((36, 66), 255), part=part("XC2V6000")))
    assert all(item.figure.source and item.amount >= 0 and item.resource in RESOURCES for item in demand.items)
