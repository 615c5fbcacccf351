"""The least visits of all tiles of a map, compiled; ``bounds`` has the proof."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

NEVER = np.int32(2147483647)


@njit(cache=True, nogil=True)
def _pierced(opens: NDArray[np.int32], closes: NDArray[np.int32], used: int) -> Any:
    """The fewest times that meet each of the intervals, and the sum of the openings that they follow but the last one.

    These intervals have no time in common.
    """
    for index in range(1, used):
        opening, closing, at = opens[index], closes[index], index
        while at > 0 and closes[at - 1] > closing:
            opens[at], closes[at] = opens[at - 1], closes[at - 1]
            at -= 1
        opens[at], closes[at] = opening, closing
    times, latest, opened, total = 0, -1, 0, 0
    for index in range(used):
        if opens[index] > latest:
            total += opened
            times, latest, opened = times + 1, closes[index], opens[index]
    return times, total


@njit(cache=True, nogil=True)
def _visits_of(
    potentials: NDArray[np.int32],
    least: NDArray[np.int32],
    tiles: tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]],
    size: tuple[int, int],
    at: tuple[int, int],
    until: int,
    opens: NDArray[np.int32],
    closes: NDArray[np.int32],
) -> Any:
    """The least visits of the tile ``at`` a row and column of tiles, and the spans of all but the last one.

    ``tiles``: their begins, upper and lower edges.
    """
    since, upper, lower = tiles
    used = 0
    for row in range(max(0, at[0] - 1), min(since.shape[0], at[0] + 2)):
        edge = at[0] * size[0] - 1 if row < at[0] else (at[0] + 1) * size[0]
        for column in range(max(0, at[1] - 1), min(since.shape[1], at[1] + 2)):
            beside = at[1] * size[1] - 1 if column < at[1] else (at[1] + 1) * size[1]
            if row == at[0]:
                closing = least[row, beside] if column != at[1] else NEVER
            elif column == at[1]:
                closing = lower[row, column] if row < at[0] else upper[row, column]
            else:
                closing = potentials[edge, beside]
            if closing < until:
                opens[used], closes[used] = since[row, column], closing
                used += 1
    times, opened = _pierced(opens, closes, used)
    # A visit ends after the change that it was pending for; the last one counts with its own end.
    return max(1, times), max(0, opened - (times - 1) * since[at])


@njit(cache=True, nogil=True)
def _least(table: NDArray[np.int32], what: int, row: int, begin: int, end: int) -> Any:
    """The least value from column ``begin`` to before ``end``: two spans of a power of two cover them."""
    level = 0
    while 2 << level <= end - begin:
        level += 1
    return min(table[level, what, row, begin], table[level, what, row, end - (1 << level)])


@njit(cache=True, nogil=True)
def least_visits(
    potentials: NDArray[np.int32], table: NDArray[np.int32], least: NDArray[np.int32], until: int, height: int
) -> NDArray[np.int64]:
    """For tiles of ``height`` rows and each width from 1 on: int64 n × 2, visits and their spans.

    ``potentials``: int32, NEVER where none. ``table``: levels × 4 × rows of tiles × columns, level k of the least over
    2^k columns of: the least potential of the windows, the greatest before ``until`` with the sign changed (1: none),
    the potentials of the upper and of the lower edges. ``least``: by rows of tiles and columns, of the tiles.
    """
    columns, down = potentials.shape[1], table.shape[2]
    answer = np.zeros((columns, 2), np.int64)
    opens, closes = np.empty(8, np.int32), np.empty(8, np.int32)
    for width in range(1, columns + 1):
        since = np.empty((down, -(-columns // width)), np.int32)
        upper, lower = np.empty_like(since), np.empty_like(since)
        spans = visits = 0
        for row in range(down):
            for column in range(since.shape[1]):
                begin, end = column * width, min(columns, (column + 1) * width)
                since[row, column] = _least(table, 0, row, begin, end)
                upper[row, column], lower[row, column] = (
                    _least(table, 2, row, begin, end),
                    _least(table, 3, row, begin, end),
                )
                spans += max(0, -_least(table, 1, row, begin, end) - since[row, column])
        tiles = since, upper, lower
        for row in range(down):
            for column in range(since.shape[1]):
                if since[row, column] < until:
                    at = row, column
                    more = _visits_of(potentials, least, tiles, (height, width), at, until, opens, closes)
                    visits, spans = visits + more[0], spans + more[1]
        answer[width - 1, 0], answer[width - 1, 1] = visits, spans
    return answer
