"""Views of robots: their frames, their bodies with headings and numbers, and their trails.

The body of a robot is drawn once, in a frame of its own. ``/tf`` moves the frame.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from foxglove import messages as fg
from numpy.typing import NDArray

from codesign.ground.records import PoseRecord, PositionsRecord
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.views.trace import shapes
from codesign.views.trace.floor import Floor

SHOWN_EACH, FLEET_SHOWN_EACH = PICOSECONDS_PER_SECOND // 5, PICOSECONDS_PER_SECOND * 2 // 5
FEW = 4
"""Picoseconds between two places of a robot, and of a fleet of more than 4 robots. Viewers move a frame smoothly."""

Place = tuple[float, float]

TRAIL = 64
"""Most positions of a trail. Of a fleet, ``TRAIL_OF_ALL`` positions in all."""

TRAIL_OF_ALL, TRAIL_EACH = 1024, PICOSECONDS_PER_SECOND * 2 // 5
TRAILS_A_LENGTH = 2
"""A trail is written each time that half of it is new, so each position is written twice."""

_CIRCLE = np.array([(math.cos(part * math.pi / 12), math.sin(part * math.pi / 12)) for part in range(24)])
_BEAK = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros(6)])


_VARINT = 5
"""Bytes of a number of a time. A varint may be longer than needed, so that the next number keeps its place."""

_PLACE_AND_TURN = struct.Struct("<BBBdBd BBBdBd")
"""A vector of x and y, and a quaternion of z and w, each number behind its field. What is left out is 0."""


class Encoded(NamedTuple):
    """A message that is encoded already, and its class in Foxglove's SDK."""

    kind: Any
    data: bytes


Show = Callable[[str, Any, int], None]
"""Takes a topic, a message of Foxglove's SDK or an ``Encoded`` one, and its time, ps."""


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
        self._transforms: dict[str, Transforms] = {}
        self._new = 0
        self._due: dict[str, int] = {}
        self._trail_due: dict[str, int] = {}
        self._kept: dict[str, Callable[[], None]] = {}

    def posed(self, record: PoseRecord) -> None:
        """Show a robot, where the last place that was shown is old enough."""
        if record.time < self._due.get(record.source, 0):
            self._kept[record.source] = partial(self._posed, record)
        else:
            self._posed(record)

    def _posed(self, record: PoseRecord) -> None:
        place = self._floor.point(record.row, record.column)
        time, frame, angle = record.time, record.source, self._floor.turned(record.heading)
        self._kept.pop(frame, None)
        if not math.isfinite(place[0] + place[1] + angle):
            return
        self._due[frame] = time + SHOWN_EACH
        self._move(frame, [frame], time, [(*place, angle)])
        if self._drawn.get(frame) != 1:
            self._bodies(time, frame, [frame], [""])
            # Rerun has no scenes. The body there is a circle of points with a beak, in the frame of the robot.
            outline = np.concatenate([_CIRCLE, 1.5 * _BEAK]) * self._radius
            body = shapes.cloud(outline, shapes.ROBOT, time, self._radius / 2, frame)
            self._show("/robots/points", body, time)
        self._trail(time, frame, [place])

    def placed(self, record: PositionsRecord) -> None:
        """Show a fleet, where the last places that were shown are old enough."""
        if record.time < self._due.get(record.source, 0):
            self._kept[record.source] = partial(self._placed, record)
        else:
            self._placed(record)

    def _placed(self, record: PositionsRecord) -> None:
        """A robot points where it last moved."""
        time, source, places = record.time, record.source, self._floor.points(record.positions)
        self._kept.pop(source, None)
        if not (len(places) and np.isfinite(places).all()):
            return
        before, angles = self._last.get(source, (places, np.zeros(len(places))))
        if len(before) != len(places):
            before, angles = places, np.zeros(len(places))
        moved = places - before
        moves = np.abs(moved).max(axis=1) > 1e-6 * self._floor.cell_size
        angles = np.where(moves, np.arctan2(moved[:, 1], moved[:, 0]), angles)
        self._last[source] = places, angles
        self._due[source] = time + (SHOWN_EACH if len(places) <= FEW else FLEET_SHOWN_EACH)
        numbers = [str(number) for number in range(len(places))]
        frames = [f"{source}/{number}" for number in numbers]
        self._move(source, frames, time, np.column_stack([places, angles]).tolist())
        if self._drawn.get(source) != len(places):
            self._bodies(time, source, frames, numbers)
        if self._trail(time, source, places.tolist()):
            self._show("/robots/points", shapes.cloud(places, shapes.ROBOT, time, self._radius / 2), time)

    def finish(self, time: int) -> None:
        """Show the last positions, and the trails where they have grown."""
        for show in list(self._kept.values()):
            show()
        if self._new:
            self._trails_of_all(time)

    def _move(self, source: str, frames: list[str], time: int, poses: Iterable[Sequence[float]]) -> None:
        """Show the frames at their poses, each x and y in metres and the angle in radians."""
        transforms = self._transforms.get(source)
        if transforms is None or len(transforms.frames) != len(frames):
            transforms = self._transforms[source] = Transforms(frames)
        self._show("/tf", Encoded(fg.FrameTransforms, transforms.message(time, poses)), time)

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
            shapes.entity(frame, time, frame, cylinders=[disc], arrows=[arrow], texts=[text] if number else [])
            for frame, number, text in zip(frames, numbers, texts, strict=True)
        ]
        self._show("/robots", fg.SceneUpdate(entities=entities), time)

    def _trail(self, time: int, source: str, places: list[Place]) -> bool:
        """A place is part of the trail where the one before is old enough. Returns whether this one is."""
        if time < self._trail_due.get(source, 0):
            return False
        self._trail_due[source] = time + TRAIL_EACH
        before = self._trails.get(source, [])
        trail = self._trails[source] = before if before and len(before[-1]) == len(places) else []
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


