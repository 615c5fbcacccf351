"""Records of a run reduced to what a page shows over time."""

from __future__ import annotations

import base64
import json
import random
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from page_data import Page, column
from report_samples import a_result
from runs_over_time import COLUMNS, CORNER, ROWS, SECOND, a_drive, a_fleet, a_map, a_plan

from codesign.ground.records import (
    BeliefRecord,
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    RobotRecord,
    TrajectoryRecord,
)
from codesign.views.report.page import Columns
from codesign.views.report.result_page import (
    MOST_EVENTS,
    MOST_TICKS,
    result_html,
    robots_table,
    scrub_data,
    scrub_part,
    tick_of,
)
from codesign.views.report.scrub import Cells, Changes, scrub_of
from codesign.views.trace.moment import moment


def data_of_run(records: list[Record]) -> dict[str, Any]:
    scrub = scrub_of(records)
    assert scrub is not None
    data = json.loads(json.dumps(scrub_data(scrub)))
    return {**data, "columns": data["packed"], "width": data["columns"]}


def grids_at(data: dict[str, Any], tick: int) -> tuple[Any, Any]:
    """The true map and the belief at a tick, as the script of the page makes them."""
    free, belief = column(data, data["free"]).astype(bool), column(data, data["believed"]).copy()
    time, cell, kind = (column(data, data["changes"][name]) for name in ("time", "cell", "kind"))
    for place, what in zip(cell[time <= tick], kind[time <= tick], strict=True):
        if what < 2:
            free[place] = what == 1
        else:
            belief[place] = {2: 1, 3: 0, 4: 2}[int(what)]
    shape = data["rows"], data["width"]
    return free.reshape(shape), belief.reshape(shape)


@pytest.mark.parametrize("seed", range(5))
def test_map_and_belief_at_any_time_are_those_of_a_moment(seed: int) -> None:
    records = a_drive(seed)
    data = data_of_run(records)
    for _ in range(20):
        tick = random.Random(seed).randrange(data["end"] + 1)
        # All that happens within the tick counts.
        seen = moment(records, (tick + 1) * data["tick"] - 1)
        free, belief = grids_at(data, tick)
        assert (free == seen.free).all()
        assert (belief == seen.belief).all()


def test_a_robot_with_a_map_believes_it_but_for_what_is_hidden() -> None:
    start, robot, *rest = a_drive()
    assert isinstance(start, MapRecord)
    assert isinstance(robot, RobotRecord)
    hidden = np.argwhere(~start.free)[:4].astype(np.int32) + np.array(CORNER, np.int32)
    unknown = np.zeros_like(start.free)
    unknown[0] = True
    records = [replace(start, unknown=unknown), replace(robot, knows=True, hidden=hidden[2:]), *rest]
    _, belief = grids_at(data_of_run(records), -1)
    expected = np.where(start.free, 0, 2)
    expected[0] = 1
    rows, columns = (hidden[2:] - CORNER).T
    expected[rows, columns] = 0
    assert (belief == expected).all()


