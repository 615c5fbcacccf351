"""Views of robots: their frames, their bodies with headings and numbers, and their trails.

The body of a robot is drawn once, in a frame of its own. ``/tf`` moves the frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from foxglove import messages as fg
from numpy.typing import NDArray

from codesign.records import PoseRecord, PositionsRecord
from codesign.trace import shapes
from codesign.trace.floor import Floor

Show = Callable[[str, Any, int], None]
"""Takes a topic, a message of Foxglove's SDK, and its time, ps."""

ALL_SHOWN, MOST_SKIPPED = 4, 3
"""A fleet of more than 4 robots is shown after each n / 4-th update, after each fourth at the least.

Viewers move a frame smoothly between two times.
"""

Place = tuple[float, float]

TRAIL = 64
"""Most positions of a trail. Of a fleet, ``TRAIL_OF_ALL`` positions in all."""

TRAIL_OF_ALL, TRAIL_STEP = 1024, 4
TRAILS_A_LENGTH = 2
"""A trail is written each time that half of it is new, so each position is written twice."""

_CIRCLE = np.array([(math.cos(part * math.pi / 12), math.sin(part * math.pi / 12)) for part in range(24)])
_BEAK = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros(6)])


class Robots:
    """The robots of a run, alone or as a fleet."""

    def __init__(self, show: Show) -> None:
        self._show = show
        self.begin(Floor(), 0.0)

    def begin(self, floor: Floor, radius: float) -> None:
        """A map has come: no robot is drawn on it. ``radius``: of their bodies, m; 0: not known."""
        self._floor = floor
        self._radius = radius or floor.cell_size / 2
        self._drawn: dict[str, int] = {}
        self._trails: dict[str, list[list[Place]]] = {}
        self._last: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        self._new, self._since = 0, -1
        self._skip = 0
        self._skipped: PositionsRecord | None = None

    def posed(self, record: PoseRecord) -> None:
        """Show a robot."""
        place = self._floor.point(record.row, record.column)
        time, frame, angle = record.time, record.source, self._floor.turned(record.heading)
        if not math.isfinite(place[0] + place[1] + angle):
            return
        transform = _transform(shapes.stamp(time), frame, *place, angle)
        self._show("/tf", fg.FrameTransforms(transforms=[transform]), time)
        if self._drawn.get(frame) != 1:
            self._bodies(time, frame, [frame], [""])
            # Rerun has no scenes. The body there is a circle of points with a beak, in the frame of the robot.
            outline = np.concatenate([_CIRCLE, 1.5 * _BEAK]) * self._radius
            body = shapes.cloud(outline, shapes.ROBOT, time, self._radius / 2, frame)
            self._show("/robots/points", body, time)
        self._trail(time, frame, [place])

    def placed(self, record: PositionsRecord) -> None:
        """Show a fleet, of more than ``ALL_SHOWN`` robots not after each update."""
        if self._skip:
            self._skip, self._skipped = self._skip - 1, record
        else:
            needed = -(-len(record.positions) // ALL_SHOWN) - 1
            self._skip, self._skipped = min(max(needed, 0), MOST_SKIPPED), None
            self._placed(record)

    def _placed(self, record: PositionsRecord) -> None:
        """A robot points where it last moved."""
        time, source, places = record.time, record.source, self._floor.points(record.positions)
        if not (len(places) and np.isfinite(places).all()):
            return
        before, angles = self._last.get(source, (places, np.zeros(len(places))))
        if len(before) != len(places):
            before, angles = places, np.zeros(len(places))
        moved = places - before
        moves = np.abs(moved).max(axis=1) > 1e-6 * self._floor.cell_size
        angles = np.where(moves, np.arctan2(moved[:, 1], moved[:, 0]), angles)
        self._last[source] = places, angles
        stamp, numbers = shapes.stamp(time), [str(number) for number in range(len(places))]
        frames = [f"{source}/{number}" for number in numbers]
        rows = np.column_stack([places, angles]).tolist()
        transforms = [_transform(stamp, frame, *row) for frame, row in zip(frames, rows, strict=True)]
        self._show("/tf", fg.FrameTransforms(transforms=transforms), time)
        if self._drawn.get(source) != len(places):
            self._bodies(time, source, frames, numbers)
        if self._trail(time, source, places.tolist()):
            self._show("/robots/points", shapes.cloud(places, shapes.ROBOT, time, self._radius / 2), time)

    def finish(self, time: int) -> None:
        """Show the last positions, and the trails where they have grown."""
        if self._skipped is not None:
            self._placed(self._skipped)
            self._skip, self._skipped = 0, None
        if self._new:
            self._trails_of_all(time)

    def _bodies(self, time: int, source: str, frames: list[str], numbers: list[str]) -> None:
        """Show a disc, an arrow and a number in each frame."""
        self._drawn[source] = len(frames)
        radius = self._radius
        disc = fg.CylinderPrimitive(
            pose=shapes.pose(0.0, 0.0, 0.0, radius / 4),
            size=fg.Vector3(x=2 * radius, y=2 * radius, z=radius / 2),
            bottom_scale=1.0,
            top_scale=1.0,
            color=shapes.colour(shapes.ROBOT),
        )
        arrow = fg.ArrowPrimitive(
            pose=shapes.pose(0.0, 0.0, 0.0, radius),
            shaft_length=radius,
            shaft_diameter=radius / 3,
            head_length=radius / 2,
            head_diameter=radius * 2 / 3,
            color=shapes.colour(shapes.PATH),
        )
        above = shapes.pose(0.0, 0.0, 0.0, 2 * radius)
        texts = [
            fg.TextPrimitive(
                pose=above,
                billboard=True,
                font_size=radius,
                scale_invariant=False,
                color=fg.Color(r=0.0, g=0.0, b=0.0, a=1.0),
                text=number,
            )
            for number in numbers
        ]
        entities = [
            shapes.entity(
                frame, time, frame, cylinders=[disc], arrows=[arrow], texts=[text] if number else []
            )
            for frame, number, text in zip(frames, numbers, texts, strict=True)
        ]
        self._show("/robots", fg.SceneUpdate(entities=entities), time)

    def _trail(self, time: int, source: str, places: list[Place]) -> bool:
        """Each fourth position is part of the trail. Returns whether this one is."""
        self._since = (self._since + 1) % TRAIL_STEP
        if self._since:
            return False
        trail = self._trails.setdefault(source, [])
        if trail and len(trail[-1]) != len(places):
            trail.clear()
        trail.append(places)
        self._new += 1
        length = max(min(TRAIL, TRAIL_OF_ALL // max(len(places), 1)), 2)
        if self._new >= length // TRAILS_A_LENGTH:
            del trail[:-length]
            self._trails_of_all(time)
        return True

    def _trails_of_all(self, time: int) -> None:
        self._new = 0
        # robots × positions × 2
        trails = [path for trail in self._trails.values() for path in np.array(trail).swapaxes(0, 1)]
        lines = [shapes.line(path, shapes.TRAIL, 0.005) for path in trails]
        self._show("/trails", shapes.scene("trails", time, lines=lines), time)
        points = np.concatenate(trails) if trails else np.zeros((0, 2))
        self._show("/trails/points", shapes.cloud(points, shapes.TRAIL, time, 0.005), time)


def _transform(stamp: fg.Timestamp, frame: str, x: float, y: float, angle: float) -> fg.FrameTransform:
    half, grain = angle / 2, shapes.GRAIN
    return fg.FrameTransform(
        timestamp=stamp,
        parent_frame_id=shapes.MAP_FRAME,
        child_frame_id=frame,
        translation=fg.Vector3(x=round(x * grain) / grain, y=round(y * grain) / grain, z=0.0),
        rotation=fg.Quaternion(
            x=0.0, y=0.0, z=round(math.sin(half) * grain) / grain, w=round(math.cos(half) * grain) / grain
        ),
    )
