"""What viewers draw of a run: whole maps now and then, paths, obstacles, robots, events. They say what records say."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from trace_samples import a_mission, write

from codesign.ground.records import (
    BeliefRecord,
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    ScanRecord,
    StageRecord,
    TrajectoryRecord,
)
from codesign.views.trace import McapListener, open_trace
from codesign.views.trace.listeners import MOST_CUBES, MOST_SHOWN
from codesign.views.trace.shapes import WALL, coloured, floor_of

SECOND = 10**12
NO_GOALS = np.zeros((0, 2), np.int32)
OPEN = MapRecord(0, "map", np.ones((40, 40), bool), NO_GOALS, 0.5)


def read(path: Path) -> list[tuple[str, str, int, Any]]:
    """Topic, schema's name, log time (ns) and message of each message, in file order, by its embedded schema alone."""
    from google.protobuf.descriptor_pb2 import FileDescriptorSet
    from google.protobuf.descriptor_pool import DescriptorPool
    from google.protobuf.message_factory import GetMessageClass
    from mcap.reader import NonSeekingReader

    kinds: dict[str, Any] = {}
    messages = []
    with path.open("rb") as stream:
        reader = NonSeekingReader(stream, validate_crcs=True)
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None
            if schema.name not in kinds:
                pool = DescriptorPool()
                for file in FileDescriptorSet.FromString(schema.data).file:
                    pool.Add(file)
                kinds[schema.name] = GetMessageClass(pool.FindMessageTypeByName(schema.name))
            decoded = kinds[schema.name].FromString(message.data)
            messages.append((channel.topic, schema.name, message.log_time, decoded))
    return messages


def shown(folder: Path, records: list[Record], topic: str) -> list[Any]:
    """The messages of a topic."""
    return [each for name, _, _, each in read(write(folder / "run.mcap", records)) if name == topic]


def test_the_topics_of_a_mission(tmp_path: Path) -> None:
    messages = read(write(tmp_path / "mission.mcap", a_mission()))
    topics = {topic: name for topic, name, _, _ in messages}
    scenes = ("/goals", "/obstacles", "/path", "/trails", "/robots")
    grids = ("/map/", "/robot/", "/fpga/plan_")
    assert {topic: name for topic, name in topics.items() if name.startswith("foxglove")} == {
        **dict.fromkeys(scenes, "foxglove.SceneUpdate"),
        **dict.fromkeys((f"{scene}/points" for scene in scenes), "foxglove.PointCloud"),
        **{f"{grid}grid": "foxglove.Grid" for grid in grids},
        **{f"{grid}voxels": "foxglove.VoxelGrid" for grid in grids},
        "/tf": "foxglove.FrameTransforms",
        "/log": "foxglove.Log",
        "/robot/laser": "foxglove.LaserScan",
    }
    # Our messages and those for viewers share no topic.
    assert all(topics[topic] == name for topic, name, _, _ in messages)


