"""The works of an exploration that a store has, and how new outcomes are kept there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from codesign.ground.errors import StoreError
from codesign.study.blocks import Plan, block_of, read_block
from codesign.study.definition import OTHER_VERSION
from codesign.study.evaluation import Done
from codesign.study.partition import Alone, Indices, Together, Work
from codesign.study.pricing.machines import Specs
from codesign.study.pricing.price import Priced
from codesign.study.shared import Parts
from codesign.study.space import Space
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
