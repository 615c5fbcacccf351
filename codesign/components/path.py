"""A path is a polyline through the cells of a grid. Here: the cells that it enters, and how far a robot may drive it.

All lengths are in cells. A point is (row, column). A cell covers [row - 0.5, row + 0.5) × [column - 0.5, column + 0.5),
so its middle has whole coordinates, as in the trajectories of the planners. Outside of the grid all is blocked. A path
that passes through a corner of cells needs both cells beside the corner, as a diagonal step of a planner does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.components import kernels
from codesign.ground.errors import InputError

Cell = tuple[int, int]
Point = tuple[float, float]

NEAR = 1e-6
"""Cells: points closer than this count as one. A robot stops this far before a border that it may not cross."""

SAME = 1e-9
"""Cells: the rounding error of a point."""

STANDING_ROOM = 1e-3
"""Cells: an authority ends this far before the border of the first cell that is not known to be free."""

CANDIDATES = 32
"""Segments of a path that ``join`` tries to connect to, closest first."""


def cell_of(point: Sequence[float]) -> Cell:
    """The cell in which ``point`` lies.

    >>> cell_of((2.4, 2.5))
    (2, 3)
    """
    return math.floor(point[0] + 0.5), math.floor(point[1] + 0.5)


class Polyline:
    """A polyline. A point is left out where it does not increase the arc length, as a repeated point.

    Attributes:
        points: float64 n × 2, n ≥ 1, (row, column) in cells, read-only.
        arcs: float64 n, arc length at each point from the first, cells; strictly increasing.

    Raises:
        InputError: not an n × 2 array of finite numbers with n ≥ 1.
    """

    def __init__(self, points: NDArray[np.float64] | Sequence[Sequence[float]]) -> None:
        array = np.array(points, np.float64)
        if array.ndim != 2 or array.shape[0] < 1 or array.shape[1] != 2 or not np.isfinite(array).all():
            raise InputError(f"a path of shape {array.shape}", "path", "give n × 2 finite numbers (row, column), n ≥ 1")
        moved = array[1:] - array[:-1]
        arcs = np.zeros(len(array))
        np.sqrt(moved[:, 0] ** 2 + moved[:, 1] ** 2).cumsum(out=arcs[1:])
        rises = arcs[1:] > arcs[:-1]
        if not rises.all():
            kept = np.concatenate((np.ones(1, np.bool_), rises))
            array, arcs = array[kept], arcs[kept]
        self.points, self.arcs = array, arcs
        self.points.flags.writeable = self.arcs.flags.writeable = False

    @property
    def length(self) -> float:
        """Length of the whole path, cells."""
        return float(self.arcs[-1])

    @cached_property
    def segments(self) -> NDArray[np.float64]:
        """From each point to the next: float64 2 × (n - 1), rows and columns, cells."""
        return np.ascontiguousarray((self.points[1:] - self.points[:-1]).T)

    @cached_property
    def headings(self) -> NDArray[np.float64]:
        """Direction of each segment, radians from the direction of growing columns towards growing rows."""
        result: NDArray[np.float64] = np.arctan2(*self.segments)
        return result

    def segment_at(self, arc: float) -> int:
        """Index of the segment that ``arc`` lies on (at a vertex the later one); 0 for a path of one point."""
        index = int(self.arcs.searchsorted(arc, side="right")) - 1
        return min(max(index, 0), max(self.arcs.size - 2, 0))

    def point_at(self, arc: float) -> Point:
        """The point at ``arc``, clipped to the path."""
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
        """Arc length at which each cell is entered, and the cells: see ``kernels.crossings``."""
        entry, cells = kernels.crossings(self.points, self.arcs)
        return entry, cells

    def first_closed(
        self, grid: NDArray[np.bool_], first: int, last: int | None = None, *, is_open: bool = True
    ) -> int:
        """Index of the first crossing, from ``first`` to before ``last``, that is not open; -1 where all are.

        A cell is open where it has the value ``is_open`` in ``grid``, bool, rows × columns.
        """
        cells = self.crossings[1]
        return int(kernels.first_closed(cells, grid, is_open, first, len(cells) if last is None else last))

    def head(self, length: float) -> Polyline:
        """The first ``length`` cells of the path, or all of it where it is shorter."""
        if self.length <= length:
            return self
        kept = self.points[self.arcs < length]
        return Polyline(np.concatenate((kept, np.array([self.point_at(length)]))))

    def closest(self, position: Point) -> tuple[float, float]:
        """The arc length at the point of the path that is closest to ``position``, and its distance, cells.

        Of equally close points the last is taken.
        """
        arcs, distances = self.feet(position)
        index = len(distances) - 1 - int(np.argmin(distances[::-1]))
        return float(arcs[index]), float(distances[index])

    def feet(self, position: Point) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """For each segment: the arc length at the point closest to ``position``, and its distance, cells.

        On the segment from a to a + d the closest point to p is a + s d, with s = (p - a)·d / d·d clipped to 0..1.
        """
        if self.arcs.size == 1:
            return self.arcs, np.array([_distance(self.points[0], position)])
        (rows, columns), (down, right) = self.points[:-1].T, self.segments
        share = (position[0] - rows) * down + (position[1] - columns) * right
        share /= down**2 + right**2
        share = np.minimum(np.maximum(share, 0.0), 1.0)
        distances = np.sqrt((rows + share * down - position[0]) ** 2 + (columns + share * right - position[1]) ** 2)
        return self.arcs[:-1] + share * (self.arcs[1:] - self.arcs[:-1]), distances

    def between(self, start: float, end: float) -> NDArray[np.float64]:
        """The points of the path from arc ``start`` to ``end``, both included: float64 n × 2, n ≥ 2."""
        inner = self.points[(self.arcs > start) & (self.arcs < end)]
        return np.concatenate((np.array([self.point_at(start)]), inner, np.array([self.point_at(end)])))

    def cut(self, start: float) -> Polyline:
        """The rest of the path, from arc ``start``."""
        if start <= 0.0:
            return self
        later = self.arcs > start + SAME
        return Polyline(np.concatenate((np.array([self.point_at(start)]), self.points[later])))


def authority(
    path: Polyline, known_free: NDArray[np.bool_], *, start: float = 0.0, room: float = STANDING_ROOM
) -> float:
    """The arc to which a robot at arc ``start`` may drive along ``path``, at least ``start``.

    This is the end of the path, or ``room`` before the border of the first cell that is not known to be free. The cell
    at ``start`` is the robot's own and always counts as free.

    Args:
        path: the path to drive.
        known_free: bool, rows × columns: cells that are known to be free for the middle of the robot.
        start: arc length of the robot on the path.
        room: distance to leave before the border, cells.
    """
    entry, _ = path.crossings
    first = int(entry.searchsorted(start, side="right"))
    index = path.first_closed(known_free, first)
    end = path.length if index < 0 else float(entry[index]) - room
    return max(start, end)


def join(
    path: Polyline, position: Point, passable: NDArray[np.bool_] | None = None, *, lookahead: float = 1.0
) -> Polyline:
    """The path from ``position`` onto ``path``, which may have been planned from another position.

    A robot on the path continues along it. A robot beside it drives straight to the point of the path that lies
    ``lookahead`` past the closest one. Where a closed cell is between, it drives to the closest point without one.

    Args:
        path: the path of the plan.
        position: (row, column) in cells.
        passable: bool, rows × columns, open cells; None: all cells are open.
        lookahead: cells. The larger it is, the less a driving robot turns.
    """
    if path.arcs.size == 1:
        target = path.points[0]
        return path if _distance(target, position) <= NEAR else Polyline([position, target])
    arcs, distances = path.feet(position)
    # Of equally close points the latest, so that a loop of the path is not driven twice.
    order = np.lexsort((-arcs, distances))
    closest = int(order[0])
    off = float(distances[closest])
    if off <= NEAR:
        # A vertex is skipped where it is so near that the offset of the robot would bend the path there.
        return _from(path, position, float(arcs[closest]) + max(10.0 * off, SAME))
    ahead = _from(path, position, min(float(arcs[closest]) + lookahead, path.length), keep=True)
    if starts_clear(ahead, passable):
        return ahead
    for index in order[:CANDIDATES]:
        candidate = _from(path, position, float(arcs[index]), keep=True)
        if starts_clear(candidate, passable):
            return candidate
    return _from(path, position, float(arcs[closest]), keep=True)


def continue_along(path: Polyline, position: Point, passable: NDArray[np.bool_]) -> Polyline:
    """The path of a robot that already drives along ``path`` and is a little beside it: straight to the next vertex.

    Vertices nearer than ten times the distance to the path are skipped: the path would bend there only because of the
    robot's offset. Where a closed cell is between, the robot uses ``join``.
    """
    arc, off = path.closest(position)
    straight = _from(path, position, arc + min(max(10.0 * off, SAME), 1.0))
    return straight if starts_clear(straight, passable) else join(path, position, passable)


def _from(path: Polyline, position: Point, arc: float, *, keep: bool = False) -> Polyline:
    """``position``, then the point at ``arc`` (with ``keep``), then the rest of the path."""
    later = path.points[path.arcs > arc]
    points = [np.array([position])]
    if keep:
        points.append(np.array([path.point_at(arc)]))
    return Polyline(np.concatenate((*points, later)))


def starts_clear(path: Polyline, passable: NDArray[np.bool_] | None) -> bool:
    """True if the first segment of a path enters open cells only. ``passable``: as for ``join``."""
    if passable is None:
        return True
    first = Polyline(path.points[:2])
    return first.first_closed(passable, 1) < 0


def _distance(point: Sequence[float] | NDArray[np.float64], other: Sequence[float]) -> float:
    return math.hypot(point[0] - other[0], point[1] - other[1])
