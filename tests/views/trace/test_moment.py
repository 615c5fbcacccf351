"""A mission at one moment: its map, belief, way and robot are those that the records add up to by then."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from trace_samples import a_mission, a_run, write

from codesign.cli import main
from codesign.ground.errors import TraceError
from codesign.ground.records import (
    BeliefRecord,
    FieldRecord,
    MapRecord,
    MessageRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    TrajectoryRecord,
)
from codesign.views.trace import MOMENT_KINDS, moment, moment_lines, open_trace, timeline, trace_thumbnail
from codesign.views.trace.moment import SHADES, row_of

SECOND = 10**12

EARLY = """
@▒▒▒▒
*····
*·▒▒▒
***▒G
▒▒▒▒▒
""".strip("\n")


def a_room() -> list[Record]:
    """A room of 3 × 3 cells with a wall inside, a robot that learns of it, and an obstacle for a while."""
    free = np.zeros((5, 5), bool)
    free[1:4, 1:5] = True
    free[0, 0] = True
    free[1:4, 0] = True
    free[2, 2:] = False
    free[3, 3] = False
    seen = np.argwhere(np.ones((5, 5), bool) & (np.add.outer(np.arange(5), np.arange(5)) < 6)).astype(np.int32)
    return [
        MapRecord(0, "map", free, np.array([[3, 4]], np.int32), 0.1),
        BeliefRecord(0, "robot", seen, np.zeros(len(seen), bool)),
        PoseRecord(0, "robot", 0.0, 0.0, 0.0, 0.0),
        TrajectoryRecord(SECOND, "robot", np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 2.0]]), False),
        ObstacleRecord(2 * SECOND, "map", np.array([[1, 2]], np.int32), True),
        BeliefRecord(3 * SECOND, "robot", np.array([[1, 2], [3, 3], [1, 3]], np.int32), np.array([True, True, True])),
        PoseRecord(3 * SECOND, "robot", 3.0, 0.0, np.pi / 2, 0.25),
        MissionRecord(3 * SECOND, "robot", "plan_requested", "the way is blocked"),
        ObstacleRecord(4 * SECOND, "map", np.array([[1, 2]], np.int32), False),
        PoseRecord(5 * SECOND, "robot", 3.0, 2.0, 0.0, 0.0),
        MissionRecord(5 * SECOND, "robot", "ended", "reached"),
    ]


def test_a_moment_holds_what_was_told_by_then() -> None:
    early = moment(a_room(), SECOND)
    assert early.time == SECOND
    assert early.path is not None
    assert early.driven.tolist() == [[0.0, 0.0]]
    assert early.free.sum() == early.start.sum()
    assert early.events == ()
    then = moment(a_room(), 3 * SECOND)
    assert (then.start & ~then.free).nonzero()[0].tolist() == [1]
    assert then.belief is not None
    assert then.belief[[1, 3, 1, 0, 4], [2, 3, 3, 0, 4]].tolist() == [2, 2, 2, 0, 1]
    assert then.pose is not None
    assert then.pose.row == 3.0
    end = moment(a_room())
    assert end.time == 5 * SECOND
    assert end.free.all() == end.start.all()
    assert len(end.driven) == 3
    assert [event.event for event in end.events] == ["plan_requested", "ended"]


def test_the_map_of_a_moment_reads_as_agreed() -> None:
    *picture, legend, when, where, known = moment_lines(moment(a_room(), SECOND))
    assert picture == EARLY.splitlines()
    assert "@ robot, G goal, * path" in legend
    assert when == "at 1 s"
    assert where == "robot at row 0.00, column 0.00, heading 0°, 0 m/s"
    # 19 of 25 cells were taken for free; walls among them are four in row 0, two in row 2 and two in row 4.
    assert known == "76.0% of the cells known, 8 of them no longer right"


def test_what_came_is_told_from_walls_and_a_cell_wrongly_blocked_from_both() -> None:
    lines = moment_lines(moment(a_room(), 3 * SECOND))
    assert lines[1] == "*·▓?·"
    assert lines[3][:4] == "@**█"
    assert "heading 90°, 0.25 m/s" in lines[7]
    assert "1 cell blocked and 0 freed since the start" in lines[8]
    assert lines[-1] == "3 s: plan requested: the way is blocked"


def test_a_large_map_is_joined_and_a_robot_goes_before_all_else() -> None:
    free = np.ones((40, 60), bool)
    records: list[Record] = [
        MapRecord(0, "map", free, np.array([[0, 0]], np.int32), None),
        PoseRecord(0, "robot", 1.0, 2.0, 0.0, 0.0),
        TrajectoryRecord(0, "robot", np.array([[1.0, 2.0], [39.0, 59.0]]), True),
    ]
    *picture, legend, _, _ = moment_lines(moment(records), width=20)
    assert legend.startswith("one glyph is 6 × 3 cells; ")
    assert [len(line) for line in picture] == [20] * 7
    assert picture[0][0] == "@"
    assert picture[-1][-1] == "*"
    # The way crosses all tiles of the diagonal without a gap.
    assert all("*" in line for line in picture)


def test_all_robots_of_a_fleet_are_shown() -> None:
    positions = np.array([[0.0, 0.0], [1.0, 3.2], [9.0, 9.0], [np.nan, 0.0]])
    records: list[Record] = [
        MapRecord(0, "map", np.ones((2, 4), bool), np.zeros((0, 2), np.int32), None),
        PositionsRecord(0, "fleet", 0, positions),
    ]
    picture = moment_lines(moment(records))[:2]
    assert picture == ["@···", "···@"]


def test_a_trace_without_a_map_or_with_a_cell_outside_of_it_has_no_moment() -> None:
    with pytest.raises(TraceError, match="no map at that time"):
        moment([])
    with pytest.raises(TraceError, match="a cell is outside of the map"):
        moment([*a_room(), ObstacleRecord(6 * SECOND, "map", np.array([[5, 0]], np.int32), True)])


def test_lines_of_a_mission_read_naturally(tmp_path: Path) -> None:
    trace = open_trace(write(tmp_path / "mission.mcap", a_mission()))
    told = {(row.source, row.what): row.details for row in timeline(trace)}
    assert told["uart", "message map"] == "host to fpga, 3 B, waited 10 ps, 3 attempts, dropped: link down"
    assert told["fpga", "field distance"] == "its values are left out in a mission"
    assert row_of(a_mission()[6]).details == "6 cells with a value, 0 to 5 cells"
    assert told["robot", "contact"] == "an obstacle came"
    assert told["robot", "belief"] == "2 cells learnt, 2 blocked"
    assert told["world", "obstacle"] == "1 cell free again"
    assert told["fleet", "update 7"] == "2 robots"
    assert told["robot", "pose"] == "row 2.00, column 0.50, 0 m/s"
    assert told["robot", "robot"] == "radius 0.1 m, at most 0.5 m/s, sees 4 m with 180 rays"
    assert told["robot", "goal"] == "(3, 5)"


def test_a_span_of_the_time_line_has_what_touches_it(tmp_path: Path) -> None:
    trace = open_trace(write(tmp_path / "mission.mcap", a_mission()))
    rows = timeline(trace, begin=2_000_000, end=3_000_000)
    # The plan and the message began before, and had not ended.
    told = ["plan 1", "message map", "field distance", "trajectory", "command", "plan ready"]
    assert [row.what for row in rows] == told
    assert timeline(trace, begin=10**13) == []


def test_a_field_is_shown_with_its_lowest_as_the_brightest(tmp_path: Path) -> None:
    assert trace_thumbnail(open_trace(write(tmp_path / "mission.mcap", a_mission()))) == []
    plan = [record for record in a_mission() if not isinstance(record, MissionRecord)]
    picture = trace_thumbnail(open_trace(write(tmp_path / "plan.mcap", plan)))
    assert picture[0][0] == SHADES[-1]
    assert picture[0][5] == SHADES[0]
    assert picture[2] == " " * 6
    assert picture[-1].endswith("· highest to @ lowest distance")
    nothing = [a_mission()[0], FieldRecord(0, "fpga", "distance", "cells", np.full((4, 6), np.inf))]
    assert trace_thumbnail(open_trace(write(tmp_path / "none.mcap", nothing)))[0] == " " * 6


def test_a_name_in_a_file_cannot_steer_the_terminal() -> None:
    evil = MissionRecord(0, "\x1b[2Jr", "ended\x07", "a\nb\x1b[31m")
    assert all(cell.isprintable() for cell in row_of(evil).cells())
    dropped = MessageRecord(0, "l", "a", "b", "c", 8, 0, 0, "dropped", "\x1b[2J", 1)
    assert row_of(dropped).details.isprintable()
    records = [*a_room(), PoseRecord(6 * SECOND, "\x1b[2J", 0.0, 0.0, 0.0, 0.0), evil]
    assert all(line.isprintable() for line in moment_lines(moment(records)))


def run(*words: str | Path) -> tuple[int, str]:
    done = CliRunner().invoke(main, ["trace", *map(str, words)])
    return done.exit_code, done.output


def test_the_command_line_shows_a_moment_and_draws_it(tmp_path: Path) -> None:
    path = write(tmp_path / "room.mcap", a_room())
    code, text = run("show", path, "--at", "1s", "--picture", tmp_path / "room.png")
    assert code == 0
    assert EARLY in text
    assert (tmp_path / "room.png").read_bytes().startswith(b"\x89PNG")
    code, text = run("show", path, "--at", "3 s", "--json")
    told = json.loads(text)
    assert told["time"] == 3 * SECOND
    assert told["lines"][1] == "*·▓?·"
    code, text = run("show", path, "--from", "4s", "--to", "4500 ms")
    assert (code, len(text.splitlines())) == (0, 2)


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--at", "12"), "has no unit"),
        (("--from", "3 m"), "has no unit of time"),
        (("--at", "1s", "--picture", "room.gif"), "neither PNG nor SVG"),
    ],
)
def test_a_bad_time_or_picture_is_refused_with_a_remedy(tmp_path: Path, words: tuple[str, ...], why: str) -> None:
    path = write(tmp_path / "room.mcap", a_room())
    done = CliRunner().invoke(main, ["trace", "show", str(path), *words])
    assert done.exit_code == 2
    assert why in done.output + str(done.exception)


def test_only_what_a_moment_needs_is_read(tmp_path: Path) -> None:
    whole = [*a_run(), *a_room()]
    trace = open_trace(write(tmp_path / "both.mcap", whole))
    kinds = {type(record) for record in trace.records(kinds=MOMENT_KINDS)}
    assert kinds <= set(MOMENT_KINDS)
    assert {PoseRecord, MapRecord} <= kinds
