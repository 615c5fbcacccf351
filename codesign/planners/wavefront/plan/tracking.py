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
            raise MapError(
                f"the wave did not reach cell {tuple(int(part) for part in start)}",
                "start",
                "no path leads there, or the wave ended before",
            )
        most = WHOLE_PATH if steps is None else steps
        path = kernels.follow(self._potentials, self._distances, index, most, *self._map.arrays)
        return self._map.cells(path)


def octile_length(path: NDArray[np.int64]) -> float:
    """Length of a path of cells: 1 for a straight step, √2 for a diagonal one, √3 for one along three axes."""
    moved = np.abs(np.diff(path, axis=0)).sum(axis=1)
    return float(np.sqrt(moved).sum())
