"""What a reader is told of a mission: its figures, where time and energy went, and pictures of the drive."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_samples import LINKS, a_mission, a_mission_result, a_result

from codesign.ground.records import (
    FieldRecord,
    MapRecord,
    MessageRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    TaskRecord,
)
from codesign.system.results.mission import ContactPoint
from codesign.views.report import (
    account_picture,
    drive_picture,
    mission_timeline_picture,
    moment_picture,
    render_text,
    result_tables,
    run_pictures,
)
from codesign.views.report.pictures import busy_shares
from codesign.views.report.result_page import result_html
from codesign.views.report.scenario_tables import (
    account_table,
    contacts_table,
    energy_table,
    links_table,
    mission_table,
)
from codesign.views.report.sentences import mission_headline
from codesign.views.report.wording import Table

SECOND = 10**12
FREE = np.ones((12, 30), dtype=bool)
FREE[5, :20] = False


def a_drive(**ended: str) -> list[Record]:
    """Round the wall to the goal in 50 s, with an obstacle, a contact and two plans."""
    way = [(9.0, 2.0), (9.0, 25.0), (2.0, 25.0), (2.0, 3.0)]
    records: list[Record] = [
        MapRecord(0, "map", FREE, np.array([[2, 3]], np.int32), 0.1),
        MissionRecord(0, "robot", "plan_requested", "the first"),
        TaskRecord(0, "fpga", "relax", SECOND, 100),
        MissionRecord(SECOND, "robot", "plan_ready", "after 1 s"),
        MessageRecord(SECOND, "uart", "fpga", "host", "direction", 64, 2 * SECOND, 3 * SECOND),
    ]
    records += [PoseRecord((index + 1) * 10 * SECOND, "robot", *point, 0.0, 0.5) for index, point in enumerate(way)]
    records += [
        ObstacleRecord(15 * SECOND, "world", np.array([[9, 28], [10, 28]], np.int32), True),
        ObstacleRecord(16 * SECOND, "world", np.array([[9, 28]], np.int32), False),
        MissionRecord(15 * SECOND, "robot", "contact", "an obstacle came"),
        MissionRecord(40 * SECOND, "robot", "goal_reached", "goal 1"),
        MissionRecord(50 * SECOND, "robot", "ended", "reached"),
    ]
    return records


def values(table: Table) -> dict[str, object]:
    return {str(row[0].value): row[1].value for row in table.rows}


def test_the_figures_of_a_mission_stand_in_its_table_with_plain_values() -> None:
    told = values(mission_table(a_mission()))
    assert told["ended"] == "reached"
    assert told["mission time"] == 100.0
    assert told["distance over the shortest"] == 1.2
    assert told["replan latency, 95th percentile"] == 0.2
    assert told["missed deadlines"] == 2
    assert told["what sets the pace"] == "uart (transfer, 80 %): a faster line would help"
    unknown = values(mission_table(a_mission(replan_latency_median_s=None, shortest_m=None, bottleneck=None)))
    assert unknown["replan latency, median"] is None
    assert "what sets the pace" not in unknown


def test_every_number_of_a_mission_is_told() -> None:
    """A figure that the model gains must be shown, or be left out here on purpose."""
    told = {name: 1000 + number for number, name in enumerate(type(a_mission()).model_fields)}
    no_numbers = {"ended", "reached", "energy", "account", "latency", "control", "bottleneck", "levers"}
    # Contacts have a table of their own, and a share is none of 1000.
    numbers = {
        name: float(value) for name, value in told.items() if name not in no_numbers | {"contact_points", "known_share"}
    }
    shown = {cell.value for row in mission_table(a_mission(**numbers)).rows for cell in row}
    assert set(numbers.values()) <= shown


def test_more_contacts_than_are_shown_are_counted() -> None:
    points = tuple(ContactPoint(time_s=number, row=number + 0.5, column=2.0, speed_m_s=0.1) for number in range(100))
    table = contacts_table(a_mission(contacts=130, contact_points=points))
    assert [row[0].value for row in table.rows] == [*range(20)]
    assert [cell.text for cell in table.rows[1]] == ["1 s", "1.500", "2.000", "0.1 m/s"]
    assert table.notes == ("the first 20; 110 contacts more",)
    assert not contacts_table(a_mission(contacts=2, contact_points=points[:2])).notes


def test_energy_adds_up_and_shows_only_what_took_any() -> None:
    table = energy_table("Energy", a_mission().energy)
    *lines, total = ([cell.value for cell in row] for row in table.rows)
    assert [line[0] for line in lines] == ["FPGAs", "processors", "links", "robot"]
    assert sum(float(line[1]) for line in lines) == total[1] == 2000.0
    assert sum(float(line[2]) for line in lines) == pytest.approx(1.0)


def test_energy_of_what_declares_no_power_is_told_as_not_declared() -> None:
    energy = a_mission().energy
    missing = {"links": ("wire", "radio"), "memories": ("sram",)}
    table = energy_table("Energy", energy.model_copy(update={"not_declared": missing}))
    told = {row[0].text: row[1].text for row in table.rows}
    assert energy.links_j > 0.0, "some links declare theirs"
    assert told["memories"] == "not declared"
    assert told["links"] != "not declared"
    assert table.notes == (
        "links whose power is not declared count as 0 J: wire, radio",
        "memories whose power is not declared count as 0 J: sram",
    )
    nothing = energy.model_copy(update={"links_j": 0.0, "not_declared": {"links": ("wire",)}})
    assert {row[0].text: row[1].text for row in energy_table("Energy", nothing).rows}["links"] == "not declared"
    assert not energy_table("Energy", energy).notes
    plan = a_result()
    assert plan.energy is not None
    plan = plan.model_copy(update={"energy": plan.energy.model_copy(update={"not_declared": missing})})
    of_plan = next(table for table in result_tables(plan) if table.title == "Energy of the run")
    told = {row[0].text: row[1].text for row in of_plan.rows}
    assert told["links"] == told["memories"] == "not declared"
    assert of_plan.notes == table.notes


def test_the_account_gives_the_busy_share_of_the_mission() -> None:
    table = account_table(a_mission().account)
    assert [[cell.value for cell in row] for row in table.rows] == [
        ["host", 2.0, 0.0, 0.5, 98.0, 0.02],
        ["fpga", 1.0, 0.0, 0.0, 99.0, 0.01],
        ["uart", 0.0, 40.0, 12.0, 60.0, 0.4],
    ]


def test_messages_that_were_sent_are_all_accounted_for_with_reasons() -> None:
    table = links_table(LINKS)
    (row,) = ([cell.value for cell in row] for row in table.rows)
    names = [column.name for column in table.columns]
    told = dict(zip(names, row, strict=True))
    assert told["sent"] == told["delivered"] + told["dropped"] + told["in flight"]  # type: ignore[operator]
    assert table.notes == ("uart: 7 messages dropped: link down", "uart: 2 messages dropped: damaged after 4 attempts")


def test_a_result_shows_its_mission_and_a_plan_alone_none() -> None:
    titles = [table.title for table in result_tables(a_mission_result())]
    mine = [
        "Mission",
        "Where the time of plans went",
        "Where the time of control turns went",
        "Energy of the mission",
        "Where each task runs",
        "Where the time of each component and link went",
        "Messages on links",
    ]
    assert [title for title in titles if title in mine] == mine
    assert titles.index("Mission") == 1
    assert not set(mine) & {table.title for table in result_tables(a_result())}
    assert all("reached" in render_text(table) for table in result_tables(a_mission_result())[1:2])


def test_the_first_rows_of_a_mission_say_how_it_ended() -> None:
    result = a_mission_result(mission=a_mission(reached=False, ended="walled in"))
    first = result_tables(result)[0]
    assert [row[1].value for row in first.rows[:2]] == ["walled in", False]
    assert first.rows[:2] == mission_table(a_mission(reached=False, ended="walled in")).rows[:2]
    assert result_tables(a_result())[0].rows[0][0].text == "platform"


def test_the_headline_of_a_failed_mission_says_so() -> None:
    told = mission_headline(a_mission(reached=False, ended="walled in", contacts=1))
    assert told[0] == ("not reached", "")
    assert ("1", "contact") in told
    assert ("2", "missed deadlines") in told


def test_the_page_of_a_mission_says_why_it_ended_and_what_sets_the_pace() -> None:
    evil = "<script>alert(1)</script>"
    html = result_html(a_mission_result(mission=a_mission(ended=evil)), pictures=run_pictures(a_drive()))
    assert evil not in html
    assert "&lt;script&gt;alert(1)" in html
    assert "What sets the pace:" in html
    # The drive, the time line and the account.
    assert html.count("data:image/png;base64,") == 3
    assert "What sets the pace:</b> planning on fpga takes 91 % of the time" in result_html(a_result())
    assert "What sets the pace" not in result_html(a_result(slices=67_584))


def test_a_drive_is_shown_with_what_happened_where() -> None:
    drive, busy = run_pictures(a_drive())
    assert drive.alt == (
        "Map of 12 by 30 cells: 1 robot, 52 cells driven, new plan asked for: 1, contact: 1, goal reached: 1"
    )
    assert busy.alt == "Time line of fpga, robot, uart over 50 s, 5 events; the busiest is robot"
    assert drive.data == run_pictures(a_drive())[0].data
    assert drive.data != run_pictures(a_drive()[:-3])[0].data


def test_pictures_are_vectors_where_asked_for() -> None:
    for draw in (drive_picture, mission_timeline_picture):
        picture = draw(a_drive(), format="svg")
        assert picture is not None
        assert ElementTree.fromstring(picture.data).tag.endswith("svg")


def test_a_contact_is_marked_where_the_robot_was_by_then() -> None:
    """At 15 s the robot is half way from (9, 2), where it was at 10 s, to (9, 25), where it is at 20 s."""
    picture = drive_picture(a_drive(), format="svg")
    assert picture is not None
    moved = [
        PoseRecord(record.time, "robot", record.row, 24.0, 0.0, 0.5)
        if isinstance(record, PoseRecord) and record.time == 20 * SECOND
        else record
        for record in a_drive()
    ]
    other = drive_picture(moved, format="svg")
    assert other is not None
    assert contact_place(picture.data) > contact_place(other.data)


def contact_place(svg: bytes) -> float:
    """Where the only marker in the colour of contacts stands, from the left."""
    for group in ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}use"):
        if "fill: #d7191c" in group.get("style", ""):
            return float(group.get("x", "nan"))
    raise AssertionError("no contact drawn")


def test_a_fleet_is_shown_as_the_tracks_of_its_robots() -> None:
    free = np.ones((20, 20), bool)
    records: list[Record] = [MapRecord(0, "map", free, np.zeros((0, 2), np.int32), None)]
    for update in range(5):
        positions = np.array([[update, update], [update, 19.0 - update]], np.float64)
        records.append(PositionsRecord(update * SECOND, "fleet", update, positions))
    picture = drive_picture(records)
    assert picture is not None
    assert picture.title == "Where the robots drove"
    assert "2 robots, 11.31 cells driven" in picture.alt


def test_what_no_robot_told_is_not_drawn() -> None:
    assert drive_picture([]) is None
    assert drive_picture(a_drive()[:2]) is None
    assert mission_timeline_picture(a_drive()[:1]) is None
    assert account_picture({}) is None


def test_a_moment_is_drawn_with_what_is_not_known() -> None:
    came = FREE.copy()
    came[9, 9:12] = False
    goals = np.array([[2, 3]], np.int32)
    whole = moment_picture(12 * SECOND, FREE, came, goals=goals, driven=np.array([[9.0, 2.0], [9.0, 5.0]]))
    assert whole.alt == "Map of 12 by 30 cells: 3 cells blocked since the start"
    assert whole.title == "The mission at 12 s"
    unknown = moment_picture(12 * SECOND, FREE, came, goals=goals, unknown=~FREE)
    assert unknown.data != whole.data


def test_a_field_that_is_no_potential_is_shown_as_it_is() -> None:
    distance = np.where(FREE, np.arange(360.0).reshape(12, 30), np.inf)
    (picture,) = run_pictures([a_drive()[0], FieldRecord(5, "fpga", "distance", "cells", distance)])
    assert picture.title == "Map, and the field of distance"
    assert "the distance (cells) as colour" in picture.alt


spans = st.lists(st.tuples(st.integers(0, 90), st.integers(0, 40)), max_size=12)


@given(spans, st.integers(1, 30))
def test_busy_shares_are_what_counting_each_picosecond_gives(begins: list[tuple[int, int]], bins: int) -> None:
    found = [(begin, begin + length) for begin, length in begins]
    end = 120 * bins
    busy = np.zeros(end, bool)
    for begin, stop in found:
        busy[begin * bins : stop * bins] = True
    shares = busy_shares([(begin * bins, stop * bins) for begin, stop in found], end, bins)
    expected = np.diff(np.concatenate(([0], np.cumsum(busy)))[np.linspace(0, end, bins + 1).astype(int)]) / 120
    assert np.allclose(shares, expected)


def test_a_time_line_of_one_event_is_drawn(tmp_path: Path) -> None:
    records = [TaskRecord(0, "fpga", "relax", 10, 1), MissionRecord(10, "robot", "ended", "no way")]
    picture = mission_timeline_picture(records)
    assert picture is not None
    (tmp_path / "picture.png").write_bytes(picture.data)
