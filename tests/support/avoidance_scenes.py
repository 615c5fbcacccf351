"""Robots near each other, and a run held against the plain reference."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st
from reference_robots import History

from codesign.planners.velocity_obstacle.plan import Avoidance, AvoidParameters, RobotsProblem, generate
from codesign.planners.velocity_obstacle.plan.parameters import Detection, Gains, Responsibility

ALL_TERMS = Gains.model_construct(proportional=0.5, integral=0.05, derivative=0.1)
"""Refused in a workload, as the sum overshoots; the arithmetic of all three terms is held against its twin anyway."""


WIDTHS = st.sampled_from([15, 16, 17, 18, 21, 24])


def given_parameters(draw: Any, **fixed_values: Any) -> AvoidParameters:
    gains = draw(st.sampled_from([Gains(), Gains(proportional=0.5, derivative=0.1), ALL_TERMS]))
    checked = AvoidParameters(
        width=draw(WIDTHS),
        detection=draw(st.sampled_from(Detection)),
        responsibility=draw(st.sampled_from(Responsibility)),
        margin=draw(st.sampled_from([0.0, 1.0, 2.5])),
        **fixed_values,
    )
    return checked.model_copy(update={"gains": gains})


@st.composite
def scenes(draw: Any, updates: int = 60) -> tuple[RobotsProblem, AvoidParameters]:
    """Robots near each other in a small arena, so that they meet soon."""
    side = draw(st.sampled_from([60.0, 100.0]))
    problem = generate(
        draw(st.sampled_from(["circle", "crossing", "random"])),
        draw(st.integers(2, 5)),
        radius=draw(st.sampled_from([2.0, 3.5])),
        speed=draw(st.sampled_from([3.0, 6.0, 7.3])),
        acceleration=draw(st.sampled_from([24.0, 29.0])),
        arena=(side, side),
        seed=draw(st.integers(0, 1000)),
    )
    return problem, given_parameters(draw, updates=updates)


def assert_same_run(run: Avoidance, history: History) -> None:
    """All states and decisions up to the last update before a value left its word, or to the end."""
    rows = len(run.times)
    assert run.updates == len(history.choices)
    # The update that ended the run may have left two states: where its robots had decided, and the one out of words.
    assert len(history.times) - 2 * history.overflow <= rows <= len(history.times)
    assert np.array_equal(run.positions, np.array(history.positions[:rows]))
    assert np.array_equal(run.velocities, np.array(history.velocities[:rows]))
    assert run.times.tolist() == history.times[:rows]
    for name, field in (("candidates", "candidate"), ("checks", "checks"), ("trials", "trials")):
        told = [[getattr(choice, field) for choice in choices] for choices in history.choices[: run.updates]]
        assert np.array_equal(getattr(run, name), np.array(told).reshape(run.updates, -1)), name