@pytest.mark.parametrize("yaw", [0.0, 0.5])
def test_a_map_lies_at_its_own_origin_and_robots_on_it(tmp_path: Path, yaw: float) -> None:
    """A map_server map at (-10, -10): the grid, the robot, the path, goals and obstacles lie over it."""
    origin = np.array([-10.0, -10.0, yaw])
    free = np.ones((4, 6), bool)
    free[3, 0] = False
    run: list[Record] = [
        MapRecord(0, "map", free, np.array([[3, 1]], np.int32), 0.5, origin=origin),
        PoseRecord(5, "robot", 3.0, 1.0, np.pi / 2, 0.5),
        ObstacleRecord(6, "map", np.array([[3, 1]], np.int32), True),
        TrajectoryRecord(7, "robot", np.array([[3.0, 1.0]]), True),
    ]
    messages = {topic: each for topic, _, _, each in read(write(tmp_path / "run.mcap", run))}
    grid = messages["/map/grid"]
    assert (grid.pose.position.x, grid.pose.position.y) == (-10.0, -10.0)
    assert 2 * math.atan2(grid.pose.orientation.z, grid.pose.orientation.w) == pytest.approx(yaw)
    # The lowest row comes first, four bytes a cell.
    assert (grid.column_count, grid.row_stride, grid.cell_stride) == (6, 24, 4)
    assert [field.name for field in grid.fields] == ["red", "green", "blue", "alpha"]
    assert grid.data[:4] == coloured("true", np.array([[WALL]], np.uint8))
    place = (-10 + 0.75 * math.cos(yaw) - 0.25 * math.sin(yaw), -10 + 0.75 * math.sin(yaw) + 0.25 * math.cos(yaw))
    (transform,) = messages["/tf"].transforms
    assert (transform.parent_frame_id, transform.child_frame_id) == ("map", "robot")
    goal, cube = messages["/goals"].entities[0].spheres[0], messages["/obstacles"].entities[0].cubes[0]
    point = messages["/path"].entities[0].lines[0].points[0]
    for here in (transform.translation, goal.pose.position, cube.pose.position, point):
        assert (here.x, here.y) == pytest.approx(place, abs=3e-4)
    # A heading of a quarter turn, towards growing rows, looks down the map.
    turned = transform.rotation
    assert 2 * math.atan2(turned.z, turned.w) == pytest.approx(yaw - np.pi / 2, abs=1e-3)


def test_all_robots_of_a_fleet_point_where_they_drive(tmp_path: Path) -> None:
    """64 robots on a circle, each towards its middle, numbered, as discs of their radius."""
    angles = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    circle = np.column_stack([np.sin(angles), np.cos(angles)])
    run: list[Record] = [
        MapRecord(0, "map", np.ones((100, 100), bool), NO_GOALS, None, radius=5.0),
        *(PositionsRecord(n * SECOND, "fleet", n, 50 + (40 - n) * circle) for n in range(9)),
    ]
    messages = read(write(tmp_path / "run.mcap", run))
    last = [each for topic, _, _, each in messages if topic == "/tf"][-1]
    frames = [f"fleet/{number}" for number in range(64)]
    assert [each.child_frame_id for each in last.transforms] == frames
    headings = np.array([2 * math.atan2(each.rotation.z, each.rotation.w) for each in last.transforms])
    # Rows grow downwards: in frame `map` the robot at (row, column) looks to (+row, -column).
    expected = np.arctan2(circle[:, 0], -circle[:, 1])
    assert np.abs(np.angle(np.exp(1j * (headings - expected)))).max() < 2e-3
    (robots,) = [each for topic, _, _, each in messages if topic == "/robots"]
    assert [(each.frame_id, each.texts[0].text) for each in robots.entities] == [
        (frame, str(number)) for number, frame in enumerate(frames)
    ]
    assert {(each.cylinders[0].size.x, len(each.arrows)) for each in robots.entities} == {(10.0, 1)}
    trails = [each for topic, _, _, each in messages if topic == "/trails"][-1]
    assert len(trails.entities[0].lines) == 64


@pytest.mark.parametrize(("event", "level"), [("plan_ready", 2), ("contact", 3), ("safety_stop", 3), ("ended", 2)])
def test_events_are_lines_of_a_log(tmp_path: Path, event: str, level: int) -> None:
    (message,) = shown(tmp_path, [MissionRecord(0, "robot", event, "why")], "/log")
    assert (message.level, message.name) == (level, "robot")
    assert message.message == f"{event.replace('_', ' ')}: why"


