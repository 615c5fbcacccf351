"""The entries of a certificate: designs that were evaluated one by one, boxes of others, and what is left."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import CertificateError
from codesign.study.groups import Groups
from codesign.study.outcomes import State
from codesign.study.space import Box, points_of
from codesign.study.table import Table

Numbers = NDArray[np.int64]
_FEW = 64
_NOTHING = "its boxes prove nothing: explore without --search bound"


@dataclass(frozen=True, eq=False)
class Entries:
    """The entries of a certificate of a study.

    - ``study``: with its designs in the order of the space. ``places``: their numbers in the whole space.
    - ``boxes``: of designs that were not evaluated; the last ones hold the designs that are in no box of a search.
    - ``holder``: for each design of the study the number of the box that stands for it; -1: it is a row.
    """

    study: Table
    boxes: Sequence[Box]
    holder: Numbers

    @classmethod
    def of(cls, study: Table, excluded: Sequence[Box]) -> Entries:
        """The entries of a study with these boxes, without the boxes of which each design was evaluated.

        Raises:
            CertificateError: a design that was evaluated is better than its box allows.
        """
        if study.chosen is not None:
            order = np.argsort(np.array(study.chosen, np.int64))
            conditions = len(study.world.each)
            outcomes = study.outcomes.chosen(points_of(order.tolist(), conditions))
            study = replace(study, chosen=tuple(np.array(study.chosen)[order].tolist()), outcomes=outcomes)
        every = cls(study, excluded, np.full(study.judged.count, -1, np.int64))
        boxes, holder = every._needed()
        entries = cls(study, boxes, holder)
        entries._check_held()
        return entries if study.chosen is None else replace(entries, boxes=(*boxes, *entries._left()))

    @cached_property
    def places(self) -> Numbers:
        """The number of each design of the study in the whole space."""
        chosen = self.study.chosen
        return np.arange(self.study.judged.count) if chosen is None else np.array(chosen, np.int64)

    @property
    def rows(self) -> Numbers:
        """The designs of the study that are rows."""
        return np.flatnonzero(self.holder < 0)

    def _needed(self) -> tuple[list[Box], Numbers]:
        """The boxes with a design that was not evaluated; and for each design of the study its box."""
        holder, known = self.holder.copy(), self.study.judged.state != State.MISSING
        for part, own in self._by_part.items():
            rows, places = self._rows_in(part)
            low, high = self._ends(part)
            holder[rows] = np.append(own, -1)[holders(low, high, places)]
        sizes = [math.prod(np.subtract(box.high, box.low).tolist()) for box in self.boxes]
        # A box stays unless all of its designs were evaluated: as many evaluated designs lie in it as it has.
        evaluated = np.bincount(holder[known & (holder >= 0)], minlength=len(sizes))
        kept = [number for number, size in enumerate(sizes) if evaluated[number] < size]
        numbers = np.full(len(sizes) + 1, -1, np.int64)
        numbers[kept] = np.arange(len(kept))
        return [self.boxes[number] for number in kept], numbers[holder]

    @cached_property
    def _by_part(self) -> dict[int, Numbers]:
        """The boxes in each part of the space that has one, by number."""
        parts = np.array([box.part for box in self.boxes], np.int64)
        return {int(parts[members[0]]): members for members in Groups.of(parts).members}

    def _ends(self, part: int) -> tuple[Numbers, Numbers]:
        """Begin and end of each box in a part of the space, boxes × axes."""
        boxes = [self.boxes[number] for number in self._by_part.get(part, ())]
        shape = len(boxes), len(self.study.decisions.parts[part].axes)
        low, high = [box.low for box in boxes], [box.high for box in boxes]
        return np.array(low, np.int64).reshape(shape), np.array(high, np.int64).reshape(shape)

    def _rows_in(self, part: int) -> tuple[Numbers, Numbers]:
        """The designs of the study in a part of the space, and their places on its axes."""
        box = self.study.decisions.parts[part]
        begin, end = np.searchsorted(self.places, [box.begin, box.begin + box.size])
        shape = [*map(len, box.axes.values())] or [1]
        own = np.unravel_index(self.places[begin:end] - box.begin, shape)
        places = np.stack(own, axis=1).astype(np.int64)[:, : len(box.axes)]
        return np.arange(begin, end), places

    def _left(self) -> list[Box]:
        """Boxes of the designs that are in no other entry."""
        left = []
        for part, box in enumerate(self.study.decisions.parts):
            rows, places = self._rows_in(part)
            places = places[self.holder[rows] < 0]
            low, high = self._ends(part)
            first, last = np.concatenate([places, low]), np.concatenate([places + 1, high])
            shape = tuple(map(len, box.axes.values()))
            left += [Box(part, *ends) for ends in rest_of(first, last, shape)]
        return left

    def _check_held(self) -> None:
        """Refuse boxes of which a design that was evaluated says that they are none."""
        study, held = self.study, np.flatnonzero(self.holder >= 0)
        boxes = [self.boxes[number] for number in self.holder[held]]
        feasible = study.judged.feasible[held]
        wrong = feasible & np.array([bool(box.why) and box.by is None for box in boxes], np.bool_)
        for figure in study.objectives:
            bounds = np.array([(box.bound or {}).get(figure.name, math.nan) for box in boxes])
            values = study.judged.figure(figure)[held]
            wrong |= feasible & (values > bounds if study.world.maximise(figure) else values < bounds)
        if wrong.any():
            design = int(self.places[held[int(wrong.argmax())]])
            what = f"design {design} was evaluated, and is better than its box allows"
            raise CertificateError(what, hint=_NOTHING)


def holders(low: Numbers, high: Numbers, places: Numbers) -> Numbers:
    """For each design the number of the box that it is in; -1: none.

    ``low``, ``high``: boxes × axes. ``places``: designs × axes.

    >>> holders(np.array([[0, 0], [2, 1]]), np.array([[2, 1], [3, 3]]), np.array([[1, 0], [2, 2], [0, 2]]))
    array([ 0,  1, -1])
    """
    found = np.full(len(places), -1, np.int64)
    stack = [(np.arange(len(low)), low, high, np.arange(len(places)))]
    while stack:
        boxes, low, high, own = stack.pop()
        cut = None if len(boxes) <= _FEW or not len(own) else _cut(low, high)
        if cut is not None:
            axis, at = cut
            below, behind, before = low[:, axis] < at, high[:, axis] > at, places[own, axis] < at
            clipped = low[behind]
            clipped[:, axis] = np.maximum(clipped[:, axis], at)
            stack.append((boxes[below], low[below], high[below], own[before]))
            stack.append((boxes[behind], clipped, high[behind], own[~before]))
            continue
        for box, first, last in zip(boxes.tolist(), low, high, strict=True):
            found[own[((places[own] >= first) & (places[own] < last)).all(axis=1)]] = box
    return found


def rest_of(low: Numbers, high: Numbers, shape: tuple[int, ...]) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Boxes that fill a grid together with boxes that do not meet: begin and end of each, boxes × axes.

    >>> rest_of(np.array([[1, 0]]), np.array([[2, 2]]), (2, 3))
    [((0, 0), (1, 3)), ((1, 2), (2, 3))]
    """
    if sum((high - low).prod(axis=1).tolist()) == math.prod(shape):
        return []
    rest: list[tuple[tuple[int, ...], tuple[int, ...]]] = []
    stack = [((0,) * len(shape), shape, low, high)]
    while stack:
        begin, end, low, high = stack.pop()
        if not len(low):
            rest.append((begin, end))
        elif len(low) == 1:
            rest += _around(begin, end, low[0].tolist(), high[0].tolist())
        else:
            cut = _cut(low, high)
            if cut is None:
                raise CertificateError("two boxes hold the same design", hint=_NOTHING)
            axis, at = cut
            before, behind = low[:, axis] < at, high[:, axis] > at
            top, clipped = high[before].copy(), low[behind].copy()
            top[:, axis], clipped[:, axis] = np.minimum(top[:, axis], at), np.maximum(clipped[:, axis], at)
            middle, start = [*end], [*begin]
            middle[axis] = start[axis] = at
            stack += [(tuple(start), end, clipped, high[behind]), (begin, tuple(middle), low[before], top)]
    return rest


def _around(
    begin: Sequence[int], end: Sequence[int], low: Sequence[int], high: Sequence[int]
) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Boxes around one box in a larger one."""
    around = []
    first, last = [*begin], [*end]
    for axis, (bottom, top) in enumerate(zip(low, high, strict=True)):
        for one, other in ((first[axis], bottom), (top, last[axis])):
            if one < other:
                around.append(((*first[:axis], one, *first[axis + 1 :]), (*last[:axis], other, *last[axis + 1 :])))
        first[axis], last[axis] = bottom, top
    return around


def _cut(low: Numbers, high: Numbers) -> tuple[int, int] | None:
    """Axis and place of a cut that leaves few boxes on each side; None where no cut parts them."""
    best, cut = len(low), None
    for axis in range(low.shape[1]):
        begins = np.unique(low[:, axis])
        if len(begins) > 1:
            at = int(begins[len(begins) // 2])
            more = int(max((low[:, axis] < at).sum(), (high[:, axis] > at).sum()))
            # Of two boxes one may reach across: the cut still makes both smaller.
            if more < best or cut is None:
                best, cut = more, (axis, at)
    return cut
