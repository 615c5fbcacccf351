"""Compiled walks over exact fields. The module is imported on first use, so that importing the planner stays light.

Fields are uint64 rows × columns × limbs, least significant limb first; outside of the map is 0. Values are compared and
subtracted limb by limb, so every choice is exact at any precision. Doubles would see neighbours that differ in the
200th bit as equal.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Neighbours in the order in which ties are broken: north, east, south, west.
ROW_STEP = (-1, 0, 1, 0)
COLUMN_STEP = (0, 1, 0, -1)

GOAL, OBSTACLE, FLAT, STEPS = 0, 1, 2, 3
FIRST_POINTS = 256


@njit(cache=True, nogil=True)
def _greater(limbs: Any, row: int, column: int, other_row: int, other_column: int) -> Any:
    # Most significant limb first, as the circuit compares: most significant bit first (section 3.2.1).
    for k in range(limbs.shape[2] - 1, -1, -1):
        here, there = limbs[row, column, k], limbs[other_row, other_column, k]
        if here != there:
            return here > there
    return False


@njit(cache=True, nogil=True)
def best_neighbours(limbs: NDArray[np.uint64], free: NDArray[np.bool_]) -> Any:
    """Int8 rows × columns: the greatest strictly greater neighbour, 0..3 = N, E, S, W; -1 where none.

    The first in that order among equals. -1 on obstacles.
    """
    rows, columns = free.shape
    best = np.full((rows, columns), np.int8(-1))
    for row in range(rows):
        for column in range(columns):
            if not free[row, column]:
                continue
            best_row, best_column = row, column
            for side in range(4):
                r, c = row + ROW_STEP[side], column + COLUMN_STEP[side]
                inside = 0 <= r < rows and 0 <= c < columns
                if inside and _greater(limbs, r, c, best_row, best_column):
                    best_row, best_column = r, c
                    best[row, column] = side
    return best


@njit(cache=True, nogil=True)
def _difference(limbs: Any, row: int, column: int, side: int, out: Any) -> Any:
    """Write |h' - h| for the neighbour h' of h at ``side``; the sign of h' - h is returned."""
    rows, columns, count = limbs.shape
    # Always the larger less the smaller: a subtraction that borrows from limb to limb and never ends below 0.
    r, c = row + ROW_STEP[side], column + COLUMN_STEP[side]
    inside = 0 <= r < rows and 0 <= c < columns
    rises = inside and _greater(limbs, r, c, row, column)
    zero = np.uint64(0)
    borrow = zero
    for k in range(count):
        here = limbs[row, column, k]
        there = limbs[r, c, k] if inside else zero
        larger, smaller = (there, here) if rises else (here, there)
        partial = larger - smaller
        out[k] = partial - borrow
        borrow = np.uint64(larger < smaller) | np.uint64(partial < borrow)
    return 1 if rises else -1


@njit(cache=True, nogil=True)
def _exceeds(first: Any, second: Any) -> Any:
    for k in range(first.size - 1, -1, -1):
        if first[k] != second[k]:
            return first[k] > second[k]
    return False


@njit(cache=True, nogil=True)
def _top_limb(first: Any, second: Any) -> Any:
    for k in range(first.size - 1, 0, -1):
        if first[k] | second[k]:
            return k
    return 0


@njit(cache=True, nogil=True)
def _mantissa(value: Any, top: int) -> Any:
    """The two limbs up to ``top`` as a double: at least 65 leading bits of the larger of two values."""
    result = np.float64(value[top]) * 18446744073709551616.0
    return result + np.float64(value[top - 1]) if top > 0 else result


@njit(cache=True, nogil=True)
def choose_side(limbs: Any, row: int, column: int, axis: int, chosen: Any, other: Any, only_ascending: bool) -> Any:
    """The side (north or south for axis 0, else east or west) of the greater |h' - h|, and the sign of h' - h.

    ``chosen`` gets |h' - h|; ``other`` is overwritten. Ties go to north and to east.
    """
    first, second = (0, 2) if axis == 0 else (1, 3)
    sign = _difference(limbs, row, column, first, chosen)
    other_sign = _difference(limbs, row, column, second, other)
    if only_ascending and sign < 0:
        chosen[:] = np.uint64(0)
    if only_ascending and other_sign < 0:
        other[:] = np.uint64(0)
    if _exceeds(other, chosen):
        chosen[:] = other
        return second, other_sign
    return first, sign


