"""Compiled crossings of a polyline, speed profiles along it, and rays over a grid (imported on first use)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]
Cells = NDArray[np.int64]

CORNER = 1e-9
"""Cells: a line that passes a corner of four cells within this distance counts as passing through the corner."""


@njit(cache=True, nogil=True)
def crossings(points: Doubles, arcs: Doubles) -> Any:
    """Every cell that a polyline enters, in order, the first cell included.

    After Amanatides and Woo (1987). Here the number of borders to cross follows from the two end cells, so rounding can
    neither skip the end cell nor pass it.

    Args:
        points: float64 n × 2, (row, column) in cells.
        arcs: float64 n, arc length at each of them, cells.

    Returns:
        entry: float64 m, arc length at which each cell is entered.
        cells: int64 m × 6: the cell, then the two cells beside the corner where it is entered through one (otherwise
        the cell itself, twice).
    """
    entry = np.empty(64)
    cells = np.empty((64, 6), np.int64)
    row, column = int(np.floor(points[0, 0] + 0.5)), int(np.floor(points[0, 1] + 0.5))
    entry[0] = arcs[0]
    cells[0] = np.array([row, column, row, column, row, column])
    used = 1
    for index in range(points.shape[0] - 1):
        y, x = points[index]
        down, along = points[index + 1, 0] - y, points[index + 1, 1] - x
        length = arcs[index + 1] - arcs[index]
        last_row = int(np.floor(points[index + 1, 0] + 0.5))
        last_column = int(np.floor(points[index + 1, 1] + 0.5))
        row_step, column_step = np.sign(last_row - row), np.sign(last_column - column)
        while row != last_row or column != last_column:
            # The segment is (y, x) + s (down, along). The next border between rows lies at s = to_row, that between
            # columns at s = to_column; above 1: no border of that kind is left.
            to_row = min(max((row + 0.5 * row_step - y) / down, 0.0), 1.0) if row != last_row else 2.0
            to_column = min(max((column + 0.5 * column_step - x) / along, 0.0), 1.0) if column != last_column else 2.0
            # Through a corner the segment touches both cells beside it, so they are reported with the cell that it
            # enters:
            #
            #   from      | in_row
            #   ----------+-------
            #   in_column | to
            corner = abs(to_row - to_column) * length <= CORNER
            in_column, in_row = (row + row_step, column), (row, column + column_step)
            if corner or to_row < to_column:
                row += row_step
            if corner or to_column < to_row:
                column += column_step
            if used == entry.size:
                larger_entry, larger_cells = np.empty(2 * used), np.empty((2 * used, 6), np.int64)
                larger_entry[:used], larger_cells[:used] = entry, cells
                entry, cells = larger_entry, larger_cells
            entry[used] = arcs[index] + min(to_row, to_column) * length
            cells[used, 0], cells[used, 1] = row, column
            if corner:
                cells[used, 2], cells[used, 3] = in_column
                cells[used, 4], cells[used, 5] = in_row
            else:
                cells[used, 2], cells[used, 3] = row, column
                cells[used, 4], cells[used, 5] = row, column
            used += 1
    return entry[:used].copy(), cells[:used].copy()


@njit(cache=True, nogil=True)
def first_closed(cells: Cells, grid: Mask, is_open: bool, first: int, last: int) -> int:
    """Index of the first crossing, from ``first`` to before ``last``, into a closed cell or past a corner beside one.

    -1 where all are open. Cells outside of the grid are closed.

    Args:
        cells: as ``crossings`` returns them.
        grid: bool, rows × columns.
        is_open: the value that an open cell has in it.
        first, last: the range of crossings.
    """
    rows, columns = grid.shape
    for index in range(first, last):
        # The cell, then the two beside its corner; without a corner all three are the same cell.
        for part in range(0, 6, 2):
            row, column = cells[index, part], cells[index, part + 1]
            if row < 0 or row >= rows or column < 0 or column >= columns or grid[row, column] != is_open:
                return index
    return -1


@njit(cache=True, nogil=True)
def ranges(free: Mask, y: float, x: float, reach: float, directions: Doubles) -> Doubles:
    """The length of each ray from (y, x), cells, to the side of the first blocked cell; infinite within ``reach``.

    The rays are the rays of ``components.kernels.cast``, with the same arguments.
    """
    rows, columns = free.shape
    lengths = np.full(directions.shape[0], np.inf)
    for ray in range(directions.shape[0]):
        down, along = directions[ray, 0], directions[ray, 1]
        row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
        row_step, column_step = (1 if down > 0.0 else -1), (1 if along > 0.0 else -1)
        length = 0.0
        while 0 <= row < rows and 0 <= column < columns:
            if not free[row, column]:
                lengths[ray] = length
                break
            to_row = (row + 0.5 * row_step - y) / down if down != 0.0 else np.inf
            to_column = (column + 0.5 * column_step - x) / along if along != 0.0 else np.inf
            length = min(to_row, to_column)
            if length > reach:
                break
            if abs(to_row - to_column) <= CORNER:
                # No ray passes between two blocked cells that touch at a corner.
                beside = 0 <= row + row_step < rows and free[row + row_step, column]
                below = 0 <= column + column_step < columns and free[row, column + column_step]
                if not beside and not below:
                    lengths[ray] = length
                    break
                row += row_step
                column += column_step
            elif to_row < to_column:
                row += row_step
            else:
                column += column_step
    return lengths


@njit(cache=True, nogil=True)
def bend_limits(arcs: Doubles, changes: Doubles, acceleration: float, period: float, fastest: float) -> Doubles:
    """Greatest speed at each vertex that limits the change of velocity within one control period.

    At speed v the vertices j to k are passed within a period where arcs[k] - arcs[j] ≤ v·period. The sum of their
    changes, v·sum(changes[j..k]), is then at most acceleration·period. So for any j ≤ i ≤ k the speed at i is at most

        max((arcs[k] - arcs[j]) / period, acceleration·period / sum(changes[j..k])).

    On a bend of radius R that takes longer than a period this gives v² / R ≤ acceleration, for any number of segments.
    A window that begins at the first vertex limits that vertex alone: the robot is there already, at its own speed.

    Args:
        arcs: float64 n, arc length of each vertex.
        changes: float64 n, change of velocity there over the speed: 2·sin(θ/2) at a corner of angle θ.
        acceleration: a second².
        period: control period, s.
        fastest: the greatest limit.

    Returns:
        float64 n, ``fastest`` where there is no limit.
    """
    # For each j the window j..k first grows as far as ``fastest`` reaches within a period, then k moves back:
    #
    #   j----+---+------k       v ≤ max((arcs[k] - arcs[j]) / period, acceleration·period / sum(changes[j..k]))
    #   j----+---k              The least of these bounds holds for every vertex of the windows inside.
    count = arcs.size
    limits = np.full(count, fastest)
    for first in range(count):
        last, change = first, changes[first]
        if first > 0:
            while last + 1 < count and arcs[last + 1] - arcs[first] < fastest * period:
                last += 1
                change += changes[last]
        least = fastest
        # From the longest window to the shortest: each limits the vertices in it.
        for index in range(last, first - 1, -1):
            if change * fastest > acceleration * period:
                most = max((arcs[index] - arcs[first]) / period, acceleration * period / change)
                least = min(least, most)
            limits[index] = min(limits[index], least)
            change -= changes[index]
    return limits


@njit(cache=True, nogil=True)
def speeds_at(lengths: Doubles, limits: Doubles, acceleration: float, begin: float) -> Any:
    """Greatest speed at each vertex within the limits and the acceleration: backward and forward pass.

    Args:
        lengths: float64 n, of the segments.
        limits: float64 n + 1, greatest speed at each vertex; at the last it is 0.
        acceleration: greatest change of speed a second, up or down.
        begin: speed at the first vertex.

    Returns:
        float64 n + 1 speeds, and the greatest speed at the first vertex that allows all limits to be kept. Where
        ``begin`` is above it, the profile begins at it instead of ``begin``.
    """
    # v² = v0² + 2·a·s along a segment of length s. Backward: the fastest speed from which the robot can still brake to
    # the limit at the end of the segment.
    speeds = limits.copy()
    for index in range(lengths.size - 1, -1, -1):
        reach = np.sqrt(speeds[index + 1] ** 2 + 2.0 * acceleration * lengths[index])
        speeds[index] = min(speeds[index], reach)
    # Forward: the fastest speed that acceleration from the begin of the segment gives. Both passes together are the
    # time-optimal profile.
    most = speeds[0]
    speeds[0] = min(begin, most)
    for index in range(lengths.size):
        reach = np.sqrt(speeds[index] ** 2 + 2.0 * acceleration * lengths[index])
        speeds[index + 1] = min(speeds[index + 1], reach)
    return speeds, most


@njit(cache=True, nogil=True)
def phases_of(
    lengths: Doubles, arcs: Doubles, speeds: Doubles, turns: Doubles, speed: float, acceleration: float
) -> Any:
    """Phases of constant acceleration along the segments: float64 m × 4.

    Columns: begin (s), arc length and speed at that time, acceleration. In the last phase the robot stands at the end.
    ``turns``: float64 n + 1, seconds of turning on the spot at each vertex.
    """
    phases = np.empty((4 * lengths.size + 2, 4))
    used, time = 0, 0.0
    for index in range(lengths.size):
        if turns[index] > 0.0:
            phases[used] = np.array([time, arcs[index], 0.0, 0.0])
            used, time = used + 1, time + turns[index]
        # A trapezoid, or a triangle where the top speed is not reached. Acceleration from v0 to the peak takes the
        # length (peak² - v0²) / 2a, braking to v1 takes (peak² - v1²) / 2a. In a triangle the two fill the segment, so
        # peak² = (v0² + v1²) / 2 + a·length.
        #
        #          peak ______
        #              /      \        rising | level | falling
        #   here v0  _/        \_  there v1
        here, there, length = speeds[index], speeds[index + 1], lengths[index]
        peak = min(speed, np.sqrt((here**2 + there**2) / 2.0 + acceleration * length))
        # The root may round to just below the speed at an end. A length would then be negative.
        peak = max(peak, here, there)
        rising = (peak**2 - here**2) / (2.0 * acceleration)
        falling = (peak**2 - there**2) / (2.0 * acceleration)
        level = max(length - rising - falling, 0.0)
        if peak > here:
            phases[used] = np.array([time, arcs[index], here, acceleration])
            used, time = used + 1, time + (peak - here) / acceleration
        if level > 0.0 and peak > 0.0:
            phases[used] = np.array([time, arcs[index] + rising, peak, 0.0])
            used, time = used + 1, time + level / peak
        if peak > there:
            phases[used] = np.array([time, arcs[index + 1] - falling, peak, -acceleration])
            used, time = used + 1, time + (peak - there) / acceleration
    phases[used] = np.array([time, arcs[-1], 0.0, 0.0])
    return phases[: used + 1].copy()


UNSEEN, FREE, BLOCKED = 0, 1, 2


@njit(cache=True, nogil=True)
def cast(free: Mask, y: float, x: float, reach: float, directions: Doubles) -> Any:
    """The cells that rays from (y, x) see: int64 n × 2 free ones and int64 m × 2 blocked ones, in raster order.

    Args:
        free: bool, rows × columns.
        y, x: row and column, in cells, inside the grid.
        reach: length of a ray, cells.
        directions: float64 k × 2, unit vectors (row, column).
    """
    # Only the square that rays can reach is stored, so that the cost does not grow with the map:
    #
    #   top, left +---------------+
    #             |   margin      |
    #             |     (y, x)    |   margin = ceil(reach) + 1
    #             +---------------+ bottom, right (excluded)
    rows, columns = free.shape
    row_of_robot, column_of_robot = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
    margin = int(np.ceil(reach)) + 1
    top, bottom = max(row_of_robot - margin, 0), min(row_of_robot + margin + 1, rows)
    left, right = max(column_of_robot - margin, 0), min(column_of_robot + margin + 1, columns)
    seen = np.zeros((bottom - top, right - left), np.int8)
    for ray in range(directions.shape[0]):
        _cast_ray(free, seen, top, left, y, x, reach, directions[ray, 0], directions[ray, 1])
    # Two passes over the square: the first counts the cells, the second lists them in raster order.
    count_free = count_blocked = 0
    for value in seen.flat:
        count_free += value == FREE
        count_blocked += value == BLOCKED
    free_cells, blocked_cells = np.empty((count_free, 2), np.int64), np.empty((count_blocked, 2), np.int64)
    count_free = count_blocked = 0
    for row in range(seen.shape[0]):
        for column in range(seen.shape[1]):
            if seen[row, column] == FREE:
                free_cells[count_free, 0], free_cells[count_free, 1] = row + top, column + left
                count_free += 1
            elif seen[row, column] == BLOCKED:
                blocked_cells[count_blocked, 0], blocked_cells[count_blocked, 1] = row + top, column + left
                count_blocked += 1
    return free_cells, blocked_cells


@njit(cache=True, nogil=True)
def _cast_ray(
    free: Mask, seen: NDArray[np.int8], top: int, left: int, y: float, x: float, reach: float, down: float, along: float
) -> None:
    rows, columns = free.shape
    row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
    row_step, column_step = (1 if down > 0.0 else -1), (1 if along > 0.0 else -1)
    while True:
        if row < 0 or row >= rows or column < 0 or column >= columns:
            return
        if not free[row, column]:
            seen[row - top, column - left] = BLOCKED
            return
        seen[row - top, column - left] = FREE
        # The ray is (y, x) + s (down, along). Cells are centred on whole coordinates, so borders lie at halves. The s
        # of the next border in each axis decides which cell is next (Amanatides and Woo 1987):
        #
        #       column + 0.5
        #   +--------|--------+
        #   |   .    |        |        to_row: s where y + s down = row ± 0.5
        #   +---'----|--------+  row + 0.5
        #   |      ' |        |        to_column: s where x + s along = column ± 0.5
        to_row = (row + 0.5 * row_step - y) / down if down != 0.0 else np.inf
        to_column = (column + 0.5 * column_step - x) / along if along != 0.0 else np.inf
        if min(to_row, to_column) > reach:
            return
        #    free    | blocked
        #   ---------+---------        The ray sees both blocked cells, and ends between them.
        #    blocked | behind
        if abs(to_row - to_column) <= CORNER:
            # Through a corner: no ray passes between two blocked cells that touch there.
            if _blocked(free, row + row_step, column) and _blocked(free, row, column + column_step):
                _mark(seen, rows, columns, top, left, row + row_step, column)
                _mark(seen, rows, columns, top, left, row, column + column_step)
                return
            row += row_step
            column += column_step
        elif to_row < to_column:
            row += row_step
        else:
            column += column_step


@njit(cache=True, nogil=True)
def _blocked(free: Mask, row: int, column: int) -> bool:
    inside = 0 <= row < free.shape[0] and 0 <= column < free.shape[1]
    return not inside or not free[row, column]


@njit(cache=True, nogil=True)
def _mark(seen: NDArray[np.int8], rows: int, columns: int, top: int, left: int, row: int, column: int) -> None:
    if 0 <= row < rows and 0 <= column < columns:
        seen[row - top, column - left] = BLOCKED
