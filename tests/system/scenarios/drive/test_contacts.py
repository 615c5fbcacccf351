"""What a mission says of contacts, and of obstacles that waited for the robot: in its result, tables and trace."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from mission_specs import SECOND, Ground, rectangle

from codesign.ground.records import MissionRecord, Record
from codesign.system.results.mission import CONTACT_POINTS, ContactPoint, Mission
from codesign.system.scenarios.drive.mission import drive
from codesign.system.scenarios.drive.scenario import mission_of
from codesign.views.report.scenario_tables import mission_tables
from codesign.views.trace.moment import row_of

OPEN = "\n".join(["." * 16] * 16) + "\n"
BLIND: dict[str, Any] = {"components": {"robot": {"sensor": {"range": "0 m"}}}}
AHEAD: dict[str, Any] = {"text": OPEN, "start": (5, 1), "goals": [(5, 10)]}


def told(records: list[Record], event: str) -> list[MissionRecord]:
    return [one for one in records if isinstance(one, MissionRecord) and one.event == event]


def test_a_contact_is_in_the_result_its_table_and_the_trace(tmp_path: Path) -> None:
    result, records = Ground(tmp_path).watched(**AHEAD, platform=BLIND, hidden=[rectangle(0, 5, 16, 1)], patience="2 s")
    mission = result.mission
    assert mission is not None
    [point] = mission.contact_points
    assert (point.row, point.column) == (pytest.approx(5.0), pytest.approx(4.5, abs=1e-5))
    # From rest, 0.35 m at 0.5 m/s² lead to no more than 0.5 m/s.
    assert point.speed_m_s == pytest.approx(0.5)
    assert 0.0 < point.time_s < mission.mission_time_s
    [event] = told(records, "contact")
    assert event.time == round(point.time_s * SECOND)
    assert event.text == "ran against (5, 5) at (5.000, 4.500), 0.5 m/s"
    [row] = [row for row in map(row_of, records) if row.what == "contact"]
    assert (row.begin, row.source, row.details) == (event.time, "robot", event.text)
    [table] = [table for table in mission_tables(result) if table.title == "Contacts"]
    assert [cell.value for cell in table.rows[0]] == [*point.model_dump().values()]


def test_a_contact_shortly_before_the_end_is_told_before_it(tmp_path: Path) -> None:
    """The robot is brought up to date by the end itself."""
    _, records = Ground(tmp_path).watched(
        **AHEAD, platform=BLIND, hidden=[rectangle(0, 5, 16, 1)], control_period="10 s", limit="19 s"
    )
    mission = [one for one in records if isinstance(one, MissionRecord)]
    assert [one.event for one in mission][-2:] == ["contact", "ended"]
    assert mission[-2].time < mission[-1].time


def test_a_result_counts_all_contacts_and_lists_the_first(tmp_path: Path) -> None:
    machine = Ground(tmp_path).machine(**AHEAD, platform=BLIND, hidden=[rectangle(0, 5, 16, 1)], patience="2 s")
    done = drive(machine)
    [contact] = done.scene.robot.contacts
    done.scene.robot.contacts.extend([contact] * 2 * CONTACT_POINTS)
    mission = mission_of(machine, done, {})
    assert mission.contacts == 2 * CONTACT_POINTS + 1
    assert len(mission.contact_points) == CONTACT_POINTS
    assert isinstance(mission.contact_points[0], ContactPoint)


@pytest.mark.parametrize("at", [0, 1])
def test_obstacles_that_wait_for_the_robot_are_counted_and_told(tmp_path: Path, at: int) -> None:
    """One that would appear around the robot, and one whose route leads through its start."""
    obstacles = {
        "appearing": [rectangle(4, 0, 3, 3, at=f"{at} ms")],
        "moving": [{"size": [1, 1], "route": [[5, 1], [9, 1]], "speed": "0.1 m/s"}],
    }
    result, records = Ground(tmp_path).watched(**AHEAD, obstacles=obstacles)
    mission: Mission | None = result.mission
    assert mission is not None
    assert mission.reached
    waits = told(records, "obstacle_waits")
    assert mission.deferred_obstacles == len(waits) >= 2
    first = {record.text: record.time for record in reversed(waits)}
    assert first == {
        "obstacles.appearing[0] waits until the robot has left its place": at * SECOND // 1000,
        "obstacles.moving[0] waits until the robot has left its place": 0,
    }
