"""A drive on a cropped map is the drive on the map cut by hand, with all that users read in the frame of the whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mission_specs import ROOMS, Ground, rectangle

from codesign.ground.errors import SpecError
from codesign.ground.records import MapRecord, MissionRecord, PoseRecord
from codesign.views.trace import McapListener, open_trace
from codesign.views.trace.moment import moment, moment_lines

ROW, COLUMN = 3, 5
CUT = "#" * 24
FRAMED = "\n".join([CUT] * ROW + [f"#####{row}###" for row in ROOMS.split()] + [CUT] * 2) + "\n"
"""ROOMS with walls around it: cell (0, 0) has become (3, 5)."""

HIDDEN = (5, 3, 1, 4)


def scenario(rows: int, columns: int) -> dict[str, Any]:
    row, column, *size = HIDDEN
    return {
        "known": "none",
        "tour": [[1 + rows, 14 + columns]],
        "hidden": [rectangle(row + rows, column + columns, *size)],
        "obstacles": {
            "appearing": [rectangle(8 + rows, 2 + columns, 2, 2, at="4 s", until="9 s")],
            "moving": [{"route": [[14 + rows, 3 + columns], [14 + rows, 9 + columns]], "speed": "0.2 m/s"}],
        },
    }


def moved_map(crop: str) -> dict[str, Any]:
    return {"problem": {"map": {"crop": crop}}}


@pytest.mark.parametrize("placement", ["breadth-first", "wavefront-host"])
def test_a_cropped_drive_is_that_on_the_map_cut_by_hand(tmp_path: Path, placement: str) -> None:
    (tmp_path / "cut").mkdir()
    (tmp_path / "framed").mkdir()
    cut, by_hand = Ground(tmp_path / "cut").watched(placement, **scenario(0, 0))
    framed, records = Ground(tmp_path / "framed").watched(
        placement,
        text=FRAMED,
        goals=[[14 + ROW, 13 + COLUMN]],
        start=[1 + ROW, 1 + COLUMN],
        workload=moved_map("free"),
        **scenario(ROW, COLUMN),
    )
    assert cut.mission is not None
    assert cut.mission.reached
    assert framed.mission == cut.mission
    assert len(records) == len(by_hand)
    for seen, same in zip(records, by_hand, strict=True):
        moved = same.moved(ROW, COLUMN)
        assert (type(seen), seen.time) == (type(moved), moved.time)
        for name in (*seen.IN_CELLS, *(("row", "column") if isinstance(seen, PoseRecord) else ())):
            assert np.array_equal(vars(seen)[name], vars(moved)[name]), (seen, name)
    (begin,) = (record for record in records if isinstance(record, MapRecord))
    assert (begin.corner, begin.free.shape) == ((ROW, COLUMN), (16, 16))
    reached = [
        record.text for record in records if isinstance(record, MissionRecord) and record.event == "goal_reached"
    ]
    assert reached[0].endswith(f"at ({14 + ROW}, {13 + COLUMN})")


def test_a_moment_of_a_cropped_drive(tmp_path: Path) -> None:
    settings = {"text": FRAMED, "goals": [[14 + ROW, 13 + COLUMN]], "start": [1 + ROW, 1 + COLUMN]}
    _, records = Ground(tmp_path).watched(workload=moved_map("free"), **settings, **scenario(ROW, COLUMN))
    seen = moment(records, 2 * 10**12)
    lines = moment_lines(seen)
    assert f"from ({ROW}, {COLUMN}) on" in lines[16]
    assert lines[14][13] == "G"
    assert seen.pose is not None
    assert lines[round(seen.pose.row) - ROW][round(seen.pose.column) - COLUMN] == "@"
    with McapListener(tmp_path / "run.mcap") as mcap:
        for record in records:
            mcap(record)
    again = moment(open_trace(tmp_path / "run.mcap").records(), 2 * 10**12)
    assert moment_lines(again) == lines


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            {"tour": [[0, 0]]},
            "scenario.tour[0]: goal (0, 0) is outside of the cropped map of 16 × 16 cells;"
            " (row, column) from (3, 5) to (18, 20)",
        ),
        (
            {"tour": [[3 + ROW, 7 + COLUMN]]},
            "scenario.tour[0]: goal (6, 12) is on an obstacle; the nearest free cell is (6, 11)",
        ),
        ({"hidden": [rectangle(2, 6)]}, "scenario.hidden[0]: its first cell (2, 6) is outside of the cropped map"),
        (
            {"hidden": [rectangle(18, 20, 2)]},
            "scenario.hidden[0]: its last cell (19, 20) is outside of the cropped map",
        ),
        ({"hidden": [rectangle(1 + ROW, 1 + COLUMN)]}, "scenario.hidden[0]: it covers (4, 6), where the robot starts"),
    ],
)
def test_faults_of_a_cropped_drive_are_in_the_frame_of_the_map(
    tmp_path: Path, change: dict[str, Any], expected: str
) -> None:
    with pytest.raises(SpecError) as caught:
        Ground(tmp_path).run(
            text=FRAMED,
            goals=[[14 + ROW, 13 + COLUMN]],
            start=[1 + ROW, 1 + COLUMN],
            workload=moved_map("free"),
            **change,
        )
    (fault,) = caught.value.faults
    assert f"{fault.key}: {fault.what}; {fault.hint}".startswith(expected)
