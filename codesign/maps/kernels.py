"""Compiled searches over a padded grid, and for the shortest any-angle path (imported on first use).

The searches over the grid take it flattened, with a ring of obstacles around it, so that no neighbour needs a bounds
check.

The any-angle search doubles coordinates, so that they are whole numbers:

    (2i-1, 2j-1) +---------+ (2i-1, 2j+1)
                 |  (2i,   |
                 |     2j) |                cell (i, j)
    (2i+1, 2j-1) +---------+ (2i+1, 2j+1)

``blocked`` is padded by one cell of obstacle on each side, and coordinates count from its first cell.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

SQRT2 = np.sqrt(2.0)


@njit(cache=True, nogil=True)
def steps_from(free: NDArray[np.uint8], goals: NDArray[np.int64], stride: int) -> Any:
    """4-connected breadth-first distance from the goals; -1 where unreachable.

    Args:
        free: uint8, padded and flattened, 1 where free.
        goals: int64 indices into it.
        stride: length of a padded row.
    """
    distance = np.full(free.size, -1, dtype=np.int32)
    # Each cell enters the queue once, when its distance is set. A cell at distance d adds cells at d + 1, so the queue
    # is always in order of distance:
    #
    #   | done      | d  d  d | d+1  d+1 |
    #               head                 tail
    queue = np.empty(free.size, dtype=np.int64)
    head = tail = 0
    for goal in goals:
        if distance[goal] < 0:
            distance[goal] = 0
            queue[tail] = goal
            tail += 1
    offsets = (-stride, 1, stride, -1)
    while head < tail:
        cell = queue[head]
        head += 1
        for offset in offsets:
            neighbour = cell + offset
            if free[neighbour] and distance[neighbour] < 0:
                distance[neighbour] = distance[cell] + 1
                queue[tail] = neighbour
                tail += 1
    return distance


@njit(cache=True, nogil=True)
def _push(bucket: NDArray[np.int64], used: int, cell: int) -> Any:
    if used == bucket.size:
        larger = np.empty(2 * bucket.size, dtype=np.int64)
        larger[:used] = bucket
        bucket = larger
    bucket[used] = cell
    return bucket


@njit(cache=True, nogil=True)
def octile_from(free: NDArray[np.uint8], goals: NDArray[np.int64], stride: int) -> Any:
    """8-connected distance without corner cutting; inf where unreachable. Arguments as in ``steps_from``.

    Dijkstra with buckets one unit wide. No edge is shorter than a bucket, so all cells of the current bucket are final
    in any order. No edge is longer than two buckets, so three buckets suffice. Linear time.
    """
    distance = np.full(free.size, np.inf)
    current = np.empty(1024, dtype=np.int64)
    following = np.empty(1024, dtype=np.int64)
    farthest = np.empty(1024, dtype=np.int64)
    in_current = in_following = in_farthest = 0
    for goal in goals:
        if distance[goal] > 0.0:
            distance[goal] = 0.0
            current = _push(current, in_current, goal)
            in_current += 1
    # Buckets by distance, each one unit wide. A step of 1 or √2 moves a cell one or two buckets further:
    #
    #   | current       | following         | farthest          |
    #   floor           floor + 1           floor + 2           floor + 3
    floor = 0.0
    straight = (-stride, 1, stride, -1)
    while in_current + in_following + in_farthest > 0:
        for index in range(in_current):
            cell = current[index]
            if distance[cell] < floor:  # a shorter path was found since, and the cell was expanded with it
                continue
            for side in range(8):
                # Sides 0 to 3 are N, E, S, W. Sides 4 to 7 are the diagonals NE, SE, SW, NW: a first step along N, E,
                # S, W and a second step along the next of these (0 for a straight side).
                first = straight[side % 4]
                second = straight[(side + 1) % 4] if side >= 4 else 0
                neighbour = cell + first + second
                if not (free[neighbour] and free[cell + first] and free[cell + second]):
                    continue
                reached = distance[cell] + (SQRT2 if side >= 4 else 1.0)
                if reached < distance[neighbour]:
                    distance[neighbour] = reached
                    if reached < floor + 2.0:
                        following = _push(following, in_following, neighbour)
                        in_following += 1
                    else:
                        farthest = _push(farthest, in_farthest, neighbour)
                        in_farthest += 1
        current, following, farthest = following, farthest, current
        in_current, in_following, in_farthest = in_following, in_farthest, 0
        floor += 1.0
    return distance


@njit(cache=True, nogil=True)
def visible(blocked: NDArray[np.bool_], y0: int, x0: int, y1: int, x1: int) -> bool:
    """True if the segment between two points crosses neither the inside of a blocked cell nor a gap without width.

    Exact, in whole numbers. A gap without width is a border between two blocked cells, or a corner at which two blocked
    cells meet diagonally.
    """
    if y0 > y1:
        y0, x0, y1, x1 = y1, x1, y0, x0
    down, along = y1 - y0, x1 - x0
    if down == 0:
        return _open_line(blocked, y0, min(x0, x1), max(x0, x1), False)
    if along == 0:
        return _open_line(blocked, x0, y0, y1, True)
    row, y, before = (y0 + 1) // 2, y0, -1
    while y < y1:
        # The slab of one row of cells, from y to below. In it the segment runs over the columns low / down to
        # high / down, as x = x0 + along (y - y0) / down; all comparisons are of numerators.
        #
        #        2j-1     2j+1
        #   y  ---|-.------|---
        #         |   ' .  |        row of cells
        #  below--|------'-|---
        below = min(2 * row + 1, y1)
        first, last = x0 * down + along * (y - y0), x0 * down + along * (below - y0)
        low, high = min(first, last), max(first, last)
        # Cells j with an inside (2j - 1, 2j + 1) that overlaps (low, high) / down.
        left, right = (low - down) // (2 * down) + 1, -(-(high + down) // (2 * down)) - 1
        for column in range(left, right + 1):
            if blocked[row, column]:
                return False
        # Between two slabs the segment may pass a corner: not between two blocked cells that meet there.
        entered = left if along > 0 else right
        if before >= 0 and before != entered and blocked[row, before] and blocked[row - 1, entered]:
            return False
        before = right if along > 0 else left
        row, y = row + 1, below
    return True


@njit(cache=True, nogil=True)
def _open_line(blocked: NDArray[np.bool_], line: int, begin: int, end: int, down: bool) -> bool:
    """``visible`` along a row of coordinate ``line`` from ``begin`` to ``end``, or along a column (``down``).

    An odd ``line`` runs along the border of two rows of cells, before and after it; an even one inside a row.
    """
    before, after = line // 2, (line + 1) // 2
    open_before = open_after = True
    for cell in range((begin + 1) // 2, (end + 1) // 2 + 1):
        # Only cells with an inside that overlaps the open span.
        if min(end, 2 * cell + 1) <= max(begin, 2 * cell - 1):
            continue
        free_before = not (blocked[cell, before] if down else blocked[before, cell])
        free_after = not (blocked[cell, after] if down else blocked[after, cell])
        # A change from one side to the other would pass through the corner of two blocked cells.
        if not ((open_before and free_before) or (open_after and free_after)):
            return False
        open_before, open_after = free_before, free_after
    return True


@njit(cache=True, nogil=True)
def corners(blocked: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Points at which a shortest path may bend, int64 n × 2: the corners with exactly one of four cells blocked.

    free | free
    -----+--------      (2 row + 1, 2 column + 1)
    free | blocked
    """
    rows, columns = blocked.shape
    points = np.empty(((rows - 1) * (columns - 1), 2), np.int64)
    used = 0
    for row in range(rows - 1):
        for column in range(columns - 1):
            count = int(blocked[row, column]) + int(blocked[row + 1, column])
            count += int(blocked[row, column + 1]) + int(blocked[row + 1, column + 1])
            if count == 1:
                points[used] = 2 * row + 1, 2 * column + 1
                used += 1
    return points[:used].copy()


