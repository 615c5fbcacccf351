"""The MCAP writer: an outside reader reads it, the same records give the same bytes, whole or not at all."""

from __future__ import annotations

import base64
import errno
import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codesign.errors import TraceError
from codesign.records import (
    BeliefRecord,
    CommandRecord,
    FieldRecord,
    MapRecord,
    MessageRecord,
    MissionRecord,
    ObstacleRecord,
    PlanRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    StageRecord,
    SummaryRecord,
    TaskRecord,
    TrajectoryRecord,
    UtilisationRecord,
    VisitsRecord,
)
from codesign.trace import McapListener, MemoryListener
from codesign.trace.encoding import RECORD_TYPES, bared, encode, schema_of
from codesign.trace.foxglove import Floor
from codesign.trace.views import SCENE_SCHEMA

FREE = np.array([[True, False, True], [True, True, True]])


def a_run(seed: int = 1) -> list[Record]:
    """One record of every class, times not in order, ps that are no whole ns, an array of every dtype."""
    rng = np.random.default_rng(seed)
    block = rng.integers(0, 4, 50, dtype=np.int32)
    iterations = rng.integers(1, 9, 50, dtype=np.int32)
    potential = rng.random((2, 3), dtype=np.float64)
    return [
        MapRecord(0, "host", FREE, np.array([[0, 2], [1, 1]], dtype=np.int32), 0.05),
        MessageRecord(0, "pci", "host", "fpga", "map", 9504, 12, 1_234_567),
        VisitsRecord(1_234_567, "fpga", 8_000_001, 0, 7, block, iterations),
        StageRecord(8_000_001, "fpga", 1_234_567, 0, 7, 3, 50, 222, 1998, 4, potential),
        VisitsRecord(8_000_001, "fpga", 8_000_001, 1, 15, block[:0], iterations[:0]),
        StageRecord(9_000_001, "fpga", 8_000_001, 1, 15, 1, 0, 0, 0, 0, potential / 2),
        TaskRecord(9_000_001, "host", "decide", 9_100_000, 99),
        TrajectoryRecord(9_100_000, "host", np.array([[1.0, 0.25], [0.0, 2.0]]), True),
        UtilisationRecord(10_000_000, "fpga", 7_000_000, 10_000_000),
        UtilisationRecord(10_000_000, "pci", 0, 0),
        SummaryRecord(10_000_000, "system", {"time_ps": 10_000_000, "quality": {"share": 0.5, "note": "è"}}),
    ]


def a_mission() -> list[Record]:
    """A small drive with a record of every class that a mission adds; it ends early, with no result."""
    free = np.ones((4, 6), bool)
    free[1, 1:5] = False
    cells = np.array([[2, 2], [2, 3]], np.int32)
    field = np.full((4, 6), np.inf)
    field[0] = np.arange(6.0)
    way = np.array([[0.0, 0.0], [3.0, 0.25], [3.0, 5.0]])
    return [
        MapRecord(0, "map", free, np.array([[3, 5]], np.int32), 0.5),
        BeliefRecord(0, "robot", np.array([[0, 0], [1, 1]], np.int32), np.array([False, True]), 0),
        MissionRecord(0, "robot", "plan_requested", "the first"),
        MessageRecord(10, "uart", "host", "fpga", "map", 24, 20, 2_000_000, "dropped", "link down", 3),
        FieldRecord(3_000_000, "fpga", "distance", "cells", field),
        PlanRecord(3_000_000, "fpga", 1, 10, 0, 2_000_000, 2_500_000),
        TrajectoryRecord(3_000_000, "robot", way, True),
        CommandRecord(4_000_000, "robot", 1, 0, 3_000_000, way, 2.5),
        MissionRecord(3_000_000, "robot", "plan_ready", "3 us"),
        PoseRecord(10**11, "robot", 1 / 3, 0.0, np.pi / 2, 0.5),
        ObstacleRecord(2 * 10**11, "world", cells, True),
        BeliefRecord(3 * 10**11, "robot", cells, np.array([True, True])),
        ObstacleRecord(15 * 10**11, "world", cells[:1], False),
        PositionsRecord(16 * 10**11, "fleet", 7, np.array([[1.0, 2.5], [3.0, 0.0]])),
        PoseRecord(17 * 10**11, "robot", 2.0, 0.5, 0.0, 0.0),
        MissionRecord(17 * 10**11, "robot", "contact", "an obstacle came"),
        MissionRecord(18 * 10**11, "robot", "ended", "the robot is walled in"),
    ]


