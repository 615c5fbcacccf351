"""What the circuits take of a part: multipliers, slices, block RAM, and the levers of one that does not fit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.ground.figures import RESOURCES
from codesign.ground.models import Part
from codesign.inputs import load_part
from codesign.planners.job import Job
from codesign.planners.velocity_obstacle import published, styles
from codesign.planners.velocity_obstacle.plan import AvoidParameters, generate
from codesign.planners.velocity_obstacle.plan.parameters import Responsibility, Unit
from codesign.planners.velocity_obstacle.styles import ARCHITECTURES, Style, resources
from codesign.planners.velocity_obstacle.styles import resources as multipliers
from codesign.planners.velocity_obstacle.styles.resources import LAWS
from codesign.planners.velocity_obstacle.styles.timing import cycles_of_trial
from codesign.system.fit import fit

CIRCUITS = {circuit.style: circuit for circuit in ARCHITECTURES}


@pytest.fixture(scope="module")
def part() -> Part:
    return load_part("XC3S500E-4")


def test_table_i_within_its_rounding(part: Part) -> None:
    for style, (slices, luts, _) in published.TABLE_I.items():
        need = styles.totals(style, 2, AvoidParameters(), part)
        assert abs(100 * need["lut4"] / 9312 - luts) <= 0.5
        assert abs(100 * need["slices"] / 4656 - slices) <= 0.5


@pytest.mark.parametrize(("robots", "wanted"), [(2, 6), (4, 16), (8, 36)])
def test_multipliers_of_the_hybrid_circuit(robots: int, wanted: int, part: Part) -> None:
    assert styles.totals(Style.HYBRID, robots, AvoidParameters(), part)["multipliers"] == wanted
    assert styles.totals(Style.PIPELINED, robots, AvoidParameters(), part)["multipliers"] == 5


@pytest.mark.parametrize(("width", "wanted"), [(16, 4), (17, 8), (18, 8), (24, 9)])
def test_multipliers_of_a_detector_as_synthesised(width: int, wanted: int) -> None:
    passive = AvoidParameters(width=width, responsibility=Responsibility.FULL)
    circuit = resources.structure(Style.HYBRID, 2, passive)
    assert multipliers.multipliers(multipliers.detector_products(circuit), "xc3se") == wanted
    assert multipliers.multipliers(multipliers.update_products(circuit), "xc3se") == (1 if width <= 18 else 4)


PARTS_OF_FAMILIES = {"xc3se": "XC3S500E-4", "ecp5": "LFE5U-85F-6", "gowin": "GW2A-18-7"}


@pytest.mark.parametrize("family", PARTS_OF_FAMILIES)
def test_multipliers_and_memories_equal_every_synthesis(family: str) -> None:
    rows = [row for row in LAWS.rows if row.family == family]
    assert len(rows) >= 10
    for row in rows:
        circuit = row.variables
        formed = {
            resources.UPDATES: multipliers.update_products(circuit),
            resources.DETECTIONS: multipliers.detector_products(circuit) * circuit["DETECT_UNITS"],
            resources.REST: [multipliers.shared_product(circuit)],
        }
        for piece, products in formed.items():
            assert row.count(piece, "multipliers") == math.ceil(multipliers.multipliers(products, family))
        parameters = AvoidParameters(width=circuit["WIDTH"])
        rams, _ = resources.array_rams(parameters, load_part(PARTS_OF_FAMILIES[family]))
        assert row.count(resources.ARRAY, "block_rams") == rams


@pytest.mark.parametrize("family", ["ecp5", "gowin"])
@pytest.mark.parametrize("resource", ["lut4", "flip_flops"])
def test_logic_of_serial_circuits_held_out_is_within_five_per_cent(family: str, resource: str) -> None:
    errors = []
    for row in LAWS.rows:
        if row.family == family and LAWS.held_out(row.variables):
            for piece in LAWS.pieces:
                value = LAWS.value(piece, resource, row.variables, family)
                counted = row.count(piece, resource)
                errors.append(abs(value - counted) / max(1, counted))
    assert len(errors) >= 4
    assert np.mean(errors) <= 0.05
    assert max(errors) <= 0.10


def test_a_constant_factor_takes_the_multipliers_of_its_bits() -> None:
    """R² = 121 · 2^12 has eight bits with its sign: two multipliers less than a factor of 35 bits."""
    circuit = resources.structure(Style.HYBRID, 2, AvoidParameters(unit=Unit.PARALLEL))
    assert multipliers.multipliers(multipliers.detector_products(circuit), "xc3se") == 18
    constant = {**circuit, "RADIUS": 704}
    assert multipliers.multipliers(multipliers.detector_products(constant), "xc3se") == 16
    # A step of an eighth of a second is a shift.
    assert multipliers.multipliers(multipliers.update_products({**circuit, "STEP": 1 << 12}), "xc3se") == 2


def test_what_the_rtl_does_not_take_of_table_i_belongs_to_the_paper_alone() -> None:
    for name, listed in (("XC3S500E-4", True), ("LFE5U-85F-6", False)):
        lines = resources.items(Style.HYBRID, 4, AvoidParameters(), load_part(name))
        assert (resources.TABLE_I in {each.name for each in lines}) == listed


@settings(max_examples=examples(200))
@given(st.integers(8, 24), st.booleans(), st.data())
def test_factors_of_a_detector_fit_the_bits_they_are_given(width: int, half: bool, data: Any) -> None:
    wide = multipliers.wide_bits({"WIDTH": width, "HALF": half}) - 1
    limit = 2 ** (width - 1)
    component = st.one_of(st.sampled_from([-limit, limit - 1]), st.integers(-limit, limit - 1))
    x, y = (data.draw(component) - data.draw(component) for _ in range(2))
    # Velocities are bounded as vectors: each of a length below the limit.
    lengths = [data.draw(st.tuples(component, component)) for _ in range(3)]
    own, now, other = ((a * 7 // 10, b * 7 // 10) for a, b in lengths)
    vx, vy = ((2 * a - b - c) if half else (a - c) for a, b, c in zip(own, now, other, strict=True))
    assert max(abs(x), abs(y)) <= 2**width
    assert max(abs(vx), abs(vy)) <= 2 ** (width + half)
    for value in (x * x + y * y, vx * vx + vy * vy, x * vx + y * vy, x * vy - y * vx):
        assert abs(value) <= 2**wide


def test_hybrid_with_8_robots_is_infeasible_by_three_budgets_and_says_what_mends_it(part: Part) -> None:
    parameters = AvoidParameters()
    problem = generate("circle", 8)
    circuit = CIRCUITS["hybrid"]
    held = fit(
        circuit.demand(Job(problem, parameters, part=part)),
        part,
        50_000_000,
        circuit.clock_limit(Job(problem, parameters, part=part)),
    )
    reasons = {reason.name: reason for reason in held.reasons}
    assert set(reasons) == {"slices", "lut4", "multipliers"}
    assert (reasons["multipliers"].demand, reasons["multipliers"].limit) == (36, 20)
    advice = " ".join(reasons["multipliers"].levers)
    assert "3, with 3 detect_units, fit XC3S500E, 37 cycles" in advice
    assert "pipelined fits XC3S500E, 84 cycles" in advice
    assert "at least 36 multipliers" in advice
    mended = AvoidParameters(update_units=3, detect_units=3)
    assert not styles.shortages(Style.HYBRID, 8, mended, part)
    assert cycles_of_trial(Style.HYBRID, 8, mended) == 37
    for update, detect in ((4, 4), (3, 4)):
        more = AvoidParameters(update_units=update, detect_units=detect)
        assert styles.shortages(Style.HYBRID, 8, more, part)


@pytest.mark.parametrize("kind", ["update_units", "detect_units"])
def test_the_sequential_style_refuses_units_that_it_cannot_have(kind: str, part: Part) -> None:
    problem = generate("circle", 8)
    for style, circuit in CIRCUITS.items():
        for count in (None, 1, 2, 4):
            parameters = AvoidParameters.model_validate({kind: count})
            limit = circuit.clock_limit(Job(problem, parameters, part=part))
            held = fit(circuit.demand(Job(problem, parameters, part=part)), part, 50_000_000, limit)
            refused = [reason for reason in held.reasons if reason.name == f"{kind} of the sequential style"]
            assert bool(refused) == (style == "sequential" and (count or 1) > 1)
            for reason in refused:
                assert (reason.demand, reason.limit) == (count, 1)
                assert f"avoid.{kind}: 1, or left out" in " ".join(reason.levers)


@pytest.mark.parametrize("robots", [2, 4])
def test_hybrid_with_2_and_4_robots_fits(robots: int, part: Part) -> None:
    assert not styles.shortages(Style.HYBRID, robots, AvoidParameters(), part)


def test_every_lever_names_a_lanes_that_fits(part: Part) -> None:
    for robots in (5, 8, 12, 16):
        for width in (16, 18):
            parameters = AvoidParameters(width=width)
            lanes = styles.widest_lanes(robots, parameters, part)
            assert lanes is not None
            assert not styles.shortages(Style.HYBRID, robots, lanes, part)


@settings(max_examples=60)
@given(st.integers(2, 63), st.sampled_from(Style), st.integers(8, 23))
def test_demand_never_falls_with_robots_or_width(robots: int, style: Style, width: int) -> None:
    part = load_part("XC3S500E-4")
    parameters = AvoidParameters(width=width)
    need = styles.totals(style, robots, parameters, part)
    # From six robots on a unit keeps their states in LUTs as memory, not in registers, which takes less.
    stored = style is not Style.HYBRID and robots + 1 == 6
    more_robots = need if stored else styles.totals(style, robots + 1, parameters, part)
    wider = styles.totals(style, robots, parameters.model_copy(update={"width": width + 1}), part)
    for kind in RESOURCES:
        assert more_robots[kind] >= need[kind]
        assert wider[kind] >= need[kind]


def test_the_mapper_packs_denser_only_near_the_end() -> None:
    ratio = resources.slice_ratio(Style.HYBRID)
    assert resources.slices_of(Style.HYBRID, 6518, 4656) == int(np.ceil(ratio * 3259))
    assert resources.slices_of(Style.HYBRID, 8320, 4656) == int(0.97 * 4656)
    assert resources.slices_of(Style.HYBRID, 9200, 4656) == 4600
    assert resources.slices_of(Style.HYBRID, 11_924, 4656) == 5962


def test_an_array_too_large_for_a_block_ram_is_a_bound(part: Part) -> None:
    large = AvoidParameters(directions=512, speeds=64)
    (bound,) = CIRCUITS["pipelined"].demand(Job(generate("circle", 2), large, part=part)).bounds
    assert bound.figure.value == 512 * 64 > bound.limit == 16_384
    assert "at most 32" in bound.levers[0].advice
