"""Clocks by what was placed, by what was published, and between them; and what every room's law is worth."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.inputs.library import load_part
from codesign.planners.breadth_first.styles import timing as breadth_first
from codesign.planners.clock_law import GROWTHS, MARGIN, TRANSFER, Placement, Registers, clock_law, on_family
from codesign.planners.harmonic.styles import timing as harmonic
from codesign.planners.measured import ClockRow
from codesign.planners.velocity_obstacle.styles import timing as robots
from codesign.planners.wavefront.styles import timing as wave
from codesign.planners.wavefront.styles.resources import ArrayLayout
from codesign.planners.wavefront.styles.tile import TileLayout

PUBLISHED = Figure(150e6, "Hz", Status.CALIBRATED, "a fit", 120e6, 180e6)


def of_family(family: str, megahertz: int = 400, grade: str = "-1") -> Part:
    """A part of a family with block RAM of that clock."""
    part = load_part("XC7A35T-1")
    ram = Figure(megahertz * 10**6, "Hz", Status.PUBLISHED, "a data sheet")
    return part.model_copy(update={"family": family, "block_ram_clock": ram, "speed_grade": grade})


def placement(part: str, family: str, pipeline: int, size: int, period: float) -> Placement:
    row = ClockRow(
        "style", "", family, part, "digest", {}, {}, [int(1e9 / period)] * 3,
        "memory", 3.6, 2, 0.5, 1.2, 0.1, "a path", "tools",
    )  # fmt: skip
    return Placement(row, Registers(f"pipeline {pipeline}", size))


def period(pipeline: int, size: int, scale: float = 1.0) -> float:
    return scale * (10.0 - 5.0 * pipeline) * (size / 72) ** (0.02 + 0.1 * pipeline)


SIZES = (36, 72, 144, 288)
PLACED = (
    *(placement("LFE5U-85F-8", "ecp5", each, size, period(each, size)) for each in (0, 1) for size in SIZES),
    *(placement("LFE5U-85F-6", "ecp5", each, 72, period(each, 72, 1.3)) for each in (0, 1)),
    placement("GW2A-18-7", "gowin", 1, 72, 3.5),
)


def limit(part: Part, pipeline: int, size: int) -> Figure:
    registers = Registers(f"pipeline {pipeline}", size)
    return on_family(PUBLISHED, part, "Virtex-4", registers=registers, placements=PLACED)


@pytest.mark.parametrize("pipeline", [0, 1])
def test_a_placed_family_has_the_clock_of_its_placements_at_any_size(pipeline: int) -> None:
    for size, status, width in ((250, Status.MEASURED, 1.1), (1000, Status.ASSUMED, 1.6)):
        found = limit(of_family("ECP5", grade="-8"), pipeline, size)
        assert found.value == pytest.approx(1e9 / period(pipeline, size), rel=0.01)
        assert found.status is status
        assert "a path" in found.source
        low, high = found.interval
        assert 1 / width - 0.01 < low / found.value < 1 < high / found.value < width + 0.01


def test_the_growth_is_the_one_that_predicts_what_is_held_out() -> None:
    law = clock_law(PLACED)
    assert law is not None
    # Powers of the size are lines over its logarithm.
    assert set(law.growth.values()) == {"log2"}
    assert len(law.errors) >= len(SIZES) * 2
    assert max(law.errors) < 0.01


def test_a_slower_grade_and_a_family_with_one_size_take_the_growth_of_the_others() -> None:
    slow = limit(of_family("ECP5", grade="-6"), 1, 288)
    assert slow.value == pytest.approx(1e9 / period(1, 288, 1.3), rel=0.02)
    gowin = limit(of_family("GW2A", grade="-7"), 1, 288)
    assert gowin.value == pytest.approx(1e9 / (3.5 * 4**0.12), rel=0.02)


def test_each_doubling_of_the_bits_that_pass_in_a_cycle_adds_the_same_share() -> None:
    base = placement("LFE5U-85F-8", "ecp5", 1, 72, period(1, 72))
    wider = [
        Placement(
            replace(base.row, clocks=[int(1e9 / (1.2**doublings * period(1, 72)))]),
            replace(base.registers, doublings=doublings),
        )
        for doublings in (1, 2)
    ]
    placements = (*PLACED, *wider)
    found = on_family(
        PUBLISHED,
        of_family("GW2A", grade="-7"),
        "Virtex-4",
        registers=Registers("pipeline 1", 72, 3),
        placements=placements,
    )
    assert found.value == pytest.approx(1e9 / (3.5 * 1.2**3), rel=0.01)
    # No plain circuit with digits was placed.
    plain = on_family(
        PUBLISHED,
        of_family("ECP5", grade="-8"),
        "Virtex-4",
        registers=Registers("pipeline 0", 72, 1),
        placements=placements,
    )
    assert plain.status is Status.ASSUMED


def test_a_grade_that_was_not_placed_lies_between_its_neighbours() -> None:
    between = limit(of_family("ECP5", grade="-7"), 1, 72)
    assert 1e9 / period(1, 72, 1.3) < between.value < 1e9 / period(1, 72)
    assert "not on XC7A35T-7" in between.source
    alone = limit(of_family("GW2A", grade="-9"), 1, 72)
    low, high = alone.interval
    assert low / alone.value < 1 / 1.15
    assert high / alone.value > 1.15


def test_a_published_family_keeps_its_clock() -> None:
    assert limit(of_family("Virtex-4"), 1, 72) is PUBLISHED


@pytest.mark.parametrize("family", ["Artix-7", "PolarFire SoC", "iCE40 UltraPlus"])
def test_a_family_that_was_never_placed_lies_between_those_that_were(family: str) -> None:
    found = limit(of_family(family), 1, 72)
    low, high = found.interval
    assert low < 1e9 / period(1, 72, 1.3) < high
    assert low < found.value <= PUBLISHED.value < high
    # The spread between the families that are known is 1.9 at least; it is half as wide again.
    assert high / low > (1e9 / 3.5 / (1e9 / period(1, 72, 1.3))) ** 1.5
    assert high >= 1e9 / 3.5
    assert found.status is Status.ASSUMED
    assert f"{family} was never placed" in found.source


def test_without_any_placement_the_published_law_is_wide() -> None:
    found = on_family(PUBLISHED, of_family("Artix-7"), "Virtex-4")
    assert found.value == PUBLISHED.value
    assert found.interval == (50e6, 180e6)
    assert "not of Artix-7" in found.source
    assert on_family(PUBLISHED, of_family("iCE40 UltraPlus"), "Virtex-4").interval[0] < 20e6


def test_no_clock_is_above_the_block_ram() -> None:
    found = limit(of_family("ECP5", 90, "-8"), 1, 72)
    assert found.value == 90e6
    assert found.interval[1] == 90e6
    assert "block RAM" in found.source


def test_a_size_far_from_all_placements_grows_no_faster_than_its_form() -> None:
    assert set(GROWTHS) == {"none", "log2", "fourth root"}
    small, large = (limit(of_family("ECP5", grade="-8"), 1, size).value for size in (72, 7200))
    assert math.log(small / large) == pytest.approx(0.12 * math.log(100), rel=0.05)


ROOMS: dict[str, Callable[[], tuple[Placement, ...]]] = {
    "harmonic": harmonic.placements,
    "breadth_first": breadth_first.placements,
    "velocity_obstacle": robots.placements,
    "wavefront": wave.placements,
}


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_has_the_clocks_of_its_placements(room: str) -> None:
    for each in ROOMS[room]():
        part = load_part(each.row.part)
        found = on_family(PUBLISHED, part, "Virtex-4", registers=each.registers, placements=ROOMS[room]())
        assert found.interval[0] <= each.row.clock <= max(found.interval[1], part.block_ram_clock.value)
        assert found.status is Status.MEASURED or found.value == part.block_ram_clock.value


def test_the_law_that_a_wave_borrows_is_faster_than_its_placements() -> None:
    for each in wave.placements():
        layout = ArrayLayout.of_row(each.row.variables)
        tiled = each.row.style == "tiled"
        if tiled:
            layout = TileLayout.of_row(each.row.variables).array
        assert wave.registers(layout, tiled=tiled) == each.registers
        borrowed = wave.clock_limit(layout, load_part("XC4VLX160-12"), tiled=tiled)
        assert borrowed.status is Status.ASSUMED
        assert borrowed.interval[0] < each.row.clock < borrowed.value


@pytest.mark.parametrize("room", ROOMS)
@settings(max_examples=200)
@given(data=st.data())
def test_a_clock_is_measured_only_where_it_was(room: str, data: st.DataObject) -> None:
    """The circuit with its options and digits, in a grade and between sizes that were placed; nothing else."""
    placements = ROOMS[room]()
    one = data.draw(st.sampled_from(placements))
    options = frozenset(data.draw(st.sets(st.sampled_from(["a new option", *one.registers.options]), max_size=1)))
    registers = replace(
        one.registers,
        size=one.registers.size * data.draw(st.floats(0.2, 5)),
        doublings=data.draw(st.sampled_from([0.0, one.registers.doublings, 2.0])),
        options=data.draw(st.sampled_from([options, one.registers.options])),
    )
    family = {"ecp5": "ECP5", "gowin": "GW2A"}[one.row.family]
    grade = data.draw(st.sampled_from(["-6", "-7", "-8"]))
    found = on_family(PUBLISHED, of_family(family, 900, grade), "Virtex-4", registers=registers, placements=placements)
    alike = [
        each
        for each in placements
        if each.registers.pipeline == registers.pipeline and each.row.family == one.row.family
    ]
    sizes = [each.registers.size for each in alike if each.row.part.endswith(grade)]
    placed = (
        bool(sizes)
        and min(sizes) <= registers.size <= max(sizes)
        and any(
            (each.registers.options, each.registers.doublings) == (registers.options, registers.doublings)
            for each in alike
        )
    )
    assert (found.status is Status.MEASURED) == placed
    assert not (placed and "not placed" in found.source)
    law = clock_law(placements)
    assert law is not None
    low, high = found.interval
    least = 1 if placed else 1.0001
    assert (
        high / low
        >= least
        * (1 + law.width(one.row.family, registers.pipeline))
        / (1 - law.width(one.row.family, registers.pipeline))
        * 0.999
    )


def test_no_circuit_is_farther_from_the_law_of_another_than_a_transfer_says() -> None:
    """The clock of each placement beside what the law of each other circuit of its planner says of that size."""
    factors = []
    for placements in (find() for find in ROOMS.values()):
        law = clock_law(placements)
        assert law is not None
        for each in placements:
            others = {other.registers.pipeline for other in placements} - {each.registers.pipeline}
            for other in others:
                plain = replace(each.registers, pipeline=other, doublings=0.0)
                period = law.period(each.row.part, each.row.family, plain)
                if period is not None:
                    factors.append(max(each.row.period_ns / period, period / each.row.period_ns))
    assert TRANSFER * 0.9 < max(factors) <= TRANSFER


@pytest.mark.parametrize("part", ["XC7Z020-1", "XC4VLX160-12", "GW2A-18-7"])
def test_a_borrowed_clock_says_what_its_circuit_reached_where_both_were_placed(part: str) -> None:
    """Beside the value, which is that of delay lines; the medians of one size, as they were placed, say as much."""
    layout = ArrayLayout((8, 8), 11)
    borrowed, lent = (wave.clock_limit(layout, load_part(part), tiled=tiled) for tiled in (True, False))
    assert borrowed.value == lent.value
    assert borrowed.interval[0] == lent.interval[0] / TRANSFER
    said = re.search(r"on LFE5U-85F-8 it reached (\d+)% of that", borrowed.source)
    clocks = {
        each.registers.like: each.row.clock
        for each in wave.placements()
        if each.row.part == "LFE5U-85F-8" and each.registers.size == 64 and not each.registers.options
        if each.registers.pipeline in ("delay lines", wave.registers(layout, tiled=True).pipeline)
    }
    assert said is not None
    assert int(said[1]) / 100 == pytest.approx(clocks["delay lines"] / clocks[""], abs=0.05)


@pytest.mark.parametrize("room", ROOMS)
def test_the_interval_beyond_the_sizes_holds_the_largest_and_the_smallest(room: str) -> None:
    """Each end is left out, with all other placements of its circuit on the family that are as far out."""
    placements = ROOMS[room]()
    for each in placements:
        alike = [
            other
            for other in placements
            if (other.registers.pipeline, other.row.part) == (each.registers.pipeline, each.row.part)
        ]
        sizes = sorted({other.registers.size for other in alike})
        if len(sizes) < 3 or each.registers.size not in (sizes[0], sizes[-1]):
            continue
        inner = tuple(
            other
            for other in placements
            if other.registers.pipeline != each.registers.pipeline
            or other.row.family != each.row.family
            or abs(math.log(other.registers.size / each.registers.size)) > 1e-9
        )
        found = on_family(PUBLISHED, load_part(each.row.part), "Virtex-4", registers=each.registers, placements=inner)
        assert found.status is Status.ASSUMED
        assert found.interval[0] <= each.row.clock <= found.interval[1], (each.row.part, each.registers)


@pytest.mark.parametrize("room", ROOMS)
def test_the_law_of_a_room_holds_what_it_was_not_fitted_to(room: str) -> None:
    placements = ROOMS[room]()
    law = clock_law(placements)
    assert law is not None
    # Products of robots and memories of engines have no delay in the open timing of Gowin.
    families = {"ecp5", "gowin"} if room in ("harmonic", "wavefront") else {"ecp5"}
    assert {each.row.family for each in placements} == families
    assert law.errors
    for family in families:
        for pipeline in {each.registers.pipeline for each in placements if each.row.family == family}:
            assert max(law.errors_of(family, pipeline)) * MARGIN <= law.width(family, pipeline)
    # Engines of 100 × 100 cells are slower by up to 14 % than smaller ones let expect.
    assert law.width("ecp5") <= 0.25