@njit(cache=True, nogil=True)
def triangle_directions(limbs: NDArray[np.uint64], free: NDArray[np.bool_], only_ascending: bool) -> Any:
    """Float64 rows × columns × 2: unit vectors (row, column) of the triangle rule; 0 where flat or obstacle.

    Each of the four triangles has one vertical neighbour (N or S) and one horizontal one (E or W), in every
    combination, so the greatest sum of squares is the greatest vertical plus the greatest horizontal square:
    two comparisons of absolute differences, no square needed. Ties go to north and to east. With
    ``only_ascending``, differences to lower neighbours count as 0.
    """
    rows, columns, count = limbs.shape
    # The rule of section 5.3: of the four triangles that the node h forms with two consecutive neighbours h', h''
    #
    #         N            maximise (h - h')² + (h - h'')², then go along (h' - h, h'' - h).
    #       / | \
    #     W - h - E        Each triangle has one of N, S and one of E, W, so the two terms are maximised apart.
    #       \ | /
    #         S
    directions = np.zeros((rows, columns, 2))
    vertical, horizontal = np.empty(count, np.uint64), np.empty(count, np.uint64)
    other = np.empty(count, np.uint64)
    for row in range(rows):
        for column in range(columns):
            if not free[row, column]:
                continue
            for axis in range(2):
                chosen = vertical if axis == 0 else horizontal
                side, sign = choose_side(limbs, row, column, axis, chosen, other, only_ascending)
                # Ascent goes towards a higher neighbour and away from a lower one.
                directions[row, column, axis] = sign * (ROW_STEP[side] + COLUMN_STEP[side])
            # Only the ratio of the two counts for a unit vector, so limbs that are 0 in both are left out.
            # Without that, values of hundreds of bits would leave the range of doubles.
            top = _top_limb(vertical, horizontal)
            down, along = _mantissa(vertical, top), _mantissa(horizontal, top)
            length = np.sqrt(down * down + along * along)
            if length > 0.0:
                directions[row, column, 0] *= down / length
                directions[row, column, 1] *= along / length
            else:
                directions[row, column, :] = 0.0
    return directions


@njit(cache=True, nogil=True)
def _may_enter(limbs: Any, free: Any, row: int, column: int, r: int, c: int, guarded: bool) -> Any:
    """True if a step between two cells touches no obstacle (and rises, where guarded)."""
    # A diagonal step passes the corner between the two cells beside it:
    #
    #   from  .        both cells beside the step have to be free, or the trajectory
    #    .    to       would cut the corner of an obstacle
    rows, columns = free.shape
    if not (0 <= r < rows and 0 <= c < columns) or abs(r - row) > 1 or abs(c - column) > 1:
        return False
    if not (free[r, c] and free[row, c] and free[r, column]):
        return False
    return not guarded or _greater(limbs, r, c, row, column)


@njit(cache=True, nogil=True)
def _append(points: Any, used: int, y: float, x: float) -> Any:
    if used == points.shape[0]:
        larger = np.empty((2 * used, 2))
        larger[:used] = points
        points = larger
    points[used, 0] = y
    points[used, 1] = x
    return points


@njit(cache=True, nogil=True)
def follow(
    limbs: NDArray[np.uint64],
    free: NDArray[np.bool_],
    goal: NDArray[np.bool_],
    directions: NDArray[np.float64],
    best: NDArray[np.int8],
    y: float,
    x: float,
    step: float,
    most_steps: int,
    guarded: bool,
) -> Any:
    """One trajectory: (points float64 n × 2, ending code, fallbacks). See ``trajectory.follow``."""
    points = np.empty((FIRST_POINTS, 2))
    points[0, 0], points[0, 1] = y, x
    used, fallbacks = 1, 0
    row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
    # Euler's steps along the direction of the cell that the point lies in; cells are centred on whole coordinates.
    for _ in range(most_steps):
        if goal[row, column]:
            break
        down, along = directions[row, column, 0], directions[row, column, 1]
        side = best[row, column]
        if (guarded and side < 0) or (down == 0.0 and along == 0.0):
            return points[:used], FLAT, fallbacks
        next_y, next_x = y + step * down, x + step * along
        r, c = int(np.floor(next_y + 0.5)), int(np.floor(next_x + 0.5))
        moved = r != row or c != column
        if moved and not _may_enter(limbs, free, row, column, r, c, guarded):
            if not guarded:
                return points[:used], OBSTACLE, fallbacks
            # The step would meet an obstacle, or not rise: go to the best neighbour's centre instead. Values rise
            # strictly along such cells, so a guarded trajectory cannot run in circles.
            fallbacks += 1
            r, c = row + ROW_STEP[side], column + COLUMN_STEP[side]
            next_y, next_x = float(r), float(c)
        y, x, row, column = next_y, next_x, r, c
        points = _append(points, used, y, x)
        used += 1
    if not goal[row, column]:
        return points[:used], STEPS, fallbacks
    if y != row or x != column:
        points = _append(points, used, float(row), float(column))
        used += 1
    return points[:used], GOAL, fallbacks


@njit(cache=True, nogil=True)
def arrivals(
    limbs: NDArray[np.uint64],
    free: NDArray[np.bool_],
    goal: NDArray[np.bool_],
    directions: NDArray[np.float64],
    best: NDArray[np.int8],
    starts: NDArray[np.float64],
    step: float,
    most_steps: int,
    guarded: bool,
) -> Any:
    """Int8 n: the ending code of the trajectory from each start (float64 n × 2)."""
    endings = np.empty(starts.shape[0], np.int8)
    for index in range(starts.shape[0]):
        y, x = starts[index, 0], starts[index, 1]
        _, endings[index], _ = follow(limbs, free, goal, directions, best, y, x, step, most_steps, guarded)
    return endings
