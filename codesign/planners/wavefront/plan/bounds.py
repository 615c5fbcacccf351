"""Lower bounds of the visits of tiles, for tiles of all shapes, from the potentials of the map.

Be p* the potential at which the wave ends. Potentials are written p, and a tile's window is the tile with the cells
around it.

1. A tile whose window holds a p below p* is visited. For the change of that cell makes the visit pending, or the cell
   is a source in the tile, and pending changes below p* are followed.
2. Its first visit is pending for the least p of its window, f: changes come in order of time, and the least is final.
   So each of its visits begins at f.
3. After its last visit no change below p* is pending: that visit had every p below p* of the window, so it ended at the
   greatest of them, g, or later. Its span is g - f or more.
4. Be m the least p, below p*, of the cells of a tile beside that lie in the window. A visit of the tile beside, at its
   own f' or later, sets it; then this tile is visited, at m or earlier. So it has a visit between f' and m for each of
   the eight tiles beside. The fewest times that meet all these intervals are a lower bound of its visits. They belong
   to intervals without a time in common, and a visit ends after the change that it was pending for: f' - f or more.
5. While visits are followed in the order of time, each interval that no visit of its tile has met has one to come. So
   they are given up as soon as what they took so far and what is sure to come are too much (``sure``).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.planners.wavefront.plan.tiles import NEVER

kernels = late("codesign.planners.wavefront.plan.bound_kernels")


@dataclass(eq=False)
class VisitBounds:
    """The least visits of a map, of tiles of any shape; computed height by height.

    ``potentials``: of the wave on the whole map, int32, negative where there is none. ``until``: p*. ``cells``: with a
    potential before it; ``latest``: the greatest of them.
    """

    potentials: NDArray[np.int32]
    until: int = NEVER
    _kept: dict[int, NDArray[np.int64]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        before = np.where((self.potentials >= 0) & (self.potentials < self.until), self.potentials, np.int32(-1))
        self.potentials = np.where(self.potentials < 0, np.int32(NEVER), self.potentials)
        begin, end = _around(self.potentials, NEVER, np.minimum), _around(before, -1, np.maximum)
        self._least = _doubled(np.stack([self.potentials, begin, -end]))
        self.cells, self.latest = int((before >= 0).sum()), max(0, int(before.max()))

    def visits(self, height: int, widths: tuple[int, int]) -> NDArray[np.int64]:
        """At least so many visits, and so long spans in all: int64 n × 2, for each width from the first to the last."""
        if height not in self._kept:
            table, least = self._rows(height)
            self._kept[height] = kernels.least_visits(self.potentials, table, least, self.until, height)
        return self._kept[height][widths[0] - 1 : widths[1]]

    def sure(self, tile: tuple[int, int]) -> NDArray[np.int64]:
        """These visits of one shape, one by one: int64 n × 4, the tile, the interval of its change, the span."""
        table, least = self._rows(tile[0])
        return np.asarray(kernels.sure_visits(self.potentials, table, least, self.until, tile))

    def _rows(self, height: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """``table`` and ``least`` as the kernel takes them."""
        tops = np.arange(0, self.potentials.shape[0], height)
        bottoms = np.append(tops[1:], self.potentials.shape[0]) - 1
        level = height.bit_length() - 1
        # Two windows of 2^level rows cover those of a tile; the last tile may have fewer.
        windows = self._least[level]
        least, first, last = np.minimum(windows[:, tops], windows[:, np.maximum(tops, bottoms + 1 - (1 << level))])
        columns = self.potentials.shape[1]
        table = np.empty((columns.bit_length(), 4, *least.shape), np.int32)
        table[0] = first, last, self.potentials[tops], self.potentials[bottoms]
        for level in range(1, len(table)):
            half, used = 1 << (level - 1), columns + 1 - (1 << level)
            np.minimum(
                table[level - 1, ..., :used], table[level - 1, ..., half : half + used], out=table[level, ..., :used]
            )
        return table, least


def _around(values: NDArray[np.int32], outside: int, least: np.ufunc) -> NDArray[np.int32]:
    """The least (or greatest) of each cell and its eight neighbours."""
    padded = np.pad(values, 1, constant_values=outside)
    across = least(least(padded[:, :-2], padded[:, 1:-1]), padded[:, 2:])
    return np.asarray(least(least(across[:-2], across[1:-1]), across[2:]))


def _doubled(values: NDArray[np.int32]) -> list[NDArray[np.int32]]:
    """The least of 1, 2, 4 ... rows from each row on, as far as there are rows: int32, n × rows × columns each."""
    tables = [values]
    while (reach := 1 << len(tables) - 1) < values.shape[1]:
        wider = tables[-1].copy()
        np.minimum(wider[:, :-reach], wider[:, reach:], out=wider[:, :-reach])
        tables.append(wider)
    return tables
