"""The least visits of all tiles of a map, compiled; ``bounds`` has the proof."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

NEVER = np.int32(2147483647)


@njit(cache=True, nogil=True)
def _pierced(opens: NDArray[np.int32], closes: NDArray[np.int32], used: int) -> Any:
    """The fewest times that meet each of the intervals: as many intervals, then the first, have no time in common."""
    for index in range(1, used):
        opening, closing, at = opens[index], closes[index], index
        while at > 0 and closes[at - 1] > closing:
            opens[at], closes[at] = opens[at - 1], closes[at - 1]
            at -= 1
        opens[at], closes[at] = opening, closing
    times, latest = 0, -1
    for index in range(used):
        if opens[index] > latest:
            latest = closes[index]
            opens[times], closes[times] = opens[index], latest
            times += 1
    return times


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
    """The least visits of the tile ``at`` a row and column of tiles: the first ``opens`` and ``closes`` are theirs.

    Each is pending for a change from its opening to its closing. ``tiles``: their begins, upper and lower edges.
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
    if used == 0:
        opens[0], closes[0] = since[at], NEVER
        return 1
    return _pierced(opens, closes, used)


@njit(cache=True, nogil=True)
def _least(table: NDArray[np.int32], what: int, row: int, begin: int, end: int) -> Any:
    """The least value from column ``begin`` to before ``end``: two spans of a power of two cover them."""
    level = 0
    while 2 << level <= end - begin:
        level += 1
    return min(table[level, what, row, begin], table[level, what, row, end - (1 << level)])


@njit(cache=True, nogil=True)
def _tiles_of(table: NDArray[np.int32], width: int) -> Any:
    """Of tiles of a width: their begins, upper and lower edges; and the span of the last visit of each."""
    columns, down = table.shape[3], table.shape[2]
    since = np.empty((down, -(-columns // width)), np.int32)
    upper, lower, spans = np.empty_like(since), np.empty_like(since), np.empty_like(since)
    for row in range(down):
        for column in range(since.shape[1]):
            begin, end = column * width, min(columns, (column + 1) * width)
            since[row, column] = _least(table, 0, row, begin, end)
            upper[row, column], lower[row, column] = (
                _least(table, 2, row, begin, end),
                _least(table, 3, row, begin, end),
            )
            spans[row, column] = max(0, -_least(table, 1, row, begin, end) - since[row, column])
    return (since, upper, lower), spans


@njit(cache=True, nogil=True)
def _span(opens: NDArray[np.int32], index: int, times: int, since: int, last: int) -> Any:
    """The least span of a visit: it ends after the change that it was pending for, the last one at its own end."""
    return max(0, opens[index] - since) if index < times - 1 else last


@njit(cache=True, nogil=True)
def sure_visits(
    potentials: NDArray[np.int32],
    table: NDArray[np.int32],
    least: NDArray[np.int32],
    until: int,
    shape: tuple[int, int],
) -> NDArray[np.int64]:
    """The least visits of tiles of a shape, one by one: int64 n × 4, the tile, two changes, the span.

    Each is pending for a change from the first to the second one. The other arguments are those of ``least_visits``.
    """
    tiles, spans = _tiles_of(table, shape[1])
    since = tiles[0]
    answer = np.empty((8 * since.size, 4), np.int64)
    opens, closes = np.empty(8, np.int32), np.empty(8, np.int32)
    used = 0
    for row in range(since.shape[0]):
        for column in range(since.shape[1]):
            if since[row, column] < until:
                at = row, column
                times = _visits_of(potentials, least, tiles, shape, at, until, opens, closes)
                for index in range(times):
                    answer[used, 0] = row * since.shape[1] + column
                    answer[used, 1], answer[used, 2] = opens[index], closes[index]
                    answer[used, 3] = _span(opens, index, times, since[at], spans[at])
                    used += 1
    return answer[:used]


@njit(cache=True, nogil=True)
def least_visits(
    potentials: NDArray[np.int32], table: NDArray[np.int32], least: NDArray[np.int32], until: int, height: int
) -> NDArray[np.int64]:
    """For tiles of ``height`` rows and each width from 1 on: int64 n × 2, visits and their spans.

    ``potentials``: int32, NEVER where none. ``table``: levels × 4 × rows of tiles × columns, level k of the least over
    2^k columns of: the least potential of the windows, the greatest before ``until`` with the sign changed (1: none),
    the potentials of the upper and of the lower edges. ``least``: by rows of tiles and columns, of the tiles.
    """
    columns = potentials.shape[1]
    answer = np.zeros((columns, 2), np.int64)
    opens, closes = np.empty(8, np.int32), np.empty(8, np.int32)
    for width in range(1, columns + 1):
        tiles, ends = _tiles_of(table, width)
        since, spans, visits = tiles[0], 0, 0
        for row in range(since.shape[0]):
            for column in range(since.shape[1]):
                if since[row, column] < until:
                    at = row, column
                    times = _visits_of(potentials, least, tiles, (height, width), at, until, opens, closes)
                    visits += times
                    for index in range(times):
                        spans += _span(opens, index, times, since[at], ends[at])
        answer[width - 1, 0], answer[width - 1, 1] = visits, spans
    return answer
