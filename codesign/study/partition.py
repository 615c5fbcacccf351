"""The points of a space, parted into those that compute the same, and those that are simulated each by itself.

Some axes move only what a component or link costs: part and clock of an FPGA, the clock of a bus, the costs of a
processor. Points that differ in these alone compute the same. All other axes move what is computed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.errors import CodesignError
from codesign.ground.numbering import Numbering, distinct
from codesign.inputs import Platform
from codesign.inputs.edit import PLATFORM_AXIS, Movable, design_point
from codesign.inputs.hardware import Hardware
from codesign.study.explored import Explored
from codesign.study.order import Order
from codesign.study.pricing.machines import Specs
from codesign.study.space import MAX_GROUP, DesignPoint, Space, canonical, group_limit

Indices = NDArray[np.int64]
_MOST = 2**62
_DENSE = 4
"""Up to so many numbers a row, a table of all of them is faster than sorting the rows."""

Affinity = tuple[int, ...]
"""The numbers of the values that works which share most of their work have in common."""


@dataclass(frozen=True)
class Alone:
    """Points that are simulated each by itself."""

    points: tuple[DesignPoint, ...]
    affinity: ClassVar[None] = None

    @property
    def indices(self) -> tuple[int, ...]:
        """Their places in the enumeration."""
        return tuple(point.index for point in self.points)

    @property
    def numbers(self) -> Indices:
        """The same as an array, int64."""
        return np.array(self.indices, np.int64)

    def __len__(self) -> int:
        return len(self.points)

    def points_of(self, _space: Space) -> Iterator[DesignPoint]:
        """The points, in order."""
        return iter(self.points)


@dataclass(frozen=True, eq=False)
class Together:
    """Points that compute the same.

    - ``numbers``: their places in the enumeration, int64, rising. ``axes``: the values of the first one.
    - ``specs``: the components and links of each.
    - ``key``: SHA-256 over all that their outcomes depend on.
    - ``affinity``: equal for works that share most of what they compute, so that one worker had better compute them all
      (``TaskParameters.shared_across``); None where it is not known.
    """

    numbers: Indices
    axes: dict[str, Any]
    specs: Specs
    key: str
    affinity: Affinity | None = None

    @property
    def indices(self) -> tuple[int, ...]:
        """Their places in the enumeration."""
        return tuple(self.numbers.tolist())

    def __len__(self) -> int:
        return len(self.numbers)

    def points_of(self, space: Space) -> Iterator[DesignPoint]:
        """The points, in order."""
        return map(space.point, self.indices)


Work = Alone | Together
"""The work that one worker computes in a row."""


def apart(space: Space, work: Work, workers: int) -> list[Alone]:
    """The points of work, to be simulated each by itself: enough works that all workers end at about the same time.

    Points that one worker simulates in a row share what they have in common.
    """
    points = tuple(work.points_of(space))
    limit = group_limit(len(points), workers)
    return [Alone(points[begin : begin + limit]) for begin in range(0, len(points), limit)]


class Turns:
    """The turns of points: an order that shows the whole space early, and does a design before the next one.

    Args:
        decisions: the space of the designs, whose turns are the turns of ``Order``.
        conditions: how many each design meets.
    """

    def __init__(self, decisions: Space, conditions: int) -> None:
        self._conditions = conditions
        self._designs = np.empty(len(decisions), np.int64)
        self._designs[Order.of(decisions).indices(0, len(decisions))] = np.arange(len(decisions))

    def of(self, points: Indices) -> Indices:
        """The turn of each point."""
        return self._designs[points // self._conditions] * self._conditions + points % self._conditions

    def first(self, points: Indices, count: int) -> Indices:
        """The points that have their turns first, by index."""
        return np.sort(points[np.argsort(self.of(points))[:count]])

    def sorted(self, works: Iterable[Work]) -> list[Work]:
        """The works by the first turn of any of their points."""
        return sorted(works, key=lambda work: int(self.of(work.numbers).min()))


def parted(explored: Explored, space: Space, pending: Indices) -> Iterator[Work]:
    """The pending points as work, in about the order of their first points."""
    levels = space.levels(pending)
    platforms = levels.get(PLATFORM_AXIS)
    if platforms is None:
        yield from Parting(explored, space, explored.platforms[""], pending, levels).works()
        return
    for number in np.unique(platforms):
        chosen = platforms == number
        platform = explored.platforms[space.axes[PLATFORM_AXIS][number]]
        own = {axis: column[chosen] for axis, column in levels.items()}
        yield from Parting(explored, space, platform, pending[chosen], own).works()


@dataclass(frozen=True, eq=False)
class Parting:
    """The points of one platform. ``levels``: the number of the value of each axis, one entry a point; -1: none."""

    explored: Explored
    space: Space
    platform: Platform
    points: Indices
    levels: Mapping[str, NDArray[np.int32]]

    @cached_property
    def priced(self) -> dict[str, list[str]]:
        """The axes that move prices, by component or link."""
        owner = {axis: str(self._movable.path(axis)[1]) for axis in self.levels if self._is_of_hardware(axis)}
        moving = (axis for axis, name in owner.items() if axis.split(".")[1] in self._models[name].prices())
        return dict(map_reduce(moving, owner.__getitem__))

    @cached_property
    def _movable(self) -> Movable:
        return Movable.of(self.platform, self.explored.workload.document)

    def _is_of_hardware(self, axis: str) -> bool:
        """True if an axis moves a component or a link."""
        section = self._movable.section(axis.partition(".")[0])
        return axis != PLATFORM_AXIS and section in ("components", "links")

    @cached_property
    def _models(self) -> Mapping[str, Hardware]:
        return {**self.platform.components, **self.platform.links}

    def works(self) -> Iterator[Work]:
        """The points as work."""
        moved = {axis for axes in self.priced.values() for axis in axes}
        count = len(self.points)
        which = {name: np.zeros(count, np.intp) for name in self._models}
        models: dict[str, tuple[Hardware, ...]] = {name: (model,) for name, model in self._models.items()}
        sound = np.ones(count, bool)
        shapes: list[NDArray[np.int32]] = []
        parts: list[NDArray[np.int32]] = []
        for name, axes in self.priced.items():
            numbers = _grouped([self.levels[axis] for axis in axes], count)
            firsts = np.zeros(numbers.max(initial=-1) + 1, np.intp)
            firsts[numbers[::-1]] = np.arange(count - 1, -1, -1)
            combinations = zip(*(self.levels[axis][firsts].tolist() for axis in axes), strict=True)
            each = [self.model(name, dict(zip(axes, row, strict=True))) for row in combinations]
            shape = _shapes(each)
            models[name] = tuple(self._models[name] if model is None else model for model in each)
            which[name] = numbers
            sound &= np.array([model is not None for model in each])[which[name]]
            shapes.append(shape[which[name]])
            parts += [self.levels[axis] for axis in axes if axis.endswith(".part")]
        computed = [column for axis, column in self.levels.items() if axis not in moved]
        group = _grouped([*computed, *shapes], count)
        part = _grouped(parts, count)
        wired = [column for axis, column in self.levels.items() if axis not in moved and self._is_of_hardware(axis)]
        wiring = _grouped([*wired, *shapes], count)
        yield from self._by_group(group, sound, models, which, part, wiring)

    def model(self, name: str, levels: Mapping[str, int]) -> Hardware | None:
        """A component or link with values of its own axes; None where it refuses them."""
        values = {axis: self.space.axes[axis][level] for axis, level in levels.items() if level >= 0}
        try:
            platform = design_point(self.platform, self.explored.workload, values)[0]
        except CodesignError:
            return None
        model: Hardware = {**platform.components, **platform.links}[name]
        return model

    def _by_group(
        self,
        group: NDArray[np.intp],
        sound: NDArray[np.bool_],
        models: Mapping[str, tuple[Hardware, ...]],
        which: Mapping[str, NDArray[np.intp]],
        part: NDArray[np.intp],
        wiring: NDArray[np.intp],
    ) -> Iterator[Work]:
        alone = np.flatnonzero(~sound)
        own = group[sound]
        # NumPy sorts numbers of 16 bits by counting.
        order = np.argsort(own.astype(np.uint16) if own.max(initial=0) < 2**16 else own, kind="stable")
        # In that order the points of a group are neighbours: it is cut where the group changes.
        places = np.flatnonzero(sound)[order]
        edges = np.flatnonzero(np.diff(group[places])) + 1
        groups = np.split(places, edges) if len(places) else []
        affinity = self._affinity_axes()
        for members in (own for group in groups for own in self._by_part(group, part)):
            own_models = {name: numbers[members] for name, numbers in which.items()}
            specs = Specs(models, own_models, len(members), int(wiring[members[0]]))
            axes = self.space.values(int(self.points[members[0]]))
            own_affinity = None if affinity is None else tuple(int(self.levels[axis][members[0]]) for axis in affinity)
            key = key_of(self.space, {axis: column[members] for axis, column in self.levels.items()})
            yield Together(self.points[members], axes, specs, key, own_affinity)
        for begin in range(0, len(alone), MAX_GROUP):
            some = self.points[alone[begin : begin + MAX_GROUP]].tolist()
            yield Alone(tuple(map(self.space.point, some)))

    def _by_part(self, members: NDArray[np.intp], part: NDArray[np.intp]) -> list[NDArray[np.intp]]:
        """The points of a group; apart by part where a parameter is left to a search, as its value may depend on it."""
        own = part[members]
        if (own == own[0]).all():
            return [members]
        named = tuple(int(self.levels[axis][members[0]]) for axis in self._in_words)
        if named not in self._searched:
            self._searched[named] = self._is_searched(int(self.points[members[0]]))
        return [members[own == number] for number in np.unique(own)] if self._searched[named] else [members]

    @cached_property
    def _searched(self) -> dict[tuple[int, ...], bool]:
        return {}

    @cached_property
    def _in_words(self) -> list[str]:
        """The axes that may leave a parameter to a search: those with values that are no numbers."""
        rest = (axis for axis in self.levels if not self._is_of_hardware(axis))
        return [axis for axis in rest if not all(map(_is_number, self.space.axes[axis]))]

    def _is_searched(self, point: int) -> bool:
        """True if a point leaves a parameter to a search."""
        try:
            mapping = self.explored.point(self.space.values(point))[1].mapping
        except CodesignError:
            return False
        return any(each.parameters.to_find for each in mapping.values())

    def _affinity_axes(self) -> list[str] | None:
        """The axes that move what works share; None where no axis leaves it."""
        moved = {axis for axes in self.priced.values() for axis in axes}
        rest = [axis for axis in self.levels if axis not in moved]
        own = [axis for axis in rest if not self._movable.is_shared_across(axis)]
        return None if own == rest else own


def key_of(space: Space, levels: Mapping[str, NDArray[np.int32]]) -> str:
    """SHA-256 over the axes of points and what their values stand for. ``levels``: see ``Parting``."""
    values: dict[str, Any] = {}
    digest = hashlib.sha256(space.fingerprint.encode())
    for axis, column in levels.items():
        # The levels that are met, and each point's number among them: how many levels up to its own are met, less 1.
        own = column + 1
        met = np.bincount(own) > 0
        used, numbers = np.flatnonzero(met) - 1, np.cumsum(met)[own] - 1
        texts = [canonical(space.axes[axis][level]) if level >= 0 else "" for level in used.tolist()]
        contents = space.contents.get(axis, {})
        values[axis] = [[text, contents.get(text, "")] for text in texts]
        digest.update(numbers.astype(np.int32).tobytes())
    digest.update(canonical(values).encode())
    return digest.hexdigest()


def _is_number(value: Any) -> bool:
    """True for a number, and for a list of numbers."""
    return all(map(_is_number, value)) if isinstance(value, list | tuple) else isinstance(value, int | float)


def _shapes(models: Sequence[Hardware | None]) -> NDArray[np.int32]:
    """A number for each kind of model: models of one kind differ in prices alone."""
    kinds = Numbering[str]()
    return np.array([kinds[("" if model is None else canonical(model.shape()))] for model in models], np.int32)


def _grouped(columns: Sequence[NDArray[np.int32]], count: int) -> NDArray[np.intp]:
    """A number for each different row of the columns, in the order of the first rows."""
    if not columns:
        return np.zeros(count, np.intp)
    # A row is one number in mixed radix: rows · width + (column + 1), of size the product of the widths. Where that
    # would pass 64 bits, the numbers met so far are renumbered densely.
    rows, size = np.zeros(count, np.int64), 1
    for column in columns:
        width = int(column.max(initial=0)) + 2
        if size * width > _MOST:
            used, rows = distinct(rows)
            size = len(used)
        rows, size = rows * width + (column + 1), size * width
    if size > _DENSE * count:
        used, rows = distinct(rows)
        size = len(used)
    # Without sorting: of several assignments to one place the last one counts, which is that of the first row.
    first = np.full(size, count, np.int64)
    first[rows[::-1]] = np.arange(count - 1, -1, -1)
    met = np.flatnonzero(first < count)
    rank = np.empty(size, np.intp)
    rank[met[np.argsort(first[met])]] = np.arange(len(met))
    return rank[rows]
