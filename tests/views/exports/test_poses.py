"""Tables of the positions of robots."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
from click.testing import CliRunner
from trace_samples import a_mission, write

from codesign.cli import main
from codesign.ground.records import PoseRecord, PositionsRecord, Record, TaskRecord
from codesign.views.exports.poses import poses_csv


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


def test_the_command_line_writes_it(tmp_path: Path) -> None:
    path, poses = write(tmp_path / "mission.mcap", a_mission()), tmp_path / "poses.csv"
    done = CliRunner().invoke(main, ["trace", "export", str(path), "--poses", str(poses)])
    assert done.exit_code == 0, done.output
    assert len(poses.read_text().splitlines()) == 5
    assert CliRunner().invoke(main, ["trace", "export", str(path), "--poses", str(path)]).exit_code == 2
