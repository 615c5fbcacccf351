"""The MCAP writer: an outside reader reads it, the same records give the same bytes, whole or not at all."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from trace_samples import FREE, PluginRecord, a_mission, a_run, same, write

from codesign.ground.errors import TraceError
from codesign.ground.records import (
    RECORD_TYPES,
    FieldRecord,
    MapRecord,
    MessageRecord,
    ObstacleRecord,
    Record,
    StageRecord,
    SummaryRecord,
    TaskRecord,
    VisitsRecord,
)
from codesign.views.trace import McapListener, MemoryListener, open_trace
from codesign.views.trace.messages import (
    MAX_ELEMENTS,
    MAX_MESSAGE_BYTES,
    PICOSECONDS,
    decode,
    descriptor_set,
    encode,
    message_class,
    schema_name,
)
from codesign.views.trace.reader import MAX_RECORD_BYTES


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
    assert header.profile == ""
    assert metadata == {
        "run": {"format": "2", "library": "hwsw-codesign", "level": "blocks", "platform": "virtex4-pci"}
    }
    assert json.loads(attachments["run.json"].data) == metadata["run"]
    records = [each for each in plain if "record" in each[1].metadata]
    assert {channel.topic for _, channel, _ in records} == {
        "/map", "/pci/message", "/fpga/visits", "/fpga/stage", "/host/task", "/trajectory",
        "/fpga/utilisation", "/pci/utilisation", "/summary", "/fpga/sample",
    }  # fmt: skip
    assert [channel.metadata["record"] for _, channel, _ in records] == [type(record).__name__ for record in a_run()]
    assert len(messages) == summary.statistics.message_count
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (0, 10_000)
    assert [message.log_time for _, _, message in records] == [record.time // 1000 for record in a_run()]
    for schema, channel, _ in messages:
        assert (channel.message_encoding, schema.encoding) == ("protobuf", "protobuf")


@pytest.mark.parametrize("record", a_run() + a_mission(), ids=lambda record: type(record).__name__)
def test_the_embedded_schema_is_all_that_a_decoder_needs(record: Record) -> None:
    from google.protobuf.descriptor_pb2 import FileDescriptorSet
    from google.protobuf.descriptor_pool import DescriptorPool
    from google.protobuf.message_factory import GetMessageClass

    kind, pool = type(record), DescriptorPool()
    for file in FileDescriptorSet.FromString(descriptor_set(kind)).file:
        pool.Add(file)
    message = GetMessageClass(pool.FindMessageTypeByName(schema_name(kind))).FromString(encode(record))
    assert (message.picoseconds, message.source) == (record.time % 1000, record.source)
    for name in kind.TIMES:
        value = getattr(record, name)
        assert not message.HasField(name) if value is None else getattr(message, name) == value - record.time
    names = [field.name for field in message.DESCRIPTOR.fields]
    assert names == [PICOSECONDS, *(item.name for item in fields(kind)[1:])]
    assert [field.number for field in message.DESCRIPTOR.fields] == list(range(1, len(fields(kind)) + 1))


def test_arrays_are_stored_in_few_bytes_without_loss() -> None:
    """0/1 as bits; float64 as float32 where that holds it exactly, NaN and infinities included."""
    grid = np.array([[0.0, np.inf], [np.nan, 3.0]])
    for values, dtype in ((grid, "float32"), (grid + 0.1, "planes"), (np.full((2, 2), 1e300), "planes")):
        record = FieldRecord(0, "fpga", "distance", "cells", values)
        message = message_class(FieldRecord).FromString(encode(record))
        assert (list(message.values.shape), message.values.dtype) == ([2, 2], dtype)
        assert same(decode(FieldRecord, encode(record), 0), record)
    free = np.random.default_rng(1).random((5, 7)) < 0.5
    record = MapRecord(0, "map", free, np.zeros((0, 2), np.int32), None)
    assert len(message_class(MapRecord).FromString(encode(record)).free.data) == 5
    assert same(decode(MapRecord, encode(record), 0), record)


def test_a_missing_field_has_its_default() -> None:
    message = message_class(MessageRecord)(picoseconds=1, source="pci", sender="host", end=1).SerializeToString()
    assert decode(MessageRecord, message, 0) == MessageRecord(1, "pci", "host", "", "", 0, 1, 2)


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


def test_a_full_disk_is_an_error_and_leaves_nothing(tmp_path: Path, capfd: Any) -> None:
    """The limit of the size of files gives the operating system's own error, as a full disk does."""
    resource = pytest.importorskip("resource")
    listener = McapListener(tmp_path / "run.mcap")
    rng = np.random.default_rng(1)
    noise = MapRecord(0, "host", rng.random((3000, 5120)) < 0.5, np.zeros((1, 2), np.int32), None)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4000, before[1]))
    try:
        with pytest.raises(TraceError, match="cannot be written: File too large"):
            listener(noise)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(TraceError, match="is closed"):
        listener(a_run()[0])
    assert capfd.readouterr() == ("", "")


