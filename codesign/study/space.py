"""The points of an exploration, in file order: all of them, some of them, and boxes of designs."""

from __future__ import annotations

import hashlib
import json
import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.inputs.axes import Part, When, ordered, parts_of, value_text

MAX_GROUP = 16

Contents = Mapping[str, Mapping[str, str]]
"""Axis → canonical text of a value → digest of what the value stands for."""


@dataclass(frozen=True)
class DesignPoint:
    """One combination of axis values.

    Attributes:
        index: place in the enumeration, from 0; the last axis moves fastest.
        axes: the value of each axis as the workload's file gives it.
        key: SHA-256 over these values, what they stand for, and the fingerprint of all else that a result depends on.
    """

    index: int
    axes: dict[str, Any]
    key: str


class Space:
    """Every combination of the values of the axes that exist. Nothing is held for each point: it may have 10^8.

    Args:
        axes: the values of each axis by name (``relax.block``, ``fpga.clock``), in file order. No axis: one
            point.
        fingerprint: names all that a result depends on besides the axes and what they stand for; part of every key.
        contents: by axis and ``canonical`` text of a value, a digest of what the value stands for: a variant, a
            platform, a map in a file. It is part of the keys of its points alone, so that one more, or a change in one,
            leaves the points of the others where they are.
        when: for which values of other axes an axis exists. A point has no value of an axis that does not exist for it,
            and is one point. Points with the same axes stand together, in ``parts``; a space of which all axes always
            exist is one part.

    >>> space = Space({"relax.iterations": [1, 6], "fpga.clock": ["100 MHz", "150 MHz"]}, "")
    >>> len(space), space.point(1).axes
    (4, {'relax.iterations': 1, 'fpga.clock': '150 MHz'})
    """

    def __init__(
        self,
        axes: Mapping[str, Sequence[Any]],
        fingerprint: str,
        contents: Contents | None = None,
        when: When | None = None,
    ) -> None:
        self.when: When = MappingProxyType(dict(when or {}))
        self.axes: Mapping[str, tuple[Any, ...]] = MappingProxyType(
            {name: tuple(axes[name]) for name in ordered(axes, self.when)}
        )
        self.fingerprint = fingerprint
        self.contents: Contents = MappingProxyType(dict(contents or {}))
        self.parts: tuple[Part, ...] = parts_of(self.axes, self.when)
        self._begins = [part.begin for part in self.parts]
        self._numbers = {
            axis: {value_text(value): number for number, value in enumerate(values)}
            for axis, values in self.axes.items()
        }

    def __reduce__(self) -> tuple[type[Space], tuple[Any, ...]]:
        return Space, (dict(self.axes), self.fingerprint, dict(self.contents), dict(self.when))

    def __len__(self) -> int:
        return self.size

    @property
    def size(self) -> int:
        """The number of points of the whole space."""
        return sum(part.size for part in self.parts)

    def points(self) -> Iterator[DesignPoint]:
        """Every point, by index."""
        return map(self.point, range(len(self)))

    def point(self, index: int) -> DesignPoint:
        """The point at one place of the enumeration, 0 ≤ ``index`` < ``len``."""
        axes = self.values(index)
        identity = [self.fingerprint, axes]
        for axis, digests in self.contents.items():
            identity += [digest] if axis in axes and (digest := digests.get(canonical(axes[axis]))) else []
        return DesignPoint(index, axes, hashlib.sha256(canonical(identity).encode()).hexdigest())

    def values(self, index: int) -> dict[str, Any]:
        """The value of each axis that exists at one place of the enumeration."""
        if not 0 <= index < len(self):
            raise IndexError(f"no point {index} among {len(self)}")
        box = self.parts[bisect_right(self._begins, index) - 1]
        rest, numbers = index - box.begin, {}
        for axis, own in reversed(list(box.axes.items())):
            rest, place = divmod(rest, len(own))
            numbers[axis] = own[place]
        return {axis: self.axes[axis][numbers[axis]] for axis in box.axes}

    def index(self, values: Mapping[str, Any]) -> int:
        """The place of the point with these values, the inverse of ``values``.

        Raises:
            KeyError: there is no such point.
        """
        numbers = {axis: self._numbers[axis][value_text(value)] for axis, value in values.items()}
        for box in self.parts:
            if box.axes.keys() == numbers.keys() and all(numbers[axis] in own for axis, own in box.axes.items()):
                index = 0
                for axis, own in box.axes.items():
                    index = index * len(own) + own.index(numbers[axis])
                return box.begin + index
        raise KeyError(f"no point has {canonical(dict(values))}")

    def levels(self, indices: NDArray[np.int64]) -> dict[str, NDArray[np.int32]]:
        """The number of the value of each axis at some places of the enumeration, int32, by axis; -1: it has none."""
        levels = {axis: np.full(len(indices), -1, np.int32) for axis in self.axes}
        which = np.searchsorted(np.array(self._begins, np.int64), indices, side="right") - 1
        for number in np.unique(which):
            box, chosen = self.parts[number], np.flatnonzero(which == number)
            rest = indices[chosen] - box.begin
            for axis, own in reversed(list(box.axes.items())):
                rest, place = np.divmod(rest, len(own))
                levels[axis][chosen] = np.array(own, np.int32)[place]
        return levels


