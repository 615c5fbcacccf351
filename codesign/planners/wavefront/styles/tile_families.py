"""Tiles of every shape in families, with lower bounds of their cycles.

Tiles of ``a`` × ``b`` cells cover a map of H × W cells as ``i`` × ``j`` = ceil(H / a) × ceil(W / b) tiles. The shapes
with the same i and j are a class: its smallest shape takes the least of every resource, as all that is counted in tiles
is alike. Classes stand in groups, by the powers of two of i and of j; groups with the same power of i in rows; and all
in one family, so that a part that is far too slow is left out in one step.

The bound of a shape is that of its visits (``bounds``) with its exchanges; the bound of a class is the least one of its
shapes. A group has a coarser one: each cell before the end of the wave is in a tile that is visited, and along the path
to the farthest of these cells the spans of the tiles cover all times. An exact run to the farthest start is a sharper
bound of a single shape. A wave to its own end takes at least the cycles of one to the starts, and as many resources but
for a register.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.planners.job import largest
from codesign.planners.styles import Family, Sides, side_classes
from codesign.planners.wavefront.plan.bounds import VisitBounds
from codesign.planners.wavefront.styles import timing
from codesign.planners.wavefront.styles.resources import Shape

PROMISING = 6
"""Shapes that stand before all families: of the widest that fit the part, those that seem the fastest."""

LONG = 12
"""The ratio of the sides of a tile whose bound is half as sharp as that of a square. Seen on rooms; it orders only."""
WIDEST = 3
"""Widths that are looked at, as block RAMs may run out before nodes do."""


class Frontier:
    """Whether a shape may fit, asked of few: a shape takes no less than one that lies in it."""

    def __init__(self, asked: Callable[[Shape], bool]) -> None:
        self._asked = asked
        self._fitting: list[Shape] = []
        self._unfit: list[Shape] = []

    def __call__(self, shape: Shape) -> bool:
        """The answer for a shape."""
        rows, columns = shape
        if any(rows <= other[0] and columns <= other[1] for other in self._fitting):
            return True
        if any(other[0] <= rows and other[1] <= columns for other in self._unfit):
            return False
        fits = self._asked(shape)
        (self._fitting if fits else self._unfit).append(shape)
        return fits


def fixed_cycles(map_shape: Shape, tile: Shape) -> tuple[int, int]:
    """Cycles to load the map and to scan its tiles; cycles of an exchange."""
    tiles = -(-map_shape[0] // tile[0]) * -(-map_shape[1] // tile[1])
    load = timing.tile_load_cycles(tile, tiles) + timing.scan_cycles(tile[1], tiles)
    return load, timing.exchange_cycles(tile, tiles)


@dataclass(eq=False)
class TileCycles:
    """The least cycles of tiles on a map, without the tracking of a path; the same on every part."""

    map_shape: Shape
    visits: VisitBounds
    _kept: dict[int, NDArray[np.int64]] = field(default_factory=dict)

    def of_height(self, height: int) -> NDArray[np.int64]:
        """The least cycles of the tiles of a height, int64, one entry for each width from 1 on."""
        if height not in self._kept:
            columns = self.map_shape[1]
            least = self.visits.visits(height, (1, columns))
            fixed = [fixed_cycles(self.map_shape, (height, width)) for width in range(1, columns + 1)]
            load, exchange = np.array(fixed, np.int64).T
            self._kept[height] = load + least[:, 0] * (exchange + 1) + least[:, 1]
        return self._kept[height]

    def of_shapes(self, rows: Sides, columns: Sides) -> int:
        """Cycles that no shape with these sides undercuts: the least of all their bounds."""
        heights = range(rows[0], rows[1] + 1)
        return min(int(self.of_height(height)[columns[0] - 1 : columns[1]].min()) for height in heights)

    def of_group(self, rows: Sides, columns: Sides) -> int:
        """Cycles that no shape with these sides undercuts."""
        down, across = -(-self.map_shape[0] // rows[1]), -(-self.map_shape[1] // columns[1])
        words = -(-self.map_shape[0] * self.map_shape[1] // timing.LOAD_CELLS)
        exchange = timing.exchange_cycles((rows[0], max(2, columns[0])), down * across)
        visits = -(-self.visits.cells // (rows[1] * columns[1]))
        return 1 + words + timing.scan_cycles(columns[0], down * across) + visits * (exchange + 1) + self.visits.latest


@dataclass(frozen=True, eq=False)
class TileSpace:
    """All shapes of tiles of a job, with each end of the wave.

    ``designs``: the other parameters by end, the earliest end first, the least demand last; ``bits``: of a register, at
    least. ``track``: cycles of the tracking. ``fits``: the least design of a shape fits the part; ``may_fit``: a shape
    of at least these sides may. ``run``: the cycles of the visits of a shape up to an end, given up beyond a number.
    """

    cycles: TileCycles
    designs: Sequence[Mapping[str, Any]]
    bits: int
    track: int
    fits: Callable[[Shape], bool]
    may_fit: Callable[[Shape], bool]
    run: Callable[[Shape, str, int], int]
    given: set[Shape] = field(default_factory=set)

    def promising(self) -> Iterator[Family]:
        """Of the widest tiles that fit, for each number of rows of tiles, those that seem the fastest, these first."""
        rows, columns = (side_classes(side) for side in self.cycles.map_shape)
        square = largest(range(1, max(self.cycles.map_shape) + 1), lambda side: self.may_fit((side, side))) or 1
        widest = []
        for least, _ in rows:
            index = bisect_left(columns, square * square // least + 1, key=lambda sides: sides[0])
            for width, _ in columns[max(0, index - WIDEST) : index]:
                ratio = max(least, width) / min(least, width)
                if ratio > LONG * max(self.cycles.map_shape) / min(self.cycles.map_shape):
                    continue
                cycles = int(self.cycles.of_height(least)[width - 1])
                widest.append((cycles * (1 + ratio / LONG), cycles, (least, width)))
        for _, cycles, tile in sorted(widest):
            if len(self.given) < PROMISING and self.fits(tile):
                self.given.add(tile)
                yield self._shape(tile, cycles)

    def families(self) -> Iterator[Family]:
        """All shapes but those of ``promising``, as one family; in it rows of groups, in these the groups."""
        rows, columns = (_octaves(side_classes(side), side) for side in self.cycles.map_shape)
        groups = [self.cycles.of_group(_whole(down), _whole(across)) for down in rows for across in columns]
        sides = [(1, side) for side in self.cycles.map_shape]
        whole = self._coarse(sides[0], sides[1], min(groups), partial(self._rows, rows, columns))
        if whole.count:
            yield whole

    def _rows(self, rows: Sequence[Sequence[Sides]], columns: Sequence[Sequence[Sides]]) -> Iterator[Family]:
        """The groups with as many rows of tiles in one, those with the least bound first; then what cannot fit."""
        found, unfit = [], []
        for down in rows:
            count = self._fitting(down[0][0], [across[0] for across in columns])
            groups = sorted((self.cycles.of_group(_whole(down), _whole(across)), across) for across in columns[:count])
            if groups:
                found.append((groups[0][0], down, groups))
            if count < len(columns):
                unfit.append(self._family(_whole(down), (columns[count][0][0], columns[-1][-1][1])))
        for least, down, groups in sorted(found):
            beyond = max(across[-1][1] for _, across in groups)
            yield self._coarse(_whole(down), (1, beyond), least, partial(self._groups, down, groups))
        yield from unfit

    def _groups(self, down: Sequence[Sides], groups: Sequence[tuple[int, Sequence[Sides]]]) -> Iterator[Family]:
        for least, across in groups:
            yield self._coarse(_whole(down), _whole(across), least, partial(self._shapes, down, across))

    def _coarse(self, rows: Sides, columns: Sides, cycles: int, parts: Callable[[], Iterator[Family]]) -> Family:
        """Several classes. Their smallest shape has the fastest clock; its columns have the deepest memories."""
        return replace(self._family(rows, columns, cycles, parts), clock_alone=True)

    def _shapes(self, rows: Sequence[Sides], columns: Sequence[Sides]) -> Iterator[Family]:
        """The shapes of these classes, by halves, the one with the least bound first; as one where none can fit."""
        if not self.may_fit((rows[0][0], columns[0][0])):
            yield self._family(_whole(rows), _whole(columns))
            return
        halves: list[tuple[Sequence[Sides], Sequence[Sides]]]
        if len(rows) == len(columns) == 1:
            halves = [([down], [across]) for down, across in _halved(rows[0], columns[0])]
        elif len(rows) >= len(columns):
            halves = [(rows[: len(rows) // 2], columns), (rows[len(rows) // 2 :], columns)]
        else:
            halves = [(rows, columns[: len(columns) // 2]), (rows, columns[len(columns) // 2 :])]
        bounds = (self.cycles.of_shapes(_whole(down), _whole(across)) for down, across in halves)
        for least, index in sorted((least, index) for index, least in enumerate(bounds)):
            yield from self._half(least, *halves[index])

    def _half(self, least: int, rows: Sequence[Sides], columns: Sequence[Sides]) -> Iterator[Family]:
        """Some shapes as one family. In a class larger ones take no less of anything."""
        (top, bottom), (left, right) = sides = _whole(rows), _whole(columns)
        parts = partial(self._shapes, rows, columns)
        if len(rows) > 1 or len(columns) > 1:
            yield self._coarse(*sides, least, parts)
        elif top < bottom or left < right:
            yield self._family(*sides, least, parts)
        elif (top, left) not in self.given:
            yield self._shape((top, left), least)

    def _fitting(self, height: int, across: Sequence[Sides]) -> int:
        """The number of columns that may fit: behind the first that cannot, none can."""
        return bisect_left(across, True, key=lambda columns: not self.may_fit((height, columns[0])))

    def _family(
        self,
        rows: Sides,
        columns: Sides,
        cycles: int | None = None,
        parts: Callable[[], Iterator[Family]] | None = None,
    ) -> Family:
        """A class or a group; of what cannot fit, its smallest shape stands for all."""
        least = self._least((rows[0], columns[0]))
        bound = self.cycles.of_group(rows, columns) if cycles is None else cycles
        inside = sum(rows[0] <= tile[0] <= rows[1] and columns[0] <= tile[1] <= columns[1] for tile in self.given)
        count = len(self.designs) * ((rows[1] - rows[0] + 1) * (columns[1] - columns[0] + 1) - inside)
        ranges = {"tile rows": rows, "tile columns": columns}
        chain = () if parts else ({**self.designs[-1], "tile": [rows[0], columns[0]]},)
        return Family(chain, {"": bound + self.track}, ranges, count, least, parts=parts)

    def _shape(self, tile: Shape, cycles: int, end: int = 0) -> Family:
        """One shape: its exact run is sharper than any bound. ``end``: this and the later ends of the wave."""
        fixed = fixed_cycles(self.cycles.map_shape, tile)[0] + self.track
        ranges = {"tile rows": (tile[0], tile[0]), "tile columns": (tile[1], tile[1])}
        design = self.designs[end]

        def sharper(limit: int) -> Mapping[str, int]:
            return {"": fixed + self.run(tile, design["stop"], limit - fixed)}

        def later() -> Iterator[Family]:
            yield self._shape(tile, cycles, end + 1)

        left = len(self.designs) - end
        units, chain = {"": cycles + self.track}, ({**design, "tile": list(tile)},)
        return Family(chain, units, ranges, left, self._least(tile), sharper, later if left > 1 else None)

    def _least(self, tile: Shape) -> dict[str, Any]:
        return {**self.designs[-1], "tile": list(tile), "register_bits": self.bits}


def _whole(classes: Sequence[Sides]) -> Sides:
    return classes[0][0], classes[-1][1]


def _halved(rows: Sides, columns: Sides) -> list[tuple[Sides, Sides]]:
    """The shapes of a class in two parts, along the side with more of them; a single one as it is."""
    middle = [sum(sides) // 2 for sides in (rows, columns)]
    if rows[0] == rows[1] and columns[0] == columns[1]:
        return [(rows, columns)]
    if rows[1] - rows[0] >= columns[1] - columns[0]:
        return [((rows[0], middle[0]), columns), ((middle[0] + 1, rows[1]), columns)]
    return [(rows, (columns[0], middle[1])), (rows, (middle[1] + 1, columns[1]))]


def _octaves(classes: Sequence[Sides], cells: int) -> list[list[Sides]]:
    """Classes by the power of two of their number of tiles."""
    return list(map_reduce(classes, lambda sides: (-(-cells // sides[0])).bit_length()).values())
