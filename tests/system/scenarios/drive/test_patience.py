"""A robot that followed a plan and can go no farther: the mission ends once it has stood for as long as it may."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mission_specs import Ground, rectangle

from codesign.planners.breadth_first.plan.planner import BreadthFirst

OPEN = "\n".join(["." * 16] * 12)


def ended(tmp_path: Path, **settings: Any) -> tuple[str, float, float]:
    """Why and when, and for how long it drove."""
    wanted = {"text": OPEN, "start": (6, 1), "goals": [(6, 14)], "patience": "2 s"} | settings
    mission = Ground(tmp_path).run(**wanted).mission
    assert mission is not None
    assert not mission.reached
    return mission.ended, mission.mission_time_s, mission.driving_s


def test_walled_off_on_the_way(tmp_path: Path) -> None:
    far = {"components": {"robot": {"sensor": {"range": "5 m", "rays": 720}}}}
    wall = rectangle(0, 10, 12, 1, at="1 s")
    why, time, driven = ended(tmp_path, platform=far, obstacles={"appearing": [wall]})
    assert "the robot has stood for 2 s: no way leads from" in why
    assert 1.0 < driven < 3.0
    assert time == pytest.approx(driven + 2.0, abs=1.0)


def test_an_obstacle_that_it_cannot_see(tmp_path: Path) -> None:
    blind = {"components": {"robot": {"sensor": {"range": "0 m"}}}}
    why, time, driven = ended(tmp_path, platform=blind, hidden=[rectangle(0, 8, 12, 1)])
    assert why == "the robot has stood for 2 s: it stands against an obstacle at (6, 8) that it does not see"
    assert time < driven + 3.0


@pytest.mark.parametrize("point", [(1e18, 3.0), (1e300, 3.0), (-5.0, -5.0), (500.0, 500.0)])
def test_a_way_that_leaves_the_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, point: tuple[float, float]) -> None:
    monkeypatch.setattr(BreadthFirst, "path_from", lambda *given: (np.array([given[3], point]), True))
    why, time, driven = ended(tmp_path)
    assert "planner breadth_first failed: ValueError: its way leaves the map" in why
    assert (time, driven) == (pytest.approx(2.0, abs=0.2), 0.0)
