"""Exports: trace events that Perfetto takes, and tables of poses."""

from __future__ import annotations

import csv
import io
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from trace_samples import a_mission, a_run, write

from codesign.cli import main
from codesign.records import MessageRecord, MissionRecord, PoseRecord, PositionsRecord, Record, TaskRecord
from codesign.trace import perfetto, poses_csv


def events_of(records: list[Record]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads("".join(perfetto(records)))["traceEvents"]
    return found


def tracks_of(events: list[dict[str, Any]]) -> dict[int, str]:
    return {event["tid"]: event["args"]["name"] for event in events if event["name"] == "thread_name"}


def test_components_links_and_waiting_are_tracks() -> None:
    events = events_of([*a_run(), *a_mission()])
    tracks = tracks_of(events)
    assert set(tracks.values()) == {
        "host", "fpga", "fpga: stages", "fpga: visits", "pci: host to fpga", "pci: waiting",
        "uart: host to fpga", "uart: waiting", "robot: plans",
    }  # fmt: skip
    assert all(event["tid"] in tracks for event in events if event["ph"] in "Xbe")
    (message,) = (event for event in events if event["ph"] == "X" and tracks[event["tid"]].startswith("pci"))
    assert (message["name"], message["ts"], message["dur"]) == ("map", 0.000012, 1.234555)
    waits = [event for event in events if event["ph"] in "be" and event["cat"] == "pci: waiting"]
    assert [(event["ph"], event["ts"]) for event in waits] == [("b", 0.0), ("e", 0.000012)]
    (dropped,) = (event for event in events if event["name"] == "map (dropped)")
    assert dropped["args"] == {
        "from": "host", "to": "fpga", "bits": 24, "outcome": "dropped", "attempts": 3, "reason": "link down",
    }  # fmt: skip


def test_a_plan_is_a_span_from_request_to_answer_and_events_are_marks() -> None:
    events = events_of(a_mission())
    (plan,) = (event for event in events if event["name"] == "plan")
    assert (plan["ts"], plan["dur"], plan["args"]) == (0.0, 3.0, {"answer": "plan ready"})
    marks = [event["name"] for event in events if event["ph"] == "i" and event["s"] == "g"]
    assert marks == ["plan requested", "plan ready", "contact", "ended"]
    speeds = [(event["ts"], event["args"]["m/s"]) for event in events if event["ph"] == "C"]
    assert speeds == [(100_000.0, 0.5), (1_700_000.0, 0.0)]


def test_a_plan_that_was_never_answered_ends_with_the_mission() -> None:
    events = events_of(
        [MissionRecord(5, "r", "plan_requested", ""), MissionRecord(9_000_005, "r", "ended", "walled in")]
    )
    (plan,) = (event for event in events if event["name"] == "plan")
    assert (plan["dur"], plan["args"]["answer"]) == (9.0, "ended")


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 30)), max_size=20))
def test_spans_of_one_track_never_overlap(begins: list[tuple[int, int]]) -> None:
    """Tasks that preempt or run on several cores, emitted as they end."""
    spans = sorted(((begin + length, begin) for begin, length in begins))
    tasks: list[Record] = [
        TaskRecord(begin * 10**6, "host", f"task {number}", end * 10**6, 1)
        for number, (end, begin) in enumerate(spans)
    ]
    shown: dict[int, list[tuple[float, float]]] = {}
    for event in events_of(tasks):
        if event["ph"] == "X":
            shown.setdefault(event["tid"], []).append((event["ts"], event["ts"] + event["dur"]))
    assert sum(map(len, shown.values())) == len(spans)
    for lane in shown.values():
        lane.sort()
        assert all(first[1] <= second[0] for first, second in itertools.pairwise(lane))


def test_names_with_markup_stay_text() -> None:
    evil = '"}]</script>\n'
    events = events_of([MessageRecord(0, evil, "a", "b", evil, 8, 0, 5)])
    assert evil in {event["name"] for event in events}


def test_poses_are_a_table_with_exact_times() -> None:
    positions = np.array([[1.0, 2.5], [3.0, 0.0]])
    records: list[Record] = [
        PoseRecord(1, "robot", 1 / 3, 0.0, 0.5, 0.25),
        PositionsRecord(2**62, "=fleet", 7, positions),
        TaskRecord(3, "host", "decide", 4, 1),
    ]
    rows = list(csv.reader(io.StringIO("".join(poses_csv(records)))))
    assert rows == [
        ["time_ps", "source", "robot", "row", "column", "heading", "speed"],
        ["1", "robot", "0", repr(1 / 3), "0.0", "0.5", "0.25"],
        [str(2**62), "'=fleet", "0", "1.0", "2.5", "", ""],
        [str(2**62), "'=fleet", "1", "3.0", "0.0", "", ""],
    ]


def test_the_command_line_writes_both(tmp_path: Path) -> None:
    path = write(tmp_path / "mission.mcap", a_mission())
    events, poses = tmp_path / "events.json", tmp_path / "poses.csv"
    done = CliRunner().invoke(
        main, ["trace", "export", str(path), "--perfetto", str(events), "--poses", str(poses)]
    )
    assert done.exit_code == 0
    assert json.loads(events.read_text()) == {
        "displayTimeUnit": "ns",
        "traceEvents": events_of(a_mission()),
    }
    assert len(poses.read_text().splitlines()) == 5
    again = CliRunner().invoke(main, ["trace", "export", str(path), "--poses", str(path)])
    assert again.exit_code == 2
    assert path.read_bytes().startswith(b"\x89MCAP")
    assert CliRunner().invoke(main, ["trace", "export", str(path)]).exit_code == 2
