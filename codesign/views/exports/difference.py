"""The first difference of two traces, and all differences: ``hwsw trace diff A B``."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from itertools import islice
from operator import itemgetter
from typing import Any

import numpy as np
from more_itertools import map_reduce

from codesign.ground.records import Record, Subject
from codesign.views.report.wording import Cell, Table, count_cell, cut, left, right, time_cell, word, words

Records = Callable[[], Iterable[Record]]
"""Reads a trace from its beginning, in the order of emission."""

_MOST_TEXT = 60


@dataclass(frozen=True)
class Channel:
    """The records of one class and one source in two traces.

    - ``counts``: how many each trace has. ``same``: how many of the first ones are equal in all fields.
    - ``time``: when the first ones that differ end or happen, ps, the earlier one; None: all are equal.
    """

    record: str
    source: str
    counts: tuple[int, int]
    same: int
    time: int | None


@dataclass(frozen=True)
class Difference:
    """The differences between two traces.

    - ``channels``: the channels that either trace has, by the time of their first difference; equal ones last.
    - ``first``: the first records that differ, of each trace, None where that trace has no such record.
    - ``results``: the figures of the results that differ, by name, with both values as text.
    """

    channels: tuple[Channel, ...]
    first: tuple[Record | None, Record | None] | None
    results: Mapping[str, tuple[str, str]]

    @property
    def equal(self) -> bool:
        """True if all records are equal."""
        return self.first is None

    def fields(self) -> list[tuple[str, str, str]]:
        """The fields in which the first records differ: name, and both values as text."""
        if self.first is None or None in self.first:
            return []
        one, other = self.first
        return [
            (item.name, _text(getattr(one, item.name)), _text(getattr(other, item.name)))
            for item in fields(one)  # type: ignore[arg-type]
            if _bytes(getattr(one, item.name)) != _bytes(getattr(other, item.name))
        ]


def difference(first: Records, second: Records) -> Difference:
    """Compare two traces record by record: records of one class and one source in their order.

    Each trace is read twice at most. Of each record a digest of 16 bytes is kept.
    """
    one, other = _digests(first()), _digests(second())
    keys = {**one.digests, **other.digests}
    channels = sorted(
        (_compared(key, one.digests.get(key, []), other.digests.get(key, [])) for key in keys),
        key=lambda channel: (channel.time is None, channel.time, channel.record, channel.source),
    )
    differing = next((channel for channel in channels if channel.time is not None), None)
    pair = None if differing is None else (_record(first, differing), _record(second, differing))
    names = {**one.result, **other.result}
    results = {
        name: (one.result.get(name, "–"), other.result.get(name, "–"))
        for name in names
        if one.result.get(name) != other.result.get(name)
    }
    return Difference(tuple(channels), pair, results)


_Key = tuple[str, str]


@dataclass
class _Read:
    digests: dict[_Key, list[tuple[int, bytes]]]
    result: dict[str, str]


def _digests(records: Iterable[Record]) -> _Read:
    digests: list[tuple[_Key, tuple[int, bytes]]] = []
    result: dict[str, str] = {}
    for record in records:
        digest = hashlib.blake2b(digest_size=16)
        for item in fields(record):
            digest.update(_bytes(getattr(record, item.name)))
        digests.append(((type(record).__name__, record.source), (record.time, digest.digest())))
        if record.ROLE.about is Subject.RESULT:
            result = dict(_flat("", vars(record)["result"]))
    return _Read(map_reduce(digests, itemgetter(0), itemgetter(1)), result)


def _compared(key: _Key, one: list[tuple[int, bytes]], other: list[tuple[int, bytes]]) -> Channel:
    pairs = enumerate(zip(one, other, strict=False))
    same = next((place for place, (left, right) in pairs if left != right), min(len(one), len(other)))
    times = [each[same][0] for each in (one, other) if same < len(each)]
    return Channel(*key, (len(one), len(other)), same, min(times) if times else None)


def _record(records: Records, channel: Channel) -> Record | None:
    """The first record of a channel that differs, in one of the traces."""
    own = (record for record in records() if (type(record).__name__, record.source) == (channel.record, channel.source))
    return next(islice(own, channel.same, None), None)


def _bytes(value: Any) -> bytes:
    """The bytes that tell a value from all others of its field."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype.str}{value.shape}".encode() + value.tobytes()
    return f"{type(value).__name__} {value!r};".encode()


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"{' × '.join(map(str, value.shape))} values"
    return cut(str(value), _MOST_TEXT)


def _flat(name: str, value: Any) -> Iterable[tuple[str, str]]:
    """The leaves of a result by their paths."""
    if isinstance(value, Mapping):
        parts: Iterable[tuple[Any, Any]] = value.items()
    elif isinstance(value, list):
        parts = enumerate(value)
    else:
        yield name, _text(value)
        return
    for key, part in parts:
        yield from _flat(f"{name}.{key}" if name else str(key), part)


def channels_table(found: Difference, names: tuple[str, str]) -> Table:
    """All channels, the one that differs first at the top. ``names``: of the two traces."""
    counts = right(*names, "equal from the start")
    columns = (*left("records", "source"), *counts, *right("first difference", unit="s"))
    rows = tuple(
        (
            *words(channel.record.removesuffix("Record").lower(), channel.source),
            *map(count_cell, channel.counts),
            Cell("all", channel.same) if channel.time is None else count_cell(channel.same),
            time_cell(channel.time),
        )
        for channel in found.channels
    )
    return Table("records of each kind", columns, rows)


def results_table(found: Difference, names: tuple[str, str], most: int = 40) -> Table:
    """The figures of the results that differ, at most so many."""
    rows = tuple(
        (word(name), Cell(one, one), Cell(other, other)) for name, (one, other) in islice(found.results.items(), most)
    )
    more = len(found.results) - len(rows)
    notes = (f"and {more} more",) if more > 0 else ()
    return Table("figures of the result that differ", (*left("figure"), *right(*names)), rows, notes)
