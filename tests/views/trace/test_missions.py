"""Traces of missions as they run: whole however a mission ends, the same bytes each time, and true to the result."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

import codesign
from codesign.components.sensor import RaySensor
from codesign.ground.records import (
    BeliefRecord,
    MapRecord,
    MessageRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    Record,
    RobotRecord,
    ScanRecord,
)
from codesign.system.results.result import Result
from codesign.views.report import mission_timeline_picture, run_pictures
from codesign.views.report.canvas import with_palette
from codesign.views.trace import Trace, moment, open_trace

PLATFORM = """
kind: platform
name: board
components:
  fpga: {type: fpga, part: XC7A35T-1, clock: 100 MHz}
  host: {type: processor, clock: 1 GHz, costs: {occupancy_cell: 0 s, way_following: 0 s}, power: {busy: 4 W, idle: 2 W}}
  robot:
    type: robot
    radius: 0 m
    kinematics: {type: point, speed: 0.5 m/s}
    sensor: {type: rays, range: 2 m, rays: 90}
    power: {moving: 10 W, standing: 3 W}
links:
  uart: {type: serial, between: [host, fpga], baud: 2000000, fifo_depth: 512}
  body:
    type: serial
    between: [host, robot]
    baud: 460800
    fifo_depth: 64
    errors: {drop: 0.05, retries: 2, timeout: 2 ms, seed: 4}
"""

WORKLOAD = """
kind: workload
name: rooms
planner: breadth_first
problem:
  map: {generate: rooms, rows: 24, columns: 32, room: [11, 15], door: 3, seed: 1, extra_doors: 1.0}
  goals: [[20, 28]]
  starts: [[3, 3]]
scenario:
  type: drive
  known: none
  resolution: 0.1 m
  control_period: 100 ms
  patience: 2 s
  limit: LIMIT
  obstacles:
    appearing: [{at: 1 s, row: 0, column: 6, rows: 9, columns: 1, until: 4 s}, APPEARING]
mapping:
  search: {component: fpga, style: state_machine, micro_architecture: three_cycles, memory: block_ram, display: none}