def test_places_are_kept_to_a_part_of_a_cell_and_times_to_a_tick() -> None:
    records = a_drive()
    data = data_of_run(records)
    poses = [record for record in records if isinstance(record, PoseRecord)]
    (robot,) = data["robots"]
    assert column(data, robot["row"]) / 64 == pytest.approx([pose.row for pose in poses], abs=1 / 128)
    assert column(data, robot["column"]) / 64 == pytest.approx([pose.column for pose in poses], abs=1 / 128)
    assert column(data, robot["time"]).tolist() == [pose.time // data["tick"] for pose in poses]
    turns = column(data, robot["heading"]) / 128 * np.pi
    off = np.angle(np.exp(1j * (turns - [pose.heading for pose in poses])))
    assert np.abs(off).max() <= np.pi / 256 + 1e-9
    assert data["end"] <= MOST_TICKS
    assert data["end"] * data["tick"] == 20 * SECOND
    assert robot["radius"] == pytest.approx(0.75)


@pytest.mark.parametrize("end", [1, 999, 10**6, 4 * 10**6, 4 * 10**6 + 1, 10**12, 36_000 * 10**12])
def test_a_tick_is_the_least_power_of_ten(end: int) -> None:
    tick = tick_of(end)
    assert end // tick <= MOST_TICKS
    assert tick == 1 or end // (tick // 10) > MOST_TICKS
    assert set(str(tick)) <= {"1", "0"}


def test_steps_are_read_back_as_they_were() -> None:
    drawn = random.Random(3)
    for size in (0, 1, 2, 500):
        for most in (1, 100, 70_000, 2**29):
            numbers = np.array([drawn.randint(-most, most) for _ in range(size)], np.int64)
            columns = Columns()
            entry = columns.steps(numbers)
            assert column({"columns": columns.packed}, entry).tolist() == numbers.tolist()


def test_a_tile_of_a_large_map_is_blocked_where_any_cell_is() -> None:
    free = np.ones((1700, 900), bool)
    free[5, 7] = free[1699, 899] = False
    start = MapRecord(0, "map", free, np.zeros((0, 2), np.int32), None)
    cells = Cells(start)
    assert cells.tile == 3
    assert cells.free.shape == (567, 300)
    assert np.argwhere(~cells.free.astype(bool)).tolist() == [[1, 2], [566, 299]]
    one, other = (np.array([[row, 8]], np.int32) for row in (3, 4))
    cells.changed(ObstacleRecord(1, "map", np.concatenate([one, other]), True))
    cells.changed(ObstacleRecord(2, "map", one, False))
    cells.changed(ObstacleRecord(3, "map", np.array([[5, 7], [4, 8]], np.int32), False))
    changes = cells.changes
    assert changes.times.tolist() == [1, 2, 3]
    assert (changes.cells == 1 * 300 + 2).all()
    # Of the tile the cells (5, 7), (3, 8) and (4, 8) were blocked; it is free with the last of them.
    assert changes.kinds.tolist() == [0, 0, 1]


def test_of_too_many_changes_the_last_in_each_span_stay() -> None:
    drawn = np.random.default_rng(1)
    count, end = 900_000, 10**6
    times = np.sort(drawn.integers(0, end, count))
    cells, kinds = drawn.integers(0, 50, count), drawn.integers(0, 5, count).astype(np.uint8)
    few = Changes(times, cells, kinds).coarsened(end)
    assert len(few.times) < count
    assert (np.diff(few.times) >= 0).all()
    for cell in range(50):
        for layer in (True, False):
            last = kinds[(cells == cell) & ((kinds >= 2) == layer)][-1]
            assert few.kinds[(few.cells == cell) & ((few.kinds >= 2) == layer)][-1] == last
    assert Changes(times[:9], cells[:9], kinds[:9]).coarsened(end).cells.tolist() == cells[:9].tolist()


def test_a_plan_shows_its_stages_in_levels() -> None:
    data = data_of_run(a_plan())
    levels = column(data, data["fields"]["levels"]).reshape(5, ROWS, COLUMNS)
    free = a_map().free
    assert data["fields"]["stage"] == [0, 1, 2, 3, 4]
    assert (data["fields"]["low"], data["fields"]["high"]) == (-39.0, 0.0)
    for stage, level in enumerate(levels):
        assert (level[~free] == 0).all()
        assert (level[:, 8 * (stage + 1) :] == 0).all()
        assert (level[:, : 8 * (stage + 1)][free[:, : 8 * (stage + 1)]] > 0).all()
    assert levels[4][:, 0].max() == 255
    assert levels[4][:, 39].max() == 1
    assert data["paths"]["time"] == [data["end"]]
    assert data["believed"] is None


def test_nothing_is_shown_where_nothing_moves() -> None:
    assert scrub_of([]) is None
    assert scrub_of([a_map()]) is None
    assert scrub_of(a_plan(1)) is None
    assert scrub_of([record for record in a_drive() if not isinstance(record, MapRecord)]) is None


def test_the_table_of_a_fleet_has_the_worst_first() -> None:
    scrub = scrub_of(a_fleet(8))
    assert scrub is not None
    table = robots_table(scrub)
    names = [row[0].text for row in table.rows]
    assert names[0] == "7"
    assert table.rows[0][1].text == "–"
    arrived = [row[1].value for row in table.rows[1:]]
    assert all(isinstance(value, float) for value in arrived)
    assert arrived == sorted(arrived, key=lambda value: -float(value or 0))
    assert names[1] == "0"
    # It crossed the circle of 25 cells, 0.2 m each, on a straight line.
    assert table.rows[1][2].value == pytest.approx(10.0)
    assert table.rows[1][3].value == pytest.approx(1.0)
    # At the middle of the circle all of them meet.
    assert float(table.rows[1][5].value or 0) < 2.0


def test_a_fleet_counts_who_moves_and_a_drive_has_its_speed() -> None:
    fleet, drive = scrub_of(a_fleet(8)), scrub_of(a_drive())
    assert fleet is not None
    assert drive is not None
    moving = fleet.series[0]
    assert moving.name == "robots that move"
    assert (moving.values[0], moving.values[-1]) == (8, 1)
    names = [series.name for series in drive.series]
    assert names == ["speed", "fpga busy", "messages at bus"]
    assert drive.series[0].values.max() == pytest.approx(0.4)
    # Each task takes 20 of 100 ms; each message 40 of them, and there is one at a time.
    assert drive.series[1].values.mean() == pytest.approx(0.2, abs=0.01)
    assert set(drive.series[2].values.tolist()) <= {0.0, 1.0}


def test_of_too_many_events_requests_and_answers_of_plans_go_first() -> None:
    records = a_drive()
    more = [MissionRecord(SECOND + k, "robot", "plan_requested", "again") for k in range(2 * MOST_EVENTS)]
    scrub = scrub_of([*records, *more])
    assert scrub is not None
    part = scrub_part(scrub)
    assert len(part.events) == MOST_EVENTS
    assert part.events[-1].text == "ended: all goals are reached"
    assert "more events in a trace" in part.more


def test_records_that_no_run_writes_do_no_harm() -> None:
    nan, far = float("nan"), np.array([[10**6, -5], [-(10**6), 3], CORNER], np.int32)
    odd: list[Record] = [
        PoseRecord(5, "robot", nan, 1.0, 0.0, 0.0),
        PoseRecord(6, "robot", 1e300, 1e300, 7e5, 1e9),
        ObstacleRecord(7, "map", far, True),
        BeliefRecord(8, "robot", far, np.array([True, False, True])),
        TrajectoryRecord(9, "robot", np.array([[nan, 1.0]]), True),
        TrajectoryRecord(9, "robot", np.zeros((0, 2)), True),
        MissionRecord(0, "nobody", "</script>", "<!-- \u202e"),
    ]
    start, *rest = a_drive()
    data = data_of_run([start, *odd, *rest])
    assert len(column(data, data["robots"][0]["row"])) == 201
    free, belief = grids_at(data, 0)
    assert not free[0, 0]
    assert belief[0, 0] == 2
    assert scrub_of([start, PositionsRecord(0, "fleet", 0, np.full((3, 2), nan))]) is None


def test_the_page_of_a_run_holds_its_course_and_shows_what_users_wrote() -> None:
    evil = "<script>alert(1)</script>\"'&</style>]]><!--"
    html = result_html(a_result(), records=a_drive(name=evil, text=evil))
    page = Page(html)
    assert page.text.count(evil) >= 3
    assert len(page.scripts) == 2
    assert "<!--" not in html
    assert json.loads(page.scripts[0])["robots"][0]["name"] == evil
    assert "alert(1)" not in page.scripts[1]
    times = [attributes["data-at"] for tag, attributes in page.elements if "data-at" in attributes]
    assert len(times) == 11
    content = zlib.decompress(base64.b64decode(json.loads(page.scripts[0])["packed"]))
    assert len(content) > 1000


def test_a_page_without_a_course_is_as_before() -> None:
    page = Page(result_html(a_result()))
    assert not any(tag == "canvas" for tag, _ in page.elements)
    assert len(page.scripts) == 1
