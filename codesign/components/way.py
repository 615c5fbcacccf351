"""A way: a polyline through the cells of a grid, the cells that it enters, and how far along it a robot may drive.

All lengths are in cells. A point is (row, column); a cell covers [row - 0.5, row + 0.5) × [column - 0.5, column + 0.5),
so its middle has whole coordinates, as in the trajectories of the planners. Outside of the grid is obstacle. A way that
passes from cell to cell through a corner needs both cells beside the corner, as a diagonal step of a planner does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.errors import InputError

Cell = tuple[int, int]
Point = tuple[float, float]

NEAR = 1e-6
"""Cells: points closer than this are taken as one. A robot also halts this far before a border it may not cross."""

SAME = 1e-9
"""Cells: what rounding makes of one point."""

STANDING_ROOM = 1e-3
"""Cells: an authority ends this far before the border of the first cell that is not known free."""

CANDIDATES = 32
"""Segments of a way to which ``join`` looks for an open connection, closest first."""


def cell_of(point: Sequence[float]) -> Cell:
    """The cell in which ``point`` lies.

    >>> cell_of((2.4, 2.5))
    (2, 3)
    """
    return math.floor(point[0] + 0.5), math.floor(point[1] + 0.5)


class Way:
    """A polyline. Points that repeat the one before, or lie so close to it that the arc length stays, are left out.

    Attributes:
        points: float64 n × 2, n ≥ 1, (row, column) in cells, read-only.
        arcs: float64 n, arc length at each point from the first, cells; rises strictly.

    Raises:
        InputError: not an n × 2 array of finite numbers with n ≥ 1.
    """

    def __init__(self, points: NDArray[np.float64] | Sequence[Sequence[float]]) -> None:
        array = np.array(points, np.float64)
        if array.ndim != 2 or array.shape[0] < 1 or array.shape[1] != 2 or not np.isfinite(array).all():
            raise InputError(
                f"a way of shape {array.shape}", "way", "give n × 2 finite numbers (row, column), n ≥ 1"
            )
        steps = np.sqrt((np.diff(array, axis=0) ** 2).sum(axis=1))
        arcs = np.concatenate((np.zeros(1), np.cumsum(steps)))
        rises = arcs[1:] > arcs[:-1]
        if not rises.all():
            kept = np.concatenate((np.ones(1, np.bool_), rises))
            array, arcs = array[kept], arcs[kept]
        self.points, self.arcs = array, arcs
        self.points.flags.writeable = self.arcs.flags.writeable = False

    @property
    def length(self) -> float:
        """Length of the whole way, cells."""
        return float(self.arcs[-1])

    @cached_property
    def headings(self) -> NDArray[np.float64]:
        """Direction of each segment, radians from that of growing columns towards that of growing rows."""
        moved = np.diff(self.points, axis=0)
        result: NDArray[np.float64] = np.arctan2(moved[:, 0], moved[:, 1])
        return result

    def segment_at(self, arc: float) -> int:
        """Index of the segment on which ``arc`` lies (at a vertex the later one); 0 where there is none."""
        index = int(self.arcs.searchsorted(arc, side="right")) - 1
        return min(max(index, 0), max(self.arcs.size - 2, 0))

    def point_at(self, arc: float) -> Point:
        """The point at ``arc``, which is first moved onto the way."""
        if self.arcs.size == 1 or arc <= 0.0:
            return float(self.points[0, 0]), float(self.points[0, 1])
        if arc >= self.arcs[-1]:
            return float(self.points[-1, 0]), float(self.points[-1, 1])
        index = self.segment_at(arc)
        begin, end = self.arcs[index], self.arcs[index + 1]
        share = (arc - begin) / (end - begin)
        (y0, x0), (y1, x1) = self.points[index], self.points[index + 1]
        return float(y0 + share * (y1 - y0)), float(x0 + share * (x1 - x0))

    @cached_property
    def crossings(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Arc length at which each cell is entered, and the cells: see ``way_kernels.crossings``."""
        from codesign.components import way_kernels

        entry, cells = way_kernels.crossings(self.points, self.arcs)
        return entry, cells

    def first_closed(
        self, grid: NDArray[np.bool_], first: int, last: int | None = None, *, is_open: bool = True
    ) -> int:
        """Index of the first crossing, from ``first`` to before ``last``, that is not open; -1 where all are.

        A cell is open where it has the value ``is_open`` in ``grid``, bool, rows × columns.
        """
        from codesign.components import way_kernels

        cells = self.crossings[1]
        return int(
            way_kernels.first_closed(cells, grid, is_open, first, len(cells) if last is None else last)
        )

    def head(self, length: float) -> Way:
        """The first ``length`` cells of the way, all of it where it is shorter."""
        if self.length <= length:
            return self
        kept = self.points[self.arcs < length]
        return Way(np.concatenate((kept, np.array([self.point_at(length)]))))

    def closest(self, position: Point) -> tuple[float, float]:
        """The arc length at the point of the way that is closest to ``position``, and how far off that is, cells.

        Of equally close points the last.
        """
        arcs, distances = self.feet(position)
        index = len(distances) - 1 - int(np.argmin(distances[::-1]))
        return float(arcs[index]), float(distances[index])

    def feet(self, position: Point) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Of each segment the arc length at the point closest to ``position``, and how far off that is, cells."""
        if self.arcs.size == 1:
            return self.arcs, np.array([_distance(self.points[0], position)])
        base, moved = self.points[:-1], np.diff(self.points, axis=0)
        share = np.clip((((position - base) * moved).sum(axis=1)) / (moved**2).sum(axis=1), 0.0, 1.0)
        feet = base + share[:, None] * moved
        distances = np.sqrt(((feet - position) ** 2).sum(axis=1))
        return self.arcs[:-1] + share * np.diff(self.arcs), distances

    def between(self, start: float, end: float) -> NDArray[np.float64]:
        """The points of the way from arc ``start`` to ``end``, both included: float64 n × 2, n ≥ 2."""
        inner = self.points[(self.arcs > start) & (self.arcs < end)]
        return np.concatenate((np.array([self.point_at(start)]), inner, np.array([self.point_at(end)])))

    def cut(self, start: float) -> Way:
        """What is left of the way from arc ``start`` on."""
        if start <= 0.0:
            return self
        later = self.arcs > start + SAME
        return Way(np.concatenate((np.array([self.point_at(start)]), self.points[later])))


def authority(
    way: Way, known_free: NDArray[np.bool_], *, start: float = 0.0, room: float = STANDING_ROOM
) -> float:
    """How far along ``way`` a robot at arc ``start`` may drive: the arc at which to stand, at least ``start``.

    That is the end of the way, or ``room`` before the border of the first cell that is not known free. The cell at
    ``start`` is the robot's own and always counts as free.

    Args:
        way: where to drive.
        known_free: bool, rows × columns: cells that are known to be free for the middle of the robot.
        start: arc length of the robot on it.
        room: cells left before the border.
    """
    entry, _ = way.crossings
    first = int(entry.searchsorted(start, side="right"))
    index = way.first_closed(known_free, first)
    end = way.length if index < 0 else float(entry[index]) - room
    return max(start, end)


def join(
    way: Way,
    position: Point,
    passable: NDArray[np.bool_] | None = None,
    *,
    lookahead: float = 1.0,
) -> Way:
    """The way of a robot that is at ``position`` and shall follow ``way``, which may have been planned from elsewhere.

    A robot on the way goes on along it. A robot beside it goes straight to the point of the way that lies
    ``lookahead`` past the closest one, or else to the closest from which no closed cell parts it.

    Args:
        way: what the planner answered.
        position: (row, column) in cells.
        passable: bool, rows × columns, open cells; None: all are.
        lookahead: cells; a robot that drives turns less the larger it is.
    """
    if way.arcs.size == 1:
        target = way.points[0]
        return way if _distance(target, position) <= NEAR else Way([position, target])
    arcs, distances = way.feet(position)
    # Of equally close points the latest: a way that comes by twice is not driven twice.
    order = np.lexsort((-arcs, distances))
    closest = int(order[0])
    off = float(distances[closest])
    if off <= NEAR:
        # A vertex so near ahead that the robot's being off the way would bend the way to it is passed over.
        return _from(way, position, float(arcs[closest]) + max(10.0 * off, SAME))
    ahead = _from(way, position, min(float(arcs[closest]) + lookahead, way.length), keep=True)
    if starts_clear(ahead, passable):
        return ahead
    for index in order[:CANDIDATES]:
        candidate = _from(way, position, float(arcs[index]), keep=True)
        if starts_clear(candidate, passable):
            return candidate
    return _from(way, position, float(arcs[closest]), keep=True)


def go_on(way: Way, position: Point, passable: NDArray[np.bool_]) -> Way:
    """The way of a robot that drives along ``way`` already and strayed a little from it: straight to its next vertex.

    Vertices that are nearer than ten times the distance to the way are passed over, as the way would bend there for
    nothing else than the robot's being beside it. Where a closed cell is between, the robot joins as a new one does.
    """
    arc, off = way.closest(position)
    straight = _from(way, position, arc + min(max(10.0 * off, SAME), 1.0))
    return straight if starts_clear(straight, passable) else join(way, position, passable)


def _from(way: Way, position: Point, arc: float, *, keep: bool = False) -> Way:
    """``position``, then (where ``keep``) the point at ``arc``, then the rest of the way."""
    later = way.points[way.arcs > arc]
    points = [np.array([position])]
    if keep:
        points.append(np.array([way.point_at(arc)]))
    return Way(np.concatenate((*points, later)))


def starts_clear(way: Way, passable: NDArray[np.bool_] | None) -> bool:
    """Whether the first segment of a way leads through open cells only. ``passable``: as for ``join``."""
    if passable is None:
        return True
    first = Way(way.points[:2])
    return first.first_closed(passable, 1) < 0


def _distance(one: Sequence[float] | NDArray[np.float64], other: Sequence[float]) -> float:
    return math.hypot(one[0] - other[0], one[1] - other[1])
