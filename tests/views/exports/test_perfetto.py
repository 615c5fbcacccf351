"""Perfetto's own protobuf, read back with its published schema: all spans are there, and none overlaps another one."""

from __future__ import annotations

import io
import itertools
from collections import Counter
from pathlib import Path
from typing import Any

from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from perfetto.protos.perfetto.trace.perfetto_trace_pb2 import Trace, TrackEvent
from trace_samples import a_mission, a_run, write

from codesign.cli import main
from codesign.ground.records import (
    ACTIVITY_KINDS,
    MessageRecord,
    MissionRecord,
    PoseRecord,
    Record,
    StageRecord,
    TaskRecord,
    VisitsRecord,
)
from codesign.views.exports.perfetto import write_perfetto


class Shown:
    """What a reader of the file draws: spans by track, marks, counters; found with the published schema alone."""

    def __init__(self, data: bytes) -> None:
        trace = Trace.FromString(data)
        self.tracks: dict[int, str] = {}
        self.units: dict[str, str] = {}
        self.spans: list[dict[str, Any]] = []
        self.marks: list[tuple[int, str, str]] = []
        self.values: dict[str, list[tuple[int, float]]] = {}
        opened: dict[int, list[dict[str, Any]]] = {}
        for packet in trace.packet:
            if packet.HasField("track_descriptor"):
                described = packet.track_descriptor
                self.tracks[described.uuid] = described.name
                if described.HasField("counter"):
                    self.units[described.name] = described.counter.unit_name
                continue
            event = packet.track_event
            track = self.tracks[event.track_uuid]
            if event.type == TrackEvent.TYPE_SLICE_BEGIN:
                span = {
                    "track": track,
                    "name": event.name,
                    "begin": packet.timestamp,
                    "flows": set(event.flow_ids),
                    "ended": set(event.terminating_flow_ids),
                    "args": {each.name: getattr(each, each.WhichOneof("value")) for each in event.debug_annotations},
                }
                opened.setdefault(event.track_uuid, []).append(span)
                self.spans.append(span)
            elif event.type == TrackEvent.TYPE_SLICE_END:
                opened[event.track_uuid].pop()["end"] = packet.timestamp
            elif event.type == TrackEvent.TYPE_INSTANT:
                self.marks.append((packet.timestamp, track, event.name))
            elif event.type == TrackEvent.TYPE_COUNTER:
                self.values.setdefault(track, []).append((packet.timestamp, event.double_counter_value))
        assert not any(opened.values()), "each span that begins ends"

    def named(self, name: str) -> dict[str, Any]:
        (span,) = (span for span in self.spans if span["name"] == name)
        return span


def shown(records: list[Record]) -> Shown:
    out = io.BytesIO()
    write_perfetto(records, out)
    return Shown(out.getvalue())


def test_components_links_and_waiting_are_tracks() -> None:
    seen = shown([*a_run(), *a_mission()])
    assert {span["track"] for span in seen.spans} == {
        "host", "fpga: stages", "fpga: visits", "pci: host to fpga", "pci: waiting",
        "uart: host to fpga", "uart: waiting", "robot: plans",
    }  # fmt: skip
    (message,) = (span for span in seen.spans if span["track"] == "pci: host to fpga")
    assert (message["name"], message["begin"], message["end"]) == ("map", 0, 1234)
    assert (message["args"]["begin_ps"], message["args"]["end_ps"]) == (12, 1_234_567)
    dropped = seen.named("map (dropped)")
    assert {key: value for key, value in dropped["args"].items() if not key.endswith("_ps")} == {
        "from": "host", "to": "fpga", "bits": 24, "outcome": "dropped", "attempts": 3, "reason": "link down",
    }  # fmt: skip


def test_no_record_is_dropped() -> None:
    records = [*a_run(), *a_mission()]
    kinds = Counter(type(record) for record in records)
    waits = sum(isinstance(record, MessageRecord) and record.begin > record.time for record in records)
    drawn = sum(kinds[each] for each in (TaskRecord, StageRecord, VisitsRecord, MessageRecord))
    plans = 1
    seen = shown(records)
    assert len(seen.spans) == drawn + waits + plans
    assert len([mark for mark in seen.marks if mark[1] == "platform"]) == kinds[MissionRecord]
    assert len(seen.values["robot: speed"]) == kinds[PoseRecord]


