"""The reader: records come back as they were, a cut file gives what is complete, all else is an error."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from trace_samples import a_mission, a_run, as_told, same, write

from codesign.ground.errors import TraceError
from codesign.ground.records import (
    RECORD_TYPES,
    BeliefRecord,
    GoalRecord,
    MapRecord,
    MessageRecord,
    ObstacleRecord,
    PoseRecord,
    Record,
    RobotRecord,
    SampleRecord,
    ScanRecord,
    StageRecord,
    SummaryRecord,
    TaskRecord,
    TrajectoryRecord,
    VisitsRecord,
)
from codesign.views.trace import MOMENT_KINDS, moment, open_trace, timeline, trace_thumbnail
from codesign.views.trace.messages import decode, encode, message_class
from codesign.views.trace.reader import decode_json

times = st.integers(0, 2**62)
sides = st.integers(1, 6)


def arrays(dtype: Any, shape: Any) -> Any:
    return npst.arrays(dtype, shape)


@st.composite
def any_records(draw: st.DrawFn) -> Record:
    shape = draw(st.tuples(sides, sides))
    visits = draw(st.integers(0, 9))
    return draw(
        st.one_of(
            st.builds(
                MapRecord, times, st.just("host"), arrays(np.bool_, shape), arrays(np.int32, (visits, 2)),
                st.none() | st.floats(0, 10),
            ),
            st.builds(
                VisitsRecord, times, st.just("fpga"), times, times, times, arrays(np.int32, (visits,)),
                arrays(np.int32, (visits,)),
            ),
            st.builds(
                StageRecord, times, st.just("fpga"), *[times] * 8, arrays(np.float64, shape),
            ),
            st.builds(
                TrajectoryRecord, times, st.text(), arrays(np.float64, (visits, 2)), st.booleans(),
            ),
        )
    )  # fmt: skip


@given(any_records())
@settings(max_examples=examples(100))
def test_a_record_comes_back_as_it_was(record: Record) -> None:
    assert same(decode(type(record), encode(record), record.time // 1000), record)


def test_a_run_comes_back_in_the_order_of_emission(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", a_run(), platform="virtex4-pci")
    trace = open_trace(path)
    assert trace.complete
    assert trace.size == path.stat().st_size
    assert trace.messages > trace.record_messages == len(a_run())
    assert (trace.begin, trace.end) == (0, 10_000_000)
    assert trace.metadata["run"]["platform"] == "virtex4-pci"
    assert trace.result["time_ps"] == 10_000_000
    back = list(trace.records())
    assert len(back) == len(a_run())
    assert all(same(one, other) for one, other in zip(back, a_run(), strict=True))


def test_a_mission_comes_back_without_what_was_made_for_viewers(tmp_path: Path) -> None:
    """It ended early, with no result: the file is whole all the same."""
    trace = open_trace(write(tmp_path / "mission.mcap", a_mission()))
    assert trace.complete
    assert trace.result is None
    assert trace.messages > trace.record_messages == len(a_mission())
    back = list(trace.records())
    assert all(same(one, other) for one, other in zip(back, as_told(a_mission()), strict=True))
    assert sum(same(one, other) for one, other in zip(back, a_mission(), strict=True)) == len(back) - 1


def test_classes_choose_records(tmp_path: Path) -> None:
    trace = open_trace(write(tmp_path / "mission.mcap", a_mission()))
    chosen = list(trace.records(kinds=[PoseRecord, ObstacleRecord]))
    expected = [record for record in a_mission() if isinstance(record, PoseRecord | ObstacleRecord)]
    assert all(same(one, other) for one, other in zip(chosen, expected, strict=True))
    assert list(trace.records(["/mission"], kinds=[PoseRecord])) == []


def test_a_message_of_an_older_file_takes_the_defaults() -> None:
    """Messages on links had no outcome when only delivered ones were written."""
    old = b'{"time":1,"source":"pci","sender":"a","receiver":"b","name":"map","bits":8,"begin":2,"end":3}'
    record = decode_json(MessageRecord, old)
    assert record == MessageRecord(1, "pci", "a", "b", "map", 8, 2, 3, "delivered", None, 1)


def test_topics_choose_records_and_patterns_too(tmp_path: Path) -> None:
    trace = open_trace(write(tmp_path / "run.mcap", a_run()))
    assert [type(record) for record in trace.records(["/fpga/stage"])] == [StageRecord] * 2
    assert {record.source for record in trace.records(["/fpga/*", "/pci/utilisation"])} == {"fpga", "pci"}
    with pytest.raises(TraceError, match="no topic '/fpga/stag'\n  hint: did you mean /fpga/stage"):
        list(trace.records(["/fpga/stag"]))


def test_an_uncompressed_and_an_lz4_file_are_read(tmp_path: Path) -> None:
    from mcap.writer import CompressionType, Writer

    record = a_run()[0]
    for compression in (CompressionType.NONE, CompressionType.LZ4):
        for chunked in (True, False):
            path = tmp_path / "other.mcap"
            with path.open("wb") as stream:
                writer = Writer(stream, compression=compression, use_chunking=chunked)
                writer.start()
                channel = writer.register_channel("/map", "protobuf", 0, {"record": "MapRecord", "source": "host"})
                writer.add_message(channel, 0, encode(record), 0)
                writer.finish()  # type: ignore[no-untyped-call]
            trace = open_trace(path)
            assert trace.complete
            assert [same(back, record) for back in trace.records()] == [True]


def test_a_cut_file_gives_all_that_is_complete_and_says_so(tmp_path: Path) -> None:
    """Wherever it is cut, the records are a beginning of the run, and only the whole file passes for whole."""
    whole = write(tmp_path / "run.mcap", many(3)).read_bytes()
    cut = tmp_path / "cut.mcap"
    seen: set[int] = set()
    faults: set[str] = set()
    for length in [*range(8, len(whole), len(whole) // 60), len(whole) - 1, len(whole)]:
        cut.write_bytes(whole[:length])
        try:
            trace = open_trace(cut)
        except TraceError as fault:
            faults.add(fault.what)
            continue
        back = list(trace.records())
        assert len(back) == trace.messages
        assert all(same(one, other) for one, other in zip(back, many(3), strict=False))
        assert trace.complete == (length == len(whole))
        seen.add(len(back))
    assert faults == {"has no readable content: the file is cut short"}
    assert len(seen) >= 3
    assert max(seen) == len(many(3))


def test_a_run_cut_at_half_keeps_about_half_of_its_stages(tmp_path: Path) -> None:
    """Twenty stages of a map of 200 × 200, 320 kB each, in chunks of 1 MiB."""
    fall = np.random.default_rng(1).random((200, 200))
    run = [StageRecord(time, "fpga", time, time, 7, 3, 50, 222, 1998, 4, fall / time) for time in range(1, 21)]
    whole = write(tmp_path / "run.mcap", list(run)).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    trace = open_trace(cut)
    assert (trace.complete, trace.size) == (False, len(whole) // 2)
    back = list(trace.records())
    assert 5 <= len(back) <= 10
    assert all(same(one, other) for one, other in zip(back, run, strict=False))


def many(chunks: int) -> list[Record]:
    """A run of some chunks: noise that does not compress away."""
    rng = np.random.default_rng(0)
    visits = rng.integers(0, 2**31, 150_000, dtype=np.int32)
    return [VisitsRecord(time, "fpga", time, 0, 7, visits + np.int32(time), visits) for time in range(chunks)]


def test_a_flipped_bit_is_found_wherever_it_is(tmp_path: Path) -> None:
    whole = write(tmp_path / "run.mcap", a_run()).read_bytes()
    path = tmp_path / "flipped.mcap"
    rng = np.random.default_rng(0)
    for place in rng.integers(8, len(whole), 150):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        try:
            assert not open_trace(path).complete
        except TraceError:
            continue


@pytest.mark.parametrize(
    ("record_type", "message", "why"),
    [
        ("TaskRecord", b"[" * 100_000, "not JSON of a trace"),
        ("TaskRecord", b"[" * 2_000_000, "a JSON text with 2000000 values"),
        ("TaskRecord", b"[1]", "not a JSON object"),
        ("TaskRecord", b"\xff", "not JSON"),
        ("TaskRecord", b'{"time":' + b"9" * 5000 + b"}", "not JSON"),
        ("TaskRecord", b'{"time":NaN}', "NaN is not JSON"),
        ("TaskRecord", b'{"time":true}', "time is no int64"),
        ("TaskRecord", b'{"time":99999999999999999999}', "time is no int64"),
        ("TaskRecord", b"{}", "time is missing"),
        ("UtilisationRecord", b'{"time":-1,"source":"a","busy":0,"span":1}', "time -1"),
        ("MapRecord", b'{"time":0,"source":"a"}', "a grid without columns or data"),
        (
            "BeliefRecord",
            b'{"time":0,"source":"a","cells":{"dtype":"int32","shape":[0,2],"data":""},'
            b'"blocked":{"dtype":"bool","shape":[1],"data":"AQ=="}}',
            "the numbers of cells and of blocked flags differ",
        ),
    ],
)
def test_a_message_that_is_none_is_refused(record_type: str, message: bytes, why: str) -> None:
    with pytest.raises(TraceError, match=why):
        decode_json(RECORD_TYPES[record_type], message)


@pytest.mark.parametrize(
    ("record_type", "fields", "why"),
    [
        (TaskRecord, {"picoseconds": 1000}, "1000 ps after 0 ns"),
        (TaskRecord, {"end": 2**63 - 1, "picoseconds": 1}, "end is"),
        (StageRecord, {"potential": {"shape": [1, 1], "dtype": "planes", "data": b"\0"}}, "1 bytes for 1"),
        (MapRecord, {}, "free is missing"),
        (MapRecord, {"free": {"shape": [2, 3], "dtype": "bits"}}, "0 bytes for 6 elements"),
        (MapRecord, {"free": {"shape": [2**20, 2**20], "dtype": "bits"}}, r"more than 2\^24"),
        (MapRecord, {"free": {"shape": [6], "dtype": "bits", "data": b"\0"}}, "free has shape"),
        (MapRecord, {"free": {"shape": [1] * 9, "dtype": "bits", "data": b"\0"}}, "free has shape"),
        (MapRecord, {"free": {"shape": [1, 1], "dtype": "object", "data": b"\0"}}, "free is no bool array"),
        (StageRecord, {"potential": {"shape": [1, 1], "dtype": "bits", "data": b"\0"}}, "is no float64 array"),
        (TrajectoryRecord, {"points": [1.0] * 3}, "points has 3 elements"),
        (VisitsRecord, {"block": [1], "iterations": []}, "numbers of blocks and of iterations differ"),
        (BeliefRecord, {"cells": [1, 2], "blocked": []}, "numbers of cells and of blocked flags differ"),
        (SummaryRecord, {"result": "[" * 100_000}, "not JSON of a trace"),
        (SummaryRecord, {"result": "[]"}, "result is no mapping"),
        (SummaryRecord, {"result": ""}, "not JSON of a trace"),
    ],
)
def test_a_protobuf_message_that_is_none_is_refused(
    record_type: type[Record], fields: dict[str, Any], why: str
) -> None:
    with pytest.raises(TraceError, match=why):
        decode(record_type, message_class(record_type)(**fields).SerializeToString(), 0)


def test_a_bomb_of_protobuf_is_refused() -> None:
    """2^24 + 1 elements of a byte each, groups within groups, and a length beyond the message."""
    elements = b"\x22" + b"\x81\x80\x80\x08" + bytes(2**24 + 1)
    with pytest.raises(TraceError, match=r"more than 2\^24"):
        decode(BeliefRecord, b"\x1a\x00" + elements, 0)
    for message in (b"\x0b" * 10_000, b"\x1a\xff\xff\xff\xff\x07", b"\x12\x02\xff\xff"):
        with pytest.raises(TraceError, match="not such a protobuf message"):
            decode(TaskRecord, message, 0)


@pytest.mark.parametrize(("name", "records"), [("records", a_run()), ("mission", a_mission())])
def test_a_trace_of_the_first_format_is_read(name: str, records: list[Record]) -> None:
    """Files of JSON messages that version 0.1.0 wrote."""
    trace = open_trace(Path(__file__).parent / "old" / f"{name}.mcap")
    assert (trace.complete, trace.metadata["run"]["format"]) == (True, "1")
    later = (SampleRecord, ScanRecord, RobotRecord, GoalRecord)
    expected = [each for each in as_told(records) if not isinstance(each, later)]
    # The map of that time had no unknown cells.
    expected = [replace(each, unknown=None) if isinstance(each, MapRecord) else each for each in expected]
    assert all(same(*pair) for pair in zip(trace.records(), expected, strict=True))
    assert trace.result == (expected[-1].result if isinstance(expected[-1], SummaryRecord) else None)
    assert moment(trace.records(kinds=MOMENT_KINDS)).start.size
    assert len(timeline(trace)) == len(expected)
    assert all(line.isprintable() for line in trace_thumbnail(trace))


def trajectory(**points: Any) -> bytes:
    whole = {"dtype": "float64", "shape": [1, 2], "data": "AAAAAAAA8D8AAAAAAADwPw==", **points}
    return json.dumps({"time": 0, "source": "a", "points": whole, "arrived": True}).encode()


@pytest.mark.parametrize(
    ("points", "why"),
    [
        ({"shape": [2**20, 2]}, "16 bytes for 2097152 elements"),
        ({"shape": [2**40, 2]}, r"more than 2\^24"),
        ({"shape": [0, 2]}, "16 bytes for 0 elements"),
        ({"shape": [2]}, "points has shape"),
        ({"shape": [-1, -2]}, "points has no shape"),
        ({"shape": [True, 2]}, "points has no shape"),
        ({"shape": [1] * 5}, "points has shape"),
        ({"dtype": "object"}, "points is no float64 array"),
        ({"data": "%%%%"}, "not base64"),
        ({"data": 3}, "without its base64 text"),
    ],
)
def test_an_array_that_is_none_is_refused(points: dict[str, Any], why: str) -> None:
    assert decode_json(TrajectoryRecord, trajectory()).points.tolist() == [[1.0, 1.0]]  # type: ignore[attr-defined]
    with pytest.raises(TraceError, match=why):
        decode_json(TrajectoryRecord, trajectory(**points))


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "is empty"),
        (b"\x89MC", "is no MCAP file"),
        (b"PK\x03\x04" + bytes(100), "is no MCAP file"),
        (b"\x89MCAP0\r\n", "has no readable content: the file is cut short"),
        (b"\x89MCAP0\r\n" + b"\x06" + b"\xff" * 8 + bytes(99), "a record of 18446744073709551615 bytes"),
    ],
)
def test_a_file_that_is_no_trace_is_refused(tmp_path: Path, content: bytes, why: str) -> None:
    path = tmp_path / "no.mcap"
    path.write_bytes(content)
    with pytest.raises(TraceError, match=why) as caught:
        open_trace(path)
    assert str(caught.value).startswith(str(path))
    assert "hint: " in str(caught.value)


def test_places_that_are_no_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(TraceError, match="does not exist"):
        open_trace(tmp_path / "none.mcap")
    with pytest.raises(TraceError, match="is no file"):
        open_trace(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(TraceError, match="is no file"):
        open_trace(tmp_path / "pipe")
    huge = tmp_path / "huge.mcap"
    huge.touch()
    os.truncate(huge, 2**32 + 1)
    with pytest.raises(TraceError, match="more than 4 GiB"):
        open_trace(huge)


@pytest.mark.parametrize("packing", ["zstd", "lz4"])
def test_a_chunk_that_unpacks_to_more_than_it_says_is_refused(tmp_path: Path, packing: str) -> None:
    """A bomb: 64 MiB of zeros behind a chunk that claims 1,000 bytes, and one that claims 2^40."""
    import lz4.frame  # type: ignore[import-untyped]
    import zstandard
    from mcap.data_stream import RecordBuilder
    from mcap.records import Chunk, Header

    zeros = bytes(2**26)
    packed = zstandard.compress(zeros) if packing == "zstd" else lz4.frame.compress(zeros)
    for claimed, why in ((1000, "a chunk with a wrong size"), (2**40, "a chunk of 1099511627776 bytes")):
        builder = RecordBuilder()
        Header("", "bomb").write(builder)  # type: ignore[no-untyped-call]
        Chunk(packing, packed, 0, 0, 0, claimed).write(builder)
        path = tmp_path / "bomb.mcap"
        path.write_bytes(b"\x89MCAP0\r\n" + builder.end())
        with pytest.raises(TraceError, match=why):
            open_trace(path)


def test_a_file_that_changes_while_it_is_read_is_an_error(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", many(3))
    trace = open_trace(path)
    os.truncate(path, path.stat().st_size - 100)
    with pytest.raises(TraceError, match="has changed since it was opened"):
        list(trace.records())