def as_told(records: list[Record]) -> list[Record]:
    """The records as a trace keeps them: once a mission has begun, without the fields of its plans."""
    began = next((place for place, one in enumerate(records) if isinstance(one, MissionRecord)), len(records))
    return [*records[:began], *map(bared, records[began:])]


def same(first: Record, second: Record) -> bool:
    """Whether two records are equal, arrays with their dtypes and shapes included."""
    if type(first) is not type(second):
        return False
    for item in fields(first):
        one, other = getattr(first, item.name), getattr(second, item.name)
        if isinstance(one, np.ndarray):
            if one.dtype != other.dtype or one.shape != other.shape or one.tobytes() != other.tobytes():
                return False
        elif type(one) is not type(other) or one != other:
            return False
    return True


def write(path: Path, records: list[Record], **identity: str) -> Path:
    with McapListener(path, identity) as listener:
        for record in records:
            listener(record)
    return path


def test_every_class_of_record_is_written_here() -> None:
    assert {type(record) for record in a_run() + a_mission()} == set(RECORD_TYPES.values())


def test_the_mcap_library_reads_it_with_its_checksums(tmp_path: Path) -> None:
    from mcap.reader import NonSeekingReader, make_reader

    path = write(tmp_path / "run.mcap", a_run(), platform="virtex4-pci")
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        messages = list(reader.iter_messages())
        header = reader.get_header()
        attachments = {item.name: item for item in reader.iter_attachments()}
        metadata = {item.name: item.metadata for item in reader.iter_metadata()}
    with path.open("rb") as stream:
        plain = list(NonSeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False))
    assert (header.profile, header.library) == ("", "hwsw-codesign")
    assert metadata == {"run": {"format": "1", "platform": "virtex4-pci"}}
    assert json.loads(attachments["run.json"].data) == metadata["run"]
    assert json.loads(attachments["result.json"].data) == {
        "time_ps": 10_000_000,
        "quality": {"share": 0.5, "note": "è"},
    }
    assert {channel.topic for channel in summary.channels.values()} == {
        "/map", "/pci/message", "/fpga/visits", "/fpga/stage", "/host/task", "/trajectory",
        "/fpga/utilisation", "/pci/utilisation", "/scene", "/summary",
    }  # fmt: skip
    told = [message.sequence for _, channel, message in plain if channel.topic != "/scene"]
    assert told == list(range(1, 12))
    assert len(messages) == summary.statistics.message_count == 12
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (0, 10_000)
    for schema, channel, message in messages:
        assert (channel.message_encoding, schema.encoding) == ("json", "jsonschema")
        data = json.loads(message.data)
        assert message.log_time == message.publish_time == data["time"] // 1000
        assert data["source"] == channel.metadata["source"]
        declared = json.loads(schema.data)
        assert set(declared["required"]) <= set(data) <= set(declared["properties"])


