"""Columns of numbers for the script of a page: typed arrays behind one another, deflated, as text.

The script takes them out again (``templates/columns.js``). Every number is kept to its last bit.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.numbering import distinct

Entry = dict[str, Any]
"""The place of a column: its ``type``, the byte ``at`` which it begins, and the ``count`` of its numbers."""

_FEW = 1 << 16


class Columns:
    """Columns that are added one after the other. ``add`` and ``texts`` return where a column stands."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0

    @property
    def packed(self) -> str:
        """All of them, deflated, in base64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 9)).decode()

    def add(self, numbers: NDArray[Any]) -> Entry:
        """A column of whole numbers from 0 to 2^32 - 1, or of any float64; NaN and infinities are kept."""
        if numbers.dtype.kind != "f":
            most = int(numbers.max(initial=0))
            size = 1 if most < 1 << 8 else 2 if most < _FEW else 4
            return self._put(f"u{size}", numbers.astype(f"<u{size}").tobytes(), len(numbers))
        values, codes = distinct(numbers)
        if len(values) < min(_FEW, max(2, len(numbers) // 2)):
            of = [self._floats(values), self.add(codes)]
            return {"type": "coded", "count": len(numbers), "of": of}
        return self._floats(numbers)

    def steps(self, numbers: NDArray[np.int64]) -> Entry:
        """A column of whole numbers that differ little from one to the next, of at most 2^31 in size."""
        steps: NDArray[np.int64] = np.diff(numbers, prepend=np.int64(0))
        # 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
        return {"type": "steps", "count": len(numbers), "of": [self.add((steps << 1) ^ (steps >> 63))]}

    def texts(self, texts: Sequence[str]) -> Entry:
        """Texts, as JSON. ``count`` is the number of bytes."""
        written = json.dumps(list(texts), ensure_ascii=True).encode()
        return self._put("json", written, len(written))

    def _floats(self, numbers: NDArray[Any]) -> Entry:
        # The first bytes of all numbers, then the second ones, and so on: so they deflate better.
        planes = numbers.astype("<f8").view(np.uint8).reshape(-1, 8).T
        return self._put("f8", np.ascontiguousarray(planes).tobytes(), len(numbers))

    def _put(self, kind: str, content: bytes, count: int) -> Entry:
        at = self._length
        # A typed array of 4 bytes a number begins at a multiple of 4.
        self._parts.append(content + bytes(-len(content) % 8))
        self._length += len(self._parts[-1])
        return {"type": kind, "at": at, "count": count}
