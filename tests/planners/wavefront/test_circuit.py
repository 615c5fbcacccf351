"""The circuits of the wave: every random design point reports what the model says, clock edge by clock edge."""

from __future__ import annotations

from typing import Any

import pytest
from rtl_tools import quickest

from codesign import maps
from codesign.ground.errors import UnsuitedError
from codesign.hardware.rtl.verify import verify
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.rtl import CIRCUITS
from codesign.planners.wavefront.styles import timing

BY_STYLE = {style.style: style for style in CIRCUITS}


def rooms(side: int) -> Problem:
    free = maps.rooms(side, side, room=(4, 4), door=2, seed=1).free
    end = maps.nearest_free(free, (side - 1, side - 1))
    assert end is not None
    return Problem(free, ((0, 0),), (end,))


def check(style: str, seed: int) -> None:
    verified = verify(BY_STYLE[style], BY_STYLE[style].sample(seed), quickest())
    assert verified.differences == 0, f"seed {seed}: {verified.first}"
    assert verified.events > 0


@pytest.mark.parametrize("seed", [30, 48, 85])
def test_an_array_of_delay_lines_equals_the_model(seed: int) -> None:
    # Safe paths addressed and by a chain; elements of 16 cells on a map of one column, smaller than its start's word.
    check("delay_line", seed)


@pytest.mark.parametrize("seed", [4, 8])
def test_a_tiled_array_equals_the_model(seed: int) -> None:
    # Seed 8: safe paths that cut no corner, with a penalty; both have tiles beyond the map.
    check("tiled", seed)


def test_an_array_of_adders_equals_the_model() -> None:
    check("adder_comparator", 3)


@pytest.mark.slow
@pytest.mark.parametrize("style", BY_STYLE)
@pytest.mark.parametrize("seed", range(1000, 1100))
def test_many_arrays_equal_the_model(style: str, seed: int) -> None:
    check(style, seed)


def test_samples_cover_every_option() -> None:
    jobs = [BY_STYLE["delay_line"].sample(seed) for seed in range(60)]
    for key, values in {
        "stop": {"starts", "whole_map"},
        "paths": {"shortest", "safe"},
        "course": {"local", "complete"},
        "read_out": {"addressed", "chain"},
        "corner_cutting": {True, False},
        "element_cells": {1, 2, 4, 8, 16},
    }.items():
        assert {job.parameters.model_dump(mode="json")[key] for job in jobs} == values, key
    assert {job.parameters.penalty is None for job in jobs} == {True, False}
    assert {job.inside is None for job in jobs} == {True, False}


def test_a_model_that_is_wrong_by_a_cycle_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    style = BY_STYLE["delay_line"]
    job: Job[Problem, PropagateParameters] = Job(rooms(5), PropagateParameters())
    assert verify(style, job, quickest()).differences == 0
    monkeypatch.setattr(timing, "NEIGHBOURS", 9)
    verified = verify(style, job, quickest())
    assert verified.differences > 0
    assert verified.first is not None
    assert "step" in verified.first.words


@pytest.mark.parametrize(
    ("raw", "key"),
    [
        ({"element_cells": 4, "read_out": "chain"}, "propagate.read_out"),
        ({"register_bits": 3}, "propagate.register_bits"),
    ],
)
def test_parameters_without_a_circuit_are_refused(raw: dict[str, Any], key: str) -> None:
    job: Job[Problem, PropagateParameters] = Job(rooms(12), PropagateParameters(**raw))
    with pytest.raises(UnsuitedError) as refused:
        BY_STYLE["delay_line"].circuit(job)
    (fault,) = refused.value.faults
    assert fault.key == key
    assert fault.hint


def test_an_element_takes_its_cells_one_after_the_other() -> None:
    shape, largest = (64, 64), 189
    cycles = [timing.wave_cycles(largest, cells) for cells in (1, 4, 64)]
    assert cycles == [190, 760, 12160]
    assert timing.load_cycles(shape, 64) == 1 + 64 * 2 + 1
