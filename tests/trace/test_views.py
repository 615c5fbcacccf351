"""What viewers draw of a mission: poses, events, whole maps now and then, and a scene. They say what records say."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from trace_samples import a_mission, write

from codesign.frame import Frame
from codesign.records import (
    BeliefRecord,
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    StageRecord,
    SummaryRecord,
    TrajectoryRecord,
)
from codesign.trace import McapListener, open_trace
from codesign.trace.floor import Floor
from codesign.trace.messages import encode
from codesign.trace.views import MOST_CUBES, Views

SECOND = 10**12
NO_GOALS = np.zeros((0, 2), np.int32)


def read(path: Path) -> list[tuple[str, str, dict[str, Any], dict[str, Any]]]:
    """Topic, schema's name, schema and message of each message, in file order, by the library's own reader."""
    from mcap.reader import NonSeekingReader

    with path.open("rb") as stream:
        return [
            (channel.topic, schema.name, json.loads(schema.data), json.loads(message.data))
            for schema, channel, message in NonSeekingReader(stream, validate_crcs=True).iter_messages(
                log_time_order=False
            )
            if schema is not None
        ]


def test_every_message_of_a_mission_keeps_to_its_schema(tmp_path: Path) -> None:
    import jsonschema

    messages = read(write(tmp_path / "mission.mcap", a_mission()))
    assert {topic: name for topic, name, _, _ in messages} == {
        "/map": "foxglove.Grid",
        "/robot/belief": "codesign.BeliefRecord",
        "/robot/grid": "foxglove.Grid",
        "/mission": "foxglove.Log",
        "/uart/message": "codesign.MessageRecord",
        "/fpga/field": "codesign.FieldRecord",
        "/fpga/plan_grid": "foxglove.Grid",
        "/fpga/plan": "codesign.PlanRecord",
        "/robot/command": "codesign.CommandRecord",
        "/trajectory": "codesign.TrajectoryRecord",
        "/scene": "foxglove.SceneUpdate",
        "/robot/pose": "foxglove.PoseInFrame",
        "/world/obstacle": "codesign.ObstacleRecord",
        "/world/grid": "foxglove.Grid",
        "/fleet/positions": "foxglove.PosesInFrame",
    }
    for _, _, schema, message in messages:
        jsonschema.validate(message, schema)
        assert set(message) <= set(schema["properties"])


def test_a_pose_stands_where_the_grid_shows_its_cell() -> None:
    """Row 3 of 4 is the lowest: y is half a cell up. A heading of a quarter turn, towards growing rows, looks down."""
    message = json.loads(encode(PoseRecord(0, "robot", 3.0, 1.0, np.pi / 2, 0.5), Floor(Frame(4, 0.5))))
    assert message["pose"]["position"] == {"x": 0.75, "y": 0.25, "z": 0.0}
    turned = message["pose"]["orientation"]
    # The x axis (1, 0, 0) turned by the quaternion (0, 0, z, w) becomes (w² - z², 2 z w, 0).
    ahead = turned["w"] ** 2 - turned["z"] ** 2, 2 * turned["z"] * turned["w"]
    assert ahead == pytest.approx((0.0, -1.0), abs=1e-6)
    assert message["heading"] == np.pi / 2
    straight = json.loads(encode(PoseRecord(0, "robot", 0.0, 0.0, 0.0, 0.0), Floor(Frame(4))))
    assert straight["pose"]["orientation"] == {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


def test_all_robots_of_a_fleet_are_poses() -> None:
    positions = np.array([[0.0, 0.0], [1.0, 2.5]])
    message = json.loads(encode(PositionsRecord(1_500_000, "fleet", 3, positions), Floor(Frame(2, 1.0))))
    assert [pose["position"] for pose in message["poses"]] == [
        {"x": 0.5, "y": 1.5, "z": 0.0},
        {"x": 3.0, "y": 0.5, "z": 0.0},
    ]


@pytest.mark.parametrize(
    ("event", "level"), [("plan_ready", 2), ("contact", 3), ("safety_stop", 3), ("ended", 2)]
)
def test_events_are_lines_of_a_log(event: str, level: int) -> None:
    message = json.loads(encode(MissionRecord(0, "robot", event, "why")))
    assert (message["level"], message["name"]) == (level, "robot")
    assert message["message"] == f"{event.replace('_', ' ')}: why"


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
        run.append(ObstacleRecord(turn * SECOND // 10, "world", cells, appeared))
        run.append(BeliefRecord(turn * SECOND // 10, "robot", cells, blocked[places]))
        walls[tuple(cells.T)] = appeared
        belief[tuple(cells.T)] = 2 * blocked[places]
    run.append(MissionRecord(30 * SECOND, "robot", "ended", "reached"))
    messages = read(write(tmp_path / "run.mcap", run))
    for topic, name, expected in (("/world/grid", "occupied_now", walls), ("/robot/grid", "belief", belief)):
        shown = [message for where, _, _, message in messages if where == topic]
        assert shown[-1]["fields"] == [{"name": name, "offset": 0, "type": 1}]
        cells_shown = np.frombuffer(base64.b64decode(shown[-1]["data"]), np.uint8).reshape(shape)
        assert np.array_equal(cells_shown[::-1], expected)
        # One each second of 30, though there are ten changes a second.
        assert len(shown) == 31
        assert shown[-1]["time"] == 30 * SECOND


def test_large_maps_are_shown_seldom() -> None:
    """At most 64 us a cell: 4 million cells take 268 s from one to the next."""
    views = Views()
    free = np.ones((2048, 2048), bool)
    assert list(views.of(MapRecord(0, "map", free, NO_GOALS, None))) == []
    cell = np.array([[5, 5]], np.int32)
    known = np.array([False])
    shown = [
        time
        for time in range(0, 600, 10)
        for _ in views.of(BeliefRecord(time * SECOND, "robot", cell, known))
    ]
    assert shown == [0, 270, 540]
    last = SummaryRecord(600 * SECOND, "run", {})
    assert [view.topic for view in views.of(last)] == ["/robot/grid"]
    assert list(views.of(last)) == []


def test_the_field_of_a_plan_is_shown_when_it_is_ready_and_seldom(tmp_path: Path) -> None:
    """Two stages a plan, a plan a second: 16 × 16 cells of 8 bytes are shown each second, 64 × 64 each 2.1 s."""
    for side, times in ((16, [0, 1, 2, 3, 4, 5]), (64, [0, 3, 5])):
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
        shown = [message for topic, _, _, message in messages if topic == "/fpga/plan_grid"]
        assert [message["time"] // SECOND for message in shown] == times
        values = [np.frombuffer(base64.b64decode(message["data"]), "<f8")[0] for message in shown]
        assert values == [time + 0.5 for time in times]
        stages = [(name, set(message)) for topic, name, _, message in messages if topic == "/fpga/stage"]
        assert len(stages) == 12
        assert all(name == "codesign.StageRecord" and "data" not in keys for name, keys in stages)


def test_a_plan_without_a_mission_keeps_its_fields(tmp_path: Path) -> None:
    field = np.full((2, 2), 0.5)
    run: list[Record] = [
        MapRecord(0, "map", np.ones((2, 2), bool), NO_GOALS, None),
        StageRecord(1, "fpga", 0, 0, 7, 3, 50, 222, 1998, 4, field),
    ]
    assert [topic for topic, _, _, _ in read(write(tmp_path / "run.mcap", run))] == ["/map", "/fpga/stage"]
    (stage,) = open_trace(tmp_path / "run.mcap").records(kinds=[StageRecord])
    assert isinstance(stage, StageRecord)
    assert np.array_equal(stage.potential, field)


def test_cubes_come_and_go_with_the_obstacles() -> None:
    views = Views()
    list(views.of(MapRecord(0, "map", np.ones((40, 40), bool), NO_GOALS, 0.5)))
    cells = np.array([[39, 0], [1, 2]], np.int32)
    (scene,) = (
        json.loads(v.data) for v in views.of(ObstacleRecord(5, "world", cells, True)) if v.topic == "/scene"
    )
    assert [entity["id"] for entity in scene["entities"]] == ["obstacle 39 0", "obstacle 1 2"]
    assert scene["entities"][0]["cubes"][0]["pose"]["position"] == {"x": 0.25, "y": 0.25, "z": 0.25}
    (scene,) = (
        json.loads(v.data) for v in views.of(ObstacleRecord(9, "world", cells, False)) if v.topic == "/scene"
    )
    assert [gone["id"] for gone in scene["deletions"]] == ["obstacle 39 0", "obstacle 1 2"]
    assert scene["entities"] == []
    many = np.argwhere(np.ones((40, 40), bool)).astype(np.int32)[: MOST_CUBES + 1]
    assert [v.topic for v in views.of(ObstacleRecord(10 * SECOND, "world", many, True))] == ["/world/grid"]


def test_a_new_way_takes_the_place_of_the_old_one_and_ways_of_one_time_stand_together() -> None:
    views = Views()
    list(views.of(MapRecord(0, "map", np.ones((4, 4), bool), NO_GOALS, None)))
    points = np.array([[0.0, 0.0], [3.0, 3.0]])
    names = []
    for time in (1, 1, 2):
        (view,) = views.of(TrajectoryRecord(time, "robot", points, True))
        (entity,) = json.loads(view.data)["entities"]
        names.append(entity["id"])
        assert entity["lines"][0]["points"] == [
            {"x": 0.5, "y": 3.5, "z": 0.0},
            {"x": 3.5, "y": 0.5, "z": 0.0},
        ]
    assert names == ["way 0", "way 1", "way 0"]


@pytest.mark.parametrize("cells", [[[4, 0]], [[0, -1]]])
def test_what_lies_outside_of_the_map_is_not_shown(cells: list[list[int]]) -> None:
    views = Views()
    record = ObstacleRecord(0, "world", np.array(cells, np.int32), True)
    assert list(views.of(record)) == []
    list(views.of(MapRecord(0, "map", np.ones((4, 4), bool), NO_GOALS, None)))
    assert list(views.of(record)) == []


def test_a_drive_of_ten_minutes_stays_small(tmp_path: Path) -> None:
    """256 × 256 cells, ten turns a second, each with nine records, a hundred replans of 400 points."""
    rng = np.random.default_rng(1)
    free = rng.random((256, 256)) < 0.8
    path = tmp_path / "drive.mcap"
    with McapListener(path) as listener:
        for record in a_long_drive(rng, free):
            listener(record)
    assert path.stat().st_size < 11_000_000


def a_long_drive(rng: np.random.Generator, free: Any) -> Any:
    from codesign.records import CommandRecord, MessageRecord, TaskRecord

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