@njit(cache=True, nogil=True)
def _from_box(box: NDArray[np.int64], y: int, x: int) -> tuple[int, int]:
    """The point of a box (first row, first column, last row, last column) that is nearest to (y, x)."""
    return min(max(y, box[0]), box[2]), min(max(x, box[1]), box[3])


@njit(cache=True, nogil=True)
def _enters(blocked: NDArray[np.bool_], box: NDArray[np.int64], y: int, x: int) -> bool:
    """True if a path may enter the cell of a box at its point (y, x): not at a corner between two blocked cells."""
    if box[0] == box[2] or (y != box[0] and y != box[2]) or (x != box[1] and x != box[3]):
        return True
    row, column = (box[0] + box[2]) // 4, (box[1] + box[3]) // 4
    beyond_row, beyond_column = row + (1 if y > 2 * row else -1), column + (1 if x > 2 * column else -1)
    return not (blocked[beyond_row, column] and blocked[row, beyond_column])


@njit(cache=True, nogil=True)
def _to_boxes(blocked: NDArray[np.bool_], boxes: NDArray[np.int64], y: int, x: int, seen: bool) -> tuple[float, int]:
    """Least distance from a point to boxes, and the tests of visibility. ``seen``: only to boxes that it sees."""
    least, tests_made = np.inf, 0
    for index in range(len(boxes)):
        to_y, to_x = _from_box(boxes[index], y, x)
        length = np.hypot(float(to_y - y), float(to_x - x))
        if length < least:
            if seen:
                tests_made += 1
                if not (_enters(blocked, boxes[index], to_y, to_x) and visible(blocked, y, x, to_y, to_x)):
                    continue
            least = length
    return least, tests_made


