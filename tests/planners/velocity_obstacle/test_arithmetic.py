"""Words of fixed point: the least width, the greatest value, and a value that leaves its word."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import reference_robots
from avoidance_scenes import assert_same_run
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from codesign.ground.errors import InputError
from codesign.planners.job import Job
from codesign.planners.velocity_obstacle.plan import AvoidParameters, avoid, generate
from codesign.planners.velocity_obstacle.plan.arithmetic import fixed, fraction_bits, least_width
from codesign.planners.velocity_obstacle.plan.parameters import Gains
from codesign.planners.velocity_obstacle.plan.planner import PLANNER


@pytest.mark.parametrize(
    ("parameters", "key", "what"),
    [
        ({"width": 12}, "width", "15 bits or more"),
        ({"directions": 16}, "directions", "24 directions or more"),
        ({"speeds": 2}, "speeds", "3 speeds or more"),
    ],
)
def test_arrays_too_coarse_and_words_too_narrow(parameters: dict[str, Any], key: str, what: str) -> None:
    problem = generate("circle", 4, seed=1)
    fault = PLANNER.check(Job(problem, AvoidParameters(**parameters)))
    assert fault is not None
    assert fault[0] == key
    assert what in fault[1]
    with pytest.raises(InputError, match=what):
        avoid(problem, AvoidParameters(**parameters))
    said = int(what.split(maxsplit=1)[0])
    assert PLANNER.check(Job(problem, AvoidParameters(**{key: said}))) is None


def test_the_least_width_is_the_least() -> None:
    problem, parameters = generate("circle", 2), AvoidParameters()
    least = least_width(problem, parameters)
    assert least == 15
    fixed(problem, parameters, least)
    with pytest.raises(InputError, match="14 bits"):
        fixed(problem, parameters, least - 1)


@pytest.mark.parametrize("step", ["0 s", "10 ns", "1000 s", "fast", "100"])
def test_time_steps_that_are_none(step: str) -> None:
    with pytest.raises(ValidationError):
        AvoidParameters(time_step=step)


def test_a_value_that_leaves_its_word_ends_the_run() -> None:
    """A robot that gains too large drive off is told of, with the quantity, and never wraps."""
    problem = generate("circle", 8)
    gains = Gains.model_construct(proportional=2.0, integral=1.0, derivative=1.0)
    wild = AvoidParameters().model_copy(update={"gains": gains})
    run = avoid(problem, wild)
    assert run.departure is not None
    assert "left its words of 16 bits" in str(run.departure)
    history = reference_robots.run(fixed(problem, wild), problem, wild)
    assert history.overflow
    assert_same_run(run, history)
    assert max(np.abs(run.positions).max(), np.abs(run.velocities).max()) < 2**15


@settings(max_examples=examples(200))
@given(st.floats(1e-3, 4096.0), st.integers(8, 24))
def test_formats_hold_their_greatest_value_and_no_bit_less(greatest: float, width: int) -> None:
    bits = fraction_bits(greatest, width)
    limit = 2 ** (width - 1)
    assert round(math.ldexp(greatest, bits)) < limit
    assert round(math.ldexp(greatest, bits + 1)) >= limit