def test_the_map_and_the_potential_are_foxglove_grids() -> None:
    map_record, stage = a_run()[0], a_run()[3]
    data = json.loads(encode(map_record, Floor(2, 0.05)))
    assert data["frame_id"] == "map"
    assert data["cell_size"] == {"x": 0.05, "y": 0.05}
    assert (data["column_count"], data["row_stride"], data["cell_stride"]) == (3, 3, 1)
    assert data["fields"] == [{"name": "occupied", "offset": 0, "type": 1}]
    # The y axis points up: the last row of the map comes first.
    assert base64.b64decode(data["data"]) == bytes([0, 0, 0, 0, 1, 0])
    data = json.loads(encode(stage))
    assert data["timestamp"] == {"sec": 0, "nsec": 8000}
    assert data["time"] == 8_000_001
    assert (data["column_count"], data["row_stride"], data["cell_stride"]) == (3, 24, 8)
    assert data["fields"] == [{"name": "potential", "offset": 0, "type": 8}]
    assert isinstance(stage, StageRecord)
    values = np.frombuffer(base64.b64decode(data["data"]), "<f8").reshape(2, 3)
    assert np.array_equal(values[::-1], stage.potential)


@pytest.mark.parametrize("record_type", RECORD_TYPES.values())
def test_foxglove_can_read_the_schema(record_type: type[Record]) -> None:
    """The rules of Foxglove's JSON schema reader, which gives up a whole channel where one is broken."""

    def walk(schema: dict[str, Any]) -> None:
        assert schema["type"] in {"boolean", "string", "number", "integer", "object", "array"}
        assert schema.get("contentEncoding", "base64") == "base64"
        if schema["type"] == "object":
            for inner in schema["properties"].values():
                walk(inner)
        if schema["type"] == "array":
            assert schema["items"]["type"] != "array"
            assert "contentEncoding" not in schema["items"]
            walk(schema["items"])

    schema = json.loads(schema_of(record_type))
    walk(json.loads(SCENE_SCHEMA))
    assert schema["type"] == "object"
    walk(schema)
    names = {item.name for item in fields(record_type)}
    assert names - {"free", "potential", "values"} <= set(schema["properties"])


def test_the_same_records_give_the_same_bytes(tmp_path: Path) -> None:
    first = write(tmp_path / "first.mcap", a_run(), seed="1")
    again = write(tmp_path / "again.mcap", a_run(), seed="1")
    other = write(tmp_path / "other.mcap", a_run(2), seed="1")
    assert first.read_bytes() == again.read_bytes() != other.read_bytes()


def test_a_run_without_records_has_its_identity(tmp_path: Path) -> None:
    from mcap.reader import make_reader

    path = write(tmp_path / "empty.mcap", [])
    with path.open("rb") as stream:
        reader = make_reader(stream)
        assert [item.name for item in reader.iter_attachments()] == ["run.json"]
        assert [item.name for item in reader.iter_metadata()] == ["run"]


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, ValueError])
def test_nothing_is_left_of_a_run_that_failed(tmp_path: Path, interruption: type[BaseException]) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(b"the last good run")

    def fail() -> None:
        with McapListener(path) as listener:
            listener(a_run()[0])
            raise interruption

    with pytest.raises(interruption):
        fail()
    assert path.read_bytes() == b"the last good run"
    assert list(tmp_path.iterdir()) == [path]


