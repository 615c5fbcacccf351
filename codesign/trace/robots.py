"""Views of robots: their frames, their bodies with headings and numbers, and their trails.

The body of a robot is drawn once, in a frame of its own. ``/tf`` moves the frame.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from typing import Any

import numpy as np
from foxglove import messages as fg
from numpy.typing import NDArray

from codesign.records import PoseRecord, PositionsRecord
from codesign.trace import shapes
from codesign.trace.floor import Floor

TRAIL = 128
"""Most positions of a trail. Of a fleet, ``TRAIL_OF_ALL`` positions in all."""

TRAIL_OF_ALL = 2048
TRAILS_A_LENGTH = 4
"""A trail is written each time that a fourth of it is new, so each position is written about four times."""

_CIRCLE = np.array([(math.cos(part * math.pi / 12), math.sin(part * math.pi / 12)) for part in range(24)])
_BEAK = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros(6)])


class Robots:
    """The robots of a run, alone or as a fleet, on ``floor``. ``radius``: of their bodies, m; 0: not known."""

    def __init__(self, floor: Floor, radius: float) -> None:
        self._floor = floor
        self._radius = radius or floor.cell_size / 2
        self._drawn: set[str] = set()
        self._trails: dict[str, list[NDArray[np.float64]]] = {}
        self._last: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        self._new = 0

    def posed(self, record: PoseRecord) -> Iterator[tuple[str, Any]]:
        """The views of a robot."""
        x, y = self._floor.point(record.row, record.column)
        angle = self._floor.turned(record.heading)
        frame = record.source
        yield (
            "/tf",
            fg.FrameTransforms(transforms=[_transform(shapes.stamp(record.time), frame, x, y, angle)]),
        )
        new = yield from self._bodies(record.time, frame, [frame], [""])
        if new:
            outline = np.concatenate([_CIRCLE, 1.5 * _BEAK]) * self._radius
            cloud = shapes.cloud(outline, shapes.ROBOT, record.time, self._radius / 2, frame)
            yield "/robots/points", cloud
        yield from self._trail(record.time, frame, np.array([(x, y)]))

    def placed(self, record: PositionsRecord) -> Iterator[tuple[str, Any]]:
        """The views of a fleet. A robot points where it last moved."""
        places, source = self._floor.points(record.positions), record.source
        before, angles = self._last.get(source, (places, np.zeros(len(places))))
        if len(before) == len(places):
            moved = places - before
            moves = np.hypot(moved[:, 0], moved[:, 1]) > 1e-6 * self._floor.cell_size
            angles = np.where(moves, np.arctan2(moved[:, 1], moved[:, 0]), angles)
        else:
            angles = np.zeros(len(places))
        self._last[source] = places, angles
        frames = [f"{source}/{number}" for number in range(len(places))]
        stamp, columns = shapes.stamp(record.time), (*places.T.tolist(), angles.tolist())
        transforms = [
            _transform(stamp, frame, x, y, angle) for frame, x, y, angle in zip(frames, *columns, strict=True)
        ]
        yield "/tf", fg.FrameTransforms(transforms=transforms)
        yield "/robots/points", shapes.cloud(places, shapes.ROBOT, record.time, self._radius / 2)
        yield from self._bodies(record.time, source, frames, [str(number) for number in range(len(places))])
        yield from self._trail(record.time, source, places)

    def finish(self, time: int) -> Iterator[tuple[str, Any]]:
        """The trails, where they have grown."""
        if self._new:
            yield from self._trails_of_all(time)

    def _bodies(
        self, time: int, source: str, frames: list[str], numbers: list[str]
    ) -> Generator[tuple[str, Any], None, bool]:
        """A disc, an arrow and a number in each frame, once. Returns whether they were new."""
        key = f"{source} {len(frames)}"
        if key in self._drawn:
            return False
        self._drawn.add(key)
        radius, colour = self._radius, shapes.colour(shapes.ROBOT)
        entities = []
        for frame, number in zip(frames, numbers, strict=True):
            disc = fg.CylinderPrimitive(
                pose=shapes.pose(0.0, 0.0, 0.0, radius / 4),
                size=fg.Vector3(x=2 * radius, y=2 * radius, z=radius / 2),
                bottom_scale=1.0,
                top_scale=1.0,
                color=colour,
            )
            arrow = fg.ArrowPrimitive(
                pose=shapes.pose(0.0, 0.0, 0.0, radius),
                shaft_length=radius,
                shaft_diameter=radius / 3,
                head_length=radius / 2,
                head_diameter=radius * 2 / 3,
                color=shapes.colour(shapes.PATH),
            )
            text = fg.TextPrimitive(
                pose=shapes.pose(0.0, 0.0, 0.0, 2 * radius),
                billboard=True,
                font_size=radius,
                scale_invariant=False,
                color=fg.Color(r=0.0, g=0.0, b=0.0, a=1.0),
                text=number,
            )
            texts = [text] if number else []
            entities.append(shapes.entity(frame, time, frame, cylinders=[disc], arrows=[arrow], texts=texts))
        yield "/robots", fg.SceneUpdate(entities=entities)
        return True

    def _trail(self, time: int, source: str, places: NDArray[np.float64]) -> Iterator[tuple[str, Any]]:
        trail = self._trails.setdefault(source, [])
        if trail and len(trail[-1]) != len(places):
            trail.clear()
        trail.append(places)
        length = max(min(TRAIL, TRAIL_OF_ALL // max(len(places), 1)), 2)
        del trail[:-length]
        self._new += 1
        if self._new >= length // TRAILS_A_LENGTH:
            yield from self._trails_of_all(time)

    def _trails_of_all(self, time: int) -> Iterator[tuple[str, Any]]:
        self._new = 0
        # robots × positions × 2
        trails = [path for trail in self._trails.values() for path in np.stack(trail, axis=1)]
        lines = [shapes.line(path, shapes.TRAIL, 0.005) for path in trails]
        yield "/trails", shapes.scene("trails", time, lines=lines)
        points = np.concatenate(trails) if trails else np.zeros((0, 2))
        yield "/trails/points", shapes.cloud(points, shapes.TRAIL, time, 0.005)


def _transform(stamp: fg.Timestamp, frame: str, x: float, y: float, angle: float) -> fg.FrameTransform:
    return fg.FrameTransform(
        timestamp=stamp,
        parent_frame_id=shapes.MAP_FRAME,
        child_frame_id=frame,
        translation=fg.Vector3(x=x, y=y, z=0.0),
        rotation=shapes.quaternion(angle),
    )
