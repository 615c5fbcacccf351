"""The MCAP writer: an outside reader reads it, the same records give the same bytes, whole or not at all."""

from __future__ import annotations

import base64
import errno
import json
import math
import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from codesign.trace.encoding import MAX_ELEMENTS, MAX_MESSAGE_BYTES, RECORD_TYPES, encode, schema_of
from codesign.trace.foxglove import Floor
from trace_samples import FREE, PluginRecord, a_mission, a_run, write

from codesign.errors import TraceError
from codesign.frame import Frame
from codesign.records import (
    MapRecord,
    ObstacleRecord,
    PoseRecord,
    Record,
    StageRecord,
    SummaryRecord,
    TaskRecord,
    VisitsRecord,
)
from codesign.trace import McapListener, MemoryListener, open_trace
from codesign.trace.scan import MAX_RECORD_BYTES
from codesign.trace.views import SCENE_SCHEMA


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
    data = json.loads(encode(map_record, Floor(Frame(2, 0.05))))
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


def test_a_trace_follows_links_and_replaces_no_fifo(tmp_path: Path) -> None:
    pipe, real, link = tmp_path / "pipe", tmp_path / "real.mcap", tmp_path / "link.mcap"
    os.mkfifo(pipe)
    with pytest.raises(TraceError, match="no regular file"):
        McapListener(pipe)
    assert pipe.is_fifo()
    link.symlink_to(real)
    with McapListener(link):
        pass
    assert link.is_symlink()
    assert real.stat().st_size > 0


def test_messages_and_records_may_hold_the_potential_of_the_largest_map() -> None:
    """2^24 float64 cells, as base64 in JSON above the 2^27 bytes that once were the bound."""
    base64_bytes = 4 * math.ceil(MAX_ELEMENTS * 8 / 3)
    assert base64_bytes > 2**27
    assert base64_bytes + 2**20 < MAX_MESSAGE_BYTES < MAX_RECORD_BYTES


@pytest.mark.parametrize("side", [512, pytest.param(4096, marks=pytest.mark.slow)])
def test_a_potential_of_a_large_map_is_written_and_read_back(tmp_path: Path, side: int) -> None:
    potential = np.zeros((side, side))
    potential[0, 1] = 0.25
    potential[-1, -1] = 1.0
    with McapListener(tmp_path / "large.mcap") as listener:
        listener(TaskRecord(0, "fpga", "load", 5, 1))
        listener(StageRecord(9, "fpga", 0, 0, 7, 1, 1, 1, 1, 0, potential))
    trace = open_trace(tmp_path / "large.mcap")
    assert trace.complete
    _, stage = trace.records()
    assert isinstance(stage, StageRecord)
    assert np.array_equal(stage.potential, potential)


@pytest.mark.parametrize("time", [2**63, 2**64 * 1000, -1])
def test_a_time_that_no_trace_holds_is_refused_with_a_remedy(tmp_path: Path, time: int) -> None:
    with (
        pytest.raises(TraceError, match="no TaskRecord: time") as caught,
        McapListener(tmp_path / "late.mcap") as listener,
    ):
        listener(TaskRecord(time, "fpga", "load", 5, 1))
    assert time < 0 or "shorter run" in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_the_latest_time_that_is_written_is_read_back(tmp_path: Path) -> None:
    """Writer and reader share one bound."""
    record = TaskRecord(2**63 - 1, "fpga", "load", 2**63 - 1, 1)
    with McapListener(tmp_path / "late.mcap") as listener:
        listener(record)
    assert list(open_trace(tmp_path / "late.mcap").records()) == [record]
