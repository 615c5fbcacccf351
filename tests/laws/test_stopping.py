"""The law of stopping: inverse pairs, directions, limits; and the worst reaction of a loop, against the loop itself."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from codesign.laws.stopping import Loop, Stopping, braking

AMOUNTS = st.floats(1e-3, 1e3)
TIMES = st.floats(0.0, 1e3)
BODIES = st.builds(Stopping, AMOUNTS, AMOUNTS)


@given(BODIES, TIMES)
def test_the_speed_is_the_closed_form_and_its_distance_is_the_sight(body: Stopping, reaction: float) -> None:
    speed = body.speed(reaction)
    assert body.distance(speed, reaction) == pytest.approx(body.sight, rel=1e-9)
    # Exactly, as the difference of two near numbers loses digits.
    root = Fraction(
        math.isqrt(int((Fraction(reaction) ** 2 + 2 * Fraction(body.sight) / Fraction(body.brake)) * 10**60))
    )
    closed = Fraction(body.brake) * (root / 10**30 - Fraction(reaction))
    assert speed == pytest.approx(float(closed), rel=1e-9)


@given(BODIES, AMOUNTS)
def test_speed_and_reaction_are_inverse(body: Stopping, number: float) -> None:
    assert body.reaction(body.speed(number)) == pytest.approx(number, rel=1e-6, abs=1e-6)
    speed = min(number, body.speed(0.0))
    assert body.speed(max(0.0, body.reaction(speed))) == pytest.approx(speed, rel=1e-6)


@given(BODIES, TIMES, st.floats(1.01, 10.0))
def test_it_is_faster_with_more_sight_harder_brakes_and_a_quicker_reaction(
    body: Stopping, reaction: float, factor: float
) -> None:
    speed = body.speed(reaction)
    assert Stopping(body.sight * factor, body.brake).speed(reaction) > speed
    assert Stopping(body.sight, body.brake * factor).speed(reaction) >= speed
    assert body.speed((reaction + 1e-3) * factor) < speed
    assert speed <= math.sqrt(2 * body.sight * body.brake) * (1 + 1e-12)


@given(BODIES, AMOUNTS)
def test_the_limits_of_no_reaction_time_and_of_endless_brakes(body: Stopping, reaction: float) -> None:
    assert body.speed(0.0) == pytest.approx(math.sqrt(2 * body.sight * body.brake))
    assert body.reaction(body.speed(0.0)) == pytest.approx(0.0, abs=1e-9 * math.sqrt(body.sight / body.brake))
    assert Stopping(body.sight, math.inf).speed(reaction) == pytest.approx(body.sight / reaction)


@given(BODIES, AMOUNTS, TIMES)
def test_the_brakes_that_are_needed_are_just_enough(body: Stopping, speed: float, reaction: float) -> None:
    assume(speed * reaction < 0.999 * body.sight)
    needed = Stopping(body.sight, body.needed_brake(speed, reaction))
    assert needed.speed(reaction) == pytest.approx(speed, rel=1e-6)
    assert braking(speed, needed.brake) + speed * reaction == pytest.approx(body.sight)


def test_the_laws_hold_over_fractions_and_arrays() -> None:
    body = Stopping(Fraction(4), Fraction(2))
    assert body.reaction(Fraction(3, 2)) == Fraction(55, 24)
    times = np.array([0.0, 1.5])
    assert Stopping(4.0, 2.0).speed(times).tolist() == [4.0, 2.0]
    assert Loop(0.1, 0.0).reaction(np.array([0.05, 0.2])) == pytest.approx([0.15, 0.5])


def reacted(period: Fraction, plan: Fraction, phase: Fraction, appeared: Fraction) -> Fraction:
    """From the appearance of an obstacle to the end of the first plan that began with a scan of it.

    Scans are at the multiples of ``period``. Plans begin at ``phase`` and run back to back, or wait for the next scan.
    """
    begun = phase
    while True:
        scan = begun // period * period
        ended = begun + plan
        if scan > appeared:
            return ended - appeared
        begun = ended if plan > period else (begun // period + 1) * period


@given(st.integers(1, 40), st.integers(1, 160), st.data())
def test_no_loop_reacts_later_than_the_law_says_and_one_reacts_just_so(
    period: int, plan: int, data: st.DataObject
) -> None:
    """A plan that is as quick as the sensor begins with a scan. A slower one begins at any time."""
    worst = Fraction(Loop(period, 0).reaction(plan))
    steps = data.draw(st.integers(0, 3 * plan))
    phase = Fraction(steps if plan > period else steps * period)
    for appeared in (Fraction(data.draw(st.integers(0, 400)), 7), phase // period * period):
        reaction = reacted(Fraction(period), Fraction(plan), phase, appeared + phase)
        assert reaction <= worst
    # An obstacle that appears at a scan, before which a plan began that is nearly over, or has just ended.
    first = Fraction(1000 * period)
    begun = first + period - Fraction(1, 1000) if plan > period else first
    assert reacted(Fraction(period), Fraction(plan), begun, first) == pytest.approx(worst, abs=2e-3)


@given(st.floats(0.0, 10.0), st.floats(0.0, 10.0), st.floats(1e-3, 100.0))
def test_the_longest_plan_keeps_the_reaction_and_no_longer_one_does(
    period: float, delay: float, reaction: float
) -> None:
    loop = Loop(period, delay)
    plan = loop.plan(reaction)
    if plan <= 0:
        assert period + delay >= reaction
        return
    assert loop.reaction(plan) <= reaction * (1 + 1e-9)
    longer = max(plan * 1.001, plan + 1e-6)
    assert loop.reaction(longer) > reaction * (1 - 1e-9)
