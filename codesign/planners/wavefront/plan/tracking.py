"""Paths down the potentials: by Dreyfus' rule (equation 2), and safe ones (equations 4 and 5)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, MapError
from codesign.ground.late import late
from codesign.planners.wavefront.plan.grid import WaveMap, check_cells, check_map

kernels = late("codesign.planners.wavefront.plan.kernels")

WHOLE_PATH = 2**31 - 1


def track(
    free: NDArray[np.bool_],
    potentials: NDArray[np.int32],
    start: Sequence[int],
    *,
    steps: int | None = None,
    obstacle_potentials: NDArray[np.int32] | None = None,
    corner_cutting: bool = True,
    extra_delay: NDArray[np.integer] | None = None,
    delays: Sequence[int] | None = None,
) -> NDArray[np.int64]:
    """The path from ``start`` to a source: int64 n × axes cells, both ends included.

    Each step goes to a neighbour j with p_i = p_j + w_ji (equation 2; the first in a fixed order among several), so
    the path is a shortest one. With ``obstacle_potentials`` it is a safe one: each step goes to a neighbour nearer to
    the source, among these to those farthest from obstacles (equation 4), and among those to the nearest to the source
    (equation 5). Potentials fall at every step, and every reached cell has a neighbour that the wave came from. So
    both rules arrive.

    Args:
        free, corner_cutting, extra_delay, delays: the arguments of ``propagate``.
        potentials: the result of ``propagate``.
        start: a cell that the wave reached.
        steps: the most steps (the paper's local course); None means the whole path.
        obstacle_potentials: p^d, the result of ``wave.obstacle_potentials``.

    Raises:
        MapError: a start outside of the map, on an obstacle, or that the wave did not reach.
        InputError: another argument.
    """
    wave_map = check_map(free, delays, corner_cutting, extra_delay)
    for name, values in (("potentials", potentials), ("obstacle_potentials", obstacle_potentials)):
        if values is not None and np.asarray(values).shape != wave_map.free.shape:
            raise InputError(f"{name} of shape {np.asarray(values).shape}", name, "give those of this map")
    if steps is not None and steps < 1:
        raise InputError(f"{steps} steps", "steps", "at least 1")
    return Tracker(wave_map, potentials, obstacle_potentials).follow(start, steps)


class Tracker:
    """Tracks many paths over the same potentials."""

    def __init__(
        self, wave_map: WaveMap, potentials: NDArray[np.int32], obstacle_potentials: NDArray[np.int32] | None = None
    ) -> None:
        self._map = wave_map
        unreached = np.where(wave_map.free, np.int32(kernels.OPEN), np.int32(kernels.CLOSED))
        shown = np.where(potentials >= 0, potentials, unreached).astype(np.int32)
        self._potentials = wave_map.pad(shown, kernels.CLOSED)
        self._distances = (
            np.zeros(0, np.int32)
            if obstacle_potentials is None
            else wave_map.pad(obstacle_potentials.astype(np.int32), 0)
        )

    def follow(self, start: Sequence[int], steps: int | None = None) -> NDArray[np.int64]:
        """The path from ``start``; see ``track``."""
        cell = check_cells([start], self._map.free, "start")
        index = int(self._map.indices(cell)[0])
        if self._potentials[index] < 0:
            what = f"the wave did not reach cell {tuple(int(part) for part in start)}"
            raise MapError(what, "start", "no path leads there, or the wave ended before")
        most = WHOLE_PATH if steps is None else steps
        path = kernels.follow(self._potentials, self._distances, index, most, *self._map.arrays)
        return self._map.cells(path)


def octile_length(path: NDArray[np.int64]) -> float:
    """Length of a path of cells: 1 for a straight step, √2 for a diagonal one, √3 for one along three axes."""
    moved = np.abs(np.diff(path, axis=0)).sum(axis=1)
    return float(np.sqrt(moved).sum())


# The skeleton of a map: the crest of the distance from obstacles, computed in 5 × 5 neighbourhoods.
#
# The paper does not say how its procedure detects the crest of p^d. Here a free cell is on the crest if, along one of
# the four axes through it (row, column, both diagonals), it is not below its two neighbours and above the two cells
# behind them. The rule holds for ridges with a top of one cell and of two cells (corridors of even width).

AXES = ((0, 1), (1, 0), (1, 1), (1, -1))
REACH = 2


def skeleton(obstacle_potentials: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Bool H×W: the cells on the crest of ``obstacle_potentials`` (int32 H×W, 0 on obstacles).

    The border cells are repeated outside of the map: p^d has no obstacle there, and so no crest against it.

    >>> distances = np.array([[0] * 6, [2] * 6, [4] * 6, [2] * 6, [0] * 6], dtype=np.int32)
    >>> np.flatnonzero(skeleton(distances).any(axis=1))
    array([2])
    """
    rows, columns = obstacle_potentials.shape
    padded = np.pad(obstacle_potentials, REACH, mode="edge")

    def seen(row: int, column: int) -> NDArray[np.int32]:
        return padded[REACH + row : REACH + row + rows, REACH + column : REACH + column + columns]

    crest = np.zeros((rows, columns), np.bool_)
    for row, column in AXES:
        beside = np.maximum(seen(row, column), seen(-row, -column))
        behind = np.maximum(seen(2 * row, 2 * column), seen(-2 * row, -2 * column))
        crest |= (obstacle_potentials >= beside) & (obstacle_potentials > behind)
    return crest & (obstacle_potentials > 0)
