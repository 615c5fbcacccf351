"""Range sensors of a robot: the cells of the true map that they see from a position.

Cells and positions are as in ``components.path``. A sensor sees cells that are not inflated by the robot's radius. It
sees the full circle, so the robot's heading does not matter. With a range of 0 it sees nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.components import kernels
from codesign.components.path import NEAR, Point, cell_of
from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, Status

Cells = NDArray[np.int64]
"""int64 n × 2, (row, column), in raster order, each once."""

BITS_A_RAY = Figure(
    16, "bit", Status.ASSUMED, "a range in millimetres fits 16 bits, as most laser scanners send it", 8, 32
)
BITS_A_CELL = Figure(1, "bit", Status.ASSUMED, "a cell within range is sent as free or not free", 1, 8)

MAX_RADIUS = 500_000
"""Cells (assumed). The message of a larger disc would have more than 0.8 · 10¹² bits."""

STRAIGHT = 1e-12
"""A component of a unit vector below this is the rounding error of a 0."""

NOTHING_SEEN = (1 << int(BITS_A_RAY.value)) - 1
"""The word of a ray without an obstacle within range (assumed). Any other word is a range in millimetres."""


@dataclass(frozen=True, eq=False)
class RangeScan:
    """The cells that one scan saw: ``free`` and ``blocked``, int64 n × 2 each, in raster order."""

    free: Cells
    blocked: Cells

    @property
    def cells(self) -> int:
        """The number of cells that were seen."""
        return len(self.free) + len(self.blocked)

    def same_as(self, other: RangeScan) -> bool:
        """True if both scans saw the same cells."""
        return np.array_equal(self.free, other.free) and np.array_equal(self.blocked, other.blocked)


NOTHING = RangeScan(np.zeros((0, 2), np.int64), np.zeros((0, 2), np.int64))
"""A scan that saw nothing."""


@dataclass(frozen=True)
class RaySensor:
    """``rays`` rays at equal angles over the full circle, each ``range_cells`` long (a lidar, a ring of sonars).

    Each ray sees the cells that it passes, up to and including the first blocked one. It does not pass through a wall,
    nor between two blocked cells that touch at a corner.

    ``metres``: the side of a cell. It matters for damaged scans alone.

    Raises:
        InputError: a range below 0 or not finite, or no ray.
    """

    range_cells: float
    rays: int
    metres: float = 1.0

    def __post_init__(self) -> None:
        _check_range(self.range_cells)
        if self.rays < 1:
            raise InputError(f"{self.rays} rays", "sensor.rays", "give at least 1")

    @cached_property
    def directions(self) -> NDArray[np.float64]:
        """Unit vectors (row, column) of the rays, float64 ``rays`` × 2. The first points along growing columns."""
        angles = [2.0 * math.pi * ray / self.rays for ray in range(self.rays)]
        vectors = np.array([(math.sin(angle), math.cos(angle)) for angle in angles])
        # A ray along a border must not cross it because of the rounding of π.
        vectors[np.abs(vectors) < STRAIGHT] = 0.0
        return vectors

    @property
    def bits(self) -> int:
        """Size of the message that carries a scan, bits: the range along each ray (assumed, see ``BITS_A_RAY``)."""
        return self.rays * int(BITS_A_RAY.value)

    def scan(self, free: NDArray[np.bool_], position: Point) -> RangeScan:
        """The cells of ``free`` (bool, rows × columns) that the rays see from ``position``, inside the map.

        Raises:
            InputError: the position lies outside.
        """
        _check_inside(free, position)
        if self.range_cells == 0.0:
            return NOTHING
        y, x = position
        return RangeScan(*kernels.cast(free, y, x, self.range_cells, self.directions))

    def ranges(self, free: NDArray[np.bool_], position: Point) -> NDArray[np.float64]:
        """Cells along each ray to the first blocked cell, float64; infinite where it meets none within its length."""
        y, x = position
        return kernels.ranges(free, y, x, self.range_cells, self.directions)

    def misread(self, free: NDArray[np.bool_], position: Point, wrong: Sequence[int]) -> RangeScan:
        """The scan that is read where the bits ``wrong`` of its message are wrong.

        Each ray is a word, the lowest bit first: see ``NOTHING_SEEN``. The cells up to the range that is read count as
        free, and the cell at that range as blocked. A cell that one ray shows blocked is shown free by no other.
        """
        if self.range_cells == 0.0:
            return NOTHING
        width = int(BITS_A_RAY.value)
        masks: dict[int, int] = {}
        for bit in wrong:
            masks[bit // width] = masks.get(bit // width, 0) ^ (1 << bit % width)
        intact = np.ones(self.rays, np.bool_)
        intact[list(masks)] = False
        y, x = position
        undamaged = RangeScan(*kernels.cast(free, y, x, self.range_cells, self.directions[intact]))
        seen, blocked = [undamaged.free], [undamaged.blocked]
        for ray, mask in masks.items():
            word = self._word(free, position, ray) ^ mask
            misread = self._read(free.shape, position, ray, word)
            seen.append(misread.free)
            blocked.append(misread.blocked)
        closed = _as_set(np.concatenate(blocked))
        opened = _as_set(np.concatenate(seen)) - closed
        return RangeScan(_raster(opened), _raster(closed))

    def _word(self, free: NDArray[np.bool_], position: Point, ray: int) -> int:
        """The word of a ray: millimetres to the border of the first blocked cell.

        A ray from p along d enters the cell c at s = max over both axes of (c - sign(d) / 2 - p) / d.
        """
        direction = self.directions[ray : ray + 1]
        obstacles = kernels.cast(free, *position, self.range_cells, direction)[1]
        if not len(obstacles):
            return NOTHING_SEEN
        along = np.where(direction == 0.0, np.inf, direction)
        entries = ((obstacles - 0.5 * np.sign(direction) - position) / along).max(axis=1)
        measured = round(max(float(entries.min()), 0.0) * self.metres * 1000.0)
        return min(measured, NOTHING_SEEN - 1)

    def _read(self, shape: tuple[int, ...], position: Point, ray: int, word: int) -> RangeScan:
        cells = word / (1000.0 * self.metres)
        met = word != NOTHING_SEEN and cells <= self.range_cells
        reach = cells if met else self.range_cells
        direction = self.directions[ray]
        passed = kernels.cast(np.ones(shape, np.bool_), *position, reach, direction[None])[0]
        if not met:
            return RangeScan(passed, NOTHING.blocked)
        obstacle = np.array(cell_of(np.array(position) + (reach + NEAR) * direction), np.int64)
        inside = bool(((obstacle >= 0) & (obstacle < shape)).all())
        return RangeScan(passed[(passed != obstacle).any(axis=1)], obstacle[None] if inside else NOTHING.blocked)


@dataclass(frozen=True)
class RadiusSensor:
    """It sees every cell with its middle within ``range_cells``, through walls too (the known window of planners'
    papers).

    Raises:
        InputError: a range below 0, or above ``MAX_RADIUS``.
    """

    range_cells: float

    def __post_init__(self) -> None:
        _check_range(self.range_cells)
        if self.range_cells > MAX_RADIUS:
            what = f"a radius of {self.range_cells:.4g} cells, each of them sent at every scan"
            raise InputError(what, "sensor.range", f"at most {MAX_RADIUS:,} cells: a shorter range, or larger cells")

    @cached_property
    def bits(self) -> int:
        """Size of the message that carries a scan, bits: one a cell of the disc (assumed, see ``BITS_A_CELL``)."""
        # Row y of the disc has the integers x with x² ≤ r² - y². All of these are exact in a double.
        most = math.floor(self.range_cells * self.range_cells)
        rows = np.arange(-math.floor(self.range_cells), math.floor(self.range_cells) + 1)
        widths = 2 * np.floor(np.sqrt(most - rows * rows)).astype(np.int64) + 1
        return int(widths.sum()) * int(BITS_A_CELL.value)

    def scan(self, free: NDArray[np.bool_], position: Point) -> RangeScan:
        """The cells of ``free`` (bool, rows × columns) within range of ``position``, inside the map.

        Raises:
            InputError: the position lies outside.
        """
        _check_inside(free, position)
        if self.range_cells == 0.0:
            return NOTHING
        corner, within = _disc(position, self.range_cells, free.shape)
        window = free[corner[0] : corner[0] + within.shape[0], corner[1] : corner[1] + within.shape[1]]
        return RangeScan(np.argwhere(within & window) + corner, np.argwhere(within & ~window) + corner)

    def ranges(self, _free: NDArray[np.bool_], _position: Point) -> None:
        """It has no rays."""

    def misread(self, free: NDArray[np.bool_], position: Point, wrong: Sequence[int]) -> RangeScan:
        """The scan that is read where the bits ``wrong`` are wrong: each inverts its cell."""
        scan = self.scan(free, position)
        if self.range_cells == 0.0:
            return scan
        corner, within = _disc(position, self.range_cells, None)
        cells = np.argwhere(within) + corner
        inverted = _as_set(cells[[bit for bit in wrong if bit < len(cells)]])
        opened, closed = _as_set(scan.free), _as_set(scan.blocked)
        return RangeScan(
            _raster((opened - inverted) | (closed & inverted)), _raster((closed - inverted) | (opened & inverted))
        )


Sensor = RaySensor | RadiusSensor


def _disc(middle: Point, reach: float, shape: tuple[int, ...] | None) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The part of a disc that lies on a map of ``shape``: its first row and column, and the cells within, bool.

    A cell is within where (row - y)² + (column - x)² ≤ reach². Time and memory grow with the map and not with the disc.
    ``shape`` None: the whole disc.
    """
    spans = []
    for axis, at in enumerate(middle):
        first, last = math.ceil(at - reach), math.floor(at + reach)
        if shape is not None:
            first, last = max(first, 0), min(last, shape[axis] - 1)
        spans.append(np.arange(first, last + 1))
    rows, columns = spans
    within = (rows[:, None] - middle[0]) ** 2 + (columns - middle[1]) ** 2 <= reach * reach
    return np.array([span[0] if span.size else 0 for span in spans]), within


def _as_set(cells: Cells) -> set[tuple[int, int]]:
    return {(int(row), int(column)) for row, column in cells}


def _raster(cells: set[tuple[int, int]]) -> Cells:
    return np.array(sorted(cells), np.int64).reshape(-1, 2)


def _check_range(cells: float) -> None:
    if not (math.isfinite(cells) and cells >= 0.0):
        raise InputError(f"a range of {cells} cells", "sensor.range", "give 0 or more; 0 sees nothing")


def _check_inside(free: NDArray[np.bool_], position: Point) -> None:
    row, column = cell_of(position)
    if not (0 <= row < free.shape[0] and 0 <= column < free.shape[1]):
        raise InputError(f"a scan from {position}, outside of the map", "position", "keep the robot in the map")
