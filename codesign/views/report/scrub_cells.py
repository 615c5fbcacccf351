"""The cells of a run over time: a grid at the begin, and what becomes of each cell at what time.

A map with a side of more than ``LARGEST_SIDE`` cells is made of tiles. A tile is blocked where any cell of it is.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.records import BeliefRecord, MapRecord, ObstacleRecord, RobotRecord
from codesign.study.groups import Groups

LARGEST_SIDE = 800
MOST_CHANGES = 400_000
_BINS = 4096

FREE, UNKNOWN, BLOCKED = 0, 1, 2
"""The belief of the robot about a tile, as the script of the page takes it."""

NOW_BLOCKED, NOW_FREE, NOW_UNKNOWN, BELIEVED_FREE, BELIEVED_BLOCKED = range(5)
"""The fate of a cell: of the true map, or of the belief of the robot."""

_BELIEF = {FREE: BELIEVED_FREE, UNKNOWN: NOW_UNKNOWN, BLOCKED: BELIEVED_BLOCKED}


@dataclass(frozen=True)
class Changes:
    """Cells that changed, in the order of time: when (ps, int64), which (int64, row by row), and into what (uint8)."""

    times: NDArray[np.int64]
    cells: NDArray[np.int64]
    kinds: NDArray[np.uint8]

    def coarsened(self, end: int) -> Changes:
        """The same, where there are too many: of the changes of a cell in a short span only the last one."""
        if len(self.times) <= MOST_CHANGES:
            return self
        spans = self.times * _BINS // max(end, 1)
        of_belief = self.kinds >= NOW_UNKNOWN
        # The last of each is the first of the reversed.
        lasts = Groups.of(spans[::-1], of_belief[::-1], self.cells[::-1]).firsts
        kept = np.sort(len(spans) - 1 - lasts)
        return Changes(self.times[kept], self.cells[kept], self.kinds[kept])


@dataclass
class Cells:
    """The true map, and the belief of the robot, in tiles of ``tile`` × ``tile`` cells.

    ``free``: bool, rows × columns, at the begin. ``believed``: uint8, the same shape, or None without a belief.
    """

    start: MapRecord
    tile: int = field(init=False)
    free: NDArray[np.bool_] = field(init=False)
    believed: NDArray[np.uint8] | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self.tile = max(1, -(-max(self.start.free.shape) // LARGEST_SIDE))
        self._free, self._known = self.start.free.copy(), np.full(self.start.free.shape, UNKNOWN, np.uint8)
        self.free = self._tiles(~self._free) == 0
        self._parts: list[tuple[int, NDArray[np.int64], NDArray[np.uint8]]] = []

    def begin(self, robot: RobotRecord) -> None:
        """The map that the robot has at the begin: without what is hidden from it, or nothing."""
        if robot.knows:
            self._known = np.where(self.start.free, FREE, BLOCKED).astype(np.uint8)
            if self.start.unknown is not None and self.start.unknown.shape == self._known.shape:
                self._known[self.start.unknown] = UNKNOWN
            hidden = self._inside(robot.hidden)[0]
            self._known[hidden[:, 0], hidden[:, 1]] = FREE
        self.believed = self._tiles(self._known)

    def changed(self, record: ObstacleRecord) -> None:
        """Cells of the true map became blocked, or free."""
        cells, _ = self._inside(record.cells)
        self._free[cells[:, 0], cells[:, 1]] = not record.appeared
        self._note(record.time, cells, ~self._free, {0: NOW_FREE, 1: NOW_BLOCKED})

    def learnt(self, record: BeliefRecord) -> None:
        """The robot saw cells."""
        if self.believed is None:
            self.believed = self._tiles(self._known)
        cells, kept = self._inside(record.cells)
        self._known[cells[:, 0], cells[:, 1]] = np.where(record.blocked[kept], BLOCKED, FREE)
        self._note(record.time, cells, self._known, _BELIEF)

    @property
    def changes(self) -> Changes:
        """All changes, in the order of time."""
        parts = sorted(self._parts, key=lambda part: part[0])
        if not parts:
            return Changes(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.uint8))
        times = np.repeat(np.array([part[0] for part in parts], np.int64), [len(part[1]) for part in parts])
        return Changes(times, np.concatenate([part[1] for part in parts]), np.concatenate([part[2] for part in parts]))

    def _inside(self, cells: NDArray[np.int32]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """The cells in rows and columns of the arrays, without those outside; and which of them were kept."""
        here = cells.reshape(-1, 2).astype(np.int64) - np.array(self.start.corner)
        kept: NDArray[np.bool_] = ((here >= 0) & (here < self._free.shape)).all(axis=1)
        return here[kept], kept

    def _note(self, time: int, cells: NDArray[np.int64], grid: NDArray[Any], kinds: dict[int, int]) -> None:
        """Keep what became of these cells; of tiles the greatest value of their cells."""
        if not len(cells):
            return
        tiles = np.unique(cells // self.tile, axis=0) if self.tile > 1 else cells
        steps = range(self.tile)
        values = np.zeros(len(tiles), np.int64)
        for down in steps:
            for across in steps:
                row, column = (tiles * self.tile + (down, across)).T
                is_in = (row < grid.shape[0]) & (column < grid.shape[1])
                values[is_in] = np.maximum(values[is_in], grid[row[is_in], column[is_in]])
        codes = np.array([kinds.get(value, 0) for value in range(max(kinds) + 1)], np.uint8)
        self._parts.append((time, tiles[:, 0] * self.free.shape[1] + tiles[:, 1], codes[values]))

    def _tiles(self, grid: NDArray[Any]) -> NDArray[np.uint8]:
        """The greatest value in each tile."""
        down, across = (np.arange(0, side, self.tile) for side in grid.shape)
        if not grid.size:
            return np.zeros((len(down), len(across)), np.uint8)
        most = np.maximum.reduceat(np.maximum.reduceat(grid.astype(np.uint8), down, axis=0), across, axis=1)
        return most.astype(np.uint8)
