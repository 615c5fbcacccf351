"""Range sensors of a robot: what they see of the true map from where it stands.

Cells and positions as in ``components.way``. A sensor sees cells, not inflated by the robot's radius. It is a full
circle, so the robot's heading does not matter. A range of 0 sees nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.components.way import NEAR, Point, cell_of
from codesign.errors import InputError
from codesign.figures import Figure, Status

Cells = NDArray[np.int64]
"""int64 n × 2, (row, column), in raster order, each once."""

BITS_A_RAY = Figure(
    16, "bit", Status.ASSUMED, "a range in millimetres fits 16 bits, as most laser scanners send it", 8, 32
)
BITS_A_CELL = Figure(1, "bit", Status.ASSUMED, "a cell within range is sent as free or not free", 1, 8)

MAX_RADIUS = 500_000
"""Cells: assumed. The scan of a larger disc would be a message of more than 0.8 · 10¹² bits."""

CORNER = 1e-9
"""Cells: a ray that comes so near to where four cells meet goes through the corner itself."""


STRAIGHT = 1e-12
"""A component of a unit vector below this is the rounding of a 0."""

NOTHING_SEEN = (1 << int(BITS_A_RAY.value)) - 1
"""The word of a ray that met no obstacle within range: assumed. Any other is a range in millimetres."""


@dataclass(frozen=True, eq=False)
class Scan:
    """What was seen at once: ``free`` cells and ``blocked`` cells, int64 n × 2 each, in raster order."""

    free: Cells
    blocked: Cells

    @property
    def cells(self) -> int:
        """How many cells were seen."""
        return len(self.free) + len(self.blocked)

    def same_as(self, other: Scan) -> bool:
        """Whether both saw the same."""
        return np.array_equal(self.free, other.free) and np.array_equal(self.blocked, other.blocked)


NOTHING = Scan(np.zeros((0, 2), np.int64), np.zeros((0, 2), np.int64))
"""A scan that saw nothing."""


@dataclass(frozen=True)
class RaySensor:
    """``rays`` rays in equal angles all around, each ``range_cells`` long (a lidar, a ring of sonars).

    Each sees the cells that it passes, up to and including the first blocked one. It never sees through a wall, and not
    between two blocked cells that touch at a corner only.

    ``metres``: a cell; only what is read of damaged scans depends on it.

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
        """Unit vectors (row, column) of the rays, float64 ``rays`` × 2; the first along growing columns."""
        angles = [2.0 * math.pi * ray / self.rays for ray in range(self.rays)]
        vectors = np.array([(math.sin(angle), math.cos(angle)) for angle in angles])
        # Straight is straight: a ray along a border must not drift over it by the rounding of π.
        vectors[np.abs(vectors) < STRAIGHT] = 0.0
        return vectors

    @property
    def bits(self) -> int:
        """Size of the message that carries a scan, bits: the range along each ray (assumed, see ``BITS_A_RAY``)."""
        return self.rays * int(BITS_A_RAY.value)

    def scan(self, free: NDArray[np.bool_], position: Point) -> Scan:
        """What the rays see of ``free`` (bool, rows × columns) from ``position``, which must lie inside the map.

        Raises:
            InputError: the position lies outside.
        """
        _check_inside(free, position)
        if self.range_cells == 0.0:
            return NOTHING
        from codesign.components import sensor_kernels

        y, x = position
        return Scan(*sensor_kernels.cast(free, y, x, self.range_cells, self.directions))

    def misread(self, free: NDArray[np.bool_], position: Point, wrong: Sequence[int]) -> Scan:
        """What is read of that scan where these bits of its message are wrong.

        Each ray is a word, the lowest bit first: see ``NOTHING_SEEN``. The cells up to the range that is read count as
        free, and the one there as blocked; what one ray shows blocked, no other shows free.
        """
        if self.range_cells == 0.0:
            return NOTHING
        from codesign.components import sensor_kernels

        width = int(BITS_A_RAY.value)
        masks: dict[int, int] = {}
        for bit in wrong:
            masks[bit // width] = masks.get(bit // width, 0) ^ (1 << bit % width)
        right = np.ones(self.rays, np.bool_)
        right[list(masks)] = False
        y, x = position
        sound = Scan(*sensor_kernels.cast(free, y, x, self.range_cells, self.directions[right]))
        seen, blocked = [sound.free], [sound.blocked]
        for ray, mask in masks.items():
            read = self._word(free, position, ray) ^ mask
            some = self._read(free.shape, position, ray, read)
            seen.append(some.free)
            blocked.append(some.blocked)
        closed = {(int(row), int(column)) for row, column in np.concatenate(blocked)}
        opened = {(int(row), int(column)) for row, column in np.concatenate(seen)} - closed
        return Scan(_raster(opened), _raster(closed))

    def _word(self, free: NDArray[np.bool_], position: Point, ray: int) -> int:
        """What the ray measures: millimetres to the border of the first blocked cell."""
        from codesign.components import sensor_kernels

        direction = self.directions[ray : ray + 1]
        met = sensor_kernels.cast(free, *position, self.range_cells, direction)[1]
        if not len(met):
            return NOTHING_SEEN
        along = np.where(direction == 0.0, np.inf, direction)
        entries = ((met - 0.5 * np.sign(direction) - position) / along).max(axis=1)
        measured = round(max(float(entries.min()), 0.0) * self.metres * 1000.0)
        return min(measured, NOTHING_SEEN - 1)

    def _read(self, shape: tuple[int, ...], position: Point, ray: int, word: int) -> Scan:
        """The cells along a ray of which ``word`` was read."""
        from codesign.components import sensor_kernels

        cells = word / (1000.0 * self.metres)
        met = word != NOTHING_SEEN and cells <= self.range_cells
        reach = cells if met else self.range_cells
        direction = self.directions[ray]
        passed = sensor_kernels.cast(np.ones(shape, np.bool_), *position, reach, direction[None])[0]
        if not met:
            return Scan(passed, NOTHING.blocked)
        there = np.array(cell_of(np.array(position) + (reach + NEAR) * direction), np.int64)
        inside = bool(((there >= 0) & (there < shape)).all())
        return Scan(passed[(passed != there).any(axis=1)], there[None] if inside else NOTHING.blocked)


@dataclass(frozen=True)
class RadiusSensor:
    """It knows every cell whose middle lies within ``range_cells``, walls or not (a known window, as planners' papers
    have it).

    Raises:
        InputError: a range below 0, or above ``MAX_RADIUS``.
    """

    range_cells: float

    def __post_init__(self) -> None:
        _check_range(self.range_cells)
        if self.range_cells > MAX_RADIUS:
            what = f"a radius of {self.range_cells:.4g} cells, each of them sent at every scan"
            raise InputError(
                what, "sensor.range", f"at most {MAX_RADIUS:,} cells: a shorter range, or larger cells"
            )

    @cached_property
    def bits(self) -> int:
        """Size of the message that carries a scan, bits: one a cell of the disc (assumed, see ``BITS_A_CELL``)."""
        # Row y of the disc holds the whole x with x² ≤ r² - y². All of these are exact in a double.
        most = math.floor(self.range_cells * self.range_cells)
        rows = np.arange(-math.floor(self.range_cells), math.floor(self.range_cells) + 1)
        widths = 2 * np.floor(np.sqrt(most - rows * rows)).astype(np.int64) + 1
        return int(widths.sum()) * int(BITS_A_CELL.value)

    def scan(self, free: NDArray[np.bool_], position: Point) -> Scan:
        """The cells of ``free`` (bool, rows × columns) within range of ``position``, which must lie inside the map.

        Raises:
            InputError: the position lies outside.
        """
        _check_inside(free, position)
        if self.range_cells == 0.0:
            return NOTHING
        corner, within = _disc(position, self.range_cells, free.shape)
        window = free[corner[0] : corner[0] + within.shape[0], corner[1] : corner[1] + within.shape[1]]
        return Scan(np.argwhere(within & window) + corner, np.argwhere(within & ~window) + corner)

    def misread(self, free: NDArray[np.bool_], position: Point, wrong: Sequence[int]) -> Scan:
        """What is read of that scan where these bits of its message are wrong: each says the contrary of its cell."""
        scan = self.scan(free, position)
        if self.range_cells == 0.0:
            return scan
        corner, within = _disc(position, self.range_cells, None)
        cells = np.argwhere(within) + corner
        turned = {
            (int(row), int(column)) for row, column in cells[[bit for bit in wrong if bit < len(cells)]]
        }
        opened, closed = (
            {(int(row), int(column)) for row, column in some} for some in (scan.free, scan.blocked)
        )
        return Scan(
            _raster((opened - turned) | (closed & turned)), _raster((closed - turned) | (opened & turned))
        )


Sensor = RaySensor | RadiusSensor


def _disc(
    middle: Point, reach: float, shape: tuple[int, ...] | None
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The part of a disc that lies on a map of ``shape``: its first row and column, and the cells within, bool.

    A cell is within where (row - y)² + (column - x)² ≤ reach². Time and memory grow with the map, not with the disc.
    With None for ``shape`` it is the whole disc, and they grow with that.
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


def _raster(cells: set[tuple[int, int]]) -> Cells:
    return np.array(sorted(cells), np.int64).reshape(-1, 2)


def _check_range(cells: float) -> None:
    if not (math.isfinite(cells) and cells >= 0.0):
        raise InputError(f"a range of {cells} cells", "sensor.range", "give 0 or more; 0 sees nothing")


def _check_inside(free: NDArray[np.bool_], position: Point) -> None:
    row, column = cell_of(position)
    if not (0 <= row < free.shape[0] and 0 <= column < free.shape[1]):
        raise InputError(
            f"a scan from {position}, outside of the map", "position", "keep the robot in the map"
        )


def cast_reference(
    free: NDArray[np.bool_], position: Point, reach: float, directions: NDArray[np.float64]
) -> Scan:
    """What ``sensor_kernels.cast`` returns, in a few plain lines."""
    seen_free: set[tuple[int, int]] = set()
    seen_blocked: set[tuple[int, int]] = set()

    def inside(cell: tuple[int, int]) -> bool:
        return cell[0] in range(free.shape[0]) and cell[1] in range(free.shape[1])

    for down, along in directions.tolist():
        row, column = cell_of(position)
        row_step, column_step = (1 if down > 0 else -1), (1 if along > 0 else -1)
        while inside((row, column)):
            if not free[row, column]:
                seen_blocked.add((row, column))
                break
            seen_free.add((row, column))
            to_row = (row + 0.5 * row_step - position[0]) / down if down else math.inf
            to_column = (column + 0.5 * column_step - position[1]) / along if along else math.inf
            if min(to_row, to_column) > reach:
                break
            corner = abs(to_row - to_column) <= CORNER
            beside = [(row + row_step, column), (row, column + column_step)]
            if corner and not any(inside(cell) and bool(free[cell]) for cell in beside):
                seen_blocked.update(cell for cell in beside if inside(cell))
                break
            row += row_step if corner or to_row < to_column else 0
            column += column_step if corner or to_row >= to_column else 0
    shape = (-1, 2)
    return Scan(
        np.array(sorted(seen_free), np.int64).reshape(shape),
        np.array(sorted(seen_blocked), np.int64).reshape(shape),
    )
