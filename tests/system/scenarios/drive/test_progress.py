"""A long drive is announced, shows how far it is, and comes out the same whether anybody looks or not."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest
from click.testing import Result as Invoked
from hypothesis import given
from hypothesis import strategies as st
from mission_specs import SECOND, Ground, rectangle

from codesign.inputs.scenario import Drive
from codesign.system import MissionProgress
from codesign.system.scenarios import outlook, simulate
from codesign.system.scenarios.drive.mission import EVENTS_OF_A_TURN, longest_turns

Hwsw = Callable[..., Invoked]

WALLED = [rectangle(12, 12, 4, 1), rectangle(12, 12, 1, 4)]
"""Around the goal: the robot finds them, and stands until the mission ends."""


@given(limit=st.integers(0, 4 * 10**18), period=st.integers(10**6, 4 * 10**18), events=st.integers(1, 10**10))
def test_no_drive_takes_more_turns_than_told(limit: int, period: int, events: int) -> None:
    """A turn takes an event of its own at least, and begins at a multiple of the control period up to the limit."""
    scenario = Drive.model_construct(limit=limit, control_period=period, events=events)
    turns = longest_turns(scenario)
    assert turns * period > limit or turns * (EVENTS_OF_A_TURN + 1) > events


@pytest.mark.parametrize(
    ("scenario", "said"),
    [
        ({}, None),
        ({"limit": "60 min"}, None),
        ({"limit": "1000 h", "events": 1000}, None),
        ({"limit": "1000 h"}, "100,001 turns of the control loop, and ends after 3,600,000 s of simulated time"),
        ({"limit": "1000 h", "events": 10**10}, "36,000,001 turns"),
        ({"control_period": "1 us", "limit": "60 min"}, "100,001 turns"),
    ],
)
def test_a_long_drive_is_announced(tmp_path: Path, scenario: dict[str, object], said: str | None) -> None:
    told = outlook(Ground(tmp_path).point(**scenario)[1])
    assert told is None if said is None else said in str(told)


def test_progress_rises_and_changes_nothing(tmp_path: Path) -> None:
    told: list[MissionProgress] = []
    point = Ground(tmp_path).point(hidden=WALLED, limit="200 s", patience="1 h")
    watched = simulate(*point, progress=told.append)
    assert watched == simulate(*point)
    assert watched.mission is not None
    assert watched.mission.mission_time_s == 200
    assert len(told) > 4
    assert all(0 < one.share <= 1 for one in told)
    for before, after in pairwise(told):
        assert before.time <= after.time <= 200 * SECOND
        assert before.events < after.events
        assert before.share <= after.share
    assert told[-1].share > 0.9


def test_the_command_line_shows_it(tmp_path: Path, hwsw: Hwsw, monkeypatch: pytest.MonkeyPatch) -> None:
    files = Ground(tmp_path).files(hidden=WALLED, limit="1000 h", patience="1 h", events=20_000)
    monkeypatch.setattr("codesign.cli.run._QUIET_SECONDS", 1e9)
    assert "longest drive" not in hwsw("run", *files, "--no-levers").stderr
    monkeypatch.setattr("codesign.cli.run._QUIET_SECONDS", 0.0)
    monkeypatch.setattr("codesign.cli.progress.SECONDS_BETWEEN_LINES", 0.0)
    done = hwsw("run", *files, "--set", "workload.scenario.events=50000", "--no-levers")
    lines = [line for line in done.stderr.splitlines() if "of the longest drive" in line]
    assert len(lines) >= 5
    assert re.match(r"9\d\d/1000 of the longest drive, [\d,]+ s simulated, [\d,]+ turns", lines[-1])
    assert not any("left" in line for line in lines)
    assert "longest drive" not in done.stdout
