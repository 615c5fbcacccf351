"""Compiled time-optimal speed profile along a polyline (imported on first use)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def bend_limits(
    arcs: NDArray[np.float64], changes: NDArray[np.float64], acceleration: float, period: float, fastest: float
) -> NDArray[np.float64]:
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
def speeds_at(lengths: NDArray[np.float64], limits: NDArray[np.float64], acceleration: float, begin: float) -> Any:
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
    lengths: NDArray[np.float64],
    arcs: NDArray[np.float64],
    speeds: NDArray[np.float64],
    turns: NDArray[np.float64],
    speed: float,
    acceleration: float,
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
