"""The words of ``hwsw trace info`` and ``hwsw trace show``, and the picture of a potential."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from places import ROOT
from trace_samples import PluginRecord, a_run, write

from codesign.ground.errors import TraceError, printable
from codesign.ground.records import RECORD_TYPES, MapRecord, MessageRecord, StageRecord, TrajectoryRecord
from codesign.views.trace import open_trace, thumbnail, timeline, trace_thumbnail
from codesign.views.trace.messages import schema_name, topic_of
from codesign.views.trace.moment import SHADES, WALL, row_of

TIMELINE = """
0 ps||host|map|2 × 3 cells, 5 free, 2 goals, 0.05 m a cell
12 ps|1.235 us|pci|message map|host to fpga, 1.188 kB, waited 12 ps
1.235 us|6.765 us|fpga|visits of stage 0|p = 7: 50 visits of 4 blocks, 234 iterations, 1 to 8 each
1.235 us|6.765 us|fpga|stage 0|p = 7: 3 sweeps, 50 visits, 222 iterations, 1,998 cycles; 4 local maxima
8 us||fpga|visits of stage 1|p = 15: 0 visits
8 us|1 us|fpga|stage 1|p = 15: 1 sweep; 0 local maxima
9 us|100 ns|host|task decide|99 cycles
9.1 us||host|trajectory|(1, 0.25) to (0, 2), 2.016 cells long, arrives
9.5 us||fpga|sample|busy 0.25
10 us||fpga|utilisation|busy 7 us, 70.0% of 10 us
10 us||pci|utilisation|busy 0 ps, no time
10 us||system|result|2 figures
"""


def test_the_timeline_of_a_run(tmp_path: Path) -> None:
    trace = open_trace(write(tmp_path / "run.mcap", a_run()))
    lines = ["|".join(row.cells()) for row in timeline(trace)]
    assert lines == TIMELINE.strip().splitlines()
    assert ["|".join(row.cells()) for row in timeline(trace, limit=3)] == lines[:3]
    assert ["|".join(row.cells()) for row in timeline(trace, ["/fpga/stage"])] == [lines[3], lines[5]]
    assert timeline(trace, limit=0) == []


@given(st.lists(st.integers(0, 5)), st.integers(0, 8))
def test_rows_that_begin_together_keep_their_order(begins: list[int], limit: int) -> None:
    records = [MessageRecord(0, "pci", "a", "b", str(index), 8, begin, 9) for index, begin in enumerate(begins)]
    trace = SimpleNamespace(records=lambda _: records)
    rows = timeline(trace)
    assert [(row.begin, row.what) for row in rows] == [
        (begin, f"message {index}") for begin, index in sorted((b, i) for i, b in enumerate(begins))
    ]
    assert timeline(trace, limit=limit) == rows[:limit]


def test_a_record_of_a_plug_in_and_an_empty_trajectory_have_lines() -> None:
    assert row_of(PluginRecord(5, "sensor", 20.5)).cells()[2:] == ("sensor", "plugin", "temperature 20.5")
    empty = TrajectoryRecord(5, "fpga", np.zeros((0, 2)), False)
    assert row_of(empty).details == "empty"


def test_text_from_a_file_cannot_steer_the_terminal() -> None:
    row = row_of(MessageRecord(0, "p\x1b[31mci", "a\nb", "c", "d\x07" * 99, 8, 0, 0))
    assert all(cell.isprintable() for cell in row.cells())
    assert len(row.what) < 70
    assert printable("\x1b[2Jab") == "\N{REPLACEMENT CHARACTER}[2Jab"


def test_the_facts_of_a_trace(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", a_run(), platform="virtex4-pci")
    info = open_trace(path)
    assert dict(info.rows()) == {
        "file": str(path),
        "size": f"{path.stat().st_size:,} bytes",
        "complete": "yes",
        "written by": "hwsw-codesign",
        "messages": str(info.messages),
        "simulated time": "0 ps to 10 us",
        "run.format": "2",
        "run.library": "hwsw-codesign",
        "run.level": "blocks",
        "run.platform": "virtex4-pci",
        "attachment run.json": f"{len(info.attachments['run.json'].data)} bytes",
    }
    assert info.channel_rows()[0] == ("/map", "codesign.MapRecord", 1)
    assert sum(count for _, _, count in info.channel_rows()) == info.messages


def test_the_docs_name_every_record_and_topic() -> None:
    text = (ROOT / "docs" / "traces.md").read_text(encoding="utf-8")
    sources = {
        "MessageRecord": "pci",
        "TaskRecord": "host",
        "PoseRecord": "robot",
        "RobotRecord": "robot",
        "GoalRecord": "robot",
        "BeliefRecord": "robot",
        "CommandRecord": "robot",
        "PositionsRecord": "fleet",
        "ObstacleRecord": "map",
        "ScanRecord": "robot",
        "SampleRecord": "uart",
    }
    for name, record_type in RECORD_TYPES.items():
        topic = topic_of(record_type, sources.get(name, "fpga"))
        assert f"| `{topic}` | `{name}` | `{schema_name(record_type)}` |" in text


def test_a_cut_file_says_so(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", a_run())
    path.write_bytes(path.read_bytes()[:-20])
    info = open_trace(path)
    assert not info.complete
    assert dict(info.rows())["complete"] == "no, only the part before: the file is cut short"
    empty = open_trace(write(tmp_path / "empty.mcap", []))
    assert dict(empty.rows())["simulated time"] == "no messages"


def test_a_thumbnail_rises_towards_the_goal_and_shows_walls() -> None:
    """A corridor whose potential doubles from cell to cell: the steps of the logarithm are even."""
    potential = np.array([2.0 ** np.arange(-8, 0)], dtype=np.float64)
    assert thumbnail(potential, width=8) == [SHADES]
    free = np.ones((1, 8), dtype=bool)
    free[0, 3] = False
    assert thumbnail(potential, free, width=8) == [SHADES[:3] + WALL + SHADES[4:]]
    assert thumbnail(np.zeros((2, 3), np.float64)) == ["   ", "   "]
    # Twice as wide as the picture: cells are joined two by four, each shows its greatest value.
    joined = thumbnail(np.repeat(np.repeat(potential, 4, axis=0), 2, axis=1), width=8)
    assert joined == [SHADES]


@pytest.mark.parametrize(("row", "column"), [(0, 0), (5, 5), (6, 3), (13, 4), (15, 15)])
def test_walls_of_one_cell_are_seen_wherever_they_stand_and_doors_stay_open(row: int, column: int) -> None:
    free = np.ones((16, 16), dtype=bool)
    free[row], free[:, column] = False, False
    free[8:12, column] = True
    lines = thumbnail(free.astype(np.float64), free, width=8)
    picture = np.array([list(line) for line in lines]) == WALL
    expected = np.zeros((4, 8), dtype=bool)
    expected[row // 4], expected[:, column // 2] = True, True
    expected[2, column // 2] = False
    assert np.array_equal(picture, expected)


@pytest.mark.parametrize(
    ("cells", "glyph"),
    [
        ([(2, 0), (3, 1), (4, 2), (5, 3)], WALL),
        ([(5, 0), (5, 1), (4, 2), (3, 3)], WALL),
        ([(0, 1), (1, 1), (2, 2), (3, 2), (4, 1), (5, 0), (6, 0), (7, 1)], WALL),
        ([(2, 0), (2, 1), (2, 3)], SHADES[0]),
        ([(0, 3), (1, 3), (2, 3), (3, 3)], SHADES[0]),
        ([(2, 0), (4, 1), (2, 2), (4, 3)], SHADES[0]),
    ],
)
def test_a_tile_is_a_wall_where_obstacles_cross_it(cells: list[tuple[int, int]], glyph: str) -> None:
    """Straight, aslant or bent; with a gap, or of half the height, they leave the tile free."""
    free = np.ones((8, 4), dtype=bool)
    free[tuple(np.transpose(cells))] = False
    assert thumbnail(np.full((8, 4), 0.5), free, width=1) == [glyph]
    assert thumbnail(np.full((8, 4), 0.5), free[::-1], width=1) == [glyph]


@given(npst.arrays(np.float64, st.tuples(st.integers(0, 30), st.integers(0, 30))), st.integers(1, 20))
def test_any_field_has_a_thumbnail_of_its_width(potential: np.ndarray, width: int) -> None:
    lines = thumbnail(potential, width=width)
    assert all(1 <= len(line) <= width for line in lines)
    assert len(lines) <= potential.shape[0]


def test_the_thumbnail_of_a_trace_is_that_of_its_last_stage(tmp_path: Path) -> None:
    run = a_run()
    stages = [record for record in run if isinstance(record, StageRecord)]
    whole = open_trace(write(tmp_path / "run.mcap", run))
    map_record = run[0]
    assert isinstance(map_record, MapRecord)
    *picture, legend = trace_thumbnail(whole)
    assert picture == thumbnail(stages[-1].potential, map_record.free)
    assert legend.startswith("one glyph is 1 cell; █ wall")
    assert trace_thumbnail(whole, width=2)[-1].startswith("one glyph is 4 × 2 cells; ")
    assert trace_thumbnail(open_trace(write(tmp_path / "none.mcap", run[:3]))) == []
    odd = MapRecord(0, "host", np.ones((5, 5), bool), np.zeros((1, 2), np.int32), None)
    with pytest.raises(TraceError, match=r"a potential of \(2, 3\) on a map of \(5, 5\)"):
        trace_thumbnail(open_trace(write(tmp_path / "odd.mcap", [odd, stages[0]])))
