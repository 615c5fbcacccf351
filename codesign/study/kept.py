"""The works of an exploration that a store has, how new outcomes are kept there, and the traces of searches.

Bounds hold for a study whatever was evaluated since, so the boxes that a search excluded outlive it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeVar

import numpy as np

from codesign.ground.errors import StoreError
from codesign.study.blocks import Plan, block_of, compressed, expanded, read_block
from codesign.study.definition import OTHER_VERSION, read_json
from codesign.study.evaluation import Done
from codesign.study.partition import Alone, Indices, Together, Work
from codesign.study.pricing.machines import Specs
from codesign.study.pricing.price import Priced
from codesign.study.search import Searched, Trace
from codesign.study.shared import Parts
from codesign.study.space import Box, Space
from codesign.study.store import Batch, Entry, EntryState, Store

_KEYS_AT_ONCE = 500


@dataclass(frozen=True)
class Kept:
    """The results of works in a store. ``where``: its file, for messages. ``space``: of the points.

    ``parts``: what the templates that it gives have in common. ``lasting``: whether anything reads the store again.
    """

    store: Store
    space: Space
    where: str | None
    parts: Parts = field(default_factory=Parts)
    lasting: bool = True

    def everything(self, plan: Plan) -> Iterator[Done]:
        """The contents of the store for a study: its blocks by their keys, and all other points one by one.

        Raises:
            StoreError: see ``parted``.
        """
        alone = np.ones(len(self.space), bool)
        for key, numbers in plan:
            if alone[numbers].any():
                for done in self.blocks([(key, numbers)]):
                    alone[numbers] = False
                    yield done
        yield from self._entries(np.flatnonzero(alone))

    def planned(self, plan: Plan) -> Iterator[Done]:
        """The contents of the store for the points of a plan alone; the space may be too large to go through.

        Raises:
            StoreError: see ``parted``.
        """
        left = set(np.concatenate([numbers for _, numbers in plan]).tolist()) if plan else set()
        for done in self.blocks(plan):
            left.difference_update(done.work.indices)
            yield done
        yield from self._entries(np.array(sorted(left), np.int64))

    @staticmethod
    def designs_of(plan: Plan, conditions: int) -> list[int]:
        """The designs of the points of a plan, each once, in their order there."""
        numbers = [numbers // conditions for _, numbers in plan]
        return list(dict.fromkeys(np.concatenate(numbers).tolist())) if numbers else []

    def blocks(self, plan: Iterable[tuple[str, Indices]]) -> Iterator[Done]:
        """The contents of the store for the blocks of a plan.

        Raises:
            StoreError: see ``parted``.
        """
        for key, numbers in plan:
            block = next(self.store.blocks([key]), None) if key else None
            if block is not None:
                work = Together(numbers, {}, Specs({}, {}, len(numbers)), key)
                yield Done(work, self._read(block[1], len(work.numbers)))

    def _entries(self, points: Indices) -> Iterator[Done]:
        """The contents of the store for points that were simulated by themselves."""
        if not len(points) or not self.store.has_entries():
            return
        for begin in range(0, len(points), _KEYS_AT_ONCE):
            some = Alone(tuple(map(self.space.point, points[begin : begin + _KEYS_AT_ONCE].tolist())))
            yield from (each for each in self._by_point(some, False) if isinstance(each, Done))

    def parted(self, works: Iterable[Work]) -> Iterator[Done | Work]:
        """Each work as what the store has of it, or as what is left to compute.

        Points that failed are left to compute. A work that is kept in part gives both.

        Raises:
            StoreError: the store cannot be read, or holds a block that this version cannot read.
        """
        for work in works:
            if isinstance(work, Together):
                block = next(self.store.blocks([work.key]), None)
                if block is not None:
                    yield Done(work, self._read(block[1], len(work.numbers)))
                    continue
                if not self.store.has_entries():
                    yield work
                    continue
            yield from self._by_point(work, True)

    def _by_point(self, work: Work, retry: bool) -> Iterator[Done | Work]:
        points = work.points if isinstance(work, Alone) else tuple(map(self.space.point, work.indices))
        entries: dict[str, Entry] = {}
        for begin in range(0, len(points), _KEYS_AT_ONCE):
            entries |= self.store.find([point.key for point in points[begin : begin + _KEYS_AT_ONCE]])
        if retry:
            entries = {key: each for key, each in entries.items() if each.state is not EntryState.FAILED}
        done = tuple(point for point in points if point.key in entries)
        if done:
            yield Done(Alone(done), entries=tuple(entries[point.key] for point in done))
        left = tuple(point for point in points if point.key not in entries)
        if left:
            yield Alone(left) if done or isinstance(work, Alone) else work

    def put(self, done: Done) -> Done:
        """Keep what came in. Gives it as it would be read again: of shared parts.

        Raises:
            StoreError: the store cannot be written.
        """
        if done.block:
            done = replace(done, priced=self._read(done.block, len(done.work)))
        elif not self.lasting:
            shared = done.priced and replace(done.priced, templates=self.parts.shared(done.priced.templates))
            done = replace(done, priced=shared)
        if not self.lasting:
            return done
        blocks = {}
        if done.priced is not None and isinstance(done.work, Together):
            block, priced = done.block, done.priced
            if not block:
                block, priced = block_of(done.priced, self.parts)
            blocks[done.work.key], done = block, replace(done, priced=priced)
        self.store.put(Batch(done.entries, blocks, done.computations))
        return done

    def _read(self, data: bytes, count: int) -> Priced:
        try:
            priced = read_block(data, self.parts)
            if len(priced.which) != count:
                raise ValueError(f"a block of {len(priced.which)} points, not of {count}")
        except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError) as wrong:
            raise StoreError("holds a block that this version cannot read", self.where, OTHER_VERSION) from wrong
        return priced


T = TypeVar("T")
_BOXES, _SEARCHED = "excluded", "searched"


def keep_boxes(kept: Kept, study: str, excluded: Sequence[Box], decisions: Space) -> None:
    """Keep the boxes of a search, unless the boxes of an earlier one hold as many designs.

    ``study``: its key in the store.
    """
    if _designs(excluded) > _designs(boxes_of(kept, study, decisions)):
        _put(kept, f"{_BOXES} {study}", [box.row for box in excluded])


def boxes_of(kept: Kept, study: str, decisions: Space) -> tuple[Box, ...]:
    """The boxes that were kept for a study.

    Raises:
        StoreError: they are none of this space.
    """

    def boxes(rows: Any) -> tuple[Box, ...]:
        return tuple(Box.of_row(row, decisions) for row in rows)

    return _read(kept, f"{_BOXES} {study}", "boxes of a search", boxes) or ()


def keep_search(kept: Kept, study: str, searched: Searched) -> None:
    """Keep what searches did of a study, in the place of earlier ones. ``study``: its key in the store."""
    traces = [
        {each.name: getattr(trace, each.name) for each in fields(trace)}
        | {"excluded": [box.row for box in trace.excluded]}
        for trace in searched.traces
    ]
    if traces:
        record = {"traces": traces, "simulated": searched.simulated, "kept": searched.kept}
        _put(kept, f"{_SEARCHED} {study}", record)


def forget_search(kept: Kept, study: str) -> None:
    """All points are asked for: the study is of no search any more."""
    key = f"{_SEARCHED} {study}"
    if any(True for _ in kept.store.blocks([key])):
        _put(kept, key, None)


def search_of_study(kept: Kept, study: str, decisions: Space, chosen: Sequence[int] | None) -> Searched | None:
    """The last search of a study; None if all points were asked for.

    ``decisions``: all designs. ``chosen``: the designs that the study holds; None: all.

    Raises:
        StoreError: it is none of this space.
    """

    def searched(record: Any) -> Searched | None:
        if record is None:
            return None
        held = range(len(decisions)) if chosen is None else frozenset(chosen)
        traces = tuple(_trace(each, decisions) for each in record["traces"])
        if not traces or any(design not in held for trace in traces for design in trace.designs):
            raise ValueError("a design that the study has not")
        return Searched(traces, _whole(record["simulated"]), _whole(record["kept"]))

    return _read(kept, f"{_SEARCHED} {study}", "a search", searched)


def _designs(excluded: Sequence[Box]) -> int:
    return sum(box.designs for box in excluded)


def _trace(record: Any, decisions: Space) -> Trace:
    name, ended, proved = record["name"], record["ended"], record["proved"]
    enumerated = record["enumerated"]
    if not all(isinstance(text, str) for text in (name, ended, enumerated)) or not isinstance(proved, bool):
        raise TypeError("no name, end or proof")
    return Trace(
        name,
        _whole(record["seed"]),
        [*map(_whole, record["designs"])],
        _whole(record["repeated"]),
        tuple(Box.of_row(row, decisions) for row in record["excluded"]),
        ended,
        proved,
        enumerated,
    )


def _whole(value: Any) -> int:
    if type(value) is not int or value < 0:
        raise TypeError("no whole number")
    return int(value)


def _put(kept: Kept, key: str, record: Any) -> None:
    text = json.dumps(record, separators=(",", ":"), allow_nan=False)
    kept.store.put(Batch(blocks={key: compressed(text.encode())}))


def _read(kept: Kept, key: str, what: str, make: Callable[[Any], T]) -> T | None:
    """The object that ``make`` makes of the record under a key; None if there is none."""
    for _, data in kept.store.blocks([key]):
        try:
            return make(read_json(expanded(data).decode()))
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as wrong:
            text = f"holds {what} that this version cannot read"
            raise StoreError(text, kept.where, OTHER_VERSION) from wrong
    return None