def test_the_maps_shown_last_are_those_that_the_changes_add_up_to(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    shape = (20, 30)
    free = rng.random(shape) < 0.7
    walls, belief = ~free, np.full(shape, 1)
    run: list[Record] = [MapRecord(0, "map", free, NO_GOALS, 0.1)]
    for turn in range(300):
        cells = rng.integers((0, 0), shape, (3, 2)).astype(np.int32)
        appeared, blocked = bool(rng.random() < 0.5), rng.random(3) < 0.5
        cells, places = np.unique(cells, axis=0, return_index=True)
        run.append(ObstacleRecord(turn * SECOND // 10, "map", cells, appeared))
        run.append(BeliefRecord(turn * SECOND // 10, "robot", cells, blocked[places]))
        walls[tuple(cells.T)] = appeared
        belief[tuple(cells.T)] = 2 * blocked[places]
    run.append(MissionRecord(30 * SECOND, "robot", "ended", "reached"))
    messages = read(write(tmp_path / "run.mcap", run))
    states = np.select([walls & free, walls, ~free], [2, 1, 3], 0)
    for topic, kind, expected in (("/map/grid", "true", states), ("/robot/grid", "belief", belief)):
        grids = [(time, message) for where, _, time, message in messages if where == topic]
        assert grids[-1][1].data == coloured(kind, expected[::-1].astype(np.uint8))
        # One each second of 30, though there are ten changes a second.
        assert len(grids) == 31
        assert grids[-1][0] == 30 * 10**9
        voxels = [message for where, _, _, message in messages if where == topic.replace("grid", "voxels")]
        assert voxels[-1].data == grids[-1][1].data
        assert len(voxels) == 31
    came = [message for where, _, _, message in messages if where == "/obstacles/points"][-1]
    assert len(came.data) // came.point_stride == (walls & free).sum()


def test_large_maps_are_shown_seldom_and_coarsely(tmp_path: Path) -> None:
    """At most 72 us a cell: 4 million cells take 302 s from one to the next. A wall of one cell is not lost."""
    free = np.ones((2048, 2048), bool)
    free[:, 77] = False
    run: list[Record] = [MapRecord(0, "map", free, NO_GOALS, None)]
    cell, known = np.array([[5, 5]], np.int32), np.array([False])
    run += [BeliefRecord(time * SECOND, "robot", cell, known) for time in range(0, 600, 10)]
    messages = read(write(tmp_path / "run.mcap", run))
    times = [time // 10**9 for topic, _, time, _ in messages if topic == "/robot/grid"]
    assert times == [0, 310, 590]
    (grid,) = [message for topic, _, _, message in messages if topic == "/map/grid"]
    assert len(grid.data) // 4 <= MOST_SHOWN
    assert (grid.column_count, grid.cell_size.x) == (512, 4.0)
    colours = np.frombuffer(grid.data, np.uint32).reshape(512, 512)
    assert np.flatnonzero(colours[0] != colours[0, 0]).tolist() == [77 // 4]


def test_the_field_of_a_plan_is_shown_when_it_is_ready_and_seldom(tmp_path: Path) -> None:
    """Two stages a plan, a plan a second: 128 × 128 cells are shown each 1.2 s."""
    for side, times in ((16, [0, 1, 2, 3, 4, 5]), (128, [0, 2, 4, 5])):
        free = np.ones((side, side), bool)
        run: list[Record] = [MapRecord(0, "map", free, NO_GOALS, None)]
        for second in range(6):
            now = second * SECOND
            run.append(MissionRecord(now, "robot", "plan_requested", ""))
            for stage in (0, 1):
                field = np.full(free.shape, second + stage / 2)
                run.append(StageRecord(now, "fpga", now, stage, 7, 3, 50, 222, 1998, 4, field))
            run.append(MissionRecord(now, "robot", "plan_ready", ""))
        run.append(MissionRecord(5 * SECOND, "robot", "ended", "reached"))
        messages = read(write(tmp_path / "run.mcap", run))
        assert [time // 10**9 for topic, _, time, _ in messages if topic == "/fpga/plan_grid"] == times
        stages = [message for topic, _, _, message in messages if topic == "/fpga/stage"]
        assert len(stages) == 12
        assert all(list(stage.potential.shape) == [0, 0] for stage in stages)


def test_a_plan_without_a_mission_keeps_and_shows_its_fields(tmp_path: Path) -> None:
    field = np.array([[0.0, 1.0], [np.inf, 0.5]])
    run: list[Record] = [
        MapRecord(0, "map", np.ones((2, 2), bool), NO_GOALS, None),
        StageRecord(1, "fpga", 0, 0, 7, 3, 50, 222, 1998, 4, field),
    ]
    (grid,) = shown(tmp_path, run, "/fpga/plan_grid")
    colours = np.frombuffer(grid.data, np.uint8).reshape(2, 2, 4)[::-1]
    assert colours[..., 3].tolist() == [[255, 255], [0, 255]]
    assert colours[0, 0].tolist()[:3] == [68, 1, 84]
    assert colours[0, 1].tolist()[:3] == [253, 231, 37]
    (stage,) = open_trace(tmp_path / "run.mcap").records(kinds=[StageRecord])
    assert isinstance(stage, StageRecord)
    assert np.array_equal(stage.potential, field)


def test_each_message_has_all_obstacles_and_an_empty_one_clears(tmp_path: Path) -> None:
    """The second message shows what the first one did, too. Neighbours in a row are one bar."""
    first, second = np.array([[39, 0], [39, 1]], np.int32), np.array([[1, 2]], np.int32)
    both = np.concatenate([first, second])
    run: list[Record] = [
        OPEN,
        ObstacleRecord(SECOND, "map", first, True),
        ObstacleRecord(2 * SECOND, "map", second, True),
        ObstacleRecord(3 * SECOND, "map", both, False),
    ]
    scenes = [message.entities[0] for message in shown(tmp_path, run, "/obstacles")]
    bars = [[(cube.pose.position.x, cube.size.x) for cube in scene.cubes] for scene in scenes]
    assert bars == [[], [(0.5, 1.0)], [(1.25, 0.5), (0.5, 1.0)], []]
    assert {scene.id for scene in scenes} == {"obstacles"}
    clouds = shown(tmp_path, run, "/obstacles/points")
    assert [len(cloud.data) // cloud.point_stride for cloud in clouds] == [0, 2, 3, 0]


def test_many_obstacles_are_bounded(tmp_path: Path) -> None:
    cells = np.argwhere(np.indices((100, 100)).sum(axis=0) % 2 == 0).astype(np.int32)
    run: list[Record] = [
        MapRecord(0, "map", np.ones((100, 100), bool), NO_GOALS, None),
        *(ObstacleRecord(n * SECOND // 10, "map", cells[n : n + 4900], n % 2 == 0) for n in range(100)),
    ]
    scenes = [message.entities[0] for message in shown(tmp_path, run, "/obstacles")]
    assert max(len(scene.cubes) for scene in scenes) == MOST_CUBES
    # After one of 4,900 cells none is written for 49 s; here are 10 s.
    assert sum(len(scene.cubes) > 1000 for scene in scenes) <= 2


def test_paths_of_one_time_are_shown_side_by_side_and_a_new_one_takes_their_place(tmp_path: Path) -> None:
    points = np.array([[0.0, 0.0], [3.0, 3.0]])
    run: list[Record] = [
        OPEN,
        TrajectoryRecord(1, "robot", points, True),
        TrajectoryRecord(1, "robot", points + 1, True),
        TrajectoryRecord(2000, "robot", points, True),
        TrajectoryRecord(9000, "robot", np.zeros((0, 2)), False),
    ]
    messages = read(write(tmp_path / "run.mcap", run))
    scenes = [(time, message.entities[0]) for topic, _, time, message in messages if topic == "/path"]
    assert [(time, sum(len(line.points) for line in scene.lines)) for time, scene in scenes] == [
        (0, 0), (0, 4), (2, 2), (9, 0),
    ]  # fmt: skip
    first = scenes[2][1].lines[0].points[0]
    assert (first.x, first.y) == (0.25, 19.75)


def test_rays_of_a_scan_turn_as_the_map_does(tmp_path: Path) -> None:
    """The second of four rays points along growing rows: downwards in frame `map`."""
    scan = ScanRecord(1000, "robot", 39.0, 0.0, 4.0, np.array([2.0, np.inf, 1.0, 4.0], np.float32))
    (message,) = shown(tmp_path, [OPEN, scan], "/robot/laser")
    assert (message.start_angle, message.end_angle) == (0.0, pytest.approx(-1.5 * np.pi))
    assert list(message.ranges) == [1.0, np.inf, 0.5, 2.0]
    assert (message.pose.position.x, message.pose.position.y) == (0.25, 0.25)


@pytest.mark.parametrize("cells", [[[4, 0]], [[0, -1]]])
def test_what_lies_outside_of_the_map_is_not_shown(tmp_path: Path, cells: list[list[int]]) -> None:
    record = ObstacleRecord(0, "map", np.array(cells, np.int32), True)
    small = MapRecord(0, "map", np.ones((4, 4), bool), NO_GOALS, None)
    for scene in shown(tmp_path, [record, small, record], "/obstacles"):
        assert not scene.entities[0].cubes
    assert floor_of(small).cell_size == 1.0


@pytest.mark.parametrize(
    "record",
    [
        PoseRecord(0, "robot", math.nan, 0.0, 0.0, 0.0),
        PoseRecord(0, "robot", 0.0, 0.0, math.inf, 0.0),
        PositionsRecord(0, "fleet", 0, np.array([[math.nan, 0.0]])),
        PositionsRecord(0, "fleet", 0, np.zeros((0, 2))),
        TrajectoryRecord(0, "robot", np.array([[math.inf, 0.0], [0.0, math.nan]]), False),
    ],
)
def test_places_that_are_no_numbers_are_recorded(tmp_path: Path, record: Record) -> None:
    trace = open_trace(write(tmp_path / "run.mcap", [OPEN, record]))
    assert [type(each) for each in trace.records()] == [MapRecord, type(record)]


def test_a_drive_of_ten_minutes_stays_small(tmp_path: Path) -> None:
    """256 × 256 cells, ten turns a second, each with nine records, a hundred replans of 400 points."""
    rng = np.random.default_rng(1)
    free = rng.random((256, 256)) < 0.8
    path = tmp_path / "drive.mcap"
    with McapListener(path) as listener:
        for record in a_long_drive(rng, free):
            listener(record)
    assert path.stat().st_size < 11_000_000


def a_long_drive(rng: np.random.Generator, free: Any) -> Iterator[Record]:
    from codesign.ground.records import CommandRecord, MessageRecord, TaskRecord

    yield MapRecord(0, "map", free, np.array([[200, 200]], np.int32), 0.1)
    position = np.array([100.0, 100.0])
    for turn in range(6000):
        now = turn * SECOND // 10
        position = np.clip(position + rng.normal(0, 0.5, 2), 1, 250)
        row, column = position.tolist()
        yield PoseRecord(now, "robot", row, column, float(rng.normal()), 0.5)
        yield TaskRecord(now, "robot", "sense", now + 1000, 1)
        for name, bits in (("scan", 2880), ("pose", 64), ("direction", 64), ("command", 64)):
            yield MessageRecord(now, "uart", "host", "fpga", name, bits, now + 5, now + 50_000 + turn)
        yield TaskRecord(now, "fpga", "decide", now + 12345 + turn, 99)
        seen = rng.integers(0, 256, (20, 2)).astype(np.int32)
        yield BeliefRecord(now, "robot", seen, free[tuple(seen.T)])
        way = position + np.cumsum(rng.uniform(0, 1, (6, 2)), axis=0)
        yield CommandRecord(now + 60_000, "robot", turn // 60 + 1, now, now + 50_000, way, 5.0)
        if turn % 2 == 0:
            yield ObstacleRecord(now, "world", seen[:4], turn % 4 == 0)
        if turn % 60 == 0:
            yield MissionRecord(now, "robot", "plan_requested", "the way is blocked")
            yield TrajectoryRecord(now, "robot", np.cumsum(rng.normal(0, 1, (400, 2)), axis=0), True)
            yield MissionRecord(now, "robot", "plan_ready", "after 2 ms")
