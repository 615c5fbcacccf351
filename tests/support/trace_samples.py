"""Traces to write and read: one record of each class, a run, a mission."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from codesign.ground.records import (
    BeliefRecord,
    CommandRecord,
    FieldRecord,
    GoalRecord,
    MapRecord,
    MessageRecord,
    MissionRecord,
    ObstacleRecord,
    PlanRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    RobotRecord,
    SampleRecord,
    ScanRecord,
    StageRecord,
    SummaryRecord,
    TaskRecord,
    TrajectoryRecord,
    UtilisationRecord,
    VisitsRecord,
)
from codesign.views.trace import McapListener

FREE = np.array([[True, False, True], [True, True, True]])


def a_run(seed: int = 1) -> list[Record]:
    """One record of every class, times not in order, ps that are no whole ns, an array of every dtype."""
    rng = np.random.default_rng(seed)
    block = rng.integers(0, 4, 50, dtype=np.int32)
    iterations = rng.integers(1, 9, 50, dtype=np.int32)
    potential = rng.random((2, 3), dtype=np.float64)
    return [
        MapRecord(0, "host", FREE, np.array([[0, 2], [1, 1]], dtype=np.int32), 0.05),
        MessageRecord(0, "pci", "host", "fpga", "map", 9504, 12, 1_234_567),
        VisitsRecord(1_234_567, "fpga", 8_000_001, 0, 7, block, iterations),
        StageRecord(8_000_001, "fpga", 1_234_567, 0, 7, 3, 50, 222, 1998, 4, potential),
        VisitsRecord(8_000_001, "fpga", 8_000_001, 1, 15, block[:0], iterations[:0]),
        StageRecord(9_000_001, "fpga", 8_000_001, 1, 15, 1, 0, 0, 0, 0, potential / 2),
        TaskRecord(9_000_001, "host", "decide", 9_100_000, 99),
        TrajectoryRecord(9_100_000, "host", np.array([[1.0, 0.25], [0.0, 2.0]]), True),
        SampleRecord(9_500_000, "fpga", "busy", "1", 0.25),
        UtilisationRecord(10_000_000, "fpga", 7_000_000, 10_000_000),
        UtilisationRecord(10_000_000, "pci", 0, 0),
        SummaryRecord(10_000_000, "system", {"time_ps": 10_000_000, "quality": {"share": 0.5, "note": "è"}}),
    ]


def a_mission() -> list[Record]:
    """A small drive with a record of every class that a mission adds; it ends early, with no result."""
    free = np.ones((4, 6), bool)
    free[1, 1:5] = False
    cells = np.array([[2, 2], [2, 3]], np.int32)
    field = np.full((4, 6), np.inf)
    field[0] = np.arange(6.0)
    way = np.array([[0.0, 0.0], [3.0, 0.25], [3.0, 5.0]])
    return [
        MapRecord(0, "map", free, np.array([[3, 5]], np.int32), 0.5, unknown=~free),
        RobotRecord(0, "robot", 0.1, 0.5, 4.0, 180, cells[:1], True),
        GoalRecord(0, "robot", np.array([[3, 5]], np.int32)),
        BeliefRecord(0, "robot", np.array([[0, 0], [1, 1]], np.int32), np.array([False, True]), 0),
        MissionRecord(0, "robot", "plan_requested", "the first"),
        MessageRecord(10, "uart", "host", "fpga", "map", 24, 20, 2_000_000, "dropped", "link down", 3),
        FieldRecord(3_000_000, "fpga", "distance", "cells", field),
        PlanRecord(3_000_000, "fpga", 1, 10, 0, 2_000_000, 2_500_000),
        TrajectoryRecord(3_000_000, "robot", way, True),
        CommandRecord(4_000_000, "robot", 1, 0, 3_000_000, way, 2.5),
        MissionRecord(3_000_000, "robot", "plan_ready", "3 us"),
        PoseRecord(10**11, "robot", 1 / 3, 0.0, np.pi / 2, 0.5),
        ScanRecord(10**11, "robot", 1 / 3, 0.0, 8.0, np.array([np.inf, 2.5, 0.1, 4.0], np.float32)),
        ObstacleRecord(2 * 10**11, "world", cells, True),
        BeliefRecord(3 * 10**11, "robot", cells, np.array([True, True])),
        ObstacleRecord(15 * 10**11, "world", cells[:1], False),
        PositionsRecord(16 * 10**11, "fleet", 7, np.array([[1.0, 2.5], [3.0, 0.0]])),
        PoseRecord(17 * 10**11, "robot", 2.0, 0.5, 0.0, 0.0),
        MissionRecord(17 * 10**11, "robot", "contact", "an obstacle came"),
        MissionRecord(18 * 10**11, "robot", "ended", "the robot is walled in"),
    ]


def as_told(records: list[Record]) -> list[Record]:
    """The records as a trace keeps them: once a mission has begun, without the fields of its plans."""
    began = next((place for place, one in enumerate(records) if isinstance(one, MissionRecord)), len(records))
    return [*records[:began], *map(Record.bare, records[began:])]


def same(first: Record, second: Record) -> bool:
    """Whether two records are equal, arrays with their dtypes and shapes included."""
    if type(first) is not type(second):
        return False
    for item in fields(first):
        one, other = getattr(first, item.name), getattr(second, item.name)
        if isinstance(one, np.ndarray):
            if one.dtype != other.dtype or one.shape != other.shape or one.tobytes() != other.tobytes():
                return False
        elif type(one) is not type(other) or one != other:
            return False
    return True


def write(path: Path, records: list[Record], **identity: str) -> Path:
    with McapListener(path, identity) as listener:
        for record in records:
            listener(record)
    return path


@dataclass(frozen=True)
class PluginRecord(Record):
    """A record of somebody else's component."""

    temperature: float | None
