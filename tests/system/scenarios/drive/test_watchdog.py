"""The watchdog of events ends a mission at the same moment, however finely the planner is simulated."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import IDEAL, PLACEMENTS, Ground, rectangle

import codesign
from codesign.system.scenarios import simulate
from codesign.views.trace import MemoryListener

OBSTACLES = {"appearing": [rectangle(2, 5, at="100 ms")], "moving": [{"route": [[3, 3], [3, 12]], "speed": "1 m/s"}]}


@settings(max_examples=10, derandomize=True)
@given(
    placement=st.sampled_from(sorted(PLACEMENTS)),
    period=st.sampled_from(["1 us", "50 us", "1 ms", "100 ms"]),
    events=st.integers(1, 1500),
    ideal=st.booleans(),
    clock=st.sampled_from(["50 kHz", "1 MHz", "100 MHz"]),
    restart=st.booleans(),
)
def test_it_ends_a_drive_at_the_same_moment_at_each_granularity(
    tmp_path: Path, placement: str, period: str, events: int, ideal: bool, clock: str, restart: bool
) -> None:
    spec: dict[str, Any] = {
        "platform": [IDEAL if ideal else {}, {"components": {"fpga": {"clock": clock}}}],
        "control_period": period,
        "events": events,
        "known": "none",
        "limit": "5 s",
        "obstacles": OBSTACLES,
        "replan": {"trigger": "change", "when_busy": "restart" if restart else "finish"},
    }
    ground = Ground(tmp_path)
    ahead, records = ground.watched(placement, **spec)
    visits, singly = ground.watched(placement, granularity="visit", **spec)
    assert visits.model_dump_json() == ahead.model_dump_json()
    assert [repr(record) for record in singly] == [repr(record) for record in records]
    # With nobody listening the planner is simulated more coarsely still.
    assert ground.run(placement, **spec) == ahead


def test_a_control_period_of_a_microsecond(tmp_path: Path) -> None:
    """The case that was found: 20,000 events ended the mission earlier where visits were simulated singly."""
    ground, spec = Ground(tmp_path), {"platform": IDEAL, "control_period": "1 us", "events": 20_000}
    ahead, visits = (ground.run("harmonic", granularity=each, **spec) for each in ("run_ahead", "visit"))
    assert ahead == visits
    assert ahead.mission is not None
    assert "limit of 20,000 events" in ahead.mission.ended
    assert ahead.mission.turns <= 1000


@pytest.mark.parametrize("events", [1, 40, 333])
def test_it_ends_a_fleet_at_the_same_moment_at_each_granularity(events: int) -> None:
    from codesign.inputs import design_point

    platform, workload = codesign.load_platform("nexys2-serial"), codesign.load_workload("robots-4-fleet")
    point = design_point(platform, workload, {"workload.scenario.events": events})
    told = []
    for granularity in ("run_ahead", "visit"):
        listener = MemoryListener()
        result = simulate(*point, granularity=granularity, listeners=(listener,))
        told.append((result, [repr(record) for record in listener.records]))
    assert told[0] == told[1]
    assert told[0][0].fleet is not None
    assert f"limit of {events} events" in told[0][0].fleet.ended
