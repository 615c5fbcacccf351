"""Goals of a tour that are given at their times: the robot waits for them, and for nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from bag_missions import write_mission

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.records import GoalRecord, MissionRecord, PlanRecord, PoseRecord
from codesign.system.results.result import Result
from codesign.views.trace import MemoryListener

SECOND = 10**12


def drive(folder: Path, **scenario: Any) -> tuple[Result, MemoryListener]:
    platform, workload = write_mission(folder)
    tree = yaml.safe_load(workload.read_text())
    tree["scenario"].update(scenario)
    workload.write_text(yaml.safe_dump(tree))
    records = MemoryListener()
    return codesign.simulate(platform, workload, listeners=[records]), records


def test_the_robot_waits_at_a_goal_until_the_next_is_given(tmp_path: Path) -> None:
    free, unhindered = drive(tmp_path)
    result, records = drive(tmp_path, tour_times=["90 s", "1 s"], patience="5 s", replan={"trigger": "change"})
    assert result.mission is not None
    assert free.mission is not None
    assert result.mission.reached, result.mission.ended
    assert result.mission.goals_reached == 3
    reached = [record.time for record in records.of(MissionRecord) if record.event == "goal_reached"]
    given = [record.time for record in records.of(GoalRecord)]
    assert given[0] == 0
    assert reached[0] < 60 * SECOND
    # The next turn after the time; the last goal was given long before, so there is no wait.
    assert 90 * SECOND <= given[1] < 90.2 * SECOND
    assert given[2] == reached[1]
    waits = [pose for pose in records.of(PoseRecord) if reached[0] + 2 * SECOND < pose.time < given[1]]
    assert len({(pose.row, pose.column) for pose in waits}) == 1
    assert not [plan for plan in records.of(PlanRecord) if reached[0] + SECOND < plan.asked < given[1]]
    assert free.mission.mission_time_s < 90 < result.mission.mission_time_s
    assert [record.cells.tolist() for record in unhindered.of(GoalRecord)] == [
        record.cells.tolist() for record in records.of(GoalRecord)
    ]


def test_times_that_have_passed_change_nothing(tmp_path: Path) -> None:
    first, _ = drive(tmp_path)
    second, _ = drive(tmp_path, tour_times=["0 s", "0 s"])
    assert first.mission == second.mission


def test_each_goal_of_the_tour_has_a_time_or_none_has(tmp_path: Path) -> None:
    with pytest.raises(SpecError, match=r"scenario\.tour_times: 1 times for 2 goals of the tour"):
        drive(tmp_path, tour_times=["9 s"])
