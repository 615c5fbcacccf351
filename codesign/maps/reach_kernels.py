"""Compiled searches over a padded grid (imported on first use, so that importing maps stays light).

Both take the grid flattened, with a ring of obstacles around it, so that no neighbour needs a bounds check.
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
