"""Whatever the bytes of a trace, only the project's own errors come out."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from trace_samples import a_mission, a_run

from codesign.ground.errors import TraceError
from codesign.ground.records import ACTIVITY_KINDS, RECORD_TYPES, Record
from codesign.views.exports.perfetto import write_perfetto
from codesign.views.exports.poses import POSE_KINDS, poses_csv
from codesign.views.exports.statistics import gantt, latencies_table, shares_table, statistics
from codesign.views.exports.waveform import waveform_of, write_waveform
from codesign.views.report.render import render_text
from codesign.views.trace import MOMENT_KINDS, Trace, moment, moment_lines, open_trace, timeline, trace_thumbnail
from codesign.views.trace.messages import decode, encode
from codesign.views.trace.reader import decode_json, scan


def exercise(trace: Trace) -> None:
    """Everything that the command line does with a trace."""
    lines = [*map(str, trace.rows()), *map(str, trace.channel_rows())]
    lines += [cell for row in timeline(trace, limit=50) for cell in row.cells()]
    lines += trace_thumbnail(trace)
    if any(channel.record == "MapRecord" and channel.messages for channel in trace.channels):
        lines += moment_lines(moment(trace.records(kinds=MOMENT_KINDS), where=str(trace.path)))
    assert "".join(poses_csv(trace.records(kinds=POSE_KINDS)))
    with TemporaryDirectory() as folder:
        write_waveform(waveform_of(trace.records(kinds=ACTIVITY_KINDS)), Path(folder) / "run.vcd")
    write_perfetto(trace.records(kinds=ACTIVITY_KINDS), io.BytesIO())
    lines += gantt(trace.records(kinds=ACTIVITY_KINDS), 80).lines()
    found = statistics(trace.records())
    assert render_text(shares_table(found)) + render_text(latencies_table(found))
    assert trace.result is None or trace.result
    assert all(line.isprintable() for line in lines)


@given(data=st.data())
@settings(max_examples=examples(250))
def test_only_trace_errors_come_out_of_mutated_files(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Checksums are left out, so that the mutations reach what lies behind them."""
    folder = tmp_path_factory.getbasetemp()
    seed = folder / "seed.mcap"
    if not seed.exists():
        without_checksums(seed)
    content = bytearray(seed.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        new = data.draw(st.binary(max_size=9) | st.sampled_from([b"\xff" * 8, b"\x00" * 8, b"[", b'"', b"-1"]))
        content[place : place + data.draw(st.sampled_from([0, 1, len(new)]))] = new
    path = folder / "mutated.mcap"
    path.write_bytes(content)
    fault = ""
    try:
        exercise(open_trace(path))
    except TraceError as error:
        fault = str(error)
    assert not fault or str(path) in fault


def without_checksums(path: Path) -> None:
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE, enable_crcs=False)
        writer.start()
        writer.add_metadata("run", {"format": "1"})
        for record in a_run() + a_mission():
            names = {"record": type(record).__name__, "source": record.source}
            channel = writer.register_channel("/any", "protobuf", 0, names)
            writer.add_message(channel, record.time // 1000, encode(record), 0)
        writer.finish()  # type: ignore[no-untyped-call]


@given(st.sampled_from(a_run() + a_mission()), st.data())
@settings(max_examples=examples(250))
def test_only_trace_errors_come_out_of_mutated_messages(record: Record, data: st.DataObject) -> None:
    """A message with some bytes replaced is a good record or an error."""
    message = bytearray(encode(record))
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(message)))
        new = data.draw(st.binary(max_size=6))
        message[place : place + data.draw(st.integers(0, 6))] = new
    check(record, lambda: decode(type(record), bytes(message), record.time // 1000))


OLD = {name: [item for item in scan(Path(__file__).parent / "old" / f"{name}.mcap")] for name in ("records", "mission")}

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["dtype", "shape"]), inner),
    max_leaves=6,
)  # fmt: skip


def old_messages() -> list[tuple[type[Record], bytes]]:
    """The messages of records of the files of the first format."""
    messages = []
    for items in OLD.values():
        kinds = {item.id: item.metadata.get("record", "") for item in items if hasattr(item, "topic")}
        messages += [
            (RECORD_TYPES[kinds[item.channel_id]], item.data)
            for item in items
            if kinds.get(getattr(item, "channel_id", None)) in RECORD_TYPES
        ]
    return messages


@given(st.sampled_from(old_messages()), st.data())
@settings(max_examples=examples(250))
def test_only_trace_errors_come_out_of_mutated_messages_in_json(
    old: tuple[type[Record], bytes], data: st.DataObject
) -> None:
    """A message with one value replaced, one level down in arrays too, is a good record or an error."""
    record_type, text = old
    message = json.loads(text)
    key = data.draw(st.sampled_from(sorted(message)))
    if isinstance(message[key], dict) and message[key] and data.draw(st.booleans()):
        message[key][data.draw(st.sampled_from(sorted(message[key])))] = data.draw(values)
    else:
        message[key] = data.draw(values)
    check(decode_json(record_type, text), lambda: decode_json(record_type, json.dumps(message).encode()))


def check(record: Record, make: Callable[[], Record]) -> None:
    """What ``make`` gives is an error of traces, or has fields of the types of ``record``."""
    try:
        back = make()
    except TraceError:
        return
    for item in fields(back):
        either = type(getattr(record, item.name)) | type(None) | np.ndarray
        assert isinstance(getattr(back, item.name), either | float)
