"""Priced outcomes as bytes: one block for the points that compute the same.

A block is a JSON header in one line, then the fields of its templates as JSON texts, a line each, then its arrays, all
compressed. Templates with the same field have the same text (``Parts``). The first bytes of all numbers of an array
come first, then the second ones: equal leading bytes of neighbours then compress to little.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import chain, islice
from typing import Any, NamedTuple

import numpy as np
import zstandard
from more_itertools import split_when
from numpy.typing import NDArray
from pydantic import TypeAdapter

from codesign.study.definition import read_json
from codesign.study.partition import Indices, Together, Work
from codesign.study.pricing.price import PRICED, Priced
from codesign.study.shared import Parts
from codesign.system.results.result import Reason

_LEVEL = 3
_MOST_BYTES = 2**30


def compressed(data: bytes) -> bytes:
    """The bytes, shorter."""
    return zstandard.compress(data, _LEVEL)


def expanded(data: bytes) -> bytes:
    """The bytes that were compressed, of bounded size.

    Raises:
        ValueError: the bytes are damaged, or too many come of them.
    """
    try:
        # Checked before: as many bytes are taken as the frame says.
        size = zstandard.get_frame_parameters(data).content_size
        if size > _MOST_BYTES:
            raise ValueError(f"a block of more than {_MOST_BYTES:,} bytes, or of a length that it does not say")
        return zstandard.ZstdDecompressor().decompress(data, allow_extra_data=False)
    except zstandard.ZstdError as wrong:
        raise ValueError(str(wrong)) from wrong


_COLUMNS = ("figures", "lows", "highs")
_REASONS = TypeAdapter(tuple[Reason, ...])
_VARIES = object()


Plan = Sequence[tuple[str, Indices]]
"""The key of each block, and its points; under an empty key points that are simulated by themselves."""


def block_of(priced: Priced, parts: Parts) -> tuple[bytes, Priced]:
    """The outcomes as bytes, and what a reader makes of these: the same, of shared parts."""
    arrays: list[NDArray[Any]] = [priced.which.astype(np.int32), priced.reason.astype(np.int32)]
    constants: dict[str, dict[str, float | None]] = {}
    for kind in _COLUMNS:
        constants[kind] = {}
        for name, column in {"figures": priced.figures, "lows": priced.lows, "highs": priced.highs}[kind].items():
            if (column == column[0]).all() or np.isnan(column).all():
                constants[kind][name] = None if np.isnan(column[0]) else float(column[0])
            else:
                arrays.append(np.asarray(column, np.float64))
    texts, numbers, templates = parts.put(priced.templates)
    header = {
        "count": len(priced.which),
        "templates": len(numbers),
        "texts": {name: len(own) for name, own in texts.items()},
        "reasons": [reason.model_dump(mode="json") for reason in priced.reasons],
        "constants": constants,
    }
    line = json.dumps(header, ensure_ascii=False, separators=(",", ":")).encode()
    columns = [numbers.T.reshape(-1), *arrays]
    data = compressed(b"\n".join([line, *chain(*texts.values()), b"".join(map(_planes, columns))]))
    return data, replace(priced, templates=templates)


def read_block(data: bytes, parts: Parts) -> Priced:
    """The outcomes of a block, of shared parts.

    Raises:
        ValueError, KeyError, TypeError: the bytes are no block that this version can read.
    """
    text, _, rest = expanded(data).partition(b"\n")
    header = _Header.read(text)
    texts, rest = _texts(header.texts, rest)
    reader = _Reader(rest)
    numbers = reader.take(np.dtype(np.int32), header.templates * len(texts)).reshape(len(texts), -1).T
    which, reason = reader.take(np.dtype(np.int32), header.points, 2).astype(np.intp)
    varying = reader.take(np.dtype(np.float64), header.points, len(header.varying))
    if np.isinf(varying).any():
        raise ValueError("a block has figures that are not finite")
    table = np.repeat(header.constants[:, None], header.points, axis=1)
    table[header.varying] = varying
    templates = parts.take(texts, numbers)
    if reader.left or not _inside(which, 0, len(templates)) or not _inside(reason, -1, len(header.reasons)):
        raise ValueError("the arrays of a block do not belong to its header")
    kinds = table.reshape(len(_COLUMNS), len(PRICED), -1)
    figures, lows, highs = (dict(zip(PRICED, own, strict=True)) for own in kinds)
    return Priced(templates, which, figures, lows, highs, header.reasons, reason)


class _Header(NamedTuple):
    """The first line of a block. ``constants``: of each column; NaN where it varies. ``varying``: which ones do."""

    points: int
    templates: int
    texts: Mapping[str, int]
    reasons: tuple[Reason, ...]
    constants: NDArray[np.float64]
    varying: list[int]

    @staticmethod
    @lru_cache(maxsize=256)
    def read(text: bytes) -> _Header:
        """The header of many blocks that say the same is one object."""
        held = read_json(text.decode())
        constants = [held["constants"][kind].get(name, _VARIES) for kind in _COLUMNS for name in PRICED]
        varying = [number for number, value in enumerate(constants) if value is _VARIES]
        columns = np.array([np.nan if value in (None, _VARIES) else value for value in constants], np.float64)
        reasons = _REASONS.validate_python(held["reasons"])
        return _Header(int(held["count"]), int(held["templates"]), held["texts"], reasons, columns, varying)


def plan_of(works: Iterable[Work], *, alone: bool = False, earlier: Plan = ()) -> bytes:
    """The points that compute the same: the key of each block, and its points.

    ``alone``: the points that are simulated by themselves too, under an empty key. ``earlier``: another plan of the
    same study; what stands in it is kept.
    """
    plan = {(key, numbers.tobytes()): (key, numbers) for key, numbers in earlier}
    for work in works:
        if isinstance(work, Together):
            plan[work.key, work.numbers.tobytes()] = work.key, work.numbers
        elif alone and len(work):
            numbers = np.array(sorted(work.indices), np.int64)
            plan["", numbers.tobytes()] = "", numbers
    header = json.dumps([[key, len(numbers)] for key, numbers in plan.values()])
    steps = [numbers - np.append(0, numbers[:-1]) for _, numbers in plan.values()]
    return compressed(b"\n".join([header.encode(), b"".join(map(_planes, steps))]))


def read_plan(data: bytes, count: int) -> list[tuple[str, Indices]]:
    """The key of each block, and its points, of a study of ``count`` points.

    Raises:
        ValueError, KeyError, TypeError: the bytes are no plan that this version can read.
    """
    text, _, rest = expanded(data).partition(b"\n")
    plan: list[tuple[str, Indices]] = []
    reader = _Reader(rest)
    for blocks in split_when(read_json(text.decode()), lambda one, other: one[1] != other[1]):
        keys, (size, *_) = zip(*blocks, strict=True)
        numbers = np.cumsum(reader.take(np.dtype(np.int64), size, len(keys)), axis=1)
        if not _inside(numbers, 0, count) or (np.diff(numbers) <= 0).any():
            raise ValueError("a block has points that the study has not")
        plan += zip(map(str, keys), numbers, strict=True)
    return plan


def _planes(array: NDArray[Any]) -> bytes:
    """The first bytes of all numbers, then the second ones, and so on; little-endian."""
    little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    return little.view(np.uint8).reshape(len(array), -1).T.tobytes()


def _texts(counts: Mapping[str, int], data: bytes) -> tuple[dict[str, list[bytes]], bytes]:
    """The texts of each field, as many as counted, a line each; and the bytes behind them."""
    *lines, rest = data.split(b"\n", sum(counts.values()))
    if len(lines) != sum(counts.values()) or min(counts.values(), default=0) < 0:
        raise ValueError("a block lacks texts")
    texts = iter(lines)
    return {name: [*islice(texts, count)] for name, count in counts.items()}, rest


class _Reader:
    """Reads arrays, one after another."""

    def __init__(self, data: bytes) -> None:
        self._data, self._place = data, 0

    @property
    def left(self) -> int:
        """Bytes that were not read."""
        return len(self._data) - self._place

    def take(self, kind: np.dtype[Any], count: int, arrays: int = 1) -> NDArray[Any]:
        """The next arrays, of ``count`` numbers each: arrays × numbers."""
        size = arrays * count * kind.itemsize
        if count < 0 or size > self.left:
            raise ValueError("a block is cut off")
        planes = np.frombuffer(self._data, np.uint8, size, self._place).reshape(arrays, kind.itemsize, count)
        self._place += size
        numbers = np.empty((arrays, count), kind.newbyteorder("<"))
        own = numbers.view(np.uint8).reshape(arrays, count, kind.itemsize)
        for place in range(kind.itemsize):
            own[:, :, place] = planes[:, place]
        return numbers.astype(kind, copy=False)


def _inside(numbers: NDArray[Any], least: int, count: int) -> bool:
    return not numbers.size or bool(least <= numbers.min() and numbers.max() < count)