def test_the_final_name_appears_at_the_end_only(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    listener = McapListener(path)
    other = McapListener(path)
    for record in a_run():
        listener(record)
    assert not path.exists()
    listener.close()
    listener.close()
    listener.abort()
    assert path.exists()
    other.abort()
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(TraceError, match="is closed"):
        listener(a_run()[0])


def test_a_closed_listener_takes_nothing(tmp_path: Path) -> None:
    listener = McapListener(tmp_path / "run.mcap")
    listener.close()
    with pytest.raises(TraceError, match="is closed"):
        listener(a_run()[0])
    with pytest.raises(TraceError, match="is closed"):
        listener.attach("late", "text/plain", b"")


def test_a_place_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(TraceError, match="cannot be written: No such file or directory"):
        McapListener(tmp_path / "no" / "run.mcap")
    with pytest.raises(TraceError, match="is a folder"):
        McapListener(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(TraceError, match="cannot be written: Not a directory"):
        McapListener(tmp_path / "file" / "run.mcap")


def test_a_full_disk_is_an_error_and_leaves_nothing(tmp_path: Path) -> None:
    class Full:
        def __init__(self, stream: Any) -> None:
            self.stream, self.room = stream, 4000

        def write(self, data: bytes) -> int:
            self.room -= len(data)
            if self.room < 0:
                raise OSError(errno.ENOSPC, "No space left on device")
            return int(self.stream.write(data))

        def __getattr__(self, name: str) -> Any:
            return getattr(self.stream, name)

    listener = McapListener(tmp_path / "run.mcap")
    listener._writer._Writer__stream = Full(listener._stream)  # type: ignore[attr-defined]
    rng = np.random.default_rng(1)
    noise = MapRecord(0, "host", rng.random((3000, 512)) < 0.5, np.zeros((1, 2), np.int32), None)
    with pytest.raises(TraceError, match="No space left on device"):
        listener(noise)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(TraceError, match="is closed"):
        listener(a_run()[0])


@dataclass(frozen=True)
class StrangeRecord(Record):
    what: list[int]


@dataclass(frozen=True)
class PluginRecord(Record):
    """A record of somebody else's component."""

    temperature: float | None


@pytest.mark.parametrize(
    ("record", "why"),
    [
        (SummaryRecord(0, "system", {"power": float("nan")}), "cannot be written as JSON"),
        (SummaryRecord(0, "system", {"power": object()}), "cannot be written as JSON"),
        (TaskRecord(np.int64(3), "host", "a", 4, 1), "cannot be written as JSON"),  # type: ignore[arg-type]
        (MapRecord(0, "host", FREE, np.zeros((1, 2), np.int64), None), "goals is int64 in place of int32"),  # type: ignore[arg-type]
        (MapRecord(0, "host", FREE.astype(np.uint8), np.zeros((1, 2), np.int32), None), "no grid"),  # type: ignore[arg-type]
        (VisitsRecord(0, "fpga", 0, 0, 7, *[np.zeros(2**24 + 1, np.int32)] * 2), r"more than 2\^24"),
        (ObstacleRecord(0, "world", np.zeros(2, np.int32), True), "cells has shape"),
        (PoseRecord(0, "robot", float("nan"), 0.0, 0.0, 0.0), "cannot be written as JSON"),
        (StrangeRecord(0, "host", [1]), r"cannot hold StrangeRecord.what, a list\[int\]"),
    ],
)
def test_what_a_trace_cannot_hold_is_refused(tmp_path: Path, record: Record, why: str) -> None:
    with pytest.raises(TraceError, match=why), McapListener(tmp_path / "run.mcap") as listener:
        listener(record)
    assert list(tmp_path.iterdir()) == []


def test_a_message_that_no_reader_would_take_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("codesign.trace.encoding.MAX_MESSAGE_BYTES", 100)
    with pytest.raises(TraceError, match="more than a reader accepts"):
        encode(a_run()[3])


def test_records_of_a_plug_in_are_written_and_left_out_by_the_reader(tmp_path: Path) -> None:
    from codesign.trace import open_trace

    mine = [PluginRecord(1, "sensor", 20.5), PluginRecord(2, "sensor", None)]
    trace = open_trace(write(tmp_path / "run.mcap", [*mine, a_run()[6]]))
    assert [(channel.topic, channel.messages) for channel in trace.channels] == [
        ("/sensor/plugin", 2),
        ("/host/task", 1),
    ]
    assert [type(record) for record in trace.records()] == [TaskRecord]


def test_the_memory_listener_keeps_all_in_order() -> None:
    listener = MemoryListener()
    for record in a_run():
        listener(record)
    assert [type(record) for record in listener.records] == [type(record) for record in a_run()]
    assert [record.stage for record in listener.of(StageRecord)] == [0, 1]
