"""``foxglove.FrameTransforms`` as bytes: a template of the message, in which only the numbers change.

A run has thousands of them, of up to thousands of robots each, so building objects would take most of its time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from codesign.trace import shapes

_VARINT = 5
"""Bytes of a number of a time. A varint may be longer than needed, so that the next number keeps its place."""

_BEFORE_TIME = b"\x0a" + bytes([2 * (1 + _VARINT)])
_BEFORE_PLACE, _BEFORE_TURN = b"\x22\x12", b"\x2a\x12"
"""Field and length: of the time, of a vector of x and y, of a quaternion of z and w. What is left out is 0."""


class Transforms:
    """From frame ``map`` to each of ``frames``, in their order."""

    def __init__(self, frames: Sequence[str]) -> None:
        self.frames = tuple(frames)
        stamps, numbers, content = [], [], b""
        for frame in frames:
            names = _text(2, shapes.MAP_FRAME) + _text(3, frame)
            time = _BEFORE_TIME + b"\x08" + bytes(_VARINT) + b"\x10" + bytes(_VARINT)
            place = _BEFORE_PLACE + b"\x09" + bytes(8) + b"\x11" + bytes(8)
            turn = _BEFORE_TURN + b"\x19" + bytes(8) + b"\x21" + bytes(8)
            head = b"\x0a" + _varint(len(time + names + place + turn))
            stamps.append(len(content + head) + len(_BEFORE_TIME))
            begin = len(content + head + time + names)
            numbers += [begin + 3, begin + 12, begin + 23, begin + 32]
            content += head + time + names + place + turn
        self._content = np.frombuffer(content, np.uint8)
        self._stamps = np.array(stamps, np.int64)[:, None] + np.arange(2 * (1 + _VARINT))
        self._numbers = (np.array(numbers, np.int64)[:, None] + np.arange(8)).ravel()

    def message(self, time: int, poses: NDArray[np.float64]) -> bytes:
        """The message at ``time``, ps. ``poses``: float64 n × 3, x and y in metres and the angle in radians."""
        seconds, rest = divmod(time, 10**12)
        stamp = b"\x08" + _varint(seconds, _VARINT) + b"\x10" + _varint(rest // 1000, _VARINT)
        half = poses[:, 2] / 2
        values = shapes.rounded(np.column_stack([poses[:, :2], np.sin(half), np.cos(half)]))
        content = self._content.copy()
        content[self._stamps] = np.frombuffer(stamp, np.uint8)
        content[self._numbers] = values.astype("<f8", copy=False).ravel().view(np.uint8)
        return content.tobytes()


def _varint(number: int, size: int = 0) -> bytes:
    """A number as protobuf has it, in at least ``size`` bytes."""
    parts = []
    while number >= 0x80 or len(parts) + 1 < size:
        parts.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*parts, number])


def _text(field: int, text: str) -> bytes:
    content = text.encode()
    return bytes([field << 3 | 2]) + _varint(len(content)) + content
