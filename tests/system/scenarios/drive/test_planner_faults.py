"""A planner that fails, or gives what is no way: the drive ends in words, and its trace is whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mission_specs import Ground

import codesign
from codesign.ground.records import SummaryRecord
from codesign.planners.breadth_first.plan.planner import BreadthFirst
from codesign.views.trace import open_trace


def fails(*_: Any, **__: Any) -> Any:
    raise ValueError("boo")


WAYS: dict[str, Any] = {
    "none": lambda *_: None,
    "empty": lambda *_: (np.zeros((0, 2)), True),
    "not a number": lambda *_: (np.array([[1.0, 1.0], [np.nan, 2.0]]), True),
    "infinite": lambda *_: (np.array([[1.0, 1.0], [np.inf, 2.0]]), True),
    "flat": lambda *_: (np.array([1.0, 1.0]), True),
}


@pytest.mark.parametrize("name", ["path_from", "check"])
def test_a_planner_that_raises(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    ground = Ground(tmp_path)
    platform, workload = ground.point()
    # The workload itself is sound: it is the drive's own problems that the planner fails at.
    calls = []
    sound = getattr(BreadthFirst, name)

    def later(self: Any, *given: Any) -> Any:
        calls.append(given)
        return fails() if name == "path_from" or len(calls) > 1 else sound(self, *given)

    monkeypatch.setattr(BreadthFirst, name, later)
    file = tmp_path / "run.mcap"
    result = codesign.simulate(platform, workload, trace=file)
    assert result.mission is not None
    assert not result.mission.reached
    assert "planner breadth_first failed: ValueError: boo" in result.mission.ended
    (summary,) = [record for record in open_trace(file).records() if isinstance(record, SummaryRecord)]
    assert {**summary.result, "provenance": None} == {**result.model_dump(mode="json"), "provenance": None}


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS.keys())
def test_what_is_no_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, way: Any) -> None:
    platform, workload = Ground(tmp_path).point()
    monkeypatch.setattr(BreadthFirst, "path_from", lambda _self, *given: way(*given))
    mission = codesign.simulate(platform, workload).mission
    assert mission is not None
    assert not mission.reached
    assert "planner breadth_first failed: " in mission.ended
    assert mission.distance_m == 0.0
