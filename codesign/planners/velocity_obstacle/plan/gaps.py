"""The least distance between two robots, at updates and between them, and when they first touch."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

_HALVINGS = 64
"""More than halve an interval of doubles within [0, 1] down to neighbours."""


def pair_gaps(
    cells: NDArray[np.float64], speeds: NDArray[np.float64], seconds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Least distance between the centres of each pair over a run, cells, float64, one value a pair.

    ``cells``: float64 (m + 1) × n × 2, the ends of m legs. ``speeds``: float64 (m + 1) × n × 2, the velocities there,
    cells/s. ``seconds``: float64 m, the time of each leg.

    On a leg a robot moves with constant acceleration (equation 2b): r(s) = r0 + v0 T s + (r1 - r0 - v0 T) s² for s
    from 0 to 1, through both its ends. So the squared distance of a pair is a quartic in s. Its least value lies at an
    end of the leg or at a root of its derivative, a cubic.
    """
    count = cells.shape[1]
    least = np.empty(count * (count - 1) // 2)
    _pair_gaps(cells, speeds, seconds, least)
    return least


def first_touches(
    before: NDArray[np.float64], after: NDArray[np.float64], drift: NDArray[np.float64], limit: float
) -> NDArray[np.float64]:
    """The moment on one leg when the centres of each pair first come nearer than ``limit`` (cells), as a share of it.

    ``before``, ``after``: float64 n × 2, the ends of the leg, cells. ``drift``: float64 n × 2, v0 T of ``pair_gaps``:
    where the velocities at its begin alone would lead, cells. Float64, one value a pair; infinity where they stay away.
    """
    count = len(before)
    first = np.empty(count * (count - 1) // 2)
    _first_touches(before, after, drift, limit, first)
    return first


@njit(cache=True, nogil=True)
def _pair_gaps(cells: Any, speeds: Any, seconds: Any, least: Any) -> None:
    legs, count = len(seconds), cells.shape[1]
    pair = 0
    for robot in range(count - 1):
        for other in range(robot + 1, count):
            x, y = cells[0, other, 0] - cells[0, robot, 0], cells[0, other, 1] - cells[0, robot, 1]
            best = math.sqrt(x * x + y * y)
            for leg in range(legs):
                # The relative motion of the pair: a + b s + c s².
                ax, ay = (cells[leg, other, 0] - cells[leg, robot, 0], cells[leg, other, 1] - cells[leg, robot, 1])
                bx = (speeds[leg, other, 0] - speeds[leg, robot, 0]) * seconds[leg]
                by = (speeds[leg, other, 1] - speeds[leg, robot, 1]) * seconds[leg]
                ex, ey = (
                    cells[leg + 1, other, 0] - cells[leg + 1, robot, 0],
                    cells[leg + 1, other, 1] - cells[leg + 1, robot, 1],
                )
                cx, cy = ex - ax - bx, ey - ay - by
                # |a + b s + c s²| ≥ |a| - |b| - |c|: most legs cannot come nearer than the best so far.
                away = math.sqrt(ax * ax + ay * ay)
                away -= math.sqrt(bx * bx + by * by) + math.sqrt(cx * cx + cy * cy)
                if away < best:
                    best = min(best, _nearest(ax, ay, bx, by, cx, cy), math.sqrt(ex * ex + ey * ey))
            least[pair] = best
            pair += 1


@njit(cache=True, nogil=True)
def _nearest(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any) -> Any:
    """The least |a + b s + c s²| for s from 0 to 1."""
    best = math.inf
    for s in _candidates(ax, ay, bx, by, cx, cy):
        best = min(best, _distance(ax, ay, bx, by, cx, cy, s))
    return best


@njit(cache=True, nogil=True)
def _candidates(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any) -> Any:
    """Values of s in rising order, from 0 to 1: every minimum of |a + b s + c s²| is among them.

    Between two neighbours the distance falls at most once below any limit that the first is not below: it rises and
    then falls, or does one of the two.
    """
    ab, bc = ax * bx + ay * by, bx * cx + by * cy
    bb, ac, cc = bx * bx + by * by, ax * cx + ay * cy, cx * cx + cy * cy
    # Half the derivative of the square is g(s) = ab + (bb + 2 ac) s + 3 bc s² + 2 cc s³. Between the roots of g', which
    # are those of 6 cc s² + 6 bc s + (bb + 2 ac), it is monotone: at most one root in each of three intervals.
    slope = bb + 2.0 * ac
    turns = np.array([0.0, 1.0, 1.0, 1.0])
    inner = 9.0 * bc * bc - 6.0 * cc * slope
    if inner >= 0.0:
        # The stable form of the roots: no difference of nearly equal numbers.
        large = -(3.0 * bc + math.copysign(math.sqrt(inner), bc))
        first = large / (6.0 * cc) if cc > 0.0 else 2.0
        second = slope / large if large != 0.0 else 2.0
        turns[1], turns[2] = max(0.0, min(first, second, 1.0)), max(0.0, min(1.0, max(first, second)))
    #   |a + b s + c s²|²
    #     \      __                 four turns: 0, the two roots of g' (clipped into [0, 1]), 1
    #      \    /  \      /         between two of them g rises or falls throughout, so at most one
    #       \__/    \____/          minimum lies there, where g goes from below 0 to above
    #    0    |      |      1
    found = np.empty(10)
    count = 0
    for number in range(4):
        low = turns[number]
        found[count] = low
        count += 1
        if number == 3:
            break
        # A minimum lies where g rises through 0: bracketed by its signs, and halved until nothing is between.
        high = turns[number + 1]
        # g in Horner's form, at both ends and at the middles.
        if ab + low * (slope + low * (3.0 * bc + 2.0 * cc * low)) < 0.0 and (
            ab + high * (slope + high * (3.0 * bc + 2.0 * cc * high)) > 0.0
        ):
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if ab + middle * (slope + middle * (3.0 * bc + 2.0 * cc * middle)) < 0.0:
                    low = middle
                else:
                    high = middle
            found[count], found[count + 1] = low, high
            count += 2
    return found[:count]


@njit(cache=True, nogil=True)
def _first_touches(before: Any, after: Any, drift: Any, limit: Any, first: Any) -> None:
    count = len(before)
    pair = 0
    for robot in range(count - 1):
        for other in range(robot + 1, count):
            # The relative motion of the pair on the leg: a + b s + c s².
            ax, ay = before[other, 0] - before[robot, 0], before[other, 1] - before[robot, 1]
            bx, by = drift[other, 0] - drift[robot, 0], drift[other, 1] - drift[robot, 1]
            ex, ey = after[other, 0] - after[robot, 0], after[other, 1] - after[robot, 1]
            cx, cy = ex - ax - bx, ey - ay - by
            first[pair] = _first_touch(ax, ay, bx, by, cx, cy, limit)
            if math.sqrt(ex * ex + ey * ey) < limit:
                first[pair] = min(first[pair], 1.0)
            pair += 1


@njit(cache=True, nogil=True)
def _first_touch(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any, limit: Any) -> Any:
    """The least s from 0 to 1 with |a + b s + c s²| < limit; infinity where there is none."""
    # |a + b s + c s²| ≥ |a| - |b| - |c|: most pairs cannot come that near.
    away = math.sqrt(ax * ax + ay * ay) - math.sqrt(bx * bx + by * by) - math.sqrt(cx * cx + cy * cy)
    if away >= limit:
        return math.inf
    low = 0.0
    for candidate in _candidates(ax, ay, bx, by, cx, cy):
        if _distance(ax, ay, bx, by, cx, cy, candidate) < limit:
            # The distance passes the limit once between the last candidate, which is not below it, and this one.
            high = candidate
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if _distance(ax, ay, bx, by, cx, cy, middle) < limit:
                    high = middle
                else:
                    low = middle
            return high
        low = candidate
    return math.inf


@njit(cache=True, nogil=True)
def _distance(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any, s: Any) -> Any:
    x, y = ax + s * (bx + s * cx), ay + s * (by + s * cy)
    return math.sqrt(x * x + y * y)