def test_a_plan_is_a_span_from_request_to_answer_and_events_are_marks() -> None:
    seen = shown(a_mission())
    plan = seen.named("plan")
    assert (plan["begin"], plan["end"], plan["args"]["answer"]) == (0, 3000, "plan ready")
    assert [name for _, track, name in seen.marks if track == "platform"] == [
        "plan requested", "plan ready", "contact", "ended",
    ]  # fmt: skip
    assert seen.values["robot: speed"] == [(10**8, 0.5), (17 * 10**8, 0.0)]
    assert seen.units["robot: speed"] == "m/s"


def test_a_plan_that_was_never_answered_ends_with_the_mission() -> None:
    seen = shown([MissionRecord(5, "r", "plan_requested", ""), MissionRecord(9_000_005, "r", "ended", "walled in")])
    plan = seen.named("plan")
    assert (plan["end"], plan["args"]["answer"]) == (9000, "ended")


def test_flows_lead_from_a_task_over_its_message_to_the_task_that_takes_it() -> None:
    tasks: list[Record] = [
        TaskRecord(0, "host", "load", 10_000, 1),
        MessageRecord(12_000, "pci", "host", "fpga", "map", 8, 15_000, 20_000),
        TaskRecord(21_000, "fpga", "relax", 30_000, 1),
        MessageRecord(30_000, "pci", "fpga", "host", "answer", 8, 30_000, 40_000),
        TaskRecord(5_000, "fpga", "idle before", 6_000, 1),
        TaskRecord(41_000, "host", "command", 50_000, 1),
        MessageRecord(50_000, "pci", "host", "fpga", "lost", 8, 50_000, 60_000, "dropped", "link down"),
        TaskRecord(61_000, "fpga", "after", 62_000, 1),
    ]
    seen = shown(tasks)
    origin = {flow: span["name"] for span in seen.spans for flow in span["flows"]}
    target = {flow: span["name"] for span in seen.spans for flow in span["ended"]}
    assert origin.keys() == target.keys()
    assert {(origin[flow], target[flow]) for flow in origin} == {
        ("load", "map"), ("map", "relax"), ("relax", "answer"), ("answer", "command"), ("command", "lost (dropped)"),
    }  # fmt: skip


def test_queues_and_busy_shares_are_counters() -> None:
    seen = shown(
        [
            MessageRecord(0, "pci", "a", "b", "one", 8, 0, 500_000),
            MessageRecord(100_000, "pci", "a", "b", "two", 8, 500_000, 1_000_000),
        ]
    )
    assert seen.values["pci: messages waiting"] == [(100, 1.0), (500, 0.0)]
    assert {value for _, value in seen.values["pci: busy"][:-1]} == {100.0}
    assert seen.values["pci: busy"][-1] == (1000, 0.0)


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 30)), max_size=20))
def test_spans_of_one_track_never_overlap(begins: list[tuple[int, int]]) -> None:
    """Tasks that preempt or run on several cores, emitted as they end; times are no whole nanoseconds."""
    spans = sorted(((begin + length, begin) for begin, length in begins))
    tasks: list[Record] = [
        TaskRecord(begin * 300, "host", f"task {number}", end * 300, 1) for number, (end, begin) in enumerate(spans)
    ]
    lanes: dict[str, list[tuple[int, int]]] = {}
    seen = shown(tasks)
    for span in seen.spans:
        lanes.setdefault(span["track"], []).append((span["begin"], span["end"]))
    assert sum(map(len, lanes.values())) == len(spans)
    for lane in lanes.values():
        assert all(first[1] <= second[0] for first, second in itertools.pairwise(lane)), "in the order of the file"


def test_names_with_markup_stay_text() -> None:
    evil = '"}]</script>\n'
    assert evil in {span["name"] for span in shown([MessageRecord(0, evil, "a", "b", evil, 8, 0, 5)]).spans}


def test_the_command_line_writes_it(tmp_path: Path) -> None:
    path = write(tmp_path / "mission.mcap", a_mission())
    events = tmp_path / "events.pftrace"
    done = CliRunner().invoke(main, ["trace", "export", str(path), "--perfetto", str(events)])
    assert done.exit_code == 0, done.output
    kept = [record for record in a_mission() if isinstance(record, ACTIVITY_KINDS)]
    assert Shown(events.read_bytes()).spans == shown(kept).spans
    assert CliRunner().invoke(main, ["trace", "export", str(path)]).exit_code == 2
    assert CliRunner().invoke(main, ["trace", "export", str(path), "--perfetto", str(path)]).exit_code == 2
    assert path.read_bytes().startswith(b"\x89MCAP")
