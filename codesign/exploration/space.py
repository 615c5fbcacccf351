"""The points of an exploration, in file order, and how they are handed out to workers."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
    """Every combination of the values of the axes.

    Args:
        axes: the values of each axis by name (``relax.block``, ``fpga.clock``), in file order. No axis: one
            point.
        fingerprint: names all that a result depends on besides the axes and what they stand for; part of every key.
        contents: by axis and ``canonical`` text of a value, a digest of what the value stands for: a variant, a
            platform, a map in a file. It is part of the keys of its points alone, so that one more, or a change in one,
            leaves the points of the others where they are.

    >>> space = Space({"relax.iterations": [1, 6], "fpga.clock": ["100 MHz", "150 MHz"]}, "")
    >>> len(space), space.point(1).axes
    (4, {'relax.iterations': 1, 'fpga.clock': '150 MHz'})
    """

    def __init__(
        self, axes: Mapping[str, Sequence[Any]], fingerprint: str, contents: Contents | None = None
    ) -> None:
        self.axes: Mapping[str, tuple[Any, ...]] = MappingProxyType(
            {name: tuple(values) for name, values in axes.items()}
        )
        self.fingerprint = fingerprint
        self.contents: Contents = MappingProxyType(dict(contents or {}))

    def __len__(self) -> int:
        return math.prod(len(values) for values in self.axes.values())

    def points(self) -> Iterator[DesignPoint]:
        """Every point, by index."""
        for index, values in enumerate(itertools.product(*self.axes.values())):
            yield self._point(index, values)

    def point(self, index: int) -> DesignPoint:
        """The point at one place of the enumeration, 0 ≤ ``index`` < ``len``."""
        if not 0 <= index < len(self):
            raise IndexError(f"no point {index} among {len(self)}")
        rest, chosen = index, []
        for values in reversed(tuple(self.axes.values())):
            rest, place = divmod(rest, len(values))
            chosen.append(values[place])
        return self._point(index, tuple(reversed(chosen)))

    def values(self, index: int) -> dict[str, Any]:
        """The value of each axis at one place of the enumeration."""
        levels = self.levels(np.array([index], np.int64))
        return {axis: self.axes[axis][int(column[0])] for axis, column in levels.items()}

    def levels(self, indices: NDArray[np.int64]) -> dict[str, NDArray[np.int32]]:
        """The number of the value of each axis at some places of the enumeration, int32, by axis."""
        if not self.axes:
            return {}
        counts = tuple(len(values) for values in self.axes.values())
        columns = np.unravel_index(indices, counts)
        return {axis: column.astype(np.int32) for axis, column in zip(self.axes, columns, strict=True)}

    def _point(self, index: int, values: tuple[Any, ...]) -> DesignPoint:
        axes = dict(zip(self.axes, values, strict=True))
        identity = [self.fingerprint, axes]
        for axis, digests in self.contents.items():
            identity += [digest] if axis in axes and (digest := digests.get(canonical(axes[axis]))) else []
        return DesignPoint(index, axes, hashlib.sha256(canonical(identity).encode()).hexdigest())


def canonical(value: Any) -> str:
    """JSON that is the same for equal values: keys sorted, no blanks, no NaN."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def group(
    points: Sequence[DesignPoint],
    *,
    cheap: Collection[str],
    related: Collection[str] = (),
    limit: int = MAX_GROUP,
) -> list[tuple[DesignPoint, ...]]:
    """Groups of points that one worker had better compute in a row, because they share work.

    Points that differ in ``cheap`` axes alone (part, clock) repeat one functional simulation: the worker's
    memo makes all but the first nearly free, so they are parted only where there are more than ``limit`` of
    them. Points that differ in ``related`` axes too (precision schedule) may share stages, and stay
    together while ``limit`` allows.

    Returns:
        Groups of at most ``limit`` points, which together hold each point once; ordered by their first
        point, so that results come in about in the order of enumeration. Nothing depends on the number of
        workers but ``limit``.
    """
    families: dict[str, dict[str, list[DesignPoint]]] = {}
    for point in points:
        family = canonical(
            {name: v for name, v in point.axes.items() if name not in cheap and name not in related}
        )
        same = canonical({name: v for name, v in point.axes.items() if name not in cheap})
        families.setdefault(family, {}).setdefault(same, []).append(point)
    groups: list[tuple[DesignPoint, ...]] = []
    for runs in families.values():
        groups.extend(_pack(runs.values(), limit))
    return sorted(groups, key=lambda members: members[0].index)


def _pack(runs: Collection[list[DesignPoint]], limit: int) -> Iterator[tuple[DesignPoint, ...]]:
    """Whole runs put together up to ``limit`` points; a run longer than that is cut."""
    filling: list[DesignPoint] = []
    for run in runs:
        if filling and len(filling) + len(run) > limit:
            yield tuple(filling)
            filling = []
        filling = [*filling, *run]
        while len(filling) > limit:
            yield tuple(filling[:limit])
            filling = filling[limit:]
    if filling:
        yield tuple(filling)


def group_limit(points: int, workers: int) -> int:
    """How large groups may be: about eight for each worker, so that all end at about the same time.

    >>> group_limit(24, 2), group_limit(1000, 2), group_limit(3, 8)
    (2, 16, 1)
    """
    return max(1, min(MAX_GROUP, math.ceil(points / (8 * max(1, workers)))))