def canonical(value: Any) -> str:
    """JSON that is the same for equal values: keys sorted, no blanks, no NaN."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def group_limit(points: int, workers: int) -> int:
    """The greatest size of groups: about eight for each worker, so that all end at about the same time.

    >>> group_limit(24, 2), group_limit(1000, 2), group_limit(3, 8)
    (2, 16, 1)
    """
    return max(1, min(MAX_GROUP, math.ceil(points / (8 * max(1, workers)))))


@dataclass(frozen=True)
class Box:
    """Designs of a part of a space: of each axis there, the places from ``low`` to before ``high``.

    One that is ``excluded`` holds no design of the front, though not all of its designs were evaluated.

    - ``part``: the number of the part of the space (``Space.parts``).
    - ``bound``: by name, the least value over the box of each objective, or of the figure of a constraint (the greatest
      of one that is maximised); None where another reason excludes it. ``by``: the evaluated design that dominates the
      bound, strictly better in one objective; None: another reason.
    - ``why``: ``dominated``; ``fit``: no design of it fits, or too few starts arrive; ``clock``: the clock of all is
      above its limit; ``constraint NAME``: the bound breaks it; ``lacks NAME``: no design of it has this figure; or a
      sentence. Empty: nothing excludes it, and its designs are missing.
    """

    part: int
    low: tuple[int, ...]
    high: tuple[int, ...]
    bound: Mapping[str, float] | None = None
    by: int | None = None
    why: str = ""

    @property
    def designs(self) -> int:
        """The number of designs in the box."""
        return math.prod(high - low for low, high in zip(self.low, self.high, strict=True))

    def axes(self, decisions: Space) -> dict[str, tuple[Any, ...]]:
        """The values of each axis that exists in the box."""
        own = decisions.parts[self.part].axes
        return {
            axis: tuple(decisions.axes[axis][number] for number in numbers[low:high])
            for (axis, numbers), low, high in zip(own.items(), self.low, self.high, strict=True)
        }

    @property
    def row(self) -> list[Any]:
        """The box as JSON has it."""
        return [self.part, self.low, self.high, self.bound, self.by, self.why]

    @classmethod
    def of_row(cls, row: Any, decisions: Space) -> Box:
        """The box that ``row`` wrote.

        Raises:
            ValueError, TypeError, AttributeError: it is none of this space.
        """
        part, low, high, bound, by, why = row
        numbers = [part, *low, *high, *([] if by is None else [by])]
        if any(type(number) is not int for number in numbers) or not isinstance(why, str):
            raise TypeError("a box of what is no number")
        if not 0 <= part < len(decisions.parts) or not 0 <= (by or 0) < decisions.size:
            raise ValueError("a box outside the space")
        sizes = map(len, decisions.parts[part].axes.values())
        if any(not 0 <= one < other <= size for one, other, size in zip(low, high, sizes, strict=True)):
            raise ValueError("a box outside the space")
        values = None if bound is None else {str(name): float(value) for name, value in bound.items()}
        if values is not None and not all(map(math.isfinite, values.values())):
            raise ValueError("a bound that is no number")
        return cls(part, tuple(low), tuple(high), values, by, why)


class Sample(Space):
    """Some points of a space by their own numbers, 0 for the first of ``places``.

    ``places``: int64, the place of each in the enumeration of the whole space.

    >>> whole = Space({"relax.iterations": range(1000), "fpga.clock": ["100 MHz", "150 MHz"]}, "")
    >>> some = Sample(whole, np.array([7, 1999]))
    >>> len(some), some.values(1)
    (2, {'relax.iterations': 999, 'fpga.clock': '150 MHz'})
    """

    def __init__(self, whole: Space, places: NDArray[np.int64]) -> None:
        super().__init__(whole.axes, whole.fingerprint, whole.contents, whole.when)
        self.whole, self.places = whole, places
        self._rows = {place: number for number, place in enumerate(places.tolist())}

    @classmethod
    def of(cls, whole: Space, designs: Sequence[int], conditions: int = 1) -> Sample:
        """The points of designs, each in all conditions."""
        return cls(whole, points_of(designs, conditions))

    def __reduce__(self) -> tuple[type[Sample], tuple[Any, ...]]:
        return Sample, (self.whole, self.places)

    def __len__(self) -> int:
        return len(self.places)

    def values(self, index: int) -> dict[str, Any]:
        """The value of each axis that exists for a point."""
        if not 0 <= index < len(self):
            raise IndexError(f"no point {index} among {len(self)}")
        return self.whole.values(int(self.places[index]))

    def index(self, values: Mapping[str, Any]) -> int:
        """The number of the point with these values.

        Raises:
            KeyError: there is no such point, or it is none of these.
        """
        row = self._rows.get(self.whole.index(values))
        if row is None:
            raise KeyError(f"no point here has {canonical(dict(values))}")
        return row

    def levels(self, indices: NDArray[np.int64]) -> dict[str, NDArray[np.int32]]:
        """See ``Space.levels``."""
        return self.whole.levels(self.places[indices])


def points_of(designs: Sequence[int], conditions: int) -> NDArray[np.int64]:
    """The places of the points of designs, each in all conditions, in their order."""
    begins = np.array(designs, np.int64) * conditions
    return np.asarray((begins[:, None] + np.arange(conditions)).reshape(-1), np.int64)
