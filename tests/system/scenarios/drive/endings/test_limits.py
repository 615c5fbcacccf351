"""Limits, patience and periods end a drive for a stated reason."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from mission_specs import ENDS, IDEAL, OPEN, POINT

from codesign.system import Result
from codesign.system.results.mission import Mission

Drives = Callable[..., tuple[Result, Mission]]


def test_a_deadline_of_zero_with_links_that_take_no_time(drives: Drives) -> None:
    _, mission = drives(platform=[IDEAL, POINT], text=OPEN, **ENDS, deadline="0 s")
    assert mission.reached
    assert mission.missed_deadlines == 0


def test_a_deadline_of_zero_with_links_as_they_are(drives: Drives) -> None:
    """Every turn is late: the robot brakes at each, and creeps on with each late command, or says why it stands."""
    _, mission = drives(text=OPEN, **ENDS, deadline="0 s", limit="30 s", patience="5 s")
    assert mission.missed_deadlines >= mission.turns - 2
    assert mission.reached or "no answer within 0 s" in mission.ended


def test_the_limit_on_simulated_time(drives: Drives) -> None:
    _, mission = drives(text=OPEN, **ENDS, limit="1234567 us")
    assert mission.mission_time_s == 1.234567
    assert "limit of 1.23457 s of simulated time" in mission.ended


def test_a_limit_of_zero(drives: Drives) -> None:
    _, mission = drives(text=OPEN, **ENDS, limit="0 s")
    assert mission.mission_time_s == 0.0
    assert not mission.reached
    assert "limit" in mission.ended


@pytest.mark.parametrize("events", [1, 7, 200])
def test_the_limit_on_events(drives: Drives, events: int) -> None:
    _, mission = drives(text=OPEN, **ENDS, events=events)
    assert f"limit of {events} events" in mission.ended
    assert not mission.reached


def test_patience_of_zero(drives: Drives) -> None:
    _, mission = drives(text=OPEN, **ENDS, patience="0 s")
    assert not mission.reached
    assert "stood for 0 s" in mission.ended


def test_patience_is_not_spent_while_a_plan_is_under_way(drives: Drives) -> None:
    """A plan may take longer than the patience of a robot that has no way."""
    _, mission = drives(
        platform={"components": {"fpga": {"clock": "100 Hz"}}}, text=OPEN, **ENDS, patience="1 s", limit="5 min"
    )
    assert mission.reached, mission.ended
    assert mission.waiting_s > 2.0


def test_a_plan_that_outlasts_the_mission(drives: Drives) -> None:
    result, mission = drives(
        "harmonic", platform={"components": {"fpga": {"clock": "10 Hz"}}}, text=OPEN, **ENDS, limit="20 s"
    )
    assert mission.mission_time_s == 20.0
    assert mission.plans == 0
    assert result.time is None
    assert mission.waiting_s == pytest.approx(20.0, abs=0.1)
    assert mission.bottleneck is not None
    assert mission.bottleneck.name == "fpga"
    assert mission.account["fpga"].compute_s == pytest.approx(20.0, abs=0.2)


@pytest.mark.parametrize("period", ["1 us", pytest.param("10 ms", marks=pytest.mark.slow), "100 s"])
def test_periods_far_off(drives: Drives, period: str) -> None:
    """Turns that are longer than their period, or the mission."""
    _, mission = drives(
        platform=IDEAL,
        text=OPEN,
        **ENDS,
        control_period=period,
        limit="300 s",
        patience="250 s",
        events=2_000 if period == "1 us" else 100_000,
    )
    assert mission.reached or "events" in mission.ended
    assert mission.reached or period == "1 us"


# Odd, and well