@njit(cache=True, nogil=True)
def _straight(blocked: NDArray[np.bool_], source: NDArray[np.int64], target: NDArray[np.int64]) -> float:
    """Length of the shortest straight path between two boxes, from 3 × 3 points of the source; inf without one."""
    least = np.inf
    for y in (source[0], (source[0] + source[2]) // 2, source[2]):
        for x in (source[1], (source[1] + source[3]) // 2, source[3]):
            to_y, to_x = _from_box(target, y, x)
            from_y, from_x = _from_box(source, to_y, to_x)
            length = np.hypot(float(to_y - from_y), float(to_x - from_x))
            if length >= least or not visible(blocked, from_y, from_x, to_y, to_x):
                continue
            if _enters(blocked, source, from_y, from_x) and _enters(blocked, target, to_y, to_x):
                least = length
    return least


@njit(cache=True, nogil=True)
def search(
    blocked: NDArray[np.bool_],
    nodes: NDArray[np.int64],
    sources: NDArray[np.int64],
    targets: NDArray[np.int64],
    most: int,
) -> float:
    """Length, in doubled coordinates, of the shortest path from any of the sources to any of the targets.

    A* over ``nodes``. A node has f = g + h: g (``driven``) is the shortest known path from the sources, h (``left``)
    the straight distance to the targets. After ``most`` tests of visibility the result is the least f: the shortest
    path is no shorter.

    Args:
        blocked: bool, padded map.
        nodes: int64 n × 2, from ``corners``.
        sources, targets: int64 m × 4, boxes.
        most: tests of visibility.
    """
    best = np.inf
    for source in range(len(sources)):
        for target in range(len(targets)):
            best = min(best, _straight(blocked, sources[source], targets[target]))
    count, tests_made = len(nodes), len(sources) * len(targets)
    driven, left = np.empty(count), np.empty(count)
    closed = np.zeros(count, np.bool_)
    for index in range(count):
        y, x = nodes[index]
        left[index] = _to_boxes(blocked, targets, y, x, False)[0]
        driven[index], tests = _to_boxes(blocked, sources, y, x, True)
        tests_made += tests
    while True:
        # Expand the open node with the least f. No f below ``best``: the path of ``best`` is the shortest.
        here, least = -1, best
        for index in range(count):
            if not closed[index] and driven[index] + left[index] < least:
                here, least = index, driven[index] + left[index]
        if here < 0 or tests_made > most:
            return least
        closed[here] = True
        y, x = nodes[here]
        end, tests = _to_boxes(blocked, targets, y, x, True)
        best, tests_made = min(best, driven[here] + end), tests_made + tests
        for index in range(count):
            if closed[index]:
                continue
            to_y, to_x = nodes[index]
            length = driven[here] + np.hypot(float(to_y - y), float(to_x - x))
            if length < driven[index] and length + left[index] < best:
                tests_made += 1
                if visible(blocked, y, x, to_y, to_x):
                    driven[index] = length
