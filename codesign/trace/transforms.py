"""``foxglove.FrameTransforms`` as bytes: a template of the message, in which only the numbers change.

A run has thousands of them. Building an object for each number would take most of their time.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Sequence

from codesign.trace import shapes

_VARINT = 5
"""Bytes of a number of a time. A varint may be longer than needed, so that the next number keeps its place."""

_PLACE_AND_TURN = struct.Struct("<BBBdBd BBBdBd")
"""A vector of x and y, and a quaternion of z and w, each number behind its field. What is left out is 0."""


class Transforms:
    """From frame ``map`` to each of ``frames``, in their order."""

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
