"""Records of runs made up for the tests of pages that show them over time."""

from __future__ import annotations

import math
import random

import numpy as np

from codesign.ground.records import (
    BeliefRecord,
    GoalRecord,
    MapRecord,
    MessageRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
    RobotRecord,
    StageRecord,
    TaskRecord,
    TrajectoryRecord,
)

SECOND = 10**12
ROWS, COLUMNS, CORNER = 30, 40, (10, 20)


def a_map(rows: int = ROWS, columns: int = COLUMNS, goals: int = 1, radius: float = 0.0) -> MapRecord:
    """A map of which one cell in six is a wall; it is a part of a larger one that begins at ``CORNER``."""
    free = np.random.default_rng(1).random((rows, columns)) > 1 / 6
    places = np.array([[CORNER[0] + 3 + k, CORNER[1] + 5 + k] for k in range(goals)], np.int32)
    return MapRecord(0, "map", free, places, 0.2, *CORNER, radius=radius)


def a_drive(seed: int = 1, name: str = "robot", text: str = "the first plan") -> list[Record]:
    """A robot that drives for 20 s, learns cells, sees obstacles come and go, and asks for plans."""
    drawn = random.Random(seed)
    start = a_map()
    first = np.array(CORNER, np.int32)

    def cells(number: int) -> np.ndarray[tuple[int, ...], np.dtype[np.int32]]:
        places = {(drawn.randrange(ROWS), drawn.randrange(COLUMNS)) for _ in range(number)}
        return np.array(sorted(places), np.int32) + first

    records: list[Record] = [
        start,
        RobotRecord(0, name, 0.15, 0.5, 4.0, 0, np.zeros((0, 2), np.int32), False),
        GoalRecord(0, name, start.goals),
    ]
    for step in range(200):
        time = step * SECOND // 10
        row, column = 15 + 8 * math.sin(step / 30), 30 + 9 * math.cos(step / 30)
        heading = math.atan2(math.cos(step / 30), -math.sin(step / 30))
        records.append(PoseRecord(time, name, row, column, heading, 0.4 if 20 < step < 180 else 0.0))
        records.append(TaskRecord(time, "fpga", "plan", time + SECOND // 50, 100))
        records.append(MessageRecord(time, "bus", "a", "b", "map", 8, time + 5, time + SECOND // 25))
        seen = cells(12)
        blocked = np.array([drawn.random() < 0.4 for _ in seen], bool)
        records.append(BeliefRecord(time + 7, name, seen, blocked))
        if step % 9 == 0:
            records.append(ObstacleRecord(time + 9, "map", cells(4), drawn.random() < 0.6))
        if step % 40 == 5:
            records.append(MissionRecord(time, name, "plan_requested", text))
            records.append(MissionRecord(time + SECOND // 5, name, "plan_ready", text))
            way = np.array([[row, column], [20.0, 40.0], [13.0, 25.0]])
            records.append(TrajectoryRecord(time + SECOND // 5, name, way, True))
    records.append(MissionRecord(20 * SECOND, name, "ended", "all goals are reached"))
    return records


def a_fleet(robots: int = 64, updates: int = 100) -> list[Record]:
    """Robots on a circle that drive to the opposite point; the last one never arrives, and stops halfway."""
    start = a_map(60, 60, robots, radius=0.8)
    middle, records = np.array([40.0, 50.0]), list[Record]([start])
    angles = np.arange(robots) * 2 * math.pi / robots
    begin = middle + 25 * np.column_stack([np.sin(angles), np.cos(angles)])
    for update in range(updates):
        share = np.minimum(1.0, update / (updates - 1 - np.arange(robots) / (2 * robots) * updates))
        share[-1] = min(share[-1], 0.5)
        places = begin + 2 * (middle - begin) * share[:, None]
        records.append(PositionsRecord(update * SECOND // 10, "fleet", update, places))
    end = (updates - 1) * SECOND // 10
    records += [MissionRecord(end, "fleet", "goal_reached", f"robot {number} has arrived") for number in range(3)]
    records += [TrajectoryRecord(end, f"robot_{number}", begin[:2], number < robots - 1) for number in range(robots)]
    return records


def a_plan(stages: int = 5) -> list[Record]:
    """A plan whose field grows stage by stage."""
    start = a_map()
    records: list[Record] = [start]
    for stage in range(stages):
        potential = np.where(start.free, 10.0 ** -np.arange(COLUMNS)[None, :], 0.0)
        potential[:, 8 * (stage + 1) :] = 0.0
        end = (stage + 1) * 1_000_000
        records.append(StageRecord(end, "fpga", end - 900_000, stage, 7, 3, 12, 30, 99, 4 - stage, potential))
    way = np.array([[12.0, 22.0], [14.0, 30.0]])
    return [*records, TrajectoryRecord(stages * 1_000_000, "robot", way, True)]