KILLED = """
import os, signal, sys
import numpy as np
from codesign.ground.records import MapRecord, TaskRecord
from codesign.views.trace import McapListener
listener = McapListener(sys.argv[1])
listener(MapRecord(0, "map", np.ones((8, 8), bool), np.zeros((0, 2), np.int32), None))
for number in range(60_000):
    listener(TaskRecord(number, "host", f"task {number}", number + 1, 1))
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_run_leaves_a_file_whose_complete_chunks_are_read(tmp_path: Path, hwsw: Callable[..., Any]) -> None:
    killed = subprocess.run([sys.executable, "-c", KILLED, tmp_path / "run.mcap"], check=False)
    assert killed.returncode == -signal.SIGKILL
    (part,) = tmp_path.iterdir()
    assert part.name.endswith(".part")
    trace = open_trace(part)
    assert not trace.complete
    tasks = list(trace.records(kinds=[TaskRecord]))
    assert 20_000 < len(tasks) < 60_000
    assert tasks == [TaskRecord(n, "host", f"task {n}", n + 1, 1) for n in range(len(tasks))]
    info = hwsw("trace", "info", part)
    assert info.exit_code == 0
    assert "no, only the part before: the file is cut short" in info.output
    # What was written ends at the end of a chunk, as each chunk is written whole.
    assert part.stat().st_size > 100_000


@dataclass(frozen=True)
class StrangeRecord(Record):
    what: list[int]


@pytest.mark.parametrize(
    ("record", "why"),
    [
        (SummaryRecord(0, "system", {"power": float("nan")}), "cannot be written as JSON"),
        (SummaryRecord(0, "system", {"power": object()}), "cannot be written as JSON"),
        (TaskRecord(3, "host", "a", "4", 1), "a TaskRecord cannot be written"),  # type: ignore[arg-type]
        (TaskRecord(3, "host", None, 4, 1), "a field without a value"),  # type: ignore[arg-type]
        (MapRecord(0, "host", FREE, np.zeros((1, 2), np.int64), None), "goals is int64 in place of int32"),  # type: ignore[arg-type]
        (MapRecord(0, "host", FREE.astype(np.uint8), np.zeros((1, 2), np.int32), None), "free is uint8"),  # type: ignore[arg-type]
        (VisitsRecord(0, "fpga", 0, 0, 7, *[np.zeros(2**24 + 1, np.int32)] * 2), r"more than 2\^24"),
        (ObstacleRecord(0, "world", np.zeros(2, np.int32), True), "cells has shape"),
        (StrangeRecord(0, "host", [1]), r"what has the type list\[int\]"),
    ],
)
def test_what_a_trace_cannot_hold_is_refused(tmp_path: Path, record: Record, why: str) -> None:
    with pytest.raises(TraceError, match=why), McapListener(tmp_path / "run.mcap") as listener:
        listener(record)
    assert list(tmp_path.iterdir()) == []


def test_a_message_that_no_reader_would_take_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("codesign.views.trace.messages.MAX_MESSAGE_BYTES", 100)
    with pytest.raises(TraceError, match="more than a reader accepts"):
        encode(StageRecord(9, "fpga", 0, 0, 7, 1, 1, 1, 1, 0, np.zeros((9, 9))))


def test_records_of_a_plug_in_are_written_and_left_out_by_the_reader(tmp_path: Path) -> None:
    from codesign.views.trace import open_trace

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
    """2^24 float64 cells."""
    assert MAX_ELEMENTS * 8 + 2**20 < MAX_MESSAGE_BYTES < MAX_RECORD_BYTES


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
