"""Statistics, differences and Gantt charts of traces."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from trace_samples import a_mission, a_run, write

from codesign.cli import main
from codesign.ground.activity import share_over_time, union
from codesign.ground.records import MessageRecord, Record, SummaryRecord, TaskRecord
from codesign.views.exports.difference import difference
from codesign.views.exports.statistics import gantt, latencies_table, shares_table, statistics

A_CHAIN: list[Record] = [
    MessageRecord(0, "pci", "host", "fpga", "map", 8, 0, 1_000),
    MessageRecord(200, "pci", "host", "fpga", "goal", 8, 1_000, 2_000),
    TaskRecord(1_000, "fpga", "load", 5_000, 1),
    TaskRecord(4_000, "fpga", "relax", 8_000, 1),
    TaskRecord(0, "host", "decide", 500, 1),
    TaskRecord(9_500, "host", "decide", 10_000, 1),
]


def test_busy_waiting_and_idle_add_up_to_the_run() -> None:
    found = statistics(A_CHAIN)
    shares = {share.where: share for share in found.shares}
    assert found.end == 10_000
    assert all(share.busy + share.waiting + share.idle == found.end for share in found.shares)
    # The fpga works from 1,000 to 8,000, and waits for the map before.
    assert (shares["fpga"].busy, shares["fpga"].waiting) == (7_000, 1_000)
    # The host works twice for 500, and waits from 500 to 2,000 while its messages are under way.
    assert (shares["host"].busy, shares["host"].waiting) == (1_000, 1_500)
    link = shares["pci"]
    assert (link.is_link, link.busy, link.queued, link.deepest) == (True, 2_000, 800, 1)


def test_latencies_have_exact_times_and_all_of_them_in_the_histogram() -> None:
    latencies = {latency.what: latency for latency in statistics(A_CHAIN).latencies}
    decide = latencies["host: task decide"]
    assert decide.times.tolist() == [500, 500]
    for latency in latencies.values():
        counts, ends = latency.histogram()
        assert counts.sum() == len(latency.times)
        assert len(ends) == len(counts) + 1
    assert latencies["pci: waiting for the link"].percentile(0.5) == 800


def test_tables_have_a_row_for_each() -> None:
    found = statistics([*a_run(), *a_mission()])
    assert [row[0].text for row in shares_table(found).rows] == ["fpga", "host", "pci", "uart"]
    assert len(latencies_table(found).rows) == len(found.latencies)


_SPANS = st.lists(st.tuples(st.integers(0, 60), st.integers(0, 20)).map(lambda pair: (pair[0], sum(pair))), max_size=12)


@given(_SPANS, st.integers(1, 9))
def test_shares_are_those_of_a_count_of_picoseconds(spans: list[tuple[int, int]], bins: int) -> None:
    covered = np.zeros(90, bool)
    for begin, end in spans:
        covered[begin:end] = True
    assert int(np.diff(union(spans), axis=1).sum()) == covered.sum()
    each = np.repeat(covered, bins).reshape(bins, 90).mean(axis=1)
    np.testing.assert_allclose(share_over_time(union(spans), 0, 90, bins), each, atol=1e-12)


def test_a_gantt_chart_shades_what_is_busy() -> None:
    chart = gantt(A_CHAIN, 100)
    rows = {row.name: row for row in chart.rows}
    assert set(rows) == {"host", "fpga", "pci: host to fpga", "pci: waiting"}
    busy = rows["fpga"].line()
    assert busy.strip("█▓▒░ ") == ""
    assert abs(busy.count("█") / chart.parts - 0.7) < 0.05
    assert all(len(line) <= 100 for line in chart.lines())
    assert "events" in {row.name for row in gantt(a_mission(), 100).rows}


def test_equal_traces_are_equal() -> None:
    found = difference(lambda: [*a_run(), *a_mission()], lambda: [*a_run(), *a_mission()])
    assert found.equal
    assert all(channel.time is None for channel in found.channels)


def test_the_first_difference_is_the_earliest_in_time() -> None:
    result = {"time_ps": 9, "quality": {"share": 0.5}}
    changed: list[Record] = []
    for record in a_run():
        if isinstance(record, MessageRecord):
            changed.append(replace(record, bits=9505))
        elif isinstance(record, SummaryRecord):
            changed.append(replace(record, result=result))
        else:
            changed.append(record)
    found = difference(a_run, lambda: changed)
    assert not found.equal
    assert (found.channels[0].record, found.channels[0].time) == ("MessageRecord", 0)
    assert found.fields() == [("bits", "9504", "9505")]
    assert found.results == {"time_ps": ("10000000", "9"), "quality.note": ("è", "–")}


def test_a_trace_that_goes_on_differs_where_the_other_one_ends() -> None:
    found = difference(lambda: A_CHAIN, lambda: A_CHAIN[:-1])
    assert found.first is not None
    assert found.first[0] is A_CHAIN[-1]
    assert found.first[1] is None
    assert found.channels[0].same == 1


def test_the_command_line(tmp_path: Path) -> None:
    run, mission = write(tmp_path / "run.mcap", a_run()), write(tmp_path / "mission.mcap", a_mission())
    invoke = CliRunner().invoke
    stats = json.loads(invoke(main, ["trace", "stats", str(run), "--json"]).output)
    assert stats["end_ps"] == statistics(a_run()).end
    assert "fpga: stage" in invoke(main, ["trace", "stats", str(run)]).output
    same = invoke(main, ["trace", "diff", str(run), str(run)])
    assert (same.exit_code, same.output) == (0, "all records are equal\n")
    other = invoke(main, ["trace", "diff", str(run), str(mission)])
    assert other.exit_code == 3
    assert other.output.startswith("first difference at 0 ps: ")
    assert json.loads(invoke(main, ["trace", "diff", str(run), str(mission), "--json"]).output)["equal"] is False
    chart = invoke(main, ["trace", "timeline", str(mission), "--width", "80"])
    assert chart.exit_code == 0
    assert invoke(main, ["trace", "timeline", str(mission), "--from", "2 s", "--to", "1 s"]).exit_code == 2
