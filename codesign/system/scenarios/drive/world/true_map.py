"""The true map over time: what is free now, and what the robot's middle may not enter."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.components.path import Point, cell_of
from codesign.ground.errors import InputError, RunError, outside_map
from codesign.system.scenarios.drive.world.inflation import Inflation
from codesign.system.scenarios.drive.world.obstacles import Appearing, Cell, Moving, rectangle

Cells = NDArray[np.int64]
"""int64 n × 2, (row, column)."""

RETRY = 10**11
"""ps: assumed. An obstacle that the robot keeps out tries again after 100 ms."""

MARGIN = 0.5
"""Cells: assumed. Obstacles keep this far from the robot's body: nothing appears under or touching it."""

_NONE: Cells = np.zeros((0, 2), np.int64)

# What is due at one time happens in this order, and each kind in the order given: the same in every run.
_VANISH, _STEP, _APPEAR = range(3)


@dataclass(frozen=True)
class Deferral:
    """An obstacle that was kept out by the robot from ``time`` (ps) on: ``kind`` appearing or moving, ``index`` in the
    order given, ``until`` it came (ps); None: not yet, or never."""

    time: int
    kind: str
    index: int
    until: int | None = None


class World:
    """The true map. Outside of it is obstacle.

    The robot is never run over: what would come within its radius and ``margin``, or block the cell in which its
    middle is (see ``Inflation``), waits until it has left, and is recorded. Obstacles pass through walls and each
    other, and may cover a goal.

    Args:
        free: bool, rows × columns: the map without what appears and moves.
        appearing, moving: the obstacles. All of their cells lie in the map.
        radius_cells: of the robot.
        margin_cells: see ``MARGIN``.
        retry: ps after which a waiting obstacle tries again.

    Attributes:
        free_now: bool, rows × columns, read-only: what is free.
        blocked_for_robot: bool, rows × columns, read-only: cells that the robot's middle may not enter; see
            ``Inflation``. Both are views that change with ``advance``.
        deferrals: obstacles that had to wait.

    Raises:
        InputError: an obstacle outside of the map, or another argument out of bounds.
    """

    def __init__(
        self,
        free: NDArray[np.bool_],
        *,
        appearing: Sequence[Appearing] = (),
        moving: Sequence[Moving] = (),
        radius_cells: float = 0.0,
        margin_cells: float = MARGIN,
        retry: int = RETRY,
    ) -> None:
        if not (margin_cells >= 0.0 and retry >= 1):
            raise InputError(f"a margin of {margin_cells} cells, a retry after {retry} ps", "world", "≥ 0 and ≥ 1")
        self._count = (~free).astype(np.int32)
        self._free = free.copy()
        self._inflation = Inflation(~free, radius_cells)
        self.free_now, self.blocked_for_robot = self._free.view(), self._inflation.blocked.view()
        self.free_now.flags.writeable = self.blocked_for_robot.flags.writeable = False
        self._reach = radius_cells + margin_cells
        self._retry = retry
        self.appearing, self.moving = tuple(appearing), tuple(moving)
        self.deferrals: list[Deferral] = []
        self._waiting: dict[tuple[int, int], int] = {}
        self._there = [False] * len(self.appearing)
        self._where: list[Cell | None] = [None] * len(self.moving)
        self._routes: list[Iterator[tuple[Cell, int]]] = [obstacle.steps() for obstacle in self.moving]
        self._ahead: list[Cell] = [obstacle.route[0] for obstacle in self.moving]
        self._check_inside()
        self._due = [(obstacle.at, _APPEAR, index) for index, obstacle in enumerate(self.appearing)]
        self._due += [(obstacle.begin, _STEP, index) for index, obstacle in enumerate(self.moving)]
        heapq.heapify(self._due)

    def _check_inside(self) -> None:
        shape = self._free.shape
        for index, appearing in enumerate(self.appearing):
            _check_cells(appearing.cells, shape, f"appearing.{index}")
        for index, moving in enumerate(self.moving):
            rows, columns = moving.size
            for row, column in moving.route:
                ends = np.array([(row, column), (row + rows - 1, column + columns - 1)])
                _check_cells(ends, shape, f"moving.{index}")

    def next_change(self, now: int = 0) -> int | None:
        """The next time (ps), from ``now`` on, at which ``advance`` has something to do; None: never again."""
        return max(self._due[0][0], now) if self._due else None

    def advance(self, now: int, robot: Point | None) -> Cells:
        """Make the changes that are due at ``now``; the robot was advanced to ``now`` before.

        Args:
            now: ps. It must not lie past ``next_change``: where the robot was then is not known any more.
            robot: (row, column) of its middle, cells; None: there is none.

        Returns:
            The cells that are free now and were not, or the reverse: int64 n × 2, in raster order.

        Raises:
            RunError: a change was due before ``now``.
        """
        if self._due and self._due[0][0] < now:
            what = f"the world is advanced to {now} ps, but something was due at {self._due[0][0]} ps"
            raise RunError(what, "world", "advance it at every next_change")
        changes: list[Cells] = []
        while self._due and self._due[0][0] <= now:
            _, kind, index = heapq.heappop(self._due)
            if kind == _VANISH:
                changes.append(self._vanish(index))
            elif kind == _APPEAR:
                changes.append(self._appear(now, index, robot))
            else:
                changes.append(self._step(now, index, robot))
        changes = [cells for cells in changes if len(cells)]
        if len(changes) < 2:
            return changes[0] if changes else _NONE
        # A cell that changed twice at one time did not change.
        cells, times = np.unique(np.concatenate(changes), axis=0, return_counts=True)
        odd: Cells = cells[times % 2 == 1]
        return odd

    def _appear(self, now: int, index: int, robot: Point | None) -> Cells:
        obstacle = self.appearing[index]
        if obstacle.until is not None and now >= obstacle.until:
            return _NONE
        if not self._admits(obstacle.cells, robot):
            self._wait(now, _APPEAR, index)
            return _NONE
        self._came(now, _APPEAR, index)
        self._there[index] = True
        if obstacle.until is not None:
            heapq.heappush(self._due, (obstacle.until, _VANISH, index))
        return self._apply(obstacle.cells, _NONE)

    def _vanish(self, index: int) -> Cells:
        self._there[index] = False
        return self._apply(_NONE, self.appearing[index].cells)

    def _step(self, now: int, index: int, robot: Point | None) -> Cells:
        here, there = self._where[index], self._ahead[index]
        old = _NONE if here is None else rectangle(*here, *self.moving[index].size)
        new = rectangle(*there, *self.moving[index].size)
        if not self._admits(new, robot):
            self._wait(now, _STEP, index)
            return _NONE
        self._came(now, _STEP, index)
        self._where[index] = there
        following = next(self._routes[index], None)
        if following is not None:
            self._ahead[index], duration = following
            heapq.heappush(self._due, (now + duration, _STEP, index))
        return self._apply(new, old)

    def _wait(self, now: int, kind: int, index: int) -> None:
        if (kind, index) not in self._waiting:
            self._waiting[kind, index] = len(self.deferrals)
            self.deferrals.append(Deferral(now, "appearing" if kind == _APPEAR else "moving", index))
        heapq.heappush(self._due, (now + self._retry, kind, index))

    def _came(self, now: int, kind: int, index: int) -> None:
        position = self._waiting.pop((kind, index), None)
        if position is not None:
            waited = self.deferrals[position]
            self.deferrals[position] = Deferral(waited.time, waited.kind, waited.index, now)

    def _admits(self, cells: Cells, robot: Point | None) -> bool:
        """True if obstacles on ``cells`` leave the robot its place."""
        if robot is None:
            return True
        place = cell_of(robot)
        from_body = _gaps(cells, robot, 0.5)
        from_cell = _gaps(cells, place, 1.0)
        taken = (cells == place).all(axis=1)
        crowded = (from_body < self._reach) | (from_cell < self._inflation.radius) | taken
        return not bool(crowded.any())

    def _apply(self, come: Cells, leave: Cells) -> Cells:
        """Put obstacles on some cells and take them from others; the cells that changed."""
        touched = np.unique(np.concatenate((come, leave)), axis=0)
        rows, columns = touched[:, 0], touched[:, 1]
        before = self._free[rows, columns]
        self._count[come[:, 0], come[:, 1]] += 1
        self._count[leave[:, 0], leave[:, 1]] -= 1
        after = self._count[rows, columns] == 0
        self._free[rows, columns] = after
        self._inflation.change(touched[before & ~after], touched[after & ~before])
        changed: Cells = touched[before != after]
        return changed


def _gaps(cells: Cells, point: Sequence[float], between: float) -> NDArray[np.float64]:
    """Distance to the square of each cell from ``point`` (``between`` 0.5), or from the square around it (1), cells."""
    gap = np.maximum(np.abs(cells - np.array(point, np.float64)) - between, 0.0)
    result: NDArray[np.float64] = np.hypot(gap[:, 0], gap[:, 1])
    return result


def _check_cells(cells: Cells, shape: tuple[int, ...], name: str) -> None:
    for row, column in cells.tolist():
        if not (0 <= row < shape[0] and 0 <= column < shape[1]):
            what, hint = outside_map((row, column), shape, "obstacle cell")
            raise InputError(what, f"obstacles.{name}", hint)
