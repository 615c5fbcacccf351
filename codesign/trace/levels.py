"""How much of a run a trace holds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.records import (
    CommandRecord,
    FieldRecord,
    MessageRecord,
    Record,
    SampleRecord,
    ScanRecord,
    StageRecord,
    TaskRecord,
    VisitsRecord,
)


class Level(StrEnum):
    """How much a trace holds. Each level holds what the one before holds, and more.

    - ``mission``: the map, obstacles, beliefs, plans, paths, poses, events, busy shares of the whole run, the result.
    - ``messages``: tasks, messages, commands, scans, and samples of queues, FIFOs and busy shares.
    - ``blocks``: the stages, visits and fields of plans.
    - ``iterations``: each visit in a record of its own.
    """

    MISSION = "mission"
    MESSAGES = "messages"
    BLOCKS = "blocks"
    ITERATIONS = "iterations"


_FROM: dict[type[Record], Level] = {
    TaskRecord: Level.MESSAGES,
    MessageRecord: Level.MESSAGES,
    CommandRecord: Level.MESSAGES,
    ScanRecord: Level.MESSAGES,
    SampleRecord: Level.MESSAGES,
    StageRecord: Level.BLOCKS,
    VisitsRecord: Level.BLOCKS,
    FieldRecord: Level.BLOCKS,
}
"""The lowest level that holds records of a class; every level holds those of all others."""


def unwanted(level: Level) -> frozenset[type[Record]]:
    """The classes of records that a level leaves out."""
    order = list(Level)
    return frozenset(kind for kind, least in _FROM.items() if order.index(least) > order.index(level))


BARE: dict[type[Record], str] = {StageRecord: "potential", FieldRecord: "values"}
"""Records with a grid that may be left out: fields of plans. A mission has hundreds of them."""

_NONE = np.zeros((0, 0))


def bared(record: Record) -> Record:
    """The record without its grid, where the grid may be left out: an array of 0 × 0 in its place."""
    name = BARE.get(type(record))
    if name is None:
        return record
    empty: dict[str, Any] = {name: _NONE}
    return replace(record, **empty)


def single_visits(record: VisitsRecord) -> Iterator[VisitsRecord]:
    """A record for each visit of ``record``. Their times are exact to the picosecond, rounded down.

    All visits of a record take equally many cycles an iteration.
    """
    total = int(record.iterations.sum())
    ends: Sequence[Any] | NDArray[Any] = (
        np.cumsum(record.iterations.astype(object)) if len(record.block) else []
    )
    begin, span = record.time, record.end - record.time
    for place, done in enumerate(ends):
        end = record.time + span * int(done) // max(total, 1)
        part = slice(place, place + 1)
        yield VisitsRecord(
            begin,
            record.source,
            end,
            record.stage,
            record.precision,
            record.block[part],
            record.iterations[part],
        )
        begin = end
