"""The robot is never inside an obstacle of the true map: by the trace of a drive, and by its robot's own track."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import COSTS, KINEMATICS, Ground, rectangle
from numpy.typing import NDArray

from codesign.components.path import NEAR, cell_of
from codesign.ground.records import MapRecord, MissionRecord, ObstacleRecord, PoseRecord, Record
from codesign.maps import OccupancyGrid, to_text
from codesign.system.scenarios.drive.mission import FinishedDrive, drive
from codesign.system.scenarios.drive.scene import Scene
from codesign.system.scenarios.drive.world.inflation import Inflation
from codesign.views.trace import MemoryListener

SIDE = 16
SLOW: dict[str, Any] = {"components": {"fpga": {"clock": "50 kHz"}, "host": {"costs": dict.fromkeys(COSTS, "50 us")}}}
PLACES = ["harmonic-decide-on-host", "breadth-first", "wavefront-tiled-track-on-host", "relaxation-sor"]


def true_maps(records: list[Record]) -> list[tuple[int, NDArray[np.bool_]]]:
    """The true map from each time on, as the trace tells it."""
    found: list[tuple[int, NDArray[np.bool_]]] = []
    for record in records:
        if isinstance(record, MapRecord):
            found.append((record.time, record.free.copy()))
        elif isinstance(record, ObstacleRecord):
            free = found[-1][1].copy()
            rows, columns = record.cells.T
            # Each record tells what changed, and nothing else.
            assert (free[rows, columns] == record.appeared).all()
            free[rows, columns] = not record.appeared
            found.append((record.time, free))
    return found


def check(done: FinishedDrive, records: list[Record], radius: float) -> None:
    """``radius`` in cells."""
    maps = true_maps(records)
    blocked = [(time, Inflation(~free, radius).blocked) for time, free in maps]
    poses = [record for record in records if isinstance(record, PoseRecord)]
    track = [(record.time, (record.row, record.column)) for record in poses]
    track += [(time, (row, column)) for time, row, column in done.scene.robot.log]
    assert poses
    for time, position in track:
        cell = cell_of(position)
        # At the moment of a change the robot is in the old map as well as in the new one.
        first = max((index for index, (begin, _) in enumerate(maps) if begin < time), default=0)
        now = [index for index, (begin, _) in enumerate(maps) if index >= first and begin <= time]
        for index in now:
            free = maps[index][1]
            assert 0 <= cell[0] < SIDE and 0 <= cell[1] < SIDE, (time, position)  # noqa: PT018
            inside = not free[cell]
            # A crossing that is logged lies on the border of the cell that is entered.
            assert not inside or on_border(position), f"inside an obstacle at {time} ps, {position}"
            allowed = not blocked[index][1][cell]
            assert allowed or on_border(position), f"too close to an obstacle at {time} ps, {position}"
    for record in poses:
        # Poses come from between events, never from a border.
        index = max(i for i, (begin, _) in enumerate(maps) if begin <= record.time)
        assert maps[index][1][cell_of((record.row, record.column))]
    mission = done.log
    told = [record for record in records if isinstance(record, MissionRecord)]
    assert told[-1].event == "ended"
    touched = [record.time for record in told if record.event == "contact"]
    assert touched == [contact.time for contact in done.scene.robot.contacts]
    waits = [record.time for record in told if record.event == "obstacle_waits"]
    assert waits == [waiting.time for waiting in done.scene.world.deferrals]
    assert told[-1].text == mission.ended


def clearance(free: NDArray[np.bool_], point: tuple[float, float]) -> float:
    """Distance from a point to the squares of all blocked cells and to the rim, cells."""
    (row, column), (rows, columns) = point, free.shape
    gaps = np.maximum(np.abs(np.argwhere(~free) - np.array(point)) - 0.5, 0.0)
    rim = (row + 0.5, column + 0.5, rows - 0.5 - row, columns - 0.5 - column)
    return float(min([*rim, *np.hypot(gaps[:, 0], gaps[:, 1])]))


class Measured:
    """Keeps each scene's least clearance over all that its robot drives, between its looks too.

    Each by itself: a drive that is over may settle its accounts when its last generator is thrown away, during another.
    """

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.least: dict[Scene, float] = {}
        self.gap = 0.0
        self._advance = Scene.advance
        # A bound method in its place would not be given the scene.
        patch.setattr(Scene, "advance", lambda scene: self._drive(scene))  # noqa: PLW0108

    def _drive(self, scene: Scene) -> None:
        way, begin = scene.robot.path, scene.robot.arc
        # The map changes after the robot was advanced: until now it has been as it is.
        self._advance(scene)
        arcs = way.arcs[(way.arcs > begin) & (way.arcs < scene.robot.arc)]
        for arc in (begin, *arcs, *np.linspace(begin, scene.robot.arc, 9)):
            found = clearance(scene.world.free_now, way.point_at(float(arc)))
            self.gap = max(self.gap, (scene.robot.arc - begin) / 8)
            self.least[scene] = min(self.least.get(scene, math.inf), found)


def on_border(position: tuple[float, float]) -> bool:
    return any(abs(abs(math.remainder(part, 1.0)) - 0.5) <= 4 * NEAR for part in position)


@st.composite
def drives(draw: st.DrawFn) -> dict[str, Any]:
    """A random map, hidden obstacles and others that come, a robot, a planner fast or slow."""
    seed = draw(st.integers(0, 2**32))
    random = np.random.Generator(np.random.PCG64([seed]))
    free = random.random((SIDE, SIDE)) > draw(st.sampled_from([0.0, 0.1, 0.2]))
    start, goal = (2, 2), (13, 12)
    radius = draw(st.sampled_from([0.0, 0.04, 0.1, 0.13]))
    clear = math.ceil(radius / 0.1)
    for row, column in (start, goal):
        free[row - clear : row + clear + 1, column - clear : column + clear + 1] = True

    def place(top: int = 0) -> dict[str, Any]:
        row, column = draw(st.integers(5, 14)), draw(st.integers(0, 14))
        return rectangle(row, column, draw(st.integers(1, 2)), draw(st.integers(1, 2)))

    def cell() -> list[int]:
        return [draw(st.integers(0, 14)), draw(st.integers(0, 14))]

    at = st.integers(1, 8000)
    appearing = [{**place(), "at": f"{draw(at)} ms"} for _ in range(draw(st.integers(0, 3)))]
    moving = [
        {
            "size": [draw(st.integers(1, 2)), 1],
            "route": [cell(), cell()],
            "speed": f"{draw(st.sampled_from([0.1, 0.4, 2.0]))} m/s",
        }
        for _ in range(draw(st.integers(0, 2)))
    ]
    for one in moving:
        if one["route"][0] == one["route"][1]:
            one["route"][1][0] = (one["route"][1][0] + 5) % 14
    obstacles: dict[str, Any] = {"appearing": appearing, "moving": moving}
    if draw(st.booleans()):
        stay = draw(st.sampled_from(["2 s", None]))
        count = draw(st.integers(1, 30))
        obstacles["random"] = {"count": count, "size": 1, "end": "10 s", "seed": seed} | (
            {"stay": stay} if stay else {}
        )
    reach = draw(st.sampled_from(["0.15 m", "0.5 m", "3 m"]))
    rays = {"type": "rays", "range": reach, "rays": draw(st.sampled_from([8, 60]))}
    sensor = draw(st.sampled_from([rays, {"type": "radius", "range": reach}]))
    robot = {"radius": f"{radius} m", "sensor": {"=": sensor}}
    return {
        "placement": draw(st.sampled_from(PLACES)),
        "platform": [
            KINEMATICS[draw(st.sampled_from([*KINEMATICS]))],
            {"components": {"robot": robot}},
            SLOW if draw(st.booleans()) else {},
        ],
        "text": to_text(OccupancyGrid(free)),
        "start": start,
        "goals": [goal],
        "hidden": [place() for _ in range(draw(st.integers(0, 3)))],
        "known": draw(st.sampled_from(["all", "none"])),
        "purpose": draw(st.sampled_from(["reach", "reach", "explore"])),
        "obstacles": obstacles,
        "replan": {
            "trigger": draw(st.sampled_from(["blocked", "change"])),
            "when_busy": draw(st.sampled_from(["finish", "restart"])),
        },
        "control_period": draw(st.sampled_from(["40 ms", "100 ms", "700 ms"])),
        "deadline": draw(st.sampled_from(["50 ms", "300 ms", "2 s"])),
        "limit": "20 s",
        "patience": "4 s",
    }


@settings(max_examples=examples(25), derandomize=True)
@given(case=drives())
def test_the_robot_never_enters_an_obstacle(tmp_path: Path, case: dict[str, Any]) -> None:
    listener = MemoryListener()
    machine = Ground(tmp_path).machine(listeners=[listener], **case)
    with pytest.MonkeyPatch.context() as patch:
        measured = Measured(patch)
        done = drive(machine)
    check(done, listener.records, done.scene.robot.radius_cells)
    least = measured.least[done.scene]
    # Between two looks that are so far apart it may come nearer by half of that, and no more.
    assert done.scene.robot.radius_cells - 1e-6 <= done.scene.clearance.least <= least + 1e-9
    assert done.scene.clearance.least >= least - measured.gap / 2