class Transforms:
    """From frame ``map`` to each of ``frames``, in their order: ``foxglove.FrameTransforms`` as bytes.

    Only the numbers in a template of the message change. A run has thousands of messages, and building an object for
    each number would take most of their time.
    """

    def __init__(self, frames: Sequence[str]) -> None:
        self.frames = tuple(frames)
        stamp = 2 + 2 * (1 + _VARINT)
        self._parts = []
        for frame in frames:
            names = _text(2, shapes.MAP_FRAME) + _text(3, frame)
            size = stamp + len(names) + _PLACE_AND_TURN.size
            self._parts.append((b"\x0a" + _varint(size), names))

    def message(self, time: int, poses: Iterable[Sequence[float]]) -> bytes:
        """The message at ``time``, ps. ``poses``: of each frame x and y in metres, and the angle in radians."""
        seconds, rest = divmod(time, 10**12)
        numbers = b"\x08" + _varint(seconds, _VARINT) + b"\x10" + _varint(rest // 1000, _VARINT)
        stamp, grain, content = b"\x0a" + bytes([len(numbers)]) + numbers, shapes.GRAIN, []
        for (head, names), (right, up, angle) in zip(self._parts, poses, strict=True):
            x, y = round(right * grain) / grain, round(up * grain) / grain
            z, w = round(math.sin(angle / 2) * grain) / grain, round(math.cos(angle / 2) * grain) / grain
            place = _PLACE_AND_TURN.pack(0x22, 18, 9, x, 0x11, y, 0x2A, 18, 0x19, z, 0x21, w)
            content += [head, stamp, names, place]
        return b"".join(content)


def _varint(number: int, size: int = 0) -> bytes:
    """A number as protobuf has it, in at least ``size`` bytes."""
    parts: list[int] = []
    while number >= 0x80 or len(parts) + 1 < size:
        parts.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*parts, number])


def _text(field: int, text: str) -> bytes:
    content = text.encode()
    return bytes([field << 3 | 2]) + _varint(len(content)) + content