"""

ENDINGS = {
    "reached": ("5 min", "{at: 2 s, row: 1, column: 1}"),
    "out of time": ("2 s", "{at: 2 s, row: 1, column: 1}"),
    # The goal is walled in for good, far from the robot.
    "blocked": (
        "5 min",
        "{at: 500 ms, row: 15, column: 21, rows: 9, columns: 1}, {at: 500 ms, row: 15, column: 21, columns: 11}",
    ),
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Result, list[Record]]]:
    """The trace, the result and the records of a mission for each way to end."""
    folder = tmp_path_factory.mktemp("missions")
    (folder / "board.yaml").write_text(PLATFORM, encoding="utf-8")
    found = {}
    for name, (limit, appearing) in ENDINGS.items():
        text = WORKLOAD.replace("LIMIT", limit).replace("APPEARING", appearing)
        (folder / "rooms.yaml").write_text(text, encoding="utf-8")
        point = codesign.load_platform(folder / "board.yaml"), codesign.load_workload(folder / "rooms.yaml")
        path, records = folder / f"{name}.mcap", list[Record]()
        result = codesign.simulate(*point, trace=path, listeners=[records.append])
        found[name] = path, result, records
        for again in ("run_ahead", "visit"):
            codesign.simulate(*point, trace=folder / f"{name}-{again}.mcap", granularity=again)
    return found


def whole(path: Path) -> Trace:
    trace = open_trace(path)
    assert trace.complete
    return trace


@pytest.mark.parametrize("name", ENDINGS)
def test_a_trace_is_whole_however_the_mission_ends(
    runs: dict[str, tuple[Path, Result, list[Record]]], name: str
) -> None:
    from mcap.reader import make_reader

    path, result, records = runs[name]
    assert result.mission is not None
    assert result.mission.reached == (name == "reached")
    trace = whole(path)
    # What identifies the run stands in a record of its own.
    assert trace.result == result.model_copy(update={"provenance": None}).model_dump(mode="json")
    assert trace.record_messages == len(records)
    events = [record for record in trace.records(kinds=[MissionRecord]) if isinstance(record, MissionRecord)]
    assert (events[-1].event, events[-1].text) == ("ended", result.mission.ended)
    assert events[-1].time == round(result.mission.mission_time_s * 1e12)
    # By the index of the file, as viewers read it.
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == trace.messages
        last = [message.log_time for _, _, message in reader.iter_messages(topics=["/mission"])][-1]
    assert last == events[-1].time // 1000


@pytest.mark.parametrize("name", ENDINGS)
def test_the_same_mission_gives_the_same_bytes_at_any_granularity(
    runs: dict[str, tuple[Path, Result, list[Record]]], name: str
) -> None:
    path = runs[name][0]
    for again in ("run_ahead", "visit"):
        assert path.with_name(f"{name}-{again}.mcap").read_bytes() == path.read_bytes()


@pytest.mark.parametrize("name", ENDINGS)
def test_a_robot_is_never_where_its_trace_has_an_obstacle(
    runs: dict[str, tuple[Path, Result, list[Record]]], name: str
) -> None:
    free = np.zeros((0, 0), bool)
    poses = 0
    for record in whole(runs[name][0]).records(kinds=[MapRecord, ObstacleRecord, PoseRecord]):
        if isinstance(record, MapRecord):
            free = record.free.copy()
        elif isinstance(record, ObstacleRecord):
            free[record.cells[:, 0], record.cells[:, 1]] = not record.appeared
        elif isinstance(record, PoseRecord):
            poses += 1
            assert free[int(np.floor(record.row + 0.5)), int(np.floor(record.column + 0.5))]
    assert poses > 5


@pytest.mark.parametrize("name", ENDINGS)
def test_the_trace_tells_what_the_result_counts(runs: dict[str, tuple[Path, Result, list[Record]]], name: str) -> None:
    path, result, _ = runs[name]
    mission, links = result.mission, result.links
    assert mission is not None
    assert links is not None
    trace = whole(path)
    messages = [record for record in trace.records(kinds=[MessageRecord]) if isinstance(record, MessageRecord)]
    for link, use in links.items():
        mine = [message for message in messages if message.source == link]
        assert sum(message.outcome == "delivered" for message in mine) == use.delivered
        assert sum(message.outcome == "dropped" for message in mine) == sum(use.dropped.values())
        assert sum(message.attempts - 1 for message in mine) == use.retransmissions
        assert sum(message.bits for message in mine if message.outcome == "delivered") == use.bits
    events = [record for record in trace.records(kinds=[MissionRecord]) if isinstance(record, MissionRecord)]
    counted = {
        event: sum(one.event == event for one in events) for event in ("contact", "safety_stop", "deadline_missed")
    }
    assert counted == {
        "contact": mission.contacts,
        "safety_stop": mission.safety_stops,
        "deadline_missed": mission.missed_deadlines,
    }


def test_what_the_robot_knows_at_the_end_is_what_the_result_says(
    runs: dict[str, tuple[Path, Result, list[Record]]],
) -> None:
    _, result, records = runs["reached"]
    assert result.mission is not None
    seen = moment(records)
    assert seen.belief is not None
    assert (seen.belief != 1).mean() == pytest.approx(result.mission.known_share)
    assert any(isinstance(record, BeliefRecord) for record in records)


def test_a_scan_is_recorded_each_five_seconds(runs: dict[str, tuple[Path, Result, list[Record]]]) -> None:
    """Its ranges are those of the rays on the true map, where the robot was at that time."""
    path, _, records = runs["out of time"]
    scans = [each for each in runs["reached"][2] if isinstance(each, ScanRecord)]
    assert len(scans) >= 2
    assert {later.time - one.time for one, later in itertools.pairwise(scans)} == {5 * 10**12}
    (start,) = [each for each in records if isinstance(each, MapRecord)]
    (robot,) = [each for each in records if isinstance(each, RobotRecord)]
    (scan,) = [each for each in records if isinstance(each, ScanRecord)]
    assert start.resolution is not None
    sensor = RaySensor(robot.reach / start.resolution, robot.rays)
    ranges = sensor.ranges(start.free, (scan.row, scan.column))
    assert len(scan.ranges) == robot.rays == 90
    assert np.array_equal(np.isinf(scan.ranges), np.isinf(ranges))
    assert np.isfinite(ranges).any()
    met = np.isfinite(ranges)
    assert np.abs(scan.ranges[met] - ranges[met]).max() <= 1 / 128
    lasers = [each for each in open_trace(path).channels if each.topic == "/robot/laser"]
    assert [(each.schema, each.messages) for each in lasers] == [("foxglove.LaserScan", 1)]


def test_a_level_without_scans_makes_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        pytest.fail("a scan was made")

    monkeypatch.setattr(RaySensor, "ranges", refused)
    (tmp_path / "board.yaml").write_text(PLATFORM, encoding="utf-8")
    limit, appearing = ENDINGS["out of time"]
    text = WORKLOAD.replace("LIMIT", limit).replace("APPEARING", appearing)
    (tmp_path / "rooms.yaml").write_text(text, encoding="utf-8")
    point = codesign.load_platform(tmp_path / "board.yaml"), codesign.load_workload(tmp_path / "rooms.yaml")
    codesign.simulate(*point)
    codesign.simulate(*point, trace=tmp_path / "run.mcap", trace_level="mission")
    assert not list(open_trace(tmp_path / "run.mcap").records(kinds=[ScanRecord]))


@pytest.mark.parametrize("name", ENDINGS)
def test_every_mission_has_its_pictures(runs: dict[str, tuple[Path, Result, list[Record]]], name: str) -> None:
    records = runs[name][2]
    drive, busy = run_pictures(records)
    assert drive.title == "Where the robot drove"
    assert "robot" in busy.alt
    whole = mission_timeline_picture(records)
    assert whole is not None
    assert with_palette(whole) == busy
    assert len(busy.data) < len(whole.data)
